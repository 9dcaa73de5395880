//! Parts that an eye confuses are set apart: whoever breaks out a build finds the copies of each together.

use std::{collections::BTreeMap, sync::Arc};

use glam::DVec3;
use solids::{Mesh, Pose};

use crate::{
    InterlockRule, ItemPlacement, NestingConfig, NestingInstance, NestingItem,
    proof::{LayoutProver, PlacedSolid},
};

/// Greatest difference of sizes and volumes that an eye does not see, as a share.
const UNSEEN_SHARE: f64 = 0.02;
/// Groups of different meshes that are tried by themselves, at most.
const MAX_SINGLE_TRIES: usize = 3;
/// Heights that differ by less are equal, mm.
const SAME_HEIGHT_MM: f64 = 1e-6;

/// What an eye sees of a part that may lie in any way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookMeasures {
    /// Edge lengths of the bounds in ascending order, and the edge length of a cube with the volume, mm.
    lengths_mm: [f64; 4],
}

impl LookMeasures {
    /// The measures of a mesh.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let mut size = mesh.bounds().size().to_array();
        size.sort_by(f64::total_cmp);
        let [a, b, c] = size;
        Self { lengths_mm: [a, b, c, mesh.volume_mm3().abs().cbrt()] }
    }

    /// Whether two parts look the same, such as the left and the right one of a pair: each length differs by 2 % of the
    /// longest edge at most.
    pub fn looks_like(&self, other: &Self) -> bool {
        let (own, others) = (&self.lengths_mm, &other.lengths_mm);
        let unseen_mm = UNSEEN_SHARE * own[2].max(others[2]);
        own.iter().zip(others).all(|(a, b)| (a - b).abs() <= unseen_mm)
    }
}

/// Exchanges the places of copies that look alike so that those of each kind stand together: equal meshes always, others
/// where the layout is still proved, comes apart if `config` demands that, and is exactly as high. The layout stays as it is
/// otherwise. `kinds` tells the kind of each item: copies of one kind, such as those of one order, need not be told apart.
///
/// # Panics
/// If there are not as many kinds as items.
///
/// ```
/// use std::sync::Arc;
/// use glam::{DQuat, DVec3};
/// use nester::{BuildVolume, ItemPlacement, NestingConfig, NestingInstance, NestingItem, set_look_alikes_apart};
/// use solids::{Mesh, Pose};
///
/// // Two orders of the same cube, which stand in turns.
/// let cube = Arc::new(Mesh::cuboid(DVec3::splat(10.0))?);
/// let items = ["Brandt", "Acme"].map(|order| NestingItem::new(order, cube.clone(), 2));
/// let instance = NestingInstance::new(BuildVolume { size_mm: DVec3::splat(80.0) }, 2.0, items.to_vec())?;
/// let at = |item, copy, x| ItemPlacement { item, copy, pose: Pose::new(DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0)) };
/// let mut placements = vec![at(0, 0, 0.0), at(1, 0, 20.0), at(0, 1, 40.0), at(1, 1, 60.0)];
/// set_look_alikes_apart(&instance, &NestingConfig::default(), &[0, 1], &mut placements);
/// assert_eq!(placements.iter().map(|placed| placed.item).collect::<Vec<_>>(), [0, 0, 1, 1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn set_look_alikes_apart(
    instance: &NestingInstance,
    config: &NestingConfig,
    kinds: &[usize],
    placements: &mut Vec<ItemPlacement>,
) {
    assert_eq!(kinds.len(), instance.items().len(), "each item has a kind");
    // Pinned copies stay what they are.
    if !instance.pinned().is_empty() {
        return;
    }
    let items = instance.items();
    let is_equal =
        |a: usize, b: usize| is_same_mesh(&items[a].mesh, &items[b].mesh) && is_asked_alike(&items[a], &items[b]);
    exchange_within(items, kinds, &groups_of(items.len(), is_equal), placements);
    // Other meshes at the same places change how full the layers are.
    if instance.layer_cap().cap_mm2().is_some() {
        return;
    }
    let looks: Vec<_> = items.iter().map(|item| LookMeasures::of_mesh(&item.mesh)).collect();
    let is_alike = |a: usize, b: usize| looks[a].looks_like(&looks[b]) && is_asked_alike(&items[a], &items[b]);
    let mut groups = groups_of(items.len(), is_alike);
    groups.retain(|group| group.iter().any(|&item| !is_same_mesh(&items[item].mesh, &items[group[0]].mesh)));
    // All at once, or else the first ones by themselves: each try costs a proof.
    let all = std::iter::once(groups.as_slice());
    for tried_groups in all.chain(groups.chunks(1).take(MAX_SINGLE_TRIES)) {
        let mut tried = placements.clone();
        if exchange_within(items, kinds, tried_groups, &mut tried) && is_as_good(instance, config, placements, &tried) {
            *placements = tried;
            if tried_groups.len() == groups.len() {
                return;
            }
        }
    }
}

/// Whether two meshes are equal, wherever they are in memory.
fn is_same_mesh(a: &Arc<Mesh>, b: &Arc<Mesh>) -> bool {
    Arc::ptr_eq(a, b) || a.vertices() == b.vertices() && a.triangles() == b.triangles()
}

/// Whether copies of two items may have the same rotations and distances.
fn is_asked_alike(a: &NestingItem, b: &NestingItem) -> bool {
    a.orientation == b.orientation && a.clearance_mm == b.clearance_mm
}

/// The groups of two items or more that are alike, also over others.
fn groups_of(items: usize, is_alike: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for item in 0..items {
        let (own, others): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(|&member| is_alike(member, item)));
        groups = others;
        groups.push(own.into_iter().flatten().chain([item]).collect());
    }
    groups.retain(|group| group.len() > 1);
    groups
}

/// Gives the places of each group to its kinds in turn, along the axis on which the places reach farthest. Returns whether
/// anything changed.
fn exchange_within(
    items: &[NestingItem],
    kinds: &[usize],
    groups: &[Vec<usize>],
    placements: &mut [ItemPlacement],
) -> bool {
    let before = placements.to_vec();
    let centre = |placed: &ItemPlacement| placed.pose.transform_point(items[placed.item].mesh.bounds().center());
    for group in groups {
        let mut places: Vec<usize> = (0..before.len()).filter(|&at| group.contains(&before[at].item)).collect();
        let centres: Vec<DVec3> = places.iter().map(|&at| centre(&before[at])).collect();
        let (low, high) = (centres.iter().copied().reduce(DVec3::min), centres.iter().copied().reduce(DVec3::max));
        let (Some(low), Some(high)) = (low, high) else { continue };
        let axis = (high - low).max_position();
        places.sort_by(|&a, &b| centre(&before[a])[axis].total_cmp(&centre(&before[b])[axis]));
        // The kinds in the order in which they stand now, so that little changes.
        let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for &at in &places {
            let (sum, count) = sums.entry(kinds[before[at].item]).or_default();
            (*sum, *count) = (*sum + centre(&before[at])[axis], *count + 1.0);
        }
        let mean = |copy: &ItemPlacement| sums.get(&kinds[copy.item]).map_or(0.0, |(sum, count)| sum / count);
        let mut copies: Vec<&ItemPlacement> = places.iter().map(|&at| &before[at]).collect();
        copies.sort_by(|a, b| mean(a).total_cmp(&mean(b)).then(kinds[a.item].cmp(&kinds[b.item])));
        for (&at, copy) in places.iter().zip(copies) {
            let pose = pose_at(&before[at], &items[before[at].item].mesh, &items[copy.item].mesh);
            placements[at] = ItemPlacement { pose, ..*copy };
        }
    }
    placements != before
}

/// The pose of another mesh in the place of a copy: turned as that is, with the same middle.
fn pose_at(placed: &ItemPlacement, standing: &Arc<Mesh>, moving: &Arc<Mesh>) -> Pose {
    if is_same_mesh(standing, moving) {
        return placed.pose;
    }
    let offset = standing.bounds().center() - moving.bounds().center();
    Pose::new(placed.pose.rotation, placed.pose.translation + placed.pose.rotation * offset)
}

/// Whether a layout is proved, comes apart if it must, and is as high as before.
fn is_as_good(
    instance: &NestingInstance,
    config: &NestingConfig,
    before: &[ItemPlacement],
    after: &[ItemPlacement],
) -> bool {
    let top_mm = |placed: &ItemPlacement| instance.items()[placed.item].mesh.bounds_at(&placed.pose).max.z;
    let height_mm = |placements: &[ItemPlacement]| placements.iter().map(top_mm).fold(0.0, f64::max);
    if (height_mm(after) - height_mm(before)).abs() > SAME_HEIGHT_MM {
        return false;
    }
    let bodies = PlacedSolid::of_layout(instance, after);
    let prover = LayoutProver::new(&bodies, config.threads);
    prover.prove_layout(instance.volume().size_mm, instance.clearance_z_extra_mm(), &instance.keep_out()).is_proved()
        && (config.effective_interlock() != InterlockRule::Forbid || prover.find_removal_order().locked.is_empty())
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::{BuildVolume, tests::testing::block};

    /// Plates that stand in turns along x, `step_mm` from each other, the second kind `longer_mm` longer along x.
    fn in_turns(step_mm: f64, longer_mm: f64) -> (NestingInstance, Vec<ItemPlacement>) {
        let plates = [0.0, longer_mm].map(|more| block(DVec3::new(20.0 + more, 30.0, 5.0)));
        let items = plates.map(|plate| NestingItem::new("plate", plate, 3));
        let volume = BuildVolume { size_mm: DVec3::new(200.0, 40.0, 10.0) };
        let at = |place: usize| {
            let pose = Pose::new(DQuat::IDENTITY, DVec3::X * (1.0 + step_mm * place as f64));
            ItemPlacement { item: place % 2, copy: (place / 2) as u32, pose }
        };
        (NestingInstance::new(volume, 2.0, items.to_vec()).unwrap(), (0..6).map(at).collect())
    }

    fn items_of(placements: &[ItemPlacement]) -> Vec<usize> {
        placements.iter().map(|placed| placed.item).collect()
    }

    #[test]
    fn parts_of_nearly_one_size_change_places_where_there_is_room() {
        let (instance, mut placements) = in_turns(25.0, 0.3);
        set_look_alikes_apart(&instance, &NestingConfig::default(), &[0, 1], &mut placements);
        assert_eq!(items_of(&placements), [0, 0, 0, 1, 1, 1]);
        assert!(prove_all(&instance, &placements));
        let mut copies: Vec<_> = placements.iter().map(|placed| (placed.item, placed.copy)).collect();
        copies.sort_unstable();
        assert_eq!(copies, [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)], "each copy is there once");
    }

    #[test]
    fn parts_of_nearly_one_size_stay_where_the_clearance_would_be_too_small() {
        let (instance, mut placements) = in_turns(22.15, 0.3);
        // The longer plates have 0.3 mm more before them.
        for placed in placements.iter_mut().filter(|placed| placed.item == 1) {
            placed.pose.translation.x -= 0.15;
        }
        let before = placements.clone();
        assert!(prove_all(&instance, &before));
        set_look_alikes_apart(&instance, &NestingConfig::default(), &[0, 1], &mut placements);
        assert_eq!(placements, before);
    }

    #[test]
    fn parts_that_differ_or_were_asked_differently_stay() {
        let (instance, mut placements) = in_turns(30.0, 4.0);
        let before = placements.clone();
        set_look_alikes_apart(&instance, &NestingConfig::default(), &[0, 1], &mut placements);
        assert_eq!(placements, before);
        let mut items = in_turns(30.0, 0.0).0.items().to_vec();
        items[1] = items[1].clone().with_clearance(3.0);
        let asked = NestingInstance::new(instance.volume(), 2.0, items).unwrap();
        set_look_alikes_apart(&asked, &NestingConfig::default(), &[0, 1], &mut placements);
        assert_eq!(placements, before);
    }

    fn prove_all(instance: &NestingInstance, placements: &[ItemPlacement]) -> bool {
        crate::prove_layout(instance, placements).is_proved()
    }
}
