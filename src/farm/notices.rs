//! The notices that stand now: logged as errors when they come, kept in a file of the state folder for `nestd status`, told
//! in the hot folders. The file does not need the ledger, which may be what is wrong.

use std::{
    collections::BTreeMap,
    fs, io,
    io::Write,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use tokio::sync::watch;
use tracing::{debug, error, info, warn};

use super::{
    attention::{Attention, Notice},
    time_source::TimeSource,
};
use crate::intake;

/// The file in the state folder.
const FILE: &str = "attention.json";
/// What mends itself within this time needs nobody.
const LASTS: Duration = Duration::from_secs(10);
/// The same trouble is logged again after so long.
const AGAIN: Duration = Duration::from_secs(600);
/// Different things remembered at most.
const MAX_TROUBLES: usize = 1000;
/// The notices of a farm with more than these are only counted in `STATUS.txt`.
const MAX_TOLD: usize = 8;

/// What the farm and the other rooms of the daemon tell each other; any thread may.
#[derive(Debug, Clone, Default)]
pub struct Outside {
    told: Arc<Mutex<BTreeMap<(Attention, String), String>>>,
    is_open: watch::Sender<bool>,
}

impl Outside {
    /// The dashboard is not served, and why.
    pub fn fails(&self, why: &str) {
        self.set(Attention::DashboardDown, "", Some(why.to_owned()));
    }

    /// A receiver of messages cannot be told, and why; `None` = it can.
    pub fn receiver(&self, name: &str, why: Option<String>) {
        self.set(Attention::MessagesFail, name, why);
    }

    /// Does work that uses the ledger, but not before the farm has found the ledger whole, and not after it began to close it.
    pub async fn while_open(&self, work: impl Future<Output = ()>) {
        let (mut opens, mut closes) = (self.is_open.subscribe(), self.is_open.subscribe());
        if opens.wait_for(|is_open| *is_open).await.is_ok() {
            tokio::select! {
                () = work => {}
                _ = closes.wait_for(|is_open| !is_open) => {}
            }
        }
    }

    /// The farm is open, or is not any more.
    pub fn set_open(&self, is_open: bool) {
        self.is_open.send_replace(is_open);
    }

    fn set(&self, kind: Attention, about: &str, why: Option<String>) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        // That all is well is kept too, so that what stood before is cleared.
        told.insert((kind, about.to_owned()), why.unwrap_or_default());
    }

    /// What each of them has to tell; "" = all is well.
    pub fn told(&self) -> BTreeMap<(Attention, String), String> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// What a notice is about: kind, profile, and a word of its own.
type Key = (Attention, String, String);

/// A changed detail of the same notice is logged after so long.
const CHANGES_AGAIN: Duration = Duration::from_secs(60);

/// Something that failed and is tried again.
#[derive(Debug)]
struct Trouble {
    detail: String,
    first: Instant,
    last: Instant,
    logged: Instant,
}

/// All notices, and the troubles that may become some.
#[derive(Debug, Default)]
pub struct Notices {
    standing: BTreeMap<Key, (Notice, Instant)>,
    troubles: BTreeMap<Key, Trouble>,
    written: Option<Vec<Notice>>,
    time: TimeSource,
}

impl Notices {
    /// Notices whose ages these clocks measure.
    pub fn by(time: TimeSource) -> Self {
        Self { time, ..Self::default() }
    }

    /// A person must see to it from now on, until it is cleared.
    pub fn raise(&mut self, kind: Attention, profile: &str, about: &str, detail: &str) {
        // A name may hold what moves a terminal.
        let detail = &intake::display_name(detail.as_ref()).replace("\\\\", "\\");
        let key = (kind, profile.to_owned(), about.to_owned());
        let known = self.standing.get(&key);
        if known.is_some_and(|(known, _)| known.detail == *detail) {
            return;
        }
        let since = known.map_or_else(|| self.time.date(), |(known, _)| known.since);
        let notice = Notice { kind, profile: profile.to_owned(), detail: detail.clone(), since };
        let logged = match known {
            Some((_, logged)) if self.time.passed_since(*logged) < CHANGES_AGAIN => *logged,
            _ => {
                error!(profile, "{} {}", notice.sentence(), kind.remedy());
                self.time.instant()
            }
        };
        self.standing.insert(key, (notice, logged));
    }

    /// It is as it should be again.
    pub fn clear(&mut self, kind: Attention, profile: &str, about: &str) {
        let key = (kind, profile.to_owned(), about.to_owned());
        self.troubles.remove(&key);
        if let Some((notice, _)) = self.standing.remove(&key) {
            info!(profile, "No longer so: {}", notice.sentence());
        }
    }

    /// Clears the notices of a kind that are about none of these profiles.
    pub fn keep_only(&mut self, kind: Attention, profiles: &[String]) {
        let gone = |(of, profile, _): &&Key| *of == kind && !profiles.contains(profile);
        let gone: Vec<Key> = self.standing.keys().filter(gone).cloned().collect();
        gone.iter().for_each(|(kind, profile, about)| self.clear(*kind, profile, about));
    }

    /// Clears all that is about a machine that is not served any more.
    pub fn forget_machine(&mut self, profile: &str) {
        self.troubles.retain(|(_, of, _), _| of != profile);
        self.standing.retain(|(_, of, _), _| of != profile);
    }

    /// Something failed and is tried again: a warning, and a notice once it lasts.
    pub fn trouble(&mut self, kind: Attention, profile: &str, about: &str, detail: &str) {
        let now = self.time.instant();
        let key = (kind, profile.to_owned(), about.to_owned());
        if self.troubles.len() >= MAX_TROUBLES && !self.troubles.contains_key(&key) {
            self.troubles.clear();
        }
        let fresh = Trouble { detail: String::new(), first: now, last: now, logged: now };
        let trouble = self.troubles.entry(key).or_insert(fresh);
        let is_news = trouble.detail != detail || now.duration_since(trouble.logged) >= AGAIN;
        let lasts = now.duration_since(trouble.first) >= LASTS;
        trouble.last = now;
        if is_news {
            (trouble.detail, trouble.logged) = (detail.to_owned(), now);
        }
        match lasts {
            true => self.raise(kind, profile, about, detail),
            false if is_news => warn!(profile, "{}: {detail}. It is tried again.", kind.headline()),
            false => {}
        }
    }

    /// Forgets troubles that did not come again for so long: they were tried again, and it went well.
    pub fn forget_what_is_over(&mut self, after: Duration) {
        let is_over = |trouble: &Trouble| self.time.passed_since(trouble.last) > after;
        let over: Vec<Key> = self.troubles.iter().filter(|(_, t)| is_over(t)).map(|(key, _)| key.clone()).collect();
        over.iter().for_each(|(kind, profile, about)| self.clear(*kind, profile, about));
    }

    /// What stands now, each thing once: steps that fail for one reason are one notice that names them.
    pub fn all(&self) -> impl Iterator<Item = Notice> {
        let mut told: Vec<(Notice, String, Vec<&str>)> = Vec::new();
        for ((_, _, about), (notice, _)) in &self.standing {
            let why = notice.detail.strip_prefix(&format!("{about}: ")).unwrap_or(&notice.detail);
            let is_same = |(known, reason, _): &&mut (Notice, String, Vec<&str>)| {
                (known.kind, known.profile.as_str(), reason.as_str()) == (notice.kind, notice.profile.as_str(), why)
            };
            match told.iter_mut().find(is_same) {
                Some((known, _, others)) => {
                    known.since = known.since.min(notice.since);
                    others.push(about);
                }
                None => told.push((notice.clone(), why.to_owned(), vec![about])),
            }
        }
        told.into_iter().map(|(notice, why, about)| match about.as_slice() {
            several if several.len() > 1 && notice.detail != why => {
                Notice { detail: format!("{}: {why}", several.join(", ")), ..notice }
            }
            _ => notice,
        })
    }

    /// What is told in the hot folder of a profile: lines for people.
    pub fn text_for(&self, profile: &str) -> String {
        let told: Vec<Notice> = self.all().filter(|notice| notice.is_told_in(profile)).collect();
        let mut text = String::new();
        for notice in told.iter().take(MAX_TOLD) {
            text += &format!("ATTENTION: {}\n    {}\n", notice.sentence(), notice.kind.remedy());
        }
        if told.len() > MAX_TOLD {
            text += &format!("ATTENTION: and {} more; `nestd status` tells all.\n", told.len() - MAX_TOLD);
        }
        text
    }

    /// Likewise, for programs.
    pub fn json_for(&self, profile: &str) -> serde_json::Value {
        self.all().filter(|notice| notice.is_told_in(profile)).map(|notice| in_json(&notice)).collect()
    }

    /// Keeps them for `nestd status`, when there is news.
    pub fn keep(&mut self, state_dir: &Path) {
        let now: Vec<Notice> = self.all().collect();
        if self.written.as_ref() == Some(&now) {
            return;
        }
        match write(state_dir, &now) {
            Ok(()) => self.written = Some(now),
            // The journal and the hot folders still tell.
            Err(error) => debug!("What needs a person could not be kept for `nestd status`: {error}."),
        }
    }
}

fn write(state_dir: &Path, notices: &[Notice]) -> io::Result<()> {
    let mut file = tempfile::Builder::new().prefix(".attention-").tempfile_in(state_dir)?;
    file.write_all(serde_json::to_string_pretty(notices)?.as_bytes())?;
    file.persist(state_dir.join(FILE))?;
    Ok(())
}

/// A notice as JSON, with its words.
fn in_json(notice: &Notice) -> serde_json::Value {
    serde_json::json!({
        "kind": notice.kind,
        "profile": notice.profile,
        "sentence": notice.sentence(),
        "remedy": notice.kind.remedy(),
        "since": notice.since.to_string(),
    })
}

/// The notices that the daemon has kept last; none when there are none or they cannot be read.
pub fn kept_notices(state_dir: &Path) -> Vec<Notice> {
    let text = fs::read_to_string(state_dir.join(FILE)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_mends_itself_needs_nobody_and_what_lasts_does() {
        let mut notices = Notices::default();
        notices.trouble(Attention::TakingFails, "p", "store", "no space");
        assert_eq!(notices.all().count(), 0);
        let key = (Attention::TakingFails, "p".to_owned(), "store".to_owned());
        notices.troubles.get_mut(&key).expect("is remembered").first -= LASTS;
        notices.trouble(Attention::TakingFails, "p", "store", "no space");
        assert_eq!(notices.all().count(), 1);
        notices.forget_what_is_over(Duration::from_secs(60));
        assert_eq!(notices.all().count(), 1);
        notices.forget_what_is_over(Duration::ZERO);
        assert_eq!(notices.all().count(), 0);
    }

    #[test]
    fn a_hot_folder_tells_what_concerns_its_machine_and_the_farm() {
        let mut notices = Notices::default();
        notices.raise(Attention::Refused, "a", "", "2 files in /error/a");
        notices.raise(Attention::QueueAway, "b", "", "not mounted");
        notices.raise(Attention::Stray, "", "", "x.stl");
        let (a, b) = (notices.text_for("a"), notices.text_for("b"));
        assert!(a.contains("Refused files") && a.contains("not mounted") && a.contains("x.stl"), "{a}");
        assert!(!b.contains("Refused files") && b.contains("not mounted"), "{b}");
        assert!(
            a.lines().count() == 6
                && a.contains("ATTENTION: a: Refused files lie in the error folder: 2 files in /error/a.\n")
        );
        notices.clear(Attention::QueueAway, "b", "");
        assert!(!notices.text_for("b").contains("not mounted"));
        notices.keep_only(Attention::Refused, &["c".to_owned()]);
        assert_eq!(notices.all().count(), 1);
    }

    #[test]
    fn one_thing_is_told_once() {
        let mut notices = Notices::default();
        for step in ["reading", "nesting", "status"] {
            notices.raise(Attention::StepFails, "", step, &format!("{step}: the disk is full"));
        }
        notices.raise(Attention::StepFails, "", "tidying", "tidying: permission denied");
        for about in ["one", "two"] {
            notices.raise(Attention::QueueAway, "p", about, "not mounted");
        }
        let told: Vec<String> = notices.all().map(|notice| notice.detail).collect();
        assert_eq!(told, ["not mounted", "nesting, reading, status: the disk is full", "tidying: permission denied"]);
        assert_eq!(notices.text_for("p").matches("not mounted").count(), 1);
    }

    #[test]
    fn what_is_kept_is_read_again() {
        let dir = tempfile::tempdir().expect("a folder");
        let mut notices = Notices::default();
        assert_eq!(kept_notices(dir.path()), []);
        for kind in Attention::ALL {
            notices.raise(kind, "p", "x", "detail");
        }
        notices.keep(dir.path());
        assert_eq!(kept_notices(dir.path()), notices.all().collect::<Vec<_>>());
        assert_eq!(kept_notices(dir.path()).len(), Attention::ALL.len());
        fs::write(dir.path().join(FILE), "{").expect("can be written");
        assert_eq!(kept_notices(dir.path()), []);
    }
}
