//! The step "verified": a layout is written as a build file under its dot-name, read back, and proved on the triangles of
//! what was written. Runs on a job's thread.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::Arc,
};

use anyhow::{Context, Result, bail, ensure};
use glam::DVec3;
use jiff::Timestamp;

use super::{
    layout::{Batch, Copy, PlacedCopy},
    nest::Nested,
};
use crate::{
    format::{self, BuildFile, BuildItem, BuildObject, Drawn, Limits, PlacedMesh, Viewpoint},
    geometry::{Mesh, Pose},
    ledger::{self, BuildRow, DrawnOut, Verified},
    nest::{self, Body, LayerAreas, Proof, Separability},
    queue::Queue,
    settings::{KeepOut, Profile},
};

/// Pixels of the build's picture and thumbnail.
const PICTURE_SIZE: (u32, u32) = (1024, 768);
const THUMBNAIL_SIZE: (u32, u32) = (256, 256);
/// A mesh read back may differ from the one that was nested by this share of its volume: rounding of decimal digits.
const SAME_VOLUME: f64 = 1e-9;

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
    let created: Timestamp = build.nesting_at.unwrap_or(build.opened_at).0;
    format::build_file_name(created, profile, build.id.0.unsigned_abs())
}

/// Writes, reads back, proves, and writes the sidecars. Nothing is published.
pub fn write_and_prove(order: &WriteOrder, nested: &Nested) -> Result<Written> {
    let name = file_name(&order.profile.name, &order.build);
    let description = describe(order, nested);
    // Of an earlier attempt: what it left visible would be taken for somebody else's.
    order.queue.discard(&name).context("removing what was staged before")?;
    let staged = order.queue.stage(&name, |file| format::write_build(&description, file))?;
    let proved = match prove_written(&staged, order, &nested.batch, &nested.layout.placed) {
        Ok(proved) => proved,
        Err(error) => {
            order.queue.discard(&name).context("taking back a build that could not be proved")?;
            return Err(error.context(Unproved));
        }
    };
    let locked = proved.separable.as_ref().map(Separability::locked_text).unwrap_or_default();
    let sidecars = write_sidecars(order, nested, &description, &proved, &name)?;
    let (file_hash, file_bytes) = hash_of(&staged)?;
    let height_mm = nested.layout.height_mm + order.profile.origin_mm().z;
    Ok(Written {
        verified: Verified {
            file_name: name,
            queue_id: order.queue.id().to_owned(),
            file_hash,
            file_bytes,
            sidecars,
            height_mm,
            density: nested.layout.density,
            lower_bound_mm: nested.lower_bound_mm,
            layers: (height_mm / order.profile.layer_mm).ceil() as u32,
            part_volume_mm3: nested.layout.part_volume_mm3,
            copies: nested.layout.placed.len() as u32,
            clearance_mm: order.profile.clearance_mm,
            clearance_proved_mm: proved.proof.clearance_proved_mm,
            cpu_secs: nested.cpu_secs,
            wall_secs: nested.wall_secs,
            evaluations: nested.layout.evaluations,
            seed: order.seed,
            method: serde_word(&order.profile.nest.method),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            profile_snapshot: serde_json::to_string(&*order.profile).context("writing down the profile")?,
            curve: curve(order, nested),
        },
        placed: (nested.layout.placed.iter())
            .map(|p| in_machine_frame(&order.profile, p, proved.drawn.get(&p.copy).copied()))
            .collect(),
        unplaced: nested.layout.unplaced.clone(),
        locked,
    })
}

fn machine_pose(profile: &Profile, pose: &Pose) -> Pose {
    Pose { rotation: pose.rotation, translation: pose.translation + profile.origin_mm() }
}

/// How the height fell, on the machine's floor.
fn curve(order: &WriteOrder, nested: &Nested) -> Vec<(f64, f64)> {
    nested.curve.iter().map(|(secs, height_mm)| (*secs, height_mm + order.profile.origin_mm().z)).collect()
}

fn in_machine_frame(profile: &Profile, placed: &PlacedCopy, drawn: Option<DrawnOut>) -> ledger::PlacedCopy {
    let pose = machine_pose(profile, &placed.pose);
    ledger::PlacedCopy {
        part: placed.copy.0,
        copy: placed.copy.1,
        rotation: pose.rotation.to_array(),
        translation_mm: pose.translation.to_array(),
        drawn,
    }
}

/// The layout as a build file says it: one object per part, one item per copy.
fn describe(order: &WriteOrder, nested: &Nested) -> BuildFile {
    let (profile, batch) = (&order.profile, &nested.batch);
    let used: Vec<usize> = (0..batch.parts.len())
        .filter(|&i| nested.layout.placed.iter().any(|p| p.copy.0 == batch.parts[i].part.id))
        .collect();
    let object = |&i: &usize| {
        let part = &batch.parts[i].part;
        BuildObject {
            name: if part.object_name.is_empty() { part.name.clone() } else { part.object_name.clone() },
            mesh: batch.parts[i].mesh.clone(),
            part_number: part.id.to_string(),
            content_hash: format!("{}-{}", part.content_hash, part.object_index),
        }
    };
    let item = |placed: &PlacedCopy| {
        let at = used.iter().position(|&i| batch.parts[i].part.id == placed.copy.0)?;
        let part = &batch.parts[used[at]].part;
        Some(BuildItem {
            object: at,
            pose: machine_pose(profile, &placed.pose),
            order: (!part.order_name.is_empty()).then(|| part.order_name.clone()),
            copy: placed.copy.1 + 1,
            source_name: part.name.clone(),
            source_hash: part.content_hash.clone(),
            clearance_mm: part.clearance_mm,
            orientation: Some(serde_word(&part.orientation)),
            tilts: (!part.tilts.0.is_empty()).then(|| part.tilts.to_string()),
        })
    };
    let created = order.build.nesting_at.unwrap_or(order.build.opened_at);
    let mut description = BuildFile {
        title: format!("{} build {}", profile.name, order.build.id),
        profile: profile.name.clone(),
        build_id: order.build.id.to_string(),
        created: created.0.strftime("%Y-%m-%dT%H:%M:%SZ").to_string(),
        seed: order.seed,
        volume_mm: profile.volume_mm,
        keep_out: profile.keep_out.iter().map(KeepOut::bounds).collect(),
        margins_mm: profile.margins().as_dvec3(),
        clearance_mm: profile.clearance_mm,
        clearance_z_extra_mm: profile.clearance_z_extra_mm,
        layer_mm: profile.layer_mm,
        layer_area_cap_mm2: profile.layer_cap().capped_mm2(),
        height_mm: nested.layout.height_mm + profile.origin_mm().z,
        density: nested.layout.density,
        interlock: profile.nest.interlock().word().to_owned(),
        application: format!("nestd {}", env!("CARGO_PKG_VERSION")),
        objects: used.iter().map(object).collect(),
        items: nested.layout.placed.iter().filter_map(item).collect(),
        instances: profile.instances,
        arrangement: profile.arrangement,
        thumbnail_png: None,
    };
    description.thumbnail_png = Some(picture(&description, THUMBNAIL_SIZE));
    description
}

fn picture(build: &BuildFile, size: (u32, u32)) -> Vec<u8> {
    let drawn = |i: &BuildItem| Drawn { mesh: &build.objects[i.object].mesh, pose: i.pose, kind: i.object };
    let bodies: Vec<Drawn> = build.items.iter().map(drawn).collect();
    format::picture(&bodies, build.volume_mm, Viewpoint::Iso, size)
}

/// What was found out about a written file.
struct Proved {
    proof: Proof,
    /// `None` where locked parts are allowed and nobody looked.
    separable: Option<Separability>,
    /// How its copies come out of the cake, as far as they do.
    drawn: BTreeMap<Copy, DrawnOut>,
}

/// Reads the written file back and proves it: walls, clearance, containment, orientation, every copy exactly once, and that
/// it comes apart.
fn prove_written(staged: &Path, order: &WriteOrder, batch: &Batch, placed: &[PlacedCopy]) -> Result<Proved> {
    let read = format::read_build(staged, &order.limits).context("reading the written build back")?;
    ensure!(
        read.len() == placed.len(),
        "the written build holds {} placements instead of {}",
        read.len(),
        placed.len()
    );
    let mut seen: BTreeSet<Copy> = BTreeSet::new();
    let mut copies: Vec<Copy> = Vec::with_capacity(read.len());
    let mut bodies = Vec::with_capacity(read.len());
    for item in &read {
        let (copy, body) = body_of(item, order, batch)?;
        ensure!(seen.insert(copy), "copy {} of part {} is in the written build twice", copy.1, copy.0);
        copies.push(copy);
        bodies.push(body);
    }
    let asked: BTreeSet<Copy> = placed.iter().map(|p| p.copy).collect();
    ensure!(seen == asked, "the written build holds other copies than were placed");
    format::cross_check(staged, &read, &order.limits).context("comparing with a second reader")?;
    let (profile, room) = (&order.profile, order.profile.build_volume().size_mm);
    let proof = nest::prove_with(&bodies, room, profile.clearance_z_extra_mm, &profile.keep_out());
    if !proof.is_proved() {
        bail!("the written build is not proved: {}", faults_of(&proof, &bodies));
    }
    let cap = order.profile.layer_cap();
    if cap.capped_mm2().is_some() {
        let areas = LayerAreas::of(bodies.iter().map(|b| (&*b.mesh, b.pose)), cap);
        ensure!(areas.keeps_cap(), "the written build fills a layer beyond its cap: {}", areas.in_words());
    }
    let name = |at: usize| {
        let source = read[at].source_name.clone().unwrap_or_else(|| read[at].name.clone());
        (source, read[at].copy.unwrap_or(1) - 1)
    };
    let rule = profile.nest.interlock();
    let apart = Separability::apart(rule, &bodies);
    let separable = apart.as_ref().map(|apart| Separability::new(apart, profile.clearance_mm, name));
    if let Some(found) = separable.as_ref().filter(|found| !found.obeys(rule)) {
        bail!("the written build is not proved: {}", found.in_words());
    }
    let order = apart.iter().flat_map(|apart| &apart.order);
    let drawn =
        (1..).zip(order).map(|(place, (at, way))| (copies[*at], DrawnOut { place, way: way.to_array() })).collect();
    Ok(Proved { proof, separable, drawn })
}

/// The read-back item as the judge wants it, in the build volume's frame, compared with the part that it should be.
fn body_of(item: &PlacedMesh, order: &WriteOrder, batch: &Batch) -> Result<(Copy, Body)> {
    let number = item.part_number.as_deref().unwrap_or_default();
    let part = (batch.parts.iter().find(|p| p.part.id.to_string() == number))
        .with_context(|| format!("the written build holds {} (part {number}), which was not asked for", item.name))?;
    let copy = item.copy.and_then(|c| c.checked_sub(1)).context("a written placement has no copy number")?;
    ensure!(
        same_mesh(&item.mesh, &part.mesh),
        "part {number} ({}) came back from the written build with another mesh",
        part.part.name
    );
    let pose = Pose { rotation: item.pose.rotation, translation: item.pose.translation - order.profile.origin_mm() };
    ensure!(
        nest::rotation_obeys(&part.part.turning(), &pose),
        "part {number} ({}) is turned against its orientation rule",
        part.part.name
    );
    let clearance_mm = part.part.clearance_mm.unwrap_or(0.0).max(order.profile.clearance_mm);
    Ok(((part.part.id, copy), Body { name: part.part.name.clone(), mesh: item.mesh.clone(), pose, clearance_mm }))
}

fn same_mesh(read: &Mesh, nested: &Mesh) -> bool {
    let close = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= 1e-9 * (1.0 + b.abs().max_element());
    read.triangles().len() == nested.triangles().len()
        && (read.volume_mm3() - nested.volume_mm3()).abs() <= SAME_VOLUME * (1.0 + nested.volume_mm3())
        && close(read.bounds().min, nested.bounds().min)
        && close(read.bounds().max, nested.bounds().max)
}

/// What is wrong with a layout, in one line.
pub fn faults_of(proof: &Proof, bodies: &[Body]) -> String {
    let name = |i: usize| bodies[i].name.as_str();
    let close = (proof.too_close.iter()).map(|p| {
        format!(
            "{} and {} are {:.4} mm apart instead of {} mm",
            name(p.first),
            name(p.second),
            p.distance_mm,
            p.wanted_mm
        )
    });
    let outside =
        proof.outside.iter().map(|&(i, excess)| format!("{} stands {excess:.4} mm out of the volume", name(i)));
    let inside = proof.inside.iter().map(|&(outer, inner)| format!("{} lies inside {}", name(inner), name(outer)));
    let intruding = proof.intruding.iter().map(|&(i, zone)| format!("{} stands in keep-out box {}", name(i), zone + 1));
    close.chain(outside).chain(inside).chain(intruding).take(5).collect::<Vec<_>>().join("; ")
}

/// Report, pick map, picture and, where asked for, the whole build as STL; all under the build's stem. Returns name and BLAKE3
/// of each.
fn write_sidecars(
    order: &WriteOrder,
    nested: &Nested,
    build: &BuildFile,
    proved: &Proved,
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
    format::write_pick_map(format::pick_rows(build), &mut pick_map)?;
    stage(".parts.csv", &pick_map)?;
    stage(".png", &picture(build, PICTURE_SIZE))?;
    if order.profile.stl_output {
        let placed = build.items.iter().map(|i| (&*build.objects[i.object].mesh, &i.pose));
        let name = format!("{stem}.stl");
        let staged = order.queue.stage(&name, |file| format::write_stl(placed, std::io::BufWriter::new(file)))?;
        written.push((name, hash_of(&staged)?.0));
    }
    Ok(written)
}

fn report(order: &WriteOrder, nested: &Nested, build: &BuildFile, proved: &Proved) -> Result<Vec<u8>> {
    let report = nest::Report {
        height_mm: build.height_mm,
        density: build.density,
        lower_bound_mm: nested.lower_bound_mm,
        clearance_mm: build.clearance_mm,
        clearance_z_extra_mm: build.clearance_z_extra_mm,
        packed_density: 0.0,
        mean_distance_mm: 0.0,
        layers: LayerAreas::default(),
        clearance_proved_mm: proved.proof.clearance_proved_mm,
        separable: proved.separable.clone(),
        placed: build.items.len(),
        unplaced: Vec::new(),
        seed: order.seed,
        evaluations: nested.layout.evaluations,
        cpu_secs: nested.cpu_secs,
        wall_secs: nested.wall_secs,
        curve: curve(order, nested),
        placements: (build.items.iter())
            .map(|i| nest::PlacedPart { part: i.source_name.clone(), copy: i.copy - 1, pose: i.pose.rows() })
            .collect(),
    };
    let in_room = |pose: &Pose| Pose { translation: pose.translation - order.profile.origin_mm(), ..*pose };
    let placed: Vec<(&Mesh, Pose)> =
        build.items.iter().map(|i| (&*build.objects[i.object].mesh, in_room(&i.pose))).collect();
    Ok(serde_json::to_vec_pretty(&report.measured(&placed, order.profile.layer_cap()))?)
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
