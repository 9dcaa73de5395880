//! Reads STL, binary and ASCII, as triangle soup. The file's size decides whether it is binary, not the header: every
//! seventh binary file starts with `solid`.

use std::{
    fs::File,
    io::{BufReader, Read, Seek, SeekFrom},
};

use glam::DVec3;

use super::{
    FileReadError, ReadLimits, format_count,
    stl_text::{TextStlContents, read_text_stl},
};

/// Bytes before the first facet: an 80-byte header and the count.
pub(super) const STL_HEAD_BYTES: u64 = 84;
/// Bytes of a facet.
pub(super) const STL_FACET_BYTES: u64 = 50;
/// Bytes of a trailer that are checked.
const MAX_TRAILER_BYTES: u64 = 1 << 16;

/// Three corners per triangle in the file's unit, and warnings for people.
#[derive(Debug)]
pub(super) struct StlTriangleSoup {
    pub(super) corners: Vec<DVec3>,
    pub(super) warnings: Vec<String>,
}

/// The triangle count that a binary STL declares.
pub(super) fn claimed_count(head: &[u8]) -> Option<u64> {
    let bytes: [u8; 4] = head.get(80..84)?.try_into().ok()?;
    Some(u32::from_le_bytes(bytes).into())
}

/// Bytes of a binary STL with `count` facets.
pub(super) fn binary_len(count: u64) -> u64 {
    STL_HEAD_BYTES + STL_FACET_BYTES * count
}

/// Reads ASCII.
pub(super) fn read_ascii(mut file: File, limits: &ReadLimits) -> Result<StlTriangleSoup, FileReadError> {
    let mut mark = [0; 3];
    let got = file.read(&mut mark)?;
    if mark[..got] != *b"\xef\xbb\xbf" {
        file.seek(SeekFrom::Start(0))?;
    }
    let TextStlContents { corners, solids, ended } = read_text_stl(BufReader::with_capacity(1 << 16, file), limits)?;
    let mut warnings = Vec::new();
    if !ended && !corners.is_empty() {
        warnings.push("the file has no `endsolid`: its end may be missing".to_owned());
    }
    if solids > 1 {
        warnings.push(format!("the file holds {solids} solids; they are one part of {} triangles", corners.len() / 3));
    }
    Ok(StlTriangleSoup { corners, warnings })
}

/// Reads binary STL; `len` is the file's size. Memory is allocated only after the size was found to match the count.
pub(super) fn read_binary(
    mut file: File,
    head: &[u8],
    len: u64,
    limits: &ReadLimits,
) -> Result<StlTriangleSoup, FileReadError> {
    let count = claimed_count(head)
        .ok_or_else(|| FileReadError::Truncated(format!("{len} bytes are too few for a binary STL header")))?;
    let wanted = binary_len(count);
    if wanted > len {
        let present = (len - STL_HEAD_BYTES) / STL_FACET_BYTES;
        let reason = format!("only {present} of {count} triangles are in the file");
        return Err(FileReadError::Truncated(reason));
    }
    if count > limits.max_triangles {
        return Err(FileReadError::TooLarge {
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
            format_count(len - wanted, "byte after the last triangle is", "bytes after the last triangle are")
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
    Ok(StlTriangleSoup { corners, warnings })
}

/// Refuses a trailer that consists of whole facets and not only of zeros: it is geometry that the count omits, and it
/// must not be lost silently.
fn check_trailer(file: &mut File, at: u64, length: u64, count: u64) -> Result<(), FileReadError> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    file.take(length.min(MAX_TRAILER_BYTES)).read_to_end(&mut bytes)?;
    if count > 0 && length.is_multiple_of(STL_FACET_BYTES) && bytes.iter().any(|&b| b != 0) {
        let more = length / STL_FACET_BYTES;
        return Err(FileReadError::invalid_stl(format!("{count} triangles are counted, but {more} more follow")));
    }
    Ok(())
}

/// Hides the header from `stl_io`. It would parse a binary file as text if the header starts with `solid `, and it
/// searches for the end of the first line without a limit.
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
