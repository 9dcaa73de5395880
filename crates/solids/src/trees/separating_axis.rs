//! The separating axis test for two oriented boxes (section 2.2.3).

use glam::{DMat3, DVec3};

/// Whether two boxes overlap or touch: none of the 15 axes (3 faces of each box, 9 products of their edges) separates them
/// by equation (9). `rotation12` and `center12` are the second box's axes and middle seen from the first box's own frame;
/// half edges in mm.
pub(crate) fn boxes_overlap(half1: DVec3, half2: DVec3, rotation12: &DMat3, center12: DVec3) -> bool {
    /// Added to the absolute cosines: the product of two nearly parallel edges is only noise and must not separate.
    const PARALLEL: f64 = 1e-9;
    let r = [rotation12.x_axis.to_array(), rotation12.y_axis.to_array(), rotation12.z_axis.to_array()];
    // `cos(i, j)`: axis i of the first box against axis j of the second.
    let cos = |i: usize, j: usize| r[j][i];
    let abs = |i: usize, j: usize| r[j][i].abs() + PARALLEL;
    let (h1, h2, t) = (half1.to_array(), half2.to_array(), center12.to_array());
    for i in 0..3 {
        if t[i].abs() > h1[i] + h2[0] * abs(i, 0) + h2[1] * abs(i, 1) + h2[2] * abs(i, 2) {
            return false;
        }
    }
    for (j, &own) in h2.iter().enumerate() {
        let along = t[0] * cos(0, j) + t[1] * cos(1, j) + t[2] * cos(2, j);
        if along.abs() > own + h1[0] * abs(0, j) + h1[1] * abs(1, j) + h1[2] * abs(2, j) {
            return false;
        }
    }
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            let along = t[i2] * cos(i1, j) - t[i1] * cos(i2, j);
            let reach1 = h1[i1] * abs(i2, j) + h1[i2] * abs(i1, j);
            let reach2 = h2[j1] * abs(i, j2) + h2[j2] * abs(i, j1);
            if along.abs() > reach1 + reach2 {
                return false;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, EulerRot};
    use proptest::prelude::*;

    use super::*;
    use crate::{ClearanceTree, Pose, fixtures::cuboid};

    fn centered(half: DVec3) -> ClearanceTree {
        ClearanceTree::new(cuboid(-half, half))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]

        #[test]
        fn it_says_what_the_triangles_say(
            h in proptest::array::uniform6(0.2..5.0f64),
            turn in prop_oneof![
                proptest::array::uniform3(-3.2..3.2f64),
                proptest::array::uniform3((-2i32..=2).prop_map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2)),
                proptest::array::uniform3(-1e-9..1e-9f64),
            ],
            t in proptest::array::uniform3(-8.0..8.0f64),
        ) {
            let (half1, half2) = (DVec3::new(h[0], h[1], h[2]), DVec3::new(h[3], h[4], h[5]));
            let rotation = DQuat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]);
            let pose12 = Pose::new(rotation, DVec3::from_array(t));
            let (one, two) = (centered(half1), centered(half2));
            let distance = one.distance_capped_mm(&two, &pose12, 100.0);
            let nested = one.contains_part(&two, &pose12) || two.contains_part(&one, &pose12.inverse());
            let overlap = boxes_overlap(half1, half2, &pose12.rotation_matrix(), pose12.translation);
            if distance > 1e-6 && !nested {
                prop_assert!(!overlap, "apart by {distance}");
            } else {
                prop_assert!(overlap);
            }
        }
    }

    #[test]
    fn only_a_product_of_edges_separates_crossed_edges() {
        let eighth = std::f64::consts::FRAC_PI_4;
        let rotation = DQuat::from_rotation_y(eighth) * DQuat::from_rotation_x(eighth);
        let crossed = DMat3::from_quat(DQuat::from_rotation_y(eighth) * DQuat::from_rotation_x(0.3) * rotation);
        let half = DVec3::new(1.0, 1.0, 1.0);
        let direction = DVec3::new(1.0, 0.0, 1.0).normalize();
        let far = (0..400).map(|i| f64::from(i) * 0.01).find(|&d| !boxes_overlap(half, half, &crossed, direction * d));
        let distance = |d: f64| {
            let pose12 = Pose::new(DQuat::from_mat3(&crossed), direction * d);
            centered(half).distance_capped_mm(&centered(half), &pose12, 9.0)
        };
        let far = far.expect("boxes 4 mm apart do not overlap");
        assert!(distance(far) > 0.0 && distance(far - 0.0101) == 0.0, "{far}");
    }
}
