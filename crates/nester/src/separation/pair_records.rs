//! Data about pairs of parts that is kept while a layout changes.

use super::exact_contacts::ExactContact;

/// What is left of a weight from round to round where nothing overlaps.
pub(crate) const WEIGHT_DECAY: f32 = 0.95;
/// Greatest weight.
pub(crate) const MAX_WEIGHT: f32 = 1e5;

/// Data about one pair.
#[derive(Debug, Clone)]
pub(crate) struct PairRecord {
    other: u32,
    /// Weight of the pair's overlap.
    pub(crate) weight: f32,
    /// Correction of the proxies' distance, mm: positive where they see too little and no contact is known, negative
    /// where they see too much.
    pub(crate) margin: f32,
    /// Exact contacts from failed exact tests.
    pub(crate) contacts: Vec<ExactContact>,
    /// The move counts of both parts when the pair was last found clear on the triangles.
    pub(crate) clear_at: Option<(u32, u32)>,
    /// The last known overlap, with the move counts of both parts at that time.
    pub(crate) known_overlap: Option<((u32, u32), f32)>,
}

/// The requirements between two parts.
pub(crate) struct PairConstraint<'a> {
    /// Distance that the proxies must keep, mm.
    pub(crate) reach: f32,
    /// Distance that the triangles must keep, mm.
    pub(crate) clearance: f32,
    pub(crate) weight: f32,
    pub(crate) contacts: &'a [ExactContact],
}

/// Data of all pairs: for every part, the pairs with later parts, in rising order.
#[derive(Debug, Clone)]
pub(crate) struct PairRecordTable {
    by_part: Vec<Vec<PairRecord>>,
}

impl PairRecordTable {
    /// Creates an empty table for `parts` parts.
    pub(crate) fn new(parts: usize) -> Self {
        Self { by_part: vec![Vec::new(); parts] }
    }

    /// The data of a pair.
    pub(crate) fn get_pair(&self, one: usize, other: usize) -> Option<&PairRecord> {
        let (first, second) = (one.min(other), one.max(other) as u32);
        let at = self.by_part[first].binary_search_by_key(&second, |n| n.other).ok()?;
        Some(&self.by_part[first][at])
    }

    /// The data of a pair, mutable; created if there is none.
    pub(crate) fn pair_or_insert(&mut self, one: usize, other: usize) -> &mut PairRecord {
        let (first, second) = (one.min(other), one.max(other) as u32);
        let records = &mut self.by_part[first];
        let at = records.binary_search_by_key(&second, |n| n.other).unwrap_or_else(|at| {
            let fresh = PairRecord {
                other: second,
                weight: 1.0,
                margin: 0.0,
                contacts: Vec::new(),
                clear_at: None,
                known_overlap: None,
            };
            records.insert(at, fresh);
            at
        });
        &mut records[at]
    }

    /// Moves the weights back towards 1.
    pub(crate) fn decay_weights(&mut self) {
        self.by_part.iter_mut().flatten().for_each(|n| n.weight = (n.weight * WEIGHT_DECAY).max(1.0));
    }

    /// Resets the weights and reduces the margins.
    pub(crate) fn reset_weights(&mut self) {
        for records in &mut self.by_part {
            records.iter_mut().for_each(|n| (n.weight, n.margin, n.known_overlap) = (1.0, 0.7 * n.margin, None));
            records.retain(|n| n.margin.abs() > 0.01 || !n.contacts.is_empty());
        }
    }
}
