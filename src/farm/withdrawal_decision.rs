//! Decides whether nestd takes a published build back out of the queue by itself. This is a function of facts.

use jiff::{SignedDuration, Timestamp};

use super::{left_out::HIGHEST_PRIORITY, trigger::secs_between};
use crate::{
    ledger::WaitingPart,
    settings::{MachineProfile, WithdrawalPolicy},
};

/// Beside the time that the next final search takes, this long must pass before the printer could take the file, seconds: a
/// printer never waits for a better build.
const LEAD_SECS: f64 = 900.0;

/// What is known of the newest build in the queue, of its printer, and of the copies that wait.
#[derive(Debug, Clone, Copy)]
pub(super) struct WithdrawalFacts<'a> {
    /// When the build was published.
    pub(super) published_at: Timestamp,
    /// Its height, mm.
    pub(super) height_mm: f64,
    /// When its printer could begin to print it.
    pub(super) printer_free_at: Timestamp,
    /// The waiting parts.
    pub(super) waiting: &'a [WaitingPart],
    /// The height of the open build, mm; `None` = its layout does not hold all waiting copies.
    pub(super) open_height_mm: Option<f64>,
    /// Whether the machine is paused, or makes another build: that one may take what waits.
    pub(super) is_hindered: bool,
}

/// Why the build is taken back; `None` = it stays.
pub(super) fn decide_withdrawal(
    profile: &MachineProfile,
    facts: &WithdrawalFacts<'_>,
    now: Timestamp,
) -> Option<&'static str> {
    let policy = profile.printing.withdraw;
    if policy == WithdrawalPolicy::Never || facts.is_hindered {
        return None;
    }
    // What waited when it was published found no place in it.
    let arrived = facts.waiting.iter().filter(|waiting| waiting.part.arrived_at().0 > facts.published_at);
    let mut arrived = arrived.peekable();
    let newest = arrived.peek()?.part.arrived_at().0;
    let (mut newest, mut is_urgent) = (newest, false);
    for waiting in arrived {
        newest = newest.max(waiting.part.arrived_at().0);
        is_urgent |= waiting.part.terms.priority == HIGHEST_PRIORITY;
    }
    if is_urgent {
        return Some("copies of the highest priority go with it");
    }
    let lead_secs = LEAD_SECS + 2.0 * profile.search.final_secs;
    let lead = SignedDuration::try_from_secs_f64(lead_secs).unwrap_or(SignedDuration::MAX);
    let has_time = now.checked_add(lead).is_ok_and(|ready| ready < facts.printer_free_at);
    let has_gathered = secs_between(newest, now) >= profile.trigger.gather_secs;
    let fits = |open_mm: f64| open_mm > 0.0 && open_mm + facts.height_mm <= profile.build_volume().size_mm.z;
    let is_worth_it = has_time && has_gathered && facts.open_height_mm.is_some_and(fits);
    (policy == WithdrawalPolicy::Always && is_worth_it).then_some("copies that arrived go with it")
}

#[cfg(test)]
mod tests {
    use super::{super::trigger::tests::machine_with_triggers, *};
    use crate::ledger::fixtures::{fresh, waiting};

    fn at(hour: i64) -> Timestamp {
        Timestamp::UNIX_EPOCH + SignedDuration::from_hours(hour)
    }

    /// A part that arrived at eight.
    async fn part(priority: u8) -> WaitingPart {
        let kept = fresh().await;
        let ledger = kept.ledger.clone().with_clock(|| at(8));
        waiting(&ledger, "a", 1).await;
        let mut part = ledger.waiting_copies("paper-200").await.unwrap().remove(0);
        part.part.terms.priority = priority;
        part
    }

    #[tokio::test]
    async fn a_build_is_taken_back_for_what_arrived_after_it_and_only_while_its_printer_prints_for_long() {
        let mut profile = machine_with_triggers("gather_secs = \"15m\"\n");
        let (usual, urgent) = ([part(50).await], [part(HIGHEST_PRIORITY).await]);
        let facts = WithdrawalFacts {
            published_at: at(7),
            height_mm: 40.0,
            printer_free_at: at(20),
            waiting: &usual,
            open_height_mm: Some(30.0),
            is_hindered: false,
        };
        let is_withdrawn = |profile: &MachineProfile, facts: WithdrawalFacts<'_>, now: i64| {
            decide_withdrawal(profile, &facts, at(now)).is_some()
        };
        let hurry = WithdrawalFacts { waiting: &urgent, open_height_mm: None, printer_free_at: at(9), ..facts };
        assert!(!is_withdrawn(&profile, facts, 9) && !is_withdrawn(&profile, hurry, 9), "never");
        profile.printing.withdraw = WithdrawalPolicy::Urgent;
        assert!(!is_withdrawn(&profile, facts, 9) && is_withdrawn(&profile, hurry, 9));
        assert!(!is_withdrawn(&profile, WithdrawalFacts { is_hindered: true, ..hurry }, 9), "another build takes it");
        assert!(!is_withdrawn(&profile, WithdrawalFacts { published_at: at(9), ..hurry }, 9), "it found no place");
        profile.printing.withdraw = WithdrawalPolicy::Always;
        assert!(is_withdrawn(&profile, facts, 9) && is_withdrawn(&profile, hurry, 9));
        assert!(!is_withdrawn(&profile, facts, 8), "more may arrive");
        for held in [
            WithdrawalFacts { published_at: at(9), ..facts },
            WithdrawalFacts { printer_free_at: at(9), ..facts },
            WithdrawalFacts { open_height_mm: Some(70.0), ..facts },
            WithdrawalFacts { open_height_mm: None, ..facts },
            WithdrawalFacts { waiting: &[], ..facts },
        ] {
            assert!(!is_withdrawn(&profile, held, 9), "{held:?}");
        }
    }
}
