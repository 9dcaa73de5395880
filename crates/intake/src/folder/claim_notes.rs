//! Notes beside stored files, one per claim: what was ordered with it. A ledger restored from a backup made before the
//! claim learns from the note what the file alone does not say: name, copies, ticket.

use std::{
    collections::BTreeMap,
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::disk;
use crate::{ContentStore, StoreError};

/// Suffix of the name of a note. The name is `<hash>.<claim>.json`, or `<hash>.<claim>.<decisions>.json` once the claim
/// has decisions.
const NOTE_SUFFIX: &str = ".json";
/// Number of hex digits in a hash.
const HASH_LEN: usize = 64;

/// What the store holds under one hash.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct StoredContent {
    /// Whether the file itself is stored.
    pub is_stored: bool,
    /// The claims that have a note, each with the number of decisions in the name of its note.
    pub claims: BTreeMap<String, u32>,
}

impl ContentStore {
    /// Writes the note of a claim beside its stored file. The note is not fsynced by itself: the row in the ledger is,
    /// and the note is needed only if that row is lost later.
    ///
    /// # Errors
    /// The file system reports an error.
    pub fn write_note(&self, hash: &str, claim: &str, text: &str) -> Result<(), StoreError> {
        let path = self.note_path(hash, claim)?;
        let failed = |source| StoreError::Io { what: "note a claim in", path: path.clone(), source };
        let mut file = fs::File::create(&path).map_err(failed)?;
        file.write_all(text.as_bytes()).map_err(failed)
    }

    /// Records in the name of a claim's note how many decisions were made about its parts. The number never decreases.
    /// This is a single rename. If the note of a stored file is missing, an empty one is created.
    ///
    /// # Errors
    /// The file system reports an error.
    pub fn mark_decisions(&self, hash: &str, claim: &str, decisions: u32) -> Result<(), StoreError> {
        let stored = self.file_path(hash)?;
        let to = stored.with_file_name(note_name(hash, claim, decisions));
        let failed = |source| StoreError::Io { what: "mark a claim in", path: to.clone(), source };
        let mut notes = self.notes_of_claim(hash, claim)?;
        let last = notes.pop();
        match &last {
            Some((known, _)) if *known >= decisions => {}
            Some((_, from)) => fs::rename(from, &to).map_err(failed)?,
            None if disk::path_exists(&stored) => drop(fs::File::create(&to).map_err(failed)?),
            None => {}
        }
        // Another note of the same claim was written during the rename.
        notes.iter().try_for_each(|(_, older)| fs::remove_file(older)).map_err(failed)
    }

    /// Removes the note of an abandoned claim. A missing note is not an error.
    ///
    /// # Errors
    /// The file system reports an error.
    pub fn delete_note(&self, hash: &str, claim: &str) -> Result<(), StoreError> {
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

    /// Path of the note of a claim; if it does not exist, the path that it would have.
    ///
    /// The hash is invalid, or the store cannot be read.
    pub fn note_path(&self, hash: &str, claim: &str) -> Result<PathBuf, StoreError> {
        match self.notes_of_claim(hash, claim)?.pop() {
            Some((_, path)) => Ok(path),
            None => Ok(self.file_path(hash)?.with_file_name(note_name(hash, claim, 0))),
        }
    }

    /// Lists the notes of a claim with their numbers of decisions, in ascending order. There is usually one; for a
    /// moment there may be two.
    fn notes_of_claim(&self, hash: &str, claim: &str) -> Result<Vec<(u32, PathBuf)>, StoreError> {
        let stored = self.file_path(hash)?;
        let notes = self.notes_beside(&stored).map_err(|source| StoreError::Io {
            what: "list the notes of",
            path: stored.clone(),
            source,
        })?;
        let of_claim = |path: PathBuf| {
            let (of, decisions) = parse_note_name(path.file_name()?.to_str()?.get(HASH_LEN..)?)?;
            (of == claim).then_some((decisions, path))
        };
        let mut notes: Vec<_> = notes.into_iter().filter_map(of_claim).collect();
        notes.sort();
        Ok(notes)
    }

    /// Lists the content of the store by hash, without changing it. Empty if there is no store yet.
    ///
    /// The store cannot be read.
    pub fn list_contents(&self) -> io::Result<BTreeMap<String, StoredContent>> {
        let mut kept: BTreeMap<String, StoredContent> = BTreeMap::new();
        for folder in list_folder(self.dir())? {
            if folder.file_name().is_none_or(|name| name.len() != 2) {
                continue;
            }
            for file in list_folder(&folder)? {
                let Some(name) = file.file_name().and_then(|name| name.to_str()) else { continue };
                match name.split_at_checked(HASH_LEN) {
                    Some((hash, "")) => kept.entry(hash.to_owned()).or_default().is_stored = true,
                    Some((hash, rest)) => {
                        let kept = kept.entry(hash.to_owned()).or_default();
                        if let Some((claim, decisions)) = parse_note_name(rest) {
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

    /// Moves a stored file that no row refers to from the store to `folder`, together with its notes. The file names
    /// stay.
    ///
    /// # Errors
    /// The file system reports an error.
    pub fn set_aside(&self, hash: &str, folder: &Path) -> io::Result<PathBuf> {
        let from = self.file_path(hash).map_err(io::Error::other)?;
        disk::create_dirs(folder)?;
        for note in self.notes_beside(&from)? {
            fs::rename(&note, folder.join(note.file_name().unwrap_or_default()))?;
        }
        let to = folder.join(hash);
        fs::rename(&from, &to)?;
        disk::fsync_dir(folder)?;
        Ok(to)
    }

    /// Removes all notes beside a stored file.
    pub(super) fn remove_notes(&self, stored: &Path) -> io::Result<()> {
        self.notes_beside(stored)?.iter().try_for_each(fs::remove_file)
    }

    fn notes_beside(&self, stored: &Path) -> io::Result<Vec<PathBuf>> {
        let mut start = stored.file_name().unwrap_or_default().to_owned();
        start.push(".");
        let is_note = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().as_encoded_bytes();
            name.starts_with(start.as_encoded_bytes()) && name.ends_with(NOTE_SUFFIX.as_bytes())
        };
        Ok(list_folder(stored.parent().unwrap_or(stored))?.into_iter().filter(is_note).collect())
    }
}

/// File name of the note of a claim.
fn note_name(hash: &str, claim: &str, decisions: u32) -> String {
    match decisions {
        0 => format!("{hash}.{claim}{NOTE_SUFFIX}"),
        _ => format!("{hash}.{claim}.{decisions}{NOTE_SUFFIX}"),
    }
}

/// Parses the part of a note's name after the hash into claim and number of decisions. Claim ids contain no dot.
fn parse_note_name(rest: &str) -> Option<(&str, u32)> {
    let rest = rest.strip_prefix('.')?.strip_suffix(NOTE_SUFFIX)?;
    let marked = rest.rsplit_once('.').and_then(|(claim, count)| Some((claim, count.parse().ok()?)));
    Some(marked.unwrap_or((rest, 0)))
}

/// Lists a folder. Empty if the folder does not exist.
fn list_folder(folder: &Path) -> io::Result<Vec<PathBuf>> {
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
        let store = ContentStore::open(dir.path().join("store")).unwrap();
        assert_eq!(ContentStore::from_dir(dir.path().join("none")).list_contents().unwrap(), BTreeMap::new());
        let part = dir.path().join("part.stl");
        fs::write(&part, "solid").unwrap();
        let hash = store.store_file(&part).unwrap().hash;
        store.write_note(&hash, "c1", "{}").unwrap();
        store.write_note(&hash, "c2", "{}").unwrap();
        store.delete_note(&hash, "c2").unwrap();
        store.delete_note(&hash, "c2").unwrap();
        let kept = store.list_contents().unwrap();
        assert_eq!(kept[&hash], StoredContent { is_stored: true, claims: BTreeMap::from([("c1".to_owned(), 0)]) });
        let aside = store.set_aside(&hash, &dir.path().join("aside")).unwrap();
        assert!(aside.is_file() && store.list_contents().unwrap().is_empty());
        store.store_file(&part).unwrap();
        store.write_note(&hash, "c1", "{}").unwrap();
        store.remove_content(&hash).unwrap();
        assert!(store.list_contents().unwrap().is_empty(), "{:?}", store.list_contents());
    }
    #[test]
    fn the_name_of_a_note_says_how_often_was_decided() {
        let dir = tempfile::tempdir().unwrap();
        let store = ContentStore::open(dir.path().join("store")).unwrap();
        let part = dir.path().join("part.stl");
        fs::write(&part, "solid").unwrap();
        let hash = store.store_file(&part).unwrap().hash;
        let decisions = || store.list_contents().unwrap()[&hash].claims.clone();
        let is_noted = |claim: &str, count| decisions().get(claim) == Some(&count);
        store.write_note(&hash, "c1", "{1}").unwrap();
        store.write_note(&hash, "c12", "{12}").unwrap();
        store.mark_decisions(&hash, "c1", 0).unwrap();
        assert!(is_noted("c1", 0));
        for (count, now) in [(1, 1), (3, 3), (2, 3), (12, 12)] {
            store.mark_decisions(&hash, "c1", count).unwrap();
            assert!(is_noted("c1", now) && is_noted("c12", 0), "{:?}", decisions());
            assert_eq!(fs::read_to_string(store.note_path(&hash, "c1").unwrap()).unwrap(), "{1}");
        }
        store.write_note(&hash, "c1", "{new}").unwrap();
        assert!(is_noted("c1", 12) && decisions().len() == 2, "its words are written under its name");
        // A note written during the rename: the next rename leaves only one.
        fs::write(store.note_path(&hash, "c1").unwrap().with_file_name(format!("{hash}.c1.json")), "{late}").unwrap();
        assert!(is_noted("c1", 12));
        store.mark_decisions(&hash, "c1", 13).unwrap();
        assert_eq!(fs::read_to_string(store.note_path(&hash, "c1").unwrap()).unwrap(), "{new}");
        assert_eq!(store.notes_of_claim(&hash, "c1").unwrap().len(), 1);
        store.delete_note(&hash, "c1").unwrap();
        assert_eq!(decisions(), BTreeMap::from([("c12".to_owned(), 0)]));
        store.mark_decisions(&hash, "c2", 2).unwrap();
        assert!(is_noted("c2", 2) && fs::read(store.note_path(&hash, "c2").unwrap()).unwrap().is_empty());
        store.set_aside(&hash, &dir.path().join("aside")).unwrap();
        assert!(dir.path().join("aside").join(format!("{hash}.c2.2.json")).is_file());
        store.mark_decisions(&hash, "c2", 3).unwrap();
        assert!(store.list_contents().unwrap().is_empty(), "nothing is noted of what is not kept");
    }
}
