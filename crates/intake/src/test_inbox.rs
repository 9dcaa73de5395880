//! A hot folder for tests: real files in a temporary folder.

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
};

use super::*;

pub(super) struct TestInbox {
    pub dir: tempfile::TempDir,
    pub inbox: PathBuf,
    pub error: PathBuf,
    pub archive: PathBuf,
}

impl TestInbox {
    pub fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        let (inbox, error, archive) = (at("inbox"), at("error"), at("archive"));
        fs::create_dir(&inbox).unwrap();
        Self { dir, inbox, error, archive }
    }

    pub fn drop_file(&self, name: &str, content: &str) -> PathBuf {
        let path = self.inbox.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, content).unwrap();
        path
    }

    /// The entries that have settled after the orphan time.
    pub fn ready(&self) -> Vec<SettledEntry> {
        let rules = OrderListRules { incomplete_secs: 1000.0, unlisted: UnlistedPolicy::Refuse };
        let judged = self.judged(rules).into_iter();
        let take = |judged| if let TakeDecision::Take(ready) = judged { Some(ready) } else { None };
        judged.filter_map(take).collect()
    }

    /// The same, including parts that wait for their order list.
    pub fn judged(&self, rules: OrderListRules) -> Vec<TakeDecision> {
        let mut settler =
            SettleTracker::new(SettleRules { settle_secs: 1.0, unfinished_secs: 2.0, orphan_secs: 100.0 });
        let seen = scan_inbox(&self.inbox, ScanLimits::default()).unwrap().entries;
        settler.observe_scan(&seen, 0.0, |_, _| Ok(true));
        let mut lists = OrderListTracker::default();
        lists.observe_scan(&seen);
        let ready = settler.observe_scan(&seen, 100.0, |_, _| Ok(true)).into_iter();
        ready.map(|ready| lists.check_against_list(&self.inbox, ready, rules, |_| Ok(true))).collect()
    }

    /// The only settled part.
    pub fn ready_part(&self) -> SettledEntry {
        let mut parts: Vec<SettledEntry> =
            self.ready().into_iter().filter(|r| matches!(r, SettledEntry::Part { .. })).collect();
        assert_eq!(parts.len(), 1, "{parts:?}");
        parts.remove(0)
    }

    pub fn claim(&self) -> ClaimedPart {
        claim_part(&self.inbox, &self.ready_part()).unwrap()
    }

    /// Relative paths of the files in the hot folder that a scan lists.
    pub fn dropped(&self) -> Vec<String> {
        let seen = scan_inbox(&self.inbox, ScanLimits::default()).unwrap().entries;
        seen.iter().map(|s| s.path.strip_prefix(&self.inbox).unwrap().to_string_lossy().into_owned()).collect()
    }

    /// Content of `.claimed/`.
    pub fn claimed(&self) -> Vec<String> {
        files(&self.inbox.join(".claimed"))
            .into_iter()
            .filter(|f| !f.starts_with(".lists") && !f.starts_with(".given"))
            .collect()
    }
}

/// Relative paths of the files below a folder, sorted. Empty if the folder does not exist.
pub(super) fn files(dir: &Path) -> Vec<String> {
    let found = crate::folder::disk::files_below(dir).unwrap_or_default();
    found.iter().map(|f| f.strip_prefix(dir).unwrap().to_string_lossy().into_owned()).collect()
}

/// Runs `work` with a step function that stops at call number `stop` like a kill, without any cleanup. Returns whether
/// that call was reached.
pub(super) fn stops_at<T>(stop: usize, work: impl FnOnce(&mut dyn FnMut()) -> T) -> bool {
    let mut steps = 0;
    let mut step = || {
        steps += 1;
        assert!(steps < stop, "stop here");
    };
    catch_unwind(AssertUnwindSafe(|| drop(work(&mut step)))).is_err()
}
