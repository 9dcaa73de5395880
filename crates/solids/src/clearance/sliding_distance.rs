//! The least distance of two parts while one of them slides along a line in both directions: exact, in one traversal of
//! the two box trees. A sliding triangle sweeps a prism, and the distance to a prism is the distance to its faces.

use glam::{DMat3, DVec3};

use crate::{
    ClearanceTree, Pose,
    mesh::triangle::Triangle,
    trees::{
        box_tree::TriangleBoxTree,
        node_box::{TreeNodeBox, TreeNodeLink},
        tree_pair_walk::{MEET_MM, opens_first},
    },
};

impl ClearanceTree {
    /// The least distance between the two surfaces over all positions of `other` from `-slide1` to `+slide1` relative
    /// to its pose, or `cap_mm` when they are further apart at all of them; 0 when they meet somewhere. `slide1` is in
    /// mm in this part's mesh frame; `pose12` is the frame of `other` seen from this one.
    pub fn distance_sliding_mm(&self, other: &Self, pose12: &Pose, slide1: DVec3, cap_mm: f64) -> f64 {
        let to_box1 = self.obb().pose.inverse();
        let boxes12 = to_box1.compose_with(&pose12.compose_with(&other.obb().pose));
        let rotation12 = boxes12.rotation_matrix();
        let spread12 = DMat3::from_cols(rotation12.x_axis.abs(), rotation12.y_axis.abs(), rotation12.z_axis.abs());
        let slide_in_box1 = to_box1.transform_direction(slide1);
        let walk = SlidingWalk {
            tree1: &self.tree,
            tree2: &other.tree,
            boxes: BoxTreeFrames {
                rotation12,
                spread12,
                translation12: boxes12.translation,
                reach1: slide_in_box1.abs(),
                reach2: (rotation12.transpose() * slide_in_box1).abs(),
            },
            rotation12: pose12.rotation_matrix(),
            translation12: pose12.translation,
            slide1,
        };
        let mut best_sq = cap_mm * cap_mm;
        if walk.boxes.lower_bound_sq(&self.tree.boxes[0], &other.tree.boxes[0]) < best_sq {
            walk.visit_pair(0, 0, &mut best_sq);
        }
        if best_sq <= MEET_MM * MEET_MM { 0.0 } else { best_sq.sqrt().min(cap_mm) }
    }
}

/// Frame 2 seen from frame 1, where both are the frames of the trees' boxes, and the slide of the second tree.
struct BoxTreeFrames {
    rotation12: DMat3,
    spread12: DMat3,
    translation12: DVec3,
    /// The slide along the axes of frame 1 and of frame 2.
    reach1: DVec3,
    reach2: DVec3,
}

impl BoxTreeFrames {
    /// A lower bound of the squared distance of a box and the volume that another box sweeps.
    fn lower_bound_sq(&self, box1: &TreeNodeBox, box2: &TreeNodeBox) -> f64 {
        let (center1, half1) = (box1.center.as_dvec3(), box1.half.as_dvec3());
        let (center2, half2) = (box2.center.as_dvec3(), box2.half.as_dvec3());
        let apart = self.rotation12 * center2 + self.translation12 - center1;
        let gaps1 = (apart.abs() - half1 - self.spread12 * half2 - self.reach1).max(DVec3::ZERO);
        let seen2 = self.rotation12.transpose() * apart;
        let gaps2 = (seen2.abs() - half2 - self.spread12.transpose() * half1 - self.reach2).max(DVec3::ZERO);
        gaps1.length_squared().max(gaps2.length_squared())
    }
}

/// Two trees, and the slide of the second one.
struct SlidingWalk<'a> {
    tree1: &'a TriangleBoxTree,
    tree2: &'a TriangleBoxTree,
    boxes: BoxTreeFrames,
    /// Mesh frame 2 seen from mesh frame 1.
    rotation12: DMat3,
    translation12: DVec3,
    /// In mesh frame 1.
    slide1: DVec3,
}

impl SlidingWalk<'_> {
    fn visit_pair(&self, node1: usize, node2: usize, best_sq: &mut f64) {
        let (link1, link2) = (self.tree1.links[node1], self.tree2.links[node2]);
        if link1.is_leaf() && link2.is_leaf() {
            return self.compare_leaves(link1, link2, best_sq);
        }
        let open1 = opens_first(self.tree1, self.tree2, node1, node2);
        let pair = |child: usize| match open1 {
            true => (link1.first_child() + child, node2),
            false => (node1, link2.first_child() + child),
        };
        let bounds = [0, 1].map(|child| {
            let (node1, node2) = pair(child);
            self.boxes.lower_bound_sq(&self.tree1.boxes[node1], &self.tree2.boxes[node2])
        });
        let order = if bounds[0] <= bounds[1] { [0, 1] } else { [1, 0] };
        for child in order {
            if bounds[child] < *best_sq && *best_sq > MEET_MM * MEET_MM {
                let (node1, node2) = pair(child);
                self.visit_pair(node1, node2, best_sq);
            }
        }
    }

    fn compare_leaves(&self, leaf1: TreeNodeLink, leaf2: TreeNodeLink, best_sq: &mut f64) {
        for place2 in leaf2.triangle_range() {
            let triangle2 = self.tree2.triangle(place2).transformed_by(&self.rotation12, self.translation12);
            let swept = SweptPrism::new(&triangle2, self.slide1);
            for place1 in leaf1.triangle_range() {
                *best_sq = swept.distance_sq_below(&self.tree1.triangle(place1), *best_sq);
                if *best_sq <= MEET_MM * MEET_MM {
                    return;
                }
            }
        }
    }
}

/// The prism that a triangle sweeps from `-slide` to `+slide`, as the triangles of its surface.
struct SweptPrism {
    triangle: Triangle,
    slide: DVec3,
    min: DVec3,
    max: DVec3,
    faces: [Triangle; 8],
}

impl SweptPrism {
    fn new(triangle: &Triangle, slide: DVec3) -> Self {
        let [a, b, c] = triangle.corners;
        let end = |shift: DVec3| Triangle { corners: triangle.corners.map(|p| p + shift), normal: triangle.normal };
        let near = |from: DVec3, to: DVec3| Triangle::new([from - slide, to - slide, to + slide]);
        let far = |from: DVec3, to: DVec3| Triangle::new([from - slide, to + slide, from + slide]);
        Self {
            triangle: *triangle,
            slide,
            min: a.min(b).min(c) - slide.abs(),
            max: a.max(b).max(c) + slide.abs(),
            faces: [end(-slide), end(slide), near(a, b), far(a, b), near(b, c), far(b, c), near(c, a), far(c, a)],
        }
    }

    /// The squared distance to a triangle, mm2, or `cap_sq` when it is not less.
    fn distance_sq_below(&self, other: &Triangle, cap_sq: f64) -> f64 {
        let [a, b, c] = other.corners;
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        if (self.min - max).max(min - self.max).max(DVec3::ZERO).length_squared() >= cap_sq {
            return cap_sq;
        }
        if self.contains_point(a) {
            return 0.0;
        }
        self.faces.iter().fold(cap_sq, |best_sq, face| face.distance_sq_below(other, best_sq))
    }

    /// Whether a point lies in the prism: a triangle inside it does not meet its faces.
    fn contains_point(&self, point: DVec3) -> bool {
        let rise = self.slide.dot(self.triangle.normal);
        if rise == 0.0 {
            return false;
        }
        let share = (point - self.triangle.corners[0]).dot(self.triangle.normal) / rise;
        share.abs() <= 1.0 && self.triangle.covers_point(point - self.slide * share)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DQuat, EulerRot};
    use proptest::prelude::*;

    use super::*;
    use crate::{
        Mesh,
        fixtures::{block, bucket, star},
    };

    fn tree(mesh: &Arc<Mesh>) -> ClearanceTree {
        ClearanceTree::new(mesh.clone())
    }

    fn any_solid() -> impl Strategy<Value = Arc<Mesh>> {
        prop_oneof![
            (0.0..6.0f64, 1u32..3).prop_map(|(s, level)| star(level, move |d| 3.0 + (4.0 * d.x + s).sin() + d.y)),
            (4.0..12.0f64, 0.3..1.5f64).prop_map(|(size, wall)| bucket(size, wall)),
            (1.0..12.0f64, 1.0..12.0f64, 0.5..6.0f64).prop_map(|(x, y, z)| block(x, y, z)),
        ]
    }

    fn any_pose() -> impl Strategy<Value = Pose> {
        let angle = prop_oneof![-3.2..3.2f64, (-2i32..=2).prop_map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2)];
        let far = -14.0..14.0f64;
        ((angle.clone(), angle.clone(), angle), (far.clone(), far.clone(), far))
            .prop_map(|((a, b, c), t)| Pose::new(DQuat::from_euler(EulerRot::XYZ, a, b, c), DVec3::new(t.0, t.1, t.2)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(150))]

        #[test]
        fn sliding_finds_what_small_steps_find(
            mesh1 in any_solid(), mesh2 in any_solid(), pose12 in any_pose(),
            slide in (-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64).prop_map(DVec3::from), cap in 0.5..4.0f64,
        ) {
            const STEPS: i32 = 60;
            let (one, two) = (tree(&mesh1), tree(&mesh2));
            let at = |k: i32| Pose { translation: pose12.translation + slide * (f64::from(k) / f64::from(STEPS)), ..pose12 };
            let stepped = (-STEPS..=STEPS).map(|k| one.distance_capped_mm(&two, &at(k), cap)).fold(cap, f64::min);
            let found = one.distance_sliding_mm(&two, &pose12, slide, cap);
            prop_assert!(found <= stepped + 1e-9, "{found} while sliding, {stepped} at a step");
            prop_assert!(found >= stepped - slide.length() / f64::from(STEPS) - 1e-9, "{found} while sliding, {stepped} in steps");
            let back = two.distance_sliding_mm(&one, &pose12.inverse(), pose12.inverse().transform_direction(slide), cap);
            prop_assert!((back - found).abs() < 1e-9, "{back} from the other side, {found}");
            let still = one.distance_sliding_mm(&two, &pose12, DVec3::ZERO, cap);
            prop_assert!((still - one.distance_capped_mm(&two, &pose12, cap)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_slide_takes_away_what_it_comes_nearer_and_no_more() {
        let brick = tree(&block(10.0, 10.0, 10.0));
        let shift = |x: f64, y: f64, z: f64| Pose::new(DQuat::IDENTITY, DVec3::new(x, y, z));
        let far = |pose12: &Pose, z: f64| brick.distance_sliding_mm(&brick, pose12, DVec3::Z * z, 9.0);
        assert!((far(&shift(2.0, 0.0, 15.0), 2.0) - 3.0).abs() < 1e-12, "above");
        assert!((far(&shift(13.0, 0.0, 1.0), 2.0) - 3.0).abs() < 1e-12, "beside");
        assert!((far(&shift(13.0, 0.0, 16.0), 2.0) - 5.0).abs() < 1e-12, "over the corner");
        assert_eq!(far(&shift(2.0, 0.0, 11.0), 2.0), 0.0, "through each other");
    }

    #[test]
    fn a_small_part_is_not_slid_over_unseen() {
        let (plate, grain) = (tree(&block(40.0, 40.0, 1.0)), tree(&block(0.2, 0.2, 0.2)));
        let above = Pose::new(DQuat::IDENTITY, DVec3::new(20.0, 20.0, 5.0));
        assert_eq!(plate.distance_sliding_mm(&grain, &above, DVec3::Z * 10.0, 1.0), 0.0);
        assert_eq!(grain.distance_sliding_mm(&plate, &above.inverse(), DVec3::Z * 10.0, 1.0), 0.0);
    }
}
