//! Eigenvectors of a symmetric 3x3 matrix by Jacobi's method: the singular value decomposition of a covariance matrix.

use glam::{DMat3, DVec3};

/// Eigenvalues from great to small, and the unit eigenvectors as columns of a rotation (right-handed). For a symmetric
/// positive matrix this is its singular value decomposition.
pub(crate) fn symmetric_eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let mut a = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|c| c.to_array());
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Jacobi's method converges quadratically: about eight sweeps reach rounding precision from any start.
    for _ in 0..16 {
        let off = a[0][1].powi(2) + a[0][2].powi(2) + a[1][2].powi(2);
        let diagonal = a[0][0].powi(2) + a[1][1].powi(2) + a[2][2].powi(2);
        if off <= 1e-32 * diagonal {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            jacobi_rotate(&mut a, &mut v, p, q);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    let column = |i: usize| DVec3::new(v[0][i], v[1][i], v[2][i]);
    let (x, y) = (column(order[0]).normalize(), column(order[1]).normalize());
    let values = DVec3::new(a[order[0]][order[0]], a[order[1]][order[1]], a[order[2]][order[2]]);
    (values, DMat3::from_cols(x, y, x.cross(y)))
}

/// One Jacobi rotation, which sets `a[p][q]` to zero.
fn jacobi_rotate(a: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    for row in a.iter_mut() {
        (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
    }
    let (row_p, row_q) = (a[p], a[q]);
    a[p] = std::array::from_fn(|k| cosine * row_p[k] - sine * row_q[k]);
    a[q] = std::array::from_fn(|k| sine * row_p[k] + cosine * row_q[k]);
    for row in v.iter_mut() {
        (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_axes_rebuild_the_matrix(
            x in 0.0..9.0f64, y in 0.0..9.0f64, z in 0.0..9.0f64, a in -3.0..3.0f64, b in -3.0..3.0f64, c in -3.0..3.0f64
        ) {
            let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, a, b, c));
            let matrix = turn * DMat3::from_diagonal(DVec3::new(x, y, z)) * turn.transpose();
            let (values, axes) = symmetric_eigen(matrix);
            let rebuilt = axes * DMat3::from_diagonal(values) * axes.transpose();
            prop_assert!(rebuilt.abs_diff_eq(matrix, 1e-9));
            prop_assert!((axes * axes.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12) && axes.determinant() > 0.0);
            prop_assert!(values.x >= values.y - 1e-12 && values.y >= values.z - 1e-12);
        }
    }

    #[test]
    fn equal_values_are_no_trouble() {
        let (values, axes) = symmetric_eigen(DMat3::ZERO);
        assert_eq!(values, DVec3::ZERO);
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }
}
