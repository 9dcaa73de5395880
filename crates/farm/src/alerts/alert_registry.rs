//! The active alerts. They are logged as errors when they are raised, stored in a file of the state folder for `nestd
//! status`, and shown in the hot folders. The file does not need the ledger, which may itself be the cause.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    time::{Duration, Instant},
};

use language::say;
use tracing::{debug, error, info, warn};

use super::{
    alert::{AlertKind, FarmAlert},
    alert_summary::AlertSummary,
    stored_alerts::{read_stored_alerts, write_alerts},
};
use crate::process::time_source::TimeSource;

/// A failure that ends within this time needs no person.
const ALERT_AFTER: Duration = Duration::from_secs(10);
/// The same failure is logged again after this time.
const LOG_REPEAT_INTERVAL: Duration = Duration::from_secs(600);
/// Maximum number of different failures remembered.
const MAX_FAILURES: usize = 1000;
/// If a farm has more alerts than this, `STATUS.txt` gives only the number of the others.
const MAX_LISTED_ALERTS: usize = 8;

/// The key of an alert: kind, machine, and subject.
type AlertKey = (AlertKind, String, String);

/// A changed detail of the same alert is logged at this interval at most.
const DETAIL_LOG_INTERVAL: Duration = Duration::from_secs(60);

/// A failure that is retried.
#[derive(Debug)]
struct RepeatedFailure {
    detail: String,
    first: Instant,
    last: Instant,
    logged: Instant,
}

/// Most alerts that are kept until the ledger can record them.
const MAX_UNRECORDED: usize = 100;

/// All alerts, and the failures that may become alerts.
#[derive(Debug, Default)]
pub struct AlertRegistry {
    active: BTreeMap<AlertKey, (FarmAlert, Instant)>,
    /// Alerts that were raised, and have no event in the ledger yet.
    unrecorded: Vec<FarmAlert>,
    /// Kind and machine of the alerts of the last run, of which there is an event.
    of_last_run: BTreeSet<(AlertKind, String)>,
    failures: BTreeMap<AlertKey, RepeatedFailure>,
    last_written: Option<Vec<FarmAlert>>,
    time: TimeSource,
}

impl AlertRegistry {
    /// Notices whose ages these clocks measure.
    pub fn by(time: TimeSource) -> Self {
        Self { time, ..Self::default() }
    }

    /// Same as [`AlertRegistry::by`] for a farm: what the last run stored needs no second event.
    pub fn after_last_run(time: TimeSource, state_dir: &Path) -> Self {
        let stored = read_stored_alerts(state_dir).into_iter();
        Self { of_last_run: stored.map(|alert| (alert.kind, alert.machine)).collect(), ..Self::by(time) }
    }

    /// Raises an alert, which stays until it is cleared.
    pub fn raise(&mut self, kind: AlertKind, machine: &str, about: &str, detail: &str) {
        // Names may contain control sequences for a terminal.
        let detail = &intake::display_name(detail.as_ref()).replace("\\\\", "\\");
        let key = (kind, machine.to_owned(), about.to_owned());
        let known = self.active.get(&key);
        if known.is_some_and(|(known, _)| known.detail == *detail) {
            return;
        }
        let since = known.map_or_else(|| self.time.date(), |(known, _)| known.since);
        let alert = FarmAlert { kind, machine: machine.to_owned(), detail: detail.clone(), since, node: String::new() };
        let logged = match known {
            Some((_, logged)) if self.time.passed_since(*logged) < DETAIL_LOG_INTERVAL => *logged,
            _ => {
                error!(machine, "{} {}", alert.alert_text(), kind.remedy());
                self.time.instant()
            }
        };
        if known.is_none() && kind.has_no_other_event() && !self.of_last_run.remove(&(kind, machine.to_owned())) {
            self.unrecorded.push(alert.clone());
            self.unrecorded.truncate(MAX_UNRECORDED);
        }
        self.active.insert(key, (alert, logged));
    }

    /// The alerts that were raised and have no event in the ledger yet.
    pub fn unrecorded(&self) -> &[FarmAlert] {
        &self.unrecorded
    }

    /// The first of them has its event.
    pub fn mark_recorded(&mut self) {
        self.unrecorded.remove(0);
    }

    /// Clears an alert.
    pub fn clear(&mut self, kind: AlertKind, machine: &str, about: &str) {
        let key = (kind, machine.to_owned(), about.to_owned());
        self.failures.remove(&key);
        self.of_last_run.remove(&(kind, machine.to_owned()));
        if let Some((alert, _)) = self.active.remove(&key) {
            info!(machine, "Resolved: {}", alert.alert_text());
        }
    }

    /// Whether an alert is active.
    pub fn is_active(&self, kind: AlertKind, machine: &str, about: &str) -> bool {
        self.active.contains_key(&(kind, machine.to_owned(), about.to_owned()))
    }

    /// Clears the alerts of a kind whose machine is not in the list.
    pub fn retain_machines(&mut self, kind: AlertKind, machines: &[String]) {
        let gone = |(of, machine, _): &&AlertKey| *of == kind && !machines.contains(machine);
        let gone: Vec<AlertKey> = self.active.keys().filter(gone).cloned().collect();
        gone.iter().for_each(|(kind, machine, about)| self.clear(*kind, machine, about));
    }

    /// Removes everything about a machine that is no longer served.
    pub fn forget_machine(&mut self, machine: &str) {
        self.failures.retain(|(_, of, _), _| of != machine);
        self.active.retain(|(_, of, _), _| of != machine);
    }

    /// Reports a failure that is retried: a warning first, and an alert once it lasts.
    pub fn report_failure(&mut self, kind: AlertKind, machine: &str, about: &str, detail: &str) {
        let now = self.time.instant();
        let key = (kind, machine.to_owned(), about.to_owned());
        if self.failures.len() >= MAX_FAILURES && !self.failures.contains_key(&key) {
            self.failures.clear();
        }
        let fresh = RepeatedFailure { detail: String::new(), first: now, last: now, logged: now };
        let failure = self.failures.entry(key).or_insert(fresh);
        let is_news = failure.detail != detail || now.duration_since(failure.logged) >= LOG_REPEAT_INTERVAL;
        let lasts = now.duration_since(failure.first) >= ALERT_AFTER;
        failure.last = now;
        if is_news {
            (failure.detail, failure.logged) = (detail.to_owned(), now);
        }
        match lasts {
            true => self.raise(kind, machine, about, detail),
            false if is_news => warn!(machine, "{}: {detail}. It is tried again.", kind.headline()),
            false => {}
        }
    }

    /// Clears failures that did not occur again for this long: the retry succeeded.
    pub fn clear_expired_failures(&mut self, after: Duration) {
        let is_over = |failure: &RepeatedFailure| self.time.passed_since(failure.last) > after;
        let over: Vec<AlertKey> =
            self.failures.iter().filter(|(_, t)| is_over(t)).map(|(key, _)| key.clone()).collect();
        over.iter().for_each(|(kind, machine, about)| self.clear(*kind, machine, about));
    }

    /// The active alerts without duplicates: steps that fail for the same reason share one alert that names them.
    pub fn active_alerts(&self) -> impl Iterator<Item = FarmAlert> {
        let mut grouped: Vec<(FarmAlert, String, Vec<&str>)> = Vec::new();
        for ((_, _, about), (alert, _)) in &self.active {
            let why = alert.detail.strip_prefix(&format!("{about}: ")).unwrap_or(&alert.detail);
            let is_same = |(known, reason, _): &&mut (FarmAlert, String, Vec<&str>)| {
                (known.kind, known.machine.as_str(), reason.as_str()) == (alert.kind, alert.machine.as_str(), why)
            };
            match grouped.iter_mut().find(is_same) {
                Some((known, _, others)) => {
                    known.since = known.since.min(alert.since);
                    others.push(about);
                }
                None => grouped.push((alert.clone(), why.to_owned(), vec![about])),
            }
        }
        grouped.into_iter().map(|(alert, why, about)| match about.as_slice() {
            several if several.len() > 1 && alert.detail != why => {
                FarmAlert { detail: format!("{}: {why}", several.join(", ")), ..alert }
            }
            _ => alert,
        })
    }

    /// The same, as JSON for the other nodes.
    pub fn to_row(&self) -> String {
        serde_json::to_string(&self.active_alerts().collect::<Vec<_>>()).unwrap_or_default()
    }

    /// The lines for the hot folder of a machine.
    pub fn status_text_for(&self, machine: &str) -> String {
        let shown: Vec<FarmAlert> = self.active_alerts().filter(|alert| alert.is_shown_in(machine)).collect();
        let mut text = String::new();
        for alert in shown.iter().take(MAX_LISTED_ALERTS) {
            text += &say!("attention", what = alert.alert_text());
            text += &format!("\n    {}\n", alert.kind.remedy());
        }
        if shown.len() > MAX_LISTED_ALERTS {
            text += &say!("attention-more", count = shown.len() - MAX_LISTED_ALERTS);
            text.push('\n');
        }
        text
    }

    /// The same, as JSON.
    pub fn status_json_for(&self, machine: &str) -> serde_json::Value {
        let shown = self.active_alerts().filter(|notice| notice.is_shown_in(machine));
        shown.map(|notice| serde_json::json!(AlertSummary::from(&notice))).collect()
    }

    /// Stores the alerts for `nestd status`, if they have changed.
    pub fn write_if_changed(&mut self, state_dir: &Path) {
        let now: Vec<FarmAlert> = self.active_alerts().collect();
        if self.last_written.as_ref() == Some(&now) {
            return;
        }
        match write_alerts(state_dir, &now) {
            Ok(()) => self.last_written = Some(now),
            // The journal and the hot folders still show them.
            Err(error) => debug!("The alerts could not be stored for `nestd status`: {error}."),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{
        super::stored_alerts::{FILE, ROOM_BYTES, overwrite_alerts},
        *,
    };

    #[test]
    fn what_mends_itself_needs_nobody_and_what_lasts_does() {
        let mut alerts = AlertRegistry::default();
        alerts.report_failure(AlertKind::TakingFails, "p", "store", "no space");
        assert_eq!(alerts.active_alerts().count(), 0);
        let key = (AlertKind::TakingFails, "p".to_owned(), "store".to_owned());
        alerts.failures.get_mut(&key).expect("is remembered").first -= ALERT_AFTER;
        alerts.report_failure(AlertKind::TakingFails, "p", "store", "no space");
        assert_eq!(alerts.active_alerts().count(), 1);
        alerts.clear_expired_failures(Duration::from_secs(60));
        assert_eq!(alerts.active_alerts().count(), 1);
        alerts.clear_expired_failures(Duration::ZERO);
        assert_eq!(alerts.active_alerts().count(), 0);
    }

    #[test]
    fn a_hot_folder_tells_what_concerns_its_machine_and_the_farm() {
        let mut alerts = AlertRegistry::default();
        alerts.raise(AlertKind::Refused, "a", "", "2 files in /error/a");
        alerts.raise(AlertKind::QueueAway, "b", "", "not mounted");
        alerts.raise(AlertKind::Stray, "", "", "x.stl");
        let (a, b) = (alerts.status_text_for("a"), alerts.status_text_for("b"));
        assert!(a.contains("Refused files") && a.contains("not mounted") && a.contains("x.stl"), "{a}");
        assert!(!b.contains("Refused files") && b.contains("not mounted"), "{b}");
        assert!(
            a.lines().count() == 6
                && a.contains("ATTENTION: a: Refused files lie in the error folder: 2 files in /error/a.\n")
        );
        alerts.clear(AlertKind::QueueAway, "b", "");
        assert!(!alerts.status_text_for("b").contains("not mounted"));
        alerts.retain_machines(AlertKind::Refused, &["c".to_owned()]);
        assert_eq!(alerts.active_alerts().count(), 1);
    }

    #[test]
    fn an_alert_has_one_event_over_restarts_until_it_is_over() {
        let dir = tempfile::tempdir().expect("a folder");
        let mut alerts = AlertRegistry::default();
        alerts.raise(AlertKind::QueueAway, "p", "", "not mounted");
        alerts.raise(AlertKind::QueueAway, "p", "", "still not mounted");
        alerts.raise(AlertKind::Refused, "p", "", "the refusal has an event of its own");
        assert_eq!(alerts.unrecorded().len(), 1);
        alerts.mark_recorded();
        alerts.write_if_changed(dir.path());
        let mut next = AlertRegistry::after_last_run(TimeSource::default(), dir.path());
        next.raise(AlertKind::QueueAway, "p", "", "not mounted");
        assert_eq!(next.unrecorded(), []);
        next.clear(AlertKind::QueueAway, "p", "");
        next.raise(AlertKind::QueueAway, "p", "", "not mounted");
        assert_eq!(next.unrecorded().len(), 1);
    }

    #[test]
    fn one_thing_is_told_once() {
        let mut alerts = AlertRegistry::default();
        for step in ["reading", "nesting", "status"] {
            alerts.raise(AlertKind::StepFails, "", step, &format!("{step}: the disk is full"));
        }
        alerts.raise(AlertKind::StepFails, "", "tidying", "tidying: permission denied");
        for about in ["one", "two"] {
            alerts.raise(AlertKind::QueueAway, "p", about, "not mounted");
        }
        let details: Vec<String> = alerts.active_alerts().map(|alert| alert.detail).collect();
        assert_eq!(
            details,
            ["not mounted", "nesting, reading, status: the disk is full", "tidying: permission denied"]
        );
        assert_eq!(alerts.status_text_for("p").matches("not mounted").count(), 1);
    }

    #[test]
    fn what_is_kept_is_read_again() {
        let dir = tempfile::tempdir().expect("a folder");
        let mut alerts = AlertRegistry::default();
        assert_eq!(read_stored_alerts(dir.path()), []);
        for kind in AlertKind::ALL {
            alerts.raise(kind, "p", "x", "detail");
        }
        alerts.write_if_changed(dir.path());
        assert_eq!(read_stored_alerts(dir.path()), alerts.active_alerts().collect::<Vec<_>>());
        assert_eq!(read_stored_alerts(dir.path()).len(), AlertKind::ALL.len());
        // As on a full disk.
        let path = dir.path().join(FILE);
        overwrite_alerts(&path, b"[]").expect("there is room");
        assert_eq!(read_stored_alerts(dir.path()), []);
        assert!(overwrite_alerts(&path, &vec![b' '; 10 * ROOM_BYTES]).is_err());
        fs::write(path, "{").expect("can be written");
        assert_eq!(read_stored_alerts(dir.path()), []);
    }
}
