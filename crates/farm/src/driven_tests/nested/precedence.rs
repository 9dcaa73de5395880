//! Who goes first: what the highest priority gets, what stays, and what is told to those who must wait.

use ledger::{CommandKind, EventKind, EventRow, PartRow, PartState};

use crate::driven_tests::{HandDrivenFarm, MACHINE, QUICK, block};

/// 8 cubes of 55 mm fill the volume of [`QUICK`].
const CUBES: usize = 8;

/// A paused farm whose open build is full of cubes that were dropped together.
fn full_and_paused(profile: &str) -> HandDrivenFarm {
    let mut farm = HandDrivenFarm::open(profile);
    farm.order_and_wait(CommandKind::Pause, None);
    farm.drop_part(&format!("cube_x{CUBES}.stl"), &block(55.0, 55.0, 55.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(3.0);
    assert_eq!(farm.open_copies().len(), CUBES);
    farm
}

/// Drops a part with a ticket and waits until it was tried.
fn drop_urgent(farm: &mut HandDrivenFarm, name: &str, size: [f64; 3], ticket: &str) -> PartRow {
    let waiting = farm.parts(PartState::Waiting).len();
    farm.drop_bytes(&format!("{name}.toml"), ticket.as_bytes());
    farm.drop_part(name, &block(size[0], size[1], size[2]));
    farm.wait_for_parts(PartState::Waiting, waiting + 1);
    farm.pass_secs(3.0);
    let part = farm.parts(PartState::Waiting).into_iter().find(|part| part.name == name);
    part.expect("it waits")
}

fn events(farm: &HandDrivenFarm, part: &PartRow, kind: EventKind) -> Vec<EventRow> {
    let all = farm.ask(async |ledger| ledger.events_of_part(part.id).await.unwrap());
    all.into_iter().filter(|event| event.kind == kind).collect()
}

/// The part numbers of the copies in the first build in the queue.
fn first_build(farm: &mut HandDrivenFarm) -> Vec<String> {
    farm.order_and_wait(CommandKind::Resume, None);
    let file = farm.wait_for_queued(1).remove(0);
    let placed = build_file::read_build(&file, &Default::default()).unwrap();
    placed.into_iter().filter_map(|placed| placed.part_number).collect()
}

#[test]
fn priority_100_gets_into_a_full_open_build_and_what_it_puts_out_is_told() {
    for size in [[55.0, 55.0, 55.0], [80.0, 30.0, 20.0], [4.0, 4.0, 4.0], [110.0, 110.0, 40.0]] {
        for seed in [1, 2] {
            let mut farm = full_and_paused(&format!("{QUICK}[nest]\nseed = {seed}\n"));
            let cubes = farm.parts(PartState::Waiting).remove(0);
            let urgent = drop_urgent(&mut farm, "urgent.stl", size, "priority = 100\n");
            let told = events(&farm, &cubes, EventKind::PutOut);
            assert!(events(&farm, &urgent, EventKind::NoRoom).is_empty());
            let standing = farm.open_copies().into_iter().filter(|copy| copy.0 == cubes.id).count();
            if size == [4.0, 4.0, 4.0] {
                assert_eq!((standing, told.len()), (CUBES, 0), "it fits beside all cubes");
                farm.order_and_wait(CommandKind::Resume, None);
                farm.order(CommandKind::Flush, None);
            } else {
                assert!(standing < CUBES && told.len() == 1, "{size:?}: {standing} cubes, {told:?}");
                let reason = format!("urgent.stl (part {}, priority 100)", urgent.id);
                assert!(told[0].detail.contains(&reason), "{}", told[0].detail);
                assert!(farm.status_text().contains(&told[0].detail));
            }
            let built = first_build(&mut farm);
            assert!(built.contains(&urgent.id.to_string()), "{size:?}, seed {seed}");
            farm.assert_nothing_lost_or_doubled();
        }
    }
}

#[test]
fn what_stands_stays_when_a_part_of_the_same_priority_comes() {
    let mut farm = full_and_paused(QUICK);
    let cubes = farm.parts(PartState::Waiting).remove(0);
    let late = drop_urgent(&mut farm, "late.stl", [50.0, 50.0, 50.0], "copies = 2\n");
    assert_eq!(farm.open_copies().iter().filter(|copy| copy.0 == cubes.id).count(), CUBES);
    assert!(events(&farm, &cubes, EventKind::PutOut).is_empty() && events(&farm, &late, EventKind::NoRoom).is_empty());
    let built = first_build(&mut farm);
    assert_eq!(built, vec![cubes.id.to_string(); CUBES]);
}

#[test]
fn an_earlier_due_date_goes_before_what_stands_without_one() {
    let mut farm = full_and_paused(QUICK);
    let cubes = farm.parts(PartState::Waiting).remove(0);
    let due = drop_urgent(&mut farm, "due.stl", [50.0, 50.0, 50.0], "due = 2099-01-01\n");
    assert!(farm.open_copies().contains(&(due.id, 0)));
    assert_eq!(events(&farm, &cubes, EventKind::PutOut).len(), 1);
}

#[test]
fn priority_100_that_finds_no_room_is_told_why_at_once() {
    let mut farm = full_and_paused(QUICK);
    let first = drop_urgent(&mut farm, "first.stl", [110.0, 110.0, 70.0], "priority = 100\n");
    let second = drop_urgent(&mut farm, "second.stl", [110.0, 110.0, 70.0], "priority = 100\n");
    let told = events(&farm, &second, EventKind::NoRoom).pop().expect("it is told");
    assert!(told.detail.contains("cannot be in the next build"), "{}", told.detail);
    assert!(told.detail.contains(&format!("first.stl (part {}", first.id)), "{}", told.detail);
    assert!(farm.status_text().contains(&told.detail));
    let built = first_build(&mut farm);
    assert!(built.contains(&first.id.to_string()) && !built.contains(&second.id.to_string()));
    let next = farm.wait_for_queued(2).remove(1);
    let placed = build_file::read_build(&next, &Default::default()).unwrap();
    assert!(placed.iter().any(|placed| placed.part_number == Some(second.id.to_string())));
    farm.pass_secs(3.0);
    assert!(!farm.status_text().contains("second.stl"), "{MACHINE}: {}", farm.status_text());
}
