//! Waiting parts that are about to be refused.

use crate::ledger::{CommandRow, PartRow, Refusal};

/// A waiting part that is refused once a copy of its original is in the error folder. Until then it is not batched.
#[derive(Debug)]
pub(super) struct Leaving {
    /// Which.
    pub(super) part: PartRow,
    /// Why.
    pub(super) cause: Refusal,
    /// The same in whole sentences.
    pub(super) reason: String,
    /// The order by hand that asked for it.
    pub(super) command: Option<CommandRow>,
}
