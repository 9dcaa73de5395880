//! Checks the invariants from the outside: in the ledger, in the folders and in the contents of the files. Changes
//! nothing.
//!
//! - I1: every file that ever left the hot folder is in exactly one of work, store, error and archive, and is
//!   byte-identical.
//! - I2: each copy of a part is in at most one published build where it is not told bad, and in exactly one once its
//!   batch is done.
//! - I3: a build file that is visible in a queue folder is complete, proved, and has its row.
//! - I4: the daemon deletes nothing but its own temporary files and what is past its retention; a kept copy of a build
//!   file has the bytes that were proved.
//! - I5: for each line of each order, copies wanted = waiting + in builds whose print is not told bad + told good, +
//!   refused; no copy leaves that sum without an event. Where somebody beside the ledger wrote down what was asked, the
//!   copies in the build files themselves are held against that.

mod builds;
mod files;
mod folders;
mod orders;
mod report;

use anyhow::{Context, Result};

use ledger::{Ledger, RuleScope};
pub use report::{AskedCopies, Invariant, InvariantExpectations, InvariantReport, InvariantViolation};

use settings::Settings;

use crate::leases::own_machines::without_other_nodes;

/// Looks for violations of I1 to I5. While a daemon works on the farm, a file may be seen between two places: a
/// violation is certain only if a second check finds it too.
pub async fn check_invariants(
    settings: &Settings,
    ledger: &Ledger,
    witness: &InvariantExpectations,
) -> Result<InvariantReport> {
    let settings = &without_other_nodes(settings, ledger).await?;
    let mut report = InvariantReport::default();
    for (scope, invariant) in [(RuleScope::Places, Invariant::I2), (RuleScope::OrderSums, Invariant::I5)] {
        let faults = ledger.find_inconsistencies_of(scope).await;
        for fault in faults.context("asking the ledger whether it holds together")? {
            report.add_violation(invariant, format!("the ledger does not hold together: {fault}"), LEDGER_BROKEN);
        }
    }
    let folders = folders::FolderContents::read_all(settings, witness, ledger, &mut report).await?;
    files::check_live_and_refused_parts(settings, ledger, &folders, witness, &mut report).await?;
    files::check_archived_originals(settings, ledger, &mut report).await?;
    files::check_open_claims(ledger, &folders, witness, &mut report).await?;
    files::check_dropped_files(ledger, &folders, witness, &mut report).await?;
    files::check_foreign_files(witness, &mut report);
    builds::check_visible_builds(settings, ledger, witness, &mut report).await?;
    builds::check_kept_builds(settings, ledger, &mut report).await?;
    orders::check_asked_copies(settings, ledger, witness, &mut report).await?;
    check_ledger_knows_folders(settings, ledger, &mut report).await?;
    Ok(report)
}

/// Reports what the folders hold and the ledger does not know.
async fn check_ledger_knows_folders(settings: &Settings, ledger: &Ledger, report: &mut InvariantReport) -> Result<()> {
    let (unknown, away) = super::ledger_freshness::find_unknown_to_ledger(settings, ledger).await?;
    for what in unknown {
        let text = format!("the folders tell of {what}, and the ledger does not know it");
        report.add_violation(Invariant::I1, text, crate::AlertKind::LedgerBehind.remedy());
    }
    for away in away {
        let text = format!("{} cannot be looked at ({})", away.folder.display(), away.why);
        let remedy = match away.is_served_by_other {
            true => "let one farm alone serve it",
            false => "mount it again, let nestd's user read it, and look once more",
        };
        report.add_violation(Invariant::I1, text, remedy);
    }
    Ok(())
}

const LEDGER_BROKEN: &str = "stop the daemon, put the last backup of the ledger back and report this to nestd's makers";
