//! What the search that lowers an open build while it waits has cost and gained, in words.

use language::say;
use ledger::{NightState, OpenBuildForecast};

/// `1.24 mm lower after 350 CPU s since the last arrival, goes on`; `None` = it is switched off, or has not begun.
pub fn night_text(open: &OpenBuildForecast) -> Option<String> {
    let state = match open.night? {
        NightState::GoesOn => say!("night-goes-on"),
        NightState::StandsStill => say!("night-stands-still"),
        NightState::UsedUp => say!("night-used-up"),
        NightState::GivenUp => say!("night-given-up"),
    };
    Some(say!("night-since-arrival", gain = night_gain_text(open)?, state = state))
}

/// `1.24 mm lower after 350 CPU s`; `None` = it is switched off, or has not begun.
pub fn night_gain_text(open: &OpenBuildForecast) -> Option<String> {
    let secs = format!("{:.0}", open.night_cpu_secs?);
    match open.night_gain_mm? {
        gain if gain >= 0.005 => Some(say!("night-gain", gain = language::decimal(format!("{gain:.2}")), secs = secs)),
        _ => (secs != "0").then(|| say!("night-no-gain", secs = secs)),
    }
}

#[cfg(test)]
mod tests {
    use ledger::BuildId;

    use super::*;

    #[test]
    fn cost_and_gain_are_told_unless_there_are_none() {
        let open = |night| OpenBuildForecast {
            build: BuildId(1),
            height_mm: Some(50.0),
            density: None,
            copies: Some(3),
            night,
            night_cpu_secs: night.map(|_| 349.6),
            night_gain_mm: night.map(|_| 1.236),
        };
        let told = night_text(&open(Some(NightState::GoesOn)));
        assert_eq!(told.as_deref(), Some("1.24 mm lower after 350 CPU s since the last arrival, goes on"));
        assert_eq!(night_text(&open(None)), None);
        let without = |secs: f64| OpenBuildForecast {
            night_cpu_secs: Some(secs),
            night_gain_mm: Some(0.004),
            ..open(Some(NightState::GoesOn))
        };
        assert_eq!(night_gain_text(&without(349.6)).as_deref(), Some("not lower after 350 CPU s"));
        assert_eq!(night_text(&without(0.4)), None, "0.00 mm after 0 s is nothing to tell");
    }
}
