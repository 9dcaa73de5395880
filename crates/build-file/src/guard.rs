//! Stands between a package entry and the XML reader and counts: bytes unpacked, bytes of the present token, and how much
//! larger they are than what is packed.

use std::io::{self, BufRead, Read};

use super::ReadError;

/// No tag, text or comment of an honest file is longer.
const MAX_TOKEN_BYTES: u64 = 1 << 20;
/// Mesh XML packs about tenfold; an entry that packs better than this is a bomb.
const MAX_RATIO: u64 = 200;
/// Small entries may pack as well as they like.
const RATIO_FREE_BYTES: u64 = 16 << 20;

/// A reader that refuses to go on when a budget is passed.
pub(super) struct Guard<R> {
    inner: R,
    packed: u64,
    unpacked: u64,
    budget: u64,
    limit: u64,
    token: u64,
    /// Why it refused.
    tripped: Option<ReadError>,
}

impl<R> Guard<R> {
    /// `packed` bytes lie in the file; `budget` may still be unpacked of the package's `limit`.
    pub(super) fn new(inner: R, packed: u64, budget: u64, limit: u64) -> Self {
        Self { inner, packed, unpacked: 0, budget, limit, token: 0, tripped: None }
    }

    /// The next token begins.
    pub(super) fn start_token(&mut self) {
        self.token = 0;
    }

    pub(super) fn unpacked(&self) -> u64 {
        self.unpacked
    }

    pub(super) fn take_tripped(&mut self) -> Option<ReadError> {
        self.tripped.take()
    }

    fn check(&mut self) -> io::Result<()> {
        let reason = if self.unpacked > self.budget {
            ReadError::TooLarge {
                what: "the unpacked package has too many bytes".to_owned(),
                limit: self.limit,
                key: "max_unpacked_bytes",
            }
        } else if self.token > MAX_TOKEN_BYTES {
            ReadError::threemf(format!("an XML token is longer than {MAX_TOKEN_BYTES} bytes"))
        } else if self.unpacked > RATIO_FREE_BYTES && self.unpacked / MAX_RATIO > self.packed {
            ReadError::threemf(format!("an entry unpacks to more than {MAX_RATIO} times its size"))
        } else {
            return Ok(());
        };
        self.tripped = Some(reason);
        Err(io::Error::other("a limit of the package reader is passed"))
    }
}

impl<R: BufRead> BufRead for Guard<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.check()?;
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.unpacked += amount as u64;
        self.token += amount as u64;
        self.inner.consume(amount);
    }
}

impl<R: BufRead> Read for Guard<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let got = self.fill_buf()?.read(out)?;
        self.consume(got);
        Ok(got)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(mut guard: Guard<impl BufRead>) -> String {
        io::copy(&mut guard, &mut io::sink()).unwrap_err();
        guard.take_tripped().unwrap().to_string()
    }

    #[test]
    fn each_budget_stops_the_reader() {
        let endless = || io::BufReader::new(io::repeat(b' '));
        assert!(refusal(Guard::new(endless(), u64::MAX, u64::MAX, 1)).contains("token"));
        assert!(refusal(Guard::new(endless(), u64::MAX, 1000, 1000)).contains("unpacked"));
        let mut guard = Guard::new(endless(), 10, u64::MAX, 1);
        guard.unpacked = RATIO_FREE_BYTES;
        assert!(refusal(guard).contains("times its size"));
    }
}
