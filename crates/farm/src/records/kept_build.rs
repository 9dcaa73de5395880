//! Copies of published build files below `archive/<machine>/builds/`, kept where `archive_builds_days` says so. A build
//! is issued once more from its copy when the originals of its parts are gone. A copy is never a link: a printer may
//! change the file in its queue folder.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
use ledger::{BuildRow, PartRow, PlacementRow};
use settings::MachineProfile;
use tracing::warn;

use crate::files::{mesh_source::MeshSource, read_again::ensure_same_size};

/// Poses in a build file and in the ledger may differ by this much, mm.
const POSE_TOLERANCE_MM: f64 = 1e-3;

/// Where the copy of a build's file is, if there is one.
pub fn kept_path(archive: &Path, file_name: &str) -> PathBuf {
    archive.join(intake::KEPT_BUILDS).join(file_name)
}

/// Copies a staged build file into the archive. A copy from an earlier attempt is replaced. A failure is only logged: a full
/// disk must not keep a build from its printer. `hash` is that of the staged file.
pub fn keep_staged_file(profile: &MachineProfile, staged: &Path, file_name: &str, hash: &str) {
    if profile.output.archive_builds_days.is_none() {
        return;
    }
    let kept = kept_path(&profile.folders.archive, file_name);
    let copied = || -> std::io::Result<()> {
        if kept.exists() && intake::hash_file(&kept)? != hash {
            fs::remove_file(&kept)?;
        }
        intake::archive_file(staged, &profile.folders.archive, intake::KEPT_BUILDS, file_name).map(drop)
    };
    if let Err(error) = copied() {
        warn!(machine = %profile.name, "No copy of {file_name} is kept in the archive: {error}. The build is published without.");
    }
}

/// The copy of a published build's file.
#[derive(Debug, Clone)]
pub struct KeptBuild {
    path: PathBuf,
    hash: String,
}

impl KeptBuild {
    /// Where the copy of the file of this build is, if one was kept. Looks at no disk. `None` = the build has no file.
    pub fn of_build(archive: &Path, build: &BuildRow) -> Option<Self> {
        let (name, hash) = (build.staged.file_name.as_deref()?, build.staged.file_hash.clone()?);
        Some(Self { path: kept_path(archive, name), hash })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its path, if it has the bytes that were proved.
    pub fn proved_path(&self) -> Option<&Path> {
        intake::hash_file(&self.path).is_ok_and(|found| found == self.hash).then_some(&self.path)
    }

    /// Puts the meshes of these parts into memory, for a search that finds no stored file of them. `placements` are those
    /// of the build.
    ///
    /// # Errors
    /// It is not the file that was proved, or it does not show the parts where the ledger says.
    pub fn load_meshes(&self, parts: &[PartRow], placements: &[PlacementRow], meshes: &MeshSource) -> Result<()> {
        let path =
            self.proved_path().with_context(|| format!("{} is not the file that was proved", self.path.display()))?;
        let placed =
            build_file::read_build(path, &meshes.limits).with_context(|| format!("reading {}", path.display()))?;
        let copy_of = |part: &Option<String>, copy: Option<u32>| Some((part.as_deref()?.parse::<i64>().ok()?, copy?));
        let by_copy: HashMap<_, _> =
            placed.iter().filter_map(|placed| Some((copy_of(&placed.part_number, placed.copy)?, placed))).collect();
        for part in parts {
            let row = placements.iter().find(|row| row.part_id == part.id);
            let row = row.with_context(|| format!("part {} has no place in the build", part.id))?;
            let placed = by_copy.get(&(part.id.0, row.copy + 1));
            let placed = placed.with_context(|| format!("part {} is not in {}", part.id, path.display()))?;
            let pose = row.pose().with_context(|| format!("part {} has no pose", part.id))?;
            let (told, found) = (placed.mesh.bounds_at(&pose), placed.mesh.bounds_at(&placed.pose));
            let difference_mm = (told.min - found.min).abs().max((told.max - found.max).abs()).max_element();
            ensure!(difference_mm < POSE_TOLERANCE_MM, "part {} stands elsewhere in {}", part.id, path.display());
            ensure_same_size(part, &placed.mesh)?;
            meshes.insert_mesh(part, (*placed.mesh).clone());
        }
        Ok(())
    }
}
