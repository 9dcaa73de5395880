//! Decides how long an open build that waits is searched next, and when that is not worth its time any more. These are
//! functions of facts.

use ledger::{NightSearchRow, NightState};

/// A round that gains less than this share of the height is the last one: the next one would take twice as long.
const LEAST_GAIN: f64 = 0.003;
/// Maximum time of one search, CPU seconds: if the daemon is killed, that is what is lost.
const MAX_SEARCH_SECS: f64 = 300.0;
/// After this many searches without an end they may be what ends the daemon.
pub(crate) const MAX_STARTS: u32 = 3;
/// A search that takes less than this share of its time knows that no lower layout exists.
const EARLY_END_SHARE: f64 = 0.5;
/// No search takes less than this share of the time of the first round: it must end with something.
const LEAST_SEARCH_SHARE: f64 = 0.1;
/// Most doublings of the time of a round.
const MAX_DOUBLINGS: u32 = 30;

/// How a search has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NightSearchEnd {
    /// The time that it had, CPU seconds.
    pub(crate) asked_secs: f64,
    /// The time that it took, CPU seconds.
    pub(crate) cpu_secs: f64,
    /// Height of the layout now, mm.
    pub(crate) height_mm: f64,
    /// Whether it was stopped, because something else needed the thread.
    pub(crate) is_stopped: bool,
}

/// How far the search is before it has begun. `problem` names the copies and rules that it is for.
pub(crate) fn begin_night(problem: String, height_mm: f64) -> NightSearchRow {
    NightSearchRow {
        problem,
        state: NightState::GoesOn,
        round: 0,
        round_cpu_secs: 0.0,
        round_height_mm: height_mm,
        cpu_secs: 0.0,
        first_height_mm: height_mm,
        starts: 0,
        pool: "[]".to_owned(),
    }
}

/// Time that is left of the round, CPU seconds; negative where the round has taken more than its time. The first round
/// takes `first_secs`.
fn round_secs_left(row: &NightSearchRow, first_secs: f64) -> f64 {
    first_secs * f64::from(1_u32 << row.round.min(MAX_DOUBLINGS)) - row.round_cpu_secs
}

/// The time of the next search, CPU seconds, or the state in which there is none. All rounds together may take
/// `improve_secs`.
pub(crate) fn decide_search(row: &NightSearchRow, first_secs: f64, improve_secs: f64) -> Result<f64, NightState> {
    let left_secs = improve_secs - row.cpu_secs;
    match row.state {
        NightState::StandsStill | NightState::GivenUp => Err(row.state),
        _ if row.starts >= MAX_STARTS => Err(NightState::GivenUp),
        _ if left_secs <= 0.0 => Err(NightState::UsedUp),
        _ => {
            let secs = round_secs_left(row, first_secs).max(LEAST_SEARCH_SHARE * first_secs);
            Ok(secs.min(left_secs).min(MAX_SEARCH_SECS))
        }
    }
}

/// How far the search is after one that ended. A round ends when it has taken its time.
pub(crate) fn count_search(mut row: NightSearchRow, end: &NightSearchEnd, first_secs: f64) -> NightSearchRow {
    let is_last = end.asked_secs >= round_secs_left(&row, first_secs);
    row.cpu_secs += end.cpu_secs;
    row.round_cpu_secs += end.cpu_secs;
    row.starts = 0;
    if end.is_stopped || !(is_last || end.cpu_secs < EARLY_END_SHARE * end.asked_secs) {
        return row;
    }
    if end.height_mm > (1.0 - LEAST_GAIN) * row.round_height_mm {
        row.state = NightState::StandsStill;
    }
    (row.round, row.round_cpu_secs, row.round_height_mm) = (row.round + 1, 0.0, end.height_mm);
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A search of a row that takes the time that it gets, and reaches a height.
    fn searched(row: NightSearchRow, height_mm: f64) -> NightSearchRow {
        let secs = decide_search(&row, 20.0, 3600.0).expect("goes on");
        let end = NightSearchEnd { asked_secs: secs, cpu_secs: secs, height_mm, is_stopped: false };
        count_search(row, &end, 20.0)
    }

    fn fresh() -> NightSearchRow {
        begin_night("a".to_owned(), 100.0)
    }

    #[test]
    fn rounds_double_until_the_time_is_used_up_and_no_search_is_long() {
        let (mut row, mut asked) = (fresh(), Vec::new());
        while let Ok(secs) = decide_search(&row, 20.0, 1000.0) {
            asked.push(secs);
            let height_mm = row.round_height_mm * 0.99;
            let end = NightSearchEnd { asked_secs: secs, cpu_secs: secs, height_mm, is_stopped: false };
            row = count_search(row, &end, 20.0);
        }
        assert_eq!(asked, [20.0, 40.0, 80.0, 160.0, 300.0, 20.0, 300.0, 80.0]);
        assert_eq!(row.cpu_secs, 1000.0);
        assert_eq!(decide_search(&row, 20.0, 1000.0), Err(NightState::UsedUp));
        assert!(decide_search(&row, 20.0, 1001.0).is_ok(), "more time was allowed since");
        assert_eq!(decide_search(&fresh(), 20.0, 0.0), Err(NightState::UsedUp));
    }

    #[test]
    fn a_round_that_gains_too_little_is_the_last_one() {
        let row = searched(searched(fresh(), 99.6), 99.31);
        assert_eq!((row.state, row.round, row.first_height_mm), (NightState::StandsStill, 2, 100.0));
        assert_eq!(decide_search(&row, 20.0, 3600.0), Err(NightState::StandsStill));
        // Its end in a search of many counts for the whole round.
        let mut long = NightSearchRow { round: 4, ..fresh() };
        long = searched(long, 99.9);
        assert_eq!((long.state, long.round), (NightState::GoesOn, 4));
        assert_eq!(searched(long, 99.9).state, NightState::StandsStill);
    }

    #[test]
    fn a_search_that_is_stopped_ends_no_round() {
        let end = NightSearchEnd { asked_secs: 20.0, cpu_secs: 15.0, height_mm: 100.0, is_stopped: true };
        let row = count_search(fresh(), &end, 20.0);
        assert_eq!((row.state, row.round, row.cpu_secs), (NightState::GoesOn, 0, 15.0));
        assert_eq!(decide_search(&row, 20.0, 3600.0), Ok(5.0));
        assert_eq!(searched(row, 100.0).state, NightState::StandsStill);
    }

    #[test]
    fn a_round_that_has_taken_more_than_its_time_ends_with_a_short_search() {
        // It was stopped late, or `arrival_secs` is shorter since.
        let row = searched(NightSearchRow { round: 5, round_cpu_secs: 900.0, cpu_secs: 900.0, ..fresh() }, 98.0);
        assert_eq!((row.state, row.round, row.round_cpu_secs, row.cpu_secs), (NightState::GoesOn, 6, 0.0, 902.0));
    }

    #[test]
    fn a_layout_that_cannot_be_lower_and_one_that_ends_the_daemon_are_let_be() {
        let end = NightSearchEnd { asked_secs: 300.0, cpu_secs: 0.1, height_mm: 100.0, is_stopped: false };
        assert_eq!(count_search(NightSearchRow { round: 6, ..fresh() }, &end, 20.0).state, NightState::StandsStill);
        let started = |starts| decide_search(&NightSearchRow { starts, ..fresh() }, 20.0, 3600.0);
        assert_eq!((started(2), started(3)), (Ok(20.0), Err(NightState::GivenUp)));
    }
}
