//! The step "verified": a layout is written as a build file under its dot-name, read back, and proved on the triangles of
//! what was written. Runs on a job's thread.

use std::{collections::HashMap, path::Path, sync::Arc};

use anyhow::{Context, Result};
use build_file::{BuildFile, Limits};
use jiff::Timestamp;
use nester::{Course, Separability};

use super::{layout::Copy, nest_order::Nested};
use crate::{
    build::{self, BuildHeading, ProvedBuild, SolvedBuild},
    ledger::{self, BuildRow, DrawnOut, FinalSearch, ProvedFile, ProvedMeasures, Verified},
    queue::Queue,
    settings::Profile,
};

/// Pixels of the build's picture and thumbnail.
const PICTURE_SIZE: (u32, u32) = (1024, 768);
const THUMBNAIL_SIZE: (u32, u32) = (256, 256);

/// A written and proved build, ready for the ledger.
#[derive(Debug)]
pub struct Written {
    /// What the build's row will say.
    pub verified: Verified,
    /// Where its copies stand, in the machine's frame.
    pub placed: Vec<ledger::PlacedCopy>,
    /// Copies that were tried and found no place.
    pub unplaced: Vec<Copy>,
    /// Who is locked into whom, in one line; "" when nobody is, or when that is allowed.
    pub locked: String,
}

/// A build that was written is not what it should be. Where the disk did not fail, something is wrong with nestd.
#[derive(Debug, thiserror::Error)]
#[error("proving the written build")]
pub struct Unproved;

/// What a build is written with.
#[derive(Debug)]
pub struct WriteOrder {
    /// The machine.
    pub profile: Arc<Profile>,
    /// The printer queue folder.
    pub queue: Queue,
    /// The build's row.
    pub build: BuildRow,
    /// Seed of the search.
    pub seed: u64,
    /// Limits of the reader that reads it back.
    pub limits: Limits,
}

/// The name of a build's file; the same at every attempt, so that a crash leaves at most one dot-file.
pub fn file_name(profile: &str, build: &BuildRow) -> String {
    let created: Timestamp = build.times.nesting_at.unwrap_or(build.times.opened_at).0;
    build_file::build_file_name(created, profile, build.id.0.unsigned_abs())
}

/// Writes, reads back, proves, and writes the sidecars. Nothing is published.
pub fn write_and_prove(order: &WriteOrder, nested: &Nested) -> Result<Written> {
    let name = file_name(&order.profile.name, &order.build);
    let build = solved_build(order, nested);
    let description = build.build_file(THUMBNAIL_SIZE);
    // Of an earlier attempt: what it left visible would be taken for somebody else's.
    order.queue.discard(&name).context("removing what was staged before")?;
    let staged = order.queue.stage(&name, |file| build_file::write_build(&description, file))?;
    let proved = match build.prove(&staged, &order.limits) {
        Ok(proved) => proved,
        Err(error) => {
            order.queue.discard(&name).context("taking back a build that could not be proved")?;
            return Err(anyhow::Error::from(error).context(Unproved));
        }
    };
    let locked = proved.separable.as_ref().map(Separability::locked_text).unwrap_or_default();
    let sidecars = write_sidecars(order, nested, &build, &description, &proved, &name)?;
    let (file_hash, file_bytes) = hash_of(&staged)?;
    let height_mm = build.machine_height_mm();
    Ok(Written {
        verified: Verified {
            file: ProvedFile {
                file_name: name,
                queue_id: order.queue.id().to_owned(),
                file_hash,
                file_bytes,
                sidecars,
            },
            measures: ProvedMeasures {
                height_mm,
                density: nested.layout.density,
                lower_bound_mm: nested.lower_bound_mm,
                layers: (height_mm / order.profile.space.layer_mm).ceil() as u32,
                part_volume_mm3: nested.layout.part_volume_mm3,
                copies: nested.layout.placed.len() as u32,
                clearance_mm: order.profile.space.clearance_mm,
                clearance_proved_mm: proved.proof.clearance_proved_mm,
            },
            search: FinalSearch {
                cpu_secs: nested.cpu_secs,
                wall_secs: nested.wall_secs,
                evaluations: nested.layout.evaluations,
                seed: order.seed,
                method: serde_word(&order.profile.search.nest.method),
                version: env!("CARGO_PKG_VERSION").to_owned(),
                curve: curve(order, nested),
            },
            profile_snapshot: serde_json::to_string(&*order.profile).context("writing down the profile")?,
        },
        placed: placed_in_machine_frame(&build, nested, &proved),
        unplaced: nested.layout.unplaced.clone(),
        locked,
    })
}

/// How the height fell, on the machine's floor.
fn curve(order: &WriteOrder, nested: &Nested) -> Vec<(f64, f64)> {
    nested.curve.iter().map(|(secs, height_mm)| (*secs, height_mm + order.profile.origin_mm().z)).collect()
}

/// Where the copies stand, and how they come out of the cake.
fn placed_in_machine_frame(build: &SolvedBuild, nested: &Nested, proved: &ProvedBuild) -> Vec<ledger::PlacedCopy> {
    let drawn: HashMap<(usize, u32), DrawnOut> = (1..)
        .zip(&proved.drawn)
        .map(|(place, &(part, copy, way))| ((part, copy), DrawnOut { place, way: way.to_array() }))
        .collect();
    (build.placed.iter())
        .map(|placed| {
            let pose = build.machine.machine_pose(&placed.pose);
            ledger::PlacedCopy {
                part: nested.batch.parts[placed.part].part.id,
                copy: placed.copy,
                rotation: pose.rotation.to_array(),
                translation_mm: pose.translation.to_array(),
                drawn: drawn.get(&(placed.part, placed.copy)).copied(),
            }
        })
        .collect()
}

fn solved_build(order: &WriteOrder, nested: &Nested) -> SolvedBuild {
    let heading = BuildHeading {
        title: format!("{} build {}", order.profile.name, order.build.id),
        build_id: order.build.id.to_string(),
        created: order.build.times.nesting_at.unwrap_or(order.build.times.opened_at).0,
        seed: order.seed,
    };
    SolvedBuild {
        heading,
        machine: order.profile.machine(),
        parts: nested.batch.build_parts(),
        placed: nested.batch.part_placements(&nested.layout),
        height_mm: nested.layout.height_mm,
        density: nested.layout.density,
    }
}

/// Report, pick map, picture and, where asked for, the whole build as STL; all under the build's stem. Returns name and BLAKE3
/// of each.
fn write_sidecars(
    order: &WriteOrder,
    nested: &Nested,
    build: &SolvedBuild,
    description: &BuildFile,
    proved: &ProvedBuild,
    name: &str,
) -> Result<Vec<(String, String)>> {
    let stem = name.strip_suffix(".build.3mf").unwrap_or(name);
    let mut written = Vec::new();
    let mut stage = |suffix: &str, bytes: &[u8]| -> Result<()> {
        use std::io::Write;
        let name = format!("{stem}{suffix}");
        order.queue.stage(&name, |file| file.write_all(bytes))?;
        written.push((name, blake3::hash(bytes).to_hex().to_string()));
        Ok(())
    };
    stage(".report.json", &report(order, nested, build, proved)?)?;
    let mut pick_map = Vec::new();
    build_file::write_pick_map(build_file::pick_rows(description), &mut pick_map)?;
    stage(".parts.csv", &pick_map)?;
    stage(".png", &build::picture(description, PICTURE_SIZE))?;
    if order.profile.output.stl_output {
        let placed = description.items.iter().map(|i| (&*description.objects[i.object].mesh, &i.pose));
        let name = format!("{stem}.stl");
        let staged = order.queue.stage(&name, |file| build_file::write_stl(placed, std::io::BufWriter::new(file)))?;
        written.push((name, hash_of(&staged)?.0));
    }
    Ok(written)
}

fn report(order: &WriteOrder, nested: &Nested, build: &SolvedBuild, proved: &ProvedBuild) -> Result<Vec<u8>> {
    let course = Course {
        clearance_proved_mm: proved.proof.clearance_proved_mm,
        separable: proved.separable.clone(),
        seed: order.seed,
        cpu_secs: nested.cpu_secs,
        wall_secs: nested.wall_secs,
        curve: curve(order, nested),
    };
    // Copies without a place go on into the next build.
    let report = build.report(nested.lower_bound_mm, nested.layout.evaluations, &[], course);
    Ok(serde_json::to_vec_pretty(&report)?)
}

fn hash_of(file: &Path) -> Result<(String, u64)> {
    let mut hasher = blake3::Hasher::new();
    let mut reader = std::fs::File::open(file).with_context(|| format!("opening {}", file.display()))?;
    let bytes = std::io::copy(&mut reader, &mut hasher).with_context(|| format!("reading {}", file.display()))?;
    Ok((hasher.finalize().to_hex().to_string(), bytes))
}

/// The word that serde writes for a plain enum.
fn serde_word(value: &impl serde::Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => word,
        _ => String::new(),
    }
}
