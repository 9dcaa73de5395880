//! Decides whether nestd takes a published build back out of the queue by itself. This is a function of facts.

use std::collections::BTreeSet;

use jiff::{SignedDuration, Timestamp};
use ledger::WaitingPart;
use settings::{ApprovalPolicy, MachineProfile, WithdrawalPolicy};

use super::{layout::CopyId, left_out::HIGHEST_PRIORITY, trigger::secs_between};

/// Beside the time that the next final search takes, this long must pass before the printer could take the file, seconds: a
/// printer never waits for a better build.
const LEAD_SECS: f64 = 900.0;
/// Parts of the highest priority that are dropped one after another gather for this long at most, seconds.
const URGENT_GATHER_SECS: f64 = 60.0;

/// What is known of the newest build in the queue, of its printer, and of the copies that wait.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WithdrawalFacts<'a> {
    /// When the copies of the build were taken: what was dropped later is not in it for that reason.
    pub(crate) fired_at: Timestamp,
    /// Its height, mm.
    pub(crate) height_mm: f64,
    /// When its printer could begin to print it.
    pub(crate) printer_free_at: Timestamp,
    /// The waiting parts.
    pub(crate) waiting: &'a [WaitingPart],
    /// The copies that stand in the open build; `None` = its layout is not of the copies that wait now.
    pub(crate) standing: Option<&'a BTreeSet<CopyId>>,
    /// The height of the open build, mm.
    pub(crate) open_height_mm: f64,
    /// Whether the machine is paused or makes another build, which may take what waits, or a withdrawal has not ended.
    pub(crate) is_hindered: bool,
}

/// Why the build is taken back; `None` = it stays.
pub(crate) fn decide_withdrawal(
    profile: &MachineProfile,
    facts: &WithdrawalFacts<'_>,
    now: Timestamp,
) -> Option<&'static str> {
    // Where a person says yes to builds, a machine that is idle in the night would wait for one.
    let may = profile.printing.withdraw != WithdrawalPolicy::Never && profile.printing.approve == ApprovalPolicy::Never;
    let standing = facts.standing.filter(|_| may && !facts.is_hindered)?;
    let arrived = facts.waiting.iter().filter(|waiting| waiting.part.times.claimed_at.0 > facts.fired_at);
    let arrived: Vec<&WaitingPart> = arrived.collect();
    let newest = arrived.iter().map(|waiting| waiting.part.times.claimed_at.0).max()?;
    let quiet_secs = secs_between(newest, now);
    let stands = |waiting: &WaitingPart| waiting.copies.iter().all(|&copy| standing.contains(&(waiting.part.id, copy)));
    let urgent = arrived.iter().find(|waiting| waiting.part.terms.priority == HIGHEST_PRIORITY && stands(waiting));
    if urgent.is_some() && quiet_secs >= profile.trigger.gather_secs.min(URGENT_GATHER_SECS) {
        return Some("copies of the highest priority go with it");
    }
    let lead_secs = LEAD_SECS + 2.0 * profile.search.final_secs;
    let lead = SignedDuration::try_from_secs_f64(lead_secs).unwrap_or(SignedDuration::MAX);
    let has_time = now.checked_add(lead).is_ok_and(|ready| ready < facts.printer_free_at);
    let has_gathered = quiet_secs >= profile.trigger.gather_secs;
    let fits = facts.open_height_mm > 0.0
        && facts.open_height_mm + facts.height_mm <= profile.build_volume().size_mm.z
        && facts.waiting.iter().all(stands);
    (profile.printing.withdraw == WithdrawalPolicy::Always && has_time && has_gathered && fits)
        .then_some("copies that arrived go with it")
}

#[cfg(test)]
mod tests {
    use ledger_fixtures::{fresh, waiting};

    use super::{super::trigger::tests::machine_with_triggers, *};

    fn at(hour: i64) -> Timestamp {
        Timestamp::UNIX_EPOCH + SignedDuration::from_hours(hour)
    }

    /// A part that was dropped at eight.
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
        let standing = BTreeSet::from([(usual[0].part.id, 0)]);
        let facts = WithdrawalFacts {
            fired_at: at(7),
            height_mm: 40.0,
            printer_free_at: at(20),
            waiting: &usual,
            standing: Some(&standing),
            open_height_mm: 30.0,
            is_hindered: false,
        };
        let is_withdrawn = |profile: &MachineProfile, facts: WithdrawalFacts<'_>, now: i64| {
            decide_withdrawal(profile, &facts, at(now)).is_some()
        };
        let hurry = WithdrawalFacts { waiting: &urgent, printer_free_at: at(9), ..facts };
        assert!(!is_withdrawn(&profile, facts, 9) && !is_withdrawn(&profile, hurry, 9), "never");
        profile.printing.withdraw = WithdrawalPolicy::Urgent;
        assert!(!is_withdrawn(&profile, facts, 9) && is_withdrawn(&profile, hurry, 9));
        assert!(!is_withdrawn(&profile, hurry, 8), "more may arrive");
        let nothing = BTreeSet::new();
        for held in [
            WithdrawalFacts { is_hindered: true, ..hurry },
            WithdrawalFacts { fired_at: at(9), ..hurry },
            WithdrawalFacts { standing: Some(&nothing), ..hurry },
            WithdrawalFacts { standing: None, ..hurry },
        ] {
            assert!(!is_withdrawn(&profile, held, 9), "{held:?}");
        }
        profile.printing.withdraw = WithdrawalPolicy::Always;
        assert!(is_withdrawn(&profile, facts, 9) && is_withdrawn(&profile, hurry, 9));
        assert!(!is_withdrawn(&profile, facts, 8), "more may arrive");
        for held in [
            WithdrawalFacts { fired_at: at(9), ..facts },
            WithdrawalFacts { printer_free_at: at(9), ..facts },
            WithdrawalFacts { open_height_mm: 70.0, ..facts },
            WithdrawalFacts { standing: Some(&nothing), ..facts },
            WithdrawalFacts { waiting: &[], ..facts },
        ] {
            assert!(!is_withdrawn(&profile, held, 9), "{held:?}");
        }
        profile.printing.approve = ApprovalPolicy::Thin;
        assert!(
            !is_withdrawn(&profile, facts, 9) && !is_withdrawn(&profile, hurry, 9),
            "somebody would have to say yes"
        );
    }
}
