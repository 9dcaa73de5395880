//! Makes a ledger that is older than its folders, because it was put back from a backup, agree with them. The folders tell
//! what was published since: the records in the archive, and the build files that still lie in a queue.
//!
//! What is doubtful is not printed: a person is told, and can have it printed; a cake that was printed twice cannot be undone.

use std::{collections::HashSet, fs, path::Path};

use anyhow::{Context, Result};
use serde_json::json;

use super::{attention::Attention, lock::Lock, record, tidy};
use crate::{
    format, intake,
    ledger::{BuildState, Ledger, PartId, PartRow, PartState, Refusal, TakenIn},
    queue::{Queue, StagedState},
    settings::{Profile, Settings},
};

/// Numbers of parts and builds that are skipped: those given out since the backup stand on reasons and build files.
const GAP: u32 = 1000;

/// What was done, in sentences.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Reconciled {
    /// What the ledger knows now that it did not know.
    pub done: Vec<String>,
    /// What a person should look at.
    pub doubts: Vec<String>,
}

/// A build of which the folders tell and the ledger does not.
#[derive(Debug)]
pub struct Unknown {
    /// Name of its file.
    pub name: String,
    profile: String,
    record: String,
    is_published: bool,
}

/// Takes what the folders tell into the ledger of a farm that no daemon serves.
///
/// # Errors
/// A daemon serves the farm, or ledger and folders cannot be read.
pub async fn repair(settings: &Settings) -> Result<Reconciled> {
    let _lock = Lock::take(&settings.state_dir, jiff::Timestamp::now())?;
    let ledger = Ledger::open_whole(&settings.ledger).await?;
    let reconciled = reconcile(settings, &ledger).await;
    ledger.close_sealed().await?;
    reconciled
}

/// Likewise, for a ledger that is open and locked.
pub async fn reconcile(settings: &Settings, ledger: &Ledger) -> Result<Reconciled> {
    let mut found = Reconciled::default();
    let unknown = unknown_builds(settings, ledger, true).await?;
    if !unknown.is_empty() {
        give_up_plans(ledger, &unknown, &mut found).await?;
    }
    for build in &unknown {
        match ledger.take_in_record(&build.record, build.is_published).await {
            Ok(TakenIn::Known) => {}
            Ok(TakenIn::Now(id, doubts)) => {
                found.done.push(format!(
                    "build {id} ({} of {}) was published; its copies are taken in",
                    build.name, build.profile
                ));
                found.doubts.extend(doubts);
            }
            Err(error) => found.doubts.push(format!("the record of {} cannot be taken in: {error}", build.name)),
        }
    }
    for profile in settings.profiles.values() {
        take_out_what_was_refused(ledger, settings, profile, &mut found).await?;
    }
    tell_unknown_files(ledger, settings, &mut found).await?;
    if found != Reconciled::default() {
        ledger.leave_gap_in_numbers(GAP).await?;
    }
    Ok(found)
}

/// Builds of which the folders tell and the ledger does not. When not `all` are asked for, only those that are younger than
/// the ledger's youngest: with them, the ledger is older than its folders.
pub async fn unknown_builds(settings: &Settings, ledger: &Ledger, all: bool) -> Result<Vec<Unknown>> {
    let (newest, fired) = ledger.newest_build().await?;
    let fired = fired.map(|at| at.strftime("%Y%m%dT%H%M%SZ").to_string()).unwrap_or_default();
    let may_be_unknown = |name: &str| {
        record::fired_and_number(name).is_some_and(|(at, number)| all || number > newest || at > fired.as_str())
    };
    let mut unknown = Vec::new();
    for profile in settings.profiles.values() {
        let mut seen = HashSet::new();
        for (name, file) in record::all(&profile.folders.archive) {
            if may_be_unknown(&name) && !ledger.knows_build_file(&name).await? {
                let record = fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?;
                let is_published = !is_staged(&profile.folders.queue, &name);
                seen.insert(name.clone());
                unknown.push(Unknown { name, profile: profile.name.clone(), record, is_published });
            }
        }
        for name in build_files(&profile.folders.queue) {
            if may_be_unknown(&name) && !seen.contains(&name) && !ledger.knows_build_file(&name).await? {
                unknown.extend(from_build_file(settings, ledger, profile, &name).await?);
            }
        }
    }
    unknown.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(unknown)
}

/// Whether the file waits under its dot-name: its record was written, and then it was not published.
fn is_staged(queue: &Path, name: &str) -> bool {
    queue.is_dir()
        && Queue::open(queue).and_then(|queue| queue.state(name)).is_ok_and(|state| state == StagedState::Staged)
}

fn build_files(queue: &Path) -> Vec<String> {
    let entries = fs::read_dir(queue).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| !name.starts_with('.') && name.ends_with(".build.3mf"));
    names.sort();
    names
}

/// What a build file without a record tells of parts that the ledger knows; `None` when it holds none of them, so that
/// nothing of it could be printed twice.
async fn from_build_file(
    settings: &Settings,
    ledger: &Ledger,
    profile: &Profile,
    name: &str,
) -> Result<Option<Unknown>> {
    let file = profile.folders.queue.join(name);
    // What is no build file of ours tells nothing.
    let Ok(placed) = format::read_build(&file, &settings.limits) else { return Ok(None) };
    let (mut parts, mut placements, mut height_mm) = (Vec::new(), Vec::new(), 0.0_f64);
    for item in &placed {
        height_mm = height_mm.max(item.mesh.bounds_at(&item.pose).max.z);
        let number = item.part_number.as_deref().and_then(|number| number.parse().ok()).map(PartId);
        let (Some(id), Some(hash), Some(copy)) = (number, &item.source_hash, item.copy) else { continue };
        if !ledger.is_part_of_content(id, hash).await? {
            continue;
        }
        if !parts.iter().any(|part: &serde_json::Value| part["id"] == id.0) {
            parts.extend(ledger.part_for_record(id).await?);
        }
        let ([qx, qy, qz, qw], [x, y, z]) = (item.pose.rotation.to_array(), item.pose.translation.to_array());
        placements.push(json!({
            "part_id": id.0, "copy": copy - 1, "qx": qx, "qy": qy, "qz": qz, "qw": qw, "tx_mm": x, "ty_mm": y, "tz_mm": z,
        }));
    }
    if placements.is_empty() {
        return Ok(None);
    }
    let (number, bytes) = (record::fired_and_number(name).map(|(_, number)| number), fs::metadata(&file)?.len());
    let at = jiff::Timestamp::try_from(fs::metadata(&file)?.modified()?).unwrap_or_default();
    let at = crate::ledger::Utc(at).to_string();
    let build = json!({
        "id": number, "profile": profile.name, "fired_by": "", "attempts": 1, "opened_at": at, "nesting_at": at,
        "verified_at": at, "state_at": at, "file_name": name, "file_hash": intake::hash_file(&file)?, "file_bytes": bytes,
        "height_mm": height_mm, "copies": placements.len(), "reason": "taken in from the build file in the queue",
    });
    let record = json!({ "builds": [build], "parts": parts, "placements": placements }).to_string();
    Ok(Some(Unknown { name: name.to_owned(), profile: profile.name.clone(), record, is_published: true }))
}

/// What was being nested when the backup was made has long become something else: its copies wait again.
async fn give_up_plans(ledger: &Ledger, unknown: &[Unknown], found: &mut Reconciled) -> Result<()> {
    for build in ledger.builds_in_state(BuildState::Nesting).await? {
        let number = |name: &str| record::fired_and_number(name).map(|(_, number)| number);
        if unknown.iter().any(|one| one.profile == build.profile && number(&one.name) == Some(build.id.0)) {
            let copies = ledger.copies_of_build(build.id).await?;
            ledger.release_copies(build.id, &copies).await?;
        } else {
            ledger.fail_build(build.id, "the ledger was put back from a backup").await?;
            found.done.push(format!("build {} was being nested and is given up; its copies wait", build.id));
        }
    }
    Ok(())
}

/// Parts that wait in the ledger, but lie refused or cancelled in the error folder or are kept nowhere any more.
async fn take_out_what_was_refused(
    ledger: &Ledger,
    settings: &Settings,
    profile: &Profile,
    found: &mut Reconciled,
) -> Result<()> {
    let mut live = ledger.parts_in_state(PartState::Waiting).await?;
    live.extend(ledger.parts_in_state(PartState::Claimed).await?);
    for part in live.into_iter().filter(|part| part.profile == profile.name) {
        if intake::claim_dir(&profile.folders.inbox, &part.claim).exists() {
            continue;
        }
        let why = if !tidy::refused_files(&profile.folders.error, &part)?.is_empty() {
            "It lies in the error folder: it was refused or cancelled after the backup was made."
        } else if !is_stored(settings, &part)? {
            "Its file is no longer kept: it was built, refused or cancelled after the backup was made."
        } else {
            continue;
        };
        match part.state {
            PartState::Claimed => ledger.reject(part.id, Refusal::Other, why).await?,
            _ => ledger.cancel(part.id, Refusal::Other, why).await?,
        }
        found.doubts.push(format!(
            "part {} ({}) is taken out. {why} `nestd retry {}` takes it back",
            part.id, part.name, part.id
        ));
    }
    Ok(())
}

fn is_stored(settings: &Settings, part: &PartRow) -> Result<bool> {
    let hash = &part.content_hash;
    let folder = hash.get(..2).context("a part without a hash")?;
    Ok(settings.state_dir.join("store").join(folder).join(hash).exists())
}

/// Files that were taken after the backup was made and are in no build: their names and copies are not known.
async fn tell_unknown_files(ledger: &Ledger, settings: &Settings, found: &mut Reconciled) -> Result<()> {
    let known: HashSet<String> = ledger.drops_by_hash().await?.into_iter().map(|(hash, _)| hash).collect();
    let mut refused = HashSet::new();
    for profile in settings.profiles.values() {
        for file in intake::files_below(&profile.folders.error).unwrap_or_default() {
            refused.extend(intake::hash_file(&file).ok());
        }
    }
    for file in intake::files_below(&settings.state_dir.join("store")).unwrap_or_default() {
        let hash = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if hash.len() == 64 && !known.contains(&hash) && !refused.contains(&hash) {
            let bytes = fs::metadata(&file).map_or(0, |meta| meta.len());
            found.doubts.push(format!(
                "{} ({bytes} bytes) was taken after the backup was made and is not built: look at it, and drop it again with \
                 its copies",
                file.display()
            ));
        }
    }
    Ok(())
}

/// Refuses to serve a farm whose ledger is older than its folders.
pub async fn demand_current(settings: &Settings, ledger: &Ledger) -> Result<()> {
    let unknown = unknown_builds(settings, ledger, false).await?;
    let Some(first) = unknown.first() else { return Ok(()) };
    let more = if unknown.len() > 1 { format!(" and {} more", unknown.len() - 1) } else { String::new() };
    Err(Behind { detail: format!("it does not know {}{more}", first.name) }.into())
}

/// The ledger is older than the folders.
#[derive(Debug, thiserror::Error)]
#[error("the ledger is older than the folders: {detail}. {}", Attention::LedgerBehind.remedy())]
pub struct Behind {
    /// What it does not know.
    pub detail: String,
}
