//! Scans of hot folders: a job looks and claims, and the event loop takes in what it found.

use std::time::Duration;

use anyhow::Result;
use build_file::format_count;
use jobs::{BackgroundJob, Carried};
use ledger::UtcTimestamp;
use tracing::warn;

use super::{
    control_files,
    intake_jobs::{record_all, record_claimed_file},
    late_tickets,
};
use crate::{
    alerts::alert::AlertKind,
    core::{
        desks::{Receiving, Serving},
        farm::Farm,
        machine_state::MachineState,
    },
    scanning::{
        arriving_lines::ArrivingLines,
        hot_folder_scan::{ClaimedDrop, HotFolderScan, RefusedFile},
        hot_folder_scanner::HotFolderScanner,
        ready_files::unpack_archives,
    },
};

/// Delay of a scan after a file-system event, so that a burst of events causes one scan.
const SCAN_DELAY_AFTER_EVENT: Duration = Duration::from_millis(200);

/// Scans a machine's hot folder.
#[derive(Clone)]
pub(crate) struct HotFolderScanJob {
    machine: String,
}

impl BackgroundJob<Farm> for HotFolderScanJob {
    const KIND: &'static str = "Scan";
    const IS_LOOK: bool = true;
    type Outcome = HotFolderScan;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, scan: Self::Outcome) -> Result<()> {
        on_scan_done(&mut desk, &self.machine, scan).await;
        Ok(())
    }

    async fn on_panic(self, desk: Self::Desk<'_>, _message: &str) -> Result<()> {
        // Nobody knows what it remembers: the next one lists the claims again.
        if let Some(machine) = desk.machines.get_mut(&self.machine) {
            let (orphan_secs, time) = (desk.shared.settings.orphan_ticket_secs, desk.shared.schedule.time.clone());
            machine.inbox.scanner = Some(Box::new(HotFolderScanner::new(&machine.profile, orphan_secs, time)));
        }
        Ok(())
    }
}

/// The scanner of a hot folder, with its memory.
struct CarriedScanner {
    machine: String,
    scanner: Box<HotFolderScanner>,
}

impl Carried<Farm> for CarriedScanner {
    type Desk<'f> = Serving<'f>;

    fn give_back(self, desk: Self::Desk<'_>) {
        let (now, scan_secs) = (desk.shared.now(), desk.shared.settings.scan_secs);
        // After a reload, the machine may have another hot folder, and another scanner.
        let is_same = |machine: &&mut MachineState| self.scanner.is_for_machine(&machine.profile);
        if let Some(machine) = desk.machines.get_mut(&self.machine).filter(is_same) {
            machine.inbox.scanner = Some(self.scanner);
            machine.inbox.next_scan_at = now + Duration::from_secs_f64(scan_secs);
        }
    }
}

/// Something changed: schedules a scan soon.
pub(crate) fn schedule_scan(desk: &mut Serving<'_>) {
    let soon = desk.shared.now() + SCAN_DELAY_AFTER_EVENT;
    desk.machines.values_mut().for_each(|s| s.inbox.next_scan_at = s.inbox.next_scan_at.min(soon));
}

/// Starts a scan of every hot folder that is due.
pub(crate) fn start_scans(desk: &mut Receiving<'_>) {
    let (now, orphan_secs) = (desk.shared.now(), desk.shared.settings.orphan_ticket_secs);
    for (name, machine) in desk.machines.iter_mut() {
        if !machine.may_claim
            || !machine.leases.are_fresh()
            || now < machine.inbox.next_scan_at
            || desk.jobs.is_running::<HotFolderScanJob>(name)
        {
            continue;
        }
        let Some(mut scanner) = machine.inbox.scanner.take() else { continue };
        if std::mem::take(&mut machine.inbox.relist) {
            scanner.relist_claims();
        }
        let (profile, store) = (machine.profile.clone(), desk.meshes.store.clone());
        let mut leases = machine.leases.clone();
        let (name, status) = (name.clone(), machine.status_files(desk.shared.alerts, desk.shared.settings));
        let (ledger, runtime) = (desk.shared.ledger.clone(), tokio::runtime::Handle::current());
        let (awaits_lines, settings) = (machine.inbox.arriving.is_some(), desk.shared.settings.clone());
        let limits = desk.shared.settings.limits.clone();
        let carried = CarriedScanner { machine: name.clone(), scanner };
        let language = desk.shared.settings.language;
        desk.jobs.start_with(HotFolderScanJob { machine: name }, carried, move |CarriedScanner { scanner, .. }| {
            let find_part = |part| runtime.block_on(ledger.find_part(part));
            let ordered = match awaits_lines {
                true => runtime.block_on(ArrivingLines::read_from(&ledger, &profile.name, &settings)),
                false => ArrivingLines::none(&settings),
            };
            // What it refuses gets its reason beside it.
            let mut scan = language.within(|| {
                let mut scan = scanner.scan_and_claim(&profile, &mut leases, &store, orphan_secs, &ordered, find_part);
                unpack_archives(&profile, &limits, &mut scan);
                scan
            });
            // The status is not written into an empty mount point that has replaced the folder meanwhile.
            if status.1.is_empty() || scan.unavailable.is_some() || leases.inbox.check_usable().is_err() {
                return scan;
            }
            if let Err(failure) = intake::write_status(&profile.folders.inbox, &status.0, &status.1) {
                scan.warnings.push(format!("writing STATUS.txt: {failure}"));
            }
            scan
        });
    }
}

/// Takes in a scan: each claimed file gets its row, and is read later. What cannot be taken in now is found or told
/// again at the next scan, and holds up nothing else.
async fn on_scan_done(desk: &mut Receiving<'_>, name: &str, mut scan: HotFolderScan) {
    let (early, drops): (Vec<ClaimedDrop>, Vec<ClaimedDrop>) = std::mem::take(&mut scan.drops)
        .into_iter()
        .partition(|drop| desk.completion.forgetting.is_under_way(&drop.stored.hash));
    for drop in early {
        // Its stored copy is being removed, for it was an earlier part's: the next look copies it in again.
        with_scanner(desk, name, |scanner| scanner.retry_claim(drop.claim));
        scan.next_secs = Some(0.0);
    }
    let recorded = record_all(desk, name, &drops).await;
    if let Err(failure) = control_files::obey_controls(desk, name, std::mem::take(&mut scan.controls)).await {
        desk.shared.report_failure(AlertKind::TakingFails, name, "obeying a control file", &failure);
    }
    let mut are_all_recorded = true;
    for (at, drop) in drops.into_iter().enumerate() {
        if let Err(failure) = record_claimed_file(desk, name, &drop, recorded.get(at).copied()).await {
            are_all_recorded = false;
            desk.shared.report_failure(AlertKind::TakingFails, name, "recording a drop", &failure);
            with_scanner(desk, name, |scanner| scanner.retry_claim(drop.claim));
        }
    }
    take_late_tickets(desk, name, are_all_recorded, &mut scan).await;
    tell_of_scan(desk, name, &scan);
    if let Some(machine) = desk.machines.get_mut(name) {
        for file in &scan.refused {
            warn!(machine = %name, "Refused {} in {name}: {}", file.name, file.reason);
        }
        machine.inbox.unrecorded_refusals.append(&mut scan.refused);
    }
    if let Err(failure) = record_refusals(desk, name).await {
        desk.shared.report_failure(AlertKind::TakingFails, name, "recording a refusal", &failure);
    }
}

/// Applies the late tickets of a scan. While a drop of it could not be recorded, nobody knows whether that is the part that one of them
/// is for.
async fn take_late_tickets(desk: &mut Receiving<'_>, name: &str, are_all_recorded: bool, scan: &mut HotFolderScan) {
    let keys = match are_all_recorded {
        true => match late_tickets::apply_late_tickets(desk, name, scan).await {
            Ok(keys) => keys,
            Err((keys, failure)) => {
                desk.shared.report_failure(AlertKind::TakingFails, name, "applying a late ticket", &failure);
                keys
            }
        },
        false => {
            // What was told of them stays.
            scan.is_truncated |= !scan.late_tickets.is_empty();
            std::mem::take(&mut scan.late_tickets).into_iter().map(|late| late.key).collect()
        }
    };
    with_scanner(desk, name, |scanner| keys.iter().for_each(|key| scanner.offer_again(key)));
}

/// The scanner of a machine, unless it has another hot folder by now.
fn with_scanner(desk: &mut Receiving<'_>, name: &str, then: impl FnOnce(&mut HotFolderScanner)) {
    if let Some(scanner) = desk.machines.get_mut(name).and_then(|machine| machine.inbox.scanner.as_mut()) {
        then(scanner);
    }
}

/// Alerts and times that follow from a scan.
fn tell_of_scan(desk: &mut Receiving<'_>, name: &str, scan: &HotFolderScan) {
    let (now, scan_secs) = (desk.shared.now(), desk.shared.settings.scan_secs);
    if let Some(machine) = desk.machines.get_mut(name) {
        let next_secs = scan.next_secs.unwrap_or(scan_secs).clamp(0.05, scan_secs);
        let is_hurried = std::mem::take(&mut machine.inbox.is_hurried);
        machine.inbox.next_scan_at = if is_hurried { now } else { now + Duration::from_secs_f64(next_secs) };
        machine.inbox.refused_file_count = scan.refused_file_count.unwrap_or(machine.inbox.refused_file_count);
        let error_dir = machine.profile.folders.error.display();
        match scan.is_truncated || scan.unavailable.is_some() {
            true => {}
            false if scan.waiting_reasons.is_empty() => desk.shared.alerts.clear(AlertKind::Incomplete, name, ""),
            false => desk.shared.alerts.raise(AlertKind::Incomplete, name, "", &join_first_few(&scan.waiting_reasons)),
        }
        match machine.inbox.refused_file_count {
            0 => desk.shared.alerts.clear(AlertKind::Refused, name, ""),
            files => {
                let detail = format!("{} in {error_dir}", format_count(files, "file", "files"));
                desk.shared.alerts.raise(AlertKind::Refused, name, "", &detail);
            }
        }
    }
    match &scan.unavailable {
        Some(away) if away.is_lease_refused => desk.shared.alerts.clear(AlertKind::HotFolderAway, name, ""),
        Some(away) => desk.shared.alerts.raise(AlertKind::HotFolderAway, name, "", &away.reason),
        None => mark_scanned(desk, name),
    }
    scan.report_faults(name, desk.shared.alerts);
}

/// Writes the events of refused files. Those that fail are written after the next scan.
async fn record_refusals(desk: &mut Receiving<'_>, name: &str) -> Result<()> {
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    while let Some(RefusedFile { name: file, cause, reason }) = machine.inbox.unrecorded_refusals.first() {
        desk.shared.ledger.record_file_refusal(name, *cause, &format!("{file}: {reason}")).await?;
        machine.inbox.unrecorded_refusals.remove(0);
    }
    Ok(())
}

/// A hot folder is available and was scanned.
fn mark_scanned(desk: &mut Receiving<'_>, name: &str) {
    desk.shared.alerts.clear(AlertKind::HotFolderAway, name, "");
    let date = desk.shared.date();
    if let Some(machine) = desk.machines.get_mut(name) {
        machine.inbox.scanned_at = Some(UtcTimestamp(date));
    }
}

/// Joins the first of many texts.
fn join_first_few(held: &[String]) -> String {
    const MOST: usize = 5;
    match held.len() {
        0..=MOST => held.join("; "),
        all => format!("{}; and {} more", held[..MOST].join("; "), all - MOST),
    }
}
