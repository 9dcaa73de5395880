//! The printers of the machines: which of them people took out of use, and which one a build is made for.

use anyhow::Result;
use build_file::format_count;
use jiff::Timestamp;
use ledger::{BuildRow, DownPrinter, Ledger, LedgerError, OccupyingBuild, UtcTimestamp, WaitingPart};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    farm::{
        core::{
            machine_state::{MachineState, MachineStates},
            printer_state::PrinterState,
        },
        decisions::{
            print_times::PrintTimes,
            printer_choice::{PrinterLoad, choose_printer, printer_loads},
            printer_outlook::PrinterOutlook,
            queue_depth::queue_room,
        },
        scanning::machine_fit::find_misfit,
    },
    settings::{FarmZone, MachineProfile, PrinterRules},
};

/// What people see of a printer.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PrinterView {
    /// Its name.
    pub printer: String,
    /// Its machine.
    pub machine: String,
    /// Its queue folder.
    pub queue: String,
    /// Since when and why it takes no builds; `None` = it is in use.
    pub down: Option<DownPrinter>,
    /// Builds that are made for it, lie in its queue or are printed, as far as is known.
    pub builds: u32,
    /// Whether its next print could begin now.
    pub is_free: bool,
    /// When its next print could begin, as far as is known, to the minute; `None` = now, or it is down, or no day is open.
    pub free_at: Option<UtcTimestamp>,
    /// Hours of printing per mm of build height.
    pub hours_per_mm: f64,
    /// Hours beside that.
    pub cool_down_hours: f64,
    /// Number of told prints that these were learned from; 0 = they are the settings.
    pub learned_from: u32,
}

/// What people see of the printers of a machine.
///
/// # Errors
/// The ledger cannot be read.
pub async fn printer_views(ledger: &Ledger, profile: &MachineProfile, now: Timestamp) -> Result<Vec<PrinterView>> {
    let (builds, times) = occupation_of(ledger, profile, now).await?;
    let down = ledger.down_printers().await?;
    let loads = printer_loads(profile, &builds, &times, now);
    let view = |rules: &PrinterRules| {
        let down = down.iter().find(|down| down.machine == profile.name && down.printer == rules.name);
        let down = down.cloned();
        let load = loads.get(&rules.name).copied().unwrap_or(PrinterLoad { free_at: now, builds: 0 });
        let is_free = down.is_none() && load.free_at <= now;
        let free_at = Some(load.free_at).filter(|at| down.is_none() && !is_free && *at < Timestamp::MAX);
        PrinterView {
            printer: rules.name.clone(),
            machine: profile.name.clone(),
            queue: rules.queue.to_string(),
            down,
            builds: u32::try_from(load.builds).unwrap_or(u32::MAX),
            is_free,
            free_at: free_at.map(|at| UtcTimestamp(at.round(jiff::Unit::Minute).unwrap_or(at))),
            hours_per_mm: times.hours_per_mm,
            cool_down_hours: times.cool_down_hours,
            learned_from: u32::try_from(times.learned_from).unwrap_or(u32::MAX),
        }
    };
    Ok(profile.printers.iter().map(view).collect())
}

/// What becomes of the builds that lie at a printer that is down, in sentences.
///
/// # Errors
/// The ledger cannot be read.
pub async fn fate_of_queued(ledger: &Ledger, profile: &MachineProfile, printer: &str) -> Result<String, LedgerError> {
    let down = ledger.down_printers().await?;
    let is_up = |other: &&str| !down.iter().any(|down| down.machine == profile.name && down.printer == **other);
    let others = profile.printers.iter().map(|rules| rules.name.as_str()).filter(|other| *other != printer);
    let others: Vec<&str> = others.filter(is_up).collect();
    if others.is_empty() {
        return Ok(format!("The builds of {} wait until a printer of it is up.", profile.name));
    }
    let mut sentences = vec![format!("What it has not taken goes to {}.", others.join(" or "))];
    for build in ledger.builds_to_take_back(&profile.name).await? {
        if build.place.printer.as_deref() == Some(printer)
            && build.place.withdraw_by.is_none()
            && let Some(why) = find_misfit(profile, &build)
        {
            sentences.push(format!("Build {0} goes to no other one, for {why}: `nestd withdraw {0}`.", build.id));
        }
    }
    Ok(sentences.join(" "))
}

/// The printer of a machine that a build is for: the one that was written down, else the first.
pub(super) fn rules_of_build<'p>(profile: &'p MachineProfile, build: &BuildRow) -> Option<&'p PrinterRules> {
    let named = profile.printers.iter().find(|printer| Some(&printer.name) == build.place.printer.as_ref());
    named.or_else(|| profile.printers.first())
}

impl PrinterView {
    /// `0.100 h per mm and 4.0 h, from 12 prints`.
    pub fn times_text(&self) -> String {
        let from = match self.learned_from {
            0 => "as set".to_owned(),
            prints => format!("from {prints} prints"),
        };
        format!("{:.3} h per mm and {:.1} h, {from}", self.hours_per_mm, self.cool_down_hours)
    }

    /// What it does: `2 builds, free from 2026-11-25 14:00 CET`, or since when it is down, and why.
    pub fn state_text(&self, zone: &FarmZone) -> String {
        if let Some(down) = &self.down {
            let why = if down.reason.is_empty() { String::new() } else { format!(": {}", down.reason) };
            return format!("down since {} by {}{why}", zone.format_minute(down.down_at.0), down.told_by);
        }
        let builds = format_count(self.builds, "build", "builds");
        match self.free_at {
            _ if self.is_free => format!("{builds}, free now"),
            Some(at) => format!("{builds}, free from {}", zone.format_minute(at.0)),
            None => format!("{builds}; its calendar is not open again"),
        }
    }
}

/// The lines of `STATUS.txt` on the printers of a machine; none for a machine of one printer that is in use.
pub(crate) fn printer_lines(profile: &MachineProfile, printers: &[PrinterView]) -> Vec<String> {
    let is_shown = profile.has_named_printers() || printers.iter().any(|printer| printer.down.is_some());
    let line =
        |printer: &PrinterView| format!("Printer {}: {}.", printer.printer, printer.state_text(&profile.time_zone));
    if is_shown { printers.iter().map(line).collect() } else { Vec::new() }
}

/// What a machine's prints take, and the builds that occupy its printers.
pub(crate) async fn occupation_of(
    ledger: &Ledger,
    profile: &MachineProfile,
    now: Timestamp,
) -> Result<(Vec<OccupyingBuild>, PrintTimes)> {
    let builds = ledger.occupying_builds(&profile.name, now.into()).await?;
    let told = ledger.told_prints(&profile.name).await?;
    Ok((builds, PrintTimes::learn(profile, &told)))
}

/// What lies ahead of the printers of a machine that can be used. It is read only where something that waits has a due date.
pub(crate) async fn printer_outlook(
    ledger: &Ledger,
    machine: &MachineState,
    waiting: &[WaitingPart],
    now: Timestamp,
) -> Result<PrinterOutlook> {
    let profile = &machine.profile;
    if waiting.iter().all(|waiting| waiting.part.terms.due_at.is_none()) {
        return Ok(PrinterOutlook { printers: Vec::new(), times: PrintTimes::of_settings(profile) });
    }
    let usable = usable_printers(machine);
    let (builds, times) = occupation_of(ledger, profile, now).await?;
    Ok(PrinterOutlook::new(profile, &builds, times, |printer| usable.contains(&printer), now))
}

/// Takes in which printers people took out of use.
pub(crate) async fn update_down_printers(ledger: &Ledger, machines: &mut MachineStates) -> Result<()> {
    let down = ledger.down_printers().await?;
    for (name, machine) in machines {
        for printer in &mut machine.printers.0 {
            printer.down = down.iter().find(|down| down.machine == *name && down.printer == printer.name).cloned();
        }
    }
    Ok(())
}

/// The printer that a build is made for, or moved to, of those that can be used now; `None` = there is none. A build that is
/// being made stays with its printer as long as that can be used.
pub(crate) async fn choose_for_build(
    ledger: &Ledger,
    machines: &MachineStates,
    build: &BuildRow,
    now: Timestamp,
) -> Result<Option<String>> {
    let Some(machine) = machines.get(&build.machine) else { return Ok(None) };
    let usable = usable_printers(machine);
    if let (None, Some(printer)) = (build.times.published_at, &build.place.printer)
        && usable.contains(&printer.as_str())
    {
        return Ok(Some(printer.clone()));
    }
    if usable.len() < 2 {
        return Ok(usable.first().map(|&name| name.to_owned()));
    }
    let (builds, times) = occupation_of(ledger, &machine.profile, now).await?;
    // A build that fired while there was room goes where it is.
    let depth = machine.profile.printing.queue_depth;
    let ahead = if depth > 0 { ledger.builds_ahead(&build.machine).await? } else { Vec::new() };
    let has_room = |printer: &&&str| queue_room(depth, printer, &ahead) > 0;
    let with_room: Vec<&str> = usable.iter().filter(has_room).copied().collect();
    let usable = if with_room.is_empty() { usable } else { with_room };
    Ok(choose_printer(&machine.profile, &usable, (build.id, &builds), &times, now).map(str::to_owned))
}

/// The names of the printers of a machine that can be given a build now.
pub(crate) fn usable_printers(machine: &MachineState) -> Vec<&str> {
    match &machine.agreed_folders {
        Some(agreed) if machine.leases.are_fresh() => {
            let usable = machine.printers.usable(agreed);
            let can_publish = |printer: &&PrinterState| machine.leases.can_publish(&printer.address);
            usable.filter(can_publish).map(|printer| printer.name.as_str()).collect()
        }
        _ => Vec::new(),
    }
}
