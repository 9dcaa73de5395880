//! What a command needs to work on a farm: its settings and its ledger; and times in the format that people write and
//! read.

use anyhow::{Context, Result, anyhow};
use jiff::{Span, Timestamp, civil::Date};
use ledger::{Ledger, LedgerError, UtcTimestamp};
use settings::{FarmZone, Settings};

use super::table::print_to_stderr;
use crate::cli::{CommonArgs, UsageError};

/// Loads the farm's settings; any error is a usage error.
pub fn load_settings(common: &CommonArgs) -> Result<Settings> {
    settings::load_settings(common.config.as_deref(), common.root.as_deref()).map_err(|error| {
        let chain = anyhow::Error::from(error);
        UsageError(format!("{chain:#}")).into()
    })
}

/// Loads the settings for a command that only reads: a wrong machine file gives a warning, and the command goes on.
pub fn load_settings_leniently(common: &CommonArgs) -> Result<Settings> {
    let loaded = settings::load_for_viewing(common.config.as_deref(), common.root.as_deref());
    let (settings, problems) = loaded.map_err(|error| UsageError(format!("{:#}", anyhow::Error::from(error))))?;
    for problem in &problems {
        print_to_stderr(&format!("warning: the configuration is wrong: {problem}"));
    }
    Ok(settings)
}

/// Runs `work` on the settings and on the ledger that the daemon has created.
pub fn with_ledger<T>(common: &CommonArgs, work: impl AsyncFnOnce(&Settings, &Ledger) -> Result<T>) -> Result<T> {
    run_with_ledger(load_settings(common)?, work)
}

/// Like [`with_ledger`], for a command that only reads: it goes on with the valid parts of the configuration.
pub fn with_ledger_to_read<T>(
    common: &CommonArgs,
    work: impl AsyncFnOnce(&Settings, &Ledger) -> Result<T>,
) -> Result<T> {
    run_with_ledger(load_settings_leniently(common)?, work)
}

/// Runs `work` on a farm's ledger.
pub fn run_with_ledger<T>(settings: Settings, work: impl AsyncFnOnce(&Settings, &Ledger) -> Result<T>) -> Result<T> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("cannot start")?;
    runtime.block_on(async {
        let ledger = match Ledger::open_existing(&settings.ledger).await {
            Err(missing @ LedgerError::Missing { .. }) => {
                let lost = farm::lost_ledger_text(&settings).map(|text| anyhow!("{text}"));
                return Err(lost.unwrap_or_else(|| missing.into()));
            }
            other => other?,
        };
        let done = match farm::with_other_nodes(settings, &ledger).await {
            Ok(settings) => work(&settings, &ledger).await,
            Err(error) => Err(error.into()),
        };
        ledger.close().await;
        done
    })
}

/// Refuses a machine that is not configured; the error names the configured ones.
pub fn require_machine(settings: &Settings, machine: &str) -> Result<()> {
    if settings.profiles.contains_key(machine) {
        return Ok(());
    }
    let known: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
    Err(UsageError(format!("there is no machine '{machine}'; there are: {}", known.join(", "))).into())
}

/// `user@host` of the operator, for the ledger.
pub fn user_at_host() -> String {
    let user = std::env::var("SUDO_USER").or_else(|_| std::env::var("USER"));
    let user = user.unwrap_or_else(|_| name_of_user(rustix::process::getuid().as_raw()));
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    format!("{user}@{}", host.trim())
}

/// The name that `/etc/passwd` gives to a user, else its number.
fn name_of_user(uid: u32) -> String {
    let known = std::fs::read_to_string("/etc/passwd").unwrap_or_default();
    let name = known.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(uid)).then(|| name.to_owned())
    });
    name.unwrap_or_else(|| format!("uid {uid}"))
}

/// Parses a time as a person writes it: `7d` (ago), `2026-11-01` (start of the day in the farm's zone) or RFC 3339.
pub fn parse_time(text: &str, now: Timestamp, zone: &FarmZone) -> Result<Timestamp, String> {
    if let Ok(time) = text.parse::<Timestamp>() {
        return Ok(time);
    }
    let zone = zone.time_zone();
    if let Ok(date) = text.parse::<Date>() {
        return date.to_zoned(zone.clone()).map(|z| z.timestamp()).map_err(|e| e.to_string());
    }
    let ago: Span =
        text.parse().map_err(|_| format!("'{text}' is no age (7d, 12h), date (2026-11-01) or RFC 3339 time"))?;
    now.to_zoned(zone.clone()).checked_sub(ago.abs()).map(|z| z.timestamp()).map_err(|e| e.to_string())
}

/// The time since `since` in two units: '3h 5m'.
pub fn format_age(since: Option<UtcTimestamp>, now: Timestamp) -> String {
    since.and_then(|since| since.age_text(now)).unwrap_or_else(|| "-".to_owned())
}

#[cfg(test)]
mod tests {
    use jiff::tz::TimeZone;

    use super::*;

    #[test]
    fn a_time_is_an_age_a_date_or_rfc_3339() {
        let now: Timestamp = "2026-11-20T04:49:00Z".parse().unwrap();
        let zone = |name: &str| FarmZone::from(TimeZone::get(name).unwrap());
        let (utc, berlin) = (zone("UTC"), zone("Europe/Berlin"));
        let is =
            |text: &str, time: &str| assert_eq!(parse_time(text, now, &utc).unwrap(), time.parse().unwrap(), "{text}");
        is("7d", "2026-11-13T04:49:00Z");
        is("90m", "2026-11-20T03:19:00Z");
        is("2w", "2026-11-06T04:49:00Z");
        is("2026-11-01", "2026-11-01T00:00:00Z");
        is("2026-11-01T06:00:00+02:00", "2026-11-01T04:00:00Z");
        assert_eq!(parse_time("2026-11-01", now, &berlin).unwrap().to_string(), "2026-10-31T23:00:00Z");
        assert!(parse_time("yesterday", now, &utc).is_err() && parse_time("7", now, &utc).is_err());
    }

    #[test]
    fn an_age_is_shown_in_two_units() {
        let now: Timestamp = "2026-11-20T04:49:00Z".parse().unwrap();
        let of = |time: &str| format_age(Some(UtcTimestamp(time.parse().unwrap())), now);
        assert_eq!(of("2026-11-20T04:48:48Z"), "12s");
        assert_eq!(of("2026-11-20T01:44:00Z"), "3h 5m");
        assert_eq!(of("2026-11-18T02:49:00Z"), "2d 2h");
        assert_eq!(format_age(None, now), "-");
    }
}
