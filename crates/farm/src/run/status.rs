//! The status of the farm: one line for the service manager, a heartbeat in the ledger, and `STATUS.txt` and
//! `status.json` in each hot folder.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use anyhow::Result;
use jiff::Timestamp;
use language::say;
use ledger::{LedgerError, MachineStatus, NodeHeartbeat};
use serde_json::json;

use super::{
    status_alerts,
    unserved::{self, WriteStatusJob, halted_status, waiting_text},
};
use crate::{
    again::part_questions,
    alerts::alert::AlertKind,
    core::{
        desks::{Shared, Showing},
        farm::TICK_INTERVAL,
        machine_state::MachineState,
    },
    decisions::{layout::BatchLayout, night_text::night_text, queue_depth::held_text},
    facts::{machine_fact::MachineFact, material_fact::MaterialReading, read_facts::FarmReading},
    nodes::machine_availability,
    open_build::due_dates,
    planning::DateRisk,
    process::{systemd, tick_tasks::TimedTask},
    receive::control_files,
    records::lost_ledger,
};

/// Failures that did not occur again for this long, or for three scans, are over.
const FAILURE_EXPIRY: Duration = Duration::from_secs(150);
/// Maximum number of parts with an open question in `status.json`, of each kind.
const MAX_QUESTIONS: u32 = 100;
/// Interval of the status updates, each of which queries the whole ledger.
const STATUS_INTERVAL: Duration = Duration::from_secs(2);
/// The same while the ledger has no news: only the time changes what is said.
const STATUS_INTERVAL_AT_REST: Duration = Duration::from_secs(30);

/// Updates the status everywhere.
pub(super) async fn update_status(desk: &mut Showing<'_>) -> Result<()> {
    let interval = if desk.display.is_behind { STATUS_INTERVAL } else { STATUS_INTERVAL_AT_REST };
    if desk.display.updated_at.is_some_and(|at| desk.shared.schedule.time.passed_since(at) < interval) {
        return Ok(());
    }
    desk.display.updated_at = Some(desk.shared.now());
    desk.display.is_behind = false;
    control_files::update_answers(desk.shared.ledger, desk.machines).await?;
    let asked = desk.shared.ledger.parts_with_questions(MAX_QUESTIONS).await?;
    let materials = MaterialReading::read(desk.shared.ledger, &desk.shared.settings.materials).await?;
    let now = desk.shared.date();
    let profiles: Vec<_> = desk.machines.values().map(|machine| machine.profile.clone()).collect();
    let reading = FarmReading::read(desk.shared.ledger, profiles.iter().map(|profile| &**profile), now).await?;
    let (facts, rows) = (reading.facts(), &reading.rows.statuses);
    let own = rows.iter().filter(|row| desk.machines.contains_key(&row.machine));
    desk.display.is_work_under_way = own.into_iter().any(|row| row.claimed_parts > 0 || !row.nesting.is_empty());
    let event = desk.shared.ledger.last_event_id().await?;
    if desk.display.dates.is_due(event, desk.shared.now()) {
        let began = Instant::now();
        let risks = reading.dates_at_risk(desk.shared.ledger).await?;
        desk.display.dates.take_in(risks, event, desk.shared.now(), began.elapsed());
    }
    let risks = &desk.display.dates.risks;
    // Programs read English, people their own language.
    let language = desk.shared.settings.language;
    let told = language.within(|| reading.facts());
    for (((name, machine), fact), told) in desk.machines.iter_mut().zip(&facts).zip(&told) {
        let risks: Vec<&DateRisk> = risks.iter().filter(|risk| risk.machine == *name).collect();
        let row = MachineStatus::of_machine(rows, name);
        let text = language.within(|| {
            let status = status_text(machine, &row, (told, &risks), now);
            status + &materials.status_lines(&row) + &part_questions::questions_text(name, &asked)
        });
        let mut json = status_json(machine, &row, (fact, &risks), now);
        json["questions"] = part_questions::questions_json(name, &asked, &materials);
        json["awaiting"] = materials.status_json(&row);
        machine.status = (text, json);
    }
    unserved::tell_gone_nodes(desk, &reading.rows.observed).await?;
    status_alerts::update_ledger_alerts(&mut desk.shared, desk.machines, rows, &reading.rows.observed).await?;
    due_dates::check_due_dates(&desk.shared, desk.machines, &desk.display.dates.risks).await?;
    let line = farm_summary(desk.machines.len(), rows.iter());
    if line != desk.display.status_line {
        systemd::notify_status(&line);
        desk.display.status_line = line;
        // Otherwise the ledger would show the old line until the next heartbeat.
        let now = desk.shared.now();
        desk.shared.schedule.tasks.make_due(TimedTask::WriteHeartbeat, now);
    }
    Ok(())
}

/// Stores the alerts for `nestd status`. A halted farm also writes them into the hot folders, which otherwise each
/// scan does.
pub(super) async fn publish_alerts(desk: &mut Showing<'_>) {
    let over = FAILURE_EXPIRY.max(Duration::from_secs_f64(3.0 * desk.shared.settings.scan_secs));
    desk.shared.alerts.clear_expired_failures(over);
    for ((kind, about), why) in desk.shared.lifecycle.services.service_reports() {
        match why {
            None => desk.shared.alerts.clear(kind, "", &about),
            Some(why) => desk.shared.alerts.raise(kind, "", &about, &why),
        }
    }
    let is_cut_off = status_alerts::is_cut_off(&desk.shared);
    status_alerts::record_alerts(&mut desk.shared).await;
    desk.shared.alerts.write_if_changed(&desk.shared.settings.state_dir);
    if !(desk.shared.lifecycle.is_halted || is_cut_off)
        || desk.display.updated_at.is_some_and(|at| desk.shared.schedule.time.passed_since(at) < STATUS_INTERVAL)
    {
        return;
    }
    desk.display.updated_at = Some(desk.shared.now());
    for (name, machine) in desk.machines.iter() {
        let status = halted_status(machine, &desk.shared, true);
        WriteStatusJob::start_in(desk.jobs, name, &machine.profile.folders.inbox, status, || true);
    }
}

/// The ledger's file was removed, replaced or overwritten: saves what the daemon knows beside it, and halts.
pub(super) async fn abandon_replaced_ledger(shared: &mut Shared<'_>, why: &LedgerError) {
    if let LedgerError::Overwritten { what, .. } = why {
        return shared.halt(AlertKind::LedgerReplaced, what);
    }
    let mut file = shared.ledger.file().unwrap_or(Path::new("")).as_os_str().to_owned();
    file.push(lost_ledger::SAVED);
    file.push(Timestamp::now().strftime("%Y%m%dT%H%M%SZ").to_string());
    let (file, ledger) = (std::path::PathBuf::from(file), shared.ledger.clone());
    let saving = ledger.write_backup(&file);
    tokio::pin!(saving);
    let saved = loop {
        tokio::select! {
            saved = &mut saving => break saved,
            () = tokio::time::sleep(TICK_INTERVAL) => systemd::notify_watchdog(),
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
    shared.halt(AlertKind::LedgerReplaced, &detail);
    // On closing, SQLite would remove the write-ahead log of the ledger that is there now.
    std::mem::forget(shared.ledger.clone());
}

/// Writes a heartbeat into the ledger.
pub(crate) async fn write_heartbeat(desk: &mut Showing<'_>) -> Result<()> {
    desk.shared.ledger.write_heartbeat(&describe_node(desk)).await?;
    desk.shared.alerts.clear(AlertKind::ChangesWait, "", "");
    Ok(())
}

/// This node, as its heartbeats name it.
pub(super) fn describe_node(desk: &Showing<'_>) -> NodeHeartbeat {
    let node = &desk.shared.settings.node;
    NodeHeartbeat {
        name: node.name.clone(),
        address: node.address.clone().unwrap_or_default(),
        pid: std::process::id(),
        host: rustix::system::uname().nodename().to_string_lossy().into_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        started_at: desk.shared.lifecycle.started_at,
        status: desk.display.status_line.clone(),
        alerts: desk.shared.alerts.to_row(),
        machines: machine_availability::observed_machines(desk),
        configured: desk.shared.settings.profiles.keys().cloned().collect(),
    }
}

/// The status for the technician at the shared folder; lengths in mm, times in the zone of the farm.
fn status_text(
    machine: &MachineState,
    row: &MachineStatus,
    (fact, risks): (&MachineFact, &[&DateRisk]),
    now: Timestamp,
) -> String {
    let (profile, zone) = (&machine.profile, &machine.profile.time_zone);
    let mut lines = vec![
        say!("status-drop", machine = &profile.name, formats = say!("drop-formats")),
        say!("status-now", doing = &fact.doing),
    ];
    lines.extend(
        risks.iter().map(|risk| say!("job-described", name = risk.subject_text(), what = risk.in_words(zone, now))),
    );
    if let Some(paused) = &row.paused {
        let since = zone.format_minute(paused.paused_at.0);
        lines.push(say!("status-paused", by = &paused.paused_by, time = since));
    }
    if machine.printers.are_all_down() {
        lines.push(say!("status-no-printer"));
    }
    lines.push(match row.waiting_parts {
        0 => say!("nothing-waits"),
        _ => waiting_text(row) + ".",
    });
    if row.claimed_parts > 0 {
        lines.push(say!("status-being-read", files = row.claimed_parts));
    }
    if is_layout_current(machine, row) {
        let (height_mm, volume_z_mm) = (machine.open.layout.height_mm, profile.build_volume().size_mm.z);
        let (height, share) =
            (language::decimal(format!("{height_mm:.1}")), format!("{:.0}", 100.0 * height_mm / volume_z_mm));
        lines.push(say!("status-open-build", height = height, share = share));
        if let Some(night) = row.open.as_ref().and_then(night_text) {
            lines.push(say!("status-while-waiting", night = night));
        }
    }
    if let Some(fires) = fact.forecast_fire(profile, row, now) {
        lines.push(say!("status-fires", when = fires.fire_text(profile, row)));
    }
    lines.extend(held_text(profile, row).map(|held| say!("status-held", why = held)));
    if !machine.inbox.controls.answer.is_empty() {
        lines.push(language::told(&machine.inbox.controls.answer));
    }
    lines.extend(machine.left_out.texts().map(language::told));
    if let Some(last) = &row.last_published {
        let height_mm = last.height_mm.unwrap_or_default();
        let (time, height) = (zone.format_minute(last.published_at.0), language::decimal(format!("{height_mm:.1}")));
        lines.push(say!("status-last-build", build = last.build.to_string(), time = time, height = height));
    }
    lines.join("\n") + "\n"
}

/// Whether the open layout belongs to the parts that wait now.
fn is_layout_current(machine: &MachineState, row: &MachineStatus) -> bool {
    let layout = &machine.open.layout;
    row.waiting_parts > 0 && layout.height_mm > 0.0 && layout.placed.len() <= row.waiting_copies as usize
}

/// One line on what the machines do.
pub fn farm_summary<'r>(machines: usize, rows: impl Iterator<Item = &'r MachineStatus>) -> String {
    let (mut waiting, mut nesting) = (0, 0);
    for row in rows {
        waiting += row.waiting_copies;
        nesting += row.nesting.len();
    }
    let machines = say!("count-machines", count = machines);
    let waiting = say!("count-copies-wait", count = waiting);
    let nesting = say!("count-builds-in-work", count = nesting);
    language::join_names([machines, waiting, nesting])
}

fn status_json(
    machine: &MachineState,
    row: &MachineStatus,
    (fact, risks): (&MachineFact, &[&DateRisk]),
    now: Timestamp,
) -> serde_json::Value {
    let fires = fact.forecast_fire(&machine.profile, row, now);
    let nothing = BatchLayout::default();
    let open = if is_layout_current(machine, row) { &machine.open.layout } else { &nothing };
    json!({
        "machine": row.machine,
        "state": fact.state,
        "doing": fact.doing,
        "free_at": fact.free_at,
        "printers": fact.printers,
        "dates_at_risk": risks,
        "paused": row.paused.is_some(),
        "material": row.material, "lot": row.lot,
        "being_read_parts": row.claimed_parts,
        "waiting_parts": row.waiting_parts,
        "waiting_copies": row.waiting_copies,
        "collecting_copies": row.collecting_copies,
        "asked_copies": row.asked_copies,
        "refused_files": machine.inbox.refused_file_count,
        "open_build": {
            "height_mm": open.height_mm,
            "density": open.density,
            "copies": open.placed.len(),
            "height_share": open.height_mm / machine.profile.build_volume().size_mm.z,
            "night": row.open.as_ref().and_then(|open| open.night),
            "night_cpu_secs": row.open.as_ref().and_then(|open| open.night_cpu_secs),
            "night_gain_mm": row.open.as_ref().and_then(|open| open.night_gain_mm),
        },
        "fires_at": fires.map(|fires| fires.at.to_string()),
        "fires_at_latest": fires.map(|fires| fires.latest.to_string()),
        "fires_by": fires.map(|fires| fires.by),
        "left_out": machine.left_out.texts().collect::<Vec<_>>(),
        "in_work": row.nesting.iter().map(|b| json!({ "build": b.build, "copies": b.copies })).collect::<Vec<_>>(),
        "last_published": row.last_published.as_ref().map(|b| json!({
            "build": b.build, "height_mm": b.height_mm, "at": b.published_at, "file": b.file_name,
        })),
    })
}
