//! Checks the ledger: it can be opened, its schema is current, its rows are consistent, and the queue folders are those
//! that it knows.

use anyhow::{Context, Result};
use ledger::{BuildRow, BuildState, Ledger, LedgerError};
use settings::{MachineProfile, PrinterRules, Settings};

use super::{other_machines::OtherMachines, report::CheckReport};

const SUBJECT: &str = "ledger";
const RESTORE: &str = "put a backup back with `nestd restore FILE`";

/// Checks the ledger without changing it.
pub fn check_ledger(settings: &Settings, others: &OtherMachines, report: &mut CheckReport) -> Result<()> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().context("starting to read the ledger")?;
    runtime.block_on(open_and_check(settings, others, report));
    Ok(())
}

async fn open_and_check(settings: &Settings, others: &OtherMachines, report: &mut CheckReport) {
    let path = &settings.ledger;
    let ledger = match Ledger::open_existing(&settings.ledger).await {
        Ok(ledger) => ledger,
        Err(LedgerError::Missing { .. }) => {
            return match farm::lost_ledger(settings) {
                Some(detail) => report.add_problem(SUBJECT, detail, farm::AlertKind::LedgerLost.remedy()),
                None => report.add_ok(SUBJECT, format!("{path} will be made by the daemon")),
            };
        }
        Err(error @ LedgerError::OlderSchema { .. }) => return report.add_note(SUBJECT, error.to_string()),
        Err(error @ (LedgerError::Damaged { .. } | LedgerError::Overwritten { .. })) => {
            return report.add_problem(SUBJECT, error_chain(&error), RESTORE);
        }
        Err(error) => {
            let remedy = "keep the file; if it is damaged, put back a copy together with its -wal file";
            return report.add_problem(SUBJECT, error_chain(&error), remedy);
        }
    };
    // A ledger that the daemon would not open is not compared: what would be said of it could not be followed.
    let is_served = ledger.is_served().await.unwrap_or(true);
    if !is_served && let Err(error @ LedgerError::Damaged { .. }) = Ledger::check_files(&settings.ledger).await {
        report.add_problem(SUBJECT, error_chain(&error), RESTORE);
        return ledger.close().await;
    }
    if let Err(error) = check_rows(&ledger, (settings, others), report).await {
        report.add_problem(
            SUBJECT,
            format!("cannot be read: {}", error_chain(&error)),
            "check the disk; keep the file",
        );
    }
    ledger.close().await;
}

async fn check_rows(
    ledger: &Ledger,
    (settings, others): (&Settings, &OtherMachines),
    report: &mut CheckReport,
) -> Result<(), LedgerError> {
    let faults = ledger.find_inconsistencies().await?;
    for fault in &faults {
        report.add_problem(
            SUBJECT,
            format!("does not hold together: {fault}"),
            "keep the file and report it to nestd's makers",
        );
    }
    if faults.is_empty() {
        report.add_ok(SUBJECT, format!("{}, schema is current, rows hold together", settings.ledger));
    }
    check_daemon(ledger, settings, report).await?;
    check_people(ledger, settings, report).await?;
    compare_with_folders(ledger, settings, report).await;
    others.check_waiting_parts(ledger, settings, report).await?;
    for build in ledger.builds_in_state(BuildState::Verified).await? {
        if let Some(profile) = settings.profiles.get(&build.machine) {
            check_staging_queue(&build, profile, report);
        }
    }
    Ok(())
}

/// Reports a dashboard on which nobody can sign in.
async fn check_people(ledger: &Ledger, settings: &Settings, report: &mut CheckReport) -> Result<(), LedgerError> {
    let signs_in = settings.interfaces.web.as_ref().is_some_and(|web| web.sign_in);
    if signs_in && !ledger.has_people().await? {
        let remedy = "add yourself with `nestd people add NAME --role admin`";
        report.add_problem("people", "web.sign_in is set, and there is nobody who could sign in", remedy);
    }
    Ok(())
}

/// Reports what keeps the daemon from its work, and all that it says itself needs a person.
async fn check_daemon(ledger: &Ledger, settings: &Settings, report: &mut CheckReport) -> Result<(), LedgerError> {
    let daemon = ledger.find_node(&settings.node.name).await?.filter(|daemon| daemon.alive);
    let is_running = daemon.is_some() || ledger.is_served_by(&settings.node.name).await?;
    let told = if is_running { farm::read_stored_alerts(&settings.state_dir) } else { Vec::new() };
    let is_cut_off = told.iter().any(|told| told.kind.cuts_ledger_off());
    let locked_by = ledger.locked_by().await?.filter(|_| !is_cut_off);
    if let Some(by) = &locked_by {
        let text = format!("{by} keeps it from being changed");
        report.add_problem(SUBJECT, text, farm::AlertKind::LedgerLocked.remedy());
    }
    match daemon {
        Some(daemon) => report.add_ok("daemon", format!("runs as process {} on {}", daemon.pid, daemon.host)),
        None if is_running => {
            let text = "runs, but could not write into the ledger since it was started";
            match is_cut_off || locked_by.is_some() {
                true => report.add_note("daemon", text),
                false => {
                    report.add_problem("daemon", text, format!("{}. Its log says more", ledger.silence_hint().await?))
                }
            }
        }
        None => {
            report.add_note("daemon", "does not run");
            check_left_claims(ledger, settings, report).await;
        }
    }
    for told in told {
        let (text, remedy) = (told.alert_text().trim_end_matches('.').to_owned(), told.kind.remedy());
        match told.kind.is_usual_work() {
            true => report.add_warning("alert", text, remedy),
            false => report.add_problem("alert", text, remedy),
        }
    }
    Ok(())
}

/// Reports files in the folders that the ledger does not know, and folders that cannot be read.
async fn compare_with_folders(ledger: &Ledger, settings: &Settings, report: &mut CheckReport) {
    match farm::unknown_to_ledger(settings, ledger).await {
        Ok((unknown, away)) => {
            for what in unknown {
                let text = format!("does not know {what}, which the folders show: the ledger is older than they are");
                report.add_problem(SUBJECT, text, farm::AlertKind::LedgerBehind.remedy());
            }
            for folder in away {
                let text = format!("{} cannot be looked at: {}", folder.folder.display(), folder.why);
                let remedy = match folder.is_served_by_other {
                    true => "let one farm alone serve it",
                    false => "mount it again, and let nestd's user read it",
                };
                report.add_problem(SUBJECT, text, remedy);
            }
        }
        Err(error) => {
            report.add_problem(SUBJECT, format!("cannot be compared with the folders: {error:#}"), "check the disk")
        }
    }
}

/// Reports claimed files that the ledger does not know: no daemon works on them.
async fn check_left_claims(ledger: &Ledger, settings: &Settings, report: &mut CheckReport) {
    match farm::find_abandoned_claims(settings, ledger).await {
        Ok(left) => left.iter().for_each(|claim| {
            let text = format!("{} was taken from the hot folder and the ledger does not know it", claim.display());
            let remedy = "start the daemon, which takes or gives back what lies there; what another nestd left, take over \
                          with nestd adopt MACHINE";
            report.add_problem("claims", text, remedy);
        }),
        Err(error) => report.add_problem("claims", format!("cannot be looked at: {error:#}"), "mount the folder again"),
    }
}

/// Checks that a staged build's queue folder is the one configured now. Published from another folder, the build would
/// be printed twice or never.
fn check_staging_queue(build: &BuildRow, profile: &MachineProfile, report: &mut CheckReport) {
    let was_staged = |printer: &PrinterRules| {
        printer.queue.find().is_some_and(|queue| Some(queue.id()) == build.staged.queue_id.as_deref())
    };
    if build.staged.queue_id.is_some() && !profile.printers.iter().any(was_staged) {
        let assigned = profile.printers.iter().find(|printer| Some(&printer.name) == build.place.printer.as_ref());
        let Some(printer) = assigned.or(profile.printers.first()) else { return };
        let text = format!("{} is not the folder in which build {} was staged", printer.queue, build.id);
        report.add_problem(
            &profile.queue_description(printer),
            text,
            "mount or configure that folder again before the daemon runs",
        );
    }
}

/// The text of an error with all its sources.
fn error_chain(error: &LedgerError) -> String {
    let mut text = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(error) = source {
        text = format!("{text}: {error}");
        source = error.source();
    }
    text
}
