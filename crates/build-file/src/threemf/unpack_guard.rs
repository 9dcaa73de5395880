//! Sits between a package entry and the XML reader and limits: unpacked bytes, bytes of the current token, and the
//! compression ratio.

use std::io::{self, BufRead, Read};

use crate::FileReadError;

/// No tag, text or comment of a valid file is longer.
const MAX_TOKEN_BYTES: u64 = 1 << 20;
/// Meshes compress about tenfold; an entry of a package with a higher ratio than this is a zip bomb.
pub const MAX_RATIO: u64 = 200;
/// Entries that unpack to no more bytes may have any compression ratio.
pub const RATIO_FREE_BYTES: u64 = 16 << 20;

/// A reader that stops when a limit is exceeded.
pub(crate) struct UnpackGuard<R> {
    inner: R,
    packed: u64,
    unpacked: u64,
    budget: u64,
    limit: u64,
    token: u64,
    /// The reason why it stopped.
    refusal: Option<FileReadError>,
}

impl<R> UnpackGuard<R> {
    /// `packed` is the size of the entry in the file. `budget` is what remains of the package's `limit` of unpacked
    /// bytes.
    pub(crate) fn new(inner: R, packed: u64, budget: u64, limit: u64) -> Self {
        Self { inner, packed, unpacked: 0, budget, limit, token: 0, refusal: None }
    }

    /// The next token begins.
    pub(super) fn start_token(&mut self) {
        self.token = 0;
    }

    pub(super) fn unpacked_bytes(&self) -> u64 {
        self.unpacked
    }

    pub(super) fn take_refusal(&mut self) -> Option<FileReadError> {
        self.refusal.take()
    }

    fn check_limits(&mut self) -> io::Result<()> {
        let reason = if self.unpacked > self.budget {
            FileReadError::TooLarge {
                what: "the unpacked package has too many bytes".to_owned(),
                limit: self.limit,
                key: "max_unpacked_bytes",
            }
        } else if self.token > MAX_TOKEN_BYTES {
            FileReadError::invalid_threemf(format!("an XML token is longer than {MAX_TOKEN_BYTES} bytes"))
        } else if self.unpacked > RATIO_FREE_BYTES && self.unpacked / MAX_RATIO > self.packed {
            FileReadError::invalid_threemf(format!("an entry unpacks to more than {MAX_RATIO} times its size"))
        } else {
            return Ok(());
        };
        self.refusal = Some(reason);
        Err(io::Error::other("a limit of the package reader is passed"))
    }
}

impl<R: BufRead> BufRead for UnpackGuard<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.check_limits()?;
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.unpacked += amount as u64;
        self.token += amount as u64;
        self.inner.consume(amount);
    }
}

impl<R: BufRead> Read for UnpackGuard<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let got = self.fill_buf()?.read(out)?;
        self.consume(got);
        Ok(got)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(mut guard: UnpackGuard<impl BufRead>) -> String {
        io::copy(&mut guard, &mut io::sink()).unwrap_err();
        guard.take_refusal().unwrap().to_string()
    }

    #[test]
    fn each_budget_stops_the_reader() {
        let endless = || io::BufReader::new(io::repeat(b' '));
        assert!(refusal(UnpackGuard::new(endless(), u64::MAX, u64::MAX, 1)).contains("token"));
        assert!(refusal(UnpackGuard::new(endless(), u64::MAX, 1000, 1000)).contains("unpacked"));
        let mut guard = UnpackGuard::new(endless(), 10, u64::MAX, 1);
        guard.unpacked = RATIO_FREE_BYTES;
        assert!(refusal(guard).contains("times its size"));
    }
}
