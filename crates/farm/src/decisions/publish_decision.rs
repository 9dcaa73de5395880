//! Decides the next step of a verified build on its way into the queue. This is a function of facts.

/// What is known of a verified build and its machine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PublishFacts {
    /// It failed recently and waits for a retry.
    pub(crate) is_resting: bool,
    /// A job takes a step with it.
    pub(crate) is_running: bool,
    /// The folders of the machine agree with the ledger, and their leases are fresh.
    pub(crate) is_machine_served: bool,
    /// The queue folder is open.
    pub(crate) is_queue_open: bool,
    /// A person took its printer out of use.
    pub(crate) is_printer_down: bool,
    /// Its printer is down, and another one of the machine can be given builds.
    pub(crate) has_better_printer: bool,
    /// A person must release it and has not.
    pub(crate) awaits_release: bool,
    /// The ledger has recorded that it will be renamed.
    pub(crate) is_recorded: bool,
    /// It does not fit its machine any more.
    pub(crate) is_misfit: bool,
}

/// The next step of a verified build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PublishDecision {
    /// None now.
    Wait,
    /// It is checked before the ledger records that it will be renamed.
    Check,
    /// It is compared with what was proved, and renamed.
    Rename,
    /// It is made again, for another printer.
    MakeForAnother,
}

/// Decides the next step of a verified build.
pub(crate) fn decide_publishing(facts: &PublishFacts) -> PublishDecision {
    if facts.is_resting || facts.is_running || !facts.is_machine_served {
        return PublishDecision::Wait;
    }
    // Nothing is renamed before the ledger says so: a crash in between must not publish a build twice.
    match (facts.is_recorded, facts.is_queue_open) {
        (true, true) => PublishDecision::Rename,
        // It may be visible already: it is published first, and moved then.
        (true, false) => PublishDecision::Wait,
        (false, _) if facts.has_better_printer => PublishDecision::MakeForAnother,
        // It is made again, so that people see what they would say yes to.
        (false, true) if facts.is_misfit => PublishDecision::Check,
        (false, true) if !facts.awaits_release && !facts.is_printer_down => PublishDecision::Check,
        (false, _) => PublishDecision::Wait,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_is_renamed_only_after_the_ledger_has_recorded_it_and_while_its_machine_is_served() {
        let facts = PublishFacts {
            is_resting: false,
            is_running: false,
            is_machine_served: true,
            is_queue_open: true,
            is_printer_down: false,
            has_better_printer: false,
            awaits_release: false,
            is_recorded: false,
            is_misfit: false,
        };
        assert_eq!(decide_publishing(&facts), PublishDecision::Check);
        let recorded = PublishFacts { is_recorded: true, ..facts };
        assert_eq!(decide_publishing(&recorded), PublishDecision::Rename);
        for hindered in [
            PublishFacts { is_resting: true, ..recorded },
            PublishFacts { is_running: true, ..recorded },
            PublishFacts { is_machine_served: false, ..recorded },
            PublishFacts { is_queue_open: false, ..recorded },
            PublishFacts { awaits_release: true, ..facts },
        ] {
            assert_eq!(decide_publishing(&hindered), PublishDecision::Wait);
        }
    }

    #[test]
    fn a_build_whose_printer_is_down_is_made_for_another_one_unless_it_may_be_visible_already() {
        let down = PublishFacts {
            is_resting: false,
            is_running: false,
            is_machine_served: true,
            is_queue_open: true,
            is_printer_down: true,
            has_better_printer: false,
            awaits_release: true,
            is_recorded: false,
            is_misfit: false,
        };
        for waits in [down, PublishFacts { awaits_release: false, ..down }] {
            assert_eq!(decide_publishing(&waits), PublishDecision::Wait, "it waits for its printer");
        }
        let better = PublishFacts { has_better_printer: true, ..down };
        assert_eq!(decide_publishing(&better), PublishDecision::MakeForAnother);
        assert_eq!(decide_publishing(&PublishFacts { is_recorded: true, ..better }), PublishDecision::Rename);
        let misfit = PublishFacts { is_misfit: true, ..down };
        assert_eq!(decide_publishing(&misfit), PublishDecision::Check, "it is made again, whatever it waits for");
        assert_eq!(decide_publishing(&PublishFacts { is_running: true, ..misfit }), PublishDecision::Wait);
    }
}
