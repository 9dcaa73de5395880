//! What may be wrong with a surface: told, not refused.

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
    /// Corners that were moved onto another one, at a distance that is the rounding of 32-bit coordinates.
    pub welded_vertices: usize,
    /// Triangles of pieces that are there several times in one place, left out.
    pub equal_triangles: usize,
    /// The whole surface was inside out and has been turned.
    pub inverted: bool,
}

impl Defects {
    /// Whether the surface is closed and consistently oriented.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.non_manifold_edges == 0 && self.inconsistent_edges == 0
    }
}
