//! Traverses two box trees at once to find the least distance between their triangles. Boxes are compared in single
//! precision with a margin for its rounding. So are triangles, to rule out those that are far; the distance of the others is
//! worked out in double precision in the first mesh's frame.

use glam::{DMat3, DVec3, Mat3A, Vec3A};

use super::{
    box_tree::TriangleBoxTree,
    node_box::{TreeNodeBox, TreeNodeLink},
};
use crate::{Pose, mesh::triangle::Triangle};

/// Surfaces nearer than this count as meeting, mm: far above rounding, far below any printer's resolution.
pub(crate) const MEET_MM: f64 = 1e-9;

/// Rounding errors of a comparison of two boxes, as a share of the lengths that enter it: 16 roundings and more.
const ROUNDING_SHARE: f32 = 1e-6;

/// Two trees, and the second mesh's frame seen from the first one's.
pub(crate) struct TreePairWalk<'a> {
    tree1: &'a TriangleBoxTree,
    tree2: &'a TriangleBoxTree,
    rotation12: DMat3,
    translation12: DVec3,
    /// The first tree's boxes seen from the second's frame, and the other way round.
    view1: TreeBoxView,
    view2: TreeBoxView,
    /// What rounding may add to the distance of two triangles in single precision, mm: of the lengths that enter it, 1 rounding
    /// to store a corner of each, 9 to see one from the other frame, 3 in each of two dot products and 1 in their difference
    /// are 18 in all, at 6e-8 each 1.1e-6; twice the share of a box is 2e-6.
    margin: f32,
}

/// How the boxes of a tree are seen from the frame of the other tree's boxes.
struct TreeBoxView {
    rotation: Mat3A,
    /// Absolute values of the rotation: they convert half edges of a box to the other frame.
    spread: Mat3A,
    translation: Vec3A,
    /// What rounding may add to a gap, mm.
    margin: Vec3A,
}

impl TreeBoxView {
    fn new(pose: &Pose, margin: f32) -> Self {
        let rotation = Mat3A::from(pose.rotation_matrix().as_mat3());
        let spread = Mat3A::from_cols(rotation.x_axis.abs(), rotation.y_axis.abs(), rotation.z_axis.abs());
        Self { rotation, spread, translation: pose.translation.as_vec3a(), margin: Vec3A::splat(margin) }
    }

    #[inline]
    fn seen_node(&self, tree: &TriangleBoxTree, node: usize) -> SeenTreeNode {
        let TreeNodeBox { center, half } = tree.boxes[node];
        SeenTreeNode {
            link: tree.links[node],
            center,
            half,
            center_seen: self.rotation * center + self.translation,
            half_seen: self.spread * half + self.margin,
            size_sq: half.length_squared(),
        }
    }
}

/// A node with its box in its own frame and as seen from the other tree's.
#[derive(Clone, Copy)]
struct SeenTreeNode {
    link: TreeNodeLink,
    center: Vec3A,
    half: Vec3A,
    center_seen: Vec3A,
    half_seen: Vec3A,
    size_sq: f32,
}

impl SeenTreeNode {
    /// A lower bound of the squared distance of the boxes of two nodes: the gaps along one box's axes are a part of any
    /// connecting line. May return early with a first bound that reaches `enough_sq`.
    #[inline]
    fn lower_bound_sq(&self, other: &Self, enough_sq: f32) -> f32 {
        let gaps1 = ((other.center_seen - self.center).abs() - (self.half + other.half_seen)).max(Vec3A::ZERO);
        let bound_sq = gaps1.length_squared();
        if bound_sq >= enough_sq {
            return bound_sq;
        }
        let gaps2 = ((self.center_seen - other.center).abs() - (other.half + self.half_seen)).max(Vec3A::ZERO);
        bound_sq.max(gaps2.length_squared())
    }

    /// Whether to open this node and not the other one, which are not both leaves.
    #[inline]
    fn opens_before(&self, other: &Self) -> bool {
        !self.link.is_leaf() && (other.link.is_leaf() || self.size_sq >= other.size_sq)
    }
}

/// A bound of boxes that reaches this cannot belong to triangles that are nearer than the root of `limit_sq`.
#[inline]
fn rounded_up(limit_sq: f64) -> f32 {
    (limit_sq * (1.0 + 1e-6)) as f32
}

impl<'a> TreePairWalk<'a> {
    /// `pose12` is the second mesh's frame seen from the first one's, `boxes12` the same of the frames of their boxes.
    pub fn new(tree1: &'a TriangleBoxTree, tree2: &'a TriangleBoxTree, pose12: &Pose, boxes12: &Pose) -> Self {
        let length = |v: Vec3A| v.abs().element_sum();
        let reach = |root: &TreeNodeBox| length(root.center) + length(root.half);
        let lengths = length(boxes12.translation.as_vec3a()) + reach(&tree1.boxes[0]) + reach(&tree2.boxes[0]);
        let margin = ROUNDING_SHARE * lengths;
        Self {
            tree1,
            tree2,
            rotation12: pose12.rotation_matrix(),
            translation12: pose12.translation,
            view1: TreeBoxView::new(&boxes12.inverse(), margin),
            view2: TreeBoxView::new(boxes12, margin),
            margin: 2.0 * margin,
        }
    }

    /// The least squared distance below `cap_sq`, or `cap_sq`; stops as soon as one at or below `goal_sq` is found,
    /// mm2.
    pub fn nearest_sq(&self, cap_sq: f64, goal_sq: f64) -> f64 {
        let nearer = |_: &Triangle, _: &Triangle| {};
        let mut search = NearestSearch { walk: self, best_sq: cap_sq, reach_sq: rounded_up(cap_sq), goal_sq, nearer };
        let (root1, root2) = self.seen_roots();
        if root1.lower_bound_sq(&root2, search.reach_sq) < search.reach_sq {
            search.visit_pair(&root1, &root2);
        }
        search.best_sq
    }

    /// Splits the first surface into patches whose boxes are at most `patch_mm` across. Calls `each`, for every patch that
    /// comes nearer to the second surface than the root of `limit_sq` (mm2) without meeting it, with the nearest triangle
    /// of the patch and of the second surface, both in the first mesh's frame. A leaf that is larger than a patch is
    /// compared with the patches of the second surface one by one: its large triangles may be near in several places.
    /// Where the surfaces meet, it calls nothing.
    pub fn visit_near_patches(&self, patch_mm: f32, limit_sq: f64, each: &mut dyn FnMut(&Triangle, &Triangle)) {
        let reach_sq = rounded_up(limit_sq);
        let patch_sq = 0.25 * patch_mm * patch_mm;
        let mut patches: Vec<NearPatch> = Vec::new();
        let mut open = vec![self.seen_roots()];
        while let Some((node1, node2)) = open.pop() {
            if node1.lower_bound_sq(&node2, reach_sq) >= reach_sq {
                continue;
            }
            let is_patch2 = node2.link.is_leaf() || node2.size_sq <= patch_sq;
            if node1.size_sq <= patch_sq || (node1.link.is_leaf() && is_patch2) {
                let known = patches.iter().position(|patch| patch.link == node1.link && node1.size_sq <= patch_sq);
                let known = known.unwrap_or_else(|| {
                    patches.push(NearPatch { link: node1.link, best_sq: limit_sq, nearest: None });
                    patches.len() - 1
                });
                self.search_patch(&mut patches[known], &node1, &node2);
                if patches[known].best_sq <= MEET_MM * MEET_MM {
                    return;
                }
            } else if node1.opens_before(&node2) {
                open.extend(self.children1(&node1).map(|child| (child, node2)));
            } else {
                open.extend(self.children2(&node2).map(|child| (node1, child)));
            }
        }
        patches.iter().filter_map(|patch| patch.nearest.as_ref()).for_each(|(one, two)| each(one, two));
    }

    /// Looks in a part of the second surface for a triangle nearer to the patch than the known one.
    fn search_patch(&self, patch: &mut NearPatch, node1: &SeenTreeNode, node2: &SeenTreeNode) {
        let nearest = &mut patch.nearest;
        let mut search = NearestSearch {
            walk: self,
            best_sq: patch.best_sq,
            reach_sq: rounded_up(patch.best_sq),
            goal_sq: MEET_MM * MEET_MM,
            nearer: |one: &Triangle, two: &Triangle| *nearest = Some((*one, *two)),
        };
        if node1.lower_bound_sq(node2, search.reach_sq) < search.reach_sq {
            search.visit_pair(node1, node2);
        }
        patch.best_sq = search.best_sq;
    }

    fn seen_roots(&self) -> (SeenTreeNode, SeenTreeNode) {
        (self.view1.seen_node(self.tree1, 0), self.view2.seen_node(self.tree2, 0))
    }

    #[inline]
    fn children1(&self, node: &SeenTreeNode) -> [SeenTreeNode; 2] {
        [0, 1].map(|child| self.view1.seen_node(self.tree1, node.link.first_child() + child))
    }

    #[inline]
    fn children2(&self, node: &SeenTreeNode) -> [SeenTreeNode; 2] {
        [0, 1].map(|child| self.view2.seen_node(self.tree2, node.link.first_child() + child))
    }

    /// Compares the triangles of two leaves until a squared distance at or below `goal_sq` is found. Calls `nearer` with
    /// any two that are nearer than all before.
    #[inline]
    fn compare_leaves(
        &self,
        leaf1: TreeNodeLink,
        leaf2: TreeNodeLink,
        best_sq: &mut f64,
        goal_sq: f64,
        nearer: &mut impl FnMut(&Triangle, &Triangle),
    ) {
        let (places1, places2) = (leaf1.triangle_range(), leaf2.triangle_range());
        let lanes1 = self.tree1.leaf_lanes(leaf1).with_spans();
        let lanes2 = self.tree2.leaf_lanes(leaf2).seen_by(&self.view2.rotation, self.view2.translation).with_spans();
        let mut reach = self.triangle_reach(*best_sq);
        for (lane, place2) in places2.enumerate() {
            let mut near = lanes1.lanes_within(&lanes2, lane, reach) & ((1 << places1.len()) - 1);
            if near == 0 {
                continue;
            }
            let two = self.second_triangle(place2);
            while near != 0 {
                let place1 = places1.start + near.trailing_zeros() as usize;
                near &= near - 1;
                let made;
                let one = match self.tree1.ready_triangle(place1) {
                    Some(ready) => ready,
                    None => {
                        made = self.tree1.triangle(place1);
                        &made
                    }
                };
                let found_sq = one.distance_sq_below(&two, *best_sq);
                if found_sq < *best_sq {
                    *best_sq = found_sq;
                    nearer(one, &two);
                    if found_sq <= goal_sq {
                        return;
                    }
                    reach = self.triangle_reach(*best_sq);
                }
            }
        }
    }

    /// A triangle of the second tree in the first mesh's frame.
    #[inline]
    fn second_triangle(&self, place: usize) -> Triangle {
        match self.tree2.ready_triangle(place) {
            Some(ready) => ready.transformed_by(&self.rotation12, self.translation12),
            None => Triangle::new(self.tree2.corners(place).map(|c| self.rotation12 * c + self.translation12)),
        }
    }

    /// What single precision must say of the distance of two triangles that are not nearer than the root of `best_sq`.
    #[inline]
    fn triangle_reach(&self, best_sq: f64) -> f32 {
        best_sq.sqrt() as f32 * (1.0 + 1e-6) + self.margin
    }
}

/// Whether to open the first of two nodes that are not both leaves: the one with the larger box, since that improves
/// the bound most.
#[inline]
pub(crate) fn opens_first(tree1: &TriangleBoxTree, tree2: &TriangleBoxTree, node1: usize, node2: usize) -> bool {
    let size = |node: &TreeNodeBox| node.half.length_squared();
    !tree1.links[node1].is_leaf()
        && (tree2.links[node2].is_leaf() || size(&tree1.boxes[node1]) >= size(&tree2.boxes[node2]))
}

/// A patch of the first surface, and what was found nearest to it.
struct NearPatch {
    link: TreeNodeLink,
    best_sq: f64,
    nearest: Option<(Triangle, Triangle)>,
}

struct NearestSearch<'a, F> {
    walk: &'a TreePairWalk<'a>,
    best_sq: f64,
    /// Boxes at this squared distance cannot hold anything nearer.
    reach_sq: f32,
    goal_sq: f64,
    /// Called with any two triangles that are nearer than all before.
    nearer: F,
}

impl<F: FnMut(&Triangle, &Triangle)> NearestSearch<'_, F> {
    fn visit_pair(&mut self, node1: &SeenTreeNode, node2: &SeenTreeNode) {
        let walk = self.walk;
        if node1.link.is_leaf() && node2.link.is_leaf() {
            walk.compare_leaves(node1.link, node2.link, &mut self.best_sq, self.goal_sq, &mut self.nearer);
            self.reach_sq = rounded_up(self.best_sq);
        } else if node1.opens_before(node2) {
            let children = walk.children1(node1);
            self.visit_nearer_first(&children, node2, |search, child, other| search.visit_pair(child, other));
        } else {
            let children = walk.children2(node2);
            self.visit_nearer_first(&children, node1, |search, child, other| search.visit_pair(other, child));
        }
    }

    #[inline]
    fn visit_nearer_first(
        &mut self,
        children: &[SeenTreeNode; 2],
        other: &SeenTreeNode,
        mut visit: impl FnMut(&mut Self, &SeenTreeNode, &SeenTreeNode),
    ) {
        let bounds = [0, 1].map(|at: usize| children[at].lower_bound_sq(other, self.reach_sq));
        let order = if bounds[0] <= bounds[1] { [0, 1] } else { [1, 0] };
        for at in order {
            if bounds[at] < self.reach_sq && self.best_sq > self.goal_sq {
                visit(self, &children[at], other);
            }
        }
    }
}
