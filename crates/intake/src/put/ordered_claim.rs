//! The claim of a line of an order that came by request. Nobody dropped its file: the claim is put together from what was put, under an id
//! that the line has for ever. So a claim that was recorded once is never a second part, however often it is put together, and one that is
//! lost before it was recorded, by a crash or by hand, is put together again. It is never given back to the hot folder.

use std::{
    fs, io,
    io::{Read, Write},
    path::Path,
};

use crate::{
    ClaimError, ClaimedPart, PutContents,
    folder::{
        claim_folder::{
            ADOPTED_PREFIX, CLAIMED_DIR, ORDERED_PREFIX, UNFINISHED_PREFIX, claim_folder_name, list_claim_folders,
            lock_claims, parse_folder_name,
        },
        claimed_part::io_error,
        disk,
    },
};

const BUFFER_BYTES: usize = 1 << 20;

/// What the claim of a line is made of.
#[derive(Debug, Clone, Copy)]
pub struct OrderedFile<'a> {
    /// Id of the claim, from [`ordered_claim_id`].
    pub claim: &'a str,
    /// File name.
    pub name: &'a str,
    /// Its ticket in JSON.
    pub ticket: &'a str,
    /// Where the files are that were put.
    pub contents: &'a PutContents,
    /// BLAKE3 of that file, 64 hex digits.
    pub hash: &'a str,
}

/// The id of the claim of a line: the same for the same line of the same request of a client, and for no other one.
pub fn ordered_claim_id(client: &str, key: &str, fingerprint: &str, line: usize) -> String {
    format!("{}-{line:04}", ordered_request_id(client, key, fingerprint))
}

/// The id of a request: the ids of the claims of its lines begin with it.
pub fn ordered_request_id(client: &str, key: &str, fingerprint: &str) -> String {
    let mut hasher = blake3::Hasher::new();
    for text in [client, key, fingerprint] {
        hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
    }
    format!("{ORDERED_PREFIX}{}", &hasher.finalize().to_hex()[..32])
}

/// Puts the claim of a line together. `None` = it is there already, or another farm has taken it over.
///
/// # Errors
/// The content is not there or has other bytes than it had, or the hot folder cannot be written.
pub fn place_ordered_claim(inbox: &Path, farm: &str, file: &OrderedFile) -> Result<Option<ClaimedPart>, ClaimError> {
    place_stepwise(inbox, farm, file, &mut || {})
}

/// Calls `step` between any two steps where a crash could happen, so that tests can stop there.
pub(super) fn place_stepwise(
    inbox: &Path,
    farm: &str,
    file: &OrderedFile,
    step: &mut dyn FnMut(),
) -> Result<Option<ClaimedPart>, ClaimError> {
    let claimed = inbox.join(CLAIMED_DIR);
    let names = list_claim_folders(inbox).map_err(|e| io_error("list", &claimed, e))?;
    let is_there = |name: &String| {
        parse_folder_name(name).0 == file.claim && (!name.starts_with('.') || name.starts_with(ADOPTED_PREFIX))
    };
    if names.iter().any(is_there) {
        return Ok(None);
    }
    disk::create_dirs_beneath(inbox, Path::new(CLAIMED_DIR)).map_err(|e| io_error("create", &claimed, e))?;
    let name = claim_folder_name(file.claim, farm);
    let new = claimed.join(format!("{UNFINISHED_PREFIX}{name}"));
    assemble_claim(&new, file, step).map_err(|e| io_error("put together the claim", &new, e))?;
    let _only_one = lock_claims(inbox);
    disk::rename_noreplace(&new, &claimed.join(&name)).map_err(|e| io_error("claim", &new, e))?;
    step();
    disk::fsync_dir(&claimed).map_err(|e| io_error("fsync", &claimed, e))?;
    ClaimedPart::load_from_folder(inbox, &name).map_err(|e| io_error("read the claim", &claimed.join(&name), e))
}

fn assemble_claim(new: &Path, file: &OrderedFile, step: &mut dyn FnMut()) -> io::Result<()> {
    disk::remove_folder(new)?;
    step();
    disk::create_dirs(new)?;
    step();
    let mut ticket = disk::create_fresh_file(&new.join(format!("{}.json", file.name)))?;
    ticket.write_all(file.ticket.as_bytes())?;
    ticket.sync_all()?;
    step();
    let missing = |error: io::Error| match error.kind() {
        io::ErrorKind::NotFound => io::Error::new(error.kind(), format!("content {} is gone: put it again", file.hash)),
        _ => error,
    };
    let content = file.contents.path_of(file.hash);
    let source = disk::open_regular_file(&content).map_err(missing)?;
    let copied = copy_hashed(source, &new.join(file.name))?;
    step();
    if copied != file.hash {
        // Or a put would find it there.
        file.contents.move_damaged_aside(file.hash)?;
        return Err(io::Error::other(format!("{} was damaged: put that content again", content.display())));
    }
    disk::fsync_dir(new)
}

/// Copies a file durably, and returns the BLAKE3 of what was copied.
fn copy_hashed(mut source: fs::File, to: &Path) -> io::Result<String> {
    let mut target = disk::create_fresh_file(to)?;
    let (mut hasher, mut buffer) = (blake3::Hasher::new(), vec![0; BUFFER_BYTES]);
    loop {
        let count = source.read(&mut buffer)?;
        if count == 0 {
            target.sync_all()?;
            return Ok(hasher.finalize().to_hex().to_string());
        }
        hasher.update(&buffer[..count]);
        target.write_all(&buffer[..count])?;
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use super::*;
    use crate::{folder::claim_folder::is_ordered_claim, recover_claims};

    fn file<'a>(contents: &'a PutContents, hash: &'a str) -> OrderedFile<'a> {
        OrderedFile { claim: "order-ab-0001", name: "a.stl", ticket: r#"{"copies":3,"order":"K"}"#, contents, hash }
    }

    #[test]
    fn a_claim_is_put_together_once_wherever_a_crash_or_a_person_interrupts() {
        let folder = tempfile::tempdir().unwrap();
        let contents = PutContents::of_farm(folder.path());
        let hash = blake3::hash(b"solid").to_hex().to_string();
        contents.create_folder().unwrap();
        fs::write(contents.path_of(&hash), "solid").unwrap();
        let mut crashes = 0;
        for at in 0.. {
            let inbox = tempfile::tempdir().unwrap();
            let mut left = at;
            let mut step = || {
                assert!(left > 0, "a crash");
                left -= 1;
            };
            let place = AssertUnwindSafe(|| place_stepwise(inbox.path(), "f", &file(&contents, &hash), &mut step));
            let is_whole = catch_unwind(place).is_ok_and(|placed| placed.unwrap().is_some());
            let (claims, troubles) = recover_claims(inbox.path(), "f").unwrap();
            assert!(troubles.is_empty() && (claims.len() == 1 || !is_whole), "{at}: {claims:?} {troubles:?}");
            assert_eq!(fs::read_dir(inbox.path()).unwrap().count(), 1, "nothing is given back to the hot folder");
            let again = place_ordered_claim(inbox.path(), "f", &file(&contents, &hash)).unwrap();
            assert_eq!(again.is_some(), claims.is_empty());
            fs::remove_dir_all(inbox.path().join(".claimed/order-ab-0001@f")).unwrap();
            let claim = place_ordered_claim(inbox.path(), "f", &file(&contents, &hash)).unwrap().unwrap();
            let spec = claim.read_part_spec().unwrap();
            assert_eq!((spec.ticket.copies, spec.ticket.order.as_deref()), (Some(3), Some("K")));
            assert!(crate::give_back_claim(&claim).is_err(), "it is put together again instead");
            assert_eq!(fs::read_dir(inbox.path()).unwrap().count(), 1);
            assert!(!claim.dir.exists());
            if is_whole {
                break;
            }
            crashes += 1;
        }
        assert!(crashes >= 5);
    }

    #[test]
    fn content_that_is_gone_or_damaged_makes_no_claim_and_a_claim_of_another_farm_is_left_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let inbox = tempfile::tempdir().unwrap();
        let contents = PutContents::of_farm(folder.path());
        contents.create_folder().unwrap();
        let hash = blake3::hash(b"solid").to_hex().to_string();
        let content = contents.path_of(&hash);
        let gone = place_ordered_claim(inbox.path(), "f", &file(&contents, &hash)).unwrap_err();
        assert!(std::error::Error::source(&gone).unwrap().to_string().contains("put it again"), "{gone:?}");
        fs::write(&content, "solil").unwrap();
        let damaged = place_ordered_claim(inbox.path(), "f", &file(&contents, &hash)).unwrap_err();
        assert!(std::error::Error::source(&damaged).unwrap().to_string().contains("damaged"), "{damaged:?}");
        assert!(recover_claims(inbox.path(), "f").unwrap().0.is_empty());
        assert_eq!(contents.use_content(&hash).unwrap(), None, "it can be put again");
        assert_eq!(fs::read(folder.path().join("damaged").join(&hash)).unwrap(), b"solil", "what was damaged is kept");
        fs::write(&content, "solid").unwrap();
        fs::create_dir_all(inbox.path().join(".claimed/.adopted-order-ab-0001@f")).unwrap();
        assert_eq!(place_ordered_claim(inbox.path(), "f", &file(&contents, &hash)).unwrap(), None);
    }

    #[test]
    fn a_line_has_one_id_for_ever_and_no_other_line_has_it() {
        let id = ordered_claim_id("mes", "k1", "f", 1);
        assert_eq!(id, ordered_claim_id("mes", "k1", "f", 1));
        for other in [
            ordered_claim_id("mes", "k1", "f", 2),
            ordered_claim_id("mes", "k", "1f", 1),
            ordered_claim_id("me", "sk1", "f", 1),
            ordered_claim_id("mes", "k1", "g", 1),
        ] {
            assert_ne!(id, other);
        }
        assert!(
            is_ordered_claim(&format!(".new-{id}@farm")) && !is_ordered_claim("20261123T200000000Z-0000-00000000@f")
        );
    }
}
