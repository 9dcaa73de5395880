//! Writes a layout as a 3MF. The file gets its name only after it was read back and proved.

use std::{collections::BTreeSet, fs, io, path::Path};

use build_file::{
    Arrangement, BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, DeliveryKind, OrderWords,
    PictureBody, PlacedMesh, ReadLimits, Viewpoint, cross_check, draw_picture, read_build, write_build,
};
use glam::DVec3;
use nester::{ItemPlacement, PlacedSolid, prove_placed_solids};
use pyo3::prelude::*;
use tempfile::NamedTempFile;

use crate::{
    errors::{InputError, ProofError, os_error, with_causes, write_error},
    found_layout::FoundLayout,
    layout_proof::{faults_of, refuse_faults},
};

/// Edge lengths of the picture in the file, pixels.
const THUMBNAIL: (u32, u32) = (512, 384);
/// Allowed difference between the height of the layout and that of the written file, mm.
const HEIGHT_TOLERANCE_MM: f64 = 1e-6;

/// Draws a layout; `size` is in pixels. Returns a PNG.
pub(crate) fn draw_layout(found: &FoundLayout, view: Viewpoint, size: (u32, u32)) -> Vec<u8> {
    let items = found.instance.items();
    let body = |p: &ItemPlacement| PictureBody { mesh: &items[p.item].mesh, pose: p.pose, kind: p.item };
    let bodies: Vec<PictureBody> = found.solution.placements.iter().map(body).collect();
    draw_picture(&bodies, found.instance.volume().size_mm, view, size)
}

/// What a 3MF says of itself, and how it is written.
pub(crate) struct FileWords {
    /// Shown by viewers.
    pub(crate) title: String,
    /// Time of creation, RFC 3339.
    pub(crate) created: String,
    /// Whether the copies of a part share one object.
    pub(crate) is_shared: bool,
}

/// Writes a layout next to `path`, proves what was written, and renames it.
///
/// # Errors
/// Nothing is placed, the disk has failed, or the written file is not proved: then `path` is as it was.
pub(crate) fn write_proved(found: &FoundLayout, path: &Path, words: FileWords) -> PyResult<()> {
    if found.solution.placements.is_empty() {
        return Err(InputError::new_err("nothing is placed, so that there is nothing to write."));
    }
    let draft = new_draft(path).map_err(|error| os_error(&error, path))?;
    let build = to_build_file(found, words);
    write_build(&build, draft.as_file()).map_err(|error| write_error(&error, path))?;
    prove_written(found, draft.path())?;
    draft.as_file().sync_all().map_err(|error| os_error(&error, path))?;
    draft.persist(path).map_err(|error| os_error(&error.error, path))?;
    Ok(())
}

/// An empty file in the folder of `path`, with the rights that any new file gets.
fn new_draft(path: &Path) -> io::Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::metadata(folder)?; // its error has a number, that of `tempfile` has none
    let mut builder = tempfile::Builder::new();
    builder.prefix(".nestd-").suffix(".3mf");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

fn to_build_file(found: &FoundLayout, words: FileWords) -> BuildFile {
    let (instance, config, solution) = (&found.instance, &found.config, &found.solution);
    // Items without a placed copy are left out of the file.
    let used: BTreeSet<usize> = solution.placements.iter().map(|placed| placed.item).collect();
    let used: Vec<usize> = used.into_iter().collect();
    let object = |&at: &usize| BuildFileObject {
        name: instance.items()[at].name.clone(),
        mesh: instance.items()[at].mesh.clone(),
        part_number: (at + 1).to_string(),
        content_hash: format!("{}-{at}", found.sources[at].hash),
    };
    let item = |placed: &ItemPlacement| BuildFileItem {
        object: used.partition_point(|&at| at < placed.item),
        pose: placed.pose,
        words: OrderWords::default(),
        copy: placed.copy + 1,
        source_name: found.sources[placed.item].file_name.clone(),
        source_hash: found.sources[placed.item].hash.clone(),
        clearance_mm: instance.items()[placed.item].clearance_mm,
        orientation: Some(found.sources[placed.item].orientation.clone()),
        tilts: None,
    };
    BuildFile {
        heading: BuildFileHeading {
            title: words.title,
            application: format!("nestd-nester {}", env!("CARGO_PKG_VERSION")),
            created: words.created,
            machine: "none".to_owned(),
            build_id: "0".to_owned(),
            seed: config.seed,
        },
        rules: BuildFileRules {
            volume_mm: instance.volume().size_mm,
            keep_out: instance.keep_out(),
            margins_mm: DVec3::ZERO,
            clearance_mm: instance.clearance_mm(),
            clearance_z_extra_mm: instance.clearance_z_extra_mm(),
            layer_mm: instance.layer_cap().layer_mm,
            layer_area_cap_mm2: None,
            interlock: config.effective_interlock().as_str().to_owned(),
        },
        height_mm: solution.height_mm,
        density: solution.density(instance),
        objects: used.iter().map(object).collect(),
        items: solution.placements.iter().map(item).collect(),
        delivery: if words.is_shared { DeliveryKind::Shared } else { DeliveryKind::Expanded },
        arrangement: Arrangement::Items,
        thumbnail_png: Some(draw_layout(found, Viewpoint::Iso, THUMBNAIL)),
    }
}

/// Reads a written file with two readers, and proves it on its triangles.
fn prove_written(found: &FoundLayout, written: &Path) -> PyResult<()> {
    let limits = ReadLimits::default();
    let unread = |error| ProofError::new_err(format!("the written file cannot be read back: {}", with_causes(&error)));
    let read = read_build(written, &limits).map_err(unread)?;
    cross_check(written, &read, &limits).map_err(unread)?;
    let (placed, clearance_mm) = (found.solution.placements.len(), found.instance.clearance_mm());
    let to_body = |item: PlacedMesh| PlacedSolid {
        name: format!("{} #{}", item.name, item.copy.unwrap_or_default()),
        mesh: item.mesh,
        pose: item.pose,
        clearance_mm: clearance_mm.max(item.clearance_mm.unwrap_or(0.0)),
    };
    let bodies: Vec<PlacedSolid> = read.into_iter().map(to_body).collect();
    let proof = prove_placed_solids(&bodies, found.instance.volume().size_mm);
    let mut faults = faults_of(&proof, &bodies);
    if bodies.len() != placed {
        faults.push(format!("it has {} copies instead of {placed}", bodies.len()));
    }
    if (proof.height_mm - found.solution.height_mm).abs() > HEIGHT_TOLERANCE_MM {
        faults.push(format!("it is {} mm high instead of {} mm", proof.height_mm, found.solution.height_mm));
    }
    refuse_faults("the written file", &faults)
}
