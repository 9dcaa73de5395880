//! What a printer does and when it is free: a function of the builds that were given to it and of the time. Where nobody told that a
//! print began, it is taken to have begun when its file was taken; the end of a print is an estimate until its outcome is told.

use jiff::Timestamp;
use language::say;
use ledger::{BuildId, DownPrinter, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::{FarmZone, MachineProfile, PrinterRules};

use crate::{
    decisions::{
        print_times::PrintTimes,
        printer_choice::{BuildSpan, BuildStage, load_of_spans},
    },
    process::time_text::known_minute,
};

/// What a printer does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PrinterWord {
    /// A person took it out of use.
    Down,
    /// It prints.
    Printing,
    /// Its last print cools, and is unpacked.
    Cooling,
    /// Its last print should be over, and nobody told how it came out.
    Ended,
    /// Files lie in its queue, and it has taken none.
    Queued,
    /// A build is made for it.
    Expecting,
    /// It has nothing to do, and no print begins now: it is outside its hours, or it has a day off.
    #[serde(rename = "closed now")]
    Closed,
    /// It has nothing to do, and a print could begin now.
    Free,
}

/// What is so of a printer.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PrinterFact {
    /// Its name.
    pub printer: String,
    /// Its machine.
    pub machine: String,
    /// Its queue folder.
    pub queue: String,
    /// What it does.
    pub state: PrinterWord,
    /// The same as a sentence, with its times.
    pub doing: String,
    /// The build that it prints, has printed, or begins next; `None` = there is none.
    pub build: Option<BuildId>,
    /// When the print ends, its cooling ends, it should have ended, or the next print could begin, as far as is known, to the minute; of a
    /// closed one, when it is open again.
    pub until: Option<UtcTimestamp>,
    /// Whether nobody told that the print began: it is taken to have begun when the printer took its file.
    pub is_estimated: bool,
    /// Since when and why it takes no builds; `None` = it is in use.
    pub down: Option<DownPrinter>,
    /// Builds that are made for it, lie in its queue or are printed, as far as is known.
    pub builds: u32,
    /// When its next print could begin after those, as far as is known, to the minute; `None` = it is down, or no day is open.
    pub free_at: Option<UtcTimestamp>,
    /// Hours of printing per mm of build height.
    pub hours_per_mm: f64,
    /// Hours beside that.
    pub cool_down_hours: f64,
    /// Number of told prints that these were learned from; 0 = they are the settings.
    pub learned_from: u32,
}

impl PrinterWord {
    /// All of them, the most urgent first.
    pub const ALL: [Self; 8] = [
        Self::Down,
        Self::Printing,
        Self::Cooling,
        Self::Ended,
        Self::Queued,
        Self::Expecting,
        Self::Closed,
        Self::Free,
    ];

    /// The word, as JSON has it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Printing => "printing",
            Self::Cooling => "cooling",
            Self::Ended => "ended",
            Self::Queued => "queued",
            Self::Expecting => "expecting",
            Self::Closed => "closed now",
            Self::Free => "free",
        }
    }
}

/// What is so of a printer with these builds, in the order in which it prints them.
pub fn printer_fact(
    profile: &MachineProfile,
    rules: &PrinterRules,
    spans: &[BuildSpan],
    down: Option<DownPrinter>,
    times: &PrintTimes,
    now: Timestamp,
) -> PrinterFact {
    let load = load_of_spans(spans, now);
    let free_at = rules.begins_at(load.free_at, &profile.time_zone);
    let (state, at) = match doing(spans, now) {
        (PrinterWord::Free, _) if free_at > now => (PrinterWord::Closed, None),
        doing => doing,
    };
    let until = match (state, at) {
        (PrinterWord::Closed, _) => Some(free_at),
        (PrinterWord::Printing, Some(span)) => Some(span.printed_at),
        (PrinterWord::Cooling | PrinterWord::Ended, Some(span)) => Some(span.ends_at),
        (_, span) => span.map(|span| span.begins_at),
    };
    let fact = PrinterFact {
        printer: rules.name.clone(),
        machine: profile.name.clone(),
        queue: rules.queue.to_string(),
        state: if down.is_some() { PrinterWord::Down } else { state },
        doing: String::new(),
        build: at.map(|span| span.build),
        until: until.and_then(known_minute),
        is_estimated: at.is_some_and(|span| span.is_taken && !span.is_told),
        builds: u32::try_from(load.builds).unwrap_or(u32::MAX),
        free_at: if down.is_some() { None } else { known_minute(free_at) },
        hours_per_mm: times.hours_per_mm,
        cool_down_hours: times.cool_down_hours,
        learned_from: u32::try_from(times.learned_from).unwrap_or(u32::MAX),
        down,
    };
    let more = at.and_then(|at| spans.iter().rposition(|span| span.build == at.build));
    let more = more.map_or(0, |place| spans.len() - 1 - place);
    PrinterFact { doing: fact.in_words(more, &profile.time_zone, now), ..fact }
}

/// What a printer that is in use does, and with which build: the first of these stages that one of its builds is in.
fn doing(spans: &[BuildSpan], now: Timestamp) -> (PrinterWord, Option<&BuildSpan>) {
    let first = |stage: BuildStage| spans.iter().find(|span| span.stage(now) == stage);
    let last = |stage: BuildStage| spans.iter().rfind(|span| span.stage(now) == stage);
    let found = [
        (PrinterWord::Printing, first(BuildStage::Printing)),
        (PrinterWord::Cooling, first(BuildStage::Cooling)),
        (PrinterWord::Ended, last(BuildStage::Ended)),
        (PrinterWord::Queued, first(BuildStage::Taken)),
        (PrinterWord::Queued, first(BuildStage::Queued)),
        (PrinterWord::Expecting, first(BuildStage::Made)),
    ];
    found.into_iter().find(|(_, span)| span.is_some()).unwrap_or((PrinterWord::Free, None))
}

impl PrinterFact {
    /// `0.100 h per mm and 4.0 h, from 12 prints`.
    pub fn times_text(&self) -> String {
        let per_mm = language::decimal(format!("{:.3}", self.hours_per_mm));
        let hours = language::decimal(format!("{:.1}", self.cool_down_hours));
        match self.learned_from {
            0 => say!("print-times-set", per_mm = per_mm, hours = hours),
            prints => say!("print-times-learned", per_mm = per_mm, hours = hours, prints = prints),
        }
    }

    /// What it does: `printing build 4 until about today 15:30 (estimated), free from tomorrow 08:00`. `more` builds follow.
    fn in_words(&self, more: usize, zone: &FarmZone, now: Timestamp) -> String {
        let time = |at: Option<UtcTimestamp>| at.map(|at| zone.format_near(at.0, now));
        let build = self.build.map(|build| build.to_string()).unwrap_or_default();
        let until = time(self.until).unwrap_or_default();
        let free = match self.free_at {
            Some(at) if at.0 <= now => None,
            Some(at) => Some(say!("printer-free-from", time = say!("about-time", time = zone.format_near(at.0, now)))),
            None => Some(say!("printer-never-open")),
        };
        let doing = match self.state {
            PrinterWord::Free => return say!("free-now"),
            PrinterWord::Closed if self.free_at.is_none() => return say!("printer-never-open"),
            PrinterWord::Closed => return say!("printer-closed", time = until),
            PrinterWord::Down => return self.down_text(zone, now),
            PrinterWord::Ended => {
                say!("printer-ended", build = build, until = until)
            }
            PrinterWord::Printing if self.is_estimated => {
                say!("printer-prints-estimated", build = build, until = until)
            }
            PrinterWord::Printing => say!("printer-prints", build = build, until = until),
            PrinterWord::Cooling if self.is_estimated => {
                say!("printer-cools-estimated", build = build, until = until)
            }
            PrinterWord::Cooling => say!("printer-cools", build = build, until = until),
            PrinterWord::Expecting => say!("printer-expects", build = build),
            PrinterWord::Queued if self.until.is_some_and(|at| at.0 > now) => {
                say!("printer-queued-until", build = build, time = until)
            }
            PrinterWord::Queued => say!("printer-queued", build = build),
        };
        let more = (more > 0).then(|| say!("then-more-builds", count = more));
        let free = free.filter(|_| self.state != PrinterWord::Ended);
        language::join_names([Some(doing), more, free].into_iter().flatten())
    }

    fn down_text(&self, zone: &FarmZone, now: Timestamp) -> String {
        let Some(down) = &self.down else { return String::new() };
        let why = if down.reason.is_empty() { String::new() } else { format!(": {}", down.reason) };
        let since = zone.format_near(down.down_at.0, now);
        say!("printer-down", since = since, by = &down.told_by) + &why
    }
}
