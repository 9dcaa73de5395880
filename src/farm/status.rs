//! What the farm tells of itself: one line for the service manager, a sign of life in the ledger, and `STATUS.txt` and
//! `status.json` in each hot folder.

use std::time::{Duration, Instant};

use anyhow::Result;
use build_file::counted;
use jiff::{Timestamp, tz::TimeZone};
use serde_json::json;

use super::{
    attention::Attention,
    claimed::ReceiveJob,
    farm::{BEAT, Farm},
    jobs::Job,
    layout::Layout,
    nest::GAVE_UP,
    sd,
    stamp::{minute, zoned},
    station::Station,
    trigger::{Facts, FiredBy, fires_next},
};
use crate::{
    intake,
    ledger::{Beat, LedgerError, ProfileStatus},
    settings::Profile,
};

/// How the line of a farm begins that does nothing any more.
pub const HALTED: &str = "halted";
/// After the farm has stopped, its hot folders are told so within this time; a share that hangs is not waited for longer.
const FAREWELL_WITHIN: Duration = Duration::from_secs(1);

/// Troubles that did not come again for so long, or for three scans, are over.
const TROUBLES_LAST: Duration = Duration::from_secs(150);
/// Between two looks at the whole ledger for what is shown.
const SHOW_EVERY: Duration = Duration::from_secs(2);

/// Telling in a hot folder that nothing is done any more.
#[derive(Clone)]
pub(super) struct TellJob {
    profile: String,
}

impl Job<Farm> for TellJob {
    const KIND: &'static str = "Tell";
    type Outcome = ();

    fn about(&self) -> String {
        self.profile.clone()
    }

    async fn done(self, _farm: &mut Farm, (): ()) -> Result<()> {
        Ok(())
    }
}

impl Farm {
    /// Brings all that is shown up to date.
    pub(super) async fn show_status(&mut self) -> Result<()> {
        if self.shown.shown_at.is_some_and(|at| self.schedule.time.passed_since(at) < SHOW_EVERY) {
            return Ok(());
        }
        self.shown.shown_at = Some(self.now());
        let rows = self.ledger.status().await?;
        for (name, station) in &mut self.stations {
            if let Some(row) = rows.iter().find(|row| row.profile == *name) {
                station.status = (status_text(station, row), status_json(station, row));
            }
        }
        self.notice_what_the_ledger_says(&rows).await?;
        self.look_at_due_dates().await?;
        let line = summary(self.stations.len(), rows.iter());
        if line != self.shown.line {
            sd::status(&line);
            self.shown.line = line;
            // Whoever asks the ledger is not told what was.
            self.shown.sign_of_life = None;
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
                let (parts, builds) = (counted(parts, "part", "parts"), counted(builds, "build", "builds"));
                let detail = format!("{parts} and {builds} in work");
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
        for ((kind, about), why) in self.life.outside.told() {
            match why.as_str() {
                "" => self.notices.clear(kind, "", &about),
                why => self.notices.raise(kind, "", &about, why),
            }
        }
        self.notices.keep(&self.settings.state_dir);
        if !self.life.is_halted
            || self.shown.shown_at.is_some_and(|at| self.schedule.time.passed_since(at) < SHOW_EVERY)
        {
            return;
        }
        self.shown.shown_at = Some(self.now());
        for (name, station) in &self.stations {
            let (profile, inbox, (text, json)) = (
                name.clone(),
                station.profile.folders.inbox.clone(),
                station.told(&self.notices, self.settings.scan_secs),
            );
            self.jobs.start(TellJob { profile: name.clone() }, move || {
                if let Err(error) = intake::write_status(&inbox, &text, &json) {
                    tracing::debug!(profile, "STATUS.txt could not be written: {error}.");
                }
            });
        }
    }

    /// The ledger's file is not there any more: what the daemon knows is saved beside it, and nothing is done any more.
    pub(super) async fn leave_ledger(&mut self, why: &LedgerError) {
        let mut file = self.settings.ledger.clone().into_os_string();
        file.push(Timestamp::now().strftime(".saved-%Y%m%dT%H%M%SZ").to_string());
        let (file, ledger) = (std::path::PathBuf::from(file), self.ledger.clone());
        let saving = ledger.backup(&file);
        tokio::pin!(saving);
        let saved = loop {
            tokio::select! {
                saved = &mut saving => break saved,
                () = tokio::time::sleep(BEAT) => sd::alive(),
            }
        };
        let what = match why {
            LedgerError::Replaced { what, .. } => what.clone(),
            other => other.to_string(),
        };
        let detail = match saved {
            Ok(_) => format!("{what}; all that nestd knew is saved as {}", file.display()),
            Err(error) => format!("{what}; it could not be saved ({error}), so put the newest backup back"),
        };
        self.halt(Attention::LedgerReplaced, &detail);
        // Closing it, SQLite would remove the log of the ledger that stands there now.
        std::mem::forget(self.ledger.clone());
    }

    /// The ledger cannot be relied on: nothing is taken and nothing published any more, for nobody would know of it.
    pub(super) fn halt(&mut self, kind: Attention, why: &str) {
        if !self.life.is_halted {
            self.life.is_halted = true;
            self.life.outside.set_open(false);
            self.nesting.finals.values().for_each(|(budget, _)| budget.cancel());
            self.stations.values_mut().for_each(|station| station.open.clear());
            self.notices.raise(kind, "", "", why);
            let what = if kind == Attention::LedgerReplaced { "was removed or replaced" } else { "is damaged" };
            self.shown.line = format!("{HALTED}: the ledger {what}");
            sd::status(&self.shown.line);
        }
    }

    /// Says in each hot folder that nobody looks there any more: what stood there before promised builds.
    pub(super) async fn say_farewell(&mut self) {
        let rows = match self.life.is_halted {
            true => Vec::new(),
            false => self.ledger.status().await.unwrap_or_default(),
        };
        for (name, station) in &self.stations {
            // A job that did not end hangs in that folder, and so would this one.
            if self.jobs.runs::<ReceiveJob>(name) {
                continue;
            }
            let row = rows.iter().find(|row| row.profile == *name).cloned().unwrap_or_default();
            let (text, json) = last_words(station, &row);
            let (profile, inbox) = (name.clone(), station.profile.folders.inbox.clone());
            let mut hold = station.holds.inbox.clone();
            self.jobs.start(TellJob { profile: name.clone() }, move || {
                // An empty mount point is told nothing.
                if hold.seen().is_some()
                    && hold.check().is_ok()
                    && let Err(error) = intake::write_status(&inbox, &text, &json)
                {
                    tracing::debug!(profile, "STATUS.txt could not be written: {error}.");
                }
            });
        }
        self.wait_for_jobs(Instant::now() + FAREWELL_WITHIN).await;
    }

    /// Writes a sign of life into the ledger.
    pub(super) async fn sign_of_life(&mut self) -> Result<()> {
        let beat = Beat {
            pid: std::process::id(),
            host: host_name(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            started_at: self.life.started_at,
            status: self.shown.line.clone(),
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
        _ => waiting_text(row) + ".",
    });
    if row.claimed_parts > 0 {
        lines.push(counted(row.claimed_parts, "file is being read.", "files are being read."));
    }
    if is_forecast(station, row) {
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
        lines.push(format!("Build {} is being made: {}.", build.build, counted(build.copies, "copy", "copies")));
    }
    if let Some(last) = &row.last_published {
        let height_mm = last.height_mm.unwrap_or_default();
        lines.push(format!("Last build: {} on {}, {height_mm:.1} mm.", last.build, local(last.published_at.0)));
    }
    lines.join("\n") + "\n"
}

/// What waits, in words.
fn waiting_text(row: &ProfileStatus) -> String {
    let parts = counted(row.waiting_parts, "part", "parts");
    format!(
        "{} of {parts} {}",
        counted(row.waiting_copies, "copy", "copies"),
        if row.waiting_copies == 1 { "waits" } else { "wait" }
    )
}

/// Whether the open layout is of what waits now.
fn is_forecast(station: &Station, row: &ProfileStatus) -> bool {
    let layout = &station.open.layout;
    row.waiting_parts > 0 && layout.height_mm > 0.0 && layout.placed.len() <= row.waiting_copies as usize
}

/// One line on what machines do.
pub fn summary<'r>(machines: usize, rows: impl Iterator<Item = &'r ProfileStatus>) -> String {
    let (mut waiting, mut nesting) = (0, 0);
    for row in rows {
        waiting += row.waiting_copies;
        nesting += row.nesting.len();
    }
    let machines = counted(machines, "machine", "machines");
    let waiting = counted(waiting, "copy waits", "copies wait");
    format!("{machines}, {waiting}, {} in work", counted(nesting, "build", "builds"))
}

fn status_json(station: &Station, row: &ProfileStatus) -> serde_json::Value {
    let fires = fires_at(&station.profile, row);
    let nothing = Layout::default();
    let open = if is_forecast(station, row) { &station.open.layout } else { &nothing };
    json!({
        "profile": row.profile,
        "paused": row.paused.is_some(),
        "being_read_parts": row.claimed_parts,
        "waiting_parts": row.waiting_parts,
        "waiting_copies": row.waiting_copies,
        "refused_files": station.inbox.refused_kept,
        "open_build": {
            "height_mm": open.height_mm,
            "density": open.density,
            "copies": open.placed.len(),
            "height_share": open.height_mm / station.profile.build_volume().size_mm.z,
        },
        "fires_at_latest": fires.map(|fires| fires.at.to_string()),
        "fires_by": fires.map(|fires| fires.by),
        "in_work": row.nesting.iter().map(|b| json!({ "build": b.build, "copies": b.copies })).collect::<Vec<_>>(),
        "last_published": row.last_published.as_ref().map(|b| json!({
            "build": b.build, "height_mm": b.height_mm, "at": b.published_at, "file": b.file_name,
        })),
    })
}

/// `STATUS.txt` and `status.json` of a farm that has stopped: what is known, and that nothing happens.
fn last_words(station: &Station, row: &ProfileStatus) -> (String, String) {
    let (name, now) = (&station.profile.name, Timestamp::now());
    let mut text = format!(
        "{name}: nestd was stopped on {}: nobody looks here now, and nothing is built. What is dropped here is taken when it runs \
         again.\n",
        zoned(now)
    );
    if row.waiting_parts > 0 {
        text += &format!("{} until then.\n", waiting_text(row));
    }
    let json = json!({
        "profile": name,
        "running": false,
        "written_at": minute(now).to_string(),
        "waiting_parts": row.waiting_parts,
        "waiting_copies": row.waiting_copies,
        "fires_at_latest": null,
    });
    (text, format!("{json:#}\n"))
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
