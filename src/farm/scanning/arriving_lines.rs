//! Lines of orders that came by request and that the ledger has no part of yet: each becomes a claim of its machine's hot folder, and is
//! taken like any other claim from there on.

use std::path::Path;

use intake::{ClaimedPart, OrderedFile, PutContents, place_ordered_claim};
use ledger::{Ledger, OrderedLine};
use tracing::warn;

use crate::farm::alerts::failure::error_chain;

/// Lines of a machine that one scan looks at. Those whose files are missing keep no others waiting.
const LINES_PER_SCAN: u32 = 10_000;
/// Claims that one scan makes.
const CLAIMS_PER_SCAN: usize = 100;

/// The lines of a machine that have no part yet, and where their files are.
#[derive(Debug)]
pub struct ArrivingLines {
    lines: Vec<OrderedLine>,
    contents: PutContents,
}

impl ArrivingLines {
    /// Those of a machine as the ledger has them now; `None` = it has none. Where it does not answer, the next scan asks again.
    pub(crate) async fn read_from(ledger: Option<&Ledger>, machine: &str, contents: PutContents) -> Self {
        let Some(ledger) = ledger else { return Self { lines: Vec::new(), contents } };
        let lines = ledger.arriving_lines(machine, LINES_PER_SCAN).await.unwrap_or_else(|failure| {
            warn!("The lines that were ordered for {machine} are not known just now: {failure}.");
            Vec::new()
        });
        Self { lines, contents }
    }

    /// Makes the claims of the lines that have none, as many as one scan takes. Those that fail are tried again by the next scan.
    pub(super) fn place_lines(&self, inbox: &Path, farm: &str, warnings: &mut Vec<String>) -> Vec<ClaimedPart> {
        let mut placed = Vec::new();
        for line in &self.lines {
            if placed.len() >= CLAIMS_PER_SCAN {
                break;
            }
            let (claim, name, ticket) = (line.claim.as_str(), line.name.as_str(), line.ticket.as_str());
            let file = OrderedFile { claim, name, ticket, contents: &self.contents, hash: &line.content_hash };
            match place_ordered_claim(inbox, farm, &file) {
                Ok(claim) => placed.extend(claim),
                Err(failure) => warnings.push(format!(
                    "{} of order {}, ordered by {}: {}",
                    line.name,
                    line.order_name,
                    line.client,
                    error_chain(&failure)
                )),
            }
        }
        placed
    }
}
