//! An open build that waits is lowered further: over a restart, until it is not worth the time, and never in the way of
//! anything else.

use std::collections::BTreeSet;

use ledger::{
    BuildState, CommandArgument, CommandKind, NewCommand, NightSearchRow, NightState, PartEdit, PartId, PartState,
};

use crate::{
    decisions::layout::layouts_from_json,
    driven_tests::{
        HandDrivenFarm, MACHINE, QUICK, block,
        hand_driven_farm::farm_files::{drop_file, list_build_files},
        stl,
    },
};

/// A machine whose open build may be lowered for `secs` CPU seconds.
pub(crate) fn lowering(secs: f64) -> String {
    QUICK.replace("improve_secs = 0", &format!("improve_secs = {secs}"))
}

/// Drops as many copies of each of three parts, and waits until they were searched.
pub(crate) fn drop_mixed(farm: &mut HandDrivenFarm, copies: usize) {
    for (name, size) in [("a", [50.0, 22.0, 13.0]), ("b", [31.0, 29.0, 17.0]), ("c", [44.0, 11.0, 9.0])] {
        farm.drop_part(&format!("{name}_x{copies}.stl"), &block(size[0], size[1], size[2]));
    }
    farm.wait_for_parts(PartState::Waiting, 3);
    farm.pass_until("they are searched further", |farm| {
        farm.open_copies().len() == 3 * copies && night_of(farm, MACHINE).is_some()
    });
}

fn night_of(farm: &HandDrivenFarm, machine: &str) -> Option<NightSearchRow> {
    let machine = machine.to_owned();
    farm.ask(async |ledger| {
        let build = ledger.open_build(&machine).await.unwrap().id;
        ledger.find_night_search(build).await.unwrap()
    })
}

fn night(farm: &HandDrivenFarm) -> NightSearchRow {
    night_of(farm, MACHINE).expect("it has begun")
}

pub(crate) fn rest(farm: &mut HandDrivenFarm) -> NightSearchRow {
    farm.pass_until("the search rests", |farm| {
        night_of(farm, MACHINE).is_some_and(|row| row.state != NightState::GoesOn)
    });
    night(farm)
}

fn open_height_mm(farm: &HandDrivenFarm) -> f64 {
    farm.ask(async |ledger| ledger.open_build(MACHINE).await.unwrap().measures.height_mm.unwrap())
}

#[test]
fn an_open_build_that_waits_gets_lower_tells_cost_and_gain_and_is_built_so() {
    let (mut farm, row, height_mm) = lowered();
    farm.pass_secs(3.0);
    assert!(row.cpu_secs > 0.0 && row.starts == 0 && row.round > 0, "{row:?}");
    let json = farm.status_json()["open_build"].clone();
    assert!((json["night_gain_mm"].as_f64().unwrap() - (row.first_height_mm - height_mm)).abs() < 1e-6);
    assert_eq!(json["night_cpu_secs"].as_f64(), Some(row.cpu_secs));
    let told = format!("While it waits: {:.2} mm lower after", row.first_height_mm - height_mm);
    assert!(farm.status_text().contains(&told), "{}", farm.status_text());
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    let build = farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap());
    assert!(build[0].measures.height_mm.unwrap() <= height_mm + 1e-6, "the final search begins from it");
    assert!(build[0].search.cpu_secs.unwrap() >= row.cpu_secs, "its cost counts");
    assert_eq!(night_of(&farm, MACHINE), None, "the next open build begins anew");
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn it_ends_when_its_time_is_used_up_and_goes_on_with_more() {
    // Less than the first round would take.
    let mut farm = HandDrivenFarm::open(&lowering(0.03));
    drop_mixed(&mut farm, 6);
    let row = rest(&mut farm);
    assert_eq!((row.state, row.round), (NightState::UsedUp, 0));
    assert!((0.03..2.0).contains(&row.cpu_secs), "{row:?}");
    farm.pass_secs(5.0);
    assert_eq!(night(&farm), row, "it rests");
    farm.write_profile(MACHINE, &lowering(30.0));
    farm.reload();
    farm.pass_until("it goes on", |farm| night(farm).cpu_secs > row.cpu_secs);
    assert_eq!(night(&farm).first_height_mm, row.first_height_mm);
}

#[test]
fn nothing_is_searched_where_it_is_switched_off() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x9.stl", &block(50.0, 22.0, 13.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(5.0);
    assert_eq!(farm.open_copies().len(), 9);
    assert_eq!(night_of(&farm, MACHINE), None);
    farm.write_profile(MACHINE, &lowering(0.5));
    farm.reload();
    rest(&mut farm);
    farm.write_profile(MACHINE, QUICK);
    farm.reload();
    farm.pass_until("it is forgotten", |farm| night_of(farm, MACHINE).is_none());
    farm.pass_secs(3.0);
    assert!(farm.status_json()["open_build"]["night"].is_null());
}

#[test]
fn a_restart_goes_on_where_it_was_and_what_cannot_be_read_begins_anew() {
    let mut farm = HandDrivenFarm::open(&lowering(0.2));
    drop_mixed(&mut farm, 6);
    let row = rest(&mut farm);
    let pool = layouts_from_json(&row.pool).unwrap();
    let copies: BTreeSet<_> = pool[0].iter().map(|placed| placed.copy).collect();
    assert_eq!(copies, farm.open_copies());
    farm.stop();
    farm.start();
    farm.pass_secs(5.0);
    assert_eq!(night(&farm), row);
    let build = farm.ask(async |ledger| ledger.open_build(MACHINE).await.unwrap().id);
    let broken = NightSearchRow { pool: "[[[1".to_owned(), ..row };
    farm.ask(async |ledger| ledger.save_night_search(build, &broken).await.unwrap());
    farm.stop();
    farm.start();
    farm.pass_until("it begins anew", |farm| night(farm).pool != broken.pool);
    rest(&mut farm);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_search_that_ended_the_daemon_three_times_is_not_begun_again() {
    let mut farm = HandDrivenFarm::open(&lowering(0.2));
    drop_mixed(&mut farm, 6);
    let row = NightSearchRow { starts: 3, state: NightState::GoesOn, cpu_secs: 0.0, ..rest(&mut farm) };
    let build = farm.ask(async |ledger| ledger.open_build(MACHINE).await.unwrap().id);
    farm.ask(async |ledger| ledger.save_night_search(build, &row).await.unwrap());
    farm.stop();
    farm.start();
    farm.pass_secs(5.0);
    assert_eq!(night(&farm).state, NightState::GivenUp);
}

/// A search that rests goes on with another round, as if it had cost nothing before.
pub(crate) fn go_on_with_round(farm: &mut HandDrivenFarm, machine: &str, round: u32) -> NightSearchRow {
    let row = night_of(farm, machine).expect("it has begun");
    let row = NightSearchRow { state: NightState::GoesOn, round, round_cpu_secs: 0.0, cpu_secs: 0.0, ..row };
    save_night(farm, machine, &row);
    farm.forget_night(machine);
    row
}

fn save_night(farm: &HandDrivenFarm, machine: &str, row: &NightSearchRow) {
    farm.ask(async |ledger| {
        let build = ledger.open_build(machine).await.unwrap().id;
        ledger.save_night_search(build, row).await.unwrap();
    });
}

/// Begins a search that would take minutes.
fn begin_long_search(farm: &mut HandDrivenFarm, machine: &str) -> NightSearchRow {
    let row = go_on_with_round(farm, machine, 12);
    farm.pass_moments_until("a long search runs", |farm| farm.is_lowering(machine));
    row
}

/// A farm that searches for minutes, also without one of its parts: what fits into one layer is as low as it can be, and
/// its search ends at once.
fn searching_long() -> (HandDrivenFarm, NightSearchRow) {
    let mut farm = HandDrivenFarm::open(&lowering(3600.0));
    drop_mixed(&mut farm, 10);
    let row = begin_long_search(&mut farm, MACHINE);
    (farm, row)
}

#[test]
fn an_arrival_stops_it_at_once() {
    let (mut farm, row) = searching_long();
    farm.drop_part("late.stl", &block(20.0, 15.0, 8.0));
    farm.pass_moments_until("the arrival stands in the open build", |farm| farm.open_copies().len() == 31);
    farm.pass_moments_until("another search begins", |farm| {
        night_of(farm, MACHINE).is_some_and(|now| now.problem != row.problem && now.round < 12)
    });
}

#[test]
fn a_flush_takes_what_it_has_found_so_far() {
    let (mut farm, _) = searching_long();
    let height_mm = open_height_mm(&farm);
    farm.order(CommandKind::Flush, None);
    // The file is visible a moment before its row says so.
    let published = |farm: &HandDrivenFarm| {
        farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()).pop()
    };
    farm.pass_moments_until("the build is published", |farm| published(farm).is_some());
    let built = published(&farm).unwrap();
    assert!(built.measures.height_mm.unwrap() <= height_mm + 1e-6);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_stop_keeps_what_it_has_done() {
    let (mut farm, row) = searching_long();
    farm.stop();
    farm.start();
    let kept = night(&farm);
    assert!(kept.cpu_secs > row.cpu_secs && kept.round == 12 && kept.starts == 0, "{kept:?}");
}

fn edit_part(farm: &HandDrivenFarm, part: PartId, edit: PartEdit) {
    let argument = CommandArgument { edit: Some(edit), ..CommandArgument::default() };
    let (kind, machine) = (CommandKind::Edit, String::new());
    farm.submit_command(&NewCommand { kind, machine, part: Some(part), argument, asked_by: "a@test".to_owned() });
}

#[test]
fn cancelled_and_edited_parts_change_what_is_searched() {
    let (mut farm, row) = searching_long();
    let parts = farm.parts(PartState::Waiting);
    farm.order(CommandKind::Cancel, Some(parts[0].id));
    let searched_anew = |farm: &HandDrivenFarm, before: &NightSearchRow| {
        night_of(farm, MACHINE).is_some_and(|now| now.problem != before.problem)
    };
    farm.pass_moments_until("a search without them begins", |farm| searched_anew(farm, &row));
    assert_eq!(farm.open_copies().len(), 20);
    let fewer = begin_long_search(&mut farm, MACHINE);
    edit_part(&farm, parts[1].id, PartEdit { clearance_mm: Some(Some(4.0)), ..PartEdit::default() });
    farm.pass_moments_until("a search for the edited part begins", |farm| searched_anew(farm, &fewer));
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn the_searches_of_other_machines_come_first() {
    let mut farm = HandDrivenFarm::closed(&lowering(3600.0));
    farm.write_profile("other", &QUICK.replace("final_secs = 0.05", "final_secs = 1"));
    farm.write_threads(1);
    farm.start();
    drop_mixed(&mut farm, 6);
    begin_long_search(&mut farm, MACHINE);
    let file = farm.folder_of("inbox", "other").join("a_x24.stl");
    drop_file(farm.root(), &file, &stl(&block(50.0, 22.0, 13.0)));
    farm.pass_moments_until("the part waits", |farm| {
        farm.parts(PartState::Waiting).iter().any(|part| part.machine == "other")
    });
    let (kind, machine) = (CommandKind::Flush, "other".to_owned());
    let argument = CommandArgument::default();
    farm.submit_command(&NewCommand { kind, machine, part: None, argument, asked_by: "a@test".to_owned() });
    let mut moments = 0;
    farm.pass_moments_until("the other build is in the queue", |farm| {
        moments += usize::from(farm.is_nesting());
        assert!(!(farm.is_nesting() && farm.is_lowering(MACHINE)), "it gives way");
        !list_build_files(&farm.folder_of("queue", "other")).is_empty()
    });
    assert!(moments > 0, "it was seen");
    farm.pass_moments_until("it goes on", |farm| farm.is_lowering(MACHINE));
    let row = night(&farm);
    assert!(row.round == 12 && row.round_cpu_secs > 0.0, "the time before counts: {row:?}");
    farm.stop();
}

/// Other settings of the machine, which change nothing about its layouts.
fn with_other_attempts(profile: &str, attempts: u32) -> String {
    profile.replace("max_attempts = 50", &format!("max_attempts = {attempts}"))
}

/// A farm whose open build was searched on in rounds of some length until it was lower than at first, and rests; and its
/// height, mm. One round is no promise: now and then the search for the arrival leaves it nothing to gain.
fn lowered() -> (HandDrivenFarm, NightSearchRow, f64) {
    let mut farm = HandDrivenFarm::open(&lowering(8.0));
    drop_mixed(&mut farm, 12);
    for _ in 0..10 {
        go_on_with_round(&mut farm, MACHINE, 3);
        let row = rest(&mut farm);
        let height_mm = open_height_mm(&farm);
        if height_mm < row.first_height_mm {
            return (farm, row, height_mm);
        }
    }
    panic!("ten rounds of {} copies gained nothing", farm.open_copies().len());
}

fn assert_stays_lowered(farm: &mut HandDrivenFarm, row: &NightSearchRow, height_mm: f64) {
    farm.pass_secs(5.0);
    assert!(open_height_mm(farm) <= height_mm, "{} of {height_mm}", open_height_mm(farm));
    assert_eq!(night(farm), *row, "it rests");
}

#[test]
fn other_settings_of_the_machine_leave_the_layout_as_low_as_it_is() {
    let (mut farm, row, height_mm) = lowered();
    let row = NightSearchRow { pool: "[]".to_owned(), ..row };
    save_night(&farm, MACHINE, &row);
    let other = format!("{}arrangement = \"locked\"\n", with_other_attempts(&lowering(8.0), 40));
    farm.write_profile(MACHINE, &other);
    farm.reload();
    assert_stays_lowered(&mut farm, &row, height_mm);
}

#[test]
fn a_kept_layout_of_the_same_copies_is_taken_back() {
    let (mut farm, row, height_mm) = lowered();
    farm.stop();
    farm.start();
    // As if other copies had been searched last.
    farm.forget_layout(MACHINE);
    assert_stays_lowered(&mut farm, &row, height_mm);
}

#[test]
fn another_order_of_precedence_is_no_arrival() {
    let (mut farm, row, _) = lowered();
    let last = farm.parts(PartState::Waiting).last().unwrap().id;
    edit_part(&farm, last, PartEdit { priority: Some(90), ..PartEdit::default() });
    farm.pass_secs(3.0);
    farm.stop();
    farm.start();
    farm.pass_secs(5.0);
    assert_eq!(night(&farm), row, "it rests");
}

#[test]
fn searches_that_are_ended_count_and_are_no_crashes() {
    let (mut farm, row) = searching_long();
    for attempts in 10..15 {
        farm.write_profile(MACHINE, &with_other_attempts(&lowering(3600.0), attempts));
        farm.reload();
        farm.pass_moments_until("it is searched again", |farm| farm.is_lowering(MACHINE));
    }
    let now = night(&farm);
    assert_eq!((now.state, now.starts, now.round), (NightState::GoesOn, 1, 12));
    assert!(now.cpu_secs > row.cpu_secs && now.round_cpu_secs > 0.0, "{now:?}");
    farm.stop();
}

#[test]
fn the_published_method_is_not_searched_further() {
    let (mut farm, ..) = lowered();
    farm.write_profile(MACHINE, &format!("{}[nest]\nmethod = \"paper\"\n", lowering(8.0)));
    farm.reload();
    farm.pass_until("it is forgotten", |farm| night_of(farm, MACHINE).is_none());
}
