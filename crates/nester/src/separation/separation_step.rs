//! A smooth measure of the overlap of two parts, and the small motion of one of them that ends it (Gauss-Newton on all
//! contacts).

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Mat3, Vec3, Vec4};
use solids::Bounds;

use crate::{
    OrientationRule,
    shapes::{point_block::BlockMotion, shape::PreparedShape, sphere_tree::SphereTree},
};

/// Greatest rotation in one step, radians: contacts are linear in it.
pub(crate) const MAX_SPIN: f32 = 0.35;

/// A part as the approximate collision test sees it.
#[derive(Debug, Clone)]
pub(crate) struct CollisionProxy {
    pub(crate) shape: Arc<PreparedShape>,
    pub(crate) rotation: Mat3,
    pub(crate) center: Vec3,
    /// Bounds by the extreme points, mm.
    pub(crate) min: Vec3,
    pub(crate) max: Vec3,
}

impl CollisionProxy {
    /// A part at a pose.
    pub(crate) fn new(shape: Arc<PreparedShape>, turn: DQuat, place: DVec3) -> Self {
        let mut proxy = Self { shape, rotation: Mat3::IDENTITY, center: Vec3::ZERO, min: Vec3::ZERO, max: Vec3::ZERO };
        proxy.set_pose(turn, place);
        proxy
    }

    /// Moves the proxy to a pose.
    pub(crate) fn set_pose(&mut self, turn: DQuat, place: DVec3) {
        self.rotation = DMat3::from_quat(turn).as_mat3();
        self.center = place.as_vec3();
        let (min, max) = self.extreme_bounds();
        (self.min, self.max) = (self.center + min, self.center + max);
    }

    /// Bounds of the extreme points alone, from the center, mm.
    pub(crate) fn extreme_bounds(&self) -> (Vec3, Vec3) {
        let motion = BlockMotion::new(self.rotation, Vec3::ZERO);
        let (mut min, mut max) = ([Vec4::INFINITY; 3], [Vec4::NEG_INFINITY; 3]);
        for block in &self.shape.extreme_blocks {
            let turned = motion.move_block(block);
            for (axis, values) in [turned.x, turned.y, turned.z].into_iter().enumerate() {
                (min[axis], max[axis]) = (min[axis].min(values), max[axis].max(values));
            }
        }
        (Vec3::from_array(min.map(Vec4::min_element)), Vec3::from_array(max.map(Vec4::max_element)))
    }

    /// The same proxy raised by `lift` mm.
    pub(crate) fn raised_by(&self, lift: f32) -> Self {
        let up = Vec3::Z * lift;
        Self { center: self.center + up, min: self.min + up, max: self.max + up, ..self.clone() }
    }

    /// Its bounds, mm.
    pub(crate) fn bounds(&self) -> Bounds {
        Bounds { min: self.min.as_dvec3(), max: self.max.as_dvec3() }
    }

    /// Whether the bounds of two parts are nearer than `reach`.
    #[inline]
    pub(crate) fn is_near(&self, other: &Self, reach: f32) -> bool {
        let gap = (other.min - self.max).max(self.min - other.max).max(Vec3::ZERO);
        gap.length_squared() < reach * reach
    }

    /// One direction of the overlap: the points of `body`, which belong to this part, in the other part's distance
    /// grid. mm3.
    fn one_sided_energy(&self, body: &SphereTree, other: &Self, reach: f32) -> f32 {
        let back = other.rotation.transpose();
        let motion = BlockMotion::new(back * self.rotation, back * (self.center - other.center));
        let mut sum = 0.0;
        body.walk
            .visit_near_points(&other.shape.distance_field, &motion, reach, |_, _, distance| sum += reach - distance);
        sum * body.point_area
    }

    /// How much two parts are nearer than `reach`: surface area times depth, mm3; 0 when they are clear.
    pub(crate) fn overlap_energy(&self, other: &Self, reach: f32) -> f32 {
        0.5 * (self.one_sided_energy(&self.shape.fine_points, other, reach)
            + other.one_sided_energy(&other.shape.fine_points, self, reach))
    }

    /// The same with few points: cheaper, for comparing candidates.
    pub(crate) fn coarse_overlap_energy(&self, other: &Self, reach: f32) -> f32 {
        0.5 * (self.one_sided_energy(&self.shape.coarse_points, other, reach)
            + other.one_sided_energy(&other.shape.coarse_points, self, reach))
    }

    /// Adds to `push` the contacts that would move this part out of `other`.
    pub(crate) fn add_overlap_contacts(&self, other: &Self, reach: f32, weight: f32, push: &mut SeparationStep) {
        self.visit_near_points(other, reach, |near| {
            push.add_contact(near.arm, near.direction, reach - near.distance, 0.5 * weight * near.area);
        });
    }

    /// Calls `visit` with every surface point of one of the two parts that is nearer than `reach` to the other part.
    #[inline]
    pub(crate) fn visit_near_points(&self, other: &Self, reach: f32, mut visit: impl FnMut(NearPoint)) {
        let back = other.rotation.transpose();
        let turn = back * self.rotation;
        let motion = BlockMotion::new(turn, back * (self.center - other.center));
        let field = &other.shape.distance_field;
        let body = &self.shape.fine_points;
        body.walk.visit_near_points(field, &motion, reach, |point, there, distance| {
            let direction = other.rotation * field.gradient(there);
            visit(NearPoint { arm: self.rotation * point, direction, distance, area: body.point_area });
        });
        let motion = BlockMotion::new(turn.transpose(), self.rotation.transpose() * (other.center - self.center));
        let field = &self.shape.distance_field;
        let body = &other.shape.fine_points;
        body.walk.visit_near_points(field, &motion, reach, |_, there, distance| {
            let direction = self.rotation * -field.gradient(there);
            visit(NearPoint { arm: self.rotation * there, direction, distance, area: body.point_area });
        });
    }
}

/// A surface point of one of two parts that is near the other one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearPoint {
    /// From the first part's center to the point, mm.
    pub(crate) arm: Vec3,
    /// Unit direction in which the first part leaves the second.
    pub(crate) direction: Vec3,
    /// Distance of the point to the other part, mm.
    pub(crate) distance: f32,
    /// Surface area that the point represents, mm2.
    pub(crate) area: f32,
}

/// Normal equations of the motion (translation, then rotation about the center, scaled by `radius`) that resolves the
/// contacts.
#[derive(Debug, Clone)]
pub(crate) struct SeparationStep {
    matrix: [[f32; 6]; 6],
    right_side: [f32; 6],
    radius: f32,
    /// Weighted overlap: sum of weight x depth squared.
    pub(crate) energy: f32,
}

impl SeparationStep {
    /// Equations without contacts.
    pub(crate) fn new(radius: f32) -> Self {
        Self { matrix: [[0.0; 6]; 6], right_side: [0.0; 6], radius: radius.max(1e-3), energy: 0.0 }
    }

    /// Adds a contact: a point at `arm` from the center is to move by `depth` along `direction`.
    #[inline]
    pub(crate) fn add_contact(&mut self, arm: Vec3, direction: Vec3, depth: f32, weight: f32) {
        let spin = arm.cross(direction) / self.radius;
        let row = [direction.x, direction.y, direction.z, spin.x, spin.y, spin.z];
        for i in 0..6 {
            let scaled = weight * row[i];
            self.right_side[i] += scaled * depth;
            for (sum, &value) in self.matrix[i][..=i].iter_mut().zip(&row) {
                *sum += scaled * value;
            }
        }
        self.energy += weight * depth * depth;
    }

    /// Solves for the motion: translation in mm and rotation vector in radians, damped, restricted to what the rule
    /// allows.
    pub(crate) fn solve_motion(&self, rule: OrientationRule) -> (Vec3, Vec3) {
        let free = match rule {
            OrientationRule::Free => [true; 6],
            OrientationRule::Upright => [true, true, true, false, false, true],
            OrientationRule::Axis | OrientationRule::Fixed => [true, true, true, false, false, false],
        };
        let trace: f32 = (0..6).map(|i| self.matrix[i][i]).sum();
        let damping = 0.003 * trace + 1e-9;
        let mut lower = [[0.0_f32; 6]; 6];
        let mut solved = [0.0_f32; 6];
        // Cholesky decomposition. A coordinate that is not free has 1 on the diagonal and 0 on the right side.
        for i in 0..6 {
            for j in 0..=i {
                let known = if free[i] && free[j] { self.matrix[i][j] } else { 0.0 };
                let known = if i == j { if free[i] { known + damping } else { 1.0 } } else { known };
                let sum = known - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f32>();
                lower[i][j] = if i == j { sum.max(1e-12).sqrt() } else { sum / lower[j][j] };
            }
        }
        for i in 0..6 {
            let side = if free[i] { self.right_side[i] } else { 0.0 };
            solved[i] = (side - (0..i).map(|k| lower[i][k] * solved[k]).sum::<f32>()) / lower[i][i];
        }
        for i in (0..6).rev() {
            solved[i] = (solved[i] - (i + 1..6).map(|k| lower[k][i] * solved[k]).sum::<f32>()) / lower[i][i];
        }
        let step = Vec3::new(solved[0], solved[1], solved[2]);
        let spin = Vec3::new(solved[3], solved[4], solved[5]) / self.radius;
        (step.clamp_length_max(0.5 * self.radius + 1.0), spin.clamp_length_max(MAX_SPIN))
    }
}
