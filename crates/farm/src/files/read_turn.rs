//! Decides whether a claimed part is read now. This is a pure function of the facts about the part and the running
//! reads.

use super::isolated_read::READS_IN_THE_DAEMON;

/// Maximum number of files read at once.
pub const READERS: usize = 2;

/// The facts that decide whether a claimed part is read now.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReadTurn {
    /// Number of reads of the part that were started.
    pub reads: u32,
    /// A disk failure stopped its last read a moment ago, and the part waits for a retry.
    pub is_resting: bool,
    /// A job still completes its claim or removes its stored file.
    pub is_ending: bool,
    /// The part is being read.
    pub is_being_read: bool,
    /// Number of files that are being read.
    pub readers: usize,
    /// Whether the file being read now has ended the process before.
    pub is_reader_alone: bool,
}

impl ReadTurn {
    /// Whether the part is read now. A file that has ended the process before is read alone, so that no other file can
    /// be the cause if the process ends again.
    pub fn has_come(&self) -> bool {
        let most = if self.reads >= READS_IN_THE_DAEMON { 1 } else { READERS };
        let is_hindered = self.is_resting || self.is_ending || self.is_being_read;
        !is_hindered && self.readers < most && !(self.is_reader_alone && self.readers > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_are_read_at_once_but_what_has_ended_the_process_is_read_alone() {
        let first = ReadTurn { reads: 1, ..ReadTurn::default() };
        assert!(first.has_come() && ReadTurn { readers: 1, ..first }.has_come());
        assert!(!ReadTurn { readers: READERS, ..first }.has_come());
        let suspect = ReadTurn { reads: READS_IN_THE_DAEMON, ..first };
        assert!(suspect.has_come() && !ReadTurn { readers: 1, ..suspect }.has_come());
        assert!(!ReadTurn { readers: 1, is_reader_alone: true, ..first }.has_come(), "nothing is read beside it");
        assert!(ReadTurn { is_reader_alone: true, ..first }.has_come(), "it has ended");
        for hindered in [
            ReadTurn { is_resting: true, ..first },
            ReadTurn { is_ending: true, ..first },
            ReadTurn { is_being_read: true, ..first },
        ] {
            assert!(!hindered.has_come());
        }
    }
}
