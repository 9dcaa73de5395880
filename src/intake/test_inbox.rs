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

    /// What is ready once everything has stood still for the orphan time.
    pub fn ready(&self) -> Vec<Ready> {
        let rules = ListRules { incomplete_secs: 1000.0, unlisted: Unlisted::Reject };
        let judged = self.judged(rules).into_iter();
        let take = |judged| if let Judged::Take(ready) = judged { Some(ready) } else { None };
        judged.filter_map(take).collect()
    }

    /// The same, with what waits for its order list.
    pub fn judged(&self, rules: ListRules) -> Vec<Judged> {
        let mut settler = Settler::new(SettleRules { settle_secs: 1.0, unfinished_secs: 2.0, orphan_secs: 100.0 });
        let seen = scan(&self.inbox, ScanLimits::default()).unwrap().seen;
        settler.observe(&seen, 0.0, |_, _| Ok(true));
        let mut lists = Lists::default();
        lists.observe(&seen);
        let ready = settler.observe(&seen, 100.0, |_, _| Ok(true)).into_iter();
        ready.map(|ready| lists.judge(&self.inbox, ready, rules, |_| Ok(true))).collect()
    }

    /// The one part that is ready.
    pub fn ready_part(&self) -> Ready {
        let mut parts: Vec<Ready> = self.ready().into_iter().filter(|r| matches!(r, Ready::Part { .. })).collect();
        assert_eq!(parts.len(), 1, "{parts:?}");
        parts.remove(0)
    }

    pub fn claim(&self) -> Claim {
        claim(&self.inbox, &self.ready_part()).unwrap()
    }

    /// Files in the hot folder that a scan lists, relative.
    pub fn dropped(&self) -> Vec<String> {
        let seen = scan(&self.inbox, ScanLimits::default()).unwrap().seen;
        seen.iter().map(|s| s.path.strip_prefix(&self.inbox).unwrap().to_string_lossy().into_owned()).collect()
    }

    /// What lies in `.claimed/`.
    pub fn claimed(&self) -> Vec<String> {
        files(&self.inbox.join(".claimed"))
            .into_iter()
            .filter(|f| !f.starts_with(".lists") && !f.starts_with(".given"))
            .collect()
    }
}

/// Files below a folder, relative, sorted; none if it is not there.
pub(super) fn files(dir: &Path) -> Vec<String> {
    let found = disk::files_below(dir).unwrap_or_default();
    found.iter().map(|f| f.strip_prefix(dir).unwrap().to_string_lossy().into_owned()).collect()
}

/// Runs `work` with a step that stops at the `stop`-th call as a kill would: nothing tidies up. Whether it got there.
pub(super) fn stops_at<T>(stop: usize, work: impl FnOnce(&mut dyn FnMut()) -> T) -> bool {
    let mut steps = 0;
    let mut step = || {
        steps += 1;
        assert!(steps < stop, "stop here");
    };
    catch_unwind(AssertUnwindSafe(|| drop(work(&mut step)))).is_err()
}
