//! Tests exactly whether one part can be moved past another along a straight line: the infinite sweep of the moving
//! surface against the triangles of the standing surface, in one traversal of the two box trees and without steps along
//! the way.

use glam::{DMat3, DVec2, DVec3, Vec3};

use crate::{
    ClearanceTree, Pose,
    mesh::triangle::Triangle,
    trees::{
        box_tree::TriangleBoxTree, box_tree_build::MAX_LEAF_TRIANGLES, node_box::TreeNodeLink,
        normal_bounds::NormalBounds, tree_pair_walk::opens_first,
    },
};

/// A face that leans less than this towards the direction (the cosine) counts as parallel to it: its neighbours sweep
/// the same volume.
const MIN_LEAN: f64 = 4e-6;
/// Triangles seen edge-on are at most this wide, mm.
const ROUNDING_MM: f64 = 1e-9;

impl ClearanceTree {
    /// Whether this part, moved without limit along `direction1` (in its mesh frame, any length but 0), keeps at least
    /// `gap_mm` from `other` all the way. The two must not be nearer than that at the start. A part in a cavity,
    /// through a ring or under a flange of the other is blocked like by any obstacle: by the surface that it would
    /// meet. `pose12` is the frame of `other` seen from this one.
    pub fn is_free_along(&self, other: &Self, pose12: &Pose, direction1: DVec3, gap_mm: f64) -> bool {
        !DirectionSweep::new(self, other, pose12, direction1, gap_mm).is_blocked()
    }
}

/// Two trees seen from a frame whose z axis is the direction of the first one's motion.
struct DirectionSweep<'a> {
    moving: SweepFrameTree<'a>,
    standing: SweepFrameTree<'a>,
    gap_mm: f64,
    /// Whether only faces towards the direction sweep, and only faces against it are hit: true for solids, not for open
    /// surfaces.
    solid: bool,
}

/// Index of the axis that is the direction of motion.
const SWEEP_AXIS: usize = 4;
/// Number of axes on which boxes are projected: x, y, their two diagonals, z (the direction), and the axes of both
/// trees' boxes.
const AXIS_COUNT: usize = 11;

/// A tree in the frame of the motion.
struct SweepFrameTree<'a> {
    tree: &'a TriangleBoxTree,
    normals: &'a [NormalBounds],
    /// From the mesh's frame to the frame of the motion.
    turn: DMat3,
    shift: DVec3,
    /// The axes in the frame of the tree's boxes.
    axes: [DVec3; AXIS_COUNT],
    /// Absolute values of the axes: they convert half edges to half widths.
    spread: [DVec3; AXIS_COUNT],
    shifts: [f64; AXIS_COUNT],
    /// The direction in the mesh's frame.
    direction: DVec3,
    /// The same in single precision, and its absolute values.
    flat_direction: Vec3,
    flat_direction_spread: Vec3,
}

/// A node with its box projected on the axes.
#[derive(Clone, Copy)]
struct ProjectedNode {
    node: usize,
    low: [f64; AXIS_COUNT],
    high: [f64; AXIS_COUNT],
}

impl<'a> DirectionSweep<'a> {
    fn new(part1: &'a ClearanceTree, part2: &'a ClearanceTree, pose12: &Pose, direction1: DVec3, gap_mm: f64) -> Self {
        let (box1, box2) = (part1.obb().pose, pose12.compose_with(&part2.obb().pose));
        let direction = direction1.normalize();
        // The x axis comes from the first box's longest side that is not parallel to the direction.
        let sides = box1.rotation_matrix();
        let across = if sides.x_axis.dot(direction).abs() < 0.9 { sides.x_axis } else { sides.y_axis };
        let x = (across - direction * across.dot(direction)).normalize();
        let y = direction.cross(x);
        // Turn each axis to the side of the direction: then only a part that lies before the sweep along it is out of
        // reach.
        let onward = |axis: DVec3| if axis.dot(direction) < 0.0 { -axis } else { axis };
        let (sides1, sides2) = (box1.rotation_matrix(), box2.rotation_matrix());
        let [a, b, c] = [sides1.x_axis, sides1.y_axis, sides1.z_axis].map(onward);
        let [d, e, f] = [sides2.x_axis, sides2.y_axis, sides2.z_axis].map(onward);
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        let axes = [x, y, (x + y) * diagonal, (x - y) * diagonal, direction, a, b, c, d, e, f];
        let rows = DMat3::from_cols(x, y, direction).transpose();
        Self {
            moving: SweepFrameTree::new(&part1.tree, rows, &Pose::IDENTITY, &box1, &axes),
            standing: SweepFrameTree::new(&part2.tree, rows, pose12, &box2, &axes),
            gap_mm: gap_mm.max(ROUNDING_MM),
            solid: part1.mesh().defects().is_closed() && part2.mesh().defects().is_closed(),
        }
    }

    fn is_blocked(&self) -> bool {
        let (shadow1, shadow2) = (self.moving.project_node(0), self.standing.project_node(0));
        self.may_collide(&shadow1, &shadow2) && self.visit_pair(&shadow1, &shadow2)
    }

    /// Whether the boxes allow the first part to sweep over the second.
    #[inline]
    fn may_collide(&self, shadow1: &ProjectedNode, shadow2: &ProjectedNode) -> bool {
        shadow2.high[SWEEP_AXIS] > shadow1.low[SWEEP_AXIS]
            && (0..SWEEP_AXIS).all(|k| {
                shadow2.low[k] - shadow1.high[k] < self.gap_mm && shadow1.low[k] - shadow2.high[k] < self.gap_mm
            })
            && (SWEEP_AXIS + 1..AXIS_COUNT).all(|k| shadow1.low[k] - shadow2.high[k] < self.gap_mm)
    }

    fn visit_pair(&self, shadow1: &ProjectedNode, shadow2: &ProjectedNode) -> bool {
        let (node1, node2) = (shadow1.node, shadow2.node);
        let (link1, link2) = (self.moving.tree.links[node1], self.standing.tree.links[node2]);
        if link1.is_leaf() && link2.is_leaf() {
            return self.compare_leaves(link1, link2);
        }
        let open1 = opens_first(self.moving.tree, self.standing.tree, node1, node2);
        (0..2).any(|child| {
            if open1 {
                let at = link1.first_child() + child;
                if self.solid && self.moving.facing_range(at).1 <= MIN_LEAN as f32 {
                    return false;
                }
                let shadow1 = self.moving.project_node(at);
                self.may_collide(&shadow1, shadow2) && self.visit_pair(&shadow1, shadow2)
            } else {
                let at = link2.first_child() + child;
                if self.solid && self.standing.facing_range(at).0 >= -MIN_LEAN as f32 {
                    return false;
                }
                let shadow2 = self.standing.project_node(at);
                self.may_collide(shadow1, &shadow2) && self.visit_pair(shadow1, &shadow2)
            }
        })
    }

    fn compare_leaves(&self, leaf1: TreeNodeLink, leaf2: TreeNodeLink) -> bool {
        let (moving, standing) = (&self.moving, &self.standing);
        let counts = |normal: DVec3, lean: f64| !self.solid || lean > MIN_LEAN || normal == DVec3::ZERO;
        let ahead = leaf1.triangle_range().map(|place| moving.tree.triangle(place));
        let ahead = ahead.filter(|t| counts(t.normal, t.normal.dot(moving.direction)));
        let mut ahead = ahead.map(|t| t.transformed_by(&moving.turn, moving.shift)).peekable();
        if ahead.peek().is_none() {
            return false;
        }
        let against = leaf2.triangle_range().map(|place| standing.tree.triangle(place));
        let against = against.filter(|t| counts(t.normal, -t.normal.dot(standing.direction)));
        let mut room = [None; MAX_LEAF_TRIANGLES];
        for (place, triangle) in room.iter_mut().zip(against) {
            *place = Some(triangle.transformed_by(&standing.turn, standing.shift));
        }
        ahead.any(|one| room.iter().flatten().any(|other| sweep_collides(&one, other, self.gap_mm)))
    }
}

impl<'a> SweepFrameTree<'a> {
    /// `mesh` and `boxes` are the frames of the mesh and of the tree's boxes.
    fn new(tree: &'a TriangleBoxTree, rows: DMat3, mesh: &Pose, boxes: &Pose, axes: &[DVec3; AXIS_COUNT]) -> Self {
        let back = boxes.rotation_matrix().transpose();
        let own = axes.map(|axis| back * axis);
        let direction = mesh.rotation.conjugate() * axes[SWEEP_AXIS];
        let flat_direction = direction.as_vec3();
        Self {
            tree,
            normals: tree.normal_bounds(),
            turn: rows * mesh.rotation_matrix(),
            shift: rows * mesh.translation,
            axes: own,
            spread: own.map(DVec3::abs),
            shifts: axes.map(|axis| axis.dot(boxes.translation)),
            direction,
            flat_direction,
            flat_direction_spread: flat_direction.abs(),
        }
    }

    #[inline]
    fn project_node(&self, node: usize) -> ProjectedNode {
        let of_node = &self.tree.boxes[node];
        let (center, half) = (of_node.center.as_dvec3(), of_node.half.as_dvec3());
        let mut shadow = ProjectedNode { node, low: [0.0; AXIS_COUNT], high: [0.0; AXIS_COUNT] };
        for k in 0..AXIS_COUNT {
            let (middle, reach) = (self.axes[k].dot(center) + self.shifts[k], self.spread[k].dot(half));
            (shadow.low[k], shadow.high[k]) = (middle - reach, middle + reach);
        }
        shadow
    }

    /// The least and the greatest dot product of a node's normals with the direction.
    #[inline]
    fn facing_range(&self, node: usize) -> (f32, f32) {
        self.normals[node].dot_range(self.flat_direction, self.flat_direction_spread)
    }
}

/// Whether a triangle moved without limit along +z comes nearer than `gap` to another one, which is not nearer at the
/// start.
fn sweep_collides(moving: &Triangle, standing: &Triangle, gap: f64) -> bool {
    let ((low1, high1), (low2, high2)) = (moving.corner_span(), standing.corner_span());
    if high2.z <= low1.z || (low2 - high1).truncate().max((low1 - high2).truncate()).max_element() >= gap {
        return false;
    }
    if leaves_plane(moving, standing, gap) {
        return false;
    }
    let across1 = planar_relation(&moving.corners, &standing.corners, gap);
    if across1 == PlanarRelation::Apart {
        return false;
    }
    let across2 = planar_relation(&standing.corners, &moving.corners, gap);
    if across2 == PlanarRelation::Apart {
        return false;
    }
    if across1 == PlanarRelation::Overlapping && across2 == PlanarRelation::Overlapping && high1.z <= low2.z {
        return true;
    }
    if standing.corners.iter().any(|&corner| is_above(corner, &moving.corners)) {
        return true;
    }
    let up = DVec3::Z * (high2.z - low1.z + gap);
    let gap_sq = gap * gap;
    (0..3).any(|edge| {
        let (from, to) = (moving.corners[edge], moving.corners[(edge + 1) % 3]);
        [[from, to, to + up], [from, to + up, from + up]]
            .into_iter()
            .any(|half| Triangle::new(half).distance_sq_below(standing, gap_sq) < gap_sq)
    })
}

/// Whether one of the two planes shows that a moving triangle is already `gap` away from the other one, and moves
/// further away.
fn leaves_plane(moving: &Triangle, standing: &Triangle, gap: f64) -> bool {
    let upwards = |normal: DVec3| if normal.z < 0.0 { -normal } else { normal };
    let (normal1, normal2) = (upwards(moving.normal), upwards(standing.normal));
    let limits = |triangle: &Triangle, normal: DVec3| {
        let [a, b, c] = triangle.corners.map(|corner| corner.dot(normal));
        (a.min(b).min(c), a.max(b).max(c))
    };
    // The normal of a sliver is zero, so all its limits are zero and nothing follows.
    limits(moving, normal1).0 - limits(standing, normal1).1 >= gap
        || limits(moving, normal2).0 - limits(standing, normal2).1 >= gap
}

/// The relation of two triangles projected along z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PlanarRelation {
    /// At least a gap apart.
    Apart,
    /// Overlapping along all tested axes.
    Overlapping,
    /// Nearer than a gap, or only touching.
    Near,
}

/// Tests two triangles along the normals of the first one's edges.
fn planar_relation(corners1: &[DVec3; 3], corners2: &[DVec3; 3], gap: f64) -> PlanarRelation {
    let flat1 = corners1.map(DVec3::truncate);
    let flat2 = corners2.map(DVec3::truncate);
    let mut found = PlanarRelation::Overlapping;
    for edge in 0..3 {
        let normal = (flat1[(edge + 1) % 3] - flat1[edge]).perp();
        let limits = |[a, b, c]: [DVec2; 3]| {
            let [a, b, c] = [a.dot(normal), b.dot(normal), c.dot(normal)];
            (a.min(b).min(c), a.max(b).max(c))
        };
        let ((low1, high1), (low2, high2)) = (limits(flat1), limits(flat2));
        // The normal is as long as the edge.
        let (apart, length_sq) = ((low2 - high1).max(low1 - high2), normal.length_squared());
        if apart > 0.0 && apart * apart >= gap * gap * length_sq {
            // An edge of length 0 has no normal.
            if length_sq > ROUNDING_MM * ROUNDING_MM {
                return PlanarRelation::Apart;
            }
        }
        if apart > 0.0 || apart * apart <= ROUNDING_MM * ROUNDING_MM * length_sq {
            found = PlanarRelation::Near;
        }
    }
    found
}

/// Whether a point lies above (in +z of) a triangle that is not seen edge-on.
fn is_above(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> bool {
    let area = (b - a).truncate().perp_dot((c - a).truncate());
    if area.abs() < ROUNDING_MM * ROUNDING_MM {
        return false;
    }
    let share = |from: DVec3, to: DVec3| (to - from).truncate().perp_dot((point - from).truncate()) / area;
    let [of_c, of_a, of_b] = [share(a, b), share(b, c), share(c, a)];
    of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 && point.z > a.z * of_a + b.z * of_b + c.z * of_c
}
