//! Notes beside stored files: one per claim, what was asked of it. A ledger that was put back from before the claim learns
//! from it what the bytes alone do not say: name, copies, ticket.

use std::{
    collections::BTreeMap,
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::{Store, StoreError, disk};

/// Ends the name of a note, which is `<hash>.<claim>.json`.
const NOTE: &str = ".json";
/// Hex digits of a hash.
const HASH_LEN: usize = 64;

/// What lies in the store under one hash.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Kept {
    /// Whether the bytes are there.
    pub is_stored: bool,
    /// The claims of which there is a note.
    pub claims: Vec<String>,
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

    /// Removes the note of a claim that came to nothing; that there is none is no error.
    ///
    /// # Errors
    /// The disk does not let it.
    pub fn forget_note(&self, hash: &str, claim: &str) -> Result<(), StoreError> {
        let path = self.note_path(hash, claim)?;
        match fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                Err(StoreError::Io { what: "remove", path, source })
            }
            _ => Ok(()),
        }
    }

    /// Where the note of a claim is, or would be.
    ///
    /// # Errors
    /// The hash is none.
    pub fn note_path(&self, hash: &str, claim: &str) -> Result<PathBuf, StoreError> {
        Ok(self.path(hash)?.with_file_name(format!("{hash}.{claim}{NOTE}")))
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
                        let claim = rest.strip_prefix('.').and_then(|rest| rest.strip_suffix(NOTE));
                        kept.entry(hash.to_owned()).or_default().claims.extend(claim.map(str::to_owned));
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
        assert_eq!(kept[&hash], Kept { is_stored: true, claims: vec!["c1".to_owned()] });
        let aside = store.set_aside(&hash, &dir.path().join("aside")).unwrap();
        assert!(aside.is_file() && store.kept().unwrap().is_empty());
        store.put(&part).unwrap();
        store.note(&hash, "c1", "{}").unwrap();
        store.remove(&hash).unwrap();
        assert!(store.kept().unwrap().is_empty(), "{:?}", store.kept());
    }
}
