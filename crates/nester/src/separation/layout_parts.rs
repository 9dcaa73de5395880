//! What is fixed about the parts of a working layout: it does not change while the parts move.

/// The parts of a layout: copies of items, then zones.
#[derive(Debug, Clone)]
pub(crate) struct LayoutParts {
    /// Item and copy number of each part.
    pub(crate) copies: Vec<(usize, u32)>,
    /// Clearance of each part, mm.
    pub(crate) clearances: Vec<f32>,
    /// Parts that must not move: fixed copies and zones.
    pub(crate) fixed: Vec<bool>,
    /// Number of parts that are copies, not zones.
    pub(crate) copy_count: usize,
}
