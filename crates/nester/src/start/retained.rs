//! Selects the placements of an earlier layout that are still valid: rules, walls and clearances may have changed
//! since, and copies may be gone.

use std::collections::BTreeSet;

use crate::{
    ItemPlacement, NestingInstance,
    prepare::{
        layers::FilledLayers,
        prepared_instance::{PlacedItem, PreparedInstance, item_layer_areas},
    },
    separation::{interlock_check::split_separable, proximity_grid::ProximityGrid},
};

/// Returns the pieces of an earlier layout that are still valid: inside the walls, clear of each other and, if
/// required, not interlocked. The other copies are placed anew.
pub(crate) fn retained_items(
    prepared: &PreparedInstance,
    instance: &NestingInstance,
    start: &[ItemPlacement],
) -> Vec<PlacedItem> {
    let known: BTreeSet<(usize, u32)> = prepared.copies.iter().copied().collect();
    let mut taken: BTreeSet<(usize, u32)> = BTreeSet::new();
    let mut near = ProximityGrid::new(prepared.room);
    let mut filled = FilledLayers::new(prepared.outlined.layer_cap);
    let mut pieces: Vec<PlacedItem> = Vec::new();
    let pinned = instance.pinned().iter();
    for placement in pinned.chain(start.iter().filter(|p| !prepared.pinned.contains(&(p.item, p.copy)))) {
        let copy = (placement.item, placement.copy);
        if !known.contains(&copy) || taken.contains(&copy) {
            continue;
        }
        let kind = prepared.prepared_item(placement.item);
        let piece = prepared.place_item(copy, placement.pose.rotation, kind.shape.center_at(&placement.pose));
        let around = || near.query_near(&piece.bounds, prepared.proximity_mm());
        if prepared.is_inside(&piece, prepared.room.z)
            && crate::obeys_orientation(&kind.orientation, &piece.pose)
            && prepared.zones.iter().all(|zone| prepared.is_still_clear(&piece, zone))
            && around().into_iter().all(|other| prepared.is_still_clear(&piece, &pieces[other]))
            && (!filled.is_capped() || filled.can_add(&item_layer_areas(prepared, &piece)))
        {
            if filled.is_capped() {
                filled.add_part(&item_layer_areas(prepared, &piece));
            }
            near.insert_bounds(pieces.len(), &piece.bounds);
            taken.insert(copy);
            pieces.push(piece);
        }
    }
    if prepared.must_be_separable { split_separable(prepared, pieces).0 } else { pieces }
}
