//! How long copies have waited: those that come back wait from then on, and fire no thin build because their part was dropped long ago.

use ledger::{CommandArgument, CommandKind, PartEdit, PartId, PartState, PrintOutcome, ReprintTarget};
use ledger_fixtures::ToldWords;

use crate::driven_tests::{
    HandDrivenFarm, QUICK, block,
    printed::reprints::{change, edit, published, tell},
};

const WAIT_A_MINUTE: &str = "[trigger]\nmax_wait_secs = 60\n";

/// A farm with a published build of three copies that were dropped long ago.
fn farm_with_old_build(trigger: &str) -> (HandDrivenFarm, PartId) {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}{trigger}"));
    farm.drop_part("a_x3.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    published(&mut farm, 1);
    farm.wait_for_parts(PartState::Built, 1);
    farm.pass_secs(100.0);
    (farm, part)
}

/// What came back just now waits for a minute, and the forecast says so.
fn assert_waits_a_minute(farm: &mut HandDrivenFarm) {
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(3.0);
    let forecast: jiff::Timestamp = farm.status_json()["fires_at"].as_str().unwrap().parse().unwrap();
    let in_secs = forecast.duration_since(farm.date()).as_secs_f64();
    assert!((40.0..=60.0).contains(&in_secs), "the forecast says in {in_secs} s");
    farm.pass_secs(35.0);
    assert_eq!(farm.queued().len(), 1, "it fires too early");
    farm.pass_secs(30.0);
    assert_eq!(farm.queued().len(), 2, "it does not fire");
}

#[test]
fn copies_of_a_failed_print_wait_from_when_they_were_put_back() {
    let (mut farm, _) = farm_with_old_build(WAIT_A_MINUTE);
    let build = farm.ask(async |ledger| ledger.read_history(&Default::default()).await.unwrap()[0].build);
    tell(&farm, build, PrintOutcome::Failed);
    assert_waits_a_minute(&mut farm);
}

#[test]
fn a_copy_that_is_printed_again_waits_from_when_it_was_put_back() {
    let (mut farm, part) = farm_with_old_build(WAIT_A_MINUTE);
    farm.ask(async |ledger| ledger.reprint_copies(&ReprintTarget::Part(part, Some(1)), "ann").await.unwrap());
    assert_waits_a_minute(&mut farm);
}

#[test]
fn more_copies_of_what_is_built_wait_from_when_they_were_wanted() {
    let (mut farm, part) = farm_with_old_build(WAIT_A_MINUTE);
    let more = PartEdit { copies: Some(5), ..PartEdit::default() };
    change(&mut farm, CommandKind::Edit, part, edit(more), "");
    assert_waits_a_minute(&mut farm);
}

#[test]
fn a_part_that_is_taken_back_waits_from_then_on() {
    let (mut farm, _) = farm_with_old_build(WAIT_A_MINUTE);
    farm.drop_part("b.stl", &block(12.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    change(&mut farm, CommandKind::Cancel, part, CommandArgument::default(), "");
    farm.pass_secs(100.0);
    farm.order_and_wait(CommandKind::Retry, Some(part));
    assert_waits_a_minute(&mut farm);
}

#[test]
fn copies_that_were_put_back_wait_for_the_next_time_of_day() {
    // The next such time is a day away: the farm's clock stands a minute after it.
    let at = (jiff::Timestamp::now().to_zoned(jiff::tz::TimeZone::UTC).time()).round(jiff::Unit::Minute).unwrap();
    let at = at.wrapping_add(jiff::Span::new().minutes(1)).strftime("%H:%M").to_string();
    let (mut farm, part) = {
        let mut farm = HandDrivenFarm::closed(&format!("{QUICK}[trigger]\nmax_wait_secs = \"30d\"\nat = [\"{at}\"]\n"));
        farm.write_time_zone("UTC");
        farm.start();
        farm.drop_part("a_x3.stl", &block(10.0, 10.0, 10.0));
        let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
        published(&mut farm, 1);
        farm.pass_secs(180.0);
        (farm, part)
    };
    farm.ask(async |ledger| ledger.reprint_copies(&ReprintTarget::Part(part, None), "ann").await.unwrap());
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(60.0);
    assert_eq!(farm.queued().len(), 1, "the time of day passed before they came back");
}

#[test]
fn copies_that_wait_since_the_drop_do_not_wait_longer_because_others_come_back() {
    // Only three of the slabs fit into a build.
    let profile = QUICK.replace("[120, 120, 120]", "[50, 50, 50]");
    let mut farm = HandDrivenFarm::open(&format!("{profile}[trigger]\nmax_wait_secs = 60\n"));
    farm.drop_part("slab_x4.stl", &block(46.0, 46.0, 14.0));
    farm.wait_for_queued(1);
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    farm.pass_secs(30.0);
    farm.ask(async |ledger| ledger.reprint_copies(&ReprintTarget::Part(part.id, Some(1)), "ann").await.unwrap());
    farm.pass_secs(40.0);
    assert_eq!(farm.queued().len(), 2, "the fourth slab has waited for a minute");
}
