//! `nestd check --deep`: reads every file that nestd keeps and holds it against the ledger.

use std::{path::PathBuf, time::Duration};

use anyhow::{Context, Result};
use build_file::counted;

use super::report::Report;
use crate::{
    farm::{self, Looked, Witness},
    ledger::{Ledger, LedgerError},
    settings::Settings,
};

const WHAT: &str = "invariants";
/// A daemon at work moves files while they are looked for: what is missing twice with this pause between is missing.
const LOOK_AGAIN: Duration = Duration::from_secs(3);

/// Looks at all invariants without changing anything.
pub fn look(settings: &Settings, report: &mut Report) -> Result<()> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().context("starting to read the ledger")?;
    let looked = runtime.block_on(async {
        let ledger = match Ledger::open_existing(&settings.ledger).await {
            Ok(ledger) => ledger,
            // The ordinary check has said so, with its remedy.
            Err(LedgerError::Missing { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let whole = match ledger.daemon().await?.is_some_and(|daemon| daemon.alive) {
            true => Ok(false),
            false => Ledger::look_at_files(&settings.ledger).await,
        };
        let looked = match whole {
            Ok(true) => look_twice(settings, &ledger).await,
            Ok(false) => match ledger.check_whole().await {
                Ok(()) => look_twice(settings, &ledger).await,
                Err(error) => Err(error.into()),
            },
            Err(error) => Err(error.into()),
        };
        ledger.close().await;
        looked.map(Some)
    });
    match looked {
        Ok(Some(looked)) => tell(&looked, report),
        Ok(None) => report.note(WHAT, "there is no ledger yet: nothing to compare with"),
        Err(error) => report.problem(WHAT, format!("cannot be looked at: {error:#}"), "mend the ledger first"),
    }
    Ok(())
}

/// Takes into the ledger what the folders tell.
pub fn repair(settings: &Settings, new_folders: &[PathBuf], report: &mut Report) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("starting to repair")?;
    match runtime.block_on(farm::repair(settings, new_folders)) {
        Ok(reconciled) => {
            super::super::backup::tell(&reconciled).into_iter().for_each(|line| report.note("repair", line))
        }
        Err(error) => report.problem("repair", format!("{error:#}"), "see to that, and run it again"),
    }
    Ok(())
}

async fn look_twice(settings: &Settings, ledger: &Ledger) -> Result<Looked> {
    let mut looked = farm::invariants(settings, ledger, &Witness::default()).await?;
    if !looked.violations.is_empty() && ledger.daemon().await?.is_some_and(|daemon| daemon.alive) {
        tokio::time::sleep(LOOK_AGAIN).await;
        let again = farm::invariants(settings, ledger, &Witness::default()).await?;
        looked.violations.retain(|violation| again.violations.contains(violation));
    }
    Ok(looked)
}

fn tell(looked: &Looked, report: &mut Report) {
    for violation in &looked.violations {
        let text = format!("{:?}: {}", violation.invariant, violation.text);
        match violation.by_people {
            true => report.warning(WHAT, text, violation.remedy.clone()),
            false => report.problem(WHAT, text, violation.remedy.clone()),
        }
    }
    if looked.violations.is_empty() {
        report.ok(WHAT, {
            let (files, builds) = (counted(looked.files, "file", "files"), counted(looked.builds, "build", "builds"));
            format!("I1 to I4 hold: {files} and {builds} read")
        });
    }
}
