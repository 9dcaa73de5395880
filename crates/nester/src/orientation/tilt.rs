//! Limits on the up direction of a part: directions of its mesh that must point nearly straight up. A face must not
//! look down means that its normal must stay out of a cone around straight down, which is the same kind of limit.

use std::{fmt, str::FromStr};

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Greatest number of tilts of one part; more are probably a mistake.
pub const MAX_TILTS: usize = 16;
/// Default angle that a face which must not look down keeps from straight down, degrees. Powder-bed machines show steps
/// on faces that look down more steeply.
const DEFAULT_SPARE_DEG: f64 = 45.0;
/// Tolerance of the search at the rim of a cone, radians. The proof allows ten times as much.
pub(crate) const RIM_TOLERANCE: f64 = 1e-7;

/// A direction of the mesh that must point within an angle of straight up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawTilt", into = "RawTilt")]
pub struct TiltLimit {
    direction: DVec3,
    within_deg: f64,
}

/// A face, by its outward normal, that must not look down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawFace", into = "RawFace")]
pub struct FaceNotDown {
    direction: DVec3,
    spare_deg: f64,
}

/// Why a tilt is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TiltLimitError {
    /// The direction has length 0 or is not finite.
    #[error("the direction is invalid: three numbers are needed, not all 0")]
    NoDirection,
    /// The angle is out of range.
    #[error("the angle must be 0 to 180 degrees")]
    NoAngle,
    /// The text is not a tilt.
    #[error("expected three numbers and an angle in degrees, e.g. 0,0,1:30")]
    NoTilt,
}

impl TiltLimit {
    /// `direction` of the mesh (any length) must point within `within_deg` degrees, 0 to 180, of straight up.
    pub fn new(direction: DVec3, within_deg: f64) -> Result<Self, TiltLimitError> {
        let within_deg = check_angle(within_deg)?;
        Ok(Self { direction: unit_direction(direction)?, within_deg })
    }

    /// The direction, mesh frame, of length 1.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// The greatest angle between the direction and straight up, degrees.
    pub fn within_deg(&self) -> f64 {
        self.within_deg
    }

    /// A readable text: `(0, 0, 1) within 30 degrees of up`.
    pub fn in_words(&self) -> String {
        let [x, y, z] = self.direction.to_array().map(|v| (v * 1e3).round() / 1e3 + 0.0);
        format!("({x}, {y}, {z}) within {} degrees of up", self.within_deg)
    }

    fn within_radians(&self) -> f64 {
        self.within_deg.to_radians()
    }

    /// Whether the mesh's direction `up` (of length 1) may point straight up, within a tolerance in radians.
    pub(crate) fn allows_up(&self, up: DVec3, tolerance: f64) -> bool {
        angle_between(self.direction, up) <= self.within_radians() + tolerance
    }

    /// Parses a list of tilts in the format of [`write_tilts`].
    pub fn parse_list(text: &str) -> Result<Vec<Self>, TiltLimitError> {
        text.split(';').filter(|one| !one.trim().is_empty()).map(str::parse).collect()
    }
}

impl FaceNotDown {
    /// The face with the outward `normal` must keep `spare_deg` degrees, 0 to 180, from pointing straight down.
    pub fn new(normal: DVec3, spare_deg: f64) -> Result<Self, TiltLimitError> {
        Ok(Self { direction: unit_direction(normal)?, spare_deg: check_angle(spare_deg)? })
    }
}

impl From<FaceNotDown> for TiltLimit {
    fn from(face: FaceNotDown) -> Self {
        Self { direction: face.direction, within_deg: 180.0 - face.spare_deg }
    }
}

/// Tilts as a line of text: `x,y,z:degrees`, with `;` between them.
///
/// ```
/// use nester::{TiltLimit, write_tilts};
///
/// let tilts = TiltLimit::parse_list("0,0,1:30; 1,0,0:90")?;
/// assert_eq!(tilts[0].in_words(), "(0, 0, 1) within 30 degrees of up");
/// assert_eq!(write_tilts(&tilts), "0,0,1:30;1,0,0:90");
/// # Ok::<(), nester::TiltLimitError>(())
/// ```
pub fn write_tilts(tilts: &[TiltLimit]) -> String {
    tilts.iter().map(ToString::to_string).collect::<Vec<_>>().join(";")
}

impl fmt::Display for TiltLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.direction;
        write!(f, "{x},{y},{z}:{}", self.within_deg)
    }
}

impl FromStr for TiltLimit {
    type Err = TiltLimitError;

    fn from_str(text: &str) -> Result<Self, TiltLimitError> {
        let (direction, angle) = parse_numbers(text)?;
        Self::new(direction, angle.ok_or(TiltLimitError::NoTilt)?)
    }
}

impl FromStr for FaceNotDown {
    type Err = TiltLimitError;

    fn from_str(text: &str) -> Result<Self, TiltLimitError> {
        let (direction, angle) = parse_numbers(text)?;
        Self::new(direction, angle.unwrap_or(DEFAULT_SPARE_DEG))
    }
}

/// `x,y,z` or `x,y,z:angle`.
fn parse_numbers(text: &str) -> Result<(DVec3, Option<f64>), TiltLimitError> {
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| TiltLimitError::NoTilt);
    let (direction, angle) = match text.split_once(':') {
        Some((direction, angle)) => (direction, Some(number(angle)?)),
        None => (text, None),
    };
    let parts = direction.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
    let direction = <[f64; 3]>::try_from(parts).map_err(|_| TiltLimitError::NoTilt)?;
    Ok((direction.into(), angle))
}

fn check_angle(degrees: f64) -> Result<f64, TiltLimitError> {
    if (0.0..=180.0).contains(&degrees) { Ok(degrees) } else { Err(TiltLimitError::NoAngle) }
}

/// Normalises a direction. A direction of length 1 stays the same to the last digit, so that a written value is read
/// back unchanged.
fn unit_direction(direction: DVec3) -> Result<DVec3, TiltLimitError> {
    if direction.is_finite() && (direction.length_squared() - 1.0).abs() < 1e-12 {
        return Ok(direction);
    }
    direction.try_normalize().ok_or(TiltLimitError::NoDirection)
}

/// The serialised form.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTilt {
    direction: [f64; 3],
    within_deg: f64,
}

impl TryFrom<RawTilt> for TiltLimit {
    type Error = TiltLimitError;

    fn try_from(raw: RawTilt) -> Result<Self, TiltLimitError> {
        Self::new(raw.direction.into(), raw.within_deg)
    }
}

impl From<TiltLimit> for RawTilt {
    fn from(tilt: TiltLimit) -> Self {
        Self { direction: tilt.direction.to_array(), within_deg: tilt.within_deg }
    }
}

/// The serialised form: the normal alone, or the normal with its angle from straight down.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a direction like [0, 0, 1] or { direction = [0, 0, 1], spare_deg = 45 }")]
enum RawFace {
    Normal([f64; 3]),
    Spare { direction: [f64; 3], spare_deg: f64 },
}

impl TryFrom<RawFace> for FaceNotDown {
    type Error = TiltLimitError;

    fn try_from(raw: RawFace) -> Result<Self, TiltLimitError> {
        match raw {
            RawFace::Normal(normal) => Self::new(normal.into(), DEFAULT_SPARE_DEG),
            RawFace::Spare { direction, spare_deg } => Self::new(direction.into(), spare_deg),
        }
    }
}

impl From<FaceNotDown> for RawFace {
    fn from(face: FaceNotDown) -> Self {
        Self::Spare { direction: face.direction.to_array(), spare_deg: face.spare_deg }
    }
}

/// Angle between two directions, radians. It is exact near 0 and near 180 degrees, where a cosine loses precision.
pub(crate) fn angle_between(one: DVec3, other: DVec3) -> f64 {
    one.cross(other).length().atan2(one.dot(other))
}

/// The direction of the mesh nearest to `up` that may point straight up; `None` when no direction obeys all tilts. Each
/// tilt allows a cap of the sphere of directions. So the nearest allowed point is `up` itself, or the nearest point on
/// the rim of one cap, or a point where two rims cross.
pub(crate) fn nearest_up(tilts: &[TiltLimit], up: DVec3) -> Option<DVec3> {
    let obeys = |up: DVec3| tilts.iter().all(|tilt| tilt.allows_up(up, RIM_TOLERANCE));
    if obeys(up) {
        return Some(up);
    }
    let rims = tilts.iter().map(|tilt| nearest_on_rim(tilt, up));
    let pairs = (0..tilts.len()).flat_map(|at| (0..at).map(move |other| (at, other)));
    let crossings = pairs.flat_map(|(at, other)| rim_crossings(&tilts[at], &tilts[other])).flatten();
    let allowed = rims.chain(crossings).filter(|&up| obeys(up));
    allowed.min_by(|&a, &b| angle_between(a, up).total_cmp(&angle_between(b, up)))
}

/// The point of a cap's rim nearest to `up`.
fn nearest_on_rim(tilt: &TiltLimit, up: DVec3) -> DVec3 {
    let axis = tilt.direction;
    let away = (up - axis * up.dot(axis)).try_normalize().unwrap_or(axis.any_orthonormal_vector());
    let (sin, cos) = tilt.within_radians().sin_cos();
    axis * cos + away * sin
}

/// Where the rims of two caps cross.
fn rim_crossings(one: &TiltLimit, other: &TiltLimit) -> [Option<DVec3>; 2] {
    let (cos1, cos2) = (one.within_radians().cos(), other.within_radians().cos());
    let together = one.direction.dot(other.direction);
    let normal = one.direction.cross(other.direction);
    let apart = normal.length_squared();
    if apart < 1e-12 {
        return [None, None];
    }
    let flat = ((cos1 - together * cos2) * one.direction + (cos2 - together * cos1) * other.direction) / apart;
    let rest = 1.0 - flat.length_squared();
    if rest < -1e-12 {
        return [None, None];
    }
    let lift = normal * (rest.max(0.0) / apart).sqrt();
    [Some((flat + lift).normalize()), Some((flat - lift).normalize())]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::orientation::rotations::spread_directions;

    fn tilt(direction: [f64; 3], within_deg: f64) -> TiltLimit {
        TiltLimit::new(direction.into(), within_deg).unwrap()
    }

    #[test]
    fn a_tilt_is_the_same_after_text_and_json() {
        let tilts =
            vec![tilt([1.0, 2.0, -0.3], 33.3), FaceNotDown::new(DVec3::new(0.1, 0.7, 9.0), 45.0).unwrap().into()];
        assert_eq!(TiltLimit::parse_list(&write_tilts(&tilts)).unwrap(), tilts);
        let json = serde_json::to_string(&tilts).unwrap();
        let back: Vec<TiltLimit> = serde_json::from_str(&json).unwrap();
        assert!(back.iter().zip(&tilts).all(|(b, t)| angle_between(b.direction, t.direction) < 1e-12), "{back:?}");
        assert_eq!(TiltLimit::parse_list("").unwrap(), []);
    }

    #[test]
    fn what_is_no_direction_and_no_angle_is_refused() {
        assert_eq!(TiltLimit::new(DVec3::ZERO, 10.0), Err(TiltLimitError::NoDirection));
        assert_eq!(TiltLimit::new(DVec3::NAN, 10.0), Err(TiltLimitError::NoDirection));
        assert_eq!(TiltLimit::new(DVec3::Z, 181.0), Err(TiltLimitError::NoAngle));
        assert_eq!("0,0,1".parse::<TiltLimit>(), Err(TiltLimitError::NoTilt));
        assert_eq!("0,1:30".parse::<TiltLimit>(), Err(TiltLimitError::NoTilt));
        assert_eq!(TiltLimit::from("0,0,1".parse::<FaceNotDown>().unwrap()), tilt([0.0, 0.0, 1.0], 135.0));
    }

    #[test]
    fn faces_are_read_with_and_without_what_they_spare() {
        let faces: Vec<FaceNotDown> =
            serde_json::from_str(r#"[[0, 0, -2], {"direction": [1, 0, 0], "spare_deg": 10}]"#).unwrap();
        assert_eq!(TiltLimit::from(faces[0]), tilt([0.0, 0.0, -1.0], 135.0));
        assert_eq!(TiltLimit::from(faces[1]), tilt([1.0, 0.0, 0.0], 170.0));
        let error = serde_json::from_str::<FaceNotDown>("[0, 0]").unwrap_err().to_string();
        assert!(error.contains("a direction like [0, 0, 1]"), "{error}");
    }

    #[test]
    fn rules_that_clash_leave_no_way_up() {
        let opposed = [tilt([0.0, 0.0, 1.0], 40.0), tilt([0.0, 0.0, -1.0], 40.0)];
        assert_eq!(nearest_up(&opposed, DVec3::X), None);
        let all_around = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]].map(|d| tilt(d, 80.0));
        assert_eq!(nearest_up(&all_around, DVec3::Z), None);
    }

    fn any_tilt() -> impl Strategy<Value = TiltLimit> {
        ((-1.0..1.0_f64, -1.0..1.0_f64, 0.1..1.0_f64), prop_oneof![Just(0.0), 0.0..180.0_f64])
            .prop_map(|((x, y, z), within)| tilt([x, y, z], within))
    }

    proptest! {
        #[test]
        fn no_allowed_direction_is_nearer(tilts in prop::collection::vec(any_tilt(), 1..5), at in 0..300_usize) {
            let directions: Vec<DVec3> = spread_directions(300).collect();
            let obeys = |up: DVec3, spare: f64| tilts.iter().all(|t| t.allows_up(up, spare));
            let up = directions[at];
            match nearest_up(&tilts, up) {
                Some(found) => {
                    prop_assert!(obeys(found, 2.0 * RIM_TOLERANCE) && found.is_normalized());
                    for &other in directions.iter().filter(|&&d| obeys(d, 0.0)) {
                        prop_assert!(angle_between(found, up) <= angle_between(other, up) + 1e-6);
                    }
                }
                None => prop_assert!(!directions.iter().any(|&d| obeys(d, 0.0))),
            }
        }
    }
}
