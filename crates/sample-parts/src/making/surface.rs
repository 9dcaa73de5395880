//! A surface under construction, triangle by triangle; corners at exactly equal places become one vertex.

use glam::DVec3;
use solids::Mesh;

/// Triangles that will form a solid.
#[derive(Debug, Default)]
pub(crate) struct SurfaceBuilder {
    corners: Vec<DVec3>,
}

impl SurfaceBuilder {
    /// Adds a triangle, counter-clockwise seen from outside; a triangle with two equal corners is ignored.
    pub(super) fn add_triangle(&mut self, a: DVec3, b: DVec3, c: DVec3) {
        if a != b && b != c && c != a {
            self.corners.extend([a, b, c]);
        }
    }

    /// Adds a quadrilateral, counter-clockwise seen from outside.
    pub(crate) fn add_quad(&mut self, a: DVec3, b: DVec3, c: DVec3, d: DVec3) {
        self.add_triangle(a, b, c);
        self.add_triangle(a, c, d);
    }

    /// Joins two columns of corners, each from low to high, to a wall; `left` is on the left seen from outside.
    pub(crate) fn add_strip(&mut self, left: &[DVec3], right: &[DVec3]) {
        let (mut l, mut r) = (0, 0);
        while l + 1 < left.len() || r + 1 < right.len() {
            let climb_left = match (left.get(l + 1), right.get(r + 1)) {
                (Some(next_left), Some(next_right)) => next_left.z < next_right.z,
                (next_left, _) => next_left.is_some(),
            };
            if climb_left {
                self.add_triangle(left[l], right[r], left[l + 1]);
                l += 1;
            } else {
                self.add_triangle(left[l], right[r], right[r + 1]);
                r += 1;
            }
        }
    }

    /// Adds all triangles of `other`.
    pub(crate) fn append_surface(&mut self, other: Self) {
        self.corners.extend(other.corners);
    }

    /// The solid.
    pub(crate) fn into_mesh(self) -> Mesh {
        let triangles = (0..self.corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Mesh::new(self.corners, triangles).expect("a sample part encloses a volume")
    }
}
