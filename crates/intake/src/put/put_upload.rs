//! Uploads that may be cut and go on: `state/put/upload-<id>.part` holds what has arrived, `upload-<id>.json` what is to come of it. How
//! far one is is the length of its file, so it goes on after a restart where it was. A complete one becomes a content under its BLAKE3.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::PathBuf,
    time::{Duration, SystemTime},
};

use serde::{Deserialize, Serialize};

use super::put_content::ROOM_CHECK_BYTES;
use crate::{PutContents, PutError, folder::disk};

/// How the names of both files begin.
const PREFIX: &str = "upload-";
/// An upload without a byte for this time is given up.
pub const UPLOAD_KEPT: Duration = Duration::from_secs(86_400);

/// What is known of an upload.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UploadRecord {
    /// All bytes of the file.
    pub length: u64,
    /// Who sends it.
    pub client: String,
    /// The BLAKE3 that it must have, 64 hex digits; `None` = not said.
    pub expected: Option<String>,
    /// Its BLAKE3 once it is complete.
    pub content: Option<String>,
}

/// An upload as it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UploadState {
    /// What is known of it.
    pub record: UploadRecord,
    /// Bytes that have arrived.
    pub offset: u64,
    /// When the last of them came.
    pub changed_at: SystemTime,
}

/// The uploads of a farm.
#[derive(Debug, Clone)]
pub struct PutUploads {
    contents: PutContents,
}

/// The file of an upload, to which more is added.
#[derive(Debug)]
pub struct UploadPart {
    contents: PutContents,
    file: File,
    bytes: u64,
}

/// Whether a text is the id of an upload.
pub fn is_upload_id(text: &str) -> bool {
    text.len() == 32 && text.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f'))
}

impl PutUploads {
    /// Those that become contents of this folder.
    pub fn new(contents: PutContents) -> Self {
        Self { contents }
    }

    fn part_file(&self, id: &str) -> PathBuf {
        self.contents.path_of(&format!("{PREFIX}{id}.part"))
    }

    fn record_file(&self, id: &str) -> PathBuf {
        self.contents.path_of(&format!("{PREFIX}{id}.json"))
    }

    /// Begins an upload, if there is room for it beside what is to come of the others.
    ///
    /// # Errors
    /// `TooLarge`, `NoRoom` or `Write`.
    pub fn begin_upload(&self, id: &str, record: &UploadRecord, max_bytes: u64) -> Result<(), PutError> {
        self.contents.create_folder()?;
        let others: u64 = self.list_unfinished()?.iter().map(|other| other.record.length - other.offset).sum();
        self.contents.check_room(record.length, max_bytes)?;
        self.contents.check_room(record.length.saturating_add(others), u64::MAX)?;
        disk::create_fresh_file(&self.part_file(id))?;
        Ok(self.write_record(id, record)?)
    }

    fn write_record(&self, id: &str, record: &UploadRecord) -> io::Result<()> {
        disk::write_file_atomically(&self.record_file(id), &serde_json::to_vec(record)?)
    }

    /// How far an upload is; `None` = there is none of that id.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn find_upload(&self, id: &str) -> io::Result<Option<UploadState>> {
        let Some(bytes) = disk::read_start(&self.record_file(id), 1 << 16)? else { return Ok(None) };
        let Ok(record) = serde_json::from_slice::<UploadRecord>(&bytes) else { return Ok(None) };
        let (offset, changed_at) = match fs::metadata(self.part_file(id)) {
            Ok(found) => (found.len(), found.modified()?),
            // It is complete, and is a content by now.
            Err(error) if error.kind() == io::ErrorKind::NotFound && record.content.is_some() => {
                (record.length, fs::metadata(self.record_file(id))?.modified()?)
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        Ok(Some(UploadState { record, offset, changed_at }))
    }

    /// Opens the file of an upload, to go on where it ends.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn open_part(&self, id: &str) -> io::Result<UploadPart> {
        let file = File::options().append(true).open(self.part_file(id))?;
        Ok(UploadPart { contents: self.contents.clone(), file, bytes: 0 })
    }

    /// Makes what has arrived durable. A complete upload becomes a content, also when that was interrupted before.
    ///
    /// # Errors
    /// `OtherContent` or `TooLong`, and the upload is gone; or `Write`.
    pub fn settle_upload(&self, id: &str) -> Result<Option<UploadState>, PutError> {
        let Some(mut upload) = self.find_upload(id)? else { return Ok(None) };
        let part = self.part_file(id);
        if upload.offset < upload.record.length || !disk::try_path_exists(&part)? {
            return Ok(Some(upload));
        }
        if upload.offset > upload.record.length {
            self.remove_upload(id)?;
            return Err(PutError::TooLong { bytes: upload.offset, said: upload.record.length });
        }
        File::open(&part)?.sync_all()?;
        let hash = disk::hash_file(&part)?;
        if let Some(expected) = upload.record.expected.clone().filter(|expected| *expected != hash) {
            self.remove_upload(id)?;
            return Err(PutError::OtherContent { found: hash, expected });
        }
        upload.record.content = Some(hash.clone());
        self.write_record(id, &upload.record)?;
        self.contents.keep_content(&part, &hash, None)?;
        Ok(Some(upload))
    }

    /// Gives an upload up. What has become a content stays.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn remove_upload(&self, id: &str) -> io::Result<()> {
        for file in [self.record_file(id), self.part_file(id)] {
            match fs::remove_file(&file) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }

    /// The uploads that are not complete.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn list_unfinished(&self) -> io::Result<Vec<UploadState>> {
        let uploads: Vec<UploadState> =
            self.list_ids()?.iter().filter_map(|id| self.find_upload(id).transpose()).collect::<io::Result<_>>()?;
        Ok(uploads.into_iter().filter(|upload| upload.offset < upload.record.length).collect())
    }

    fn list_ids(&self) -> io::Result<Vec<String>> {
        let entries = match fs::read_dir(self.contents.path_of("")) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            other => other?,
        };
        let mut ids = Vec::new();
        for entry in entries {
            let name = entry?.file_name().to_string_lossy().into_owned();
            let id = name.strip_prefix(PREFIX).and_then(|rest| rest.split('.').next()).unwrap_or_default();
            if is_upload_id(id) {
                ids.push(id.to_owned());
            }
        }
        ids.sort();
        ids.dedup();
        Ok(ids)
    }

    /// Removes the uploads of which no byte came for this time.
    ///
    /// # Errors
    /// The folder cannot be read or written.
    pub fn sweep_uploads(&self, quiet_for: Duration) -> io::Result<()> {
        for id in self.list_ids()? {
            let changed_at = match self.find_upload(&id)? {
                Some(upload) => upload.changed_at,
                // A crash left one of its two files.
                None => {
                    let file = [self.part_file(&id), self.record_file(&id)].into_iter().find(|file| file.exists());
                    file.map_or(Ok(SystemTime::UNIX_EPOCH), |file| fs::metadata(file)?.modified())?
                }
            };
            if changed_at.elapsed().is_ok_and(|age| age >= quiet_for) {
                self.remove_upload(&id)?;
            }
        }
        Ok(())
    }
}

impl UploadPart {
    /// Adds what has arrived.
    ///
    /// # Errors
    /// `NoRoom` where the disk has become too full, or `Write`.
    pub fn append_bytes(&mut self, bytes: &[u8]) -> Result<(), PutError> {
        let (before, more) = (self.bytes, bytes.len() as u64);
        self.bytes += more;
        if before / ROOM_CHECK_BYTES != self.bytes / ROOM_CHECK_BYTES {
            self.contents.check_room(more, u64::MAX)?;
        }
        Ok(self.file.write_all(bytes)?)
    }

    /// Makes what was added durable.
    ///
    /// # Errors
    /// The disk is full, or fails.
    pub fn sync_bytes(&self) -> io::Result<()> {
        self.file.sync_data()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ID: &str = "0123456789abcdef0123456789abcdef";

    fn record(length: u64, expected: Option<&str>) -> UploadRecord {
        UploadRecord { length, client: "mes".to_owned(), expected: expected.map(str::to_owned), content: None }
    }

    #[test]
    fn an_upload_goes_on_where_it_was_cut_and_becomes_a_content_once() {
        let folder = tempfile::tempdir().unwrap();
        let contents = PutContents::of_farm(folder.path());
        let uploads = PutUploads::new(contents.clone());
        assert_eq!(uploads.find_upload(ID).unwrap(), None);
        uploads.begin_upload(ID, &record(5, None), 10).unwrap();
        for (piece, offset) in [("so", 2), ("", 2), ("lid", 5)] {
            uploads.open_part(ID).unwrap().append_bytes(piece.as_bytes()).unwrap();
            // As another process after a crash.
            let uploads = PutUploads::new(PutContents::of_farm(folder.path()));
            assert_eq!(uploads.find_upload(ID).unwrap().unwrap().offset, offset);
            assert_eq!(uploads.list_unfinished().unwrap().len(), usize::from(offset < 5));
        }
        let hash = blake3::hash(b"solid").to_hex().to_string();
        // A crash before the file had its name.
        let complete = UploadRecord { content: Some(hash.clone()), ..record(5, None) };
        uploads.write_record(ID, &complete).unwrap();
        for _ in 0..2 {
            let settled = uploads.settle_upload(ID).unwrap().unwrap();
            assert_eq!((settled.record, settled.offset), (complete.clone(), 5));
            assert_eq!(contents.use_content(&hash).unwrap().unwrap().bytes, 5);
        }
        uploads.sweep_uploads(UPLOAD_KEPT).unwrap();
        assert!(uploads.find_upload(ID).unwrap().is_some());
        uploads.sweep_uploads(Duration::ZERO).unwrap();
        assert!(uploads.find_upload(ID).unwrap().is_none() && contents.use_content(&hash).unwrap().is_some());
    }

    #[test]
    fn an_upload_that_is_too_large_or_becomes_something_else_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let uploads = PutUploads::new(PutContents::of_farm(folder.path()));
        assert!(matches!(uploads.begin_upload(ID, &record(11, None), 10), Err(PutError::TooLarge { .. })));
        assert!(matches!(uploads.begin_upload(ID, &record(1 << 60, None), u64::MAX), Err(PutError::NoRoom { .. })));
        uploads.begin_upload(ID, &record(5, Some(&"0".repeat(64))), 10).unwrap();
        uploads.open_part(ID).unwrap().append_bytes(b"solid").unwrap();
        assert!(matches!(uploads.settle_upload(ID), Err(PutError::OtherContent { .. })));
        uploads.begin_upload(ID, &record(5, None), 10).unwrap();
        uploads.open_part(ID).unwrap().append_bytes(b"solids").unwrap();
        assert!(matches!(uploads.settle_upload(ID), Err(PutError::TooLong { bytes: 6, said: 5 })));
        assert_eq!(uploads.find_upload(ID).unwrap(), None);
        fs::write(folder.path().join(format!("put/upload-{ID}.part")), "left over").unwrap();
        uploads.sweep_uploads(Duration::ZERO).unwrap();
        assert_eq!(fs::read_dir(folder.path().join("put")).unwrap().count(), 0);
        assert!(is_upload_id(ID) && !is_upload_id("../x") && !is_upload_id(&ID.to_uppercase()));
    }
}
