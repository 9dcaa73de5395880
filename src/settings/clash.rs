//! Folders that must not be one another: a file in two meanings is taken twice or lost.

use std::path::{Path, PathBuf};

use super::Problem;

/// A folder with its meaning and where the configuration says so.
#[derive(Debug)]
pub(super) struct Claim {
    /// The folder.
    pub folder: PathBuf,
    /// What it is, as in "the inbox of fuse-1".
    pub what: String,
    /// Where the configuration says so.
    pub place: (PathBuf, Option<usize>),
}

/// Objects to folders that are claimed twice or lie in one another. The state directory may hold folders of profiles, as a
/// farm on one disk may want, but lies in none of them.
pub(super) fn objections(profiles: &[Claim], state: &Claim) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (at, claim) in profiles.iter().enumerate() {
        problems.extend(profiles[..at].iter().filter_map(|earlier| objection(claim, earlier)));
        if state.folder.starts_with(&claim.folder) {
            problems.push(problem(state, claim, relation(&state.folder, &claim.folder)));
        }
    }
    problems
}

fn objection(claim: &Claim, earlier: &Claim) -> Option<Problem> {
    if claim.folder.starts_with(&earlier.folder) {
        return Some(problem(claim, earlier, relation(&claim.folder, &earlier.folder)));
    }
    earlier.folder.starts_with(&claim.folder).then(|| problem(earlier, claim, "lies inside"))
}

fn relation(inner: &Path, outer: &Path) -> &'static str {
    if inner == outer { "is also" } else { "lies inside" }
}

fn problem(inner: &Claim, outer: &Claim, relation: &str) -> Problem {
    Problem {
        file: inner.place.0.clone(),
        line: inner.place.1,
        text: format!("{} ({}) {relation} {}", inner.what, inner.folder.display(), outer.what),
        remedy: "give each a folder of its own, none inside another".into(),
    }
}
