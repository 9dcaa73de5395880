//! What a machine does and when it is free: a function of its printers, of what waits for it, and of what the daemon saw of it. Trouble
//! goes first, then what its printers do, then what is made for them; it is free where nothing of all that is so.

use jiff::Timestamp;
use language::say;
use ledger::{BuildId, BuildState, MachineRow, MachineStatus, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::MachineProfile;

use super::printer_fact::{PrinterFact, PrinterWord};
use crate::{
    decisions::fire_forecast::{FireForecast, forecast_fire},
    planning::PlanStage,
};

/// What a machine does, in one word: the first of these that is so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MachineWord {
    /// It takes no parts, or no build can be put into its queue.
    Unavailable,
    /// A person, or a build that failed, has paused it: nothing fires.
    Paused,
    /// All its printers are down.
    Down,
    /// One of its printers prints.
    Printing,
    /// A print of it cools, and is unpacked.
    Cooling,
    /// A print of it should be over, and nobody told how it came out.
    Ended,
    /// A file lies in its queue.
    Queued,
    /// A proved build waits for a person's yes.
    #[serde(rename = "waits for a yes")]
    AwaitsYes,
    /// A build is made: searched, or proved.
    Nesting,
    /// Files are read.
    Reading,
    /// Parts wait for its next build.
    Collecting,
    /// Nothing of all that, and no print begins now on any of its printers.
    #[serde(rename = "closed now")]
    Closed,
    /// Nothing of all that.
    Free,
}

/// What is so of a machine.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MachineFact {
    /// Its name.
    #[serde(skip)]
    pub machine: String,
    /// What it does.
    pub state: MachineWord,
    /// The same as a sentence, with its times: all that is so of it, the most urgent first.
    pub doing: String,
    /// When the next print of one of its printers could begin after what is given to it, to the minute; `None` = all are down, or none is
    /// open again.
    pub free_at: Option<UtcTimestamp>,
    /// Its printers.
    pub printers: Vec<PrinterFact>,
}

impl MachineWord {
    /// All of them, the most urgent first.
    pub const ALL: [Self; 13] = [
        Self::Unavailable,
        Self::Paused,
        Self::Down,
        Self::Printing,
        Self::Cooling,
        Self::Ended,
        Self::Queued,
        Self::AwaitsYes,
        Self::Nesting,
        Self::Reading,
        Self::Collecting,
        Self::Closed,
        Self::Free,
    ];

    /// The word, as JSON has it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unavailable => "unavailable",
            Self::Paused => "paused",
            Self::Down => "down",
            Self::Printing => "printing",
            Self::Cooling => "cooling",
            Self::Ended => "ended",
            Self::Queued => "queued",
            Self::AwaitsYes => PlanStage::Made.word(true),
            Self::Nesting => "nesting",
            Self::Reading => "reading",
            Self::Collecting => "collecting",
            Self::Closed => PrinterWord::Closed.word(),
            Self::Free => "free",
        }
    }
}

/// What is so of a machine with these printers. `observed` is what the daemon saw of it last, `awaiting` its builds that wait for a yes.
pub fn machine_fact(
    status: &MachineStatus,
    observed: Option<&MachineRow>,
    printers: Vec<PrinterFact>,
    awaiting: &[BuildId],
) -> MachineFact {
    let trouble = observed.map_or("", |observed| observed.trouble.as_str());
    let is_one = |word: PrinterWord| printers.iter().any(|printer| printer.state == word);
    let state = match status {
        _ if !trouble.is_empty() => MachineWord::Unavailable,
        status if status.paused.is_some() => MachineWord::Paused,
        _ if !printers.is_empty() && printers.iter().all(|printer| printer.state == PrinterWord::Down) => {
            MachineWord::Down
        }
        _ if is_one(PrinterWord::Printing) => MachineWord::Printing,
        _ if is_one(PrinterWord::Cooling) => MachineWord::Cooling,
        _ if is_one(PrinterWord::Ended) => MachineWord::Ended,
        _ if is_one(PrinterWord::Queued) => MachineWord::Queued,
        _ if !awaiting.is_empty() => MachineWord::AwaitsYes,
        status if !status.nesting.is_empty() => MachineWord::Nesting,
        status if status.claimed_parts > 0 => MachineWord::Reading,
        status if status.collecting_copies > 0 => MachineWord::Collecting,
        _ if is_one(PrinterWord::Closed) && !is_one(PrinterWord::Free) => MachineWord::Closed,
        _ => MachineWord::Free,
    };
    let mut pieces = Vec::new();
    if !trouble.is_empty() {
        pieces.push(say!("machine-unavailable", trouble = language::told(trouble)));
    }
    if let Some(paused) = &status.paused {
        let by = if paused.paused_by.is_empty() { "-" } else { &paused.paused_by };
        pieces.push(say!("machine-paused", by = by));
    }
    pieces.extend(printing_texts(&printers));
    pieces.extend(making_texts(status, awaiting));
    MachineFact {
        machine: status.machine.clone(),
        state,
        doing: if pieces.is_empty() { say!("free-now") } else { language::join_sentences(pieces) },
        free_at: printers.iter().filter_map(|printer| printer.free_at).min(),
        printers,
    }
}

/// What the printers of a machine do, unless all are idle.
fn printing_texts(printers: &[PrinterFact]) -> Vec<String> {
    match printers {
        all if all.iter().all(|printer| printer.state == PrinterWord::Free) => Vec::new(),
        [only] => vec![only.doing.clone()],
        all => all.iter().map(|printer| format!("{}: {}", printer.printer, printer.doing)).collect(),
    }
}

/// What is made, read and collected, in words.
fn making_texts(status: &MachineStatus, awaiting: &[BuildId]) -> Vec<String> {
    let made = |build: &ledger::NestingBuild| {
        let (number, copies) = (build.build.to_string(), build.copies);
        match build.state {
            _ if awaiting.contains(&build.build) => say!("build-awaits-yes", build = number, copies = copies),
            BuildState::Verified => say!("build-is-proved", build = number, copies = copies),
            _ => say!("build-is-searched", build = number, copies = copies),
        }
    };
    let mut making: Vec<String> = status.nesting.iter().map(made).collect();
    if status.claimed_parts > 0 {
        making.push(say!("reading-files", files = status.claimed_parts));
    }
    if status.collecting_copies > 0 {
        making.push(say!("collecting-copies", copies = status.collecting_copies));
    }
    making.extend(asked_text(status));
    making.extend(
        status
            .awaiting
            .iter()
            .map(|awaiting| say!("copies-await-material", copies = awaiting.copies, material = &awaiting.material)),
    );
    making
}

/// How many copies are asked about, in words; `None` = none is.
pub fn asked_text(status: &MachineStatus) -> Option<String> {
    (status.asked_copies > 0).then(|| say!("copies-await-answer", copies = status.asked_copies))
}

impl MachineFact {
    /// When its next build fires. While it is unavailable, nobody knows.
    pub fn forecast_fire(
        &self,
        profile: &MachineProfile,
        status: &MachineStatus,
        now: Timestamp,
    ) -> Option<FireForecast> {
        if self.state == MachineWord::Unavailable { None } else { forecast_fire(profile, status, now) }
    }

    /// Its printers, unless it has only one, which is in use.
    pub fn shown_printers(&self) -> &[PrinterFact] {
        match self.printers.as_slice() {
            [only] if only.down.is_none() => &[],
            all => all,
        }
    }
}
