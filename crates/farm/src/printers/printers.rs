//! The printers of the machines: which of them people took out of use, and which one a build is made for.

use anyhow::Result;
use jiff::Timestamp;
use ledger::{BuildRow, Ledger, LedgerError, WaitingPart};
use settings::{MachineProfile, PrinterRules};

use crate::{
    core::{
        machine_state::{MachineState, MachineStates},
        printer_state::PrinterState,
    },
    decisions::{
        print_times::PrintTimes, printer_choice::choose_printer, printer_outlook::PrinterOutlook,
        queue_depth::queue_room,
    },
    planning::{Occupation, read_occupation},
    scanning::machine_fit::find_misfit,
};

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
    let Occupation { builds, times, .. } = read_occupation(ledger, profile, now).await?;
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
    let Occupation { builds, times, .. } = read_occupation(ledger, &machine.profile, now).await?;
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
