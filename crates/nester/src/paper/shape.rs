//! An item prepared for the paper's method: its trees, its initial orientation, and the meaning of its rotation genes.

use std::{
    f64::consts::{FRAC_PI_2, PI},
    sync::Arc,
};

use glam::{DMat3, DQuat, EulerRot};
use solids::{ClearanceTree, Mesh, Obb, ObbTree, Pose};

use crate::{
    NestingInstance, OrientationLimits, OrientationRule,
    orientation::rotations::axis_rotations,
    pollination::{GeneBoundary, GeneRange},
};

/// A prepared item.
pub(super) struct PaperShape {
    /// Exact distances for the final proof, and exact bounds.
    pub surface: Arc<ClearanceTree>,
    /// Collision test of the search.
    pub boxes: Arc<ObbTree>,
    /// The largest face of the part's box, mm2: larger ones are placed first (section 2.3.1, step 3).
    pub print_area_mm2: f64,
    /// The initial orientation of the search: the smallest extent upright, if the rule allows it.
    pub initial: DQuat,
    orientation: OrientationLimits,
    /// The axis rotations that the tilts allow.
    axis_turns: Vec<DQuat>,
}

/// Prepares all items of an instance; items with the same mesh share their trees.
pub(super) fn prepare_shapes(instance: &NestingInstance, reduce_tree: bool) -> Vec<PaperShape> {
    let mut known: Vec<(&Arc<Mesh>, f64, PaperShape)> = Vec::new();
    for (index, item) in instance.items().iter().enumerate() {
        let stop_height_mm = if reduce_tree { instance.clearance_between_mm(index, index) } else { 0.0 };
        let same_mesh = known.iter().find(|(mesh, ..)| Arc::ptr_eq(mesh, &item.mesh));
        let same_tree = known.iter().find(|(mesh, stop, _)| Arc::ptr_eq(mesh, &item.mesh) && *stop == stop_height_mm);
        let surface = same_mesh.map(|(.., s)| s.surface.clone());
        let boxes = same_tree.map(|(.., s)| s.boxes.clone());
        let surface = surface.unwrap_or_else(|| Arc::new(ClearanceTree::new(item.mesh.clone())));
        let boxes = boxes.unwrap_or_else(|| Arc::new(ObbTree::new(&item.mesh, stop_height_mm)));
        let shape = PaperShape {
            print_area_mm2: print_area_mm2(boxes.root()),
            initial: initial_rotation(&item.orientation, &boxes, &surface),
            axis_turns: axis_rotations().into_iter().filter(|&turn| item.orientation.allows_rotation(turn)).collect(),
            orientation: item.orientation.clone(),
            surface,
            boxes,
        };
        known.push((&item.mesh, stop_height_mm, shape));
    }
    known.into_iter().map(|(.., shape)| shape).collect()
}

impl PaperShape {
    /// The genes of a rotation: three angles from the initial orientation, an angle about z, the number of an axis rotation,
    /// or none.
    pub fn rotation_genes(&self) -> Vec<GeneRange> {
        let angle = GeneRange { lower: -PI, upper: PI, edge: GeneBoundary::Wrap };
        match self.orientation.rule {
            OrientationRule::Free => vec![angle; 3],
            OrientationRule::Upright => vec![angle],
            OrientationRule::Axis => {
                vec![GeneRange { lower: 0.0, upper: self.axis_turns.len().max(1) as f64, edge: GeneBoundary::Wrap }]
            }
            OrientationRule::Fixed => Vec::new(),
        }
    }

    /// Whether a decoded rotation obeys the item's rules; it does unless the rules contradict each other.
    pub fn allows_rotation(&self, turn: DQuat) -> bool {
        self.orientation.allows_rotation(turn)
    }

    /// The rotation that genes encode. It is allowed unless the rules contradict each other.
    pub fn decode_rotation(&self, genes: &[f64]) -> DQuat {
        match (self.orientation.rule, genes) {
            (OrientationRule::Free, &[z, y, x]) => {
                let turn = DQuat::from_euler(EulerRot::ZYX, z, y, x) * self.initial;
                self.orientation.nearest_allowed(turn).unwrap_or(self.initial)
            }
            (OrientationRule::Upright, &[z]) => DQuat::from_rotation_z(z) * self.initial,
            (OrientationRule::Axis, &[number]) => self.axis_turns.get(number as usize).copied().unwrap_or(self.initial),
            _ => self.initial,
        }
    }

    /// The genes of the initial orientation, rotated by multiples of 90 degrees about z.
    pub fn initial_genes(&self, quarters: u32) -> Vec<f64> {
        let turn = f64::from(quarters % 4) * FRAC_PI_2;
        let angle = if turn > PI { turn - 2.0 * PI } else { turn };
        match self.orientation.rule {
            OrientationRule::Free => vec![angle, 0.0, 0.0],
            OrientationRule::Upright => vec![angle],
            OrientationRule::Axis => {
                let wanted = DQuat::from_rotation_z(turn) * self.initial;
                let near = |i: usize| self.axis_turns[i].dot(wanted).abs();
                let number = (0..self.axis_turns.len()).max_by(|&i, &j| near(i).total_cmp(&near(j))).unwrap_or(0);
                vec![number as f64 + 0.5]
            }
            OrientationRule::Fixed => Vec::new(),
        }
    }
}

fn print_area_mm2(obb: &Obb) -> f64 {
    let size = obb.half_mm * 2.0;
    size.element_product() / size.min_element()
}

fn initial_rotation(orientation: &OrientationLimits, boxes: &ObbTree, surface: &ClearanceTree) -> DQuat {
    let size_at = |rotation: DQuat| surface.bounds_at(&Pose::new(rotation, glam::DVec3::ZERO)).size();
    let by = |value: &dyn Fn(DQuat) -> f64, rotations: Vec<DQuat>| {
        rotations.into_iter().min_by(|&a, &b| value(a).total_cmp(&value(b))).unwrap_or(DQuat::IDENTITY)
    };
    match orientation.rule {
        OrientationRule::Free => {
            let lying = smallest_extent_upright(boxes.root());
            orientation.nearest_allowed(lying).unwrap_or(lying)
        }
        OrientationRule::Upright => {
            let turns = (0..90).map(|degrees| DQuat::from_rotation_z(f64::from(degrees).to_radians()));
            by(&|q| size_at(q).x * size_at(q).y, turns.collect())
        }
        OrientationRule::Axis => by(
            &|q| size_at(q).z,
            axis_rotations().into_iter().filter(|&turn| orientation.allows_rotation(turn)).collect(),
        ),
        OrientationRule::Fixed => DQuat::IDENTITY,
    }
}

/// The rotation that takes the box's smallest extent to z and its largest to x.
fn smallest_extent_upright(obb: &Obb) -> DQuat {
    let axes = obb.pose.rotation_matrix();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| obb.half_mm[j].total_cmp(&obb.half_mm[i]));
    let (x, y) = (axes.col(order[0]), axes.col(order[1]));
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)).transpose()).normalize()
}
