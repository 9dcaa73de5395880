//! Oriented bounding boxes (OBB), and the frames in which they are searched.

use glam::{DMat3, DQuat, DVec3};

use crate::{Bounds, ExtremePoints, Mesh, Pose, mesh::eigen::symmetric_eigen};

/// A box in any orientation: `pose` transforms the box's own frame (center at its origin, faces along its axes) to the
/// surrounding frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obb {
    /// Box frame -> surrounding frame.
    pub pose: Pose,
    /// Half the edge lengths along the box's own axes, mm.
    pub half_mm: DVec3,
}

impl Obb {
    /// The least box around `points` (mm, at least one) whose faces are aligned with the columns of the rotation `axes`
    /// (step 4 of section 2.2.1).
    pub fn along_axes(axes: DMat3, points: impl IntoIterator<Item = DVec3>) -> Self {
        // The quaternion is stored, so the limits are computed with it and not with the original matrix.
        let rotation = DQuat::from_mat3(&axes).normalize();
        let to_box = DMat3::from_quat(rotation).transpose();
        let limits = Bounds::from_points(points.into_iter().map(|p| to_box * p));
        Self { pose: Pose { rotation, translation: rotation * limits.center() }, half_mm: limits.size() * 0.5 }
    }

    /// The smallest box found around a mesh, from several frames: vertex PCA (which uneven tessellation distorts), PCA
    /// weighted by area, the mesh's own frame, and a local search from each of them. Its axes run from long to short.
    pub fn smallest_around(mesh: &Mesh) -> Self {
        let frames = [vertex_axes(mesh.vertices().iter().copied()), area_axes(mesh), DMat3::IDENTITY];
        let proxy = outermost_vertices(mesh.vertices());
        let fits = |axes: DMat3| Self::along_axes(axes, proxy.iter().copied());
        let mut best = fits(frames[0]);
        for axes in frames {
            let found = refine_box(fits(axes), &proxy);
            // A box must be clearly smaller to replace one from an earlier frame, so that ties are stable.
            if found.volume_mm3() < best.volume_mm3() * (1.0 - 1e-9) {
                best = found;
            }
        }
        Self::along_axes(axes_long_to_short(&best), mesh.vertices().iter().copied())
    }

    /// Volume, mm3.
    pub fn volume_mm3(&self) -> f64 {
        8.0 * self.half_mm.element_product()
    }

    /// Whether a point (surrounding frame) lies inside, with `slack` mm of tolerance.
    pub fn contains_point(&self, point: DVec3, slack: f64) -> bool {
        self.pose.inverse().transform_point(point).abs().cmple(self.half_mm + slack).all()
    }
}

/// The principal axes of points, the primary one first (equations (6) to (8)).
pub(crate) fn vertex_axes(points: impl Iterator<Item = DVec3> + Clone) -> DMat3 {
    let (sum, count) = points.clone().fold((DVec3::ZERO, 0.0), |(sum, n), p| (sum + p, n + 1.0));
    let mean = sum / count;
    let mut covariance = DMat3::ZERO;
    for point in points {
        covariance += outer_product(point - mean);
    }
    symmetric_eigen(covariance * (1.0 / count)).1
}

/// The principal axes of the surface itself, with every piece weighted by its area.
fn area_axes(mesh: &Mesh) -> DMat3 {
    let origin = mesh.bounds().center();
    let pieces = || {
        (0..mesh.triangles().len()).map(|t| {
            let [a, b, c] = mesh.corners(t).map(|p| p - origin);
            ((b - a).cross(c - a).length() * 0.5, a, b, c)
        })
    };
    let total: f64 = pieces().map(|(area, ..)| area).sum();
    let mean = pieces().fold(DVec3::ZERO, |sum, (area, a, b, c)| sum + (a + b + c) * (area / 3.0)) / total;
    let mut covariance = DMat3::ZERO;
    for (area, a, b, c) in pieces() {
        let [a, b, c] = [a - mean, b - mean, c - mean];
        // The second moment of a triangle: area / 12 x (the corners' and the corner sum's outer products).
        covariance +=
            (outer_product(a) + outer_product(b) + outer_product(c) + outer_product(a + b + c)) * (area / 12.0);
    }
    symmetric_eigen(covariance).1
}

fn outer_product(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// The outermost vertices in many directions: enough of the hull to compare frames.
fn outermost_vertices(vertices: &[DVec3]) -> Vec<DVec3> {
    const DIRECTIONS: usize = 200;
    if vertices.len() <= DIRECTIONS {
        return vertices.to_vec();
    }
    // A Fibonacci lattice spreads directions uniformly over the sphere.
    let directions = (0..DIRECTIONS).map(|i| {
        let z = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
        let angle = i as f64 * std::f64::consts::PI * (5f64.sqrt() - 1.0);
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    });
    let places = ExtremePoints::new(vertices).farthest_points(directions);
    places.into_iter().map(|i| vertices[i]).collect()
}

/// Rotates the box slightly about each of its axes while that makes it smaller, with decreasing angles.
fn refine_box(start: Obb, points: &[DVec3]) -> Obb {
    let mut best = start;
    let mut step = 0.2;
    while step > 1e-4 {
        let turns = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [(axis, step), (axis, -step)]);
        let tried = turns.map(|(axis, angle)| {
            let rotation = best.pose.rotation * DQuat::from_axis_angle(axis, angle);
            Obb::along_axes(DMat3::from_quat(rotation), points.iter().copied())
        });
        let found = tried.min_by(|a, b| a.volume_mm3().total_cmp(&b.volume_mm3())).expect("six turns are tried");
        if found.volume_mm3() < best.volume_mm3() * (1.0 - 1e-6) {
            best = found;
        } else {
            step *= 0.5;
        }
    }
    best
}

/// The box's axes ordered by its edges, as a rotation.
fn axes_long_to_short(obb: &Obb) -> DMat3 {
    let axes = obb.pose.rotation_matrix();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| obb.half_mm[j].total_cmp(&obb.half_mm[i]));
    let (x, y) = (axes.col(order[0]), axes.col(order[1]));
    DMat3::from_cols(x, y, x.cross(y))
}
