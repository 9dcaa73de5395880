//! I2 and I3: every build file in a queue folder matches its row, including the copies in it.

use std::{
    collections::{BTreeSet, HashMap},
    fs,
    path::{Path, PathBuf},
};

use anyhow::Result;
use ledger::{BuildRow, BuildState, Ledger, PartId};
use settings::{MachineProfile, Settings};

use super::report::{
    Invariant::{I2, I3, I4},
    InvariantExpectations, InvariantReport,
};
use crate::records::kept_build::KeptBuild;

/// Ends of the dot-names of nestd's files in a queue folder.
const DOT_SUFFIXES: [&str; 3] = [".part", ".half", ".moving"];

/// Checks every queue folder.
pub async fn check_visible_builds(
    settings: &Settings,
    ledger: &Ledger,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    for profile in settings.profiles.values() {
        let mut visible: HashMap<String, PathBuf> = HashMap::new();
        for folder in profile.queue_folders() {
            for name in sorted_names(folder) {
                let file = folder.join(&name);
                let dot_name = name.strip_prefix('.').filter(|rest| DOT_SUFFIXES.iter().any(|end| rest.ends_with(end)));
                if let Some(rest) = dot_name {
                    if !is_of_moving_build(ledger, profile, rest).await? {
                        report_left_over_file(&file, witness, report);
                    }
                } else if build_file::build_file_stem(&name).is_some() && !name.starts_with('.') {
                    let row = ledger.find_build_of_file(&name).await?.filter(|build| build.machine == profile.name);
                    check_build_file(&file, row, settings, ledger, witness, report).await?;
                    let before = visible.insert(name, file.clone());
                    // It may have been moved between the two listings.
                    if before.is_some_and(|before| before.exists() && file.exists()) {
                        let text = format!("{} is in the queue of another printer, too", file.display());
                        report.add_violation(I3, text, "take one of the two out of its queue before both are printed");
                    }
                }
            }
        }
    }
    Ok(())
}

fn sorted_names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    names
}

/// Whether a dot-file, without its dot, belongs to a build that is on its way between two printers, or out of the queue.
async fn is_of_moving_build(ledger: &Ledger, profile: &MachineProfile, rest: &str) -> Result<bool> {
    let mut moving = ledger.builds_to_take_back(&profile.name).await?;
    moving.retain(|build| build.place.is_on_its_way());
    let mut moving = moving.iter();
    Ok(moving.any(|build| {
        let stem = build.staged.file_name.as_deref().and_then(build_file::build_file_stem);
        stem.is_some_and(|stem| rest.starts_with(stem))
    }))
}

/// Each kept copy of a published build's file has the bytes that were proved.
pub async fn check_kept_builds(settings: &Settings, ledger: &Ledger, report: &mut InvariantReport) -> Result<()> {
    for profile in settings.profiles.values() {
        let Ok(entries) = fs::read_dir(profile.folders.archive.join(intake::KEPT_BUILDS)) else { continue };
        for name in entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()) {
            let row = ledger.find_build_of_file(&name).await?.filter(|build| build.machine == profile.name);
            let Some(build) = row else { continue };
            let Some(kept) = KeptBuild::of_build(&profile.folders.archive, &build) else { continue };
            report.files_read += 1;
            if build.times.published_at.is_some() && kept.proved_path().is_none() {
                let text = format!("{} is not the file that was proved as build {}", kept.path().display(), build.id);
                report.add_manual_violation(I4, text, "remove it: the build is then made from the originals only");
            }
        }
    }
    Ok(())
}

fn report_left_over_file(file: &Path, witness: &InvariantExpectations, report: &mut InvariantReport) {
    if witness.at_rest && file.extension().is_some_and(|end| end == "moving") {
        let text = format!("{} was taken back and is on its way to no printer", file.display());
        report.add_violation(I3, text, "leave it there and start the daemon: it puts it into a queue again");
    } else if witness.at_rest {
        let text = format!("{} was left behind", file.display());
        report.add_violation(I3, text, "restart the daemon: it removes what no build names");
    }
}

async fn check_build_file(
    file: &Path,
    row: Option<BuildRow>,
    settings: &Settings,
    ledger: &Ledger,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    let shown = file.display();
    let Some(row) = row else {
        let text = format!("{shown} is in the queue and no build of the ledger has that name");
        let remedy = "somebody copied it there, or the ledger is older than it: do not print it before that is clear";
        report.add_manual_violation(I3, text, remedy);
        return Ok(());
    };
    report.builds_checked += 1;
    let may_be_visible = row.times.published_at.is_some() || (!witness.at_rest && row.state == BuildState::Verified);
    if !may_be_visible || row.place.withdrawn_at.is_some() {
        let state = if may_be_visible { "withdrawn".to_owned() } else { row.state.to_string() };
        let text = format!("{shown} is in the queue and build {} is {state}", row.id);
        report.add_violation(I3, text, "take it out of the queue, and restart the daemon");
    }
    match intake::hash_file(file) {
        // The printer took it meanwhile.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => {
            let text = format!("{shown} cannot be read: {error}");
            report.add_violation(I3, text, "check the disk; `nestd show` names the parts, which can be dropped again");
            return Ok(());
        }
        Ok(hash) if Some(&hash) != row.staged.file_hash.as_ref() => {
            let text = format!("{shown} is not the file that was proved as build {}", row.id);
            report.add_violation(I3, text, "do not print it: somebody changed it or the disk damaged it");
        }
        Ok(_) => report.files_read += 1,
    }
    check_same_copies(file, &row, settings, ledger, report).await
}

/// Checks that the copies in the file are those of the row.
async fn check_same_copies(
    file: &Path,
    row: &BuildRow,
    settings: &Settings,
    ledger: &Ledger,
    report: &mut InvariantReport,
) -> Result<()> {
    let placed = match build_file::read_build(file, &settings.limits) {
        Ok(placed) => placed,
        Err(error) => {
            let text = format!("{} cannot be read as a build: {error}", file.display());
            report.add_violation(I3, text, "do not print it: somebody changed it or the disk damaged it");
            return Ok(());
        }
    };
    let rows: BTreeSet<(String, u32)> =
        ledger.copies_of_build(row.id).await?.into_iter().map(|(part, copy)| (part.to_string(), copy + 1)).collect();
    // A build that was taken in from its record may have other numbers of parts here than in its file: then the contents
    // tell which copies it holds.
    let contents: HashMap<PartId, String> =
        ledger.parts_of_build(row.id).await?.into_iter().map(|part| (part.id, part.file.content_hash)).collect();
    let mut known: Vec<(String, u32)> = (ledger.copies_of_build(row.id).await?.into_iter())
        .map(|(part, copy)| (contents.get(&part).cloned().unwrap_or_default(), copy + 1))
        .collect();
    let mut read: Vec<(String, u32)> =
        placed.iter().map(|p| (p.source_hash.clone().unwrap_or_default(), p.copy.unwrap_or_default())).collect();
    known.sort();
    read.sort();
    if known == read {
        return Ok(());
    }
    let held: Vec<(String, u32)> =
        placed.into_iter().map(|p| (p.part_number.unwrap_or_default(), p.copy.unwrap_or_default())).collect();
    let distinct: BTreeSet<(String, u32)> = held.iter().cloned().collect();
    if distinct.len() != held.len() || distinct != rows {
        let text = format!(
            "{} holds {} placements of {} copies and the ledger says {} copies of build {}",
            file.display(),
            held.len(),
            distinct.len(),
            rows.len(),
            row.id
        );
        report.add_violation(I2, text, "do not print it, and report it to nestd's makers");
    }
    Ok(())
}
