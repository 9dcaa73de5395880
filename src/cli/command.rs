//! `nestd flush|pause|resume|retry|cancel|scan`: orders by hand, given to the daemon through the ledger.

use anyhow::Result;

use super::{Common, Exit};

/// What an order is about.
#[derive(Debug, Clone)]
pub enum Order {
    /// Publish what waits in a profile now.
    Flush(String),
    /// Fire no batch in a profile until it is resumed.
    Pause(String),
    /// Let a profile fire again.
    Resume(String),
    /// Take a rejected part back.
    Retry(i64),
    /// Reject a waiting part.
    Cancel(i64),
    /// Look into the hot folders now.
    Scan,
}

/// Gives the order and waits a little for the answer.
pub fn run(_common: &Common, _order: &Order) -> Result<Exit> {
    Ok(Exit::Success)
}
