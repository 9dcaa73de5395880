//! Who goes first: the order of precedence of waiting copies. It is defined here and nowhere else: the ledger's lists,
//! the open build and its searches, and the pages all use it.
//!
//! 1. **Put back**: copies that were printed badly, the earliest put back first.
//! 2. **Priority**, 100 before 0.
//! 3. **Due date**, the earliest first; parts without one come after all others of their priority.
//! 4. **Standing**: a copy that stands in the open build comes before one that does not. So it stays unless a copy of
//!    higher priority or with an earlier due date needs its room.
//! 5. **Age**: what was claimed first. A copy that comes back (it found no place, its build failed) keeps its age, so
//!    it is the first of its priority and due date. Parts claimed at the same time are ordered by their numbers.
//!
//! Precedence decides which copies are in the next build. The nester receives them in this order
//! (`nester::NestingInstance`) and decides only where they stand: a copy is left out only if it finds no place beside
//! the copies that come before it.

use std::cmp::{Ordering, Reverse};

use crate::PartRow;

/// Compares two parts by precedence; `Less` goes first. The flags say whether their copies stand in the open build.
pub fn compare_precedence((one, one_stands): (&PartRow, bool), (other, other_stands): (&PartRow, bool)) -> Ordering {
    let key = |part: &PartRow, stands: bool| {
        let due = part.terms.due_at.map(|due| due.0);
        let put_back = part.owed.put_back_at.map(|at| at.0);
        (
            put_back.is_none(),
            put_back,
            Reverse(part.terms.priority),
            due.is_none(),
            due,
            !stands,
            part.times.claimed_at.0,
            part.id,
        )
    };
    key(one, one_stands).cmp(&key(other, other_stands))
}

/// Sorts parts by precedence; nothing stands.
pub fn sort_by_precedence(parts: &mut [PartRow]) {
    parts.sort_by(|one, other| compare_precedence((one, false), (other, false)));
}
