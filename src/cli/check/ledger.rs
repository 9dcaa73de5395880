//! The ledger: can it be opened, is its schema ours, does it hold together, and are the queues those it knows.

use std::fs;

use anyhow::{Context, Result};
use build_file::counted;

use super::report::Report;
use crate::{
    farm,
    ledger::{BuildRow, BuildState, Ledger, LedgerError},
    settings::{Profile, Settings},
};

const WHAT: &str = "ledger";
/// The file by which a queue folder is known.
const QUEUE_MARKER: &str = ".nestd-queue";

/// Looks at the ledger without changing it.
pub fn look(settings: &Settings, report: &mut Report) -> Result<()> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().context("starting to read the ledger")?;
    runtime.block_on(look_into(settings, report));
    Ok(())
}

async fn look_into(settings: &Settings, report: &mut Report) {
    let path = settings.ledger.display();
    let ledger = match Ledger::open_existing(&settings.ledger).await {
        Ok(ledger) => ledger,
        Err(LedgerError::Missing { .. }) => {
            return match farm::lost_ledger(settings) {
                Some(detail) => report.problem(WHAT, detail, farm::Attention::LedgerLost.remedy()),
                None => report.ok(WHAT, format!("{path} will be made by the daemon")),
            };
        }
        Err(error @ LedgerError::OlderSchema { .. }) => return report.note(WHAT, error.to_string()),
        Err(error) => {
            let remedy = "keep the file; if it is damaged, put back a copy together with its -wal file";
            return report.problem(WHAT, in_full(&error), remedy);
        }
    };
    if let Err(error) = look_at_rows(&ledger, settings, report).await {
        report.problem(WHAT, format!("cannot be read: {}", in_full(&error)), "check the disk; keep the file");
    }
    ledger.close().await;
}

async fn look_at_rows(ledger: &Ledger, settings: &Settings, report: &mut Report) -> Result<(), LedgerError> {
    let faults = ledger.faults().await?;
    for fault in &faults {
        report.problem(
            WHAT,
            format!("does not hold together: {fault}"),
            "keep the file and report it to nestd's makers",
        );
    }
    if faults.is_empty() {
        report.ok(WHAT, format!("{}, schema is current, rows hold together", settings.ledger.display()));
    }
    match ledger.daemon().await? {
        Some(daemon) if daemon.alive => {
            report.ok("daemon", format!("runs as process {} on {}", daemon.pid, daemon.host))
        }
        _ => {
            report.note("daemon", "does not run");
            look_at_claims(ledger, settings, report).await;
        }
    }
    look_at_folders(ledger, settings, report).await;
    for status in ledger.status().await? {
        let parts = status.claimed_parts + status.waiting_parts;
        if parts > 0 && !settings.profiles.contains_key(&status.profile) {
            let text = format!(
                "{} for {}, which has no file in profiles/",
                counted(parts, "part waits", "parts wait"),
                status.profile
            );
            report.problem("configuration", text, "put its file back, or cancel the parts");
        }
    }
    for build in ledger.builds_in_state(BuildState::Verified).await? {
        if let Some(profile) = settings.profiles.get(&build.profile) {
            staged_in_this_queue(&build, profile, report);
        }
    }
    Ok(())
}

/// What the folders tell and the ledger does not know, and folders that cannot tell.
async fn look_at_folders(ledger: &Ledger, settings: &Settings, report: &mut Report) {
    match farm::unknown_to_ledger(settings, ledger).await {
        Ok((unknown, away)) => {
            for what in unknown {
                let text = format!("does not know {what}, of which the folders tell: it is older than they are");
                report.problem(WHAT, text, farm::Attention::LedgerBehind.remedy());
            }
            for folder in away {
                let text = format!("{} cannot be looked at: {}", folder.folder.display(), folder.why);
                report.problem(WHAT, text, "mount it again, and let nestd's user read it");
            }
        }
        Err(error) => report.problem(WHAT, format!("cannot be compared with the folders: {error:#}"), "check the disk"),
    }
}

/// Files that were taken from a hot folder, and nobody works on.
async fn look_at_claims(ledger: &Ledger, settings: &Settings, report: &mut Report) {
    match farm::left_claims(settings, ledger).await {
        Ok(left) => left.iter().for_each(|claim| {
            let text = format!("{} was taken from the hot folder and the ledger does not know it", claim.display());
            let remedy = "start the daemon, which takes or gives back what lies there; what another nestd left, take over \
                          with nestd adopt PROFILE";
            report.problem("claims", text, remedy);
        }),
        Err(error) => report.problem("claims", format!("cannot be looked at: {error:#}"), "mount the folder again"),
    }
}

/// A build is staged in one queue folder; published from another it would be printed twice or never.
fn staged_in_this_queue(build: &BuildRow, profile: &Profile, report: &mut Report) {
    let queue = &profile.folders.queue;
    let marker = fs::read_to_string(queue.join(QUEUE_MARKER)).ok().map(|text| text.trim().to_owned());
    if build.staged.queue_id.is_some() && marker != build.staged.queue_id {
        let text = format!("{} is not the folder in which build {} was staged", queue.display(), build.id);
        report.problem(
            &format!("queue of {}", profile.name),
            text,
            "mount or configure that folder again before the daemon runs",
        );
    }
}

/// An error with its sources.
fn in_full(error: &LedgerError) -> String {
    let mut text = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(error) = source {
        text = format!("{text}: {error}");
        source = error.source();
    }
    text
}
