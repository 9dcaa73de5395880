//! Finds folders that conflict: if one folder has two purposes, a file in it is taken twice or lost.

use std::{
    fs,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::mpsc,
    thread,
    time::Duration,
};

use crate::ConfigProblem;

/// A share that does not answer within this time is not compared: its folders cannot be used now, and each keeps its
/// lease for one machine.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);

/// A configured folder with its purpose and its position in the configuration.
#[derive(Debug, Clone)]
pub(crate) struct FolderClaim {
    /// The folder.
    pub folder: PathBuf,
    /// Its purpose, as in "the inbox of fuse-1".
    pub description: String,
    /// File and line of the configuration.
    pub location: (PathBuf, Option<usize>),
    /// Whether the file of its machine names it; otherwise it follows from the farm's file, or from names.
    pub is_named: bool,
}

/// Reports folders that are used twice or are inside one another. The state directory may contain folders of machines,
/// as a farm on one disk may need, but must not be inside one of them.
fn find_conflicts(machines: &[FolderClaim], state: &FolderClaim) -> Vec<ConfigProblem> {
    let mut problems = Vec::new();
    for (at, claim) in machines.iter().enumerate() {
        problems.extend(machines[..at].iter().filter_map(|earlier| find_conflict(claim, earlier)));
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

/// The problem, at the place that can be changed: a folder that a file names meets one that follows from a name.
fn conflict_problem(inner: &FolderClaim, outer: &FolderClaim, relation: &str) -> ConfigProblem {
    let rank = |claim: &FolderClaim| (claim.is_named, claim.location.1.is_some());
    let (file, line) = if rank(inner) >= rank(outer) { &inner.location } else { &outer.location };
    ConfigProblem {
        file: file.clone(),
        line: *line,
        text: format!("{} ({}) {relation} {}", inner.description, inner.folder.display(), outer.description),
        remedy: "give each a folder of its own, none inside another".into(),
    }
}

/// Reports folders that conflict by their names and, unless they do, through links and mounts.
pub(crate) fn find_all_conflicts(
    machines: Vec<FolderClaim>,
    state: FolderClaim,
    follows_links: bool,
) -> Vec<ConfigProblem> {
    let named = find_conflicts(&machines, &state);
    if named.is_empty() && follows_links { find_linked_conflicts(machines, state) } else { named }
}

/// Reports folders that are used twice, or are inside one another, through a link or a mount.
fn find_linked_conflicts(machines: Vec<FolderClaim>, state: FolderClaim) -> Vec<ConfigProblem> {
    let (sender, receiver) = mpsc::channel();
    let look = move || {
        let real: Vec<FolderClaim> = machines.iter().map(resolve_claim).collect();
        let mut problems = find_conflicts(&real, &resolve_claim(&state));
        if problems.is_empty() {
            problems = find_same_directories(&machines);
        }
        drop(sender.send(problems));
    };
    let started = thread::Builder::new().name("folders".to_owned()).spawn(look);
    let mut problems = match started {
        Ok(_) => receiver.recv_timeout(ANSWER_TIMEOUT).unwrap_or_default(),
        Err(_) => Vec::new(),
    };
    for problem in &mut problems {
        problem.text += ", through a link or a mount";
    }
    problems
}

/// Reports folders that are one directory, as a mount can make them.
fn find_same_directories(machines: &[FolderClaim]) -> Vec<ConfigProblem> {
    let identity = |claim: &FolderClaim| fs::metadata(&claim.folder).ok().map(|meta| (meta.dev(), meta.ino()));
    let seen: Vec<Option<(u64, u64)>> = machines.iter().map(identity).collect();
    let mut problems = Vec::new();
    for (at, claim) in machines.iter().enumerate().filter(|(at, _)| seen[*at].is_some()) {
        let same = machines[..at].iter().zip(&seen).find(|(_, id)| **id == seen[at]);
        problems.extend(same.map(|(earlier, _)| conflict_problem(claim, earlier, "is also")));
    }
    problems
}

/// The claim with the real path of its folder, as far as that exists.
fn resolve_claim(claim: &FolderClaim) -> FolderClaim {
    let real = claim.folder.ancestors().find_map(|above| {
        let rest = claim.folder.strip_prefix(above).ok()?;
        let real = fs::canonicalize(above).ok()?;
        Some(if rest.as_os_str().is_empty() { real } else { real.join(rest) })
    });
    FolderClaim { folder: real.unwrap_or_else(|| claim.folder.clone()), ..claim.clone() }
}
