//! The outline of a copy from above as a path of SVG: in half millimetres, each corner as the difference to the one before, which is a
//! third of the letters of coordinates in millimetres.

use std::fmt::Write;

use glam::{DVec2, DVec3};

use super::footprint::convex_footprint;

/// Steps of an outline in a millimetre.
const STEPS_PER_MM: f64 = 2.0;
/// What makes millimetres of the steps of outlines: the `transform` of whatever contains them.
pub(crate) const OUTLINE_SCALE: &str = "scale(.5)";

/// The path of the convex hull of points seen from above. The front of the machine, whose depth is `depth_mm`, is at the bottom; "" = no
/// points.
pub(super) fn outline_path(points: impl Iterator<Item = DVec3>, depth_mm: f64) -> String {
    let steps = |corner: &DVec2| {
        let flipped = STEPS_PER_MM * DVec2::new(corner.x, depth_mm - corner.y);
        (flipped.x.round() as i64, flipped.y.round() as i64)
    };
    let mut corners: Vec<(i64, i64)> = convex_footprint(points).iter().map(steps).collect();
    corners.dedup();
    let mut path = String::new();
    let mut last = (0, 0);
    for (x, y) in corners {
        let gap = if path.is_empty() { "m" } else { " " };
        push_number(&mut path, gap, x - last.0);
        push_number(&mut path, " ", y - last.1);
        last = (x, y);
    }
    if !path.is_empty() {
        path.push('z');
    }
    path
}

/// Appends a number; a sign takes the place of a blank.
fn push_number(path: &mut String, gap: &str, number: i64) {
    if number >= 0 || gap != " " {
        path.push_str(gap);
    }
    let _ = write!(path, "{number}");
}

#[cfg(test)]
mod tests {
    use solids::Pose;

    use super::*;

    #[test]
    fn a_block_is_a_path_of_four_corners_in_half_millimetres_with_the_front_below() {
        let block = sample_parts::cuboid(DVec3::new(30.0, 20.0, 5.0));
        let at = Pose::new(glam::DQuat::IDENTITY, DVec3::new(50.0, 40.0, 5.0));
        let path = outline_path(block.vertices().iter().map(|&v| at.transform_point(v)), 100.0);
        assert_eq!(path, "m100 120 60 0 0-40-60 0z");
        assert_eq!(outline_path(std::iter::empty(), 100.0), "");
    }

    #[test]
    fn a_round_part_of_four_millimetres_has_eight_corners_at_least_and_a_large_one_not_many_more() {
        for (diameter, corners) in [(4.0, 8..=16), (12.0, 9..=18), (80.0, 14..=30)] {
            let ring = sample_parts::ring(diameter, 0.6 * diameter, 3.0);
            let path = outline_path(ring.vertices().iter().copied(), 100.0);
            let numbers = path.matches([' ', '-']).count();
            assert!(corners.contains(&(numbers.div_ceil(2))), "{diameter}: {path}");
        }
    }
}
