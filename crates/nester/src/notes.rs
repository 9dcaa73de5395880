//! What is remembered of pairs of parts while a layout is changed.

use super::touch::Touch;

/// What is remembered of a pair.
#[derive(Debug, Clone)]
pub(crate) struct Note {
    other: u32,
    /// Of the pair's overlap among all others.
    pub(crate) weight: f32,
    /// What the guides are wrong by, mm: too little where no contact can be told, or too much.
    pub(crate) margin: f32,
    /// Exact contacts, from the failed confirmations.
    pub(crate) touches: Vec<Touch>,
    /// The moves of both parts at which the triangles were last found clear.
    pub(crate) clear_at: Option<(u32, u32)>,
    /// The overlap, at the moves of both parts at which it was last asked for.
    pub(crate) seen: Option<((u32, u32), f32)>,
}

/// What holds between two parts.
pub(crate) struct Wanted<'a> {
    /// What the guides keep, mm.
    pub(crate) reach: f32,
    /// What the triangles are to keep, mm.
    pub(crate) clearance: f32,
    pub(crate) weight: f32,
    pub(crate) touches: &'a [Touch],
}

/// Notes of all pairs: of every part those with later parts, in rising order.
#[derive(Debug, Clone)]
pub(crate) struct Notes {
    of: Vec<Vec<Note>>,
}

impl Notes {
    /// Nothing to remember of so many parts.
    pub(crate) fn new(parts: usize) -> Self {
        Self { of: vec![Vec::new(); parts] }
    }

    /// What is remembered of a pair.
    pub(crate) fn of(&self, one: usize, other: usize) -> Option<&Note> {
        let (first, second) = (one.min(other), one.max(other) as u32);
        let at = self.of[first].binary_search_by_key(&second, |n| n.other).ok()?;
        Some(&self.of[first][at])
    }

    /// The same, to change; a fresh note where there is none.
    pub(crate) fn of_mut(&mut self, one: usize, other: usize) -> &mut Note {
        let (first, second) = (one.min(other), one.max(other) as u32);
        let notes = &mut self.of[first];
        let at = notes.binary_search_by_key(&second, |n| n.other).unwrap_or_else(|at| {
            let fresh =
                Note { other: second, weight: 1.0, margin: 0.0, touches: Vec::new(), clear_at: None, seen: None };
            notes.insert(at, fresh);
            at
        });
        &mut notes[at]
    }

    /// Weights go back towards 1.
    pub(crate) fn decay(&mut self, share: f32) {
        self.of.iter_mut().flatten().for_each(|n| n.weight = (n.weight * share).max(1.0));
    }

    /// Forgets weights, and a part of the margins.
    pub(crate) fn forget(&mut self) {
        for notes in &mut self.of {
            notes.iter_mut().for_each(|n| (n.weight, n.margin, n.seen) = (1.0, 0.7 * n.margin, None));
            notes.retain(|n| n.margin.abs() > 0.01 || !n.touches.is_empty());
        }
    }
}
