//! STL, binary and ASCII, -> triangle soup. The file's size decides first whether it is binary, whatever the header says:
//! every seventh binary file starts with `solid`.

use std::{
    fs::File,
    io::{BufReader, Read, Seek, SeekFrom},
};

use glam::DVec3;

use super::{
    Limits, ReadError, counted,
    stl_text::{Soup, read_text},
};

/// Bytes before the first facet: an 80-byte header and the count.
pub(super) const HEAD: u64 = 84;
/// Bytes of a facet.
pub(super) const FACET: u64 = 50;
/// How much of a trailer is looked at.
const TRAILER: u64 = 1 << 16;

/// Three corners per triangle in the file's unit, and what a person should know.
#[derive(Debug)]
pub(super) struct StlSoup {
    pub(super) corners: Vec<DVec3>,
    pub(super) warnings: Vec<String>,
}

/// The count that a binary STL claims.
pub(super) fn claimed_count(head: &[u8]) -> Option<u64> {
    let bytes: [u8; 4] = head.get(80..84)?.try_into().ok()?;
    Some(u32::from_le_bytes(bytes).into())
}

/// Bytes of a binary STL with so many facets.
pub(super) fn binary_len(count: u64) -> u64 {
    HEAD + FACET * count
}

/// Reads ASCII.
pub(super) fn read_ascii(mut file: File, limits: &Limits) -> Result<StlSoup, ReadError> {
    let mut mark = [0; 3];
    let got = file.read(&mut mark)?;
    if mark[..got] != *b"\xef\xbb\xbf" {
        file.seek(SeekFrom::Start(0))?;
    }
    let Soup { corners, solids, ended } = read_text(BufReader::with_capacity(1 << 16, file), limits)?;
    let mut warnings = Vec::new();
    if !ended && !corners.is_empty() {
        warnings.push("the file has no `endsolid`: its end may be missing".to_owned());
    }
    if solids > 1 {
        warnings.push(format!("the file holds {solids} solids; they are one part of {} triangles", corners.len() / 3));
    }
    Ok(StlSoup { corners, warnings })
}

/// Reads binary; `len` is the file's size. Never allocates by the count alone: the size has to agree with it first.
pub(super) fn read_binary(mut file: File, head: &[u8], len: u64, limits: &Limits) -> Result<StlSoup, ReadError> {
    let count = claimed_count(head)
        .ok_or_else(|| ReadError::Truncated(format!("{len} bytes are too few for a binary STL header")))?;
    let wanted = binary_len(count);
    if wanted > len {
        let present = (len - HEAD) / FACET;
        let reason = format!("{present} of {count} triangles are there");
        return Err(ReadError::Truncated(reason));
    }
    if count > limits.max_triangles {
        return Err(ReadError::TooLarge {
            what: format!("it has {count} triangles"),
            limit: limits.max_triangles,
            key: "max_triangles",
        });
    }
    let mut warnings = Vec::new();
    if len > wanted {
        check_trailer(&mut file, wanted, len - wanted, count)?;
        warnings.push(format!(
            "{} ignored",
            counted(len - wanted, "byte after the last triangle is", "bytes after the last triangle are")
        ));
    }
    let mut neutral = NeutralHeader { file, at: 0 };
    neutral.seek(SeekFrom::Start(0))?;
    let mut corners = Vec::with_capacity(3 * count as usize);
    for triangle in stl_io::create_stl_reader(&mut neutral)? {
        for corner in triangle?.vertices {
            corners.push(DVec3::from_array(corner.0.map(f64::from)));
        }
    }
    Ok(StlSoup { corners, warnings })
}

/// A trailer that is made of whole facets and not of zeros is geometry which the count denies: not to be lost silently.
fn check_trailer(file: &mut File, at: u64, length: u64, count: u64) -> Result<(), ReadError> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    file.take(length.min(TRAILER)).read_to_end(&mut bytes)?;
    if count > 0 && length.is_multiple_of(FACET) && bytes.iter().any(|&b| b != 0) {
        let more = length / FACET;
        return Err(ReadError::stl(format!("{count} triangles are counted, but {more} more follow")));
    }
    Ok(())
}

/// Shows `stl_io` a header that cannot be taken for ASCII: it would parse a binary file as text whose header starts with
/// `solid `, and looks for the end of the first line without a bound.
struct NeutralHeader {
    file: File,
    at: u64,
}

impl Read for NeutralHeader {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let got = self.file.read(out)?;
        let masked = 80_u64.saturating_sub(self.at).min(got as u64) as usize;
        out[..masked].fill(b'\n');
        self.at += got as u64;
        Ok(got)
    }
}

impl Seek for NeutralHeader {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.at = self.file.seek(to)?;
        Ok(self.at)
    }
}
