//! Builds a mesh from triangles that come one after the other, as a reader finds them: their corners are never in memory
//! more than once.

use glam::DVec3;

use super::weld::SoupWelder;
use crate::{Mesh, MeshError};

/// A mesh under construction. It becomes what [`Mesh::new`] makes of the same triangles.
///
/// ```
/// use glam::DVec3;
/// use solids::MeshBuilder;
///
/// let mut builder = MeshBuilder::default();
/// let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
///     builder.add_triangle(face.map(|corner: usize| corners[corner]));
/// }
/// assert_eq!(builder.into_mesh()?.vertices().len(), 4);
/// # Ok::<(), solids::MeshError>(())
/// ```
#[derive(Debug, Default)]
pub struct MeshBuilder {
    soup: SoupWelder,
    given: usize,
    /// The first corner that is not finite, counted over all triangles.
    not_finite: Option<usize>,
}

impl MeshBuilder {
    /// A builder with room for so many triangles.
    pub fn with_capacity(triangles: usize) -> Self {
        let mut builder = Self::default();
        builder.soup.reserve(triangles);
        builder
    }

    /// Adds a triangle, counter-clockwise seen from outside, mm.
    pub fn add_triangle(&mut self, corners: [DVec3; 3]) {
        match corners.iter().position(|corner| !corner.is_finite()) {
            Some(at) => self.not_finite = self.not_finite.or(Some(3 * self.given + at)),
            None => self.soup.add_triangle(corners),
        }
        self.given += 1;
    }

    /// Number of triangles that were added.
    pub fn triangle_count(&self) -> usize {
        self.given
    }

    /// Checks and mends the surface as [`Mesh::new`] does.
    pub fn into_mesh(self) -> Result<Mesh, MeshError> {
        if let Some(vertex) = self.not_finite {
            return Err(MeshError::NotFinite { vertex });
        }
        let (vertices, triangles) = self.soup.into_welded();
        Mesh::from_welded(vertices, triangles, self.given)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::star;

    #[test]
    fn it_makes_the_mesh_of_the_same_soup() {
        let star = star(3, |d| 5.0 + d.x);
        let mut soup: Vec<DVec3> = (0..star.triangles().len()).flat_map(|t| star.corners(t)).collect();
        soup.extend([DVec3::X, DVec3::X, DVec3::Y]);
        let triangles = (0..soup.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mut builder = MeshBuilder::with_capacity(soup.len() / 3);
        soup.chunks(3).for_each(|t| builder.add_triangle([t[0], t[1], t[2]]));
        assert_eq!(builder.triangle_count(), soup.len() / 3);
        let (made, wanted) =
            (builder.into_mesh().expect("is a solid"), Mesh::new(soup, triangles).expect("is a solid"));
        assert_eq!((made.vertices(), made.triangles()), (wanted.vertices(), wanted.triangles()));
        assert_eq!(made.defects(), wanted.defects());
    }

    #[test]
    fn a_corner_that_is_no_place_is_named() {
        let mut builder = MeshBuilder::default();
        builder.add_triangle([DVec3::ZERO, DVec3::X, DVec3::Y]);
        builder.add_triangle([DVec3::ZERO, DVec3::X, DVec3::NAN]);
        assert_eq!(builder.into_mesh().map(|_| ()), Err(MeshError::NotFinite { vertex: 5 }));
    }
}
