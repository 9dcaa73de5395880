//! Order folders that became empty because their files were claimed. They are removed after a while. Folders that
//! somebody created and has not used yet stay.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use crate::ClaimedPart;

/// The order folders of one hot folder that files were claimed from.
#[derive(Debug, Default)]
pub struct EmptiedFolders {
    /// Paths relative to the hot folder.
    folders: BTreeSet<PathBuf>,
}

impl EmptiedFolders {
    /// Default time that a folder must have been empty: the next file of the order may still arrive.
    pub const MIN_AGE: Duration = Duration::from_secs(60);

    /// Adds the order folder of a claim.
    pub fn add_order_folder(&mut self, claim: &ClaimedPart) {
        if !claim.order_path.as_os_str().is_empty() {
            self.folders.insert(claim.order_path.clone());
        }
    }

    /// Removes the recorded folders that are empty and were not changed for `min_age`, and later their parent folders
    /// in the same way. Returns the removed folders. A folder that is not empty is dropped from the record until the
    /// next claim from it.
    pub fn remove_empty_folders(&mut self, inbox: &Path, min_age: Duration) -> Vec<PathBuf> {
        let mut removed = Vec::new();
        for folder in std::mem::take(&mut self.folders) {
            let path = inbox.join(&folder);
            let Some(age) = folder_age(&path) else { continue };
            if age < min_age {
                self.folders.insert(folder);
            } else if fs::remove_dir(&path).is_ok() {
                self.folders.extend(folder.parent().filter(|p| !p.as_os_str().is_empty()).map(Path::to_owned));
                removed.push(path);
            }
        }
        removed
    }
}

fn folder_age(path: &Path) -> Option<Duration> {
    let meta = fs::symlink_metadata(path).ok()?;
    Some(meta.modified().ok()?.elapsed().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_inbox::TestInbox;

    #[test]
    fn an_order_folder_goes_some_time_after_its_last_file_was_claimed() {
        let farm = TestInbox::new();
        farm.drop_file("kit/lid/a.stl", "solid");
        fs::create_dir(farm.inbox.join("made by hand")).unwrap();
        let mut left = EmptiedFolders::default();
        left.add_order_folder(&farm.claim());
        assert!(left.remove_empty_folders(&farm.inbox, EmptiedFolders::MIN_AGE).is_empty());
        assert_eq!(left.remove_empty_folders(&farm.inbox, Duration::ZERO), [farm.inbox.join("kit/lid")]);
        assert_eq!(left.remove_empty_folders(&farm.inbox, Duration::ZERO), [farm.inbox.join("kit")]);
        assert!(left.remove_empty_folders(&farm.inbox, Duration::ZERO).is_empty());
        assert!(farm.inbox.join("made by hand").exists());
    }

    #[test]
    fn a_folder_with_anything_in_it_stays() {
        let farm = TestInbox::new();
        farm.drop_file("kit/a.stl", "solid");
        let mut left = EmptiedFolders::default();
        left.add_order_folder(&farm.claim());
        farm.drop_file("kit/.DS_Store", "x");
        assert!(left.remove_empty_folders(&farm.inbox, Duration::ZERO).is_empty());
        assert!(farm.inbox.join("kit/.DS_Store").exists());
    }

    #[test]
    fn a_part_of_the_hot_folder_itself_leaves_no_folder() {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "solid");
        let mut left = EmptiedFolders::default();
        left.add_order_folder(&farm.claim());
        assert!(left.remove_empty_folders(&farm.inbox, Duration::ZERO).is_empty() && farm.inbox.exists());
    }
}
