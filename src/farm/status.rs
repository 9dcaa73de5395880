//! What the farm tells of itself: one line for the service manager, a sign of life in the ledger, and `STATUS.txt` and
//! `status.json` in each hot folder.

use std::time::{Duration, Instant};

use anyhow::Result;
use jiff::{Timestamp, tz::TimeZone};
use serde_json::json;

use super::{
    attention::Attention,
    event::Event,
    farm::Farm,
    jobs::JobKey,
    publish::GAVE_UP,
    sd,
    station::Station,
    trigger::{Facts, FiredBy, fires_next},
};
use crate::{
    intake,
    ledger::{Beat, ProfileStatus},
    settings::Profile,
};

/// Troubles that did not come again for so long, or for three scans, are over.
const TROUBLES_LAST: Duration = Duration::from_secs(150);
/// Between two looks at the whole ledger for what is shown.
const SHOW_EVERY: Duration = Duration::from_secs(2);

impl Farm {
    /// Brings all that is shown up to date.
    pub(super) async fn show_status(&mut self) -> Result<()> {
        if self.shown_at.is_some_and(|at| at.elapsed() < SHOW_EVERY) {
            return Ok(());
        }
        self.shown_at = Some(Instant::now());
        let rows = self.ledger.status().await?;
        for (name, station) in &mut self.stations {
            if let Some(row) = rows.iter().find(|row| row.profile == *name) {
                station.status = (status_text(station, row), status_json(station, row));
            }
        }
        self.notice_what_the_ledger_says(&rows).await?;
        self.look_at_due_dates().await?;
        let waiting: u32 = rows.iter().map(|r| r.waiting_copies).sum();
        let nesting: usize = rows.iter().map(|r| r.nesting.len()).sum();
        let line = format!("{} profiles, {waiting} copies wait, {nesting} builds in work", self.stations.len());
        if line != self.status_line {
            sd::status(&line);
            self.status_line = line;
        }
        Ok(())
    }

    /// What needs a person and stands in the ledger: so it is known after a restart too.
    async fn notice_what_the_ledger_says(&mut self, rows: &[ProfileStatus]) -> Result<()> {
        let names: Vec<String> = self.stations.keys().cloned().collect();
        for name in &names {
            let paused = rows.iter().find(|row| row.profile == *name).and_then(|row| row.paused.as_ref());
            match paused.filter(|paused| paused.paused_by == GAVE_UP) {
                Some(_) => {
                    let why = self.ledger.last_failure(name).await?;
                    let detail = why.map(|(build, why)| format!("build {build} {why}")).unwrap_or_default();
                    self.notices.raise(Attention::BuildFailed, name, "", &detail);
                }
                None => self.notices.clear(Attention::BuildFailed, name, ""),
            }
        }
        let mut gone = Vec::new();
        for row in rows.iter().filter(|row| !self.stations.contains_key(&row.profile)) {
            let (parts, builds) = (row.waiting_parts + row.claimed_parts, row.nesting.len());
            if parts > 0 || builds > 0 {
                let detail = format!("{parts} parts and {builds} builds that have fired");
                self.notices.raise(Attention::MachineGone, &row.profile, "", &detail);
                gone.push(row.profile.clone());
            }
        }
        self.notices.keep_only(Attention::MachineGone, &gone);
        Ok(())
    }

    /// Keeps what needs a person where `nestd status` finds it; a farm that has stopped working tells it in the hot folders
    /// too, which otherwise every look does.
    pub(super) fn tell_people(&mut self) {
        let over = TROUBLES_LAST.max(Duration::from_secs_f64(3.0 * self.settings.scan_secs));
        self.notices.forget_what_is_over(over);
        for ((kind, about), why) in self.outside.told() {
            match why.as_str() {
                "" => self.notices.clear(kind, "", &about),
                why => self.notices.raise(kind, "", &about, why),
            }
        }
        self.notices.keep(&self.settings.state_dir);
        if !self.is_halted || self.shown_at.is_some_and(|at| at.elapsed() < SHOW_EVERY) {
            return;
        }
        self.shown_at = Some(Instant::now());
        for (name, station) in &self.stations {
            let (profile, inbox, (text, json)) =
                (name.clone(), station.profile.folders.inbox.clone(), station.told(&self.notices));
            self.jobs.start(JobKey::Tell(name.clone()), move || {
                if let Err(error) = intake::write_status(&inbox, &text, &json) {
                    tracing::debug!(profile, "STATUS.txt could not be written: {error}.");
                }
                Event::Told { profile }
            });
        }
    }

    /// The ledger is damaged: nothing is taken and nothing published any more, for nobody would know of it.
    pub(super) fn halt(&mut self, why: &str) {
        if !self.is_halted {
            self.is_halted = true;
            self.outside.set_open(false);
            self.finals.values().for_each(|(budget, _)| budget.cancel());
            self.stations.values_mut().for_each(|station| station.open.clear());
            self.notices.raise(Attention::LedgerDamaged, "", "", why);
            self.status_line = "halted: the ledger is damaged".to_owned();
            sd::status(&self.status_line);
        }
    }

    /// Writes a sign of life into the ledger.
    pub(super) async fn sign_of_life(&mut self) -> Result<()> {
        let beat = Beat {
            pid: std::process::id(),
            host: host_name(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            started_at: self.started_at,
            status: self.status_line.clone(),
            stations: self.stations_seen(),
        };
        Ok(self.ledger.beat(&beat).await?)
    }
}

fn host_name() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

/// For the technician at the shared folder; lengths in mm, times local.
fn status_text(station: &Station, row: &ProfileStatus) -> String {
    let profile = &station.profile;
    let mut lines = vec![format!("{}: drop STL or 3MF files here.", profile.name)];
    if let Some(paused) = &row.paused {
        lines.push(format!("PAUSED by {} since {}: nothing is fired.", paused.paused_by, local(paused.paused_at.0)));
    }
    lines.push(match row.waiting_parts {
        0 => "Nothing waits.".to_owned(),
        parts => format!("{} copies of {parts} parts wait.", row.waiting_copies),
    });
    if row.claimed_parts > 0 {
        lines.push(format!("{} files are being read.", row.claimed_parts));
    }
    if row.waiting_parts > 0 && station.open.layout.height_mm > 0.0 {
        let (height_mm, volume_z_mm) = (station.open.layout.height_mm, profile.build_volume().size_mm.z);
        lines.push(format!(
            "Open build: {height_mm:.1} mm high, {:.0} % of the volume's height.",
            100.0 * height_mm / volume_z_mm
        ));
    }
    if let Some(at) = fires_at(profile, row) {
        lines.push(format!("It fires when it is full, at the latest {}: {}.", local(at.at), at.why(row)));
    }
    for build in &row.nesting {
        lines.push(format!("Build {} is being made: {} copies.", build.build, build.copies));
    }
    if let Some(last) = &row.last_published {
        let height_mm = last.height_mm.unwrap_or_default();
        lines.push(format!("Last build: {} on {}, {height_mm:.1} mm.", last.build, local(last.published_at.0)));
    }
    lines.join("\n") + "\n"
}

fn status_json(station: &Station, row: &ProfileStatus) -> serde_json::Value {
    let fires = fires_at(&station.profile, row);
    json!({
        "profile": row.profile,
        "paused": row.paused.is_some(),
        "being_read_parts": row.claimed_parts,
        "waiting_parts": row.waiting_parts,
        "waiting_copies": row.waiting_copies,
        "refused_files": station.refused_kept,
        "open_build": {
            "height_mm": station.open.layout.height_mm,
            "density": station.open.layout.density,
            "copies": station.open.layout.placed.len(),
            "height_share": station.open.layout.height_mm / station.profile.build_volume().size_mm.z,
        },
        "fires_at_latest": fires.map(|fires| fires.at.to_string()),
        "fires_by": fires.map(|fires| fires.by),
        "in_work": row.nesting.iter().map(|b| json!({ "build": b.build, "copies": b.copies })).collect::<Vec<_>>(),
        "last_published": row.last_published.as_ref().map(|b| json!({
            "build": b.build, "height_mm": b.height_mm, "at": b.published_at, "file": b.file_name,
        })),
    })
}

/// When a machine's next build fires at the latest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fires {
    /// Then; what is over means at once.
    pub at: Timestamp,
    /// The trigger that fires it.
    pub by: FiredBy,
}

impl Fires {
    /// Why then, in words.
    pub fn why(&self, row: &ProfileStatus) -> String {
        match self.by {
            FiredBy::Due if row.due_of.is_empty() => "a due date comes near".to_owned(),
            FiredBy::Due => format!("deadline of {}", row.due_of),
            FiredBy::At => format!("at {}", self.at.to_zoned(TimeZone::system()).strftime("%H:%M %Z")),
            _ => "waited long enough".to_owned(),
        }
    }
}

/// When the next build of a profile fires at the latest; unless it is full before, or an operator wants it.
pub fn fires_at(profile: &Profile, row: &ProfileStatus) -> Option<Fires> {
    if row.paused.is_some() || row.waiting_parts == 0 {
        return None;
    }
    let facts = Facts {
        copies: row.waiting_copies.max(1) as usize,
        oldest: row.oldest_at?.0,
        due: row.due_at.map(|due| due.0),
        height_mm: row.open.as_ref().and_then(|open| open.height_mm).unwrap_or(0.0),
        density: 0.0,
        full: false,
        flush: false,
        knows_the_date: true,
    };
    fires_next(profile, &facts).map(|(at, by)| Fires { at, by })
}

fn local(time: Timestamp) -> String {
    time.to_zoned(TimeZone::system()).strftime("%Y-%m-%d %H:%M").to_string()
}
