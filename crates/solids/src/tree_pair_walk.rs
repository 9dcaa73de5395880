//! Traverses two box trees at once to find the least distance between their triangles.

use glam::{DMat3, DVec3};

use super::{
    Pose,
    box_tree::{BoxTreeNode, TriangleBoxTree},
    triangle::Triangle,
};

/// Two trees, and frame 2 (of the second tree's boxes) seen from frame 1.
pub(super) struct TreePairWalk<'a> {
    tree1: &'a TriangleBoxTree,
    tree2: &'a TriangleBoxTree,
    rotation12: DMat3,
    /// Absolute values of the rotation: they convert half edges of a box to the other frame.
    spread12: DMat3,
    spread21: DMat3,
    translation12: DVec3,
}

impl<'a> TreePairWalk<'a> {
    /// `pose12` is the frame of the second tree's boxes seen from that of the first's.
    pub fn new(tree1: &'a TriangleBoxTree, tree2: &'a TriangleBoxTree, pose12: &Pose) -> Self {
        let rotation12 = pose12.rotation_matrix();
        let spread12 = DMat3::from_cols(rotation12.x_axis.abs(), rotation12.y_axis.abs(), rotation12.z_axis.abs());
        Self { tree1, tree2, rotation12, spread12, spread21: spread12.transpose(), translation12: pose12.translation }
    }

    /// The least squared distance below `cap_sq`, or `cap_sq`; stops as soon as one at or below `goal_sq` is found,
    /// mm2.
    pub fn nearest_sq(&self, cap_sq: f64, goal_sq: f64) -> f64 {
        let mut search = NearestSearch { walk: self, best_sq: cap_sq, goal_sq };
        let (root1, root2) = (&self.tree1.nodes[0], &self.tree2.nodes[0]);
        if self.lower_bound_sq(root1, root2, cap_sq) < cap_sq {
            search.visit_pair(root1, root2);
        }
        search.best_sq
    }

    /// Calls `each` with the nearest two triangles of every two leaves that come nearer than the root of `limit_sq`
    /// (mm2) without meeting. The second triangle is given in frame 1.
    pub fn visit_near_leaves(&self, limit_sq: f64, each: &mut dyn FnMut(&Triangle, &Triangle)) {
        let mut open = vec![(0_usize, 0_usize)];
        while let Some((at1, at2)) = open.pop() {
            let (node1, node2) = (&self.tree1.nodes[at1], &self.tree2.nodes[at2]);
            if self.lower_bound_sq(node1, node2, limit_sq) >= limit_sq {
                continue;
            }
            if node1.is_leaf() && node2.is_leaf() {
                self.visit_nearest_triangles(node1, node2, limit_sq, each);
            } else if opens_first(node1, node2) {
                open.extend([0, 1].map(|child| (node1.first as usize + child, at2)));
            } else {
                open.extend([0, 1].map(|child| (at1, node2.first as usize + child)));
            }
        }
    }

    fn visit_nearest_triangles(
        &self,
        leaf1: &BoxTreeNode,
        leaf2: &BoxTreeNode,
        limit_sq: f64,
        each: &mut dyn FnMut(&Triangle, &Triangle),
    ) {
        let mut best_sq = limit_sq;
        let mut best = None;
        for triangle2 in &self.tree2.triangles[leaf2.triangle_range()] {
            let triangle2 = triangle2.transformed_by(&self.rotation12, self.translation12);
            for triangle1 in &self.tree1.triangles[leaf1.triangle_range()] {
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

    /// A lower bound of the squared distance of two boxes: the gaps along one box's axes are a part of any connecting
    /// line. May return early with a first bound that reaches `enough_sq`.
    #[inline]
    fn lower_bound_sq(&self, node1: &BoxTreeNode, node2: &BoxTreeNode, enough_sq: f64) -> f64 {
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

/// Whether to open the first of two nodes that are not both leaves: the one with the larger box, since that improves
/// the bound most.
#[inline]
fn opens_first(node1: &BoxTreeNode, node2: &BoxTreeNode) -> bool {
    !node1.is_leaf() && (node2.is_leaf() || node1.half.length_squared() >= node2.half.length_squared())
}

struct NearestSearch<'a> {
    walk: &'a TreePairWalk<'a>,
    best_sq: f64,
    goal_sq: f64,
}

impl NearestSearch<'_> {
    fn visit_pair(&mut self, node1: &BoxTreeNode, node2: &BoxTreeNode) {
        if node1.is_leaf() && node2.is_leaf() {
            return self.compare_leaves(node1, node2);
        }
        let open1 = opens_first(node1, node2);
        let walk = self.walk;
        let (opened, nodes) = if open1 { (node1, &walk.tree1.nodes) } else { (node2, &walk.tree2.nodes) };
        let children = [&nodes[opened.first as usize], &nodes[opened.first as usize + 1]];
        let pair = |child: usize| if open1 { (children[child], node2) } else { (node1, children[child]) };
        let bounds = [0, 1].map(|c| walk.lower_bound_sq(pair(c).0, pair(c).1, self.best_sq));
        let order = if bounds[0] <= bounds[1] { [0, 1] } else { [1, 0] };
        for child in order {
            if bounds[child] < self.best_sq && self.best_sq > self.goal_sq {
                let (node1, node2) = pair(child);
                self.visit_pair(node1, node2);
            }
        }
    }

    fn compare_leaves(&mut self, leaf1: &BoxTreeNode, leaf2: &BoxTreeNode) {
        let walk = self.walk;
        for triangle2 in &walk.tree2.triangles[leaf2.triangle_range()] {
            let triangle2 = triangle2.transformed_by(&walk.rotation12, walk.translation12);
            for triangle1 in &walk.tree1.triangles[leaf1.triangle_range()] {
                self.best_sq = triangle1.distance_sq_below(&triangle2, self.best_sq);
                if self.best_sq <= self.goal_sq {
                    return;
                }
            }
        }
    }
}
