//! The forecast of when the next build of a machine fires: on the pages, in `STATUS.txt` and in `nestd status`.

use jiff::Timestamp;
use language::say;
use ledger::MachineStatus;
use settings::MachineProfile;

use super::{
    printer_outlook::PrinterOutlook,
    queue_depth::{has_machine_room, is_hindered},
    trigger::{DueFacts, FireTrigger, TriggerFacts, next_timed_trigger},
};

/// When a machine's next build fires, unless it is full before or an operator flushes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FireForecast {
    /// The time if nothing more arrives; a time in the past means at once.
    pub at: Timestamp,
    /// The time whatever arrives.
    pub latest: Timestamp,
    /// The trigger that fires it.
    pub by: FireTrigger,
}

impl FireForecast {
    /// When it fires, what would be in it and why: the end of a sentence that begins with 'It fires'.
    pub fn fire_text(&self, profile: &MachineProfile, row: &MachineStatus) -> String {
        let zone = &profile.time_zone;
        let (at, latest, why) =
            (zone.format_minute(self.at), zone.format_minute(self.latest), self.fire_reason(profile, row));
        let content = contents_text(row);
        match self.at < self.latest {
            true => say!("fires-when-full-or", at = at, latest = latest, content = content, why = why),
            false => say!("fires-when-full", latest = latest, content = content, why = why),
        }
    }

    /// The reason in words.
    pub fn fire_reason(&self, profile: &MachineProfile, row: &MachineStatus) -> String {
        match self.by {
            FireTrigger::Due if row.due_of.is_empty() => say!("fires-due"),
            FireTrigger::Due => match row.due_of.strip_prefix("order ") {
                Some(order) => say!("fires-due-of", name = say!("order-of", order = order)),
                None => say!("fires-due-of", name = &row.due_of),
            },
            FireTrigger::At => {
                let at = self.at.to_zoned(profile.time_zone.time_zone().clone());
                say!("fires-at", time = at.strftime("%H:%M %Z").to_string())
            }
            _ => say!("fires-waited"),
        }
    }
}

/// What would be in the build now: `with 12 copies, 83.0 mm high`.
fn contents_text(row: &MachineStatus) -> String {
    match row.open.as_ref().and_then(|open| Some((open.copies?, open.height_mm?))) {
        Some((copies, height_mm)) if copies > 0 => {
            let height = language::decimal(format!("{height_mm:.1}"));
            say!("with-copies-high", copies = copies, height = height)
        }
        // Its layout is not searched yet.
        _ => say!("with-copies", copies = row.collecting_copies),
    }
}

/// When the next build of a machine fires because of the time alone.
pub fn forecast_fire(profile: &MachineProfile, row: &MachineStatus, now: Timestamp) -> Option<FireForecast> {
    if is_hindered(profile, row) || row.waiting_parts == 0 || !has_machine_room(profile, &row.ahead) {
        return None;
    }
    let height_mm = row.open.as_ref().and_then(|open| open.height_mm).unwrap_or(0.0);
    let (oldest, outlook) = (row.waits_since?.0, PrinterOutlook::of_status(profile, row, now));
    let facts = |newest: Timestamp| TriggerFacts {
        copies: row.collecting_copies.max(1) as usize,
        oldest,
        due: DueFacts::of_arrivals(profile, &outlook, height_mm, &row.due_arrivals, newest),
        height_mm,
        density: 0.0,
        full: false,
        flush: false,
        takes_over: false,
        is_date_trusted: true,
    };
    let (at, by) = next_timed_trigger(profile, &facts(row.newest_at.map_or(oldest, |at| at.0)))?;
    // As if parts arrived until it fires.
    let (latest, _) = next_timed_trigger(profile, &facts(Timestamp::MAX))?;
    Some(FireForecast { at, latest, by })
}
