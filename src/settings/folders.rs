//! Where a farm's folders are.
//!
//! One rule: `root` is as seen from the working directory (as `--root` is), every other folder as seen from the root, and
//! a profile's folder is the farm's with the profile's name below it. An absolute path stays where it is.

use std::path::{Component, Path, PathBuf};

use super::{
    Folders,
    inputs::{FarmFolders, FarmInputs, ProfileFolders},
};

/// The root: `asked` (`--root`) beats the file.
pub(super) fn root(inputs: &FarmInputs, asked: Option<&Path>) -> PathBuf {
    let root = asked.unwrap_or(&inputs.root);
    tidied(&std::path::absolute(root).unwrap_or_else(|_| root.to_owned()))
}

/// A profile's folders.
pub(super) fn of_profile(root: &Path, farm: &FarmFolders, own: &ProfileFolders, name: &str) -> Folders {
    let folder = |own: &Option<PathBuf>, farm: &Path| match own {
        Some(exact) if !exact.as_os_str().is_empty() => below(root, exact),
        _ => below(root, farm).join(name),
    };
    Folders {
        inbox: folder(&own.inbox, &farm.inbox),
        queue: folder(&own.queue, &farm.queue),
        error: folder(&own.error, &farm.error),
        archive: folder(&own.archive, &farm.archive),
    }
}

/// `path` as seen from `base`, without `.` and `..`.
pub(super) fn below(base: &Path, path: &Path) -> PathBuf {
    tidied(&base.join(path))
}

/// Without `.` and `..`, so that two spellings of a folder are equal. Links are not followed: `nestd check` does that.
fn tidied(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for step in path.components() {
        match step {
            Component::CurDir => {}
            Component::ParentDir => {
                tidy.pop();
            }
            other => tidy.push(other),
        }
    }
    tidy
}
