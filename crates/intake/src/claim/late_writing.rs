//! What is written into a file after it was taken. A program that rests behind a body may go on when its file was taken and removed, into
//! a file that no folder shows any more. So the originals of files that may grow are kept open for a while, and come back into the hot
//! folder, whole, when more was written.

use std::{
    collections::VecDeque,
    ffi::OsString,
    fs::{self, File},
    io::{self, Seek},
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use tracing::warn;

use super::{claim::create_claim_dir, recover::give_back_files};
use crate::{
    ClaimedPart, ListLookup, StoredFile,
    folder::{claim_folder::lock_claims, disk, file_role::LIST_LOOKUP_NAME},
};

/// More originals are not kept open; the oldest ones are closed.
const MOST_OPEN: usize = 256;
/// What the file that comes back is told with.
const WARNING: &str = "More was written into this file after it had been taken, so it was taken once more, whole. What was taken \
     first is an earlier part of the same name: where both are there, cancel that one.";

/// Size and time of the last change.
type Written = (u64, i128);

/// An original that was taken.
#[derive(Debug)]
struct KeptOriginal {
    file: File,
    /// Device and number of the file.
    inode: (u64, u64),
    /// The claim that it was taken by.
    claim: String,
    inbox: PathBuf,
    farm: String,
    /// Its path in the hot folder, without its name.
    order_path: PathBuf,
    name: OsString,
    has_terms: bool,
    /// BLAKE3 of what was taken.
    hash: String,
    seen: Written,
    /// When this was first seen, seconds.
    since_secs: f64,
    /// Whether it differs from what was taken.
    has_changed: bool,
}

/// Originals that were taken a while ago and are kept open.
#[derive(Debug, Default)]
pub struct LateWriting {
    kept: VecDeque<KeptOriginal>,
}

impl LateWriting {
    /// Keeps the original of a claim open, which is in the store as `stored`.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn keep_open(&mut self, claim: &ClaimedPart, stored: &StoredFile, farm: &str, now_secs: f64) -> io::Result<()> {
        let relative = claim.part.strip_prefix(&claim.inbox).unwrap_or(&claim.part);
        let mut file = disk::open_beneath(&claim.inbox, relative)?;
        if !build_file::may_grow(&mut file, &claim.display_name())? {
            return Ok(());
        }
        let meta = file.metadata()?;
        let inode = (meta.dev(), meta.ino());
        // One that was given back is the same file.
        self.kept.retain(|kept| kept.inode != inode);
        self.kept.truncate(MOST_OPEN - 1);
        self.kept.push_front(KeptOriginal {
            file,
            inode,
            claim: claim.id.clone(),
            inbox: claim.inbox.clone(),
            farm: farm.to_owned(),
            order_path: claim.order_path.clone(),
            name: claim.name.clone(),
            has_terms: !claim.tickets.is_empty() || claim.list.is_some(),
            hash: stored.hash.clone(),
            seen: written(&meta),
            since_secs: now_secs,
            has_changed: meta.len() != stored.bytes,
        });
        Ok(())
    }

    /// Gives back the removed originals into which more was written and that have not changed for `settle_secs`; closes those
    /// that have not changed for `keep_secs`.
    ///
    /// # Errors
    /// One cannot be read or given back; it is tried again.
    pub fn give_back_changed(&mut self, now_secs: f64, settle_secs: f64, keep_secs: f64) -> io::Result<()> {
        let mut result = Ok(());
        self.kept.retain_mut(|kept| match kept.look(now_secs, settle_secs) {
            Ok(()) => now_secs - kept.since_secs < keep_secs,
            Err(error) => {
                result = Err(error);
                true
            }
        });
        result
    }
}

impl KeptOriginal {
    fn look(&mut self, now_secs: f64, settle_secs: f64) -> io::Result<()> {
        let meta = self.file.metadata()?;
        if written(&meta) != self.seen {
            (self.seen, self.since_secs, self.has_changed) = (written(&meta), now_secs, true);
        }
        // While it has a name, the claim or the error folder has all of it.
        if !self.has_changed || meta.nlink() > 0 || now_secs - self.since_secs < settle_secs {
            return Ok(());
        }
        self.give_back()?;
        self.has_changed = false;
        Ok(())
    }

    /// Writes what the file holds now into the hot folder, as a claim that is given back.
    fn give_back(&mut self) -> io::Result<()> {
        let mut only_one = lock_claims(&self.inbox);
        let (_, dir) = create_claim_dir(&mut only_one, &self.inbox, &self.farm).map_err(io::Error::other)?;
        let folder = dir.join(&self.order_path);
        disk::create_dirs(&folder)?;
        let copy = folder.join(&self.name);
        self.file.rewind()?;
        let mut to = disk::create_fresh_file(&copy)?;
        io::copy(&mut self.file, &mut to)?;
        to.sync_all()?;
        let hash = disk::hash_file(&copy)?;
        if hash == self.hash {
            return fs::remove_dir_all(&dir);
        }
        let question = "the ticket or list of this file was taken with what it held before".to_owned();
        let lookup = ListLookup {
            warnings: vec![WARNING.to_owned()],
            question: self.has_terms.then_some(question),
            rewrites: Some(self.claim.clone()),
            ..ListLookup::default()
        };
        lookup.save_to(&folder.join(LIST_LOOKUP_NAME))?;
        let back = give_back_files(&self.inbox, &dir)?;
        let back = back.as_deref().unwrap_or(Path::new(&self.name)).display();
        warn!("{back} was written to after it was taken; it is taken again, whole.");
        self.hash = hash;
        Ok(())
    }
}

fn written(meta: &fs::Metadata) -> Written {
    (meta.len(), disk::mtime_ns(meta))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use crate::{ContentStore, release_claim, test_inbox::TestInbox};

    const BODY: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

    /// A binary STL of one triangle.
    fn binary_body() -> Vec<u8> {
        let mut body = vec![b'b'; 80];
        body.extend(1u32.to_le_bytes());
        body.extend([0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat());
        body.extend([0; 2]);
        body
    }

    #[test]
    fn what_is_written_after_the_file_was_removed_comes_back_whole_and_once() {
        for body in [BODY.as_bytes(), &binary_body()] {
            write_late_and_look(body);
        }
    }

    fn write_late_and_look(body: &[u8]) {
        let farm = TestInbox::new();
        let mut writer = fs::File::create(farm.inbox.join("a.stl")).unwrap();
        writer.write_all(body).unwrap();
        let claim = farm.claim();
        let store = ContentStore::open(farm.dir.path().join("store")).unwrap();
        let stored = store.store_claimed(&claim).unwrap();
        let mut late = LateWriting::default();
        late.keep_open(&claim, &stored, "", 0.0).unwrap();
        release_claim(&claim, &stored.hash).unwrap();
        late.give_back_changed(1.0, 5.0, 600.0).unwrap();
        assert!(!farm.inbox.join("a.stl").exists(), "nothing more was written");
        writer.write_all(body).unwrap();
        for now_secs in [2.0, 6.0] {
            late.give_back_changed(now_secs, 5.0, 600.0).unwrap();
            assert!(!farm.inbox.join("a.stl").exists(), "it has not settled after {now_secs} s");
        }
        late.give_back_changed(7.0, 5.0, 600.0).unwrap();
        assert_eq!(fs::read(farm.inbox.join("a.stl")).unwrap(), body.repeat(2));
        fs::remove_file(farm.inbox.join("a.stl")).unwrap();
        late.give_back_changed(20.0, 5.0, 600.0).unwrap();
        assert!(!farm.inbox.join("a.stl").exists(), "it came back already");
        late.give_back_changed(700.0, 5.0, 600.0).unwrap();
        assert!(late.kept.is_empty(), "it is not kept open for ever");
    }
}
