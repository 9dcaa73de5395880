//! Stacks bounding boxes: the very first layout, and the place for copies that fit nowhere else. It needs only a part's
//! extents, so it can run before any mesh is prepared.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DQuat, DVec3};
use solids::{Bounds, Pose};

use crate::{
    orientation::first_rotations::first_rotations,
    prepare::{
        layers::{FilledLayers, PartLayerAreas},
        prepared_instance::{CLEARANCE_SPARE_MM, PlacedItem, raised_bounds},
    },
    problem::fit_check::WALL_SPARE_MM,
    shapes::{
        outline::{OutlinedInstance, OutlinedItem},
        skyline::SkylineGrid,
    },
};

/// Cells of the base for few copies and for many. With many copies, most are small, and each of them tests all cells.
const CELLS: [f64; 2] = [20_000.0, 8_000.0];
/// From this number of copies on, the copies count as many.
const MANY_COPIES: usize = 200;
/// Number of orientations tried for an item.
const MAX_ORIENTATIONS: usize = 6;

/// One orientation of an item: a rotation, and the resulting bounds around its center.
#[derive(Debug, Clone)]
struct BoxOrientation {
    rotation: DQuat,
    bounds: Bounds,
}

impl BoxOrientation {
    /// Places a copy so that the least corner of its bounds is at `corner`.
    fn place_copy(&self, (item, copy): (usize, u32), candidate: &OutlinedItem, corner: DVec3) -> PlacedItem {
        let center = corner - self.bounds.min;
        let bounds = Bounds { min: corner, max: self.bounds.max + center };
        let pose = Pose::new(self.rotation, center - self.rotation * candidate.outline.obb.pose.translation);
        PlacedItem { item, copy, rotation: self.rotation, center, pose, bounds }
    }
}

/// Stacks boxes and knows the orientations of every item.
#[derive(Debug, Clone)]
pub(crate) struct BoxStacker<'a> {
    outlined: &'a OutlinedInstance,
    orientations: BTreeMap<usize, Vec<BoxOrientation>>,
}

impl<'a> BoxStacker<'a> {
    /// Creates a stacker for the items of an instance.
    pub(crate) fn new(outlined: &'a OutlinedInstance) -> Self {
        Self { outlined, orientations: BTreeMap::new() }
    }

    /// A base with the pieces that are already placed.
    pub(crate) fn build_skyline(&self, standing: &[PlacedItem]) -> SkylineGrid {
        let mut skyline =
            SkylineGrid::new(self.outlined.room, CELLS[usize::from(self.outlined.copies.len() > MANY_COPIES)]);
        self.outlined.zones.iter().for_each(|zone| skyline.add_keep_out(&zone.bounds));
        standing.iter().for_each(|piece| skyline.add_box(&raised_bounds(&piece.bounds, self.outlined.z_extra_mm)));
        skyline
    }

    /// Returns the placed pieces and the copies stacked as boxes, in the given order. Copies that do not fit are left
    /// out.
    pub(crate) fn stack_copies(&mut self, standing: &[PlacedItem], copies: &[(usize, u32)]) -> Vec<PlacedItem> {
        let mut skyline = self.build_skyline(standing);
        let mut filled = FilledLayers::new(self.outlined.layer_cap);
        let mut full: BTreeSet<usize> = BTreeSet::new();
        let mut pieces = standing.to_vec();
        standing.iter().for_each(|piece| self.add_layer_areas(&mut filled, piece));
        for &copy in copies {
            // An item that did not fit will not fit on higher boxes either.
            if full.contains(&copy.0) {
                continue;
            }
            match self.place_on_top(copy, &skyline, &filled) {
                Some(piece) => {
                    skyline.add_box(&raised_bounds(&piece.bounds, self.outlined.z_extra_mm));
                    self.add_layer_areas(&mut filled, &piece);
                    pieces.push(piece);
                }
                None => drop(full.insert(copy.0)),
            }
        }
        pieces
    }

    /// Adds a piece to the layer areas if layers have a cap.
    fn add_layer_areas(&self, filled: &mut FilledLayers, piece: &PlacedItem) {
        if filled.is_capped() {
            let mesh = &self.outlined.outlined_item(piece.item).mesh;
            filled.add_part(&PartLayerAreas::from_mesh(mesh, &piece.pose, self.outlined.layer_cap.layer_mm));
        }
    }

    /// The lowest place of a copy on top of the boxes below it, higher where its layers are full: in the orientation that is
    /// the lowest before it is raised, or in the next one that has a place.
    pub(crate) fn place_on_top(
        &mut self,
        copy: (usize, u32),
        skyline: &SkylineGrid,
        filled: &FilledLayers,
    ) -> Option<PlacedItem> {
        let outlined = self.outlined;
        let candidate = outlined.outlined_item(copy.0);
        let orientations =
            self.orientations.entry(copy.0).or_insert_with(|| distinct_orientations(candidate, outlined.room));
        let lowest_corner = |orientation: &BoxOrientation, floor_mm: f64| {
            let spacing_mm = outlined.max_clearance_mm + CLEARANCE_SPARE_MM;
            skyline.lowest_position(orientation.bounds.size(), spacing_mm, floor_mm)
        };
        let with_corner = |orientation| Some((lowest_corner(orientation, 0.0)?, orientation));
        let mut corners: Vec<(DVec3, &BoxOrientation)> = orientations.iter().filter_map(with_corner).collect();
        // Tops that differ by rounding only are the same.
        corners.sort_by_key(|(corner, orientation)| ((corner.z + orientation.bounds.size().z) * 1e9).round() as i64);
        corners.into_iter().find_map(|(mut corner, orientation)| {
            loop {
                let piece = orientation.place_copy(copy, candidate, corner);
                let raise_mm = if filled.is_capped() { filled.raise_mm(&candidate.mesh, &piece.pose)? } else { 0.0 };
                if raise_mm == 0.0 {
                    return Some(piece);
                }
                corner = lowest_corner(orientation, corner.z - WALL_SPARE_MM + raise_mm)?;
            }
        })
    }
}

/// Rotations that give an item different extents, lowest first.
fn distinct_orientations(candidate: &OutlinedItem, room: DVec3) -> Vec<BoxOrientation> {
    let center = candidate.outline.obb.pose.translation;
    let mut orientations: Vec<BoxOrientation> = Vec::new();
    for turn in rotations_to_try(candidate, room, usize::MAX) {
        let rough = Bounds::from_points(candidate.outline.extremes.iter().map(|&p| turn * p)).size();
        let is_like = |orientation: &BoxOrientation| (orientation.bounds.size() - rough).abs().max_element() < 0.05;
        if orientations.iter().any(is_like) {
            continue;
        }
        let turn = turn.normalize();
        let bounds = candidate.mesh.bounds_at(&Pose::new(turn, -(turn * center)));
        orientations.push(BoxOrientation { rotation: turn, bounds });
        if orientations.len() == MAX_ORIENTATIONS {
            break;
        }
    }
    orientations
}

/// Rotations to try for an item; never empty.
pub(crate) fn rotations_to_try(candidate: &OutlinedItem, room: DVec3, most: usize) -> Vec<DQuat> {
    let outline = &candidate.outline;
    let room = room - 2.0 * WALL_SPARE_MM;
    let mut turns = first_rotations(&candidate.orientation, outline.obb.pose.rotation, &outline.extremes, room, most);
    if turns.is_empty() {
        turns.push(candidate.fitting_rotation);
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        BuildVolume, LayerAreaCap, NestingInstance, NestingItem,
        tests::testing::{block, coarsely_prepared},
    };

    #[test]
    fn a_part_that_lies_flat_in_no_layer_is_stacked_on_its_edge() {
        // Flat, one plate alone fills more of a layer than is allowed.
        let plates = vec![NestingItem::new("plate", block(DVec3::new(20.0, 20.0, 5.0)), 3)];
        let volume = BuildVolume { size_mm: DVec3::new(30.0, 30.0, 80.0) };
        let cap = LayerAreaCap { layer_mm: 0.1, area_mm2: 150.0 };
        let instance =
            NestingInstance::new(volume, 1.0, plates).expect("makes sense").with_layer_cap(cap).expect("a cap");
        let prepared = coarsely_prepared(&instance);
        let stacked = BoxStacker::new(&prepared.outlined).stack_copies(&[], &prepared.copies);
        assert!(stacked.len() == 3 && prepared.keeps_cap(&stacked), "{stacked:?}");
        assert!(stacked.iter().all(|plate| plate.bounds.size().z > 19.0), "{stacked:?}");
    }
}
