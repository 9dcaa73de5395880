//! Reads STL, binary and ASCII, as a welded surface. The file's size decides whether it is binary, not the header: every
//! seventh binary file starts with `solid`.

use std::{
    fs::File,
    io::{BufReader, Read, Seek, SeekFrom},
};

use glam::{DVec3, Vec3};

use super::stl_text::{TextStlContents, read_text_stl};
use crate::{
    FileReadError, LengthUnit, ReadLimits,
    common::{
        solid::WeldedSurface,
        unfinished::{ends_in_zero, unfinished_copy},
    },
    format_count,
};

/// Bytes before the first facet: an 80-byte header and the count.
pub(crate) const STL_HEAD_BYTES: u64 = 84;
/// Bytes of a facet.
pub(crate) const STL_FACET_BYTES: u64 = 50;
/// Bytes of a trailer that are checked.
const MAX_TRAILER_BYTES: u64 = 1 << 16;

/// Facets that are read at once.
const FACETS_PER_READ: usize = 2000;

/// The surface of a file, and warnings for people.
#[derive(Debug)]
pub(crate) struct StlContents {
    pub(crate) surface: WeldedSurface,
    pub(crate) warnings: Vec<String>,
}

/// The triangle count that a binary STL declares.
pub(crate) fn claimed_count(head: &[u8]) -> Option<u64> {
    let bytes: [u8; 4] = head.get(80..84)?.try_into().ok()?;
    Some(u32::from_le_bytes(bytes).into())
}

/// Bytes of a binary STL with `count` facets.
pub(crate) fn binary_len(count: u64) -> u64 {
    STL_HEAD_BYTES + STL_FACET_BYTES * count
}

/// Reads ASCII.
pub(crate) fn read_ascii(mut file: File, unit: LengthUnit, limits: &ReadLimits) -> Result<StlContents, FileReadError> {
    let len = file.metadata()?.len();
    if ends_in_zero(&mut file, len)? {
        return Err(unfinished_copy("which ends in zeros"));
    }
    file.seek(SeekFrom::Start(0))?;
    let mut mark = [0; 3];
    let got = file.read(&mut mark)?;
    if mark[..got] != *b"\xef\xbb\xbf" {
        file.seek(SeekFrom::Start(0))?;
    }
    let mut surface = WeldedSurface::new("STL", unit, 0);
    let input = BufReader::with_capacity(1 << 16, file);
    let TextStlContents { facets, solids, ended } =
        read_text_stl(input, limits, &mut |corners| surface.add_triangle(corners))?;
    let mut warnings = Vec::new();
    if !ended && facets > 0 {
        warnings.push("the file has no `endsolid`: its end may be missing".to_owned());
    }
    if solids > 1 {
        warnings.push(format!("the file holds {solids} solids; they are one part of {facets} triangles"));
    }
    Ok(StlContents { surface, warnings })
}

/// Reads binary STL; `len` is the file's size and `head` its first bytes. Memory is allocated only after the size was found to match the count.
pub(crate) fn read_binary(
    mut file: File,
    (head, len): (&[u8], u64),
    unit: LengthUnit,
    limits: &ReadLimits,
) -> Result<StlContents, FileReadError> {
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
        check_trailer(&mut file, wanted, len - wanted, (count, limits))?;
        let (one, several) = ("byte after the last triangle is ignored", "bytes after the last triangle are ignored");
        warnings.push(format_count(len - wanted, one, several));
    }
    file.seek(SeekFrom::Start(STL_HEAD_BYTES))?;
    let mut surface = WeldedSurface::new("STL", unit, count as usize);
    let mut bytes = vec![0; FACETS_PER_READ * STL_FACET_BYTES as usize];
    let mut left = (wanted - STL_HEAD_BYTES) as usize;
    while left > 0 {
        let piece = left.min(bytes.len());
        file.read_exact(&mut bytes[..piece])?;
        bytes[..piece].chunks_exact(STL_FACET_BYTES as usize).for_each(|facet| {
            let corners = facet_corners(facet);
            surface.zero_facets.add_facet(facet, corners == [DVec3::ZERO; 3]);
            surface.add_triangle(corners);
        });
        left -= piece;
    }
    Ok(StlContents { surface, warnings })
}

/// The corners of a facet: twelve numbers, of which the first three are a normal that is not trusted, and two bytes more.
pub(crate) fn facet_corners(facet: &[u8]) -> [DVec3; 3] {
    let number = |at: usize| f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]);
    [12, 24, 36].map(|at| Vec3::new(number(at), number(at + 4), number(at + 8)).as_dvec3())
}

/// Refuses a trailer that holds geometry, which must not be lost silently: whole facets, not only of zeros, that the count
/// omits, or another STL file, whole or cut off.
fn check_trailer(
    file: &mut File,
    at: u64,
    length: u64,
    (count, limits): (u64, &ReadLimits),
) -> Result<(), FileReadError> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    file.take(length.min(MAX_TRAILER_BYTES)).read_to_end(&mut bytes)?;
    let is_second = claimed_count(&bytes).is_some_and(|more| (1..=limits.max_triangles).contains(&more));
    if count > 0 && is_second {
        return Err(FileReadError::invalid_stl(format!("a second STL follows the {count} triangles of the first")));
    }
    let is_solid = |word: &[u8]| word.eq_ignore_ascii_case(b"solid");
    if count > 0 && bytes.trim_ascii_start().get(..5).is_some_and(is_solid) {
        return Err(FileReadError::invalid_stl(format!("an ASCII STL follows its {count} triangles")));
    }
    if count > 0 && length.is_multiple_of(STL_FACET_BYTES) && bytes.iter().any(|&b| b != 0) {
        let more = length / STL_FACET_BYTES;
        return Err(FileReadError::invalid_stl(format!("{count} triangles are counted, but {more} more follow")));
    }
    Ok(())
}
