//! A closed triangle surface in mm, checked once when it is created.

use glam::DVec3;
use thiserror::Error;

use super::{
    equal_pieces::keep_one_of_equal_pieces,
    local_order::put_in_local_order,
    weld::{edge_defects, noise_of, weld_equal_vertices, weld_open_edges},
};
use crate::{Bounds, MeshDefects, Pose};

/// Why a triangle soup is not a solid.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangle with an area is left.
    #[error("the mesh has no triangles")]
    Empty,
    /// A vertex coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// Index of the vertex as given.
        vertex: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices}")]
    BadIndex {
        /// Index of the triangle as given.
        triangle: usize,
        /// The index of the missing vertex.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The surface encloses nothing (flat, or its parts cancel out).
    #[error("the mesh encloses no volume")]
    NoVolume,
}

/// A triangle surface with welded vertices, outward orientation, finite coordinates and a volume. Millimetres.
#[derive(Debug, Clone)]
pub struct Mesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    bounds: Bounds,
    volume_mm3: f64,
    defects: MeshDefects,
}

impl Mesh {
    /// Checks the input; welds vertices at equal places (along edges that stay open, also at places that differ by the
    /// rounding of 32-bit coordinates); drops triangles that use a vertex twice; reverses an inside-out surface. The
    /// triangles keep their order, unless there are very many in a scattered order. Holes and the like are not errors;
    /// [`Mesh::defects`] reports them.
    pub fn new(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if let Some(vertex) = vertices.iter().position(|v| !v.is_finite()) {
            return Err(MeshError::NotFinite { vertex });
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices.len()) {
                return Err(MeshError::BadIndex { triangle, vertex, vertices: vertices.len() });
            }
        }
        let given = triangles.len();
        let (vertices, triangles) = weld_equal_vertices(&vertices, triangles);
        Self::from_welded(vertices, triangles, given)
    }

    /// Finishes a surface without equal vertices and collapsed triangles; `given` is the number of triangles before.
    pub(super) fn from_welded(
        mut vertices: Vec<DVec3>,
        mut triangles: Vec<[u32; 3]>,
        given: usize,
    ) -> Result<Self, MeshError> {
        put_in_local_order(&mut vertices, &mut triangles);
        let mut defects = edge_defects(&triangles, vertices.len(), |_, _| {});
        if !defects.is_closed() {
            let apart = vertices.len();
            let noise_mm = noise_of(&vertices);
            (vertices, triangles) = weld_open_edges(&vertices, triangles, noise_mm);
            defects = edge_defects(&triangles, vertices.len(), |_, _| {});
            defects.welded_vertices = apart - vertices.len();
        }
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        defects.degenerate_triangles = given - triangles.len();
        let with_equal = triangles.len();
        triangles = keep_one_of_equal_pieces(triangles, vertices.len());
        defects.equal_triangles = with_equal - triangles.len();
        let bounds = Bounds::from_points(vertices.iter().copied());
        let mut volume_mm3 = signed_volume(&vertices, &triangles, bounds.center());
        let size = bounds.size();
        if volume_mm3.abs() <= 1e-9 * size.max_element().powi(3) || size.min_element() <= 0.0 {
            return Err(MeshError::NoVolume);
        }
        if volume_mm3 < 0.0 {
            volume_mm3 = -volume_mm3;
            defects.inverted = true;
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        vertices.shrink_to_fit();
        triangles.shrink_to_fit();
        Ok(Self { vertices, triangles, bounds, volume_mm3, defects })
    }

    /// As [`Mesh::new`] for a surface that came from [`Mesh::vertices`] and [`Mesh::triangles`]: it keeps their order, so that
    /// all that is worked out from it comes out the same. What does need mending is mended.
    pub(crate) fn restored(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let checked = Self::new(vertices.clone(), triangles.clone())?;
        let same = checked.vertices.len() == vertices.len() && checked.triangles.len() == triangles.len();
        if !same || checked.defects.inverted || checked.defects.welded_vertices > 0 {
            return Ok(checked);
        }
        let volume_mm3 = signed_volume(&vertices, &triangles, checked.bounds.center());
        Ok(Self { vertices, triangles, volume_mm3, ..checked })
    }

    /// Corner positions, mm; every one is used by a triangle.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Corner indices, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The edges at which the surface is not closed, as pairs of corner indices: open ones, and those at which triangles do not fit.
    pub fn faulty_edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        if !self.defects.is_closed() {
            edge_defects(&self.triangles, self.vertices.len(), |from, to| edges.push([from, to]));
        }
        edges
    }

    /// The three corners of a triangle, mm.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// Axis-aligned bounds in the mesh's own frame.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Exact axis-aligned bounds of the mesh at a pose. Time grows with the vertices.
    pub fn bounds_at(&self, pose: &Pose) -> Bounds {
        Bounds::from_points(self.vertices.iter().map(|&v| pose.transform_point(v)))
    }

    /// Enclosed volume, mm3, positive.
    pub fn volume_mm3(&self) -> f64 {
        self.volume_mm3
    }

    /// The defects of the surface.
    pub fn defects(&self) -> MeshDefects {
        self.defects
    }
}

/// Sum of the signed tetrahedra over all triangles, mm3; an `origin` near the mesh keeps precision.
fn signed_volume(vertices: &[DVec3], triangles: &[[u32; 3]], origin: DVec3) -> f64 {
    let corner = |v: u32| vertices[v as usize] - origin;
    triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        (vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    #[test]
    fn a_tetrahedron_has_a_sixth_of_the_cube() {
        let (vertices, triangles) = tetrahedron();
        let mesh = Mesh::new(vertices, triangles).expect("is a solid");
        assert!((mesh.volume_mm3() - 1.0 / 6.0).abs() < 1e-12);
        assert!(mesh.defects().is_closed());
    }

    #[test]
    fn an_inside_out_surface_is_turned_and_reported() {
        let (vertices, mut triangles) = tetrahedron();
        triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let mesh = Mesh::new(vertices, triangles).expect("is a solid");
        assert!(mesh.volume_mm3() > 0.0 && mesh.defects().inverted);
    }

    #[test]
    fn a_missing_triangle_leaves_three_open_edges() {
        let (vertices, mut triangles) = tetrahedron();
        triangles.pop();
        let mesh = Mesh::new(vertices, triangles).expect("still has a signed volume");
        assert_eq!((mesh.defects().open_edges, mesh.faulty_edges().len()), (3, 3));
    }

    #[test]
    fn equal_places_are_one_vertex_in_the_order_of_their_first_use() {
        let (vertices, triangles) = tetrahedron();
        let soup: Vec<DVec3> =
            triangles.iter().flatten().map(|&v| vertices[v as usize] * -0.0 + vertices[v as usize]).collect();
        let apart: Vec<[u32; 3]> = (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mesh = Mesh::new(soup, apart).expect("is a solid");
        assert_eq!(mesh.vertices(), [DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::Z]);
        assert!(mesh.defects().is_closed());
    }

    #[test]
    fn noise_of_32_bit_coordinates_does_not_open_a_surface() {
        let (vertices, triangles) = tetrahedron();
        let mut soup: Vec<DVec3> = triangles.iter().flatten().map(|&v| vertices[v as usize] * 50.0).collect();
        soup[1] += DVec3::new(3e-15, -2e-15, 4e-6);
        let apart: Vec<[u32; 3]> = (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        assert!(Mesh::new(soup.clone(), apart.clone()).expect("is a solid").defects().is_closed());
        soup[1].z += 0.01;
        assert!(!Mesh::new(soup, apart).expect("still has a volume").defects().is_closed(), "a real gap is told");
    }

    #[test]
    fn nonsense_is_refused() {
        let (vertices, triangles) = tetrahedron();
        let mut bad = vertices.clone();
        bad[2].y = f64::NAN;
        assert_eq!(Mesh::new(bad, triangles.clone()).map(|_| ()), Err(MeshError::NotFinite { vertex: 2 }));
        assert!(matches!(Mesh::new(vertices.clone(), vec![[0, 1, 9]]), Err(MeshError::BadIndex { .. })));
        assert!(matches!(Mesh::new(vertices.clone(), vec![[0, 1, 2]]), Err(MeshError::NoVolume)));
        assert!(matches!(Mesh::new(vertices, vec![]), Err(MeshError::Empty)));
    }
}
