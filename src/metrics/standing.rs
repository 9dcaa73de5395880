//! What stands now: what waits, what is in work, whether machines, folders and the daemon are as they should be.

use anyhow::Result;
use prometheus_client::{
    metrics::{family::Family, gauge::Gauge},
    registry::Registry,
};
use std::sync::atomic::AtomicU64;

use crate::{
    ledger::{DaemonRow, Ledger, ProfileStatus, StationRow, Utc},
    settings::Settings,
};

/// A number that goes up and down.
pub(super) type Number = Gauge<f64, AtomicU64>;
/// Names and values.
pub(super) type Labels = Vec<(&'static str, String)>;

/// Gauges of one farm at one moment.
struct Standing<'a> {
    registry: &'a mut Registry,
    profiles: Vec<String>,
    status: Vec<ProfileStatus>,
    stations: Vec<StationRow>,
}

/// Registers what stands now.
pub(super) async fn register(registry: &mut Registry, ledger: &Ledger, settings: &Settings) -> Result<()> {
    let daemon = ledger.daemon().await?;
    let is_up = daemon.as_ref().is_some_and(|daemon| daemon.alive);
    // What a daemon that is gone saw of the machines says nothing of them now.
    let stations = if is_up { ledger.stations().await? } else { Vec::new() };
    let profiles = settings.profiles.keys().cloned().collect();
    let mut standing = Standing { registry, profiles, status: ledger.status().await?, stations };
    standing.waiting();
    standing.in_work();
    standing.machines();
    of_daemon(registry, daemon.as_ref(), is_up);
    disk(registry, settings);
    Ok(())
}

impl Standing<'_> {
    /// A gauge with a value for each profile of which there is one.
    fn each(&mut self, name: &str, help: &str, value: impl Fn(Option<&ProfileStatus>, &str) -> Option<f64>) {
        let family = Family::<Labels, Number>::default();
        for profile in &self.profiles {
            let status = self.status.iter().find(|s| s.profile == *profile);
            if let Some(value) = value(status, profile) {
                family.get_or_create(&vec![("profile", profile.clone())]).set(value);
            }
        }
        self.registry.register(name, help, family);
    }

    /// Likewise, of what the daemon sees of a machine.
    fn seen(&mut self, name: &str, help: &str, value: impl Fn(&StationRow) -> Option<f64>) {
        let family = Family::<Labels, Number>::default();
        for station in self.stations.iter().filter(|s| self.profiles.contains(&s.profile)) {
            if let Some(value) = value(station) {
                family.get_or_create(&vec![("profile", station.profile.clone())]).set(value);
            }
        }
        self.registry.register(name, help, family);
    }

    fn waiting(&mut self) {
        let count = |value: u32| Some(f64::from(value));
        self.each("parts_waiting", "Parts with a copy in no build", |s, _| count(s.map_or(0, |s| s.waiting_parts)));
        self.each("copies_waiting", "Copies in no build", |s, _| count(s.map_or(0, |s| s.waiting_copies)));
        self.each("parts_being_read", "Parts that are taken and not read yet", |s, _| {
            count(s.map_or(0, |s| s.claimed_parts))
        });
        self.each("oldest_waiting_timestamp_seconds", "When the oldest waiting part was taken", |s, _| {
            Some(seconds(s?.oldest_at?))
        });
        self.each("next_due_timestamp_seconds", "The nearest due date of what waits", |s, _| Some(seconds(s?.due_at?)));
    }

    fn in_work(&mut self) {
        self.each("builds_in_work", "Builds that have fired and are not in the queue yet", |s, _| {
            Some(s.map_or(0, |s| s.nesting.len()) as f64)
        });
        self.each("open_build_height_meters", "Height of the open build's layout so far", |s, _| {
            Some(s?.open.as_ref()?.height_mm? / 1000.0)
        });
        self.each(
            "open_build_density_ratio",
            "Part volume over box volume of the open build's layout so far",
            |s, _| s?.open.as_ref()?.density,
        );
        self.each("paused", "1 while nothing is fired", |s, _| Some(one(s.is_some_and(|s| s.paused.is_some()))));
    }

    fn machines(&mut self) {
        self.seen("available", "1 while parts are taken and builds can be put into the queue", |s| {
            Some(one(s.trouble.is_empty()))
        });
        self.seen("inbox_available", "1 while the hot folder can be used", |s| Some(one(s.is_inbox_there)));
        self.seen("queue_writable", "1 while the queue folder can be written to", |s| Some(one(s.is_queue_writable)));
        self.seen("last_scan_timestamp_seconds", "When the hot folder was last looked through", |s| {
            Some(seconds(s.scanned_at?))
        });
    }
}

fn of_daemon(registry: &mut Registry, daemon: Option<&DaemonRow>, is_up: bool) {
    let version = Family::<Labels, Number>::default();
    version.get_or_create(&vec![("version", env!("CARGO_PKG_VERSION").to_owned())]).set(1.0);
    registry.register("version_info", "Which nestd tells this", version);
    plain(registry, "daemon_up", "1 while the daemon beats", one(is_up));
    if let Some(daemon) = daemon {
        plain(registry, "last_beat_timestamp_seconds", "Last sign of life of the daemon", seconds(daemon.beat_at));
    }
}

fn disk(registry: &mut Registry, settings: &Settings) {
    let Ok(stat) = rustix::fs::statvfs(&settings.state_dir) else { return };
    let bytes = |blocks: u64| blocks as f64 * stat.f_frsize as f64;
    plain(registry, "disk_free_bytes", "Free space of the disk with ledger and store", bytes(stat.f_bavail));
    plain(registry, "disk_size_bytes", "Size of the disk with ledger and store", bytes(stat.f_blocks));
}

/// A number without labels.
fn plain(registry: &mut Registry, name: &str, help: &str, value: f64) {
    let number = Number::default();
    number.set(value);
    registry.register(name, help, number);
}

fn one(is: bool) -> f64 {
    if is { 1.0 } else { 0.0 }
}

fn seconds(at: Utc) -> f64 {
    at.0.as_millisecond() as f64 / 1000.0
}
