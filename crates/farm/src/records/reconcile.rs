//! Brings a ledger that was restored from a backup up to date with the folders. They show what was published since: by
//! the records in the archive, and by the build files that are still in a queue.
//!
//! A part in doubt is not printed: a person is told and can have it printed. A cake that was printed twice cannot be
//! undone.

use std::{collections::HashSet, fs, path::PathBuf};

use anyhow::{Context, Result};
use serde_json::json;

mod known_builds;

use intake::ContentStore;
use ledger::{BuildRow, BuildState, ImportOutcome, Ledger, LedgerError, PartId, PartRow, PartState, RefusalCause};

use super::{
    build_record,
    folder_builds::{self, FolderExpectations},
    newer_decisions::{NewerDecisions, how_to_take_back, wanted_then},
    order_notes,
    reconcile_report::{DECIDED_SINCE, DeferredFolderStep, ErrorFolderIndex, ReconcileReport, copy_to_error_folder},
    said_words,
};
use settings::{MachineProfile, Settings};

use crate::files::{claim_note, error_folder};

/// How many numbers of parts and builds are skipped: the numbers used since the backup are in reasons and build files.
const NUMBER_GAP: u32 = 1000;

/// A build that the folders hold and the ledger does not know.
#[derive(Debug)]
pub struct UnknownBuild {
    /// Name of its build file.
    pub name: String,
    machine: String,
    record: String,
    /// Path of its record, if it has one.
    record_file: Option<PathBuf>,
    is_published: bool,
}

impl UnknownBuild {
    /// Whether it is the record of a build that the ledger still nests. Builds of another farm may have the same number.
    fn is_record_of(&self, build: &BuildRow) -> bool {
        let record: serde_json::Value = serde_json::from_str(&self.record).unwrap_or_default();
        let row = &record["builds"][0];
        let opened_at = row["opened_at"].as_str().and_then(|at| at.parse::<jiff::Timestamp>().ok());
        self.machine == build.machine && row["id"] == build.id.0 && opened_at == Some(build.times.opened_at.0)
    }
}

/// Records what the folders hold in a ledger that is not in use yet.
///
/// # Errors
/// A folder cannot be read, or the ledger cannot be changed.
pub async fn reconcile_ledger(
    settings: &Settings,
    ledger: &Ledger,
    known: &FolderExpectations,
) -> Result<ReconcileReport> {
    known.check_all_available(settings)?;
    let (mut found, last_event_at) = (ReconcileReport::default(), ledger.last_event_at().await?);
    let mut unclear = HashSet::new();
    let mut unknown = Vec::new();
    for profile in settings.profiles.values() {
        unknown.extend(find_unknown_builds(settings, ledger, profile, known, &mut unclear).await?);
    }
    known_builds::record_published_builds(settings, ledger, &mut found).await?;
    known_builds::take_in_withdrawals(settings, ledger, &mut found).await?;
    known_builds::end_noted_words(settings, ledger, &mut found).await?;
    if !unknown.is_empty() {
        give_up_nesting_builds(settings, ledger, &unknown, &mut found).await?;
    }
    for build in &unknown {
        match ledger.import_build_record(&build.record, build.is_published).await {
            Ok(ImportOutcome::AlreadyKnown) => {}
            Ok(ImportOutcome::Imported(id, doubts)) => {
                let what = match build_record::is_withdrawn(&build.record) {
                    true => "was published and taken back out of the queue untouched; its copies wait",
                    false => "was published; its copies are taken in",
                };
                found.done.push(format!("build {id} ({} of {}) {what}", build.name, build.machine));
                found.doubts.extend(doubts);
            }
            Err(error) => {
                found.doubts.push(format!(
                    "the record of {} cannot be taken in: {error}. `nestd show` does not know its parts: see that none of \
                     them is printed again",
                    build.name
                ));
                found.folder_steps.extend(build.record_file.clone().map(DeferredFolderStep::SetRecordAside));
            }
        }
    }
    let refused = ErrorFolderIndex::read_all(settings, known)?;
    let kept = claim_note::list_stored_files(settings)?;
    let mut since = NewerDecisions::load_for_reconcile(settings, ledger, &kept, &mut found).await?;
    let context = ReconcileContext { settings, ledger, refused: &refused };
    for profile in settings.profiles.values() {
        refuse_parts_again(&context, profile, &mut since, &mut found).await?;
        restore_retried_files(&context, profile, &mut since, &mut found).await?;
    }
    since.apply_to_ledger(ledger, &mut found).await?;
    let mut forgotten = claim_note::find_forgotten_files(settings, ledger, &kept).await?;
    // What lies in an error folder is first of all of a part that was decided on.
    forgotten.sort_by_key(|one| one.decisions == 0);
    let mut again = super::forgotten_files::ForgottenFileRecovery {
        settings,
        ledger,
        refused: &refused,
        possibly_printed: &unclear,
        report: &mut found,
        assigned: HashSet::new(),
    };
    for one in forgotten {
        again.recover_file(one).await?;
    }
    order_notes::take_in_orders(ledger, &settings.state_dir, &mut found).await?;
    said_words::name_words_since(settings, last_event_at, &mut found)?;
    if found != ReconcileReport::default() {
        ledger.leave_gap_in_numbers(NUMBER_GAP).await?;
    }
    Ok(found)
}

/// What the steps of reconciling share.
struct ReconcileContext<'a> {
    settings: &'a Settings,
    ledger: &'a Ledger,
    refused: &'a ErrorFolderIndex,
}

/// The builds in a machine's folders that the ledger does not know. Adds to `unclear` the contents of parts in build
/// files that the ledger never knew: they may be printed already.
///
/// # Errors
/// A folder cannot be read.
pub async fn find_unknown_builds(
    settings: &Settings,
    ledger: &Ledger,
    profile: &MachineProfile,
    known: &FolderExpectations,
    unclear: &mut HashSet<String>,
) -> Result<Vec<UnknownBuild>> {
    let builds = folder_builds::list_folder_builds(profile, known)?;
    let names: Vec<String> = builds.iter().map(|build| build.name.clone()).collect();
    let names: HashSet<String> = ledger.unknown_build_files(&names).await?.into_iter().collect();
    let mut unknown = Vec::new();
    for folder_builds::FolderBuild { name, record: file } in
        builds.into_iter().filter(|build| names.contains(&build.name))
    {
        if build_record::parse_build_file_name(&name).is_none() {
            continue;
        }
        let Some(file) = file else {
            unknown.extend(record_from_build_file(settings, ledger, profile, &name, unclear).await?);
            continue;
        };
        let record = fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?;
        let queue_id = staged_in(&record);
        let is_published = !folder_builds::is_staged(profile, &name, queue_id.as_deref())?;
        unknown.push(UnknownBuild {
            name,
            machine: profile.name.clone(),
            record,
            record_file: Some(file),
            is_published,
        });
    }
    Ok(unknown)
}

/// The marker of the queue folder where the build of a record was staged.
fn staged_in(record: &str) -> Option<String> {
    let record: serde_json::Value = serde_json::from_str(record).unwrap_or_default();
    record["builds"][0]["queue_id"].as_str().map(str::to_owned)
}

/// A record made from a build file that has none, for the parts in it that the ledger knows. `None` = there are none,
/// so nothing of it could be printed twice.
async fn record_from_build_file(
    settings: &Settings,
    ledger: &Ledger,
    profile: &MachineProfile,
    name: &str,
    unclear: &mut HashSet<String>,
) -> Result<Option<UnknownBuild>> {
    let file = profile.visible_file(name, None);
    fs::File::open(&file).with_context(|| format!("reading {}", file.display()))?;
    // A file that is not one of our build files says nothing.
    let Ok(placed) = build_file::read_build(&file, &settings.limits) else { return Ok(None) };
    let (mut parts, mut placements, mut height_mm) = (Vec::new(), Vec::new(), 0.0_f64);
    for item in &placed {
        height_mm = height_mm.max(item.mesh.bounds_at(&item.pose).max.z);
        let number = item.part_number.as_deref().and_then(|number| number.parse().ok()).map(PartId);
        let (Some(id), Some(hash), Some(copy)) = (number, &item.source_hash, item.copy) else { continue };
        if !ledger.part_has_content(id, hash).await? {
            unclear.insert(hash.clone());
            continue;
        }
        if !parts.iter().any(|part: &serde_json::Value| part["id"] == id.0) {
            parts.extend(ledger.export_part_row(id).await?);
        }
        let ([qx, qy, qz, qw], [x, y, z]) = (item.pose.rotation.to_array(), item.pose.translation.to_array());
        placements.push(json!({
            "part_id": id.0, "copy": copy - 1, "qx": qx, "qy": qy, "qz": qz, "qw": qw, "tx_mm": x, "ty_mm": y, "tz_mm": z,
        }));
    }
    if placements.is_empty() {
        return Ok(None);
    }
    let (number, bytes) =
        (build_record::parse_build_file_name(name).map(|(_, number)| number), fs::metadata(&file)?.len());
    let at = jiff::Timestamp::try_from(fs::metadata(&file)?.modified()?).unwrap_or_default();
    let at = ledger::UtcTimestamp(at).to_string();
    let build = json!({
        "id": number, "machine": profile.name, "fired_by": "", "attempts": 1, "opened_at": at, "nesting_at": at,
        "verified_at": at, "state_at": at, "file_name": name, "file_hash": intake::hash_file(&file)?, "file_bytes": bytes,
        "material": placed.iter().find_map(|item| item.words.material.clone()).unwrap_or_default(),
        "height_mm": height_mm, "copies": placements.len(), "reason": "taken in from the build file in the queue",
    });
    let record = json!({ "builds": [build], "parts": parts, "placements": placements }).to_string();
    let (name, machine) = (name.to_owned(), profile.name.clone());
    Ok(Some(UnknownBuild { name, machine, record, record_file: None, is_published: true }))
}

/// Gives up the builds that were being nested when the backup was made, since they are outdated: their copies wait
/// again. Those of a node that runs, and has lost no changes, are of now.
async fn give_up_nesting_builds(
    settings: &Settings,
    ledger: &Ledger,
    unknown: &[UnknownBuild],
    found: &mut ReconcileReport,
) -> Result<()> {
    for build in ledger.builds_in_state(BuildState::Nesting).await? {
        if ledger.is_machine_of_sound_node(&build.machine, &settings.node.name).await? {
            continue;
        }
        if unknown.iter().any(|one| one.is_record_of(&build)) {
            let copies = ledger.copies_of_build(build.id).await?;
            ledger.release_copies(build.id, &copies, "its build was published after the backup was made").await?;
        } else {
            ledger.fail_build(build.id, "the ledger was put back from a backup").await?;
            found.done.push(format!("build {} was being nested and is given up; its copies wait", build.id));
        }
    }
    Ok(())
}

/// Refuses parts that wait in the ledger but were refused, cancelled or otherwise decided on since, or whose files are
/// not kept any more.
async fn refuse_parts_again(
    context: &ReconcileContext<'_>,
    profile: &MachineProfile,
    since: &mut NewerDecisions,
    found: &mut ReconcileReport,
) -> Result<()> {
    let (ledger, settings) = (context.ledger, context.settings);
    let mut live = ledger.parts_in_state(PartState::Waiting).await?;
    live.extend(ledger.parts_in_state(PartState::Claimed).await?);
    for part in live.into_iter().filter(|part| part.machine == profile.name) {
        let (is_in_work, is_decided) = (is_in_work(profile, &part)?, since.contains_part(&part));
        if is_in_work && !is_decided {
            continue;
        }
        let (is_in_error, is_stored) =
            (is_in_error_folder(context.refused, profile, &part)?, is_stored(settings, &part)?);
        let why = match () {
            () if is_in_error => {
                "It lies in the error folder: it was refused or cancelled after the backup was made".to_owned()
            }
            // Its original was asked back from the archive when the backup was made, and still is.
            () if !is_stored && part.owed.fetch_at.is_some() && !is_decided => continue,
            () if !is_stored => {
                "Its file is no longer kept: it was built, refused or cancelled after the backup was made".to_owned()
            }
            () if is_decided => format!("{DECIDED_SINCE}{}", wanted_then(since.wanted_since(&part))),
            () => continue,
        } + ".";
        if let Err(error) = refuse_part(ledger, &part, &why).await {
            let LedgerError::BeingBuilt { build, .. } = error else { return Err(error.into()) };
            let doubt = format!(
                "part {} ({}) has copies in build {build}, which is to be published. {why} `nestd cancel {0}` takes out what \
                 is left of it then",
                part.id, part.name
            );
            since.report_doubt(&part, found, doubt);
            continue;
        }
        if let Some(part) = ledger.find_part(part.id).await?
            && !is_in_error
            && is_stored
            && !is_in_work
        {
            copy_to_error_folder(settings, profile, &part)?;
        }
        let back = match is_stored {
            true => how_to_take_back(part.id, since.wanted_since(&part)),
            false if is_in_error => "To print it, drop the file that lies in the error folder again".to_owned(),
            false => "To print it all the same, drop its file again".to_owned(),
        };
        let doubt = format!("part {} ({}) is taken out. {why} {back}", part.id, part.name);
        since.report_doubt(&part, found, doubt);
    }
    Ok(())
}

/// waiting, claimed -> refused; the other parts of a claimed part's file are refused with it.
async fn refuse_part(ledger: &Ledger, part: &PartRow, why: &str) -> Result<(), LedgerError> {
    match ledger.find_part(part.id).await?.map(|now| now.state) {
        Some(PartState::Claimed) => ledger.refuse_claim(part.id, RefusalCause::Other, why).await,
        Some(PartState::Waiting) => ledger.cancel_part(part.id, RefusalCause::Other, why).await,
        _ => Ok(()),
    }
}

/// Handles parts that are refused in the ledger but were taken back after the backup was made, which removed their
/// files from the error folder. It is not known what became of them, so a person decides, and the file is put back into
/// the error folder.
async fn restore_retried_files(
    context: &ReconcileContext<'_>,
    profile: &MachineProfile,
    since: &mut NewerDecisions,
    found: &mut ReconcileReport,
) -> Result<()> {
    for part in context.ledger.parts_in_state(PartState::Refused).await? {
        if part.machine != profile.name || since.is_reported(&part) || is_in_work(profile, &part)? {
            continue;
        }
        if !is_stored(context.settings, &part)? || is_in_error_folder(context.refused, profile, &part)? {
            continue;
        }
        copy_to_error_folder(context.settings, profile, &part)?;
        let doubt = format!(
            "part {} ({}) was refused before the backup was made and taken back or tidied away after it; its file lies in {} \
             again. `nestd retry {0}` takes it back",
            part.id,
            part.name,
            profile.folders.error.display()
        );
        since.report_doubt(&part, found, doubt);
    }
    Ok(())
}

/// Whether a part's file is in the error folder with a reason that names it.
fn is_in_error_folder(refused: &ErrorFolderIndex, profile: &MachineProfile, part: &PartRow) -> Result<bool> {
    let may_lie = !refused.files_with_content(&profile.name, &part.file.content_hash).is_empty();
    Ok(may_lie && !error_folder::find_refused_files(&profile.folders.error, part)?.is_empty())
}

fn is_in_work(profile: &MachineProfile, part: &PartRow) -> Result<bool> {
    let dir = intake::claim_dir(&profile.folders.inbox, &part.file.claim);
    dir.try_exists().with_context(|| format!("looking at {}", dir.display()))
}

fn is_stored(settings: &Settings, part: &PartRow) -> Result<bool> {
    let stored = ContentStore::from_dir(settings.state_dir.join("store")).file_path(&part.file.content_hash)?;
    stored.try_exists().with_context(|| format!("looking at {}", stored.display()))
}
