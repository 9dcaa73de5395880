//! Copies that stopped while their blocks were allocated already: what was not written reads as zeros.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    path::Path,
};

use crate::FileReadError;

/// File systems allocate blocks of this size, or of a multiple.
const BLOCK_BYTES: usize = 4096;
/// Blocks that are read at once.
const BLOCKS_PER_READ: usize = 64;

/// The error of an unfinished copy.
pub(crate) fn unfinished_copy(what: &str) -> FileReadError {
    FileReadError::Truncated(format!("it is an unfinished copy, {what}"))
}

/// Whether the last byte of a file is zero. Text and packages end otherwise.
pub(crate) fn ends_in_zero(file: &mut File, len: u64) -> io::Result<bool> {
    let mut last = [1];
    if len > 0 {
        file.seek(SeekFrom::Start(len - 1))?;
        file.read_exact(&mut last)?;
    }
    Ok(last[0] == 0)
}

/// Why a file cannot be read, where whole blocks of it were never written: that explains whatever else was found.
pub(crate) fn blame_unwritten_blocks(error: FileReadError, file: &Path) -> FileReadError {
    match error {
        FileReadError::Truncated(_) | FileReadError::Invalid { .. } | FileReadError::NoSolid { .. } => {
            match first_zero_block(file) {
                Ok(Some(at)) => unfinished_copy(&format!("with nothing but zeros from byte {at} on")),
                Ok(None) => error,
                Err(failure) => failure.into(),
            }
        }
        other => other,
    }
}

/// Where the first block of zeros begins.
fn first_zero_block(file: &Path) -> io::Result<Option<u64>> {
    let mut file = File::open(file)?;
    let (mut bytes, mut at) = (vec![0; BLOCKS_PER_READ * BLOCK_BYTES], 0);
    loop {
        let mut got = 0;
        while got < bytes.len() {
            match file.read(&mut bytes[got..])? {
                0 => break,
                more => got += more,
            }
        }
        let is_zero = |block: &[u8]| block.iter().all(|&byte| byte == 0);
        if let Some(found) = bytes[..got].chunks_exact(BLOCK_BYTES).position(is_zero) {
            return Ok(Some(at + (found * BLOCK_BYTES) as u64));
        }
        if got < bytes.len() {
            return Ok(None);
        }
        at += got as u64;
    }
}

/// Triangles of a binary STL whose bytes are all zero.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct ZeroFacets {
    facets: u64,
    run: u64,
    longest: u64,
    longest_end: u64,
}

impl ZeroFacets {
    /// So many in a row fill a block. No program was seen to write a single one.
    const MOST_IN_A_ROW: u64 = 79;
    /// A body has at least four triangles: fewer behind a closed surface miss nothing.
    const MOST_AT_THE_END: u64 = 3;

    /// Takes in the next facet; `is_at_origin` = all its corners are.
    pub(crate) fn add_facet(&mut self, facet: &[u8], is_at_origin: bool) {
        self.facets += 1;
        if !is_at_origin || facet.iter().any(|&byte| byte != 0) {
            self.run = 0;
            return;
        }
        self.run += 1;
        if self.run > self.longest {
            (self.longest, self.longest_end) = (self.run, self.facets);
        }
    }

    /// Refuses what was never written; `is_closed` = the other triangles are a closed surface.
    pub(super) fn check(&self, is_closed: bool) -> Result<(), FileReadError> {
        let count = self.facets;
        if self.run > Self::MOST_AT_THE_END || self.run > 0 && !is_closed {
            return Err(unfinished_copy(&format!("whose last {} of {count} triangles are zeros", self.run)));
        }
        if self.longest > Self::MOST_IN_A_ROW {
            let (first, last) = (self.longest_end - self.longest + 1, self.longest_end);
            return Err(unfinished_copy(&format!("whose triangles {first} to {last} of {count} are zeros")));
        }
        Ok(())
    }
}
