//! Walks two box trees at once for the least distance between their triangles.

use glam::{DMat3, DVec3};

use super::{
    Pose,
    box_tree::{BoxTree, Node},
    triangle::Triangle,
};

/// Two trees, and frame 2 (of the second tree's boxes) seen from frame 1.
pub(super) struct Walk<'a> {
    tree1: &'a BoxTree,
    tree2: &'a BoxTree,
    rotation12: DMat3,
    /// Absolute values of the rotation: half edges of a box seen from the other frame.
    spread12: DMat3,
    spread21: DMat3,
    translation12: DVec3,
}

impl<'a> Walk<'a> {
    /// `pose12` is the frame of the second tree's boxes seen from that of the first's.
    pub fn new(tree1: &'a BoxTree, tree2: &'a BoxTree, pose12: &Pose) -> Self {
        let rotation12 = pose12.matrix();
        let spread12 = DMat3::from_cols(rotation12.x_axis.abs(), rotation12.y_axis.abs(), rotation12.z_axis.abs());
        Self { tree1, tree2, rotation12, spread12, spread21: spread12.transpose(), translation12: pose12.translation }
    }

    /// The least squared distance below `cap_sq`, or `cap_sq`; ends as soon as one at or below `goal_sq` is found, mm2.
    pub fn nearest_sq(&self, cap_sq: f64, goal_sq: f64) -> f64 {
        let mut search = Search { walk: self, best_sq: cap_sq, goal_sq };
        let (root1, root2) = (&self.tree1.nodes[0], &self.tree2.nodes[0]);
        if self.apart_sq(root1, root2, cap_sq) < cap_sq {
            search.visit(root1, root2);
        }
        search.best_sq
    }

    /// Tells `each` of the nearest two triangles of every two leaves that come nearer than the root of `limit_sq` (mm2)
    /// without meeting. The second triangle is given in frame 1.
    pub fn near_leaves(&self, limit_sq: f64, each: &mut dyn FnMut(&Triangle, &Triangle)) {
        let mut open = vec![(0_usize, 0_usize)];
        while let Some((at1, at2)) = open.pop() {
            let (node1, node2) = (&self.tree1.nodes[at1], &self.tree2.nodes[at2]);
            if self.apart_sq(node1, node2, limit_sq) >= limit_sq {
                continue;
            }
            if node1.is_leaf() && node2.is_leaf() {
                self.nearest_triangles(node1, node2, limit_sq, each);
            } else if opens_first(node1, node2) {
                open.extend([0, 1].map(|child| (node1.first as usize + child, at2)));
            } else {
                open.extend([0, 1].map(|child| (at1, node2.first as usize + child)));
            }
        }
    }

    fn nearest_triangles(&self, leaf1: &Node, leaf2: &Node, limit_sq: f64, each: &mut dyn FnMut(&Triangle, &Triangle)) {
        let mut best_sq = limit_sq;
        let mut best = None;
        for triangle2 in &self.tree2.triangles[leaf2.range()] {
            let triangle2 = triangle2.moved(&self.rotation12, self.translation12);
            for triangle1 in &self.tree1.triangles[leaf1.range()] {
                let found_sq = triangle1.distance_sq_below(&triangle2, best_sq);
                if found_sq < best_sq {
                    (best_sq, best) = (found_sq, Some((triangle1, triangle2)));
                }
            }
        }
        if let Some((triangle1, triangle2)) = best.filter(|_| best_sq > 0.0) {
            each(triangle1, &triangle2);
        }
    }

    /// A lower bound of the squared distance of two boxes: the gaps along one box's axes are a part of any connecting line.
    /// May stop at a first bound that reaches `enough_sq`.
    #[inline]
    fn apart_sq(&self, node1: &Node, node2: &Node, enough_sq: f64) -> f64 {
        let apart = self.rotation12 * node2.center + self.translation12 - node1.center;
        let gaps1 = (apart.abs() - node1.half - self.spread12 * node2.half).max(DVec3::ZERO);
        let bound_sq = gaps1.length_squared();
        if bound_sq >= enough_sq {
            return bound_sq;
        }
        let seen2 = DVec3::new(
            self.rotation12.x_axis.dot(apart),
            self.rotation12.y_axis.dot(apart),
            self.rotation12.z_axis.dot(apart),
        );
        let gaps2 = (seen2.abs() - node2.half - self.spread21 * node1.half).max(DVec3::ZERO);
        bound_sq.max(gaps2.length_squared())
    }
}

/// Which of two nodes that are not both leaves is opened: the larger box, for that shrinks the bound the most.
#[inline]
fn opens_first(node1: &Node, node2: &Node) -> bool {
    !node1.is_leaf() && (node2.is_leaf() || node1.half.length_squared() >= node2.half.length_squared())
}

struct Search<'a> {
    walk: &'a Walk<'a>,
    best_sq: f64,
    goal_sq: f64,
}

impl Search<'_> {
    fn visit(&mut self, node1: &Node, node2: &Node) {
        if node1.is_leaf() && node2.is_leaf() {
            return self.compare(node1, node2);
        }
        let open1 = opens_first(node1, node2);
        let walk = self.walk;
        let (opened, nodes) = if open1 { (node1, &walk.tree1.nodes) } else { (node2, &walk.tree2.nodes) };
        let children = [&nodes[opened.first as usize], &nodes[opened.first as usize + 1]];
        let pair = |child: usize| if open1 { (children[child], node2) } else { (node1, children[child]) };
        let bounds = [0, 1].map(|c| walk.apart_sq(pair(c).0, pair(c).1, self.best_sq));
        let order = if bounds[0] <= bounds[1] { [0, 1] } else { [1, 0] };
        for child in order {
            if bounds[child] < self.best_sq && self.best_sq > self.goal_sq {
                let (node1, node2) = pair(child);
                self.visit(node1, node2);
            }
        }
    }

    fn compare(&mut self, leaf1: &Node, leaf2: &Node) {
        let walk = self.walk;
        for triangle2 in &walk.tree2.triangles[leaf2.range()] {
            let triangle2 = triangle2.moved(&walk.rotation12, walk.translation12);
            for triangle1 in &walk.tree1.triangles[leaf1.range()] {
                self.best_sq = triangle1.distance_sq_below(&triangle2, self.best_sq);
                if self.best_sq <= self.goal_sq {
                    return;
                }
            }
        }
    }
}
