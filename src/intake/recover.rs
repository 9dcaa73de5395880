//! What lies in `.claimed/` after a crash: whole claims are listed, half made ones given back, half removed ones removed.

use std::{
    ffi::{OsStr, OsString},
    fs, io,
    path::{Path, PathBuf},
};

use super::{
    Claim, ClaimError, Said,
    beside::{Role, SAID_NAME, role, short_name},
    claim_folder::{CLAIMED_DIR, DONE, NEW, claiming, is_foreign},
    claimed::io_error,
    disk, given_back,
    marks::sweep_marks,
    name::numbered,
    same_name::folded_path,
};

/// The claims of a farm that lie in `.claimed/`, oldest first, and what could not be recovered now; gives back what a crash left half
/// claimed and removes what it left half released. To be called before a scan: what it gives back is then listed like any
/// other drop.
pub fn claims(inbox: &Path, farm: &str) -> Result<(Vec<Claim>, Vec<String>), ClaimError> {
    let _only_one = claiming(inbox);
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
        // Another farm's lies there until a person adopts it.
        if is_foreign(&dir.file_name().unwrap_or_default().to_string_lossy(), farm) {
            continue;
        }
        match recover(inbox, &dir) {
            Ok(found) => claims.extend(found),
            // It stays where it is and is tried again: the other claims must not wait for it.
            Err(error) => troubles.push(format!("cannot recover the claim {}: {error}", dir.display())),
        }
    }
    sweep_marks(inbox);
    claims.sort_by(|a, b| a.id.cmp(&b.id));
    Ok((claims, troubles))
}

/// What lies in `.claimed/`.
#[derive(Debug, Default)]
pub struct Work {
    /// Whole claims, oldest first.
    pub claims: Vec<Claim>,
    /// Claims that are being put together or taken apart, or that a crash left so.
    pub unfinished: Vec<PathBuf>,
    /// The files in those that are being put together.
    pub half_made: Vec<PathBuf>,
}

/// What lies in `.claimed/`, without touching it.
pub fn work(inbox: &Path) -> io::Result<Work> {
    let mut work = Work::default();
    let entries = match fs::read_dir(inbox.join(CLAIMED_DIR)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(work),
        other => other?,
    };
    for entry in entries {
        let (name, path) = entry.map(|e| (e.file_name(), e.path()))?;
        let is_unfinished = [NEW, DONE].iter().any(|with| name.as_encoded_bytes().starts_with(with.as_bytes()));
        match name.to_str().filter(|name| !name.starts_with('.')).map(|id| Claim::load(inbox, id)) {
            Some(claim) => match claim? {
                Some(claim) => work.claims.push(claim),
                None => work.unfinished.push(path),
            },
            None if is_unfinished => {
                if name.as_encoded_bytes().starts_with(NEW.as_bytes()) {
                    work.half_made.extend(disk::files_below(&path)?);
                }
                work.unfinished.push(path);
            }
            None => {}
        }
    }
    work.claims.sort_by(|a, b| a.id.cmp(&b.id));
    Ok(work)
}

fn recover(inbox: &Path, dir: &Path) -> io::Result<Option<Claim>> {
    // Claims are folders that nestd made; anything else was put there by somebody else and is left alone.
    if !fs::symlink_metadata(dir)?.is_dir() {
        return Ok(None);
    }
    let name = dir.file_name().unwrap_or_default();
    let starts = |with: &str| name.as_encoded_bytes().starts_with(with.as_bytes());
    if starts(NEW) {
        give_back_files(inbox, dir)?;
    } else if starts(DONE) {
        fs::remove_dir_all(dir)?;
    } else if let (false, Some(id)) = (starts("."), name.to_str()) {
        match Claim::load(inbox, id)? {
            Some(claim) => return Ok(Some(claim)),
            // Its part was refused; a ticket may be left to be given back.
            None => give_back_files(inbox, dir)?,
        };
    }
    Ok(None)
}

/// Moves all that was taken back to where it was dropped, under a free name if there is something new, and removes the
/// claim. The copy of a list is only a copy. Returns where the (first) part is now.
pub(super) fn give_back_files(inbox: &Path, dir: &Path) -> io::Result<Option<PathBuf>> {
    let dir = &unmake(dir)?;
    let mut part = None;
    let files = disk::files_below(dir)?;
    // A ticket that still has its part goes back with it.
    let is_led = |file: &Path| files.iter().any(|part| follows(file, part));
    for file in files.iter().filter(|f| role(f) != Role::List && !is_led(f)) {
        let followers: Vec<&Path> = files.iter().map(PathBuf::as_path).filter(|f| follows(f, file)).collect();
        let said = file.parent().map(|folder| Said::load(&folder.join(SAID_NAME))).transpose()?.flatten();
        let back = give_back_one(inbox, dir, file, &followers, said)?;
        if role(file) == Role::Part {
            part = part.or(Some(back));
        }
    }
    remove_emptied(dir)?;
    Ok(part)
}

/// Removes a claim that was taken apart: the copies of its list and the folders, nothing else.
fn remove_emptied(dir: &Path) -> io::Result<()> {
    for file in disk::files_below(dir)?.iter().filter(|f| role(f) == Role::List) {
        fs::remove_file(file)?;
    }
    disk::remove_empty_folders(dir)
}

/// A claim that is taken apart must not look whole meanwhile: without its ticket it would be another order.
fn unmake(dir: &Path) -> io::Result<PathBuf> {
    let id = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if id.starts_with(NEW) {
        return Ok(dir.to_owned());
    }
    let new = dir.with_file_name(format!("{NEW}{id}"));
    disk::rename_noreplace(dir, &new)?;
    Ok(new)
}

fn follows(ticket: &Path, part: &Path) -> bool {
    let Role::Ticket { part: named } = role(ticket) else { return false };
    let (named, folded) = (folded_path(&named), folded_path(part));
    role(part) == Role::Part && (named == folded || short_name(&folded) == Some(named))
}

fn give_back_one(
    inbox: &Path,
    dir: &Path,
    file: &Path,
    followers: &[&Path],
    said: Option<Said>,
) -> io::Result<PathBuf> {
    let folder = file.parent().and_then(|p| p.strip_prefix(dir).ok()).unwrap_or(Path::new(""));
    let name = file.file_name().unwrap_or_default();
    for n in 1..=disk::MAX_NUMBER {
        let leader = numbered(name, n);
        let targets = follower_names(&leader, followers);
        if targets.iter().chain([&leader]).any(|t| disk::is_there(&inbox.join(folder).join(t))) {
            continue;
        }
        // The tickets first: a part in the hot folder is never without what is said about it.
        for (follower, target) in followers.iter().zip(&targets) {
            disk::rename_in(follower, inbox, &folder.join(target))?;
        }
        if role(file) == Role::Part && (said.is_some() || n > 1) {
            given_back::keep(inbox, file, &folder.join(&leader), said.unwrap_or_default())?;
        }
        disk::rename_in(file, inbox, &folder.join(&leader))?;
        return Ok(inbox.join(folder).join(leader));
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Names of the tickets of one part, in full: what was clear when they were claimed may be so no more. Only a second one of
/// the same kind has the short name.
fn follower_names(part: &OsStr, tickets: &[&Path]) -> Vec<OsString> {
    let mut names = Vec::new();
    for ticket in tickets {
        let full = follower_name(part, ticket);
        let short = follower_name(Path::new(part).with_extension("").as_os_str(), ticket);
        names.push(if names.contains(&full) { short } else { full });
    }
    names
}

/// The name of a ticket for a part of that name.
pub(super) fn follower_name(part: &OsStr, ticket: &Path) -> OsString {
    let mut name = part.to_owned();
    name.push(".");
    name.push(ticket.extension().unwrap_or_default());
    name
}

/// Removes a claim so that it is there whole or not at all.
///
/// Returns whether this call gave it its last name.
pub(super) fn remove_claim_dir(dir: &Path, step: &mut dyn FnMut()) -> io::Result<bool> {
    let id = dir.file_name().unwrap_or_default().to_string_lossy();
    let done = dir.with_file_name(format!("{DONE}{}", id.trim_start_matches(NEW)));
    let renamed = fs::rename(dir, &done);
    match &renamed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return renamed.map(|()| true),
        _ => step(),
    }
    match fs::remove_dir_all(&done) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => step(),
    }
    dir.parent().map_or(Ok(()), disk::fsync_dir)?;
    Ok(renamed.is_ok())
}
