//! What of an earlier layout still holds: rules, walls and clearances may have changed since, and copies may be gone.

use std::collections::BTreeSet;

use super::{
    Instance, Placement,
    interlock::parted,
    layers::Filled,
    near::Near,
    piece::{Piece, Task, slice},
};

/// The pieces of an earlier layout that still hold: inside the walls, clear of each other and, where it is asked, not locked
/// into each other. Others are placed anew.
pub(super) fn standing(task: &Task, instance: &Instance, start: &[Placement]) -> Vec<Piece> {
    let known: BTreeSet<(usize, u32)> = task.copies.iter().copied().collect();
    let mut taken: BTreeSet<(usize, u32)> = BTreeSet::new();
    let mut near = Near::new(task.room);
    let mut filled = Filled::new(task.lineup.cap);
    let mut pieces: Vec<Piece> = Vec::new();
    let pinned = instance.pinned().iter();
    for placement in pinned.chain(start.iter().filter(|p| !task.pins.contains(&(p.item, p.copy)))) {
        let copy = (placement.item, placement.copy);
        if !known.contains(&copy) || taken.contains(&copy) {
            continue;
        }
        let kind = task.kind(placement.item);
        let piece = task.piece(copy, placement.pose.rotation, kind.shape.place(&placement.pose));
        let around = || near.around(&piece.bounds, task.near_mm());
        if task.is_inside(&piece, task.room.z)
            && super::rotation_obeys(&kind.orientation, &piece.pose)
            && task.zones.iter().all(|zone| task.is_still_clear(&piece, zone))
            && around().into_iter().all(|other| task.is_still_clear(&piece, &pieces[other]))
            && (!filled.is_capped() || filled.takes(&slice(task, &piece)))
        {
            if filled.is_capped() {
                filled.add(&slice(task, &piece));
            }
            near.add(pieces.len(), &piece.bounds);
            taken.insert(copy);
            pieces.push(piece);
        }
    }
    if task.separable { parted(task, pieces).0 } else { pieces }
}
