//! Traverses two box trees at once to find the least distance between their triangles. Boxes are compared in single
//! precision with a margin for its rounding, triangles in double precision in the first mesh's frame.

use glam::{DMat3, DVec3, Mat3A, Vec3A};

use super::{
    Pose,
    box_tree::TriangleBoxTree,
    box_tree_build::MAX_LEAF_TRIANGLES,
    node_box::{TreeNodeBox, TreeNodeLink},
    triangle::{CornerSpan, Triangle},
};

/// Rounding errors of a comparison of two boxes, as a share of the lengths that enter it: 16 roundings and more.
const ROUNDING_SHARE: f32 = 1e-6;

/// Two trees, and the second mesh's frame seen from the first one's.
pub(super) struct TreePairWalk<'a> {
    tree1: &'a TriangleBoxTree,
    tree2: &'a TriangleBoxTree,
    rotation12: DMat3,
    translation12: DVec3,
    /// The first tree's boxes seen from the second's frame, and the other way round.
    view1: TreeBoxView,
    view2: TreeBoxView,
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
            } else if node1.opens_before(&node2) {
                open.extend(self.children1(&node1).map(|child| (child, node2)));
            } else {
                open.extend(self.children2(&node2).map(|child| (node1, child)));
            }
        }
        for (one, two) in patches.iter().filter(|patch| patch.best_sq > 0.0).filter_map(|patch| patch.nearest.as_ref())
        {
            each(one, two);
        }
    }

    /// Looks in a part of the second surface for a triangle nearer to the patch than the known one.
    fn search_patch(&self, patch: &mut NearPatch, node1: &SeenTreeNode, node2: &SeenTreeNode) {
        let nearest = &mut patch.nearest;
        let mut search = NearestSearch {
            walk: self,
            best_sq: patch.best_sq,
            reach_sq: rounded_up(patch.best_sq),
            goal_sq: 0.0,
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
        let mut first = [const { None::<LeafTriangle> }; MAX_LEAF_TRIANGLES];
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (slot, place) in first.iter_mut().zip(leaf1.triangle_range()) {
            let triangle = LeafTriangle::new(self.tree1.corners(place), place);
            around = (around.0.min(triangle.span.0), around.1.max(triangle.span.1));
            *slot = Some(triangle);
        }
        for place in leaf2.triangle_range() {
            let corners = self.tree2.corners(place).map(|c| self.rotation12 * c + self.translation12);
            let mut second = LeafTriangle::new(corners, place);
            if spans_distance_sq(around, second.span) >= *best_sq {
                continue;
            }
            for one in first.iter_mut().flatten() {
                let spans = (one.span, second.span);
                if spans_distance_sq(spans.0, spans.1) >= *best_sq {
                    continue;
                }
                let normal = |place: usize| self.tree1.ready_triangle(place).map(|t| t.normal);
                let one = one.whole_triangle(normal);
                let normal = |place: usize| self.tree2.ready_triangle(place).map(|t| self.rotation12 * t.normal);
                let two = second.whole_triangle(normal);
                let found_sq = one.near_distance_sq(two, *best_sq, spans);
                if found_sq < *best_sq {
                    *best_sq = found_sq;
                    nearer(one, two);
                    if found_sq <= goal_sq {
                        return;
                    }
                }
            }
        }
    }
}

/// A triangle of a leaf, whose normal is asked for when another triangle comes near.
struct LeafTriangle {
    corners: [DVec3; 3],
    span: CornerSpan,
    place: usize,
    whole: Option<Triangle>,
}

impl LeafTriangle {
    #[inline]
    fn new(corners: [DVec3; 3], place: usize) -> Self {
        let [a, b, c] = corners;
        Self { corners, span: (a.min(b).min(c), a.max(b).max(c)), place, whole: None }
    }

    /// The triangle with its normal, which `known_normal` may give.
    #[inline]
    fn whole_triangle(&mut self, known_normal: impl FnOnce(usize) -> Option<DVec3>) -> &Triangle {
        let (corners, place) = (self.corners, self.place);
        self.whole.get_or_insert_with(|| match known_normal(place) {
            Some(normal) => Triangle { corners, normal },
            None => Triangle::new(corners),
        })
    }
}

/// The squared distance of the boxes around two triangles.
#[inline]
fn spans_distance_sq(one: CornerSpan, other: CornerSpan) -> f64 {
    (other.0 - one.1).max(one.0 - other.1).max(DVec3::ZERO).length_squared()
}

/// Whether to open the first of two nodes that are not both leaves: the one with the larger box, since that improves
/// the bound most.
#[inline]
pub(super) fn opens_first(tree1: &TriangleBoxTree, tree2: &TriangleBoxTree, node1: usize, node2: usize) -> bool {
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
