//! The machines that other nodes of the farm serve: their folders and parts are for those nodes to look at.

use std::{collections::BTreeMap, path::PathBuf};

use anyhow::{Context, Result};
use build_file::format_count;
use ledger::{Ledger, LedgerError};
use settings::Settings;

use super::report::CheckReport;

/// Each machine with its node.
#[derive(Debug, Default)]
pub struct OtherMachines(BTreeMap<String, String>);

impl OtherMachines {
    /// As the ledger says; none where it cannot be read, which its own check tells.
    pub fn read(settings: &Settings) -> Result<Self> {
        if settings.ledger.file().is_some() {
            return Ok(Self::default());
        }
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        runtime.context("starting to read the machines of other nodes")?.block_on(async {
            let Ok(ledger) = Ledger::open_existing(&settings.ledger).await else { return Ok(Self::default()) };
            let others = farm::machines_of_other_nodes(settings, &ledger).await;
            ledger.close().await;
            Ok(Self(others.unwrap_or_default()))
        })
    }

    /// The settings without them.
    pub fn taken_out_of(&self, settings: &Settings) -> Settings {
        let mut own = settings.clone();
        own.profiles.retain(|name, _| !self.0.contains_key(name));
        own
    }

    /// Says of those that are configured here, too, who serves them.
    pub fn report_configured(&self, settings: &Settings, report: &mut CheckReport) {
        for (machine, node) in self.0.iter().filter(|(machine, _)| settings.profiles.contains_key(*machine)) {
            report.add_note(machine, format!("the node {node} serves it, and checks its folders"));
        }
    }

    /// Their hot folders, where these lie beside those of this node.
    pub fn hot_folders(&self, settings: &Settings) -> impl Iterator<Item = PathBuf> {
        self.0.keys().map(|machine| settings.inbox_base.join(machine))
    }

    /// Reports parts that wait for a machine that this node does not serve, unless the node of the machine runs.
    pub async fn check_waiting_parts(
        &self,
        ledger: &Ledger,
        settings: &Settings,
        report: &mut CheckReport,
    ) -> Result<(), LedgerError> {
        for status in ledger.machine_statuses().await? {
            let (machine, parts) = (&status.machine, status.claimed_parts + status.waiting_parts);
            if parts == 0 || settings.profiles.contains_key(machine) {
                continue;
            }
            let waiting = format_count(parts, "part waits", "parts wait");
            match self.0.get(machine) {
                Some(node) if ledger.find_node(node).await?.is_some_and(|row| row.alive) => {}
                Some(node) => report.add_warning(
                    "nodes",
                    format!("{waiting} for {machine}, whose node {node} does not run"),
                    format!(
                        "start it; where it is gone for good, `nestd adopt {machine}` on the node that takes its place"
                    ),
                ),
                None => report.add_problem(
                    "configuration",
                    format!("{waiting} for {machine}, which has no file in profiles/"),
                    match ledger.file() {
                        Some(_) => "put its file back, or cancel the parts",
                        None => "put its file into profiles/ of the node that is to serve it, or cancel the parts",
                    },
                ),
            }
        }
        Ok(())
    }
}
