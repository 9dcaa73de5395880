//! Notes beside stored files: one per claim, what was asked of it. A ledger that was put back from before the claim learns
//! from it what the bytes alone do not say: name, copies, ticket.

use std::{
    collections::BTreeMap,
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::{Store, StoreError, disk};

/// Ends the name of a note, which is `<hash>.<claim>.json`, or `<hash>.<claim>.<decisions>.json` once something was decided.
const NOTE: &str = ".json";
/// Hex digits of a hash.
const HASH_LEN: usize = 64;

/// What lies in the store under one hash.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Kept {
    /// Whether the bytes are there.
    pub is_stored: bool,
    /// The claims of which there is a note, and how often each says that was decided.
    pub claims: BTreeMap<String, u32>,
}

impl Store {
    /// Notes beside a stored file what was asked of a claim. It is not forced to disk on its own: the row of the ledger is,
    /// and the note is needed only when that was lost later.
    ///
    /// # Errors
    /// The disk does not let it.
    pub fn note(&self, hash: &str, claim: &str, text: &str) -> Result<(), StoreError> {
        let path = self.note_path(hash, claim)?;
        let failed = |source| StoreError::Io { what: "note a claim in", path: path.clone(), source };
        let mut file = fs::File::create(&path).map_err(failed)?;
        file.write_all(text.as_bytes()).map_err(failed)
    }

    /// Has the note of a claim say how often was decided of its parts; it never says less than before. One rename; a note that
    /// is missing beside a stored file is made without words.
    ///
    /// # Errors
    /// The disk does not let it.
    pub fn mark(&self, hash: &str, claim: &str, decisions: u32) -> Result<(), StoreError> {
        let stored = self.path(hash)?;
        let to = stored.with_file_name(name_of(hash, claim, decisions));
        let failed = |source| StoreError::Io { what: "mark a claim in", path: to.clone(), source };
        let mut notes = self.notes_of_claim(hash, claim)?;
        let last = notes.pop();
        match &last {
            Some((known, _)) if *known >= decisions => {}
            Some((_, from)) => fs::rename(from, &to).map_err(failed)?,
            None if disk::is_there(&stored) => drop(fs::File::create(&to).map_err(failed)?),
            None => {}
        }
        // Another one of the same claim was written while it was marked.
        notes.iter().try_for_each(|(_, older)| fs::remove_file(older)).map_err(failed)
    }

    /// Removes the note of a claim that came to nothing; that there is none is no error.
    ///
    /// # Errors
    /// The disk does not let it.
    pub fn forget_note(&self, hash: &str, claim: &str) -> Result<(), StoreError> {
        for (_, path) in self.notes_of_claim(hash, claim)? {
            match fs::remove_file(&path) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => {
                    return Err(StoreError::Io { what: "remove", path, source });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Where the note of a claim is, or would be.
    ///
    /// # Errors
    /// The hash is none, or the store cannot be read.
    pub fn note_path(&self, hash: &str, claim: &str) -> Result<PathBuf, StoreError> {
        match self.notes_of_claim(hash, claim)?.pop() {
            Some((_, path)) => Ok(path),
            None => Ok(self.path(hash)?.with_file_name(name_of(hash, claim, 0))),
        }
    }

    /// The notes of a claim with how often each says that was decided, that of the most last; there is one but for a moment.
    fn notes_of_claim(&self, hash: &str, claim: &str) -> Result<Vec<(u32, PathBuf)>, StoreError> {
        let stored = self.path(hash)?;
        let notes = self.notes_of(&stored).map_err(|source| StoreError::Io {
            what: "list the notes of",
            path: stored.clone(),
            source,
        })?;
        let of_claim = |path: PathBuf| {
            let (of, decisions) = claim_and_decisions(path.file_name()?.to_str()?.get(HASH_LEN..)?)?;
            (of == claim).then_some((decisions, path))
        };
        let mut notes: Vec<_> = notes.into_iter().filter_map(of_claim).collect();
        notes.sort();
        Ok(notes)
    }

    /// All that lies in the store, by hash, without touching it; nothing where there is no store yet.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn kept(&self) -> io::Result<BTreeMap<String, Kept>> {
        let mut kept: BTreeMap<String, Kept> = BTreeMap::new();
        for folder in entries(self.dir())? {
            if folder.file_name().is_none_or(|name| name.len() != 2) {
                continue;
            }
            for file in entries(&folder)? {
                let Some(name) = file.file_name().and_then(|name| name.to_str()) else { continue };
                match name.split_at_checked(HASH_LEN) {
                    Some((hash, "")) => kept.entry(hash.to_owned()).or_default().is_stored = true,
                    Some((hash, rest)) => {
                        let kept = kept.entry(hash.to_owned()).or_default();
                        if let Some((claim, decisions)) = claim_and_decisions(rest) {
                            let known = kept.claims.entry(claim.to_owned()).or_default();
                            *known = decisions.max(*known);
                        }
                    }
                    None => {}
                }
            }
        }
        Ok(kept)
    }

    /// Moves a stored file that nobody knows out of the store to `folder`, under its own name; notes of it go with it.
    ///
    /// # Errors
    /// The disk does not let it.
    pub fn set_aside(&self, hash: &str, folder: &Path) -> io::Result<PathBuf> {
        let from = self.path(hash).map_err(io::Error::other)?;
        disk::create_dirs(folder)?;
        for note in self.notes_of(&from)? {
            fs::rename(&note, folder.join(note.file_name().unwrap_or_default()))?;
        }
        let to = folder.join(hash);
        fs::rename(&from, &to)?;
        disk::fsync_dir(folder)?;
        Ok(to)
    }

    /// Removes all notes beside a stored file.
    pub(super) fn remove_notes(&self, stored: &Path) -> io::Result<()> {
        self.notes_of(stored)?.iter().try_for_each(fs::remove_file)
    }

    fn notes_of(&self, stored: &Path) -> io::Result<Vec<PathBuf>> {
        let mut start = stored.file_name().unwrap_or_default().to_owned();
        start.push(".");
        let is_note = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().as_encoded_bytes();
            name.starts_with(start.as_encoded_bytes()) && name.ends_with(NOTE.as_bytes())
        };
        Ok(entries(stored.parent().unwrap_or(stored))?.into_iter().filter(is_note).collect())
    }
}

/// Name of the note of a claim.
fn name_of(hash: &str, claim: &str, decisions: u32) -> String {
    match decisions {
        0 => format!("{hash}.{claim}{NOTE}"),
        _ => format!("{hash}.{claim}.{decisions}{NOTE}"),
    }
}

/// What the name of a note says after the hash; ids of claims have no dot.
fn claim_and_decisions(rest: &str) -> Option<(&str, u32)> {
    let rest = rest.strip_prefix('.')?.strip_suffix(NOTE)?;
    let marked = rest.rsplit_once('.').and_then(|(claim, count)| Some((claim, count.parse().ok()?)));
    Some(marked.unwrap_or((rest, 0)))
}

/// What a folder holds; nothing where there is none.
fn entries(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Ok(Vec::new());
        }
        other => other?,
    };
    entries.map(|entry| Ok(entry?.path())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_lie_beside_their_file_and_go_with_it() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path().join("store")).unwrap();
        assert_eq!(Store::at(dir.path().join("none")).kept().unwrap(), BTreeMap::new());
        let part = dir.path().join("part.stl");
        fs::write(&part, "solid").unwrap();
        let hash = store.put(&part).unwrap().hash;
        store.note(&hash, "c1", "{}").unwrap();
        store.note(&hash, "c2", "{}").unwrap();
        store.forget_note(&hash, "c2").unwrap();
        store.forget_note(&hash, "c2").unwrap();
        let kept = store.kept().unwrap();
        assert_eq!(kept[&hash], Kept { is_stored: true, claims: BTreeMap::from([("c1".to_owned(), 0)]) });
        let aside = store.set_aside(&hash, &dir.path().join("aside")).unwrap();
        assert!(aside.is_file() && store.kept().unwrap().is_empty());
        store.put(&part).unwrap();
        store.note(&hash, "c1", "{}").unwrap();
        store.remove(&hash).unwrap();
        assert!(store.kept().unwrap().is_empty(), "{:?}", store.kept());
    }
    #[test]
    fn the_name_of_a_note_says_how_often_was_decided() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path().join("store")).unwrap();
        let part = dir.path().join("part.stl");
        fs::write(&part, "solid").unwrap();
        let hash = store.put(&part).unwrap().hash;
        let decisions = || store.kept().unwrap()[&hash].claims.clone();
        let is_noted = |claim: &str, count| decisions().get(claim) == Some(&count);
        store.note(&hash, "c1", "{1}").unwrap();
        store.note(&hash, "c12", "{12}").unwrap();
        store.mark(&hash, "c1", 0).unwrap();
        assert!(is_noted("c1", 0));
        for (count, now) in [(1, 1), (3, 3), (2, 3), (12, 12)] {
            store.mark(&hash, "c1", count).unwrap();
            assert!(is_noted("c1", now) && is_noted("c12", 0), "{:?}", decisions());
            assert_eq!(fs::read_to_string(store.note_path(&hash, "c1").unwrap()).unwrap(), "{1}");
        }
        store.note(&hash, "c1", "{new}").unwrap();
        assert!(is_noted("c1", 12) && decisions().len() == 2, "its words are written under its name");
        // Written while it was being marked: the next mark leaves one.
        fs::write(store.note_path(&hash, "c1").unwrap().with_file_name(format!("{hash}.c1.json")), "{late}").unwrap();
        assert!(is_noted("c1", 12));
        store.mark(&hash, "c1", 13).unwrap();
        assert_eq!(fs::read_to_string(store.note_path(&hash, "c1").unwrap()).unwrap(), "{new}");
        assert_eq!(store.notes_of_claim(&hash, "c1").unwrap().len(), 1);
        store.forget_note(&hash, "c1").unwrap();
        assert_eq!(decisions(), BTreeMap::from([("c12".to_owned(), 0)]));
        store.mark(&hash, "c2", 2).unwrap();
        assert!(is_noted("c2", 2) && fs::read(store.note_path(&hash, "c2").unwrap()).unwrap().is_empty());
        store.set_aside(&hash, &dir.path().join("aside")).unwrap();
        assert!(dir.path().join("aside").join(format!("{hash}.c2.2.json")).is_file());
        store.mark(&hash, "c2", 3).unwrap();
        assert!(store.kept().unwrap().is_empty(), "nothing is noted of what is not kept");
    }
}
