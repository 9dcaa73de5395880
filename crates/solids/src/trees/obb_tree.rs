//! The OBB tree of the paper (section 2.2): the collision test of the paper's method. Every box has its own axes, from
//! the principal axes of its triangles.

use glam::{DMat3, DVec3};

use super::{obb::vertex_axes, separating_axis::boxes_overlap};
use crate::{Mesh, Obb, Pose};

/// Below this depth, nodes are halved by count: halving the axis does not separate coincident or very uneven triangles.
const MAX_UNEVEN_DEPTH: usize = 48;

/// A box and its two children, which are stored next to each other; 0 (the root is no node's child) for a leaf.
#[derive(Debug, Clone, Copy)]
struct ObbTreeNode {
    rotation: DMat3,
    center: DVec3,
    half: DVec3,
    children: u32,
}

impl ObbTreeNode {
    fn is_leaf(&self) -> bool {
        self.children == 0
    }
}

/// A binary tree of oriented boxes around the triangles of a mesh.
#[derive(Debug, Clone)]
pub struct ObbTree {
    root: Obb,
    nodes: Vec<ObbTreeNode>,
}

impl ObbTree {
    /// Builds the tree (sections 2.2.1 and 2.2.2). A node is divided in the middle of its primary axis, by the centers
    /// of its triangles, until it contains one triangle or until its least height is at most `stop_height_mm` (section
    /// 2.2.4: the clearance; 0 builds the whole tree).
    pub fn new(mesh: &Mesh, stop_height_mm: f64) -> Self {
        let mut triangles: Vec<[DVec3; 3]> = (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect();
        let root = box_around(&triangles);
        let mut tree = Self { root, nodes: vec![leaf_node(&root)] };
        tree.divide_node(0, &root, &mut triangles, stop_height_mm, 0);
        tree
    }

    /// The box around the whole part, in the mesh's frame; its axes run from the primary to the third.
    pub fn root(&self) -> &Obb {
        &self.root
    }

    /// Number of boxes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Never true: a mesh has triangles.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Whether leaf boxes of the two trees overlap when each box is expanded by half of `clearance_mm` on every side
    /// (section 2.2.5). `pose12` is the frame of `other` seen from this one. If they do not overlap, the surfaces keep
    /// the clearance; if they do, the surfaces may still keep it. A part wholly inside another one is not detected.
    pub fn collides_with(&self, other: &Self, pose12: &Pose, clearance_mm: f64) -> bool {
        let pair = ObbTreePair {
            nodes1: &self.nodes,
            nodes2: &other.nodes,
            rotation12: pose12.rotation_matrix(),
            translation12: pose12.translation,
            expansion: DVec3::splat(0.5 * clearance_mm),
        };
        pair.nodes_collide(&self.nodes[0], &other.nodes[0])
    }

    fn divide_node(&mut self, at: usize, obb: &Obb, triangles: &mut [[DVec3; 3]], stop_height_mm: f64, depth: usize) {
        if triangles.len() == 1 || 2.0 * obb.half_mm.min_element() <= stop_height_mm && stop_height_mm > 0.0 {
            return;
        }
        let middle = split_triangles(obb, triangles, depth);
        let (left, right) = triangles.split_at_mut(middle);
        let boxes = [box_around(left), box_around(right)];
        let children = self.nodes.len();
        self.nodes[at].children = children as u32;
        self.nodes.extend([leaf_node(&boxes[0]), leaf_node(&boxes[1])]);
        self.divide_node(children, &boxes[0], left, stop_height_mm, depth + 1);
        self.divide_node(children + 1, &boxes[1], right, stop_height_mm, depth + 1);
    }
}

/// The box along the principal axes of the triangles' corners.
fn box_around(triangles: &[[DVec3; 3]]) -> Obb {
    let corners = triangles.iter().flatten().copied();
    Obb::along_axes(vertex_axes(corners.clone()), corners)
}

fn leaf_node(obb: &Obb) -> ObbTreeNode {
    ObbTreeNode { rotation: obb.pose.rotation_matrix(), center: obb.pose.translation, half: obb.half_mm, children: 0 }
}

/// Orders triangles by the side of the primary axis' middle on which their centers lie. Returns the size of the first
/// group.
fn split_triangles(obb: &Obb, triangles: &mut [[DVec3; 3]], depth: usize) -> usize {
    let axis = obb.pose.rotation_matrix().x_axis;
    let place = |t: &[DVec3; 3]| (t[0] + t[1] + t[2]).dot(axis) / 3.0;
    let mean = triangles.iter().map(place).sum::<f64>() / triangles.len() as f64;
    // If the middle of the axis leaves one half empty, divide at the mean of the centers.
    for border in [obb.pose.translation.dot(axis), mean] {
        let mut middle = 0;
        for i in 0..triangles.len() {
            if place(&triangles[i]) < border {
                triangles.swap(i, middle);
                middle += 1;
            }
        }
        if middle > 0 && middle < triangles.len() && depth < MAX_UNEVEN_DEPTH {
            return middle;
        }
    }
    let middle = triangles.len() / 2;
    triangles.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)));
    middle
}

/// Two trees, and frame 2 seen from frame 1.
struct ObbTreePair<'a> {
    nodes1: &'a [ObbTreeNode],
    nodes2: &'a [ObbTreeNode],
    rotation12: DMat3,
    translation12: DVec3,
    expansion: DVec3,
}

impl ObbTreePair<'_> {
    fn nodes_collide(&self, node1: &ObbTreeNode, node2: &ObbTreeNode) -> bool {
        let back = node1.rotation.transpose();
        let rotation12 = back * (self.rotation12 * node2.rotation);
        let center12 = back * (self.rotation12 * node2.center + self.translation12 - node1.center);
        if !boxes_overlap(node1.half + self.expansion, node2.half + self.expansion, &rotation12, center12) {
            return false;
        }
        let children = |node: &ObbTreeNode| [node.children as usize, node.children as usize + 1];
        match (node1.is_leaf(), node2.is_leaf()) {
            (true, true) => true,
            (false, true) => children(node1).into_iter().any(|c| self.nodes_collide(&self.nodes1[c], node2)),
            (true, false) => children(node2).into_iter().any(|c| self.nodes_collide(node1, &self.nodes2[c])),
            (false, false) if node1.half.length_squared() >= node2.half.length_squared() => {
                children(node1).into_iter().any(|c| self.nodes_collide(&self.nodes1[c], node2))
            }
            (false, false) => children(node2).into_iter().any(|c| self.nodes_collide(node1, &self.nodes2[c])),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, EulerRot};
    use proptest::prelude::*;

    use super::*;
    use crate::{
        ClearanceTree,
        fixtures::{block, star},
    };

    fn bumpy(seed: f64, size: DVec3) -> std::sync::Arc<Mesh> {
        star(2, move |d| (size * d).length() * (1.0 + 0.3 * (5.0 * d.x + seed).sin()))
    }

    /// Checks that the boxes hold their triangles: every triangle lies wholly in one leaf.
    fn leaves_hold_all(tree: &ObbTree, mesh: &Mesh) -> bool {
        let holds =
            |n: &ObbTreeNode, p: DVec3| (n.rotation.transpose() * (p - n.center)).abs().cmple(n.half + 1e-9).all();
        (0..mesh.triangles().len()).all(|t| {
            let corners = mesh.corners(t);
            tree.nodes.iter().any(|n| n.is_leaf() && corners.iter().all(|&c| holds(n, c)))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn leaves_cover_every_triangle(seed in 0.0..6.0f64, x in 1.0..9.0f64, stop in 0.0..6.0f64) {
            let mesh = bumpy(seed, DVec3::new(x, 4.0, 2.0));
            let tree = ObbTree::new(&mesh, stop);
            prop_assert!(leaves_hold_all(&tree, &mesh));
            prop_assert!(mesh.vertices().iter().all(|&v| tree.root().contains_point(v, 1e-9)));
        }

        #[test]
        fn no_collision_means_that_the_clearance_is_kept(
            seed in 0.0..6.0f64, stop in prop_oneof![Just(0.0), 0.5..4.0f64], clearance in 0.0..4.0f64,
            turn in proptest::array::uniform3(-3.2..3.2f64), t in proptest::array::uniform3(-12.0..12.0f64),
        ) {
            let (one, two) = (bumpy(seed, DVec3::new(7.0, 3.0, 2.0)), bumpy(-seed, DVec3::new(2.0, 5.0, 4.0)));
            let rotation = DQuat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]);
            let pose12 = Pose::new(rotation, DVec3::from_array(t));
            let collides = ObbTree::new(&one, stop).collides_with(&ObbTree::new(&two, stop), &pose12, clearance);
            let distance = ClearanceTree::new(one).distance_capped_mm(&ClearanceTree::new(two), &pose12, 100.0);
            prop_assert!(collides || distance >= clearance - 1e-9, "distance {distance}");
            // Expanded boxes reach no further than half a diagonal of the expansion, and a whole tree's leaves lie on
            // their triangles.
            if stop == 0.0 && distance > clearance * 3f64.sqrt() + 4.0 {
                prop_assert!(!collides);
            }
        }
    }

    #[test]
    fn a_whole_tree_ends_at_single_triangles_and_a_reduced_one_earlier() {
        let mesh = bumpy(1.0, DVec3::new(30.0, 20.0, 10.0));
        let whole = ObbTree::new(&mesh, 0.0);
        assert_eq!(whole.len(), 2 * mesh.triangles().len() - 1);
        let reduced = ObbTree::new(&mesh, 3.0);
        assert!(reduced.len() < whole.len() && !reduced.is_empty());
        assert_eq!(ObbTree::new(&mesh, 100.0).len(), 1, "the root is flat enough");
    }

    #[test]
    fn coincident_triangles_end_too() {
        let brick = block(4.0, 3.0, 2.0);
        let again = [brick.triangles(), brick.triangles()].concat();
        let doubled = Mesh::new(brick.vertices().to_vec(), again).expect("encloses a volume twice");
        let tree = ObbTree::new(&doubled, 0.0);
        assert_eq!(tree.len(), 2 * doubled.triangles().len() - 1);
        assert!(leaves_hold_all(&tree, &doubled));
    }
}
