//! `nestd check --deep`: reads every file that nestd keeps and compares it with the ledger.

use std::{path::PathBuf, time::Duration};

use anyhow::{Context, Result};
use build_file::format_count;
use farm::{InvariantExpectations, InvariantReport};
use ledger::{Ledger, LedgerError};
use settings::Settings;

use super::report::CheckReport;

const SUBJECT: &str = "invariants";
/// A running daemon moves files during the check. Only a violation that is found twice, with this delay between,
/// counts.
const RECHECK_DELAY: Duration = Duration::from_secs(3);

/// Checks all invariants without changing anything.
pub fn check_invariants(settings: &Settings, report: &mut CheckReport) -> Result<()> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().context("starting to read the ledger")?;
    let invariant_report = runtime.block_on(async {
        let ledger = match Ledger::open_existing(&settings.ledger).await {
            Ok(ledger) => ledger,
            // The ordinary check has reported this, with its remedy.
            Err(LedgerError::Missing { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let whole = match ledger.is_served().await? {
            true => Ok(false),
            false => Ledger::check_files(&settings.ledger).await,
        };
        let invariant_report = match whole {
            Ok(true) => check_twice(settings, &ledger).await,
            Ok(false) => match ledger.check_integrity().await {
                Ok(()) => check_twice(settings, &ledger).await,
                Err(error) => Err(error.into()),
            },
            Err(error) => Err(error.into()),
        };
        ledger.close().await;
        invariant_report.map(Some)
    });
    match invariant_report {
        Ok(Some(invariant_report)) => report_violations(&invariant_report, report),
        Ok(None) => report.add_note(SUBJECT, "there is no ledger yet: nothing to compare with"),
        Err(error) => report.add_problem(SUBJECT, format!("cannot be looked at: {error:#}"), "mend the ledger first"),
    }
    Ok(())
}

/// Updates the ledger from the contents of the folders.
pub fn repair_ledger(settings: &Settings, new_folders: &[PathBuf], report: &mut CheckReport) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("starting to repair")?;
    match runtime.block_on(farm::repair_ledger(settings, new_folders)) {
        Ok(reconciled) => super::super::backup::reconciliation_lines(&reconciled)
            .into_iter()
            .for_each(|line| report.add_note("repair", line)),
        Err(error) => report.add_problem("repair", format!("{error:#}"), "see to that, and run it again"),
    }
    Ok(())
}

async fn check_twice(settings: &Settings, ledger: &Ledger) -> Result<InvariantReport> {
    let mut invariant_report = farm::check_invariants(settings, ledger, &InvariantExpectations::default()).await?;
    if !invariant_report.violations.is_empty() && ledger.is_served().await? {
        tokio::time::sleep(RECHECK_DELAY).await;
        let again = farm::check_invariants(settings, ledger, &InvariantExpectations::default()).await?;
        invariant_report.violations.retain(|violation| again.violations.contains(violation));
    }
    Ok(invariant_report)
}

fn report_violations(invariant_report: &InvariantReport, report: &mut CheckReport) {
    for violation in &invariant_report.violations {
        let text = format!("{:?}: {}", violation.invariant, violation.text);
        match violation.may_be_manual {
            true => report.add_warning(SUBJECT, text, violation.remedy.clone()),
            false => report.add_problem(SUBJECT, text, violation.remedy.clone()),
        }
    }
    if invariant_report.violations.is_empty() {
        report.add_ok(SUBJECT, {
            let (files, builds) = (
                format_count(invariant_report.files_read, "file", "files"),
                format_count(invariant_report.builds_checked, "build", "builds"),
            );
            format!("I1 to I5 hold: {files} and {builds} read")
        });
    }
}
