//! Decides what the open build of a machine needs next. This is a function of facts and time.

use jiff::Timestamp;
use settings::MachineProfile;

use super::trigger::{FireTrigger, TriggerFacts, find_trigger};

/// What is known of a machine and its waiting parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BatchFacts {
    /// The waiting parts and the open build. `flush` = an operator asked for a flush.
    pub(crate) open: TriggerFacts,
    /// Claimed parts are not read yet, or originals are being fetched; a flush waits for them.
    pub(crate) has_unread_claims: bool,
    /// Whether the machine is paused.
    pub(crate) is_paused: bool,
    /// Whether every printer has as many builds ahead as may lie in its queue. Only a person's flush fires then.
    pub(crate) is_held: bool,
}

/// What the open build needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BatchDecision {
    /// No part waits, and flushes are answered.
    AnswerFlushes,
    /// No part waits, but a flush waits for claimed parts.
    AwaitClaims,
    /// It fires.
    Fire(FireTrigger),
    /// Its layout is kept up to date.
    Search,
}

/// Decides what the open build of a machine needs.
pub(crate) fn decide_batch(profile: &MachineProfile, facts: &BatchFacts, now: Timestamp) -> BatchDecision {
    let awaits_claims = facts.open.flush && facts.has_unread_claims;
    if facts.open.copies == 0 {
        return if awaits_claims { BatchDecision::AwaitClaims } else { BatchDecision::AnswerFlushes };
    }
    let open = TriggerFacts { flush: facts.open.flush && !awaits_claims, ..facts.open };
    match find_trigger(profile, &open, now) {
        Some(by) if !facts.is_paused && (by == FireTrigger::Flush || !facts.is_held) => BatchDecision::Fire(by),
        _ => BatchDecision::Search,
    }
}

#[cfg(test)]
mod tests {
    use super::{super::trigger::tests::machine_with_triggers, *};

    fn facts(copies: usize, flush: bool) -> BatchFacts {
        let open = TriggerFacts {
            copies,
            oldest: Timestamp::UNIX_EPOCH,
            due: None,
            height_mm: 0.0,
            density: 0.0,
            full: false,
            flush,
            takes_over: false,
            is_date_trusted: true,
        };
        BatchFacts { open, has_unread_claims: false, is_paused: false, is_held: false }
    }

    #[test]
    fn a_flush_waits_for_claimed_parts_and_a_pause_for_nobody() {
        let profile = machine_with_triggers("max_wait_secs = \"24h\"");
        let decide = |facts: BatchFacts| decide_batch(&profile, &facts, Timestamp::UNIX_EPOCH);
        assert_eq!(decide(facts(3, false)), BatchDecision::Search);
        assert_eq!(decide(facts(3, true)), BatchDecision::Fire(FireTrigger::Flush));
        assert_eq!(decide(BatchFacts { has_unread_claims: true, ..facts(3, true) }), BatchDecision::Search);
        assert_eq!(decide(BatchFacts { is_paused: true, ..facts(3, true) }), BatchDecision::Search);
        assert_eq!(decide(facts(0, true)), BatchDecision::AnswerFlushes);
        assert_eq!(decide(facts(0, false)), BatchDecision::AnswerFlushes);
        assert_eq!(decide(BatchFacts { has_unread_claims: true, ..facts(0, true) }), BatchDecision::AwaitClaims);
        assert_eq!(decide(BatchFacts { has_unread_claims: true, ..facts(0, false) }), BatchDecision::AnswerFlushes);
    }

    #[test]
    fn parts_that_waited_long_enough_fire_unless_the_machine_is_paused() {
        let profile = machine_with_triggers("max_wait_secs = \"1h\"");
        let now = Timestamp::from_second(3600).unwrap();
        assert_eq!(decide_batch(&profile, &facts(1, false), now), BatchDecision::Fire(FireTrigger::MaxWait));
        let paused = BatchFacts { is_paused: true, ..facts(1, false) };
        assert_eq!(decide_batch(&profile, &paused, now), BatchDecision::Search);
    }

    #[test]
    fn a_full_queue_holds_the_open_build_and_no_persons_flush() {
        let profile = machine_with_triggers("max_wait_secs = \"1h\"");
        let now = Timestamp::from_second(3600).unwrap();
        let held = |flush: bool| BatchFacts { is_held: true, ..facts(1, flush) };
        assert_eq!(decide_batch(&profile, &held(false), now), BatchDecision::Search);
        assert_eq!(decide_batch(&profile, &held(true), now), BatchDecision::Fire(FireTrigger::Flush));
    }

    #[test]
    fn what_takes_over_a_withdrawn_build_fires_while_the_queue_has_room() {
        let profile = machine_with_triggers("max_wait_secs = \"24h\"");
        let open = TriggerFacts { takes_over: true, ..facts(2, false).open };
        let ready = BatchFacts { open, ..facts(2, false) };
        let decide = |facts: BatchFacts| decide_batch(&profile, &facts, Timestamp::UNIX_EPOCH);
        assert_eq!(decide(ready), BatchDecision::Fire(FireTrigger::Withdrawn));
        assert_eq!(decide(BatchFacts { is_held: true, ..ready }), BatchDecision::Search);
    }
}
