//! A file is judged before an order is taken: what would be refused later is refused at once, with the same reason. What was read for that
//! is handed to the step "read", so that the file of an order is read once.

use std::{
    collections::VecDeque,
    fs,
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use build_file::{LengthUnit, PartFileContents, ReadLimits};
use intake::Ticket;
use ledger::PartRow;
use settings::MachineProfile;

use super::{
    file_fault::{FileTerms, find_file_fault},
    isolated_read::PartReadRequest,
    mending::{allowed_by_ticket, mend_solids},
};
use crate::alerts::failure::PartReadError;

/// A larger file is judged when it is taken: reading it takes longer than a client waits.
const MAX_JUDGED_BYTES: u64 = 64 << 20;
/// Bytes of meshes that wait for the step "read"; the oldest go first, and are read again.
const MAX_KEPT_BYTES: usize = 256 << 20;

/// A file that was read to be judged.
#[derive(Debug)]
pub struct JudgedFile {
    content_hash: String,
    request: PartReadRequest,
    contents: PartFileContents,
}

/// What was read of files whose orders were taken, until the step "read" needs it; shared by all threads.
#[derive(Debug, Clone, Default)]
pub struct JudgedFiles(Arc<Mutex<VecDeque<JudgedFile>>>);

impl JudgedFiles {
    /// Keeps what was read of the files of an order.
    pub fn keep(&self, files: Vec<JudgedFile>) {
        let mut kept = self.lock_files();
        kept.extend(files);
        let mut bytes: usize = kept.iter().map(JudgedFile::bytes).sum();
        while bytes > MAX_KEPT_BYTES {
            bytes -= kept.pop_front().map_or(bytes, |oldest| oldest.bytes());
        }
    }

    /// What was read of the file of a part that was never read, if it was read as it would be now, in `fixed_unit` if it states no unit.
    pub fn take(&self, part: &PartRow, fixed_unit: LengthUnit, limits: &ReadLimits) -> Option<PartFileContents> {
        let mut kept = self.lock_files();
        let is_same = |file: &JudgedFile| {
            let PartReadRequest { file: _, name, unit, fixed_unit: read_in, limits: read_within } = &file.request;
            file.content_hash == part.file.content_hash
                && (name, *unit, *read_in, read_within) == (&part.name, part.terms.unit, fixed_unit, limits)
        };
        let at = kept.iter().position(is_same).filter(|_| part.size_mm().is_none())?;
        kept.remove(at).map(|file| file.contents)
    }

    /// Forgets all of it.
    pub fn clear(&self) {
        self.lock_files().clear();
    }

    fn lock_files(&self) -> MutexGuard<'_, VecDeque<JudgedFile>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl JudgedFile {
    fn bytes(&self) -> usize {
        let meshes = self.contents.solids.iter().map(|solid| &solid.mesh);
        meshes.map(|mesh| size_of_val(mesh.vertices()) + size_of_val(mesh.triangles())).sum()
    }
}

/// What was read of a file, or why it cannot be printed as its ticket asks, in whole sentences: what its reason file would say. It is read
/// in a separate process. `None` = nothing speaks against it so far: it is too large, or cannot be read now.
pub fn judge_file(
    file: &Path,
    (name, content_hash): (&str, &str),
    ticket: &Ticket,
    profile: &MachineProfile,
    limits: &ReadLimits,
) -> Result<Option<JudgedFile>, String> {
    if fs::metadata(file).map_or(0, |found| found.len()) > MAX_JUDGED_BYTES {
        return Ok(None);
    }
    let request = PartReadRequest {
        file: file.to_owned(),
        name: name.to_owned(),
        unit: ticket.unit,
        fixed_unit: profile.intake.unit,
        limits: limits.clone(),
    };
    let contents = match request.read_isolated() {
        Ok(contents) => contents,
        Err(PartReadError::Refused(_, reason)) => return Err(reason),
        Err(PartReadError::TryLater(_)) => return Ok(None),
    };
    let mut as_printed = contents.clone();
    mend_solids(&mut as_printed, allowed_by_ticket(ticket, profile).as_deref());
    match find_file_fault(&as_printed, &FileTerms::of_ticket(ticket, profile), profile, limits) {
        Some((_, reason)) => Err(reason),
        None => Ok(Some(JudgedFile { content_hash: content_hash.to_owned(), request, contents })),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use build_file::PartFileSolid;
    use intake::ContentStore;
    use jiff::Timestamp;
    use ledger::PartId;
    use ledger_fixtures::part_row;
    use sample_parts::fixtures::block;

    use super::*;
    use crate::{
        decisions::trigger::tests::machine_with_triggers,
        files::{
            mesh_source::MeshSource,
            read::{PartReadOutcome, read_part},
        },
    };

    fn judged_block(content_hash: &str, name: &str, fixed_unit: LengthUnit) -> JudgedFile {
        let solid = PartFileSolid {
            name: name.to_owned(),
            mesh: block(10.0, 8.0, 6.0),
            copies: 1,
            warnings: Vec::new(),
            question: None,
            coordinate_step_mm: 0.0,
            request: None,
        };
        let request = PartReadRequest {
            file: "/where/it/came".into(),
            name: name.to_owned(),
            unit: None,
            fixed_unit,
            limits: ReadLimits::default(),
        };
        JudgedFile {
            content_hash: content_hash.to_owned(),
            request,
            contents: PartFileContents { solids: vec![solid], warnings: Vec::new() },
        }
    }

    #[test]
    fn what_was_judged_is_read_once_and_only_as_it_was_judged() {
        let folder = tempfile::tempdir().unwrap();
        let store = ContentStore::open(folder.path().join("store")).unwrap();
        // No reader would take this: a part of it has been read elsewhere.
        let file = folder.path().join("block.stl");
        fs::write(&file, "no mesh at all").unwrap();
        let hash = store.store_file(&file).unwrap().hash;
        let meshes = MeshSource {
            mesh_cache: Default::default(),
            store,
            limits: ReadLimits::default(),
            prepared: Default::default(),
            preparation_cache: None,
            judged: Default::default(),
            unreadable_since: Default::default(),
        };
        let mut part = part_row(PartId(1), 1, Timestamp::UNIX_EPOCH);
        (part.file.content_hash, part.name) = (hash.clone(), "block.stl".to_owned());
        part.measures.read_unit = Some(LengthUnit::Millimeter);
        let profile = Arc::new(machine_with_triggers(""));
        let read = || read_part(&part, None, &profile, &meshes);

        meshes.judged.keep(vec![judged_block(&hash, "block.stl", LengthUnit::Inch)]);
        assert!(matches!(read(), PartReadOutcome::Refused(..)), "it was judged in inches, and is read in mm");
        meshes.judged.clear();
        meshes.judged.keep(vec![judged_block(&hash, "block.stl", LengthUnit::Millimeter)]);
        assert!(matches!(read(), PartReadOutcome::Solids(solids) if solids.len() == 1));
        assert!(matches!(read(), PartReadOutcome::Refused(..)), "another part has been judged itself, or is read");
    }

    #[test]
    fn the_oldest_go_when_too_much_waits() {
        let files = JudgedFiles::default();
        let bytes = judged_block("a", "a.stl", LengthUnit::Millimeter).bytes();
        files.keep(
            (0..MAX_KEPT_BYTES / bytes + 3)
                .map(|at| judged_block(&at.to_string(), "a.stl", LengthUnit::Millimeter))
                .collect(),
        );
        let kept = files.lock_files();
        assert!(kept.iter().map(JudgedFile::bytes).sum::<usize>() <= MAX_KEPT_BYTES);
        assert_eq!(kept.front().map(|file| file.content_hash.as_str()), Some("3"));
    }
}
