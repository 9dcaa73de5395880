//! Finds folders that conflict: if one folder has two purposes, a file in it is taken twice or lost.

use std::path::{Path, PathBuf};

use super::ConfigProblem;

/// A configured folder with its purpose and its position in the configuration.
#[derive(Debug)]
pub(super) struct FolderClaim {
    /// The folder.
    pub folder: PathBuf,
    /// Its purpose, as in "the inbox of fuse-1".
    pub description: String,
    /// File and line of the configuration.
    pub location: (PathBuf, Option<usize>),
}

/// Reports folders that are used twice or are inside one another. The state directory may contain folders of profiles,
/// as a farm on one disk may need, but must not be inside one of them.
pub(super) fn find_conflicts(profiles: &[FolderClaim], state: &FolderClaim) -> Vec<ConfigProblem> {
    let mut problems = Vec::new();
    for (at, claim) in profiles.iter().enumerate() {
        problems.extend(profiles[..at].iter().filter_map(|earlier| find_conflict(claim, earlier)));
        if state.folder.starts_with(&claim.folder) {
            problems.push(conflict_problem(state, claim, folder_relation(&state.folder, &claim.folder)));
        }
    }
    problems
}

fn find_conflict(claim: &FolderClaim, earlier: &FolderClaim) -> Option<ConfigProblem> {
    if claim.folder.starts_with(&earlier.folder) {
        return Some(conflict_problem(claim, earlier, folder_relation(&claim.folder, &earlier.folder)));
    }
    earlier.folder.starts_with(&claim.folder).then(|| conflict_problem(earlier, claim, "lies inside"))
}

fn folder_relation(inner: &Path, outer: &Path) -> &'static str {
    if inner == outer { "is also" } else { "lies inside" }
}

fn conflict_problem(inner: &FolderClaim, outer: &FolderClaim, relation: &str) -> ConfigProblem {
    ConfigProblem {
        file: inner.location.0.clone(),
        line: inner.location.1,
        text: format!("{} ({}) {relation} {}", inner.description, inner.folder.display(), outer.description),
        remedy: "give each a folder of its own, none inside another".into(),
    }
}
