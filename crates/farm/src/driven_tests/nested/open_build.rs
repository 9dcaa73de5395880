//! Parts enter and leave the open build.

use ledger::{CommandKind, PartState};

use crate::driven_tests::{HandDrivenFarm, MACHINE, QUICK, block};

#[test]
fn a_cancelled_part_leaves_the_open_build() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x4.stl", &block(20.0, 15.0, 8.0));
    farm.drop_part("b_x4.stl", &block(18.0, 12.0, 9.0));
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    farm.pass_secs(3.0);
    let gone = parts.iter().find(|part| part.name.starts_with('b')).unwrap();
    farm.order_and_wait(CommandKind::Cancel, Some(gone.id));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 1);
    let placed = build_file::read_build(&farm.queued()[0], &Default::default()).unwrap();
    assert_eq!(placed.len(), 4);
    assert!(placed.iter().all(|p| p.part_number.as_deref() != Some(&gone.id.to_string())));
}

#[test]
fn nothing_is_told_of_an_open_build_whose_parts_were_all_cancelled() {
    let mut farm = HandDrivenFarm::open(&QUICK.replace("improve_secs = 0", "improve_secs = 1"));
    farm.drop_part("a_x4.stl", &block(20.0, 15.0, 8.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    let told = |farm: &HandDrivenFarm| {
        farm.ask(async |ledger| {
            let build = ledger.open_build(MACHINE).await.unwrap();
            let night = ledger.find_night_search(build.id).await.unwrap();
            (build.measures.copies, build.measures.height_mm.is_some(), night.is_some(), build.kept.layout.is_some())
        })
    };
    farm.pass_until("it was searched", |farm| told(farm) == (Some(4), true, true, true));
    farm.order_and_wait(CommandKind::Cancel, Some(part.id));
    farm.pass_until("it is forgotten", |farm| told(farm) == (None, false, false, false));
    farm.drop_part("b_x3.stl", &block(18.0, 12.0, 9.0));
    farm.pass_until("others are searched", |farm| told(farm) == (Some(3), true, true, true));
    farm.assert_ledger_agrees_with_folders();
}
