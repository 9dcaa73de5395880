//! Parts enter and leave the open build.

use super::{HandDrivenFarm, QUICK, block};
use crate::ledger::{CommandKind, PartState};

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
