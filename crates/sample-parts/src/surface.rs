//! A surface being sewn together, triangle by triangle; corners at exactly equal places are one vertex.

use glam::DVec3;
use solids::Mesh;

/// Triangles that are becoming a solid.
#[derive(Debug, Default)]
pub(super) struct Surface {
    corners: Vec<DVec3>,
}

impl Surface {
    /// Adds a triangle, counter-clockwise seen from outside; one that collapses to a line of two corners adds nothing.
    pub(super) fn triangle(&mut self, a: DVec3, b: DVec3, c: DVec3) {
        if a != b && b != c && c != a {
            self.corners.extend([a, b, c]);
        }
    }

    /// Adds a quadrilateral, counter-clockwise seen from outside.
    pub(super) fn quad(&mut self, a: DVec3, b: DVec3, c: DVec3, d: DVec3) {
        self.triangle(a, b, c);
        self.triangle(a, c, d);
    }

    /// Sews two columns of corners, each from low to high, into a wall; `left` stands to the left seen from outside.
    pub(super) fn zip(&mut self, left: &[DVec3], right: &[DVec3]) {
        let (mut l, mut r) = (0, 0);
        while l + 1 < left.len() || r + 1 < right.len() {
            let climb_left = match (left.get(l + 1), right.get(r + 1)) {
                (Some(next_left), Some(next_right)) => next_left.z < next_right.z,
                (next_left, _) => next_left.is_some(),
            };
            if climb_left {
                self.triangle(left[l], right[r], left[l + 1]);
                l += 1;
            } else {
                self.triangle(left[l], right[r], right[r + 1]);
                r += 1;
            }
        }
    }

    /// Adds all triangles of `other`.
    pub(super) fn append(&mut self, other: Self) {
        self.corners.extend(other.corners);
    }

    /// The solid.
    pub(super) fn mesh(self) -> Mesh {
        let triangles = (0..self.corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Mesh::new(self.corners, triangles).expect("a sample part encloses a volume")
    }
}
