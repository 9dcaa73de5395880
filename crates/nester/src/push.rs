//! How much two parts overlap, smoothly, and which small motion of one of them ends it (Gauss-Newton on all contacts).

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Mat3, Vec3};
use solids::Bounds;

use super::{OrientationRule, body::Body, shape::Shape};

/// A part as the guides see it.
#[derive(Debug, Clone)]
pub(crate) struct Guide {
    pub(crate) shape: Arc<Shape>,
    pub(crate) turn: Mat3,
    pub(crate) place: Vec3,
    /// Bounds by the extreme points, mm.
    pub(crate) min: Vec3,
    pub(crate) max: Vec3,
}

impl Guide {
    /// A part at a pose.
    pub(crate) fn new(shape: Arc<Shape>, turn: DQuat, place: DVec3) -> Self {
        let mut guide = Self { shape, turn: Mat3::IDENTITY, place: Vec3::ZERO, min: Vec3::ZERO, max: Vec3::ZERO };
        guide.set(turn, place);
        guide
    }

    /// Moves it.
    pub(crate) fn set(&mut self, turn: DQuat, place: DVec3) {
        self.turn = DMat3::from_quat(turn).as_mat3();
        self.place = place.as_vec3();
        let turned = self.shape.extremes_f32.iter().map(|&p| self.turn * p);
        let (min, max) = turned.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        self.min = self.place + min;
        self.max = self.place + max;
    }

    /// The same part higher by `lift` mm.
    pub(crate) fn raised(&self, lift: f32) -> Self {
        let up = Vec3::Z * lift;
        Self { place: self.place + up, min: self.min + up, max: self.max + up, ..self.clone() }
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

    /// Half the overlap: of `body`, this part's points, in the other's distance grid. mm3.
    fn half_energy(&self, body: &Body, other: &Self, reach: f32) -> f32 {
        let back = other.turn.transpose();
        let (turn, shift) = (back * self.turn, back * (self.place - other.place));
        let field = &other.shape.field;
        let mut sum = 0.0;
        body.walk(
            |center, radius| field.distance(turn * center + shift) < reach + radius,
            |point| {
                let depth = reach - field.distance(turn * point + shift);
                if depth > 0.0 {
                    sum += depth;
                }
            },
        );
        sum * body.point_area
    }

    /// How much two parts are nearer than `reach`: surface times depth, mm3; 0 when they are clear.
    pub(crate) fn energy(&self, other: &Self, reach: f32) -> f32 {
        0.5 * (self.half_energy(&self.shape.fine, other, reach) + other.half_energy(&other.shape.fine, self, reach))
    }

    /// The same by few points: cheaper, for candidates.
    pub(crate) fn coarse_energy(&self, other: &Self, reach: f32) -> f32 {
        0.5 * (self.half_energy(&self.shape.coarse, other, reach) + other.half_energy(&other.shape.coarse, self, reach))
    }

    /// Adds to `push` what would move this part out of `other`.
    pub(crate) fn push_from(&self, other: &Self, reach: f32, weight: f32, push: &mut Push) {
        let back = other.turn.transpose();
        let (turn, shift) = (back * self.turn, back * (self.place - other.place));
        let field = &other.shape.field;
        let body = &self.shape.fine;
        let share = 0.5 * weight * body.point_area;
        body.walk(
            |center, radius| field.distance(turn * center + shift) < reach + radius,
            |point| {
                let there = turn * point + shift;
                if field.distance(there) < reach {
                    let (distance, way) = field.distance_and_way(there);
                    push.add(self.turn * point, other.turn * way, reach - distance, share);
                }
            },
        );
        let (turn, shift) = (turn.transpose(), self.turn.transpose() * (other.place - self.place));
        let field = &self.shape.field;
        let body = &other.shape.fine;
        let share = 0.5 * weight * body.point_area;
        body.walk(
            |center, radius| field.distance(turn * center + shift) < reach + radius,
            |point| {
                let there = turn * point + shift;
                if field.distance(there) < reach {
                    let (distance, way) = field.distance_and_way(there);
                    push.add(self.turn * there, self.turn * -way, reach - distance, share);
                }
            },
        );
    }
}

/// Normal equations of the motion (translation, then rotation about the center scaled by `radius`) that ends contacts.
#[derive(Debug, Clone)]
pub(crate) struct Push {
    matrix: [[f32; 6]; 6],
    side: [f32; 6],
    radius: f32,
    /// Weighted overlap: sum of weight x depth squared.
    pub(crate) energy: f32,
}

impl Push {
    /// No contact yet.
    pub(crate) fn new(radius: f32) -> Self {
        Self { matrix: [[0.0; 6]; 6], side: [0.0; 6], radius: radius.max(1e-3), energy: 0.0 }
    }

    /// A point at `arm` from the center is to move by `depth` along `way`.
    #[inline]
    pub(crate) fn add(&mut self, arm: Vec3, way: Vec3, depth: f32, weight: f32) {
        let spin = arm.cross(way) / self.radius;
        let row = [way.x, way.y, way.z, spin.x, spin.y, spin.z];
        for i in 0..6 {
            let scaled = weight * row[i];
            self.side[i] += scaled * depth;
            for (sum, &value) in self.matrix[i][..=i].iter_mut().zip(&row) {
                *sum += scaled * value;
            }
        }
        self.energy += weight * depth * depth;
    }

    /// The motion: translation in mm and rotation vector in radians, damped, as far as the rule allows it.
    pub(crate) fn motion(&self, rule: OrientationRule) -> (Vec3, Vec3) {
        let free = match rule {
            OrientationRule::Free => [true; 6],
            OrientationRule::Upright => [true, true, true, false, false, true],
            OrientationRule::Axis | OrientationRule::Fixed => [true, true, true, false, false, false],
        };
        let trace: f32 = (0..6).map(|i| self.matrix[i][i]).sum();
        let damping = 0.003 * trace + 1e-9;
        let mut lower = [[0.0_f32; 6]; 6];
        let mut solved = [0.0_f32; 6];
        // Cholesky; what is not free stands as 1 on the diagonal and 0 on the right side.
        for i in 0..6 {
            for j in 0..=i {
                let known = if free[i] && free[j] { self.matrix[i][j] } else { 0.0 };
                let known = if i == j { if free[i] { known + damping } else { 1.0 } } else { known };
                let sum = known - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f32>();
                lower[i][j] = if i == j { sum.max(1e-12).sqrt() } else { sum / lower[j][j] };
            }
        }
        for i in 0..6 {
            let side = if free[i] { self.side[i] } else { 0.0 };
            solved[i] = (side - (0..i).map(|k| lower[i][k] * solved[k]).sum::<f32>()) / lower[i][i];
        }
        for i in (0..6).rev() {
            solved[i] = (solved[i] - (i + 1..6).map(|k| lower[k][i] * solved[k]).sum::<f32>()) / lower[i][i];
        }
        let step = Vec3::new(solved[0], solved[1], solved[2]);
        let spin = Vec3::new(solved[3], solved[4], solved[5]) / self.radius;
        (step.clamp_length_max(0.5 * self.radius + 1.0), spin.clamp_length_max(0.35))
    }
}
