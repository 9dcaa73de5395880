//! Rigid poses: rotation, then translation.

use glam::{DMat3, DQuat, DVec3};

/// A rigid motion: `point -> rotation * point + translation` (mm). `pose12` is frame 2 seen from frame 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Translation after the rotation, mm.
    pub translation: DVec3,
}

impl Pose {
    /// The pose that moves nothing.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// Rotation (normalised here), then translation in mm.
    pub fn new(rotation: DQuat, translation: DVec3) -> Self {
        Self { rotation: rotation.normalize(), translation }
    }

    /// Moves a point.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// Turns a direction.
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.rotation * direction
    }

    /// The pose that undoes this one.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation: rotation * -self.translation }
    }

    /// First `inner`, then `self`: `pose13 = pose12.after(pose23)`.
    pub fn after(&self, inner: &Self) -> Self {
        Self::new(self.rotation * inner.rotation, self.rotation * inner.translation + self.translation)
    }

    /// Frame `other` seen from this frame: `pose12 = pose01.inverse() after pose02`.
    pub fn seen(&self, other: &Self) -> Self {
        self.inverse().after(other)
    }

    /// The rotation as a matrix.
    pub fn matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }

    /// Row-major 4x4 matrix acting on column vectors.
    pub fn rows(&self) -> [[f64; 4]; 4] {
        let m = self.matrix();
        let t = self.translation;
        [
            [m.x_axis.x, m.y_axis.x, m.z_axis.x, t.x],
            [m.x_axis.y, m.y_axis.y, m.z_axis.y, t.y],
            [m.x_axis.z, m.y_axis.z, m.z_axis.z, t.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    }
}
