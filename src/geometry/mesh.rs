//! A closed triangle surface in mm, checked once, at its construction.

use glam::DVec3;
use thiserror::Error;

use super::{Bounds, Pose};

/// Why a triangle soup is no solid.
#[derive(Debug, Clone, PartialEq, Error)]
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
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices}")]
    BadIndex {
        /// Index of the triangle as given.
        triangle: usize,
        /// The vertex index that it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The surface encloses nothing (flat, or its parts cancel out).
    #[error("the mesh encloses no volume")]
    NoVolume,
}

/// What is wrong with a surface; all zero for a clean one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Defects {
    /// Edges with a triangle on one side only.
    pub open_edges: usize,
    /// Edges shared by more than two triangles whose directions do not cancel in pairs.
    pub non_manifold_edges: usize,
    /// Edges whose two triangles run the same way.
    pub inconsistent_edges: usize,
    /// Triangles without an area, dropped.
    pub degenerate_triangles: usize,
    /// The whole surface was inside out and has been turned.
    pub inverted: bool,
}

impl Defects {
    /// Whether the surface is closed and consistently oriented.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.non_manifold_edges == 0 && self.inconsistent_edges == 0
    }
}

/// A triangle surface with welded vertices, outward orientation, finite coordinates and a volume. Millimetres.
#[derive(Debug, Clone)]
pub struct Mesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    bounds: Bounds,
    volume_mm3: f64,
    defects: Defects,
}

impl Mesh {
    /// Checks, welds vertices at exactly equal places, drops triangles that name a vertex twice, and turns an inside-out
    /// surface. Holes and the like are no error here but told by [`Mesh::defects`].
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
        let (vertices, mut triangles) = weld(&vertices, triangles);
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        let bounds = Bounds::around(vertices.iter().copied());
        let mut volume_mm3 = signed_volume(&vertices, &triangles, bounds.center());
        let size = bounds.size();
        if volume_mm3.abs() <= 1e-9 * size.max_element().powi(3) || size.min_element() <= 0.0 {
            return Err(MeshError::NoVolume);
        }
        let mut defects = edge_defects(&triangles, vertices.len());
        defects.degenerate_triangles = given - triangles.len();
        if volume_mm3 < 0.0 {
            volume_mm3 = -volume_mm3;
            defects.inverted = true;
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Ok(Self { vertices, triangles, bounds, volume_mm3, defects })
    }

    /// Corner places, mm; every one is used by a triangle.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Corner indices, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
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
        Bounds::around(self.vertices.iter().map(|&v| pose.point(v)))
    }

    /// Enclosed volume, mm3, positive.
    pub fn volume_mm3(&self) -> f64 {
        self.volume_mm3
    }

    /// What is wrong with the surface.
    pub fn defects(&self) -> Defects {
        self.defects
    }
}

/// Merges equal vertices and drops triangles that collapse and vertices that nothing names.
fn weld(vertices: &[DVec3], triangles: Vec<[u32; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const UNSEEN: u32 = u32::MAX;
    let mut welder = Welder::default();
    let mut welded = vec![UNSEEN; vertices.len()];
    let mut out = triangles;
    // -0.0 equals 0.0, so that both weld; there is no NaN any more.
    out.retain(|corners| {
        let [a, b, c] = corners.map(|v| vertices[v as usize]);
        a != b && b != c && c != a
    });
    for corner in out.iter_mut().flatten() {
        let known = &mut welded[*corner as usize];
        if *known == UNSEEN {
            *known = welder.index(vertices[*corner as usize]);
        }
        *corner = *known;
    }
    (welder.kept, out)
}

/// Numbers different places in the order of their first coming. An open hash table of indices: a third of the time and
/// memory of a map that holds the places a second time.
#[derive(Default)]
struct Welder {
    kept: Vec<DVec3>,
    /// Index + 1 of a kept vertex, 0 where free; its length is a power of two.
    slots: Vec<u32>,
}

impl Welder {
    fn index(&mut self, place: DVec3) -> u32 {
        if 2 * self.kept.len() >= self.slots.len() {
            self.grow();
        }
        let slot = self.slot(place);
        if self.slots[slot] == 0 {
            self.kept.push(place);
            self.slots[slot] = self.kept.len() as u32;
        }
        self.slots[slot] - 1
    }

    /// Where a place is, or the free slot where it belongs.
    fn slot(&self, place: DVec3) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(place) as usize & mask;
        while self.slots[slot] != 0 && self.kept[self.slots[slot] as usize - 1] != place {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow(&mut self) {
        self.slots = vec![0; (4 * self.kept.len()).next_power_of_two().max(64)];
        for index in 0..self.kept.len() {
            let slot = self.slot(self.kept[index]);
            self.slots[slot] = index as u32 + 1;
        }
    }
}

/// Mixes the bits of three coordinates; adding zero makes -0.0 and 0.0 the same.
fn hash(place: DVec3) -> u64 {
    let fold = |state: u64, bits: u64| {
        let wide = u128::from(state ^ bits) * 0x9e37_79b9_7f4a_7c15;
        (wide >> 64) as u64 ^ wide as u64
    };
    (place + DVec3::ZERO).to_array().into_iter().map(f64::to_bits).fold(0x2545_f491_4f6c_dd1d, fold)
}

/// Sum of the signed tetrahedra over all triangles, mm3; `origin` near the mesh keeps digits.
fn signed_volume(vertices: &[DVec3], triangles: &[[u32; 3]], origin: DVec3) -> f64 {
    let corner = |v: u32| vertices[v as usize] - origin;
    triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum::<f64>() / 6.0
}

/// Counts edges that are not passed exactly once each way. An edge passed twice each way (two solids that touch along
/// it) still encloses a volume and is no defect.
fn edge_defects(triangles: &[[u32; 3]], vertices: usize) -> Defects {
    let edges = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    // A counting sort by the lower vertex leaves a handful of edges in each bucket.
    let mut ends = vec![0_usize; vertices + 1];
    edges().for_each(|(a, b)| ends[a.min(b) as usize + 1] += 1);
    for vertex in 0..vertices {
        ends[vertex + 1] += ends[vertex];
    }
    let mut sorted = vec![0_u64; 3 * triangles.len()];
    for (a, b) in edges() {
        let next = &mut ends[a.min(b) as usize];
        sorted[*next] = u64::from(a.max(b)) << 1 | u64::from(a < b);
        *next += 1;
    }
    let mut defects = Defects::default();
    let mut start = 0;
    for &end in &ends[..vertices] {
        let bucket = &mut sorted[start..end];
        bucket.sort_unstable();
        for edge in bucket.chunk_by(|x, y| x >> 1 == y >> 1) {
            let forward = edge.iter().filter(|&e| e & 1 == 1).count();
            match (edge.len(), 2 * forward == edge.len()) {
                (_, true) => {}
                (1, _) => defects.open_edges += 1,
                (2, _) => defects.inconsistent_edges += 1,
                _ => defects.non_manifold_edges += 1,
            }
        }
        start = end;
    }
    defects
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
    fn an_inside_out_surface_is_turned_and_told() {
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
        assert_eq!(mesh.defects().open_edges, 3);
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
        let many: Vec<DVec3> = (0..1000).map(|i| DVec3::new(f64::from(i % 250), 0.0, -0.0)).collect();
        let mut welder = Welder::default();
        let indices: Vec<u32> = many.iter().map(|&place| welder.index(place)).collect();
        assert!((0..1000).all(|i| indices[i] == i as u32 % 250));
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
