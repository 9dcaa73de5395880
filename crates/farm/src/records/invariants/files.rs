//! I1 and I4: where the file of every part must be.

use std::collections::{BTreeMap, HashMap, HashSet};

use anyhow::Result;
use intake::{ContentStore, StoreError};
use jiff::{SignedDuration, Timestamp};
use ledger::{BuildState, Ledger, PartFileRow, PartId, PartState, is_missing_file};
use settings::Settings;

use super::{
    folders::{FilesByHash, FolderContents, files_by_hash},
    report::{
        Invariant::{I1, I4},
        InvariantExpectations, InvariantReport,
    },
};
use crate::{
    decisions::trigger::secs_between,
    records::{build_record::archive_folder, forgettable::KEEP_REFUSED_SECS, kept_build::KeptBuild},
};

/// The archive is purged by the age of its files; an original is archived at most this long before its build is
/// published.
const NESTED_WITHIN: SignedDuration = SignedDuration::from_hours(48);

/// The file of a live part is in the store; that of a refused part is in the error folder and, for a time, in the
/// store.
pub async fn check_live_and_refused_parts(
    settings: &Settings,
    ledger: &Ledger,
    folders: &FolderContents,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    let mut stored = StoreVerifier::for_settings(settings);
    let begun = ArchivedParts::of_begun_builds(settings, ledger, report).await?;
    let mut refused: BTreeMap<(&str, &str), Vec<&PartFileRow>> = BTreeMap::new();
    let places = ledger.unbuilt_part_files().await?;
    for part in places.iter().filter(|part| is_of_this_node(settings, ledger, &part.machine)) {
        if is_missing_file(&part.claim) {
            continue;
        }
        if part.state == PartState::Refused {
            refused.entry((&part.machine, &part.content_hash)).or_default().push(part);
        } else if !begun.hold(part) {
            check_live_part(part, folders, &mut stored, report);
        }
    }
    for ((machine, hash), parts) in &refused {
        let Some(errors) = folders.error.get(*machine) else { continue };
        let lie = errors.get(*hash).map_or(0, Vec::len);
        let is_stored = stored.verify_content(hash, report).is_ok();
        check_refused_copies(parts, (lie, is_stored), folders, witness, report);
        if lie > 0 || is_stored {
            check_kept_for_retry(parts, &mut stored, report);
        }
    }
    if witness.at_rest {
        for (machine, errors) in &folders.error {
            for (hash, paths) in errors.iter().filter(|(hash, _)| !refused.contains_key(&(machine, hash))) {
                check_error_folder_duplicates(ledger, machine, hash, paths, report).await?;
            }
        }
    }
    Ok(())
}

/// Whether the files of a machine are on this server: where several nodes share a ledger, each has the files of its own machines.
fn is_of_this_node(settings: &Settings, ledger: &Ledger, machine: &str) -> bool {
    ledger.file().is_some() || settings.profiles.contains_key(machine)
}

/// The parts of builds whose publishing has begun, and the originals that their archives have. A ledger may know them as batched until the
/// next start finds out that their build was published.
struct ArchivedParts(Vec<(HashSet<PartId>, FilesByHash)>);

impl ArchivedParts {
    async fn of_begun_builds(settings: &Settings, ledger: &Ledger, report: &mut InvariantReport) -> Result<Self> {
        let mut begun = Vec::new();
        for build in ledger.builds_in_state(BuildState::Verified).await? {
            let (Some(profile), Some(name)) = (settings.profiles.get(&build.machine), &build.staged.file_name) else {
                continue;
            };
            if build.staged.publishing_at.is_some() {
                let parts = ledger.copies_of_build(build.id).await?.into_iter().map(|(part, _)| part).collect();
                let folder = archive_folder(&profile.folders.archive, name);
                begun.push((parts, files_by_hash(&folder, |_| true, report)));
            }
        }
        Ok(Self(begun))
    }

    fn hold(&self, part: &PartFileRow) -> bool {
        let is_held = |(parts, files): &(HashSet<PartId>, FilesByHash)| {
            parts.contains(&part.id) && files.contains_key(&part.content_hash)
        };
        part.state == PartState::Batched && self.0.iter().any(is_held)
    }
}

/// Verifies each content once, even if many parts share it.
struct StoreVerifier {
    store: ContentStore,
    known: HashMap<String, Result<(), String>>,
}

impl StoreVerifier {
    fn for_settings(settings: &Settings) -> Self {
        Self { store: ContentStore::from_dir(settings.state_dir.join("store")), known: HashMap::new() }
    }

    fn verify_content(&mut self, hash: &str, report: &mut InvariantReport) -> Result<(), String> {
        if let Some(known) = self.known.get(hash) {
            return known.clone();
        }
        report.files_read += 1;
        let answer = self.store.verify_hash(hash).map_err(|error| match error {
            StoreError::Damaged(path) => format!("{} does not hold the bytes that its name says", path.display()),
            other => crate::alerts::failure::error_chain(&other),
        });
        self.known.insert(hash.to_owned(), answer.clone());
        answer
    }
}

fn check_live_part(
    part: &PartFileRow,
    folders: &FolderContents,
    stored: &mut StoreVerifier,
    report: &mut InvariantReport,
) {
    let Err(why) = stored.verify_content(&part.content_hash, report) else { return };
    // Copies of it are printed again, and its original is fetched from the archive.
    if part.fetch_at.is_some() {
        return;
    }
    // Until it is read, the claimed original can replace the stored file: the next start stores it again.
    let in_work = folders.work.get(&part.machine).and_then(|work| work.claims.iter().find(|c| c.id == part.claim));
    if part.state == PartState::Claimed
        && in_work.is_some_and(|claim| intake::hash_file(&claim.part).is_ok_and(|hash| hash == part.content_hash))
    {
        return;
    }
    let (id, name) = (part.id, &part.name);
    let text = format!("part {id} ({name}) is {} and its file is not whole in the store: {why}", part.state);
    let remedy = format!(
        "put the file with the BLAKE3 {} back from a backup of the state folder, or cancel part {id} and drop it again",
        part.content_hash
    );
    report.add_violation(I1, text, remedy);
}

/// Each refused content is in the error folder at least once, and not more often than it was refused. `lie` = how often it
/// lies there, `is_stored` = the store has it too.
fn check_refused_copies(
    parts: &[&PartFileRow],
    (lie, is_stored): (usize, bool),
    folders: &FolderContents,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) {
    let [first, ..] = parts else { return };
    let (id, name) = (first.id, &first.name);
    let waits = folders.work.get(&first.machine).is_some_and(|work| {
        !witness.at_rest && work.claims.iter().any(|claim| parts.iter().any(|part| part.claim == claim.id))
    });
    if lie == 0 && !waits {
        let text = format!("part {id} ({name}) is refused and its file is not in the error folder");
        let remedy = match is_stored {
            true => format!("when nobody took it away on purpose, `nestd retry {id}` takes it from the store"),
            false => "to print it, drop its file again; otherwise nothing is to be done".to_owned(),
        };
        report.add_manual_violation(I1, text, remedy);
    }
    if lie > parts.len() {
        let text = format!("part {id} ({name}) is refused once and its file lies {lie} times in the error folder");
        report.add_manual_violation(I1, text, "keep one of them and remove the others");
    }
}

/// Refused files stay in the store for `nestd retry`.
fn check_kept_for_retry(parts: &[&PartFileRow], stored: &mut StoreVerifier, report: &mut InvariantReport) {
    let now = Timestamp::now();
    let young = parts.iter().find(|part| secs_between(part.state_at.0, now) < KEEP_REFUSED_SECS);
    let Some(part) = young else { return };
    if let Err(why) = stored.verify_content(&part.content_hash, report) {
        let text = format!("part {} ({}) was refused lately and cannot be taken back: {why}", part.id, part.name);
        // Nothing can end this but time, and it may be settled long since: it is no problem of the farm.
        report.add_manual_violation(I4, text, "to print it, drop its file again; otherwise nothing is to be done");
    }
}

/// A file in the error folder whose part is not refused (any more) is in two places.
async fn check_error_folder_duplicates(
    ledger: &Ledger,
    machine: &str,
    hash: &str,
    paths: &[std::path::PathBuf],
    report: &mut InvariantReport,
) -> Result<()> {
    if let Some(part) = ledger.find_part_with_content(machine, hash).await? {
        let text = format!("part {} is {} and its file also lies at {}", part.id, part.state, paths[0].display());
        report.add_violation(I1, text, "remove it there: the part goes on without it");
    }
    Ok(())
}

/// The originals of published builds are in the archive for as long as the profile says.
pub async fn check_archived_originals(
    settings: &Settings,
    ledger: &Ledger,
    report: &mut InvariantReport,
) -> Result<()> {
    let oldest = settings.profiles.values().map(|profile| originals_required_since(profile.output.archive_days)).min();
    let mut archives: HashMap<String, FilesByHash> = HashMap::new();
    for row in ledger.built_parts_since(oldest.unwrap_or(Timestamp::MIN)).await? {
        let Some(profile) = settings.profiles.get(&row.machine) else { continue };
        let Some(build) = ledger.find_build(row.build).await? else { continue };
        let since = originals_required_since(profile.output.archive_days);
        let is_required = build.times.published_at.is_some_and(|at| at.0 >= since);
        // A build that was issued once more from a kept file never had them.
        let is_from_kept = build.search.repeats.is_some()
            && KeptBuild::of_build(&profile.folders.archive, &build).is_some_and(|kept| kept.path().is_file());
        if !is_required || is_from_kept {
            continue;
        }
        let folder = archive_folder(&profile.folders.archive, &row.file_name);
        // Another node that served the machine then has published it into an archive of its own.
        if ledger.file().is_none() && !folder.exists() {
            continue;
        }
        let archived =
            archives.entry(row.file_name.clone()).or_insert_with(|| files_by_hash(&folder, |_| true, report));
        if !archived.contains_key(&row.content_hash) {
            let text = format!(
                "part {} ({}) is printed in build {} and its original is not in {}",
                row.part,
                row.name,
                row.build,
                folder.display()
            );
            let remedy =
                "nestd keeps originals for archive_days: ask who else deletes there, and put it back if needed";
            report.add_manual_violation(I1, text, remedy);
        }
    }
    Ok(())
}

/// Originals of builds published since this time must be in the archive.
fn originals_required_since(archive_days: u32) -> Timestamp {
    if archive_days == 0 {
        return Timestamp::MIN;
    }
    let keep = SignedDuration::from_hours(24 * i64::from(archive_days)) - NESTED_WITHIN;
    Timestamp::now().checked_sub(keep).unwrap_or(Timestamp::MIN)
}

/// Each claim in `.claimed/` belongs to a part that is being taken; at rest there is none.
pub async fn check_open_claims(
    ledger: &Ledger,
    folders: &FolderContents,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    if !witness.at_rest {
        return Ok(());
    }
    for work in folders.work.values() {
        for path in &work.unfinished {
            let text = format!("{} was left half done", path.display());
            report.add_violation(I1, text, "restart the daemon: it gives back what was taken and removes what is done");
        }
        for claim in &work.claims {
            let parts = ledger.parts_of_claim(&claim.id).await?;
            let text = match parts.first() {
                None => format!("{} was claimed and has no row", claim.part.display()),
                Some(part) => format!("{} lies in work, and part {} is {}", claim.part.display(), part.id, part.state),
            };
            report.add_violation(I1, text, "restart the daemon, which ends every claim; its log says what hinders it");
        }
    }
    Ok(())
}

/// Every content is in the ledger, in work or still in the hot folder, as often as it was dropped.
pub async fn check_dropped_files(
    ledger: &Ledger,
    folders: &FolderContents,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    let recorded: BTreeMap<String, u32> = ledger.drop_counts_by_hash().await?.into_iter().collect();
    for (hash, &times) in &witness.dropped {
        let rows = recorded.get(hash).copied().unwrap_or(0) as usize;
        let lie: usize = folders.inbox.values().filter_map(|inbox| inbox.get(hash)).map(Vec::len).sum();
        let mut unrecorded = 0;
        for claim in folders.work.values().flat_map(|work| &work.claims) {
            let is_it = intake::hash_file(&claim.part).is_ok_and(|found| found == *hash);
            unrecorded += usize::from(is_it && ledger.parts_of_claim(&claim.id).await?.is_empty());
        }
        // A half-made claim may hold the file; the next scan gives it back.
        for file in folders.work.values().flat_map(|work| &work.unfinished_files) {
            unrecorded += usize::from(intake::hash_file(file).is_ok_and(|found| found == *hash));
        }
        if rows + lie + unrecorded != times {
            let text = format!(
                "a file was dropped {times} times; {rows} are recorded, {unrecorded} are claimed, {lie} lie in the hot \
                 folder (BLAKE3 {hash})"
            );
            report.add_violation(I1, text, "keep all folders as they are and report it to nestd's makers");
        }
    }
    Ok(())
}

/// Files that do not belong to nestd are unchanged.
pub fn check_foreign_files(witness: &InvariantExpectations, report: &mut InvariantReport) {
    for (path, hash) in &witness.untouched {
        report.files_read += 1;
        let text = match intake::hash_file(path) {
            Ok(found) if found == *hash => continue,
            Ok(_) => format!("{} is not nestd's and was changed", path.display()),
            Err(error) => format!("{} is not nestd's and cannot be read any more: {error}", path.display()),
        };
        report.add_violation(I4, text, "put it back and report it to nestd's makers");
    }
}
