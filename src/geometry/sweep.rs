//! Whether one part can be drawn past another along a straight line, exactly: the moving surface's infinite sweep against the
//! standing surface's triangles, in one walk of the two box trees and without steps along the way.

use glam::{DMat3, DVec3, Vec3};

use super::{
    ClearanceTree, Pose,
    box_tree::{BoxTree, Node},
    triangle::Triangle,
};

/// A face that leans less than this towards the way (the cosine) counts as standing along it: what it sweeps is swept by its
/// neighbours too.
const LEAN: f64 = 4e-6;
/// Triangles seen edge-on are no wider than this, mm.
const ROUNDING_MM: f64 = 1e-9;

impl ClearanceTree {
    /// Whether this part, moved along `direction1` (of its mesh frame, any length but 0) for ever, keeps `gap_mm` or more
    /// from `other` all the way. The two must not be nearer than that to begin with. A part in a cavity, through a ring or
    /// under a flange of the other is held as any obstacle holds it: by the surface that it would meet. `pose12` is the
    /// frame of `other` seen from this one.
    pub fn is_free_along(&self, other: &Self, pose12: &Pose, direction1: DVec3, gap_mm: f64) -> bool {
        !Sweep::new(self, other, pose12, direction1, gap_mm).is_barred()
    }
}

/// Two trees seen from a frame whose z axis is the way that the first one takes.
struct Sweep<'a> {
    moving: Seen<'a>,
    standing: Seen<'a>,
    gap_mm: f64,
    /// Only what faces the way is swept, only what faces against it is met: true of solids, not of open surfaces.
    solid: bool,
}

/// Axes along which boxes are seen: x, y, their two diagonals, z, which is the way, and the axes of both trees' boxes.
const AXES: usize = 11;

/// A tree in the frame of the way.
struct Seen<'a> {
    tree: &'a BoxTree,
    turn: DMat3,
    shift: DVec3,
    /// The axes in the tree's own frame.
    axes: [DVec3; AXES],
    /// Absolute values of the axes: they turn half edges into half widths.
    spread: [DVec3; AXES],
    shifts: [f64; AXES],
    /// The way in the tree's own frame, and its absolute values.
    way: Vec3,
    way_spread: Vec3,
}

/// A node with its box as it is seen along the axes.
#[derive(Clone, Copy)]
struct Shadow<'a> {
    node: &'a Node,
    low: [f64; AXES],
    high: [f64; AXES],
}

impl<'a> Sweep<'a> {
    fn new(part1: &'a ClearanceTree, part2: &'a ClearanceTree, pose12: &Pose, direction1: DVec3, gap_mm: f64) -> Self {
        let (box1, box2) = (part1.obb().pose, pose12.after(&part2.obb().pose));
        let way = direction1.normalize();
        // The first box's longest side that stands across the way gives x.
        let sides = box1.matrix();
        let across = if sides.x_axis.dot(way).abs() < 0.9 { sides.x_axis } else { sides.y_axis };
        let x = (across - way * across.dot(way)).normalize();
        let y = way.cross(x);
        // An axis that the way runs along, not against: then only what stands before the sweep along it is out of reach.
        let onward = |axis: DVec3| if axis.dot(way) < 0.0 { -axis } else { axis };
        let (sides1, sides2) = (box1.matrix(), box2.matrix());
        let [a, b, c] = [sides1.x_axis, sides1.y_axis, sides1.z_axis].map(onward);
        let [d, e, f] = [sides2.x_axis, sides2.y_axis, sides2.z_axis].map(onward);
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        let axes = [x, y, (x + y) * diagonal, (x - y) * diagonal, way, a, b, c, d, e, f];
        let rows = DMat3::from_cols(x, y, way).transpose();
        Self {
            moving: Seen::new(&part1.tree, rows, &box1, &axes),
            standing: Seen::new(&part2.tree, rows, &box2, &axes),
            gap_mm,
            solid: part1.mesh().defects().is_closed() && part2.mesh().defects().is_closed(),
        }
    }

    fn is_barred(&self) -> bool {
        let (shadow1, shadow2) = (self.moving.shadow(0), self.standing.shadow(0));
        self.may_meet(&shadow1, &shadow2) && self.visit(&shadow1, &shadow2)
    }

    /// Whether boxes leave it open that something of the first sweeps over something of the second.
    #[inline]
    fn may_meet(&self, shadow1: &Shadow<'_>, shadow2: &Shadow<'_>) -> bool {
        shadow2.high[4] > shadow1.low[4]
            && (0..4).all(|k| {
                shadow2.low[k] - shadow1.high[k] < self.gap_mm && shadow1.low[k] - shadow2.high[k] < self.gap_mm
            })
            && (5..AXES).all(|k| shadow1.low[k] - shadow2.high[k] < self.gap_mm)
    }

    fn visit(&self, shadow1: &Shadow<'_>, shadow2: &Shadow<'_>) -> bool {
        let (node1, node2) = (shadow1.node, shadow2.node);
        if node1.is_leaf() && node2.is_leaf() {
            return self.compare(node1, node2);
        }
        let open1 = !node1.is_leaf() && (node2.is_leaf() || node1.half.length_squared() >= node2.half.length_squared());
        (0..2).any(|child| {
            if open1 {
                let at = node1.first as usize + child;
                if self.solid && self.moving.faces(at).1 <= LEAN as f32 {
                    return false;
                }
                let shadow1 = self.moving.shadow(at);
                self.may_meet(&shadow1, shadow2) && self.visit(&shadow1, shadow2)
            } else {
                let at = node2.first as usize + child;
                if self.solid && self.standing.faces(at).0 >= -LEAN as f32 {
                    return false;
                }
                let shadow2 = self.standing.shadow(at);
                self.may_meet(shadow1, &shadow2) && self.visit(shadow1, &shadow2)
            }
        })
    }

    fn compare(&self, leaf1: &Node, leaf2: &Node) -> bool {
        let standing = |triangle: &Triangle| triangle.moved(&self.standing.turn, self.standing.shift);
        let moving = |triangle: &Triangle| triangle.moved(&self.moving.turn, self.moving.shift);
        let ahead = |t: &Triangle| !self.solid || t.normal.z > LEAN || t.normal == DVec3::ZERO;
        let against = |t: &Triangle| !self.solid || t.normal.z < -LEAN || t.normal == DVec3::ZERO;
        for triangle1 in self.moving.tree.triangles[leaf1.range()].iter().map(moving).filter(ahead) {
            for triangle2 in self.standing.tree.triangles[leaf2.range()].iter().map(standing).filter(against) {
                if sweeps_over(&triangle1, &triangle2, self.gap_mm) {
                    return true;
                }
            }
        }
        false
    }
}

impl<'a> Seen<'a> {
    fn new(tree: &'a BoxTree, rows: DMat3, pose: &Pose, axes: &[DVec3; AXES]) -> Self {
        let matrix = pose.matrix();
        let back = matrix.transpose();
        let own = axes.map(|axis| back * axis);
        let way = own[4].as_vec3();
        Self {
            tree,
            turn: rows * matrix,
            shift: rows * pose.translation,
            axes: own,
            spread: own.map(DVec3::abs),
            shifts: axes.map(|axis| axis.dot(pose.translation)),
            way,
            way_spread: way.abs(),
        }
    }

    #[inline]
    fn shadow(&self, node: usize) -> Shadow<'a> {
        let node = &self.tree.nodes[node];
        let mut shadow = Shadow { node, low: [0.0; AXES], high: [0.0; AXES] };
        for k in 0..AXES {
            let (middle, half) = (self.axes[k].dot(node.center) + self.shifts[k], self.spread[k].dot(node.half));
            (shadow.low[k], shadow.high[k]) = (middle - half, middle + half);
        }
        shadow
    }

    /// How little and how much the triangles of a node face the way.
    #[inline]
    fn faces(&self, node: usize) -> (f32, f32) {
        self.tree.facings[node].along(self.way, self.way_spread)
    }
}

/// Whether a triangle moved along +z for ever comes nearer than `gap` to another, nearer than which it is not now.
fn sweeps_over(moving: &Triangle, standing: &Triangle, gap: f64) -> bool {
    let span = |t: &Triangle| {
        (t.corners[0].min(t.corners[1]).min(t.corners[2]), t.corners[0].max(t.corners[1]).max(t.corners[2]))
    };
    let ((low1, high1), (low2, high2)) = (span(moving), span(standing));
    if high2.z <= low1.z || (low2 - high1).truncate().max((low1 - high2).truncate()).max_element() >= gap {
        return false;
    }
    let apart = apart_across(&moving.corners, &standing.corners).max(apart_across(&standing.corners, &moving.corners));
    if apart >= gap {
        return false;
    }
    if apart < -ROUNDING_MM && high1.z <= low2.z {
        return true;
    }
    if standing.corners.iter().any(|&corner| is_over(corner, &moving.corners)) {
        return true;
    }
    let up = DVec3::Z * (high2.z - low1.z + gap);
    (0..3).any(|edge| {
        let (from, to) = (moving.corners[edge], moving.corners[(edge + 1) % 3]);
        let gap_sq = gap * gap;
        [[from, to, to + up], [from, to + up, from + up]]
            .into_iter()
            .any(|half| Triangle::new(half).distance_sq_below(standing, gap_sq) < gap_sq)
    })
}

/// How far apart two triangles stand across z, seen along the normals of the first one's edges, mm; negative when they
/// overlap along all of them.
fn apart_across(corners1: &[DVec3; 3], corners2: &[DVec3; 3]) -> f64 {
    let mut most = f64::NEG_INFINITY;
    for edge in 0..3 {
        let along = (corners1[(edge + 1) % 3] - corners1[edge]).truncate();
        let Some(normal) = along.perp().try_normalize() else { continue };
        let limits = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner.truncate().dot(normal));
            (a.min(b).min(c), a.max(b).max(c))
        };
        let ((low1, high1), (low2, high2)) = (limits(corners1), limits(corners2));
        most = most.max(low2 - high1).max(low1 - high2);
    }
    most
}

/// Whether a point stands over (in +z of) a triangle that is not seen edge-on.
fn is_over(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> bool {
    let area = (b - a).truncate().perp_dot((c - a).truncate());
    if area.abs() < ROUNDING_MM * ROUNDING_MM {
        return false;
    }
    let share = |from: DVec3, to: DVec3| (to - from).truncate().perp_dot((point - from).truncate()) / area;
    let [of_c, of_a, of_b] = [share(a, b), share(b, c), share(c, a)];
    of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 && point.z > a.z * of_a + b.z * of_b + c.z * of_c
}
