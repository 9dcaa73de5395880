//! Point location: the winding number of each connected shell of a surface about a point.

use glam::DVec3;

use super::box_tree::TriangleBoxTree;
use crate::Pose;

/// Ray directions that no drawing uses, so that a ray rarely hits an edge; then the next one is tried.
const DIRECTIONS: [DVec3; 9] = [
    DVec3::new(0.267, 0.534_522_9, 0.801_783_7),
    DVec3::new(-0.845_154_3, 0.507_092_5, 0.169_030_1),
    DVec3::new(0.408_111, -0.816_223, 0.409_3),
    DVec3::new(-0.301_511, -0.301_613, -0.904_534),
    DVec3::new(0.917_663, 0.146_826, -0.369_065),
    DVec3::new(-0.613_941, 0.716_264, -0.330_87),
    DVec3::new(0.090_535, 0.950_618, 0.295_04),
    DVec3::new(-0.696_311, -0.526_235, 0.487_71),
    DVec3::new(0.548_821, -0.359_913, -0.754_31),
];

/// The winding number of each connected shell about a point of the mesh's frame: 1 inside a solid's outer shell, -1
/// inside a cavity's, 0 outside. A closed surface needs one ray that hits no edge; for an open one, three rays vote.
/// `boxes` is the frame of the boxes seen from the mesh's.
pub(crate) fn winding_numbers(tree: &TriangleBoxTree, boxes: &Pose, point: DVec3, is_closed: bool) -> Vec<i32> {
    let votes_wanted = if is_closed { 1 } else { 3 };
    let clean = DIRECTIONS.iter().filter_map(|&direction| cast_ray(tree, boxes, point, direction));
    let votes: Vec<Vec<i32>> = clean.take(votes_wanted).collect();
    (0..tree.shell_corners().len())
        .map(|shell| {
            let mut counts: Vec<i32> = votes.iter().map(|v| v[shell]).collect();
            counts.sort_unstable();
            counts.get(counts.len() / 2).copied().unwrap_or(0)
        })
        .collect()
}

/// Counts the crossings of a ray per connected shell, +1 out and -1 in; `None` when it hits an edge. The direction is in
/// the frame of the boxes.
fn cast_ray(tree: &TriangleBoxTree, boxes: &Pose, point: DVec3, direction: DVec3) -> Option<Vec<i32>> {
    let point_in_box = boxes.inverse().transform_point(point);
    let direction_in_mesh = boxes.transform_direction(direction);
    let mut counts = vec![0; tree.shell_corners().len()];
    let mut stack = vec![0usize];
    while let Some(node) = stack.pop() {
        let of_node = &tree.boxes[node];
        if !ray_meets_box(point_in_box, direction, of_node.center.as_dvec3(), of_node.half.as_dvec3()) {
            continue;
        }
        let link = tree.links[node];
        if !link.is_leaf() {
            stack.extend([link.first_child(), link.first_child() + 1]);
            continue;
        }
        for place in link.triangle_range() {
            counts[tree.shell_of(place)] += ray_crossing(&tree.corners(place), point, direction_in_mesh)?;
        }
    }
    Some(counts)
}

/// Whether a ray meets a box that is grown slightly: a miss must be certain.
fn ray_meets_box(point: DVec3, direction: DVec3, center: DVec3, half: DVec3) -> bool {
    let half = half + 1e-9 + half * 1e-9;
    let (near, far) = ((center - half - point) / direction, (center + half - point) / direction);
    let (enter, leave) = (near.min(far).max_element(), near.max(far).min_element());
    leave >= enter.max(0.0)
}

/// +1 where the ray leaves through a triangle, -1 where it enters, 0 where it misses, `None` on an edge. Both triangles
/// of an edge compute the same number for it except for the sign, so no ray slips through between them.
fn ray_crossing(corners: &[DVec3; 3], point: DVec3, direction: DVec3) -> Option<i32> {
    let [a, b, c] = corners.map(|corner| corner - point);
    let sides = [a.cross(b).dot(direction), b.cross(c).dot(direction), c.cross(a).dot(direction)];
    let leaving = sides.iter().all(|&s| s >= 0.0);
    if !leaving && !sides.iter().all(|&s| s <= 0.0) {
        return Some(0);
    }
    let normal = (b - a).cross(c - a);
    let (height, slope) = (a.dot(normal), normal.dot(direction));
    if sides.contains(&0.0) || slope == 0.0 {
        // Only an edge ahead of the point makes the ray unusable.
        return if height * slope < 0.0 { Some(0) } else { None };
    }
    match height / slope > 0.0 {
        true => Some(if leaving { 1 } else { -1 }),
        false => Some(0),
    }
}
