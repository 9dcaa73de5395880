//! Order folders that are empty because their files were claimed. They go after a while; folders that somebody made and
//! has not used yet stay.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use super::Claim;

/// Folders that files were claimed from, of one hot folder.
#[derive(Debug, Default)]
pub struct LeftFolders {
    /// Relative to the hot folder.
    left: BTreeSet<PathBuf>,
}

impl LeftFolders {
    /// How long a folder must have been empty by default: the next file of the order may be on its way.
    pub const MIN_AGE: Duration = Duration::from_secs(60);

    /// Notes the order folder of a claim.
    pub fn note(&mut self, claim: &Claim) {
        if !claim.order_path.as_os_str().is_empty() {
            self.left.insert(claim.order_path.clone());
        }
    }

    /// Removes noted folders that are empty and in which nothing came or went for `min_age`; then the folders above them,
    /// when their time has come. Returns what was removed. A folder that is not empty is forgotten until the next claim
    /// from it.
    pub fn sweep(&mut self, inbox: &Path, min_age: Duration) -> Vec<PathBuf> {
        let mut removed = Vec::new();
        for folder in std::mem::take(&mut self.left) {
            let path = inbox.join(&folder);
            let Some(age) = age(&path) else { continue };
            if age < min_age {
                self.left.insert(folder);
            } else if fs::remove_dir(&path).is_ok() {
                self.left.extend(folder.parent().filter(|p| !p.as_os_str().is_empty()).map(Path::to_owned));
                removed.push(path);
            }
        }
        removed
    }
}

fn age(path: &Path) -> Option<Duration> {
    let meta = fs::symlink_metadata(path).ok()?;
    Some(meta.modified().ok()?.elapsed().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::test_inbox::TestInbox;

    #[test]
    fn an_order_folder_goes_some_time_after_its_last_file_was_claimed() {
        let farm = TestInbox::new();
        farm.drop_file("kit/lid/a.stl", "solid");
        fs::create_dir(farm.inbox.join("made by hand")).unwrap();
        let mut left = LeftFolders::default();
        left.note(&farm.claim());
        assert!(left.sweep(&farm.inbox, LeftFolders::MIN_AGE).is_empty());
        assert_eq!(left.sweep(&farm.inbox, Duration::ZERO), [farm.inbox.join("kit/lid")]);
        assert_eq!(left.sweep(&farm.inbox, Duration::ZERO), [farm.inbox.join("kit")]);
        assert!(left.sweep(&farm.inbox, Duration::ZERO).is_empty());
        assert!(farm.inbox.join("made by hand").exists());
    }

    #[test]
    fn a_folder_with_anything_in_it_stays() {
        let farm = TestInbox::new();
        farm.drop_file("kit/a.stl", "solid");
        let mut left = LeftFolders::default();
        left.note(&farm.claim());
        farm.drop_file("kit/.DS_Store", "x");
        assert!(left.sweep(&farm.inbox, Duration::ZERO).is_empty());
        assert!(farm.inbox.join("kit/.DS_Store").exists());
    }

    #[test]
    fn a_part_of_the_hot_folder_itself_leaves_no_folder() {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "solid");
        let mut left = LeftFolders::default();
        left.note(&farm.claim());
        assert!(left.sweep(&farm.inbox, Duration::ZERO).is_empty() && farm.inbox.exists());
    }
}
