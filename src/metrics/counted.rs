//! What is counted over all time, and what was measured of every build.

use prometheus_client::{
    metrics::{counter::Counter, family::Family, histogram::Histogram},
    registry::Registry,
};

use super::standing::{Labels, Number};
use crate::{
    ledger::{BuildCount, Measured, Refusal, Totals},
    settings::Settings,
};

/// Upper ends of the buckets of build heights, m.
const HEIGHTS_M: [f64; 9] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6];
/// Upper ends of the buckets of densities.
const DENSITIES: [f64; 8] = [0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5];
/// Upper ends of the buckets of nesting durations, seconds.
const SECONDS: [f64; 9] = [1.0, 5.0, 15.0, 60.0, 180.0, 600.0, 1800.0, 3600.0, 14_400.0];
/// What can become of a build; all but the first two are told by people, of published ones.
const OUTCOMES: [&str; 5] = ["published", "given_up", "complete", "interrupted", "failed"];

/// Registers the totals. A profile that is configured has all its counters from the start, at 0: what begins with 1 is no
/// increase to Prometheus.
pub(super) fn register(registry: &mut Registry, totals: &Totals, settings: &Settings) {
    let profiles: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
    files(registry, totals, &profiles);
    builds(registry, totals, &profiles);
    measured(registry, &totals.measured, &profiles);
}

fn files(registry: &mut Registry, totals: &Totals, profiles: &[&str]) {
    let parts = Family::<Labels, Number>::default();
    for (profile, state, count) in &totals.parts {
        parts.get_or_create(&of(profile, "state", state)).set(*count as f64);
    }
    registry.register("parts", "Parts by the state they are in", parts);
    let ingested = Family::<Labels, Counter>::default();
    let refused = Family::<Labels, Counter>::default();
    for profile in profiles {
        let _ = ingested.get_or_create(&vec![("profile", (*profile).to_owned())]);
        for kind in Refusal::ALL {
            let _ = refused.get_or_create(&of(profile, "reason", &kind.to_string()));
        }
    }
    for (profile, count) in &totals.files {
        ingested.get_or_create(&vec![("profile", profile.clone())]).inc_by(*count);
    }
    for (profile, cause, count) in &totals.refused {
        let known = Refusal::ALL.iter().find(|kind| kind.to_string() == *cause).unwrap_or(&Refusal::Other);
        refused.get_or_create(&of(profile, "reason", &known.to_string())).inc_by(*count);
    }
    registry.register("files_ingested", "Files ever taken out of the hot folders", ingested);
    registry.register("files_refused", "Files ever refused or cancelled, by the kind of reason", refused);
}

fn builds(registry: &mut Registry, totals: &Totals, profiles: &[&str]) {
    let states = Family::<Labels, Number>::default();
    let outcomes = Family::<Labels, Counter>::default();
    let unproved = Family::<Labels, Counter>::default();
    for profile in profiles {
        for outcome in OUTCOMES {
            let _ = outcomes.get_or_create(&of(profile, "outcome", outcome));
        }
        let _ = unproved.get_or_create(&vec![("profile", (*profile).to_owned())]);
    }
    for count in &totals.builds {
        states.get_or_create(&of(&count.profile, "state", &count.state)).inc_by(count.builds as f64);
        for outcome in outcomes_of(count) {
            outcomes.get_or_create(&of(&count.profile, "outcome", outcome)).inc_by(count.builds);
        }
    }
    for (profile, count) in &totals.unproved {
        unproved.get_or_create(&vec![("profile", profile.clone())]).inc_by(*count);
    }
    registry.register("builds", "Builds by the state they are in", states);
    let help = "Builds ever published or given up, and what was told of published ones";
    registry.register("build_outcomes", help, outcomes);
    registry.register("proof_failures", "Written builds that could not be proved", unproved);
}

/// What became of builds: that they were published stays true whatever was told of them later.
fn outcomes_of(count: &BuildCount) -> Vec<&'static str> {
    let told = OUTCOMES[2..].iter().find(|outcome| **outcome == count.state);
    match (count.is_published, count.state.as_str()) {
        (true, _) => ["published"].into_iter().chain(told.copied()).collect(),
        (false, "failed") => vec!["given_up"],
        (false, _) => Vec::new(),
    }
}

fn measured(registry: &mut Registry, builds: &[Measured], profiles: &[&str]) {
    let heights = Family::<Labels, Histogram>::new_with_constructor(|| Histogram::new(HEIGHTS_M));
    let densities = Family::<Labels, Histogram>::new_with_constructor(|| Histogram::new(DENSITIES));
    let seconds = Family::<Labels, Histogram>::new_with_constructor(|| Histogram::new(SECONDS));
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

fn of(profile: &str, name: &'static str, value: &str) -> Labels {
    vec![("profile", profile.to_owned()), (name, value.to_owned())]
}
