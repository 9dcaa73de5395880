//! Defects of a surface. They are reported, not refused.

/// The defects of a surface; all zero for a clean one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct MeshDefects {
    /// Edges with a triangle on one side only.
    pub open_edges: usize,
    /// Edges shared by more than two triangles whose directions do not cancel in pairs.
    pub non_manifold_edges: usize,
    /// Edges whose two triangles run the same way.
    pub inconsistent_edges: usize,
    /// Triangles without an area, dropped.
    pub degenerate_triangles: usize,
    /// Vertices that were merged with another one within the rounding of 32-bit coordinates.
    pub welded_vertices: usize,
    /// Triangles of duplicate pieces at the same place, left out.
    pub equal_triangles: usize,
    /// Whether the whole surface was inside out and was reversed.
    pub inverted: bool,
}

impl MeshDefects {
    /// Whether the surface is closed and consistently oriented.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.non_manifold_edges == 0 && self.inconsistent_edges == 0
    }
}
