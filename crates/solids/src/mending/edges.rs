//! Which triangles use which edge of a surface: a sorted list, so that the same surface is always mended the same way.

/// One use of an edge by a triangle. Sorted by edge, then by triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct EdgeUse {
    low: u32,
    high: u32,
    /// Three times the triangle, plus the number of its edge.
    slot: u32,
    /// From the lower corner to the higher one.
    is_forward: bool,
}

impl EdgeUse {
    pub(super) fn triangle(self) -> usize {
        self.slot as usize / 3
    }

    /// Where the triangle runs along it: from, to.
    pub(super) fn ends(self) -> (u32, u32) {
        if self.is_forward { (self.low, self.high) } else { (self.high, self.low) }
    }

    fn edge(self) -> (u32, u32) {
        (self.low, self.high)
    }
}

/// All uses of all edges.
#[derive(Debug)]
pub(super) struct EdgeUses(Vec<EdgeUse>);

impl EdgeUses {
    pub(super) fn of(triangles: &[[u32; 3]]) -> Self {
        let uses = triangles.iter().enumerate().flat_map(|(triangle, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].into_iter().enumerate().map(move |(at, (from, to))| EdgeUse {
                low: from.min(to),
                high: from.max(to),
                slot: (3 * triangle + at) as u32,
                is_forward: from < to,
            })
        });
        let mut uses: Vec<EdgeUse> = uses.collect();
        uses.sort_unstable();
        Self(uses)
    }

    /// The uses of each edge.
    pub(super) fn edges(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.0.chunk_by(|one, other| one.edge() == other.edge())
    }

    /// Whether a triangle has this edge.
    pub(super) fn has(&self, one: u32, other: u32) -> bool {
        self.0.binary_search_by_key(&(one.min(other), one.max(other)), |used| used.edge()).is_ok()
    }
}

/// Whether an edge is used as often one way as the other.
pub(super) fn is_balanced(uses: &[EdgeUse]) -> bool {
    2 * uses.iter().filter(|used| used.is_forward).count() == uses.len()
}
