//! The mesh of a part for a picture of it, also of one that was refused or waits for an answer.

use std::{fs, path::Path, sync::Arc};

use anyhow::Result;
use glam::DVec3;
use ledger::{Ledger, PartMending, PartRow, PartState};
use settings::Settings;
use solids::Mesh;

use super::node_content::find_kept_content;
use crate::files::{isolated_read::PartReadRequest, mesh_cache::MeshCache};

/// A larger file has no picture: reading it takes longer than somebody looks at a list.
const MAX_PICTURED_BYTES: u64 = 64 << 20;

/// A mesh to be shown.
#[derive(Debug)]
pub struct ShownMesh {
    /// The mesh, mm.
    pub mesh: Arc<Mesh>,
    /// The triangles that were added or turned to mend it.
    pub mended: Vec<[DVec3; 3]>,
}

/// The mesh of a part as it was dropped, or `mended`; `None` = its file is no longer kept on this node, is too large, or holds no mesh that can be read, or mended. A file that
/// was refused is read in a separate process.
///
/// # Errors
/// The ledger cannot be read.
pub async fn load_part_mesh(
    settings: &Arc<Settings>,
    ledger: &Ledger,
    part: &PartRow,
    mended: bool,
) -> Result<Option<ShownMesh>> {
    let Some(file) = find_kept_content(settings, ledger, &part.file.content_hash).await? else { return Ok(None) };
    let (settings, part) = (settings.clone(), part.clone());
    let show = move || {
        let mesh = read_mesh(&settings, &part, &file)?;
        match mended {
            true => mesh.mended().ok().map(|done| ShownMesh { mesh: Arc::new(done.mesh), mended: done.mended }),
            false => Some(ShownMesh { mesh, mended: Vec::new() }),
        }
    };
    Ok(tokio::task::spawn_blocking(show).await?)
}

/// The mesh as it was dropped.
fn read_mesh(settings: &Settings, part: &PartRow, file: &Path) -> Option<Arc<Mesh>> {
    if fs::metadata(file).ok()?.len() > MAX_PICTURED_BYTES {
        return None;
    }
    if part.state != PartState::Refused {
        let as_dropped = PartRow { mending: PartMending::default(), ..part.clone() };
        return MeshCache::default().read_mesh(file, &as_dropped, &settings.limits).ok();
    }
    let of_machine = settings.profiles.get(&part.machine).map(|profile| profile.intake.unit);
    let request = PartReadRequest {
        file: file.to_owned(),
        name: part.name.clone(),
        unit: part.terms.unit,
        fixed_unit: part.measures.read_unit.or(of_machine).unwrap_or_default(),
        limits: settings.limits.clone(),
    };
    let solids = request.read_isolated().ok()?.solids;
    solids.into_iter().nth(part.solid.object_index as usize).map(|solid| solid.mesh)
}
