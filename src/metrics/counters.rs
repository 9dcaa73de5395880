//! Counters over all time, and histograms of what was measured for each build.

use ledger::{BuildCount, FarmTotals, MeasuredBuild, RefusalCause};
use prometheus_client::{
    metrics::{counter::Counter, family::Family, histogram::Histogram},
    registry::Registry,
};

use super::gauges::{FloatGauge, LabelPairs};
use crate::settings::Settings;

/// Upper bounds of the buckets of build heights, m.
const HEIGHTS_M: [f64; 9] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6];
/// Upper bounds of the buckets of densities.
const DENSITIES: [f64; 8] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5];
/// Upper bounds of the buckets of nesting durations, seconds.
const SECONDS: [f64; 9] = [1.0, 5.0, 15.0, 60.0, 180.0, 600.0, 1800.0, 3600.0, 14_400.0];
/// Possible outcomes of a build. All but the first three are entered by people for published builds.
const OUTCOMES: [&str; 6] = ["published", "given_up", "withdrawn", "complete", "interrupted", "failed"];

/// Registers the totals. Every configured profile has all of its counters from the start, at 0: Prometheus does not see
/// an increase if a counter starts at 1.
pub(super) fn register_counters(registry: &mut Registry, totals: &FarmTotals, settings: &Settings) {
    let profiles: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
    register_file_metrics(registry, totals, &profiles);
    register_build_metrics(registry, totals, &profiles);
    register_build_histograms(registry, &totals.measured, &profiles);
}

fn register_file_metrics(registry: &mut Registry, totals: &FarmTotals, profiles: &[&str]) {
    let parts = Family::<LabelPairs, FloatGauge>::default();
    for (profile, state, count) in &totals.parts {
        parts.get_or_create(&profile_labels(profile, "state", state)).set(*count as f64);
    }
    registry.register("parts", "Parts by the state they are in", parts);
    let ingested = Family::<LabelPairs, Counter>::default();
    let refused = Family::<LabelPairs, Counter>::default();
    for profile in profiles {
        let _ = ingested.get_or_create(&vec![("profile", (*profile).to_owned())]);
        for kind in RefusalCause::ALL {
            let _ = refused.get_or_create(&profile_labels(profile, "reason", &kind.to_string()));
        }
    }
    for (profile, count) in &totals.files {
        ingested.get_or_create(&vec![("profile", profile.clone())]).inc_by(*count);
    }
    for (profile, cause, count) in &totals.refused {
        let known = RefusalCause::ALL.iter().find(|kind| kind.to_string() == *cause).unwrap_or(&RefusalCause::Other);
        refused.get_or_create(&profile_labels(profile, "reason", &known.to_string())).inc_by(*count);
    }
    registry.register("files_ingested", "Files ever taken out of the hot folders", ingested);
    registry.register("files_refused", "Files ever refused or cancelled, by the kind of reason", refused);
}

fn register_build_metrics(registry: &mut Registry, totals: &FarmTotals, profiles: &[&str]) {
    let states = Family::<LabelPairs, FloatGauge>::default();
    let outcomes = Family::<LabelPairs, Counter>::default();
    let unproved = Family::<LabelPairs, Counter>::default();
    for profile in profiles {
        for outcome in OUTCOMES {
            let _ = outcomes.get_or_create(&profile_labels(profile, "outcome", outcome));
        }
        let _ = unproved.get_or_create(&vec![("profile", (*profile).to_owned())]);
    }
    for count in &totals.builds {
        states.get_or_create(&profile_labels(&count.profile, "state", &count.state)).inc_by(count.builds as f64);
        for outcome in build_outcomes(count) {
            outcomes.get_or_create(&profile_labels(&count.profile, "outcome", outcome)).inc_by(count.builds);
        }
    }
    for (profile, count) in &totals.unproved {
        unproved.get_or_create(&vec![("profile", profile.clone())]).inc_by(*count);
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

fn register_build_histograms(registry: &mut Registry, builds: &[MeasuredBuild], profiles: &[&str]) {
    let heights = Family::<LabelPairs, Histogram>::new_with_constructor(|| Histogram::new(HEIGHTS_M));
    let densities = Family::<LabelPairs, Histogram>::new_with_constructor(|| Histogram::new(DENSITIES));
    let seconds = Family::<LabelPairs, Histogram>::new_with_constructor(|| Histogram::new(SECONDS));
    for family in [&heights, &densities, &seconds] {
        profiles.iter().for_each(|profile| drop(family.get_or_create(&vec![("profile", (*profile).to_owned())])));
    }
    for build in builds {
        let of = vec![("profile", build.profile.clone())];
        build.height_mm.into_iter().for_each(|mm| heights.get_or_create(&of).observe(mm / 1000.0));
        build.density.into_iter().for_each(|share| densities.get_or_create(&of).observe(share));
        build.wall_secs.into_iter().for_each(|secs| seconds.get_or_create(&of).observe(secs));
    }
    registry.register("build_height_meters", "Heights of published builds", heights);
    registry.register("build_density_ratio", "Part volume over box volume of published builds", densities);
    registry.register("nesting_duration_seconds", "Final nesting of published builds", seconds);
}

fn profile_labels(profile: &str, name: &'static str, value: &str) -> LabelPairs {
    vec![("profile", profile.to_owned()), (name, value.to_owned())]
}
