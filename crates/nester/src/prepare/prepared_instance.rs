//! The prepared instance, and the exact tests of a layout on the triangles.

use std::{collections::BTreeSet, ops::Range, sync::Arc};

use glam::{DQuat, DVec3};
use solids::{Bounds, Mesh, Pose};

use super::{
    layers::{FilledLayers, PartLayerAreas},
    preparation::MeshPreparation,
};
use crate::{
    ItemPlacement, NestingInstance, NestingSolution, OrientationLimits, OrientationRule, SearchComponents,
    problem::{fit_check::WALL_SPARE_MM, reserved::ReservedZone},
    shapes::{
        outline::{OutlinedInstance, OutlinedItem},
        shape::{PreparedShape, ShapeDetail},
    },
};

/// Distance that two placements keep beyond their clearance, mm, so that rounding in a written file never breaks it.
pub(crate) const CLEARANCE_SPARE_MM: f64 = 1e-4;

/// An item that fits the volume, prepared.
#[derive(Debug, Clone)]
pub(crate) struct PreparedItem {
    pub(crate) shape: Arc<PreparedShape>,
    pub(crate) orientation: OrientationLimits,
    /// Clearance required for this item, mm. Between two items the greater one applies.
    pub(crate) clearance_mm: f64,
}

/// The prepared instance. `kinds` has one entry per item; `None` for items that fit in no allowed orientation.
#[derive(Debug, Clone)]
pub(crate) struct PreparedInstance {
    /// The outlines of the same items.
    pub(crate) outlined: Arc<OutlinedInstance>,
    pub(crate) prepared_items: Vec<Option<PreparedItem>>,
    /// All copies that fit into the empty volume, in order of precedence.
    pub(crate) copies: Vec<(usize, u32)>,
    pub(crate) room: DVec3,
    /// The greatest clearance of any item, mm.
    pub(crate) max_clearance_mm: f64,
    /// Keep-out zones, as pieces whose kinds come after those of the items.
    pub(crate) zones: Vec<PlacedItem>,
    /// Copies that never move.
    pub(crate) pinned: BTreeSet<(usize, u32)>,
    /// Clearances must also hold when either part is raised by up to this, mm.
    pub(crate) z_extra_mm: f64,
    /// Enabled components of the search.
    pub(crate) components: SearchComponents,
    /// Whether a layout is valid only if no part is locked.
    pub(crate) must_be_separable: bool,
}

impl PreparedInstance {
    /// Prepares every distinct mesh of the instance; `None` when the time for preparation runs out first. Interlocking
    /// is not checked yet.
    pub(crate) fn new(
        outlined: Arc<OutlinedInstance>,
        pins: BTreeSet<(usize, u32)>,
        preparation: &MeshPreparation<'_>,
        components: SearchComponents,
        nodes: usize,
        points: usize,
    ) -> Option<Self> {
        let detail = ShapeDetail { nodes, points, reach_mm: outlined.max_clearance_mm + 0.5 };
        let zones = || outlined.zones.iter().map(|zone| &zone.mesh);
        let items = outlined.outlined_items.iter().flatten().map(|c| &c.mesh);
        let meshes: Vec<Arc<Mesh>> = items.chain(zones()).cloned().collect();
        let mut shapes = preparation.prepare_shapes(&meshes, detail)?.into_iter();
        let kind = |candidate: &Option<OutlinedItem>| {
            let OutlinedItem { orientation, clearance_mm, .. } = candidate.as_ref()?;
            Some(PreparedItem { shape: shapes.next()?, orientation: orientation.clone(), clearance_mm: *clearance_mm })
        };
        let mut kinds: Vec<Option<PreparedItem>> = outlined.outlined_items.iter().map(kind).collect();
        let zone = |shape| {
            Some(PreparedItem { shape, orientation: OrientationRule::Fixed.into(), clearance_mm: ZONE_CLEARANCE })
        };
        kinds.extend(shapes.map(zone));
        let (copies, room) = (outlined.copies.clone(), outlined.room);
        let (reach_mm, z_extra_mm) = (outlined.max_clearance_mm, outlined.z_extra_mm);
        let mut prepared = Self {
            prepared_items: kinds,
            copies,
            room,
            max_clearance_mm: reach_mm,
            z_extra_mm,
            zones: Vec::new(),
            pinned: pins,
            components,
            must_be_separable: false,
            outlined,
        };
        let place = |zone: &ReservedZone| zone.bounds.center();
        let first = prepared.outlined.outlined_items.len();
        let zones = prepared.outlined.zones.iter().enumerate();
        prepared.zones =
            zones.map(|(at, zone)| prepared.place_item((first + at, 0), DQuat::IDENTITY, place(zone))).collect();
        Some(prepared)
    }

    /// Prepares some of the items at another detail. They stay as they are when the time for preparation runs out
    /// first.
    pub(crate) fn refine_shapes(
        &mut self,
        items: Range<usize>,
        preparation: &MeshPreparation<'_>,
        nodes: usize,
        points: usize,
    ) {
        let detail = ShapeDetail { nodes, points, reach_mm: self.max_clearance_mm + 0.5 };
        let mut kinds: Vec<&mut PreparedItem> = self.prepared_items[items].iter_mut().flatten().collect();
        let meshes: Vec<Arc<Mesh>> = kinds.iter().map(|kind| kind.shape.tree.mesh().clone()).collect();
        let Some(shapes) = preparation.prepare_shapes(&meshes, detail) else { return };
        kinds.iter_mut().zip(shapes).for_each(|(kind, shape)| kind.shape = shape);
    }

    /// The prepared item of a copy.
    pub(crate) fn prepared_item(&self, item: usize) -> &PreparedItem {
        self.prepared_items[item].as_ref().expect("only items that fit are nested")
    }

    /// Clearance between two items, mm.
    pub(crate) fn clearance_mm(&self, item1: usize, item2: usize) -> f64 {
        clearance_of_pair(self.prepared_item(item1).clearance_mm, self.prepared_item(item2).clearance_mm)
    }

    /// Places a copy at a rotation and a position of its center.
    pub(crate) fn place_item(&self, (item, copy): (usize, u32), turn: DQuat, place: DVec3) -> PlacedItem {
        let shape = &self.prepared_item(item).shape;
        let pose = shape.mesh_pose(turn, place);
        PlacedItem { item, copy, rotation: turn, center: place, pose, bounds: shape.tree.bounds_at(&pose) }
    }

    /// Whether a copy must not move: it has a fixed pose, or it is a zone.
    pub(crate) fn is_fixed(&self, copy: (usize, u32)) -> bool {
        copy.0 >= self.outlined.outlined_items.len() || self.pinned.contains(&copy)
    }

    /// Whether no layer exceeds the area cap.
    pub(crate) fn keeps_cap(&self, pieces: &[PlacedItem]) -> bool {
        let mut filled = FilledLayers::new(self.outlined.layer_cap);
        !filled.is_capped()
            || pieces.iter().all(|piece| {
                let slice = item_layer_areas(self, piece);
                let takes = filled.can_add(&slice);
                filled.add_part(&slice);
                takes
            })
    }

    /// Pieces whose bounds are further apart than this are clear, mm.
    pub(crate) fn proximity_mm(&self) -> f64 {
        self.max_clearance_mm + self.z_extra_mm + 2.0 * CLEARANCE_SPARE_MM
    }

    /// Heights at which the proxies are tested for overlap, mm. If parts may be raised by more than a clearance,
    /// heights in between are tested too.
    pub(crate) fn raise_offsets(&self) -> Vec<f32> {
        if self.z_extra_mm <= 0.0 {
            return vec![0.0];
        }
        let steps = (self.z_extra_mm / self.max_clearance_mm.max(1.0)).ceil().min(4.0) as i32;
        (-steps..=steps).map(|step| (self.z_extra_mm * f64::from(step) / f64::from(steps)) as f32).collect()
    }

    /// Whether a piece is inside the walls and below the height limit.
    pub(crate) fn is_inside(&self, piece: &PlacedItem, height_limit_mm: f64) -> bool {
        let room = Bounds { min: DVec3::ZERO, max: self.room.with_z(height_limit_mm.min(self.room.z)) };
        room.contains_bounds(&piece.bounds, WALL_SPARE_MM - 1e-7)
    }

    /// The distance at which the search counts two pieces as clear, mm.
    pub(crate) fn wanted_distance_mm(&self, one: &PlacedItem, other: &PlacedItem) -> f64 {
        self.clearance_mm(one.item, other.item) + CLEARANCE_SPARE_MM
    }

    /// Whether two pieces keep their clearance and neither is inside the other. Exact.
    pub(crate) fn is_clear(&self, one: &PlacedItem, other: &PlacedItem) -> bool {
        self.keeps_distance(one, other, self.wanted_distance_mm(one, other))
    }

    /// The same for pieces that were found clear before, with a tolerance for rounding in a file or a ledger.
    pub(crate) fn is_still_clear(&self, one: &PlacedItem, other: &PlacedItem) -> bool {
        self.keeps_distance(one, other, self.clearance_mm(one.item, other.item) + 0.5 * CLEARANCE_SPARE_MM)
    }

    /// Whether two pieces keep a distance over all allowed raises of either, and neither is inside the other. Exact.
    fn keeps_distance(&self, one: &PlacedItem, other: &PlacedItem, distance_mm: f64) -> bool {
        // The extra z clearance does not apply to zones.
        let zones = self.outlined.outlined_items.len();
        let extra_mm = if one.item.max(other.item) >= zones { 0.0 } else { self.z_extra_mm };
        if raised_bounds(&one.bounds, extra_mm).distance(&raised_bounds(&other.bounds, extra_mm)) >= distance_mm {
            return true;
        }
        let (tree1, tree2) = (&self.prepared_item(one.item).shape.tree, &self.prepared_item(other.item).shape.tree);
        let pose12 = one.pose.relative_pose_of(&other.pose);
        let is_near = match extra_mm > 0.0 {
            true => {
                let slide1 = one.pose.inverse().transform_direction(DVec3::Z * extra_mm);
                tree1.distance_sliding_mm(tree2, &pose12, slide1, distance_mm) < distance_mm
            }
            false => tree1.is_closer_than(tree2, &pose12, distance_mm),
        };
        !is_near && !self.encloses(one, other) && !self.encloses(other, one)
    }

    /// Whether a piece, whose surface does not meet that of another one, is inside of it or of a sealed cavity of it.
    pub(crate) fn encloses(&self, outer: &PlacedItem, inner: &PlacedItem) -> bool {
        let tree = |piece: &PlacedItem| &self.prepared_item(piece.item).shape.tree;
        outer.bounds.contains_bounds(&inner.bounds, 0.0)
            && tree(outer).contains_part(tree(inner), &outer.pose.relative_pose_of(&inner.pose))
    }
}

/// Marks a zone: no clearance to it is required.
const ZONE_CLEARANCE: f64 = -1.0;

/// The clearance that applies between two clearances, mm: the greater one, and none to a zone.
pub(crate) fn clearance_of_pair(one_mm: f64, other_mm: f64) -> f64 {
    if one_mm.min(other_mm) < 0.0 { 0.0 } else { one_mm.max(other_mm) }
}

/// One placed copy.
#[derive(Debug, Clone)]
pub(crate) struct PlacedItem {
    pub(crate) item: usize,
    pub(crate) copy: u32,
    pub(crate) rotation: DQuat,
    /// Position of the shape's center.
    pub(crate) center: DVec3,
    pub(crate) pose: Pose,
    /// Exact bounds.
    pub(crate) bounds: Bounds,
}

/// Bounds extended upwards by the height that is kept free above them.
pub(crate) fn raised_bounds(bounds: &Bounds, extra_mm: f64) -> Bounds {
    Bounds { min: bounds.min, max: bounds.max + DVec3::Z * extra_mm }
}

/// Top of the highest piece, mm.
pub(crate) fn height_mm(pieces: &[PlacedItem]) -> f64 {
    pieces.iter().map(|p| p.bounds.max.z).fold(0.0, f64::max)
}

/// The area that a piece fills in each layer.
pub(crate) fn item_layer_areas(prepared: &PreparedInstance, piece: &PlacedItem) -> PartLayerAreas {
    PartLayerAreas::from_mesh(
        prepared.prepared_item(piece.item).shape.tree.mesh(),
        &piece.pose,
        prepared.outlined.layer_cap.layer_mm,
    )
}

/// Returns the solution that consists of the pieces.
pub(crate) fn solution_from_items(
    instance: &NestingInstance,
    pieces: &[PlacedItem],
    evaluations: u64,
) -> NestingSolution {
    let mut placements: Vec<ItemPlacement> =
        pieces.iter().map(|p| ItemPlacement { item: p.item, copy: p.copy, pose: p.pose }).collect();
    placements.sort_by_key(|p| (p.item, p.copy));
    // Fixed copies get exactly the pose that was given, to the last digit.
    for pin in instance.pinned() {
        if let Ok(at) = placements.binary_search_by_key(&(pin.item, pin.copy), |p| (p.item, p.copy)) {
            placements[at].pose = pin.pose;
        }
    }
    let placed = |copy: (usize, u32)| placements.binary_search_by_key(&copy, |p| (p.item, p.copy)).is_ok();
    let all = (instance.items().iter().enumerate()).flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)));
    let unplaced = all.filter(|&copy| !placed(copy)).collect();
    NestingSolution { unplaced, height_mm: height_mm(pieces), evaluations, placements }
}
