//! The farm's view of a layout: which copies of which parts are placed where. The nester speaks of items, the ledger of
//! parts; this file converts between them.

use std::{
    cmp::Ordering,
    collections::{BTreeSet, HashMap, HashSet},
    sync::Arc,
};

use build_file::OrderWords;
use delivery::build::{BuildPart, PartPlacement};
use glam::{DQuat, DVec3};
use ledger::{PartId, PartRow, PartTerms, PlacementRow, WaitingPart};
use nester::{InstanceError, ItemPlacement, NestingInstance, NestingItem, NestingSolution};
use serde::{Deserialize, Serialize};
use settings::{FarmZone, MachineProfile};
use solids::{Mesh, Pose};

/// A copy of a part: the unit that is never lost and never printed twice.
pub type CopyId = (PartId, u32);

/// One copy at a pose in the build volume's frame (its lower front left corner is the origin), mm.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutPlacement {
    /// The copy.
    pub copy: CopyId,
    /// Mesh frame -> build volume frame.
    pub pose: Pose,
}

/// What the order of a part says for the people who unpack it. Due dates are those of `zone`.
fn order_words(terms: &PartTerms, zone: &FarmZone) -> OrderWords {
    let some = |text: String| Some(text).filter(|text| !text.is_empty());
    OrderWords {
        order: some(terms.order_name.clone()),
        due: some(due_words(terms, zone)),
        note: some(terms.note.clone()),
        reference: some(terms.reference.clone()),
        // Its build says it.
        material: None,
    }
}

/// The due date of a part as people read it, "" = none.
pub(crate) fn due_words(terms: &PartTerms, zone: &FarmZone) -> String {
    terms.due_at.map_or_else(String::new, |at| zone.format_due(at.0, &terms.due_text))
}

/// A layout of a batch.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BatchLayout {
    /// Placed copies.
    pub placed: Vec<LayoutPlacement>,
    /// Copies that were tried and found no place, in order of precedence.
    pub unplaced: Vec<CopyId>,
    /// Top of the highest placement above the volume's floor, mm.
    pub height_mm: f64,
    /// Part volume / (base area x height).
    pub density: f64,
    /// Volume of the placed copies, mm3.
    pub part_volume_mm3: f64,
    /// Evaluations of the search.
    pub evaluations: u64,
}

impl BatchLayout {
    /// The placed copies.
    pub fn copies(&self) -> BTreeSet<CopyId> {
        self.placed.iter().map(|placed| placed.copy).collect()
    }
}

/// Parts with their meshes and the copies of them that are to be nested, in order of precedence. A part may be there
/// twice: copies that stand in the open build go before its others.
#[derive(Debug, Clone)]
pub struct NestingBatch {
    /// Parts in order of precedence.
    pub parts: Vec<NestingPart>,
}

/// A part of a batch.
#[derive(Debug, Clone)]
pub struct NestingPart {
    /// The row of the part.
    pub part: PartRow,
    /// Its mesh.
    pub mesh: Arc<Mesh>,
    /// Wanted copy numbers.
    pub copies: Vec<u32>,
}

impl NestingBatch {
    /// The instance for the nester.
    pub fn create_instance(&self, profile: &MachineProfile) -> Result<NestingInstance, InstanceError> {
        let items = self.parts.iter().map(|p| NestingItem {
            name: format!("{} (part {})", p.part.name, p.part.id.0),
            mesh: p.mesh.clone(),
            copies: p.copies.len() as u32,
            orientation: p.part.orientation_limits(),
            clearance_mm: p.part.terms.clearance_mm,
        });
        profile.to_machine().create_instance(items.collect())
    }

    /// The parts for a build file, in the same order. Due dates are those of `zone`.
    pub fn build_parts(&self, zone: &FarmZone) -> Vec<BuildPart> {
        let build_part = |NestingPart { part, mesh, copies }: &NestingPart| BuildPart {
            name: part.name.clone(),
            object_name: if part.solid.object_name.is_empty() {
                part.name.clone()
            } else {
                part.solid.object_name.clone()
            },
            part_number: part.id.to_string(),
            source_name: part.name.clone(),
            source_hash: part.file.content_hash.clone(),
            content_hash: format!("{}-{}", part.file.content_hash, part.solid.object_index),
            mesh: mesh.clone(),
            copies: copies.clone(),
            orientation: part.orientation_limits(),
            clearance_mm: part.terms.clearance_mm,
            words: order_words(&part.terms, zone),
        };
        self.parts.iter().map(build_part).collect()
    }

    /// The placed copies of a layout, with the indices of [`NestingBatch::build_parts`].
    pub fn part_placements(&self, layout: &BatchLayout) -> Vec<PartPlacement> {
        let index: HashMap<PartId, usize> = self.parts.iter().enumerate().map(|(at, p)| (p.part.id, at)).collect();
        let placed =
            |p: &LayoutPlacement| Some(PartPlacement { part: *index.get(&p.copy.0)?, copy: p.copy.1, pose: p.pose });
        layout.placed.iter().filter_map(placed).collect()
    }

    /// An earlier layout as placements of this batch; copies that are not in the batch are left out.
    pub fn matching_placements(&self, placed: &[LayoutPlacement]) -> Vec<ItemPlacement> {
        let mut index: HashMap<CopyId, (usize, u32)> = HashMap::new();
        for (item, part) in self.parts.iter().enumerate() {
            for (number, &copy) in part.copies.iter().enumerate() {
                index.insert((part.part.id, copy), (item, number as u32));
            }
        }
        (placed.iter())
            .filter_map(|p| index.get(&p.copy).map(|&(item, copy)| ItemPlacement { item, copy, pose: p.pose }))
            .collect()
    }

    /// The earlier layout to continue from: of those that place the most copies of the batch, the lowest.
    pub fn lowest_start(&self, starts: &[Vec<LayoutPlacement>]) -> Vec<ItemPlacement> {
        let top_mm = |p: &ItemPlacement| self.parts[p.item].mesh.bounds_at(&p.pose).max.z;
        let height_mm = |placements: &[ItemPlacement]| placements.iter().map(top_mm).fold(0.0, f64::max);
        let starts = starts.iter().map(|placed| self.matching_placements(placed));
        let better = |best: Vec<ItemPlacement>, other: Vec<ItemPlacement>| match other.len().cmp(&best.len()) {
            Ordering::Greater => other,
            Ordering::Equal if height_mm(&other) < height_mm(&best) => other,
            _ => best,
        };
        starts.reduce(better).unwrap_or_default()
    }

    /// Converts a solution of [`NestingBatch::instance`] to parts and copies.
    pub fn layout_from_solution(&self, instance: &NestingInstance, solution: &NestingSolution) -> BatchLayout {
        BatchLayout {
            placed: self.layout_placements(&solution.placements),
            unplaced: solution.unplaced.iter().map(|&(item, copy)| self.copy_id(item, copy)).collect(),
            height_mm: solution.height_mm,
            density: solution.density(instance),
            part_volume_mm3: solution.part_volume_mm3(instance),
            evaluations: solution.evaluations,
        }
    }

    /// Placements of [`NestingBatch::create_instance`] as those of parts and copies.
    pub fn layout_placements(&self, placements: &[ItemPlacement]) -> Vec<LayoutPlacement> {
        let named = |p: &ItemPlacement| LayoutPlacement { copy: self.copy_id(p.item, p.copy), pose: p.pose };
        placements.iter().map(named).collect()
    }

    fn copy_id(&self, item: usize, copy: u32) -> CopyId {
        (self.parts[item].part.id, self.parts[item].copies[copy as usize])
    }

    /// The batch without the copies that a layout leaves out.
    pub fn placed_only(&self, layout: &BatchLayout) -> Self {
        let placed: HashSet<CopyId> = layout.placed.iter().map(|p| p.copy).collect();
        let mut batch = self.clone();
        batch.parts.iter_mut().for_each(|p| p.copies.retain(|&copy| placed.contains(&(p.part.id, copy))));
        batch
    }
}

impl NestingBatch {
    /// The batch with each part once, as a build file holds it.
    #[must_use]
    pub fn merge_parts(self) -> Self {
        let mut parts: Vec<NestingPart> = Vec::with_capacity(self.parts.len());
        let mut index: HashMap<PartId, usize> = HashMap::new();
        for more in self.parts {
            match index.get(&more.part.id) {
                Some(&at) => {
                    parts[at].copies.extend(more.copies);
                    parts[at].copies.sort_unstable();
                }
                None => {
                    index.insert(more.part.id, parts.len());
                    parts.push(more);
                }
            }
        }
        Self { parts }
    }
}

/// All copies of waiting parts, in order of precedence.
pub fn waiting_copy_ids(waiting: &[WaitingPart]) -> Vec<CopyId> {
    waiting.iter().flat_map(|w| w.copies.iter().map(|&c| (w.part.id, c))).collect()
}

/// A placed copy as stored in the ledger: part, copy, quaternion, translation (mm).
#[derive(Serialize, Deserialize)]
struct StoredPlacement(i64, u32, [f64; 4], [f64; 3]);

impl BatchLayout {
    /// The placed copies as JSON, so that the search continues from them after a restart.
    pub fn to_json(&self) -> String {
        serde_json::to_string(&stored_placements(&self.placed)).unwrap_or_default()
    }
}

/// Several layouts as JSON, so that the search continues from them after a restart.
pub fn layouts_to_json(layouts: &[Vec<LayoutPlacement>]) -> String {
    let stored: Vec<Vec<StoredPlacement>> = layouts.iter().map(|placed| stored_placements(placed)).collect();
    serde_json::to_string(&stored).unwrap_or_default()
}

/// Stored layouts.
///
/// # Errors
/// They cannot be read.
pub fn layouts_from_json(json: &str) -> serde_json::Result<Vec<Vec<LayoutPlacement>>> {
    let stored: Vec<Vec<StoredPlacement>> = serde_json::from_str(json)?;
    Ok(stored.into_iter().map(read_placements).collect())
}

/// The placed copies of a stored layout; an unreadable layout counts as empty.
pub fn placed_from_json(json: &str) -> Vec<LayoutPlacement> {
    read_placements(serde_json::from_str(json).unwrap_or_default())
}

fn stored_placements(placed: &[LayoutPlacement]) -> Vec<StoredPlacement> {
    (placed.iter())
        .map(|p| StoredPlacement(p.copy.0.0, p.copy.1, p.pose.rotation.to_array(), p.pose.translation.to_array()))
        .collect()
}

fn read_placements(stored: Vec<StoredPlacement>) -> Vec<LayoutPlacement> {
    let read = |StoredPlacement(part, copy, rotation, translation)| {
        let pose = Pose::from_stored(DQuat::from_array(rotation), DVec3::from_array(translation)).ok()?;
        Some(LayoutPlacement { copy: (PartId(part), copy), pose })
    };
    stored.into_iter().filter_map(read).collect()
}

/// The placed copies of a proved build, from its poses in the ledger, which are in the machine's frame.
pub fn placed_from_rows(rows: &[PlacementRow], origin_mm: DVec3) -> Vec<LayoutPlacement> {
    let in_volume = |pose: Pose| Pose { translation: pose.translation - origin_mm, ..pose };
    rows.iter()
        .filter_map(|row| Some(LayoutPlacement { copy: (row.part_id, row.copy), pose: in_volume(row.pose()?) }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stored_layout_comes_back_to_the_last_digit() {
        let pose = Pose::new(DQuat::from_rotation_x(0.3), DVec3::new(1.0 / 3.0, 2e-9, 170.25));
        let layout =
            BatchLayout { placed: vec![LayoutPlacement { copy: (PartId(7), 3), pose }], ..BatchLayout::default() };
        let back = placed_from_json(&layout.to_json());
        assert_eq!(back[0].copy, (PartId(7), 3));
        assert_eq!(back[0].pose, pose);
        assert!(placed_from_json("no json").is_empty());
        let both = [layout.placed, back];
        assert_eq!(layouts_from_json(&layouts_to_json(&both)).unwrap()[0][0].pose, both[1][0].pose);
        assert!(layouts_from_json("[[[7, 3]]]").is_err() && layouts_from_json("[]").unwrap().is_empty());
    }

    #[test]
    fn no_pose_of_a_stored_layout_differs_in_a_single_bit() {
        // Numbers with as many digits as a pose of a search has.
        let number = |step: u32| (f64::from(step) * 0.754_877_666_246_692_8).fract() * 300.0;
        let place = |step: u32| LayoutPlacement {
            copy: (PartId(1), step),
            pose: Pose::new(
                DQuat::from_rotation_y(number(step)),
                DVec3::new(number(step + 7), number(step + 31), number(step + 59)),
            ),
        };
        let placed: Vec<LayoutPlacement> = (0..1000).map(place).collect();
        let back = layouts_from_json(&layouts_to_json(std::slice::from_ref(&placed))).unwrap().remove(0);
        let changed = placed.iter().zip(&back).filter(|(one, other)| one.pose != other.pose).count();
        assert_eq!(changed, 0, "of {} poses", placed.len());
    }
}
