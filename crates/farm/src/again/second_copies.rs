//! Files of live parts on the disks of two servers: each node copies those of the node before it, in the circle of the nodes that run. If
//! that server is lost, whoever adopts its machines has them from here, and nobody is asked for a file again.

use std::{collections::BTreeSet, time::Duration};

use anyhow::Result;
use build_file::format_count;
use intake::ContentStore;
use jobs::BackgroundJob;
use ledger::{NodeRow, PartId};
use tracing::info;

use crate::{
    alerts::alert::AlertKind,
    core::{
        desks::{Serving, Shared},
        farm::Farm,
        state::SecondCopyLook,
    },
    nesting::{
        node_client::node_secret,
        node_content::{OtherNodes, remove_unneeded, second_copies},
    },
};

/// What fails, and is tried again later.
const STEP: &str = "copying files of another node";
/// A copy is kept this long although no part needs it: its part may just be claimed.
const KEEP_COPIES: Duration = Duration::from_secs(600);
/// All live parts are looked at so often: some came from another machine, and some have ended. Otherwise the newer ones are.
const LOOK_AT_ALL: Duration = Duration::from_secs(60);

/// Copies the files of another node's parts.
#[derive(Clone)]
pub(crate) struct SecondCopyJob {
    node: String,
}

impl BackgroundJob<Farm> for SecondCopyJob {
    const KIND: &'static str = "SecondCopy";
    const IS_LOOK: bool = true;
    /// Number of files that were copied.
    type Outcome = Result<usize>;
    type Desk<'f> = Shared<'f>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, mut shared: Self::Desk<'_>, copied: Self::Outcome) -> Result<()> {
        match copied {
            Ok(count) => {
                shared.alerts.clear(AlertKind::StepFails, "", STEP);
                if count > 0 {
                    info!("{} of the node {} copied.", format_count(count, "file", "files"), self.node);
                }
            }
            Err(failure) => {
                // Whatever is missing is looked for again.
                shared.schedule.copies = SecondCopyLook::default();
                shared.report_failure(AlertKind::StepFails, "", STEP, &failure);
            }
        }
        Ok(())
    }
}

/// Starts to copy what is missing, and to remove what is not needed any more.
pub(crate) async fn keep_second_copies(desk: &mut Serving<'_>) -> Result<()> {
    if desk.shared.ledger.file().is_some() || desk.jobs.is_running::<SecondCopyJob>("") {
        return Ok(());
    }
    let (now, look) = (desk.shared.now(), &mut desk.shared.schedule.copies);
    if !look.changes.may_have_changed(desk.shared.ledger, [], (now, LOOK_AT_ALL)).await {
        return Ok(());
    }
    let rows = desk.shared.ledger.list_nodes().await?;
    let node = node_before(&desk.shared.settings.node.name, &rows).unwrap_or_default();
    let nodes = OtherNodes::from_rows(desk.shared.settings, rows, &node_secret(desk.shared.ledger).await?);
    let newest = desk.shared.ledger.newest_part().await?;
    let is_all = look.node != node || look.all_at.is_none_or(|at| now.saturating_duration_since(at) >= LOOK_AT_ALL);
    let after = look.newest.filter(|_| !is_all).unwrap_or(PartId(0));
    if after == newest {
        return Ok(());
    }
    (look.node, look.newest) = (node.clone(), Some(newest));
    look.all_at = if is_all { Some(now) } else { look.all_at };
    let (state_dir, ledger) = (desk.shared.settings.state_dir.clone(), desk.shared.ledger.clone());
    let runtime = tokio::runtime::Handle::current();
    desk.jobs.start(SecondCopyJob { node: node.clone() }, move || {
        let contents = runtime.block_on(ledger.live_contents(after))?;
        let files = second_copies(&state_dir);
        if is_all {
            let needed: BTreeSet<&str> = contents.iter().map(|(hash, _)| hash.as_str()).collect();
            remove_unneeded(&files, KEEP_COPIES, |hash| needed.contains(hash))?;
        }
        copy_files(&files, &node, &contents, &nodes)
    });
    Ok(())
}

/// The node whose files this one copies: the one before it by name, of those that run and can be reached.
fn node_before(own: &str, nodes: &[NodeRow]) -> Option<String> {
    let mut names: Vec<&str> = (nodes.iter())
        .filter(|row| row.alive && (row.name == own || !row.address.is_empty()))
        .map(|row| row.name.as_str())
        .collect();
    names.sort_unstable();
    let at = names.iter().position(|name| *name == own)?;
    let before = names[(at + names.len() - 1) % names.len()];
    (before != own).then(|| before.to_owned())
}

/// `contents` are files of live parts, each with the node of its machine. Returns how many of `node` ("" = none) were copied.
fn copy_files(files: &ContentStore, node: &str, contents: &[(String, String)], nodes: &OtherNodes) -> Result<usize> {
    let kept = files.list_contents()?;
    let mut copied = 0;
    let is_missing = |(hash, of): &&(String, String)| !node.is_empty() && of == node && !kept.contains_key(hash);
    for (hash, _) in contents.iter().filter(is_missing) {
        // The part may have been built or moved meanwhile: then no copy is needed.
        copied += usize::from(nodes.fetch_from_node(node, files, hash)?);
    }
    Ok(copied)
}

#[cfg(test)]
mod tests {
    use ledger::UtcTimestamp;

    use super::*;

    fn node(name: &str, alive: bool, address: &str) -> NodeRow {
        NodeRow {
            name: name.to_owned(),
            address: address.to_owned(),
            pid: 1,
            host: String::new(),
            version: String::new(),
            started_at: UtcTimestamp(jiff::Timestamp::UNIX_EPOCH),
            beat_at: UtcTimestamp(jiff::Timestamp::UNIX_EPOCH),
            status: String::new(),
            alerts: String::new(),
            alive,
        }
    }

    #[test]
    fn each_node_that_runs_copies_those_of_the_one_before() {
        let at = "http://x";
        let nodes = [node("c", true, at), node("a", true, at), node("b", false, at), node("d", true, "")];
        assert_eq!(node_before("a", &nodes).as_deref(), Some("c"));
        assert_eq!(node_before("c", &nodes).as_deref(), Some("a"));
        assert_eq!(node_before("d", &nodes).as_deref(), Some("c"), "it cannot be reached, and can still copy");
        assert_eq!(node_before("a", &nodes[1..3]), None, "a node alone");
    }
}
