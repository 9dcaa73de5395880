//! The mesh of a part for a picture of it, also of one that was refused or waits for an answer.

use std::{fs, path::Path, sync::Arc};

use anyhow::Result;
use ledger::{Ledger, PartRow, PartState};
use solids::Mesh;

use super::node_content::find_kept_content;
use crate::{
    farm::files::{isolated_read::PartReadRequest, mesh_cache::MeshCache},
    settings::Settings,
};

/// A larger file has no picture: reading it takes longer than somebody looks at a list.
const MAX_PICTURED_BYTES: u64 = 64 << 20;

/// The mesh of a part, mm; `None` = its file is no longer kept on this node, is too large, or holds no mesh that can be read. A file that
/// was refused is read in a separate process.
///
/// # Errors
/// The ledger cannot be read.
pub async fn load_part_mesh(settings: &Arc<Settings>, ledger: &Ledger, part: &PartRow) -> Result<Option<Arc<Mesh>>> {
    let Some(file) = find_kept_content(settings, ledger, &part.file.content_hash).await? else { return Ok(None) };
    let (settings, part) = (settings.clone(), part.clone());
    Ok(tokio::task::spawn_blocking(move || read_mesh(&settings, &part, &file)).await?)
}

fn read_mesh(settings: &Settings, part: &PartRow, file: &Path) -> Option<Arc<Mesh>> {
    if fs::metadata(file).ok()?.len() > MAX_PICTURED_BYTES {
        return None;
    }
    if part.state != PartState::Refused {
        return MeshCache::default().read_mesh(file, part, &settings.limits).ok();
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
