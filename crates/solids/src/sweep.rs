//! Whether one part can be drawn past another along a straight line, exactly: the moving surface's infinite sweep against the
//! standing surface's triangles, in one walk of the two box trees and without steps along the way.

use glam::{DMat3, DVec2, DVec3, Vec3};

use super::{
    ClearanceTree, Pose,
    box_tree::{BoxTree, LEAF, Node},
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

/// Which of the axes is the way.
const WAY: usize = 4;
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
            gap_mm: gap_mm.max(ROUNDING_MM),
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
        shadow2.high[WAY] > shadow1.low[WAY]
            && (0..WAY).all(|k| {
                shadow2.low[k] - shadow1.high[k] < self.gap_mm && shadow1.low[k] - shadow2.high[k] < self.gap_mm
            })
            && (WAY + 1..AXES).all(|k| shadow1.low[k] - shadow2.high[k] < self.gap_mm)
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
        let (moving, standing) = (&self.moving, &self.standing);
        let counts = |normal: DVec3, lean: f64| !self.solid || lean > LEAN || normal == DVec3::ZERO;
        let way = (moving.axes[WAY], standing.axes[WAY]);
        let ahead = moving.tree.triangles[leaf1.range()].iter().filter(|t| counts(t.normal, t.normal.dot(way.0)));
        let mut ahead = ahead.map(|t| t.moved(&moving.turn, moving.shift)).peekable();
        if ahead.peek().is_none() {
            return false;
        }
        let against = standing.tree.triangles[leaf2.range()].iter().filter(|t| counts(t.normal, -t.normal.dot(way.1)));
        let mut room = [None; LEAF];
        for (place, triangle) in room.iter_mut().zip(against) {
            *place = Some(triangle.moved(&standing.turn, standing.shift));
        }
        ahead.any(|one| room.iter().flatten().any(|other| sweeps_over(&one, other, self.gap_mm)))
    }
}

impl<'a> Seen<'a> {
    fn new(tree: &'a BoxTree, rows: DMat3, pose: &Pose, axes: &[DVec3; AXES]) -> Self {
        let matrix = pose.matrix();
        let back = matrix.transpose();
        let own = axes.map(|axis| back * axis);
        let way = own[WAY].as_vec3();
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
    let ((low1, high1), (low2, high2)) = (moving.span(), standing.span());
    if high2.z <= low1.z || (low2 - high1).truncate().max((low1 - high2).truncate()).max_element() >= gap {
        return false;
    }
    if leaves_plane(moving, standing, gap) {
        return false;
    }
    let across1 = across(&moving.corners, &standing.corners, gap);
    if across1 == Across::Apart {
        return false;
    }
    let across2 = across(&standing.corners, &moving.corners, gap);
    if across2 == Across::Apart {
        return false;
    }
    if across1 == Across::Overlapping && across2 == Across::Overlapping && high1.z <= low2.z {
        return true;
    }
    if standing.corners.iter().any(|&corner| is_over(corner, &moving.corners)) {
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

/// Whether one of the two planes keeps a moving triangle `gap` away from the other one already, and ever more on its way.
fn leaves_plane(moving: &Triangle, standing: &Triangle, gap: f64) -> bool {
    let upwards = |normal: DVec3| if normal.z < 0.0 { -normal } else { normal };
    let (normal1, normal2) = (upwards(moving.normal), upwards(standing.normal));
    let limits = |triangle: &Triangle, normal: DVec3| {
        let [a, b, c] = triangle.corners.map(|corner| corner.dot(normal));
        (a.min(b).min(c), a.max(b).max(c))
    };
    // Of a sliver, whose normal is zero, nothing follows: all limits are zero.
    limits(moving, normal1).0 - limits(standing, normal1).1 >= gap
        || limits(moving, normal2).0 - limits(standing, normal2).1 >= gap
}

/// How two triangles stand to each other across z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Across {
    /// A gap or more apart.
    Apart,
    /// Overlapping along all axes looked at.
    Overlapping,
    /// Nearer than a gap, or only touching.
    Near,
}

/// Looks at two triangles along the normals of the first one's edges.
fn across(corners1: &[DVec3; 3], corners2: &[DVec3; 3], gap: f64) -> Across {
    let flat1 = corners1.map(DVec3::truncate);
    let flat2 = corners2.map(DVec3::truncate);
    let mut found = Across::Overlapping;
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
            // A point of an edge has no normal.
            if length_sq > ROUNDING_MM * ROUNDING_MM {
                return Across::Apart;
            }
        }
        if apart > 0.0 || apart * apart <= ROUNDING_MM * ROUNDING_MM * length_sq {
            found = Across::Near;
        }
    }
    found
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
