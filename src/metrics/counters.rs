//! Counters over all time, and histograms of what was measured for each build.

use ledger::{BuildCount, FarmTotals, MeasuredBuild, RefusalCause};
use prometheus_client::{
    metrics::{counter::Counter, family::Family, histogram::Histogram},
    registry::Registry,
};
use settings::Settings;

use super::gauges::{FloatGauge, LabelPairs};

/// Upper bounds of the buckets of build heights, m.
const HEIGHTS_M: [f64; 9] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6];
/// Upper bounds of the buckets of densities.
const DENSITIES: [f64; 8] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5];
/// Upper bounds of the buckets of nesting durations, seconds.
const SECONDS: [f64; 9] = [1.0, 5.0, 15.0, 60.0, 180.0, 600.0, 1800.0, 3600.0, 14_400.0];
/// Possible outcomes of a build. All but the first three are entered by people for published builds.
const OUTCOMES: [&str; 6] = ["published", "given_up", "withdrawn", "complete", "interrupted", "failed"];

/// Registers the totals. Every configured machine has all of its counters from the start, at 0: Prometheus does not see
/// an increase if a counter starts at 1.
pub(super) fn register_counters(registry: &mut Registry, totals: &FarmTotals, settings: &Settings) {
    let machines: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
    register_file_metrics(registry, totals, &machines);
    register_build_metrics(registry, totals, &machines);
    register_build_histograms(registry, &totals.measured, &machines);
}

fn register_file_metrics(registry: &mut Registry, totals: &FarmTotals, machines: &[&str]) {
    let parts = Family::<LabelPairs, FloatGauge>::default();
    for (machine, state, count) in &totals.parts {
        parts.get_or_create(&machine_labels(machine, "state", state)).set(*count as f64);
    }
    registry.register("parts", "Parts by the state they are in", parts);
    let ingested = Family::<LabelPairs, Counter>::default();
    let refused = Family::<LabelPairs, Counter>::default();
    for machine in machines {
        let _ = ingested.get_or_create(&vec![("machine", (*machine).to_owned())]);
        for kind in RefusalCause::ALL {
            let _ = refused.get_or_create(&machine_labels(machine, "reason", &kind.to_string()));
        }
    }
    for (machine, count) in &totals.files {
        ingested.get_or_create(&vec![("machine", machine.clone())]).inc_by(*count);
    }
    for (machine, cause, count) in &totals.refused {
        let known = RefusalCause::ALL.iter().find(|kind| kind.to_string() == *cause).unwrap_or(&RefusalCause::Other);
        refused.get_or_create(&machine_labels(machine, "reason", &known.to_string())).inc_by(*count);
    }
    registry.register("files_ingested", "Files ever taken out of the hot folders", ingested);
    registry.register("files_refused", "Files ever refused or cancelled, by the kind of reason", refused);
}

fn register_build_metrics(registry: &mut Registry, totals: &FarmTotals, machines: &[&str]) {
    let states = Family::<LabelPairs, FloatGauge>::default();
    let outcomes = Family::<LabelPairs, Counter>::default();
    let unproved = Family::<LabelPairs, Counter>::default();
    for machine in machines {
        for outcome in OUTCOMES {
            let _ = outcomes.get_or_create(&machine_labels(machine, "outcome", outcome));
        }
        let _ = unproved.get_or_create(&vec![("machine", (*machine).to_owned())]);
    }
    for count in &totals.builds {
        states.get_or_create(&machine_labels(&count.machine, "state", &count.state)).inc_by(count.builds as f64);
        for outcome in build_outcomes(count) {
            outcomes.get_or_create(&machine_labels(&count.machine, "outcome", outcome)).inc_by(count.builds);
        }
    }
    for (machine, count) in &totals.unproved {
        unproved.get_or_create(&vec![("machine", machine.clone())]).inc_by(*count);
    }
    registry.register("builds", "Builds by the state they are in", states);
    let help = "Builds ever published or given up, and outcomes entered for published ones";
    registry.register("build_outcomes", help, outcomes);
    registry.register("proof_failures", "Written builds that could not be proved", unproved);
}

/// The outcomes of builds. A published build always counts as published, whatever outcome was entered later.
fn build_outcomes(count: &BuildCount) -> Vec<&'static str> {
    let outcome = OUTCOMES[2..].iter().find(|outcome| **outcome == count.state);
    match (count.is_published, count.state.as_str()) {
        (true, _) => ["published"].into_iter().chain(outcome.copied()).collect(),
        (false, "failed") => vec!["given_up"],
        (false, _) => Vec::new(),
    }
}

fn register_build_histograms(registry: &mut Registry, builds: &[MeasuredBuild], machines: &[&str]) {
    let heights = Family::<LabelPairs, Histogram>::new_with_constructor(|| Histogram::new(HEIGHTS_M));
    let densities = Family::<LabelPairs, Histogram>::new_with_constructor(|| Histogram::new(DENSITIES));
    let seconds = Family::<LabelPairs, Histogram>::new_with_constructor(|| Histogram::new(SECONDS));
    for family in [&heights, &densities, &seconds] {
        machines.iter().for_each(|machine| drop(family.get_or_create(&vec![("machine", (*machine).to_owned())])));
    }
    for build in builds {
        let of = vec![("machine", build.machine.clone())];
        build.height_mm.into_iter().for_each(|mm| heights.get_or_create(&of).observe(mm / 1000.0));
        build.density.into_iter().for_each(|share| densities.get_or_create(&of).observe(share));
        build.wall_secs.into_iter().for_each(|secs| seconds.get_or_create(&of).observe(secs));
    }
    registry.register("build_height_meters", "Heights of published builds", heights);
    registry.register("build_density_ratio", "Part volume over box volume of published builds", densities);
    registry.register("nesting_duration_seconds", "Final nesting of published builds", seconds);
}

fn machine_labels(machine: &str, name: &'static str, value: &str) -> LabelPairs {
    vec![("machine", machine.to_owned()), (name, value.to_owned())]
}
