//! Decides whether a fired build gets a final search, of which length, and what follows a search that failed. These are
//! functions of facts.

use build_file::format_count;
use ledger::BuildId;

use super::{layout_search::SearchCutShort, write_build::UnprovedBuildError};
use crate::alerts::failure::{PartFault, is_disk_failure};

/// A build that was started this many times without an end is given up, whatever ended the daemon each time.
const MAX_STARTS: u32 = 200;
/// The time of a search is halved at most so often.
const MAX_HALVINGS: u32 = 10;

/// What is known of a fired build before a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AttemptFacts {
    /// Its number.
    pub(crate) build: BuildId,
    /// Attempts that were begun, with this one.
    pub(crate) attempts: u32,
    /// Attempts of this run that failed.
    pub(crate) failures: u32,
    /// Attempts that may fail before the build is given up.
    pub(crate) max_attempts: u32,
    /// Time of the first search, seconds.
    pub(crate) final_secs: f64,
    /// Seconds that it was searched before the daemon stopped.
    pub(crate) searched_secs: f64,
    /// Seed of the profile.
    pub(crate) seed: u64,
}

/// What happens with a fired build.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum AttemptDecision {
    /// It failed too often.
    GiveUp,
    /// It is searched for so many seconds with this seed.
    Search {
        /// Time of the search, seconds.
        secs: f64,
        /// Seed of the search.
        seed: u64,
    },
}

/// Decides whether a build is searched once more. Each further attempt gets half the time, so that one finishes even if
/// crashes interrupt attempts; what stops before took of it is not searched again.
pub(crate) fn decide_attempt(facts: &AttemptFacts) -> AttemptDecision {
    if facts.failures >= facts.max_attempts || facts.attempts > MAX_STARTS {
        return AttemptDecision::GiveUp;
    }
    let earlier = facts.attempts.saturating_sub(1);
    AttemptDecision::Search {
        secs: (facts.final_secs / f64::from(1_u32 << earlier.min(MAX_HALVINGS)) - facts.searched_secs).max(0.0),
        seed: facts.seed.wrapping_add(facts.build.0.unsigned_abs()).wrapping_add(u64::from(earlier) << 32),
    }
}

/// Why a build is given up: after so many attempts, of which `failed` says how many of this run failed, and how the last one did.
pub(crate) fn give_up_reason(attempts: u32, failed: Option<&(u32, String)>) -> String {
    match failed {
        Some((failures, last)) => {
            format!("gave up after {}: {last}", format_count(*failures, "failed attempt", "failed attempts"))
        }
        None => format!("gave up after {attempts} attempts: nestd stopped each time"),
    }
}

/// Not one copy of a build found a place, each of which was tried in the empty machine.
#[derive(Debug, thiserror::Error)]
#[error("none of its copies has a place in the machine as it is now")]
pub(crate) struct NoPlaceError;

/// What follows a final search that failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FailedSearch {
    /// It was stopped, or the daemon is: the next start goes on with the build.
    LeaveForNextStart,
    /// A stored file is lost, or a part has another size than when it was first read: the build goes on without it.
    ContinueWithoutPart,
    /// The disk failed: the build is tried again, and this was no attempt.
    RetryLater,
    /// None of its copies has a place in the machine, and no other attempt finds one.
    GiveUp,
    /// The build failed: this was an attempt.
    CountAttempt {
        /// The written build could not be proved.
        is_unproved: bool,
    },
}

/// Decides what follows a final search that failed.
pub(crate) fn classify_failure(failure: &anyhow::Error, is_stopping: bool) -> FailedSearch {
    if is_stopping || failure.is::<SearchCutShort>() {
        FailedSearch::LeaveForNextStart
    } else if PartFault::find_in_chain(failure).is_some() {
        FailedSearch::ContinueWithoutPart
    } else if is_disk_failure(failure) {
        FailedSearch::RetryLater
    } else if failure.is::<NoPlaceError>() {
        FailedSearch::GiveUp
    } else {
        FailedSearch::CountAttempt { is_unproved: failure.is::<UnprovedBuildError>() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alerts::failure::LostFileError;

    const FACTS: AttemptFacts = AttemptFacts {
        build: BuildId(7),
        attempts: 1,
        failures: 0,
        max_attempts: 3,
        final_secs: 60.0,
        searched_secs: 0.0,
        seed: 1,
    };

    #[test]
    fn each_attempt_has_half_the_time_and_another_seed() {
        assert_eq!(decide_attempt(&FACTS), AttemptDecision::Search { secs: 60.0, seed: 8 });
        let third = AttemptFacts { attempts: 3, ..FACTS };
        assert_eq!(decide_attempt(&third), AttemptDecision::Search { secs: 15.0, seed: 8 + (2 << 32) });
        let left = AttemptFacts { searched_secs: 20.0, ..FACTS };
        assert_eq!(decide_attempt(&left), AttemptDecision::Search { secs: 40.0, seed: 8 });
        let over = AttemptFacts { attempts: 2, searched_secs: 40.0, ..FACTS };
        assert!(matches!(decide_attempt(&over), AttemptDecision::Search { secs: 0.0, .. }));
        let many = AttemptFacts { attempts: 150, ..FACTS };
        assert!(matches!(decide_attempt(&many), AttemptDecision::Search { secs, .. } if secs == 60.0 / 1024.0));
    }

    #[test]
    fn a_build_that_failed_too_often_or_never_ends_is_given_up() {
        assert_eq!(decide_attempt(&AttemptFacts { failures: 3, ..FACTS }), AttemptDecision::GiveUp);
        assert_ne!(decide_attempt(&AttemptFacts { attempts: 200, ..FACTS }), AttemptDecision::GiveUp);
        assert_eq!(decide_attempt(&AttemptFacts { attempts: 201, ..FACTS }), AttemptDecision::GiveUp);
    }

    #[test]
    fn only_a_fault_of_the_build_counts_as_an_attempt() {
        let full_disk = || anyhow::Error::from(std::io::Error::from_raw_os_error(28));
        let lost = LostFileError { name: "a.stl".to_owned(), content_hash: "aa".to_owned(), aside: None };
        assert_eq!(classify_failure(&full_disk(), true), FailedSearch::LeaveForNextStart);
        assert_eq!(classify_failure(&full_disk(), false), FailedSearch::RetryLater);
        assert_eq!(classify_failure(&anyhow::Error::from(lost), false), FailedSearch::ContinueWithoutPart);
        let other = anyhow::anyhow!("its parts are locked");
        assert_eq!(classify_failure(&other, false), FailedSearch::CountAttempt { is_unproved: false });
        assert_eq!(classify_failure(&NoPlaceError.into(), false), FailedSearch::GiveUp);
    }
}
