//! Lines of orders that came by request and that the ledger has no part of yet: each becomes a claim of its machine's hot folder, and is
//! taken like any other claim from there on.

use std::path::Path;

use intake::{ClaimedPart, OrderedFile, PutContents, place_ordered_claim};
use ledger::{Ledger, OrderedLine};
use settings::Settings;
use tracing::warn;

use crate::{alerts::failure::error_chain, nesting::node_content::OtherNodes};

/// Lines of a machine that one scan looks at. Those whose files are missing keep no others waiting.
const LINES_PER_SCAN: u32 = 10_000;
/// Claims that one scan makes.
const CLAIMS_PER_SCAN: usize = 100;

/// The lines of a machine that have no part yet, and where their files are.
#[derive(Debug)]
pub struct ArrivingLines {
    lines: Vec<OrderedLine>,
    contents: PutContents,
    /// Where files are that were put on other nodes.
    nodes: Option<OtherNodes>,
}

impl ArrivingLines {
    /// Those of a machine as the ledger has them now. Where it does not answer, the next scan asks again.
    pub(crate) async fn read_from(ledger: &Ledger, machine: &str, settings: &Settings) -> Self {
        let lines = ledger.arriving_lines(machine, LINES_PER_SCAN).await.unwrap_or_else(|failure| {
            warn!("The lines that were ordered for {machine} are not known just now: {failure}.");
            Vec::new()
        });
        let is_served_alone = lines.is_empty() || ledger.file().is_some();
        let nodes = if is_served_alone { None } else { OtherNodes::of_ledger(settings, ledger).await.ok() };
        Self { lines, nodes, ..Self::none(settings) }
    }

    /// No lines.
    pub(crate) fn none(settings: &Settings) -> Self {
        Self { lines: Vec::new(), contents: PutContents::of_farm(&settings.state_dir), nodes: None }
    }

    /// Brings a file here that was put on another node.
    fn fetch(&self, hash: &str) -> anyhow::Result<()> {
        if let Some(nodes) = self.nodes.as_ref().filter(|_| !self.contents.path_of(hash).exists()) {
            nodes.fetch_put(&self.contents, hash)?;
        }
        Ok(())
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
            let claim = self.fetch(&line.content_hash).map_err(|failure| format!("{failure:#}"));
            let place = || place_ordered_claim(inbox, farm, &file).map_err(|failure| error_chain(&failure));
            match claim.and_then(|()| place()) {
                Ok(claim) => placed.extend(claim),
                Err(why) => {
                    let (name, order, client) = (&line.name, &line.order_name, &line.client);
                    warnings.push(format!("{name} of order {order}, ordered by {client}: {why}"));
                }
            }
        }
        placed
    }
}
