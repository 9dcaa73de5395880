//! A clock that is set between the look at it and what is decided or recorded afterwards.

use jiff::SignedDuration;
use ledger::PartState;

use crate::driven_tests::{HandDrivenFarm, QUICK, block, kept::failing_ledger::RefusedChanges};

const JUMPS: [SignedDuration; 4] = [
    SignedDuration::from_hours(24),
    SignedDuration::from_hours(-24),
    SignedDuration::from_mins(90),
    SignedDuration::from_mins(-90),
];

/// A farm with one part that fires after ten minutes.
fn farm_with_waiting_part() -> HandDrivenFarm {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\nmax_wait_secs = 600\n"));
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(5.0);
    farm
}

/// The part fires about ten minutes after it was dropped, by the clock that only passes, of which this much is over.
fn assert_fires_in_time(farm: &mut HandDrivenFarm, over_secs: f64, what: &str) {
    farm.pass_secs(570.0 - over_secs);
    assert!(farm.queued().is_empty(), "{what}: it fires too early");
    farm.pass_secs(60.0);
    assert_eq!(farm.queued().len(), 1, "{what}: it does not fire");
}

#[test]
fn a_clock_that_is_set_after_the_look_at_it_fires_no_wait_in_the_same_tick() {
    for jump in JUMPS {
        let mut farm = farm_with_waiting_part();
        farm.set_wall_clock_by(jump);
        farm.look_at_open_build();
        farm.pass_secs(2.0);
        assert_eq!(farm.parts(PartState::Waiting).len(), 1, "{jump:#}");
        assert_fires_in_time(&mut farm, 10.0, &format!("{jump:#}"));
    }
}

#[test]
fn a_part_that_is_recorded_between_a_jump_and_its_notice_keeps_its_age() {
    for jump in JUMPS {
        let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\nmax_wait_secs = 600\n"));
        farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
        for turn in 0..20 {
            farm.begin_tick();
            // It is set to and fro, each time between a look at it and what the ledger records.
            farm.set_wall_clock_by(if turn % 2 == 0 { jump } else { -jump });
            farm.await_jobs();
            farm.pass_secs(0.25);
        }
        farm.wait_for_parts(PartState::Waiting, 1);
        assert_fires_in_time(&mut farm, 10.0, &format!("{jump:#}"));
    }
}

#[test]
fn a_jump_whose_ages_the_ledger_refuses_to_adjust_fires_nothing_and_is_noticed_again() {
    let mut farm = farm_with_waiting_part();
    let refused = RefusedChanges::of(&farm, "UPDATE OF claimed_at ON part");
    farm.set_wall_clock_by(SignedDuration::from_hours(24));
    farm.pass_secs(20.0);
    assert_eq!(farm.parts(PartState::Waiting).len(), 1, "nothing fires");
    refused.allow(&farm);
    assert_fires_in_time(&mut farm, 30.0, "it was refused for a while");
}
