//! The current state of a machine: waiting parts, current activity, and when its next build fires.

use build_file::format_count;
use farm::{FireTrigger, MachineFact, held_text, night_gain_text};
use jiff::Timestamp;
use ledger::{MachineStatus, OpenBuildForecast, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::MachineProfile;

use super::build_sheet::joined;
use crate::tables::{
    columns::{
        table_column::TableColumn,
        time_view::{GivenDate, TimeView},
    },
    fields,
};

/// The current state of a machine, with the forecast of its next build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MachineForecast {
    /// Its state in the ledger.
    #[serde(flatten)]
    pub status: MachineStatus,
    /// When its next build fires if nothing more arrives. It fires earlier if it is full.
    #[schemars(with = "Option<UtcTimestamp>")]
    pub fires_at: Option<Timestamp>,
    /// When its next build fires at the latest, whatever arrives.
    #[schemars(with = "Option<UtcTimestamp>")]
    pub fires_at_latest: Option<Timestamp>,
    /// The trigger that fires the build at these times.
    pub fires_by: Option<FireTrigger>,
    /// Why the open build waits although a trigger may hold; `None` = it does not.
    pub held: Option<String>,
    /// What it does, and its printers; none where it is not configured.
    #[serde(flatten)]
    pub fact: MachineFact,
}

/// The state of a machine at one point in time, for display.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineNow {
    /// The state of the machine, with the forecast of its next build.
    pub forecast: MachineForecast,
    /// Whether the machine is (still) in the configuration.
    pub is_configured: bool,
    /// The other node that serves the machine; `None` = this one does, or none.
    pub other_node: Option<String>,
    /// How its times are shown.
    pub view: TimeView,
}

/// The machines of a farm.
pub const MACHINE_COLUMNS: &[TableColumn<MachineNow>] = &[
    TableColumn::new("machine", fields::MACHINE, |row| (&row.forecast.status.machine).into()),
    TableColumn::new("waiting_parts", fields::WAITING, |row| row.forecast.status.waiting_parts.into()),
    TableColumn::new("waiting_copies", fields::COPIES, |row| row.forecast.status.waiting_copies.into()),
    TableColumn::for_people("oldest", fields::OLDEST, |row| {
        row.view.now().and_then(|now| row.forecast.oldest(now)).into()
    }),
    TableColumn::new("due_at", fields::DUE, |row| {
        GivenDate::new(row.forecast.status.due_at, &row.forecast.status.due_text).into()
    }),
    TableColumn::for_people("next_build", fields::NEXT_BUILD, |row| row.forecast.next_build(&row.view).into()),
    TableColumn::for_people("now", fields::NOW, |row| row.doing().into()),
    TableColumn::new("refused_parts", fields::REFUSED, |row| row.forecast.status.refused_parts.into()),
    TableColumn::for_people("last_published", fields::LAST_PUBLISHED, |row| {
        row.forecast.last_published(&row.view).into()
    }),
];

impl MachineForecast {
    /// Creates the forecast. `profile` is the machine's configuration, if it has one, and `fact` what is so of it.
    pub fn new(status: MachineStatus, profile: Option<&MachineProfile>, fact: MachineFact, now: Timestamp) -> Self {
        let fires = profile.and_then(|profile| fact.forecast_fire(profile, &status, now));
        Self {
            fires_at: fires.map(|fires| fires.at),
            fires_at_latest: fires.map(|fires| fires.latest),
            fires_by: fires.map(|fires| fires.by),
            held: profile.and_then(|profile| held_text(profile, &status)),
            status,
            fact,
        }
    }

    /// The open build, if its layout contains a copy.
    pub fn forecast_build(&self) -> Option<&OpenBuildForecast> {
        self.status.open.as_ref().filter(|open| open.copies.unwrap_or(0) > 0)
    }

    /// How long the oldest part has waited.
    pub fn oldest(&self, now: Timestamp) -> Option<String> {
        self.status.oldest_at.and_then(|at| at.age_text(now))
    }

    /// `55.61 mm, 1.24 mm lower after 350 CPU s, 11 copies, by 2026-11-20 06:00:00 CET (max_wait)`; where parts are gathered for a due date, also when it
    /// fires if nothing more arrives.
    fn next_build(&self, view: &TimeView) -> String {
        let open = self.forecast_build();
        let height = open.and_then(|open| fields::HEIGHT.with_unit(open.height_mm));
        let night = open.and_then(night_gain_text);
        let copies = open.map(|open| format_count(open.copies.unwrap_or(0), "copy", "copies"));
        let time = |at: Timestamp| view.time_text(UtcTimestamp(at));
        let gathers = self.fires_at.filter(|at| Some(*at) < self.fires_at_latest);
        let gathers = gathers.map(|at| format!("at {} if nothing more arrives", time(at)));
        let fires = self.fires_at_latest.zip(self.fires_by).map(|(at, by)| format!("by {} ({by})", time(at)));
        joined([height, night, copies, gathers, fires, self.held.clone()], ", ")
    }

    /// `build 3, 87.50 mm, 2026-11-20 04:49:00 CET`.
    fn last_published(&self, view: &TimeView) -> Option<String> {
        let last = self.status.last_published.as_ref()?;
        let height = fields::HEIGHT.with_unit(last.height_mm);
        let at = view.time_text(last.published_at);
        Some(joined([Some(format!("build {}", last.build)), height, Some(at)], ", "))
    }
}

impl MachineNow {
    fn doing(&self) -> String {
        let node = match &self.other_node {
            Some(node) => Some(format!("served by {node}")),
            None => (!self.is_configured).then(|| "not configured".to_owned()),
        };
        joined([node, Some(self.forecast.fact.doing.clone())], "; ")
    }
}
