//! Which ways up a part may stand: directions of its mesh that must stay near to straight up. A face must not look down when
//! its normal must stay out of a cone around straight down, which is the same kind of rule.

use std::{fmt, str::FromStr};

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// More of them for one part are a slip.
pub const MAX_TILTS: usize = 16;
/// A face that must not look down keeps so far from straight down where nothing else is said, degrees: powder-bed machines
/// show steps on faces that look down more steeply.
const DEFAULT_SPARE_DEG: f64 = 45.0;
/// The search may miss the rim of a cone by so much, radians; the proof allows ten times as much.
pub(crate) const RIM_TOLERANCE: f64 = 1e-7;

/// A direction of the mesh that must stand within an angle of straight up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawTilt", into = "RawTilt")]
pub struct Tilt {
    direction: DVec3,
    within_deg: f64,
}

/// A face, by its outward normal, that must not look down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawFace", into = "RawFace")]
pub struct NotDown {
    direction: DVec3,
    spare_deg: f64,
}

/// Why something is no tilt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum TiltError {
    /// Its length is 0 or no number.
    #[error("the direction is none: three numbers are wanted, not all 0")]
    NoDirection,
    /// Its angle is none.
    #[error("the angle must be 0 to 180 degrees")]
    NoAngle,
    /// A text that does not say one.
    #[error("wants three numbers and an angle in degrees, e.g. 0,0,1:30")]
    NoTilt,
}

impl Tilt {
    /// `direction` of the mesh (any length) stands within `within_deg` degrees, 0 to 180, of straight up.
    pub fn new(direction: DVec3, within_deg: f64) -> Result<Self, TiltError> {
        let within_deg = angle_of(within_deg)?;
        Ok(Self { direction: unit(direction)?, within_deg })
    }

    /// The direction, mesh frame, of length 1.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// Its greatest angle to straight up, degrees.
    pub fn within_deg(&self) -> f64 {
        self.within_deg
    }

    /// For people: `(0, 0, 1) within 30 degrees of up`.
    pub fn in_words(&self) -> String {
        let [x, y, z] = self.direction.to_array().map(|v| (v * 1e3).round() / 1e3 + 0.0);
        format!("({x}, {y}, {z}) within {} degrees of up", self.within_deg)
    }

    fn within(&self) -> f64 {
        self.within_deg.to_radians()
    }

    /// Whether it lets the mesh's direction `up` (of length 1) stand straight up, within a tolerance in radians.
    pub(crate) fn lets(&self, up: DVec3, tolerance: f64) -> bool {
        between(self.direction, up) <= self.within() + tolerance
    }

    /// The tilts that a text lists, as [`write_tilts`] writes them.
    pub fn parse_list(text: &str) -> Result<Vec<Self>, TiltError> {
        text.split(';').filter(|one| !one.trim().is_empty()).map(str::parse).collect()
    }
}

impl NotDown {
    /// The face with the outward `normal` keeps `spare_deg` degrees, 0 to 180, from looking straight down.
    pub fn new(normal: DVec3, spare_deg: f64) -> Result<Self, TiltError> {
        Ok(Self { direction: unit(normal)?, spare_deg: angle_of(spare_deg)? })
    }
}

impl From<NotDown> for Tilt {
    fn from(face: NotDown) -> Self {
        Self { direction: face.direction, within_deg: 180.0 - face.spare_deg }
    }
}

/// Tilts as a line of text: `x,y,z:degrees`, with `;` between them.
///
/// ```
/// use nester::{Tilt, write_tilts};
///
/// let tilts = Tilt::parse_list("0,0,1:30; 1,0,0:90")?;
/// assert_eq!(tilts[0].in_words(), "(0, 0, 1) within 30 degrees of up");
/// assert_eq!(write_tilts(&tilts), "0,0,1:30;1,0,0:90");
/// # Ok::<(), nester::TiltError>(())
/// ```
pub fn write_tilts(tilts: &[Tilt]) -> String {
    tilts.iter().map(ToString::to_string).collect::<Vec<_>>().join(";")
}

impl fmt::Display for Tilt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.direction;
        write!(f, "{x},{y},{z}:{}", self.within_deg)
    }
}

impl FromStr for Tilt {
    type Err = TiltError;

    fn from_str(text: &str) -> Result<Self, TiltError> {
        let (direction, angle) = numbers(text)?;
        Self::new(direction, angle.ok_or(TiltError::NoTilt)?)
    }
}

impl FromStr for NotDown {
    type Err = TiltError;

    fn from_str(text: &str) -> Result<Self, TiltError> {
        let (direction, angle) = numbers(text)?;
        Self::new(direction, angle.unwrap_or(DEFAULT_SPARE_DEG))
    }
}

/// `x,y,z` or `x,y,z:angle`.
fn numbers(text: &str) -> Result<(DVec3, Option<f64>), TiltError> {
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| TiltError::NoTilt);
    let (direction, angle) = match text.split_once(':') {
        Some((direction, angle)) => (direction, Some(number(angle)?)),
        None => (text, None),
    };
    let parts = direction.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
    let direction = <[f64; 3]>::try_from(parts).map_err(|_| TiltError::NoTilt)?;
    Ok((direction.into(), angle))
}

fn angle_of(degrees: f64) -> Result<f64, TiltError> {
    if (0.0..=180.0).contains(&degrees) { Ok(degrees) } else { Err(TiltError::NoAngle) }
}

/// One of length 1 already stays as it is to the last digit, so that what is written comes back the same.
fn unit(direction: DVec3) -> Result<DVec3, TiltError> {
    if direction.is_finite() && (direction.length_squared() - 1.0).abs() < 1e-12 {
        return Ok(direction);
    }
    direction.try_normalize().ok_or(TiltError::NoDirection)
}

/// As files say it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTilt {
    direction: [f64; 3],
    within_deg: f64,
}

impl TryFrom<RawTilt> for Tilt {
    type Error = TiltError;

    fn try_from(raw: RawTilt) -> Result<Self, TiltError> {
        Self::new(raw.direction.into(), raw.within_deg)
    }
}

impl From<Tilt> for RawTilt {
    fn from(tilt: Tilt) -> Self {
        Self { direction: tilt.direction.to_array(), within_deg: tilt.within_deg }
    }
}

/// As files say it: the normal alone, or with how far it keeps from straight down.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "a direction as in [0, 0, 1] or { direction = [0, 0, 1], spare_deg = 45 } is wanted")]
enum RawFace {
    Normal([f64; 3]),
    Spare { direction: [f64; 3], spare_deg: f64 },
}

impl TryFrom<RawFace> for NotDown {
    type Error = TiltError;

    fn try_from(raw: RawFace) -> Result<Self, TiltError> {
        match raw {
            RawFace::Normal(normal) => Self::new(normal.into(), DEFAULT_SPARE_DEG),
            RawFace::Spare { direction, spare_deg } => Self::new(direction.into(), spare_deg),
        }
    }
}

impl From<NotDown> for RawFace {
    fn from(face: NotDown) -> Self {
        Self::Spare { direction: face.direction.to_array(), spare_deg: face.spare_deg }
    }
}

/// Angle between two directions, radians; exact near 0 and near a half turn, where a cosine says nothing.
pub(crate) fn between(one: DVec3, other: DVec3) -> f64 {
    one.cross(other).length().atan2(one.dot(other))
}

/// The direction of the mesh nearest to `up` that may stand straight up; `None` when no way up obeys all tilts. What a tilt
/// allows is a cap of the sphere of directions, so the nearest point that all allow is `up` itself, or the nearest on the
/// rim of one cap, or where two rims cross.
pub(crate) fn nearest_up(tilts: &[Tilt], up: DVec3) -> Option<DVec3> {
    let obeys = |up: DVec3| tilts.iter().all(|tilt| tilt.lets(up, RIM_TOLERANCE));
    if obeys(up) {
        return Some(up);
    }
    let rims = tilts.iter().map(|tilt| on_rim(tilt, up));
    let pairs = (0..tilts.len()).flat_map(|at| (0..at).map(move |other| (at, other)));
    let crossings = pairs.flat_map(|(at, other)| crossings(&tilts[at], &tilts[other])).flatten();
    let allowed = rims.chain(crossings).filter(|&up| obeys(up));
    allowed.min_by(|&a, &b| between(a, up).total_cmp(&between(b, up)))
}

/// The point of a cap's rim nearest to `up`.
fn on_rim(tilt: &Tilt, up: DVec3) -> DVec3 {
    let axis = tilt.direction;
    let away = (up - axis * up.dot(axis)).try_normalize().unwrap_or(axis.any_orthonormal_vector());
    let (sin, cos) = tilt.within().sin_cos();
    axis * cos + away * sin
}

/// Where the rims of two caps cross.
fn crossings(one: &Tilt, other: &Tilt) -> [Option<DVec3>; 2] {
    let (cos1, cos2) = (one.within().cos(), other.within().cos());
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
    use crate::turns::spread_directions;

    fn tilt(direction: [f64; 3], within_deg: f64) -> Tilt {
        Tilt::new(direction.into(), within_deg).unwrap()
    }

    #[test]
    fn a_tilt_is_the_same_after_text_and_json() {
        let tilts = vec![tilt([1.0, 2.0, -0.3], 33.3), NotDown::new(DVec3::new(0.1, 0.7, 9.0), 45.0).unwrap().into()];
        assert_eq!(Tilt::parse_list(&write_tilts(&tilts)).unwrap(), tilts);
        let json = serde_json::to_string(&tilts).unwrap();
        let back: Vec<Tilt> = serde_json::from_str(&json).unwrap();
        assert!(back.iter().zip(&tilts).all(|(b, t)| between(b.direction, t.direction) < 1e-12), "{back:?}");
        assert_eq!(Tilt::parse_list("").unwrap(), []);
    }

    #[test]
    fn what_is_no_direction_and_no_angle_is_refused() {
        assert_eq!(Tilt::new(DVec3::ZERO, 10.0), Err(TiltError::NoDirection));
        assert_eq!(Tilt::new(DVec3::NAN, 10.0), Err(TiltError::NoDirection));
        assert_eq!(Tilt::new(DVec3::Z, 181.0), Err(TiltError::NoAngle));
        assert_eq!("0,0,1".parse::<Tilt>(), Err(TiltError::NoTilt));
        assert_eq!("0,1:30".parse::<Tilt>(), Err(TiltError::NoTilt));
        assert_eq!(Tilt::from("0,0,1".parse::<NotDown>().unwrap()), tilt([0.0, 0.0, 1.0], 135.0));
    }

    #[test]
    fn faces_are_read_with_and_without_what_they_spare() {
        let faces: Vec<NotDown> =
            serde_json::from_str(r#"[[0, 0, -2], {"direction": [1, 0, 0], "spare_deg": 10}]"#).unwrap();
        assert_eq!(Tilt::from(faces[0]), tilt([0.0, 0.0, -1.0], 135.0));
        assert_eq!(Tilt::from(faces[1]), tilt([1.0, 0.0, 0.0], 170.0));
        let error = serde_json::from_str::<NotDown>("[0, 0]").unwrap_err().to_string();
        assert!(error.contains("a direction as in [0, 0, 1]"), "{error}");
    }

    #[test]
    fn rules_that_clash_leave_no_way_up() {
        let opposed = [tilt([0.0, 0.0, 1.0], 40.0), tilt([0.0, 0.0, -1.0], 40.0)];
        assert_eq!(nearest_up(&opposed, DVec3::X), None);
        let all_around = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]].map(|d| tilt(d, 80.0));
        assert_eq!(nearest_up(&all_around, DVec3::Z), None);
    }

    fn any_tilt() -> impl Strategy<Value = Tilt> {
        ((-1.0..1.0_f64, -1.0..1.0_f64, 0.1..1.0_f64), prop_oneof![Just(0.0), 0.0..180.0_f64])
            .prop_map(|((x, y, z), within)| tilt([x, y, z], within))
    }

    proptest! {
        #[test]
        fn no_allowed_direction_is_nearer(tilts in prop::collection::vec(any_tilt(), 1..5), at in 0..300_usize) {
            let directions: Vec<DVec3> = spread_directions(300).collect();
            let obeys = |up: DVec3, spare: f64| tilts.iter().all(|t| t.lets(up, spare));
            let up = directions[at];
            match nearest_up(&tilts, up) {
                Some(found) => {
                    prop_assert!(obeys(found, 2.0 * RIM_TOLERANCE) && found.is_normalized());
                    for &other in directions.iter().filter(|&&d| obeys(d, 0.0)) {
                        prop_assert!(between(found, up) <= between(other, up) + 1e-6);
                    }
                }
                None => prop_assert!(!directions.iter().any(|&d| obeys(d, 0.0))),
            }
        }
    }
}
