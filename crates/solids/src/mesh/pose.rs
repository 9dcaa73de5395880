//! Rigid poses: a rotation, then a translation.

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A rigid motion: `point -> rotation * point + translation` (mm). `pose12` is frame 2 seen from frame 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawPose")]
pub struct Pose {
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Translation after the rotation, mm.
    pub translation: DVec3,
}

/// Why numbers do not form a valid pose.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The quaternion is not a unit quaternion. Contains its length.
    #[error("the rotation is a quaternion (x, y, z, w) of length {0}, a length of 1 is wanted")]
    NoRotation(f64),
    /// A coordinate is NaN or infinite.
    #[error("the translation ({0}) is not made of finite numbers")]
    NoTranslation(DVec3),
}

impl Pose {
    /// The pose that leaves every point in place.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// Creates a pose from a rotation, which is normalised here, and a translation in mm.
    pub fn new(rotation: DQuat, translation: DVec3) -> Self {
        Self { rotation: rotation.normalize(), translation }
    }

    /// A pose from numbers that were stored. A unit quaternion (up to arithmetic rounding) stays unchanged to the last
    /// bit. One that was rounded when it was written is normalised.
    ///
    /// # Errors
    /// The numbers do not form a valid pose.
    pub fn from_stored(rotation: DQuat, translation: DVec3) -> Result<Self, PoseError> {
        let off = (rotation.length() - 1.0).abs();
        match translation.is_finite() {
            false => Err(PoseError::NoTranslation(translation)),
            true if off < EXACT => Ok(Self { rotation, translation }),
            true if off < ROUNDED => Ok(Self::new(rotation, translation)),
            true => Err(PoseError::NoRotation(rotation.length())),
        }
    }

    /// Moves a point.
    pub fn transform_point(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// Rotates a direction.
    pub fn transform_direction(&self, direction: DVec3) -> DVec3 {
        self.rotation * direction
    }

    /// The inverse pose.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation: rotation * -self.translation }
    }

    /// First `inner`, then `self`: `pose13 = pose12.compose_with(pose23)`.
    pub fn compose_with(&self, inner: &Self) -> Self {
        Self::new(self.rotation * inner.rotation, self.rotation * inner.translation + self.translation)
    }

    /// Frame `other` seen from this frame: `pose12 = pose01.inverse().compose_with(pose02)`.
    pub fn relative_pose_of(&self, other: &Self) -> Self {
        self.inverse().compose_with(other)
    }

    /// The rotation as a matrix.
    pub fn rotation_matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }

    /// Row-major 4x4 matrix acting on column vectors.
    pub fn matrix_rows(&self) -> [[f64; 4]; 4] {
        let m = self.rotation_matrix();
        let t = self.translation;
        [
            [m.x_axis.x, m.y_axis.x, m.z_axis.x, t.x],
            [m.x_axis.y, m.y_axis.y, m.z_axis.y, t.y],
            [m.x_axis.z, m.y_axis.z, m.z_axis.z, t.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    }
}

/// A pose as files contain it, not checked yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPose {
    rotation: DQuat,
    translation: DVec3,
}

impl TryFrom<RawPose> for Pose {
    type Error = PoseError;

    fn try_from(raw: RawPose) -> Result<Self, PoseError> {
        Self::from_stored(raw.rotation, raw.translation)
    }
}

/// Allowed deviation of a quaternion's length from 1 due to its own arithmetic.
const EXACT: f64 = 1e-12;
/// Allowed deviation of a quaternion's length from 1 if its numbers were written with few digits.
const ROUNDED: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_comes_back_to_the_last_digit_and_a_rounded_one_is_mended() {
        let pose = Pose::new(DQuat::from_xyzw(0.1, -0.7, 0.3, 0.2), DVec3::new(1.0 / 3.0, -0.0, 1e7 / 7.0));
        let text = toml::to_string(&pose).expect("is written");
        assert_eq!(toml::from_str::<Pose>(&text).expect("is read"), pose);
        let rounded: Pose =
            toml::from_str("rotation = [0.0, 0.0, 0.7071, 0.7071]\ntranslation = [1.0, 2.0, 3.0]").expect("is read");
        assert!(rounded.rotation.is_normalized() && (rounded.rotation.z - 0.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn numbers_that_are_no_pose_are_refused() {
        let read = |rotation: &str, translation: &str| {
            toml::from_str::<Pose>(&format!("rotation = {rotation}\ntranslation = {translation}"))
                .map_err(|e| e.to_string())
        };
        assert!(read("[0.0, 0.0, 0.0, 2.0]", "[0.0, 0.0, 0.0]").is_err_and(|e| e.contains("of length 2")));
        assert!(read("[0.0, 0.0, 0.0, nan]", "[0.0, 0.0, 0.0]").is_err_and(|e| e.contains("of length NaN")));
        assert!(read("[0.0, 0.0, 0.0, 1.0]", "[0.0, inf, 0.0]").is_err_and(|e| e.contains("finite")));
    }
}
