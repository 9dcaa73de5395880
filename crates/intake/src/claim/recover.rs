//! Recovers `.claimed/` after a crash: complete claims are listed, incomplete ones are given back to the hot folder,
//! and partly removed ones are removed.

use std::{
    ffi::{OsStr, OsString},
    fs, io,
    path::{Path, PathBuf},
};

use super::{
    given_back,
    unpack::{UNPACK_PREFIX, finish_unpacked},
};
use crate::{
    ClaimError, ClaimedPart, ListLookup,
    folder::{
        claim_folder::{
            CLAIMED_DIR, EmptiedClaims, REMOVED_PREFIX, UNFINISHED_PREFIX, is_foreign_claim, is_ordered_claim,
            lock_claims,
        },
        claimed_part::io_error,
        disk,
        file_role::{FileRole, LIST_LOOKUP_NAME, file_role, without_hidden_txt},
    },
    lists::{served_rows::sweep_marks, sidecars::short_name},
    names::{name::numbered_name, name_match::fold_path},
};

/// Returns the complete claims of a farm in `.claimed/`, oldest first, and messages about claims that could not be
/// recovered now. Gives back the files of incomplete claims and removes partly released ones. Call this before a scan,
/// so that the scan lists the files that were given back.
pub fn recover_claims(inbox: &Path, farm: &str) -> Result<(Vec<ClaimedPart>, Vec<String>), ClaimError> {
    let _only_one = lock_claims(inbox);
    let claimed = inbox.join(CLAIMED_DIR);
    if fs::symlink_metadata(&claimed).is_ok_and(|meta| !meta.is_dir()) {
        return Err(io_error("use as the folder of the claims", &claimed, io::ErrorKind::NotADirectory.into()));
    }
    let entries = match fs::read_dir(&claimed) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Default::default()),
        other => other.map_err(|e| io_error("list", &claimed, e))?,
    };
    let (mut claims, mut troubles) = (Vec::new(), Vec::new());
    for entry in entries {
        let dir = entry.map_err(|e| io_error("list", &claimed, e))?.path();
        // A claim of another farm stays until a person adopts it.
        if is_foreign_claim(&dir.file_name().unwrap_or_default().to_string_lossy(), farm) {
            continue;
        }
        match recover_claim(inbox, &dir) {
            Ok(found) => claims.extend(found),
            // The claim stays in place and is tried again later. The other claims must not wait for it.
            Err(error) => troubles.push(format!("cannot recover the claim {}: {error}", dir.display())),
        }
    }
    sweep_marks(inbox);
    claims.sort_by(|a, b| a.id.cmp(&b.id));
    Ok((claims, troubles))
}

/// The content of `.claimed/`.
#[derive(Debug, Default)]
pub struct ClaimsOnDisk {
    /// Complete claims, oldest first.
    pub claims: Vec<ClaimedPart>,
    /// Claims that are being assembled or removed, or that a crash left in that state.
    pub unfinished: Vec<PathBuf>,
    /// The files in claims that are being assembled.
    pub unfinished_files: Vec<PathBuf>,
}

/// Lists the content of `.claimed/` without changing it.
pub fn list_claims(inbox: &Path) -> io::Result<ClaimsOnDisk> {
    let mut work = ClaimsOnDisk::default();
    let entries = match fs::read_dir(inbox.join(CLAIMED_DIR)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(work),
        other => other?,
    };
    for entry in entries {
        let (name, path) = entry.map(|e| (e.file_name(), e.path()))?;
        let is_unfinished =
            [UNFINISHED_PREFIX, REMOVED_PREFIX].iter().any(|with| name.as_encoded_bytes().starts_with(with.as_bytes()));
        match name.to_str().filter(|name| !name.starts_with('.')).map(|id| ClaimedPart::load_from_folder(inbox, id)) {
            Some(claim) => match claim? {
                Some(claim) => work.claims.push(claim),
                None => work.unfinished.push(path),
            },
            None if is_unfinished => {
                if name.as_encoded_bytes().starts_with(UNFINISHED_PREFIX.as_bytes()) {
                    work.unfinished_files.extend(disk::files_below(&path)?);
                }
                work.unfinished.push(path);
            }
            None => {}
        }
    }
    work.claims.sort_by(|a, b| a.id.cmp(&b.id));
    Ok(work)
}

fn recover_claim(inbox: &Path, dir: &Path) -> io::Result<Option<ClaimedPart>> {
    // Claims are folders made by nestd. Any other entry belongs to somebody else and is left alone.
    if !fs::symlink_metadata(dir)?.is_dir() {
        return Ok(None);
    }
    let name = dir.file_name().unwrap_or_default();
    let starts = |with: &str| name.as_encoded_bytes().starts_with(with.as_bytes());
    if starts(UNFINISHED_PREFIX) {
        give_back_files(inbox, dir)?;
    } else if starts(REMOVED_PREFIX) {
        fs::remove_dir_all(dir)?;
    } else if starts(UNPACK_PREFIX) {
        finish_unpacked(inbox, dir)?;
    } else if let (false, Some(id)) = (starts("."), name.to_str()) {
        match ClaimedPart::load_from_folder(inbox, id)? {
            Some(claim) => return Ok(Some(claim)),
            // Its part was refused. A ticket may be left, which is given back.
            None => give_back_files(inbox, dir)?,
        };
    }
    Ok(None)
}

/// Moves all claimed files back to where they were dropped, under a free name if the name is taken now, and removes the
/// claim. What the claim holds of a list is only a copy and is deleted. Returns the new path of the (first) part. The claim of
/// an ordered line is removed: the farm puts it together again.
pub(super) fn give_back_files(inbox: &Path, dir: &Path) -> io::Result<Option<PathBuf>> {
    let dir = &rename_to_unfinished(dir)?;
    if is_ordered_claim(&dir.file_name().unwrap_or_default().to_string_lossy()) {
        fs::remove_dir_all(dir)?;
        return Ok(None);
    }
    let mut part = None;
    let files = disk::files_below(dir)?;
    // A ticket whose part is still there goes back with the part.
    let is_led = |file: &Path| files.iter().any(|part| is_ticket_of(file, part));
    for file in files.iter().filter(|f| file_role(f) != FileRole::List && !is_led(f)) {
        let followers: Vec<&Path> = files.iter().map(PathBuf::as_path).filter(|f| is_ticket_of(f, file)).collect();
        let said =
            file.parent().map(|folder| ListLookup::load_from(&folder.join(LIST_LOOKUP_NAME))).transpose()?.flatten();
        let back = give_back_one(inbox, dir, file, &followers, said)?;
        if file_role(file) == FileRole::Part {
            part = part.or(Some(back));
        }
    }
    remove_emptied_claim(dir)?;
    Ok(part)
}

/// Removes a claim whose files were given back: deletes the copies of its list and the empty folders, nothing else.
fn remove_emptied_claim(dir: &Path) -> io::Result<()> {
    for file in disk::files_below(dir)?.iter().filter(|f| file_role(f) == FileRole::List) {
        fs::remove_file(file)?;
    }
    disk::remove_empty_folders(dir)
}

/// Renames a claim before its files are given back. It must not look complete meanwhile: without its ticket it would be
/// another order.
fn rename_to_unfinished(dir: &Path) -> io::Result<PathBuf> {
    let id = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if id.starts_with(UNFINISHED_PREFIX) {
        return Ok(dir.to_owned());
    }
    let new = dir.with_file_name(format!("{UNFINISHED_PREFIX}{id}"));
    disk::rename_noreplace(dir, &new)?;
    Ok(new)
}

fn is_ticket_of(ticket: &Path, part: &Path) -> bool {
    let FileRole::Ticket { part: named } = file_role(ticket) else { return false };
    let (named, folded) = (fold_path(&named), fold_path(part));
    file_role(part) == FileRole::Part && (named == folded || short_name(&folded) == Some(named))
}

fn give_back_one(
    inbox: &Path,
    dir: &Path,
    file: &Path,
    followers: &[&Path],
    said: Option<ListLookup>,
) -> io::Result<PathBuf> {
    let folder = file.parent().and_then(|p| p.strip_prefix(dir).ok()).unwrap_or(Path::new(""));
    let name = file.file_name().unwrap_or_default();
    for n in 1..=disk::MAX_NAME_NUMBER {
        let leader = numbered_name(name, n);
        let targets = full_ticket_names(&leader, followers);
        if targets.iter().chain([&leader]).any(|t| disk::path_exists(&inbox.join(folder).join(t))) {
            continue;
        }
        // The tickets are moved first, so a part in the hot folder is never without its instructions.
        for (follower, target) in followers.iter().zip(&targets) {
            disk::rename_in(follower, inbox, &folder.join(target))?;
        }
        if file_role(file) == FileRole::Part && (said.is_some() || n > 1) {
            given_back::save_note(inbox, file, &folder.join(&leader), said.unwrap_or_default())?;
        }
        disk::rename_in(file, inbox, &folder.join(&leader))?;
        return Ok(inbox.join(folder).join(leader));
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Returns ticket names that contain the full name of the part, because a short name that was unique at the time of the
/// claim may be ambiguous now. Only a second ticket with the same extension gets the short name.
fn full_ticket_names(part: &OsStr, tickets: &[&Path]) -> Vec<OsString> {
    let mut names = Vec::new();
    for ticket in tickets {
        let full = ticket_file_name(part, ticket);
        let short = ticket_file_name(Path::new(part).with_extension("").as_os_str(), ticket);
        names.push(if names.contains(&full) { short } else { full });
    }
    names
}

/// File name of a ticket for a part with this name.
pub(super) fn ticket_file_name(part: &OsStr, ticket: &Path) -> OsString {
    let mut name = part.to_owned();
    name.push(".");
    name.push(without_hidden_txt(ticket).extension().unwrap_or_default());
    name
}

/// Removes a claim atomically: it exists completely or not at all.
///
/// Returns whether this call did the rename that removes the claim.
pub(super) fn remove_claim_dir(emptied: &mut EmptiedClaims, dir: &Path, step: &mut dyn FnMut()) -> io::Result<bool> {
    let id = dir.file_name().unwrap_or_default().to_string_lossy();
    let done = dir.with_file_name(format!("{REMOVED_PREFIX}{}", id.trim_start_matches(UNFINISHED_PREFIX)));
    let renamed = fs::rename(dir, &done);
    match &renamed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return renamed.map(|()| true),
        _ => step(),
    }
    emptied.remove_folder(&done)?;
    step();
    dir.parent().map_or(Ok(()), disk::fsync_dir)?;
    Ok(renamed.is_ok())
}
