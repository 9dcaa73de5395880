//! Reads a 3MF package with limits: entries and unpacked bytes are counted while reading; declared sizes are not
//! trusted.

use std::{
    collections::HashMap,
    fs::File,
    io::{self, BufReader, Read, Seek, SeekFrom, Write},
    path::Path,
};

use zip::{ZipArchive, result::ZipError};

use super::{
    unpack_guard::UnpackGuard,
    xml::{DocumentStep, XmlReader},
    xml_names::ElementTag,
};
use crate::{FileReadError, ReadLimits};

/// Relationship types of the model.
const MODEL_TYPES: [&str; 2] = [
    "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel",
    "http://schemas.microsoft.com/3dmanufacturing/2015/06/3dmodel",
];
/// The end record has 22 bytes, and a comment of the greatest length may follow.
pub(crate) const MAX_END: u64 = 22 + 65_535;

/// XML of a package entry, unpacked while it is read.
pub(crate) type EntryXmlReader<'a> = XmlReader<UnpackGuard<BufReader<zip::read::ZipFile<'a, BufReader<File>>>>>;

/// An opened package.
pub(crate) struct PackageReader {
    archive: ZipArchive<BufReader<File>>,
    /// Lower-case name -> index: package names are case-insensitive.
    entries: HashMap<String, usize>,
    /// Bytes that may still be unpacked.
    budget: u64,
    limits: ReadLimits,
}

impl PackageReader {
    /// Opens the ZIP directory and counts its entries; unpacks nothing.
    pub(crate) fn open(file: &Path, limits: &ReadLimits) -> Result<Self, FileReadError> {
        let mut opened = File::open(file)?;
        let len = opened.metadata()?.len();
        if len > limits.max_bytes {
            return Err(FileReadError::TooLarge {
                what: format!("it is {len} bytes long"),
                limit: limits.max_bytes,
                key: "max_bytes",
            });
        }
        let claimed = declared_entries(&mut opened, len)?
            .ok_or_else(|| FileReadError::Truncated("the end of the ZIP package is missing".to_owned()))?;
        if claimed > limits.max_entries {
            return Err(FileReadError::TooLarge {
                what: format!("the package has {claimed} entries"),
                limit: limits.max_entries,
                key: "max_entries",
            });
        }
        let archive = ZipArchive::new(BufReader::new(opened)).map_err(zip_error)?;
        if archive.len() as u64 != claimed {
            // The ZIP reader keeps one of two entries with the same name; other readers keep the other one.
            return Err(FileReadError::invalid_threemf("the package names an entry twice"));
        }
        let mut entries = HashMap::new();
        for (index, name) in archive.file_names().enumerate() {
            if entries.insert(plain_path(name), index).is_some() {
                return Err(FileReadError::invalid_threemf(format!("the package names {name:?} twice")));
            }
        }
        Ok(Self { archive, entries, budget: limits.max_unpacked_bytes, limits: limits.clone() })
    }

    /// Unpacks one entry as XML and passes it to `parse`, which must read it to its end.
    pub(super) fn parse_entry<T>(
        &mut self,
        path: &str,
        parse: impl FnOnce(&mut EntryXmlReader<'_>) -> Result<T, FileReadError>,
    ) -> Result<T, FileReadError> {
        let name = plain_path(path);
        let index =
            *self.entries.get(&name).ok_or_else(|| FileReadError::invalid_threemf(format!("there is no {path:?}")))?;
        let entry = self.archive.by_index(index).map_err(zip_error)?;
        if entry.encrypted() {
            return Err(encrypted_error());
        }
        let packed = entry.compressed_size();
        let guard = UnpackGuard::new(
            BufReader::with_capacity(1 << 16, entry),
            packed,
            self.budget,
            self.limits.max_unpacked_bytes,
        );
        let mut xml = XmlReader::new(guard, path);
        let result = parse(&mut xml);
        self.budget -= xml.unpacked_bytes().min(self.budget);
        result
    }

    /// The first of these paths that is an entry, in any letter case.
    pub(crate) fn find_entry(&self, paths: &[&str]) -> Option<String> {
        paths.iter().map(|path| path.to_ascii_lowercase()).find(|path| self.entries.contains_key(path))
    }

    /// The entries whose path fits, in lower case, in the order of the alphabet.
    pub(super) fn entries_that(&self, fits: impl Fn(&str) -> bool) -> Vec<String> {
        let mut found: Vec<String> = self.entries.keys().filter(|path| fits(path)).cloned().collect();
        found.sort();
        found
    }

    /// The entries with one of these names, in any letter case, in the package or in its folders, in the order of the alphabet.
    pub(crate) fn entries_named(&self, names: &[&str]) -> Vec<String> {
        self.entries_that(|path| {
            let name = path.split_once('/').map_or(path, |(_, name)| name);
            names.iter().any(|wanted| wanted.eq_ignore_ascii_case(name))
        })
    }

    /// Unpacks an entry; a longer one than `most` bytes is refused.
    pub(crate) fn unpack_entry(&mut self, name: &str, most: u64, to: &mut impl Write) -> Result<(), FileReadError> {
        let index =
            *self.entries.get(name).ok_or_else(|| FileReadError::invalid_threemf(format!("there is no {name:?}")))?;
        let entry = self.archive.by_index(index).map_err(zip_error)?;
        if entry.encrypted() {
            return Err(encrypted_error());
        }
        let packed = entry.compressed_size();
        let entry = BufReader::with_capacity(1 << 16, entry);
        let mut guard = UnpackGuard::new(entry, packed, self.budget, self.limits.max_unpacked_bytes);
        let mut piece = [0; 1 << 14];
        loop {
            guard.start_token();
            match guard.read(&mut piece) {
                Ok(0) => break,
                Ok(read) => to.write_all(&piece[..read])?,
                Err(error) if error.raw_os_error().is_some() => return Err(error.into()),
                Err(error) => {
                    let damaged = || FileReadError::Truncated(format!("{name:?} in the package is damaged: {error}"));
                    return Err(guard.take_refusal().unwrap_or_else(damaged));
                }
            }
            if guard.unpacked_bytes() > most {
                return Err(FileReadError::invalid_threemf(format!("{name:?} is longer than {most} bytes")));
            }
        }
        self.budget -= guard.unpacked_bytes().min(self.budget);
        Ok(())
    }

    /// The path of the start model, and the number of start models (it should be one).
    pub(super) fn start_part_path(&mut self) -> Result<(String, usize), FileReadError> {
        if !self.entries.contains_key("_rels/.rels") {
            if self.entries.keys().any(|name| name.ends_with(".stl") || name.ends_with(".3mf")) {
                return Err(FileReadError::Unknown {
                    what: "it is a ZIP archive with part files in it".to_owned(),
                    remedy: "Unpack it, and drop the files that are in it.",
                });
            }
            return Err(FileReadError::invalid_threemf("the package has no relationships, so no 3D model"));
        }
        let mut targets = self.parse_entry("_rels/.rels", relationship_targets)?;
        match targets.len() {
            0 => Err(FileReadError::invalid_threemf("the package has no 3D model")),
            count => Ok((targets.remove(0), count)),
        }
    }
}

/// Targets of the relationships to a model.
fn relationship_targets(xml: &mut EntryXmlReader<'_>) -> Result<Vec<String>, FileReadError> {
    let mut targets = Vec::new();
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Relationship)
                if xml.plain_attribute("Type").is_some_and(|t| MODEL_TYPES.contains(&t)) =>
            {
                let target = xml
                    .plain_attribute("Target")
                    .ok_or_else(|| xml.invalid_document("a relationship without a target"))?;
                if targets.len() < 10 {
                    targets.push(target.to_owned());
                }
            }
            DocumentStep::End => return Ok(targets),
            _ => {}
        }
    }
}

/// The path of an entry as it is compared: programs write it in any letter case, from the root or not, and with the signs of Windows.
fn plain_path(path: &str) -> String {
    path.replace('\\', "/").trim_start_matches("./").trim_start_matches('/').to_ascii_lowercase()
}

/// The number of entries that the end record of a ZIP package of `len` bytes declares; `None` without an end record.
///
/// # Errors
/// The file cannot be read.
pub fn declared_entries(file: &mut File, len: u64) -> io::Result<Option<u64>> {
    let tail_len = len.min(MAX_END + 20);
    file.seek(SeekFrom::Start(len - tail_len))?;
    let mut tail = Vec::new();
    (&mut *file).take(tail_len).read_to_end(&mut tail)?;
    let Some(at) = end_record(&tail) else { return Ok(None) };
    let short = u64::from(u16::from_le_bytes([tail[at + 10], tail[at + 11]]));
    if short != 0xffff || at < 20 || !tail[at - 20..].starts_with(b"PK\x06\x07") {
        return Ok(Some(short));
    }
    let offset = u64::from_le_bytes(tail[at - 12..at - 4].try_into().expect("eight bytes"));
    let mut long = [0; 40];
    file.seek(SeekFrom::Start(offset.min(len)))?;
    match file.read_exact(&mut long) {
        Ok(()) => Ok(Some(u64::from_le_bytes(long[32..40].try_into().expect("eight bytes")))),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}

/// Start of the last end-of-central-directory record whose comment is complete.
pub(crate) fn end_record(tail: &[u8]) -> Option<usize> {
    (0..tail.len().saturating_sub(21)).rev().find(|&at| {
        tail[at..].starts_with(b"PK\x05\x06")
            && at + 22 + usize::from(u16::from_le_bytes([tail[at + 20], tail[at + 21]])) <= tail.len()
    })
}

fn encrypted_error() -> FileReadError {
    FileReadError::Unsupported {
        what: "the package is encrypted".to_owned(),
        remedy: "Save it without a password, and drop that.",
    }
}

/// Converts a ZIP error; an I/O error of the disk stays an I/O error.
fn zip_error(error: ZipError) -> FileReadError {
    match error {
        ZipError::Io(error) if error.raw_os_error().is_some() => FileReadError::Io(error),
        ZipError::UnsupportedArchive(ZipError::PASSWORD_REQUIRED) => encrypted_error(),
        ZipError::UnsupportedArchive(what) => FileReadError::Unsupported {
            what: format!("the package is packed in a way that 3MF does not allow: {what}"),
            remedy: "Open it in the program that wrote it, and save it as a plain 3MF.",
        },
        other => FileReadError::invalid_threemf(format!("the ZIP package is damaged: {other}")),
    }
}
