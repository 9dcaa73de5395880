//! Checks whether the end of a file is there: the farm waits for a half-copied drop.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
};

use super::sniff::{FileFormat, HEAD_BYTES, detect_format};
use crate::{
    common::{file_name::is_part_name, unfinished::ends_in_zero},
    polygons::ply_read::least_ply_bytes,
    stl::stl_read::{STL_FACET_BYTES, STL_HEAD_BYTES, binary_len, claimed_count},
    threemf::package::{MAX_END, end_record},
};

/// Length of the file's end that is searched for the last `endsolid`; a name and white space may follow it.
const TEXT_TAIL: u64 = 1 << 16;

/// Whether the file has the end that its format promises: a binary STL is 84 + 50 n bytes or longer, and its last triangle
/// is not all zeros; an ASCII STL has its `endsolid`, and no zeros behind it; a 3MF its end-of-central-directory record; an OBJ ends with
/// its last line; a PLY is no shorter than its head says.
/// Returns `true` for any other file, since reading will refuse it. Only the head and the tail are read. A file with a
/// wrong length field never has its end, so the caller must limit the wait.
pub fn has_end(opened: &mut File, name: &str) -> io::Result<bool> {
    let len = opened.metadata()?.len();
    let mut head = Vec::new();
    opened.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    if is_barely_begun(&head, name) {
        return Ok(false);
    }
    match detect_format(&head, len, name) {
        FileFormat::Package | FileFormat::Camspec => Ok(end_record(&read_tail(opened, len, MAX_END)?).is_some()),
        FileFormat::TextStl if ends_in_zero(opened, len)? => Ok(false),
        FileFormat::TextStl => {
            let tail = read_tail(opened, len, TEXT_TAIL)?;
            Ok(tail.windows(8).any(|w| w.eq_ignore_ascii_case(b"endsolid")))
        }
        FileFormat::BinaryStl => match claimed_count(&head).map(binary_len) {
            Some(end) if len >= end => Ok(!is_zero_facet(opened, end)?),
            _ => Ok(false),
        },
        FileFormat::Obj => Ok(matches!(read_tail(opened, len, 1)?[..], [b'\n' | b'\r'])),
        FileFormat::Ply => Ok(len >= least_ply_bytes(opened)?),
        FileFormat::Other(_) => Ok(true),
    }
}

/// Whether a file may hold a part: by its bytes, or by its name while there are no bytes yet.
pub fn may_be_part(opened: &mut File, name: &str) -> io::Result<bool> {
    let len = opened.metadata()?.len();
    let mut head = Vec::new();
    opened.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    Ok(is_barely_begun(&head, name) || !matches!(detect_format(&head, len, name), FileFormat::Other(_)))
}

/// Whether more may be written behind the end that a file has now: the format of an ASCII STL or an OBJ tells no length, and a program that
/// joins bodies writes one binary STL behind the other.
pub fn may_grow(opened: &mut File, name: &str) -> io::Result<bool> {
    let len = opened.metadata()?.len();
    let mut head = Vec::new();
    opened.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    Ok(matches!(detect_format(&head, len, name), FileFormat::TextStl | FileFormat::BinaryStl | FileFormat::Obj))
}

/// Whether the file has too few bytes, or is allocated but not yet written: it may still become a part.
fn is_barely_begun(head: &[u8], name: &str) -> bool {
    let prefix = |of: &[u8]| of.starts_with(&head.to_ascii_lowercase());
    is_part_name(name)
        && (head.iter().all(|&b| b == 0) || [&b"solid"[..], b"pk\x03\x04", b"ply\n"].into_iter().any(prefix))
}

/// Whether the facet before this end of a binary STL was never written.
fn is_zero_facet(file: &mut File, end: u64) -> io::Result<bool> {
    let mut facet = [0; STL_FACET_BYTES as usize];
    if end < STL_HEAD_BYTES + STL_FACET_BYTES {
        return Ok(false);
    }
    file.seek(SeekFrom::Start(end - STL_FACET_BYTES))?;
    file.read_exact(&mut facet)?;
    Ok(facet.iter().all(|&byte| byte == 0))
}

fn read_tail(file: &mut File, len: u64, at_most: u64) -> io::Result<Vec<u8>> {
    let length = len.min(at_most);
    file.seek(SeekFrom::Start(len - length))?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(bytes: &[u8], name: &str) -> bool {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        has_end(&mut File::open(file.path()).unwrap(), name).unwrap()
    }

    #[test]
    fn a_binary_stl_ends_with_its_last_facet() {
        let mut bytes = vec![b'x'; 80];
        bytes.extend(2_u32.to_le_bytes());
        bytes.extend([7; 100]);
        for cut in [0, 3, 40, 84, 134, 183] {
            assert!(!ends(&bytes[..cut], "a.stl"), "{cut}");
        }
        assert!(ends(&bytes, "a.STL"));
        bytes.push(0);
        assert!(ends(&bytes, "a.stl"));
    }

    #[test]
    fn an_ascii_stl_ends_with_endsolid() {
        let text = format!("solid a\n{}EndSolid a\n", "facet normal 0 0 1\n".repeat(9));
        assert!(ends(text.as_bytes(), "a.stl"));
        for cut in [2, 5, 60, text.len() - 12] {
            assert!(!ends(&text.as_bytes()[..cut], "a.stl"), "{cut}");
        }
    }

    #[test]
    fn a_package_ends_with_its_end_record() {
        let mut bytes = b"PK\x03\x04 entries PK\x05\x06".to_vec();
        bytes.extend([0; 18]);
        assert!(ends(&bytes, "a.3mf"));
        for cut in [1, 4, 10, bytes.len() - 1] {
            assert!(!ends(&bytes[..cut], "a.3mf"), "{cut}");
        }
    }

    #[test]
    fn a_file_allocated_but_not_written_has_no_end() {
        assert!(!ends(&[0; 4096], "a.stl") && !ends(&[0; 4096], "a.3mf"));
    }

    #[test]
    fn a_file_that_will_be_refused_is_not_waited_for() {
        assert!(ends(b"version https://git-lfs.github.com/spec/v1\n", "a.stl"));
        assert!(ends(b"OFF\n8 6 0", "a.off") && ends(b"hello", "readme.txt") && ends(b"", "empty.txt"));
    }
}
