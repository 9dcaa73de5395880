//! The 24 rotations that map axes onto axes.

use glam::{DMat3, DQuat, DVec3};

/// All rotations that take every axis to an axis; the first moves nothing, and the order is fixed for ever.
pub(crate) fn axis_rotations() -> Vec<DQuat> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let pairs = axes.iter().flat_map(|&x| axes.iter().map(move |&y| (x, y)));
    let right_angled = pairs.filter(|(x, y)| x.dot(*y) == 0.0);
    right_angled.map(|(x, y)| DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_24_and_the_first_moves_nothing() {
        let all = axis_rotations();
        assert_eq!(all.len(), 24);
        assert!(all[0].dot(DQuat::IDENTITY).abs() > 1.0 - 1e-12);
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a.dot(*b).abs() < 0.99), "no two are the same");
        }
    }
}
