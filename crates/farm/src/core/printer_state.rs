//! The printers of an active machine: the queue of each, whether it is open, and whether a person took the printer
//! out of use.

use std::time::Instant;

use delivery::queue::{OpenQueue, QueueAddress};
use ledger::{BuildRow, DownPrinter};
use settings::MachineProfile;

use crate::records::ledger_freshness::FolderIdentities;

/// A printer of an active machine.
#[derive(Debug)]
pub struct PrinterState {
    /// Its name.
    pub name: String,
    /// Where its queue is.
    pub address: QueueAddress,
    /// The open queue; `None` until it could be opened.
    pub opened: Option<OpenQueue>,
    /// A queue that could not be opened is not tried again before this time.
    pub open_at: Instant,
    /// Since when and why it takes no builds; `None` = it is in use.
    pub down: Option<DownPrinter>,
}

/// All printers of a machine, in the order of its file.
#[derive(Debug)]
pub struct MachinePrinters(pub Vec<PrinterState>);

impl MachinePrinters {
    /// Printers whose folders are not open yet.
    pub fn new(profile: &MachineProfile, now: Instant) -> Self {
        let state = |rules: &settings::PrinterRules| PrinterState {
            name: rules.name.clone(),
            address: rules.queue.clone(),
            opened: None,
            open_at: now,
            down: None,
        };
        Self(profile.printers.iter().map(state).collect())
    }

    /// The printer with this name.
    pub fn find(&self, name: &str) -> Option<&PrinterState> {
        self.0.iter().find(|printer| printer.name == name)
    }

    /// The open queues, by the names of their printers.
    pub fn open_queues(&self) -> Vec<(String, OpenQueue)> {
        self.0.iter().filter_map(|printer| Some((printer.name.clone(), printer.opened.clone()?))).collect()
    }

    /// The open queue that has this id.
    pub fn queue_with_id(&self, id: Option<&str>) -> Option<OpenQueue> {
        let mut queues = self.0.iter().filter_map(|printer| printer.opened.as_ref());
        queues.find(|queue| Some(queue.id()) == id).cloned()
    }

    /// Whether a queue folder is open.
    pub fn has_open_queue(&self) -> bool {
        self.0.iter().any(|printer| printer.opened.is_some())
    }

    /// Whether every queue folder is open.
    pub fn are_all_open(&self) -> bool {
        self.0.iter().all(|printer| printer.opened.is_some())
    }

    /// Whether a person took all printers out of use.
    pub fn are_all_down(&self) -> bool {
        self.0.iter().all(|printer| printer.down.is_some())
    }

    /// The printer that a build is staged or published at: that of the queue folder where its file was staged. Where that
    /// folder is not open, the printer that it was made for; else the first.
    pub fn of_build(&self, build: &BuildRow) -> Option<&PrinterState> {
        let staged = build.staged.queue_id.as_deref();
        let is_staged_at =
            |printer: &&PrinterState| staged.is_some() && printer.opened.as_ref().map(|queue| queue.id()) == staged;
        let by_name = || build.place.printer.as_deref().and_then(|name| self.find(name));
        self.0.iter().find(is_staged_at).or_else(by_name).or_else(|| self.0.first())
    }

    /// The printers that can be given a build now: not down, and their folders are open and agree with the ledger.
    pub fn usable<'a>(&'a self, agreed: &'a FolderIdentities) -> impl Iterator<Item = &'a PrinterState> {
        self.0
            .iter()
            .filter(|printer| printer.down.is_none() && printer.opened.is_some() && agreed.has_queue(&printer.address))
    }

    /// Closes queues: they are opened anew.
    pub fn close_queues(&mut self, is_meant: impl Fn(&QueueAddress) -> bool) {
        self.0.iter_mut().filter(|printer| is_meant(&printer.address)).for_each(|printer| printer.opened = None);
    }
}

/// What alerts on a printer's queue folder are about; "" = the only one of its machine.
pub fn alert_subject(machine: &str, printer: &str) -> String {
    if printer == machine { String::new() } else { format!("printer {printer}") }
}
