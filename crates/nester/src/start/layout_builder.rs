//! Builds the first layouts: places one part after the other at its lowest position in a voxel grid of bit columns, or
//! on top of the boxes of all others where that is lower or there is no such position. Every placement is confirmed on the
//! triangles.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    box_stacker::{BoxStacker, rotations_to_try},
    lowest_layers::LowestLayers,
    occupancy_grid::OccupancyGrid,
    recipe::PlacementRecipe,
};
use crate::{
    prepare::{
        layers::FilledLayers,
        prepared_instance::{PlacedItem, PreparedInstance, item_layer_areas, raised_bounds},
    },
    separation::{disassembly::can_be_removed, interlock_check::split_separable, proximity_grid::ProximityGrid},
    shapes::{part_raster::PartRaster, skyline::SkylineGrid},
};

/// Voxels by which a part is grown beyond half its clearance. Less growth wastes less space, but fails the exact test
/// more often.
const GROWTH_VOXELS: f64 = 0.45;
/// Least pitch of a finer builder, mm and relative to the clearance.
const LEAST_PITCH: (f64, f64) = (0.3, 0.15);
/// Greatest memory for remembered lowest layers, bytes.
const MAX_LOWEST_LAYER_BYTES: usize = 64 << 20;
/// Number of positions that may fail the exact test before a part is placed on top of the boxes of the others, although
/// other positions may be lower.
const MAX_FAILED_PLACES: usize = 100;
/// Number of positions that may lock the part before it is placed on top of the boxes.
const MAX_LOCKED_PLACES: usize = 6;
/// Number of raises to layers with free area before a part is placed on top of the boxes.
const MAX_LAYER_RAISES: usize = 64;

/// Voxel rasters of all items at all rotations tried. They are made when first needed and kept over all runs.
pub(crate) struct LayoutBuilder<'t> {
    prepared: &'t PreparedInstance,
    boxes: BoxStacker<'t>,
    /// Edge of a voxel, mm.
    pub(crate) pitch: f64,
    max_rotations: usize,
    rasters: BTreeMap<usize, Vec<PartRaster>>,
    /// Whether a position counts only if the part can be removed from there again.
    must_be_removable: bool,
    /// Work done: columns of voxels compared, and what costs about as much.
    pub(crate) steps: u64,
}

/// A layout that is being built.
#[derive(Clone)]
pub(crate) struct PartialLayout {
    pub(crate) items: Vec<PlacedItem>,
    occupancy: OccupancyGrid,
    skyline: SkylineGrid,
    proximity: ProximityGrid,
    lowest_layers: BTreeMap<usize, LowestLayers>,
    filled: FilledLayers,
}

impl<'t> LayoutBuilder<'t> {
    /// Creates a builder with a voxel pitch that suits the task: finer for few parts and large clearances.
    pub(crate) fn new(prepared: &'t PreparedInstance) -> Self {
        let distinct = prepared.prepared_items.iter().flatten().count().max(1);
        let columns = if prepared.copies.len() > 150 { 14_000.0 } else { 20_000.0 };
        let pitch = (prepared.room.x * prepared.room.y / columns).sqrt().max(0.3 * prepared.max_clearance_mm).max(0.5);
        let turns = (300 / distinct).clamp(4, 40);
        let boxes = BoxStacker::new(&prepared.outlined);
        Self {
            prepared,
            boxes,
            pitch,
            max_rotations: turns,
            rasters: BTreeMap::new(),
            must_be_removable: prepared.must_be_separable,
            steps: 0,
        }
    }

    /// A builder whose voxels are at most `factor` times finer, for lower first layouts that cost more.
    pub(crate) fn finer_by(prepared: &'t PreparedInstance, factor: f64) -> Self {
        let builder = Self::new(prepared);
        let least = LEAST_PITCH.0.max(LEAST_PITCH.1 * prepared.max_clearance_mm);
        Self { pitch: (builder.pitch / factor).max(least), ..builder }
    }

    /// The same builder, which tries at least this number of rotations of each item.
    pub(crate) fn with_rotations(self, least: usize) -> Self {
        Self { max_rotations: self.max_rotations.max(least), ..self }
    }

    /// A layout that contains the already placed pieces.
    pub(crate) fn start_layout(&self, standing: &[PlacedItem]) -> PartialLayout {
        let prepared = self.prepared;
        let mut stack = PartialLayout {
            items: Vec::with_capacity(standing.len()),
            occupancy: OccupancyGrid::new(
                prepared.room,
                prepared.max_clearance_mm,
                self.pitch,
                self.extra_height_voxels(),
            ),
            skyline: self.boxes.build_skyline(&[]),
            proximity: ProximityGrid::new(prepared.room),
            lowest_layers: BTreeMap::new(),
            filled: FilledLayers::new(prepared.outlined.layer_cap),
        };
        for zone in &prepared.zones {
            let half_mm = 0.5 * prepared.max_clearance_mm;
            // Parts are grown by half a clearance that does not apply to a zone. A thin zone still fills its middle
            // voxels.
            let thin_mm = 0.3 * self.pitch - 0.5 * zone.bounds.size().min_element();
            let reach_mm = (GROWTH_VOXELS * self.pitch - half_mm).max(thin_mm);
            let shape = &prepared.prepared_item(zone.item).shape;
            stack.occupancy.fill_solid(shape, &zone.pose, &zone.bounds, reach_mm, half_mm);
        }
        standing.iter().for_each(|piece| self.add_standing(&mut stack, piece.clone()));
        stack
    }

    /// Adds a piece that is already placed.
    pub(crate) fn add_standing(&self, stack: &mut PartialLayout, piece: PlacedItem) {
        self.mark_occupied(&mut stack.occupancy, &piece);
        stack.add_item(self.prepared, piece);
    }

    /// Voxels by which every part is extended upwards, so that clearances hold when it is raised.
    fn extra_height_voxels(&self) -> usize {
        (self.prepared.z_extra_mm / self.pitch).ceil() as usize
    }

    /// Places copies in the given order around the pieces already placed; copies that do not fit are left out. Returns
    /// `None` early when `enough` returns true. If interlocking is forbidden, locked parts are placed elsewhere at the end.
    pub(crate) fn build_separable(
        &mut self,
        recipe: &PlacementRecipe,
        order: &[(usize, u32)],
        standing: &[PlacedItem],
        enough: &mut dyn FnMut(u64) -> bool,
    ) -> Option<Vec<PlacedItem>> {
        let built = self.build_once(recipe, order, standing, f64::INFINITY, enough)?;
        self.make_separable(recipe, order, built, enough)
    }

    /// Places copies in the given order around the pieces already placed; copies that do not fit are left out, and parts
    /// may be locked. Returns `None` early when the layout reaches the height `worst_mm` or when `enough` returns true.
    pub(crate) fn build_once(
        &mut self,
        recipe: &PlacementRecipe,
        order: &[(usize, u32)],
        standing: &[PlacedItem],
        worst_mm: f64,
        enough: &mut dyn FnMut(u64) -> bool,
    ) -> Option<Vec<PlacedItem>> {
        self.must_be_removable = false;
        let built = self.place_copies(recipe, order, standing, worst_mm, enough);
        self.must_be_removable = self.prepared.must_be_separable;
        built
    }

    /// If interlocking is forbidden, takes out the parts that are locked and places them elsewhere; those for which there
    /// is no place are left out. Returns `None` when `enough` returns true.
    pub(crate) fn make_separable(
        &mut self,
        recipe: &PlacementRecipe,
        order: &[(usize, u32)],
        pieces: Vec<PlacedItem>,
        enough: &mut dyn FnMut(u64) -> bool,
    ) -> Option<Vec<PlacedItem>> {
        if !self.prepared.must_be_separable {
            return Some(pieces);
        }
        let (kept, dropped) = split_separable(self.prepared, pieces);
        if dropped.is_empty() {
            return Some(kept);
        }
        let again: BTreeSet<(usize, u32)> = dropped.iter().map(|p| (p.item, p.copy)).collect();
        let again: Vec<(usize, u32)> = order.iter().copied().filter(|copy| again.contains(copy)).collect();
        self.place_copies(recipe, &again, &kept, f64::INFINITY, enough)
    }

    /// Places copies in order around the pieces already placed.
    fn place_copies(
        &mut self,
        recipe: &PlacementRecipe,
        order: &[(usize, u32)],
        standing: &[PlacedItem],
        worst_mm: f64,
        enough: &mut dyn FnMut(u64) -> bool,
    ) -> Option<Vec<PlacedItem>> {
        let mut stack = self.start_layout(standing);
        for &copy in order {
            if enough(self.steps) {
                return None;
            }
            let placed = self.place_copy(recipe, copy, &mut stack);
            if placed && stack.items.last().is_some_and(|piece| piece.bounds.max.z >= worst_mm) {
                return None;
            }
        }
        Some(stack.items)
    }

    /// Places one more copy. Returns whether it fits.
    pub(crate) fn place_copy(
        &mut self,
        recipe: &PlacementRecipe,
        copy: (usize, u32),
        stack: &mut PartialLayout,
    ) -> bool {
        let Some(piece) = self.find_lowest_place(recipe, copy, stack) else { return false };
        stack.add_item(self.prepared, piece);
        true
    }

    fn mark_occupied(&self, occupancy: &mut OccupancyGrid, piece: &PlacedItem) {
        let half_mm = 0.5 * self.prepared.max_clearance_mm;
        let shape = &self.prepared.prepared_item(piece.item).shape;
        occupancy.fill_solid(shape, &piece.pose, &piece.bounds, half_mm + GROWTH_VOXELS * self.pitch, half_mm);
    }

    /// Returns the best lattice position that the exact test confirms, or a place on top of the boxes, and marks it as
    /// occupied.
    fn find_lowest_place(
        &mut self,
        recipe: &PlacementRecipe,
        copy: (usize, u32),
        stack: &mut PartialLayout,
    ) -> Option<PlacedItem> {
        let (prepared, pitch, lift) = (self.prepared, self.pitch, self.extra_height_voxels());
        let rasters = self.rasters.entry(copy.0).or_insert_with(|| {
            let turns = rotations_to_try(prepared.outlined.outlined_item(copy.0), prepared.room, self.max_rotations);
            let shape = &prepared.prepared_item(copy.0).shape;
            let (clearance_mm, fineness) = (prepared.max_clearance_mm, (pitch, GROWTH_VOXELS, lift));
            turns
                .into_iter()
                .map(|turn| PartRaster::new(shape, turn, clearance_mm, fineness, &mut self.steps))
                .collect()
        });
        let mut floors =
            stack.lowest_layers.remove(&copy.0).unwrap_or_else(|| LowestLayers::new(&stack.occupancy, rasters));
        let mut on_top = None;
        let mut found = None;
        let (mut failed, mut held, mut raises) = (0, 0, 0);
        while failed < MAX_FAILED_PLACES && held < MAX_LOCKED_PLACES && raises < MAX_LAYER_RAISES {
            let lowest = floors.lowest_scored_position(recipe, &stack.occupancy, rasters, &mut self.steps);
            let Some((at, node)) = lowest else { break };
            let raster = &rasters[at];
            let piece = prepared.place_item(copy, raster.rotation, stack.occupancy.center_at(raster, node));
            // Where many positions fail, the part may stand lower on top of the boxes of the others.
            if failed + held > 0 {
                let on_top = on_top.get_or_insert_with(|| self.boxes.place_on_top(copy, &stack.skyline, &stack.filled));
                if on_top.as_ref().is_some_and(|on_top| on_top.bounds.max.z <= piece.bounds.max.z) {
                    break;
                }
            }
            if !(prepared.is_inside(&piece, prepared.room.z) && stack.is_clear(prepared, &piece)) {
                floors.forbid_position(at, node);
                failed += 1;
            } else if let Some(layers) = stack.raise_needed_mm(prepared, &piece) {
                // The layers are full at every position on the base: all positions of this rotation wait for higher
                // layers.
                floors.raise_full_layers(at, node[2], (layers / pitch).ceil().max(1.0) as usize);
                raises += 1;
            // If each part can be removed from among those placed before it, all can be removed in the opposite order.
            } else if self.must_be_removable && !can_be_removed(prepared, &piece, &stack.items) {
                let reach = 0.25 * prepared.prepared_item(copy.0).shape.radius_mm / pitch;
                floors.forbid_positions_around(node, reach.ceil() as usize);
                held += 1;
            } else {
                stack.occupancy.fill_raster(raster, node);
                found = Some(piece);
                break;
            }
        }
        stack.remember_lowest_layers(copy.0, floors);
        if found.is_none() {
            found = on_top.unwrap_or_else(|| self.boxes.place_on_top(copy, &stack.skyline, &stack.filled));
            found.iter().for_each(|piece| self.mark_occupied(&mut stack.occupancy, piece));
        }
        found
    }
}

impl PartialLayout {
    /// The height by which a piece must be raised so that no layer exceeds the area cap, mm; `None` when it need not be
    /// raised.
    fn raise_needed_mm(&self, prepared: &PreparedInstance, piece: &PlacedItem) -> Option<f64> {
        if !self.filled.is_capped() {
            return None;
        }
        match self.filled.layers_to_raise(&item_layer_areas(prepared, piece)) {
            Some(0) => None,
            Some(layers) => Some(layers as f64 * prepared.outlined.layer_cap.layer_mm),
            None => Some(prepared.room.z),
        }
    }

    /// Whether a piece that is inside the walls can be added as it stands: it keeps its clearance, and no layer exceeds
    /// its cap.
    pub(crate) fn can_take(&self, prepared: &PreparedInstance, piece: &PlacedItem) -> bool {
        let near = self.proximity.query_near(&piece.bounds, prepared.proximity_mm());
        near.into_iter().all(|other| prepared.is_still_clear(piece, &self.items[other]))
            && (!self.filled.is_capped() || self.filled.can_add(&item_layer_areas(prepared, piece)))
    }

    fn add_item(&mut self, prepared: &PreparedInstance, piece: PlacedItem) {
        if self.filled.is_capped() {
            self.filled.add_part(&item_layer_areas(prepared, &piece));
        }
        self.proximity.insert_bounds(self.items.len(), &piece.bounds);
        self.skyline.add_box(&raised_bounds(&piece.bounds, prepared.z_extra_mm));
        self.items.push(piece);
    }

    /// Whether a piece keeps its clearance to all others. Exact.
    fn is_clear(&self, prepared: &PreparedInstance, piece: &PlacedItem) -> bool {
        let near = self.proximity.query_near(&piece.bounds, prepared.proximity_mm());
        near.into_iter()
            .map(|other| &self.items[other])
            .chain(&prepared.zones)
            .all(|other| prepared.is_clear(piece, other))
    }

    fn remember_lowest_layers(&mut self, item: usize, floors: LowestLayers) {
        if self.lowest_layers.values().map(LowestLayers::memory_bytes).sum::<usize>() + floors.memory_bytes()
            > MAX_LOWEST_LAYER_BYTES
        {
            self.lowest_layers.clear();
        }
        self.lowest_layers.insert(item, floors);
    }
}
