//! Reaching a farm: its settings, its ledger, and times as people write and read them.

use anyhow::{Context, Result};
use jiff::{Span, Timestamp, civil::Date, tz::TimeZone};

use super::{Common, Usage, table::tell};
use crate::{
    ledger::{Ledger, Utc},
    settings::{self, Settings},
    tables::fields,
};

/// The settings of the farm; whatever is wrong with them is wrong use.
pub fn settings(common: &Common) -> Result<Settings> {
    settings::load(common.config.as_deref(), common.root.as_deref()).map_err(|error| {
        let chain = anyhow::Error::from(error);
        Usage(format!("{chain:#}")).into()
    })
}

/// The settings for a command that only looks: a machine file that is wrong is told, but hinders nobody.
pub fn settings_to_look(common: &Common) -> Result<Settings> {
    let loaded = settings::load_to_look(common.config.as_deref(), common.root.as_deref());
    let (settings, problems) = loaded.map_err(|error| Usage(format!("{:#}", anyhow::Error::from(error))))?;
    for problem in &problems {
        tell(&format!("warning: the configuration is wrong: {problem}"));
    }
    Ok(settings)
}

/// Runs `work` over the settings and the ledger that the daemon has made.
pub fn with_ledger<T>(common: &Common, work: impl AsyncFnOnce(&Settings, &Ledger) -> Result<T>) -> Result<T> {
    over(settings(common)?, work)
}

/// [`with_ledger`] for a command that only looks, and so goes on with what is right of the configuration.
pub fn look_at_ledger<T>(common: &Common, work: impl AsyncFnOnce(&Settings, &Ledger) -> Result<T>) -> Result<T> {
    over(settings_to_look(common)?, work)
}

/// Runs `work` over a farm's ledger.
pub fn over<T>(settings: Settings, work: impl AsyncFnOnce(&Settings, &Ledger) -> Result<T>) -> Result<T> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("cannot start")?;
    runtime.block_on(async {
        let ledger = Ledger::open_existing(&settings.ledger).await?;
        let done = work(&settings, &ledger).await;
        ledger.close().await;
        done
    })
}

/// Refuses a profile that is not configured, and names those that are.
pub fn demand_profile(settings: &Settings, profile: &str) -> Result<()> {
    if settings.profiles.contains_key(profile) {
        return Ok(());
    }
    let known: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
    Err(Usage(format!("there is no profile '{profile}'; there are: {}", known.join(", "))).into())
}

/// user@host, for the ledger.
pub fn who() -> String {
    let user = std::env::var("SUDO_USER").or_else(|_| std::env::var("USER"));
    let user = user.unwrap_or_else(|_| format!("uid {}", rustix::process::getuid().as_raw()));
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    format!("{user}@{}", host.trim())
}

/// A point in time as a person writes it: '7d' (ago), '2026-11-01' (its first moment, UTC) or RFC 3339.
pub fn time_of(text: &str, now: Timestamp) -> Result<Timestamp, String> {
    if let Ok(time) = text.parse::<Timestamp>() {
        return Ok(time);
    }
    let utc = TimeZone::UTC;
    if let Ok(date) = text.parse::<Date>() {
        return date.to_zoned(utc).map(|z| z.timestamp()).map_err(|e| e.to_string());
    }
    let ago: Span =
        text.parse().map_err(|_| format!("'{text}' is no age (7d, 12h), date (2026-11-01) or RFC 3339 time"))?;
    now.to_zoned(utc).checked_sub(ago.abs()).map(|z| z.timestamp()).map_err(|e| e.to_string())
}

/// [`time_of`] at this moment, as an argument of a command.
pub fn time_argument(text: &str) -> Result<Timestamp, String> {
    time_of(text, Timestamp::now())
}

/// A time with its zone: '2026-11-20 04:49:00 UTC'.
pub fn zoned(time: Option<Utc>) -> String {
    fields::TIME.with_unit(time).unwrap_or_else(|| "-".to_owned())
}

/// How long ago, to two units: '3h 5m'.
pub fn age(since: Option<Utc>, now: Timestamp) -> String {
    since.and_then(|since| since.age(now)).unwrap_or_else(|| "-".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_an_age_a_date_or_rfc_3339() {
        let now: Timestamp = "2026-11-20T04:49:00Z".parse().unwrap();
        let is = |text: &str, time: &str| assert_eq!(time_of(text, now).unwrap(), time.parse().unwrap(), "{text}");
        is("7d", "2026-11-13T04:49:00Z");
        is("90m", "2026-11-20T03:19:00Z");
        is("2w", "2026-11-06T04:49:00Z");
        is("2026-11-01", "2026-11-01T00:00:00Z");
        is("2026-11-01T06:00:00+02:00", "2026-11-01T04:00:00Z");
        assert!(time_of("yesterday", now).is_err() && time_of("7", now).is_err());
    }

    #[test]
    fn an_age_is_told_in_two_units() {
        let now: Timestamp = "2026-11-20T04:49:00Z".parse().unwrap();
        let of = |time: &str| age(Some(Utc(time.parse().unwrap())), now);
        assert_eq!(of("2026-11-20T04:48:48Z"), "12s");
        assert_eq!(of("2026-11-20T01:44:00Z"), "3h 5m");
        assert_eq!(of("2026-11-18T02:49:00Z"), "2d 2h");
        assert_eq!(age(None, now), "-");
    }
}
