//! Metrics for Prometheus, made of the ledger at each scrape: base units, `nestd_` before every name, labels only of what
//! is configured.

use std::{
    sync::{Arc, atomic::AtomicU64},
    time::{Duration, Instant},
};

use anyhow::Context;
use axum::{
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use prometheus_client::{
    encoding::text::encode,
    metrics::{counter::Counter, family::Family, gauge::Gauge, histogram::Histogram},
    registry::Registry,
};

use super::{problem::Answer, server::Web};
use crate::{ledger::Totals, settings::Settings};

type Number = Gauge<f64, AtomicU64>;
type Label = Vec<(&'static str, String)>;

/// Upper ends of the buckets of build heights, m.
const HEIGHTS_M: [f64; 9] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6];
/// Upper ends of the buckets of densities.
const DENSITIES: [f64; 8] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5];
/// Upper ends of the buckets of nesting durations, seconds.
const SECONDS: [f64; 9] = [1.0, 5.0, 15.0, 60.0, 180.0, 600.0, 1800.0, 3600.0, 14_400.0];
/// Totals look at every row: they are asked for again after so long.
const TOTALS_AGAIN: Duration = Duration::from_secs(60);

/// The totals as they were asked for last.
pub(super) type Kept = tokio::sync::Mutex<Option<(Instant, Arc<Totals>)>>;

/// What Prometheus is told of the text.
const CONTENT_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// The metrics.
pub(super) async fn metrics(State(web): State<Arc<Web>>) -> Answer<Response> {
    Ok(([(header::CONTENT_TYPE, CONTENT_TYPE)], text(&web).await?).into_response())
}

/// Whether the ledger answers, the daemon beats and every folder is there.
pub(super) async fn readyz(State(web): State<Arc<Web>>) -> Answer<Response> {
    let daemon = web.ledger.daemon().await?;
    let settings = web.settings();
    let gone: Vec<String> = settings
        .folders()
        .iter()
        .filter(|folder| !folder.is_dir())
        .map(|f| format!("{} is not there\n", f.display()))
        .collect();
    Ok(match (daemon.is_some_and(|d| d.alive), gone.is_empty()) {
        (true, true) => "ready\n".into_response(),
        (false, _) => (StatusCode::SERVICE_UNAVAILABLE, "the daemon does not beat\n").into_response(),
        (true, false) => (StatusCode::SERVICE_UNAVAILABLE, gone.concat()).into_response(),
    })
}

async fn text(web: &Web) -> Answer<String> {
    let mut registry = Registry::with_prefix("nestd");
    let (settings, status) = (web.settings(), web.ledger.status().await?);
    let totals = totals(web).await?;
    let daemon = web.ledger.daemon().await?;
    let mut per_profile = |name: &str, help: &str, value: &dyn Fn(&str) -> Option<f64>| {
        let family = Family::<Label, Number>::default();
        for profile in settings.profiles.keys() {
            if let Some(value) = value(profile) {
                family.get_or_create(&vec![("profile", profile.clone())]).set(value);
            }
        }
        registry.register(name, help, family);
    };
    let of = |profile: &str| status.iter().find(|s| s.profile == profile);
    let number = |value: u32| Some(f64::from(value));
    per_profile("parts_waiting", "Parts with a copy in no build", &|p| number(of(p).map_or(0, |s| s.waiting_parts)));
    per_profile("copies_waiting", "Copies in no build", &|p| number(of(p).map_or(0, |s| s.waiting_copies)));
    per_profile("parts_being_read", "Files that are taken and not read yet", &|p| {
        number(of(p).map_or(0, |s| s.claimed_parts))
    });
    per_profile("oldest_waiting_timestamp_seconds", "When the oldest waiting part was taken", &|p| {
        Some(of(p)?.oldest_at?.0.as_second() as f64)
    });
    per_profile("open_build_height_meters", "Height of the open build's layout so far", &|p| {
        Some(of(p)?.open.as_ref()?.height_mm? / 1000.0)
    });
    per_profile("paused", "1 while nothing is fired", &|p| {
        number(u32::from(of(p).is_some_and(|s| s.paused.is_some())))
    });
    per_profile("queue_available", "1 while the queue folder is there", &|p| {
        number(u32::from(settings.profiles.get(p)?.folders.queue.is_dir()))
    });
    per_profile("inbox_available", "1 while the hot folder is there", &|p| {
        number(u32::from(settings.profiles.get(p)?.folders.inbox.is_dir()))
    });
    daemon_metrics(&mut registry, daemon.as_ref());
    disk(&mut registry, &settings);
    counted(&mut registry, &totals);
    measured(&mut registry, &totals);
    let mut text = String::new();
    encode(&mut text, &registry).context("writing the metrics")?;
    Ok(text)
}

async fn totals(web: &Web) -> Answer<Arc<Totals>> {
    let mut kept = web.totals.lock().await;
    if let Some((at, totals)) = &*kept
        && at.elapsed() < TOTALS_AGAIN
    {
        return Ok(totals.clone());
    }
    let totals = Arc::new(web.ledger.totals().await?);
    *kept = Some((Instant::now(), totals.clone()));
    Ok(totals)
}

fn daemon_metrics(registry: &mut Registry, daemon: Option<&crate::ledger::DaemonRow>) {
    let (up, beat) = (Number::default(), Number::default());
    up.set(if daemon.is_some_and(|d| d.alive) { 1.0 } else { 0.0 });
    beat.set(daemon.map_or(0.0, |d| d.beat_at.0.as_second() as f64));
    registry.register("daemon_up", "1 while the daemon beats", up);
    registry.register("last_beat_timestamp_seconds", "Last sign of life of the daemon", beat);
}

fn disk(registry: &mut Registry, settings: &Settings) {
    let free = Number::default();
    if let Ok(stat) = rustix::fs::statvfs(&settings.state_dir) {
        free.set(stat.f_bavail as f64 * stat.f_frsize as f64);
    }
    registry.register("state_free_bytes", "Free space of the disk with ledger and store", free);
}

fn counted(registry: &mut Registry, totals: &Totals) {
    let by_state = |rows: &[(String, String, u64)]| {
        let (gauges, counters) = (Family::<Label, Number>::default(), Family::<Label, Counter>::default());
        for (profile, state, count) in rows {
            gauges.get_or_create(&vec![("profile", profile.clone()), ("state", state.clone())]).set(*count as f64);
            counters.get_or_create(&vec![("profile", profile.clone())]).inc_by(*count);
        }
        (gauges, counters)
    };
    let (parts, taken) = by_state(&totals.parts);
    registry.register("parts", "Parts by the state they are in", parts);
    registry.register("parts_ingested", "Parts ever taken out of the hot folders", taken);
    let (builds, begun) = by_state(&totals.builds);
    registry.register("builds", "Builds by the state they are in", builds);
    registry.register("builds_begun", "Builds ever begun", begun);
}

fn measured(registry: &mut Registry, totals: &Totals) {
    let (height, density, seconds) = (Histogram::new(HEIGHTS_M), Histogram::new(DENSITIES), Histogram::new(SECONDS));
    for build in &totals.measured {
        build.height_mm.into_iter().for_each(|mm| height.observe(mm / 1000.0));
        build.density.into_iter().for_each(|share| density.observe(share));
        build.wall_secs.into_iter().for_each(|secs| seconds.observe(secs));
    }
    registry.register("build_height_meters", "Heights of published builds", height);
    registry.register("build_density_ratio", "Part volume over box volume of published builds", density);
    registry.register("nesting_duration_seconds", "Final nesting of published builds", seconds);
}
