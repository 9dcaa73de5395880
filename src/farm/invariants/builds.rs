//! I2 and I3: every build file in a queue folder matches its row, including the copies in it.

use std::{
    collections::{BTreeSet, HashMap},
    fs,
    path::Path,
};

use anyhow::Result;

use super::report::{
    Invariant::{I2, I3, I4},
    InvariantExpectations, InvariantReport,
};
use crate::{
    farm::kept_build::KeptBuild,
    intake,
    ledger::{BuildRow, BuildState, Ledger, PartId},
    settings::{MachineProfile, Settings},
};

/// Checks every queue folder.
pub async fn check_visible_builds(
    settings: &Settings,
    ledger: &Ledger,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    for profile in settings.profiles.values() {
        let Ok(entries) = fs::read_dir(&profile.folders.queue) else { continue };
        let mut names: Vec<String> = entries.flatten().filter_map(|e| e.file_name().into_string().ok()).collect();
        names.sort();
        for name in names {
            if name.starts_with('.') && (name.ends_with(".part") || name.ends_with(".half")) {
                report_left_over_file(profile, &name, witness, report);
            } else if name.ends_with(".build.3mf") && !name.starts_with('.') {
                let row = ledger.find_build_by_file(&profile.name, &name).await?;
                check_build_file(profile, &name, row, settings, ledger, witness, report).await?;
            }
        }
    }
    Ok(())
}

/// Each kept copy of a published build's file has the bytes that were proved.
pub async fn check_kept_builds(settings: &Settings, ledger: &Ledger, report: &mut InvariantReport) -> Result<()> {
    for profile in settings.profiles.values() {
        let Ok(entries) = fs::read_dir(profile.folders.archive.join(intake::KEPT_BUILDS)) else { continue };
        for name in entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()) {
            let Some(build) = ledger.find_build_by_file(&profile.name, &name).await? else { continue };
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

fn report_left_over_file(
    profile: &MachineProfile,
    name: &str,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) {
    if witness.at_rest {
        let text = format!("{} was left behind", profile.folders.queue.join(name).display());
        report.add_violation(I3, text, "restart the daemon: it removes what no build names");
    }
}

async fn check_build_file(
    profile: &MachineProfile,
    name: &str,
    row: Option<BuildRow>,
    settings: &Settings,
    ledger: &Ledger,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    let file = profile.folders.queue.join(name);
    let shown = file.display();
    let Some(row) = row else {
        let text = format!("{shown} is in the queue and no build of the ledger has that name");
        let remedy = "somebody copied it there, or the ledger is older than it: do not print it before that is clear";
        report.add_manual_violation(I3, text, remedy);
        return Ok(());
    };
    report.builds_checked += 1;
    let may_be_visible = row.times.published_at.is_some() || (!witness.at_rest && row.state == BuildState::Verified);
    if !may_be_visible {
        let text = format!("{shown} is in the queue and build {} is {}", row.id, row.state);
        report.add_violation(I3, text, "take it out of the queue, and restart the daemon");
    }
    match intake::hash_file(&file) {
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
    check_same_copies(&file, &row, settings, ledger, report).await
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
