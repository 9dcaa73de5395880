//! The step "verified": writes a layout as a build file under its dot-name, reads it back, and proves it on the
//! triangles in the file. Runs on a job's thread.

use std::{
    collections::HashMap,
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, Result};
use build_file::{BuildFile, DeliveryKind, ReadLimits};
use delivery::{
    build::{self, BuildHeading, ProvedBuild, SolvedBuild},
    queue::OpenQueue,
};
use jiff::Timestamp;
use ledger::{BuildRow, FinalSearch, ProvedFile, ProvedMeasures, RemovalStep, Verified};
use nester::{SearchSummary, Separability};
use settings::MachineProfile;
use tracing::info;

use super::layout_search::NestingResult;
use crate::decisions::layout::CopyId;

/// Pixels of the build's picture and thumbnail.
const PICTURE_SIZE: (u32, u32) = (1024, 768);
const THUMBNAIL_SIZE: (u32, u32) = (256, 256);

/// A written and proved build, ready for the ledger.
#[derive(Debug)]
pub struct WrittenBuild {
    /// The values for the build's row.
    pub verified: Verified,
    /// The placed copies, in the machine's frame.
    pub placed: Vec<ledger::ProvedPlacement>,
    /// Copies that were tried and found no place.
    pub unplaced: Vec<CopyId>,
    /// Which parts are locked into each other, on one line; "" = none, or it is allowed.
    pub locked: String,
}

/// A written build is not what it should be. Unless the disk failed, this is a fault in nestd.
#[derive(Debug, thiserror::Error)]
#[error("proving the written build")]
pub struct UnprovedBuildError;

/// A request to write a build.
#[derive(Debug)]
pub struct BuildWriteRequest {
    /// The machine.
    pub profile: Arc<MachineProfile>,
    /// The queue of its printer.
    pub queue: OpenQueue,
    /// The build's row.
    pub build: BuildRow,
    /// Seed of the search.
    pub seed: u64,
    /// Limits of the reader that reads it back.
    pub limits: ReadLimits,
}

/// The name of a build's file. Its stem is the same at every attempt, so that a crash leaves at most one dot-file.
pub fn queue_file_name(machine: &str, build: &BuildRow, kind: DeliveryKind) -> String {
    let created: Timestamp = build.times.nesting_at.unwrap_or(build.times.opened_at).0;
    build_file::build_file_name(created, machine, build.id.0.unsigned_abs(), kind)
}

/// The stem of that name, whatever the build is delivered as.
pub fn queue_file_stem(machine: &str, build: &BuildRow) -> String {
    let name = queue_file_name(machine, build, DeliveryKind::default());
    build_file::build_file_stem(&name).unwrap_or(&name).to_owned()
}

/// Writes the build, reads it back, proves it, and writes the sidecars. Publishes nothing.
pub fn write_and_prove(request: &BuildWriteRequest, nested: &NestingResult) -> Result<WrittenBuild> {
    let name = queue_file_name(&request.profile.name, &request.build, request.profile.output.delivery);
    let build = create_solved_build(request, nested);
    let description = build.to_build_file(THUMBNAIL_SIZE);
    // Removes an earlier attempt: its visible sidecars would be taken for files of another build.
    request.queue.discard(&name).context("removing what was staged before")?;
    let staged = request.queue.stage(&name, Box::new(|file| Ok(build_file::write_build(&description, file)?)))?;
    let table = stage_placement_table(request, &description, &name)?;
    let proved =
        match build.prove_written_file(&staged, table.as_ref().map(|table| table.staged.as_path()), &request.limits) {
            Ok(proved) => proved,
            Err(error) => {
                request.queue.discard(&name).context("taking back a build that could not be proved")?;
                return Err(anyhow::Error::from(error).context(UnprovedBuildError));
            }
        };
    let locked = proved.separability.as_ref().map(Separability::locked_text).unwrap_or_default();
    let mut sidecars = write_sidecars(request, nested, &build, &description, &proved, &name)?;
    sidecars.extend(table.map(|table| (table.name, table.hash)));
    let (file_hash, file_bytes) = hash_and_size(&staged)?;
    let height_mm = build.machine_height_mm();
    let (id, bound_mm, ended) = (request.build.id, lower_bound_mm(request, nested), why_ended(request, nested));
    if !ended.is_empty() {
        info!(build.id = %id, "Build {id} is {height_mm:.2} mm high, bound {bound_mm:.2}: {ended}.");
    }
    Ok(WrittenBuild {
        verified: Verified {
            file: ProvedFile {
                file_name: name,
                queue_id: request.queue.id().to_owned(),
                file_hash,
                file_bytes,
                sidecars,
            },
            measures: ProvedMeasures {
                height_mm,
                density: nested.layout.density,
                lower_bound_mm: bound_mm,
                layers: (height_mm / request.profile.space.layer_mm).ceil() as u32,
                part_volume_mm3: nested.layout.part_volume_mm3,
                copies: nested.layout.placed.len() as u32,
                clearance_mm: request.profile.space.clearance_mm,
                clearance_proved_mm: proved.proof.clearance_proved_mm,
            },
            search: FinalSearch {
                cpu_secs: nested.cpu_secs,
                wall_secs: nested.wall_secs,
                evaluations: nested.layout.evaluations,
                seed: request.seed,
                method: serialized_name(&request.profile.search.nest.method),
                version: env!("CARGO_PKG_VERSION").to_owned(),
                curve: height_curve(request, nested),
            },
            profile_snapshot: serde_json::to_string(&*request.profile).context("writing down the profile")?,
        },
        placed: placed_in_machine_frame(&build, nested, &proved),
        unplaced: nested.layout.unplaced.clone(),
        locked,
    })
}

/// The lower bound of the height, above the machine's floor, mm.
fn lower_bound_mm(request: &BuildWriteRequest, nested: &NestingResult) -> f64 {
    nested.lower_bound_mm + request.profile.origin_mm().z
}

/// Why the search has ended; nothing where a build is issued once more without one.
fn why_ended(request: &BuildWriteRequest, nested: &NestingResult) -> String {
    if request.build.search.repeats.is_some() { String::new() } else { nested.end.in_words() }
}

/// The height over time, above the machine's floor.
fn height_curve(request: &BuildWriteRequest, nested: &NestingResult) -> Vec<(f64, f64)> {
    nested.curve.iter().map(|(secs, height_mm)| (*secs, height_mm + request.profile.origin_mm().z)).collect()
}

/// The poses of the copies, and how they are removed from the cake.
fn placed_in_machine_frame(
    build: &SolvedBuild,
    nested: &NestingResult,
    proved: &ProvedBuild,
) -> Vec<ledger::ProvedPlacement> {
    let drawn: HashMap<(usize, u32), RemovalStep> = (1..)
        .zip(&proved.removal_order)
        .map(|(place, &(part, copy, way))| ((part, copy), RemovalStep { position: place, direction: way.to_array() }))
        .collect();
    (build.placed.iter())
        .map(|placed| {
            let pose = build.machine.machine_pose(&placed.pose);
            ledger::ProvedPlacement {
                part: nested.batch.parts[placed.part].part.id,
                copy: placed.copy,
                rotation: pose.rotation.to_array(),
                translation_mm: pose.translation.to_array(),
                removal: drawn.get(&(placed.part, placed.copy)).copied(),
            }
        })
        .collect()
}

fn create_solved_build(request: &BuildWriteRequest, nested: &NestingResult) -> SolvedBuild {
    let material = Some(request.build.material.clone()).filter(|material| !material.is_empty());
    let of = material.as_ref().map(|material| format!(", {material}")).unwrap_or_default();
    let heading = BuildHeading {
        title: format!("{} build {}{of}", request.profile.name, request.build.id),
        build_id: request.build.id.to_string(),
        created: request.build.times.nesting_at.unwrap_or(request.build.times.opened_at).0,
        seed: request.seed,
    };
    let mut parts = nested.batch.build_parts(&request.profile.time_zone);
    parts.iter_mut().for_each(|part| part.words.material.clone_from(&material));
    SolvedBuild {
        heading,
        machine: request.profile.to_machine(),
        parts,
        placed: nested.batch.part_placements(&nested.layout),
        height_mm: nested.layout.height_mm,
        density: nested.layout.density,
    }
}

/// Writes report, pick map, picture and, if configured, the whole build as STL, all with the build's stem. Returns name
/// and BLAKE3 of each.
fn write_sidecars(
    request: &BuildWriteRequest,
    nested: &NestingResult,
    build: &SolvedBuild,
    description: &BuildFile,
    proved: &ProvedBuild,
    name: &str,
) -> Result<Vec<(String, String)>> {
    let stem = build_file::build_file_stem(name).unwrap_or(name);
    let mut written = Vec::new();
    let mut stage = |suffix: &str, bytes: &[u8]| -> Result<()> {
        use std::io::Write;
        let name = format!("{stem}{suffix}");
        request.queue.stage(&name, Box::new(|file| Ok(file.write_all(bytes)?)))?;
        written.push((name, blake3::hash(bytes).to_hex().to_string()));
        Ok(())
    };
    stage(".report.json", &report_json(request, nested, build, proved)?)?;
    let mut pick_map = Vec::new();
    build_file::write_pick_map(build_file::pick_rows(description), &mut pick_map)?;
    stage(".parts.csv", &pick_map)?;
    stage(".png", &build::render_picture(description, PICTURE_SIZE))?;
    if request.profile.output.stl_output && request.profile.output.delivery != DeliveryKind::Stl {
        let placed = description.items.iter().map(|i| (&*description.objects[i.object].mesh, &i.pose));
        let name = format!("{stem}.stl");
        let write = |file: &mut File| Ok(build_file::write_stl(placed, BufWriter::new(file))?);
        let staged = request.queue.stage(&name, Box::new(write))?;
        written.push((name, hash_and_size(&staged)?.0));
    }
    Ok(written)
}

/// The table of places beside a whole build as STL, which is proved and kept with it.
struct StagedTable {
    name: String,
    hash: String,
    staged: PathBuf,
}

fn stage_placement_table(
    request: &BuildWriteRequest,
    description: &BuildFile,
    build_name: &str,
) -> Result<Option<StagedTable>> {
    if description.delivery != DeliveryKind::Stl {
        return Ok(None);
    }
    let name = build_file::placement_table_name(build_file::build_file_stem(build_name).unwrap_or(build_name));
    let write = |file: &mut File| Ok(build_file::write_placement_table(description, BufWriter::new(file))?);
    let staged = request.queue.stage(&name, Box::new(write))?;
    Ok(Some(StagedTable { hash: hash_and_size(&staged)?.0, name, staged }))
}

fn report_json(
    request: &BuildWriteRequest,
    nested: &NestingResult,
    build: &SolvedBuild,
    proved: &ProvedBuild,
) -> Result<Vec<u8>> {
    let course = SearchSummary {
        clearance_proved_mm: proved.proof.clearance_proved_mm,
        separable: proved.separability.clone(),
        seed: request.seed,
        // Of all searches, also those that were stopped before.
        cpu_secs: request.build.search.cpu_secs.unwrap_or(0.0) + nested.cpu_secs,
        wall_secs: request.build.search.wall_secs.unwrap_or(0.0) + nested.wall_secs,
        curve: height_curve(request, nested),
        ended: why_ended(request, nested),
        ..SearchSummary::default()
    };
    // Copies without a place go into the next build.
    let report = build.to_report(lower_bound_mm(request, nested), nested.layout.evaluations, &[], course);
    Ok(serde_json::to_vec_pretty(&report)?)
}

fn hash_and_size(file: &Path) -> Result<(String, u64)> {
    let mut hasher = blake3::Hasher::new();
    let mut reader = std::fs::File::open(file).with_context(|| format!("opening {}", file.display()))?;
    let bytes = std::io::copy(&mut reader, &mut hasher).with_context(|| format!("reading {}", file.display()))?;
    Ok((hasher.finalize().to_hex().to_string(), bytes))
}

/// The name that serde writes for a unit variant.
fn serialized_name(value: &impl serde::Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => word,
        _ => String::new(),
    }
}
