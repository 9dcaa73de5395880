//! Makes a ledger that is older than its folders, because it was put back from a backup, agree with them. The folders tell
//! what was published since: the records in the archive, and the build files that still lie in a queue.
//!
//! What is doubtful is not printed: a person is told, and can have it printed; a cake that was printed twice cannot be undone.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use serde_json::json;

use super::{
    decided::Since,
    error_folder,
    reconciled::{DECIDED_SINCE, Later, Reconciled, Refused, put_into_error},
    record, taken,
    told::{self, Known},
};
use crate::{
    intake,
    intake::Store,
    ledger::{BuildState, Ledger, LedgerError, PartId, PartRow, PartState, Refusal, TakenIn},
    queue::{Queue, StagedState},
    settings::{Profile, Settings},
};

/// Numbers of parts and builds that are skipped: those given out since the backup stand on reasons and build files.
const GAP: u32 = 1000;

/// A build of which the folders tell and the ledger does not.
#[derive(Debug)]
pub struct Unknown {
    /// Name of its file.
    pub name: String,
    profile: String,
    record: String,
    /// Where its record is, if it has one.
    file: Option<PathBuf>,
    is_published: bool,
}

/// Takes what the folders tell into a ledger that nobody uses yet.
///
/// # Errors
/// A folder cannot be asked, or the ledger cannot be changed.
pub async fn reconcile(settings: &Settings, ledger: &Ledger, known: &Known) -> Result<Reconciled> {
    known.demand_all(settings)?;
    let mut found = Reconciled::default();
    let mut unclear = HashSet::new();
    let mut unknown = Vec::new();
    for profile in settings.profiles.values() {
        unknown.extend(unknown_builds(settings, ledger, profile, known, &mut unclear).await?);
    }
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
            Err(error) => {
                found.doubts.push(format!(
                    "the record of {} cannot be taken in: {error}. `nestd show` does not know its parts: see that none of \
                     them is printed again",
                    build.name
                ));
                found.later.extend(build.file.clone().map(Later::SetRecordAside));
            }
        }
    }
    let refused = Refused::read(settings, known)?;
    let kept = taken::kept(settings)?;
    let mut since = Since::of(settings, ledger, &kept, &mut found).await?;
    let look = Look { settings, ledger, refused: &refused };
    for profile in settings.profiles.values() {
        take_out_what_was_refused(&look, profile, &mut since, &mut found).await?;
        put_back_what_was_taken_back(&look, profile, &mut since, &mut found).await?;
    }
    since.agree(ledger, &mut found).await?;
    let forgotten = taken::forgotten(settings, ledger, &kept).await?;
    let mut again = super::recall::Recall { settings, ledger, refused: &refused, unclear: &unclear, found: &mut found };
    for one in forgotten {
        again.take(one).await?;
    }
    if found != Reconciled::default() {
        ledger.leave_gap_in_numbers(GAP).await?;
    }
    Ok(found)
}

/// What is held against one another.
struct Look<'a> {
    settings: &'a Settings,
    ledger: &'a Ledger,
    refused: &'a Refused,
}

/// Builds of which a machine's folders tell and the ledger does not. Into `unclear` go the contents of build files that tell of
/// parts that the ledger never knew: they may be printed already.
///
/// # Errors
/// A folder cannot be asked.
pub async fn unknown_builds(
    settings: &Settings,
    ledger: &Ledger,
    profile: &Profile,
    known: &Known,
    unclear: &mut HashSet<String>,
) -> Result<Vec<Unknown>> {
    let told = told::builds(profile, known)?;
    let names: Vec<String> = told.iter().map(|build| build.name.clone()).collect();
    let names: HashSet<String> = ledger.unknown_build_files(&names).await?.into_iter().collect();
    let mut unknown = Vec::new();
    for told::ToldBuild { name, record: file } in told.into_iter().filter(|build| names.contains(&build.name)) {
        if record::fired_and_number(&name).is_none() {
            continue;
        }
        let Some(file) = file else {
            unknown.extend(from_build_file(settings, ledger, profile, &name, unclear).await?);
            continue;
        };
        let record = fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?;
        let is_published = !is_staged(&profile.folders.queue, &name)?;
        unknown.push(Unknown { name, profile: profile.name.clone(), record, file: Some(file), is_published });
    }
    Ok(unknown)
}

/// Whether the file waits under its dot-name: its record was written, and then it was not published.
fn is_staged(queue: &Path, name: &str) -> Result<bool> {
    if !queue.try_exists().with_context(|| format!("looking at {}", queue.display()))? {
        return Ok(false);
    }
    let state = Queue::open(queue).and_then(|queue| queue.state(name));
    Ok(state.with_context(|| format!("looking for {name} in {}", queue.display()))? == StagedState::Staged)
}

/// What a build file without a record tells of parts that the ledger knows; `None` when it holds none of them, so that
/// nothing of it could be printed twice.
async fn from_build_file(
    settings: &Settings,
    ledger: &Ledger,
    profile: &Profile,
    name: &str,
    unclear: &mut HashSet<String>,
) -> Result<Option<Unknown>> {
    let file = profile.folders.queue.join(name);
    fs::File::open(&file).with_context(|| format!("reading {}", file.display()))?;
    // What is no build file of ours tells nothing.
    let Ok(placed) = build_file::read_build(&file, &settings.limits) else { return Ok(None) };
    let (mut parts, mut placements, mut height_mm) = (Vec::new(), Vec::new(), 0.0_f64);
    for item in &placed {
        height_mm = height_mm.max(item.mesh.bounds_at(&item.pose).max.z);
        let number = item.part_number.as_deref().and_then(|number| number.parse().ok()).map(PartId);
        let (Some(id), Some(hash), Some(copy)) = (number, &item.source_hash, item.copy) else { continue };
        if !ledger.is_part_of_content(id, hash).await? {
            unclear.insert(hash.clone());
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
    let (name, profile) = (name.to_owned(), profile.name.clone());
    Ok(Some(Unknown { name, profile, record, file: None, is_published: true }))
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

/// Parts that wait in the ledger, but lie refused or cancelled in the error folder, were decided of since, or are kept nowhere
/// any more.
async fn take_out_what_was_refused(
    look: &Look<'_>,
    profile: &Profile,
    since: &mut Since,
    found: &mut Reconciled,
) -> Result<()> {
    let (ledger, settings) = (look.ledger, look.settings);
    let mut live = ledger.parts_in_state(PartState::Waiting).await?;
    live.extend(ledger.parts_in_state(PartState::Claimed).await?);
    for part in live.into_iter().filter(|part| part.profile == profile.name) {
        let (is_in_work, is_decided) = (is_in_work(profile, &part)?, since.has(&part));
        if is_in_work && !is_decided {
            continue;
        }
        let (lies, is_stored) = (lies(look.refused, profile, &part)?, is_stored(settings, &part)?);
        let why = match () {
            () if lies => {
                "It lies in the error folder: it was refused or cancelled after the backup was made".to_owned()
            }
            () if !is_stored => {
                "Its file is no longer kept: it was built, refused or cancelled after the backup was made".to_owned()
            }
            () if is_decided => DECIDED_SINCE.to_owned(),
            () => continue,
        } + ".";
        if let Err(error) = take_out(ledger, &part, &why).await {
            let LedgerError::BeingBuilt { build, .. } = error else { return Err(error.into()) };
            let doubt = format!(
                "part {} ({}) has copies in build {build}, which is to be published. {why} `nestd cancel {0}` takes out what \
                 is left of it then",
                part.id, part.name
            );
            since.tell(&part, found, doubt);
            continue;
        }
        if let Some(part) = ledger.part(part.id).await?
            && !lies
            && is_stored
            && !is_in_work
        {
            put_into_error(settings, profile, &part)?;
        }
        let doubt = format!("part {} ({}) is taken out. {why} `nestd retry {0}` takes it back", part.id, part.name);
        since.tell(&part, found, doubt);
    }
    Ok(())
}

/// waiting, claimed -> rejected; a claimed one takes its siblings with it.
async fn take_out(ledger: &Ledger, part: &PartRow, why: &str) -> Result<(), LedgerError> {
    match ledger.part(part.id).await?.map(|now| now.state) {
        Some(PartState::Claimed) => ledger.reject(part.id, Refusal::Other, why).await,
        Some(PartState::Waiting) => ledger.cancel(part.id, Refusal::Other, why).await,
        _ => Ok(()),
    }
}

/// Parts that are refused in the ledger and were taken back after the backup was made: their files went from the error folder
/// then. What became of them is not known, so that a person decides; the file lies where he looks for it.
async fn put_back_what_was_taken_back(
    look: &Look<'_>,
    profile: &Profile,
    since: &mut Since,
    found: &mut Reconciled,
) -> Result<()> {
    for part in look.ledger.parts_in_state(PartState::Rejected).await? {
        if part.profile != profile.name || since.is_told(&part) || is_in_work(profile, &part)? {
            continue;
        }
        if !is_stored(look.settings, &part)? || lies(look.refused, profile, &part)? {
            continue;
        }
        put_into_error(look.settings, profile, &part)?;
        let doubt = format!(
            "part {} ({}) was refused before the backup was made and taken back or tidied away after it; its file lies in {} \
             again. `nestd retry {0}` takes it back",
            part.id,
            part.name,
            profile.folders.error.display()
        );
        since.tell(&part, found, doubt);
    }
    Ok(())
}

/// Whether a part's file lies in the error folder with a reason that names it.
fn lies(refused: &Refused, profile: &Profile, part: &PartRow) -> Result<bool> {
    let may_lie = !refused.of(&profile.name, &part.file.content_hash).is_empty();
    Ok(may_lie && !error_folder::refused_files(&profile.folders.error, part)?.is_empty())
}

fn is_in_work(profile: &Profile, part: &PartRow) -> Result<bool> {
    let dir = intake::claim_dir(&profile.folders.inbox, &part.file.claim);
    dir.try_exists().with_context(|| format!("looking at {}", dir.display()))
}

fn is_stored(settings: &Settings, part: &PartRow) -> Result<bool> {
    let stored = Store::at(settings.state_dir.join("store")).path(&part.file.content_hash)?;
    stored.try_exists().with_context(|| format!("looking at {}", stored.display()))
}
