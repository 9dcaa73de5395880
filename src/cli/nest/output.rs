//! Writes the build, reads it back and proves it before it gets its name; then report and STL.

use std::{collections::BTreeSet, io::BufWriter, path::Path};

use anyhow::{Context, Result, bail, ensure};
use jiff::Timestamp;

use super::{
    super::{draft::Draft, table::tell},
    args::Args,
    machine::Machine,
    parts::Part,
};
use crate::{
    format::{self, BuildFile, BuildItem, BuildObject, Drawn, Viewpoint},
    geometry::{Mesh, Pose},
    nest::{self, Body, Course, Instance, LayerAreas, Placement, Proof, Report, Separability, Solution},
};

/// Edge lengths of the thumbnail, pixels.
const THUMBNAIL: (u32, u32) = (512, 384);

/// Writes everything that was asked for. Nothing is written under the build's name that is not proved.
pub fn write(
    args: &Args,
    machine: &Machine,
    parts: &[Part],
    instance: &Instance,
    solution: &Solution,
    mut course: Course,
) -> Result<Report> {
    let mut moved = solution.clone();
    moved.placements.iter_mut().for_each(|p| p.pose.translation += machine.origin_mm());
    if !moved.placements.is_empty() {
        moved.height_mm += machine.origin_mm().z;
        let build = describe(machine, parts, instance, solution, &moved);
        let draft = Draft::fill(&args.output, |file| Ok(format::write_build(&build, file)?))?;
        let (proof, separable) = prove(&draft.hidden, machine, parts, &moved.placements)?;
        course.clearance_proved_mm = proof.clearance_proved_mm;
        course.separable = separable;
        draft.publish()?;
    } else {
        tell(&format!("no copy could be placed; {} is not written", args.output.display()));
    }
    let standing: Vec<(&Mesh, Pose)> = solution.placements.iter().map(|p| (&*parts[p.item].mesh, p.pose)).collect();
    let mut report = Report::new(instance, &moved, course).measured(&standing, machine.layer_cap());
    report.density = solution.density(instance);
    if let Some(target) = &args.stl {
        let placed = moved.placements.iter().map(|p| (&*parts[p.item].mesh, &p.pose));
        Draft::fill(target, |file| Ok(format::write_stl(placed, BufWriter::new(file))?))?.publish()?;
    }
    if let Some(target) = &args.report {
        Draft::fill(target, |file| Ok(serde_json::to_writer_pretty(BufWriter::new(file), &report)?))?.publish()?;
    }
    Ok(report)
}

/// The solution as a build file says it; `moved` is the same in the machine's frame.
fn describe(
    machine: &Machine,
    parts: &[Part],
    instance: &Instance,
    solution: &Solution,
    moved: &Solution,
) -> BuildFile {
    let used: BTreeSet<usize> = moved.placements.iter().map(|p| p.item).collect();
    let used: Vec<usize> = used.into_iter().collect();
    let rule = serde_json::to_value(machine.orientation.rule).ok().and_then(|v| v.as_str().map(str::to_owned));
    let object = |&at: &usize| BuildObject {
        name: parts[at].name.clone(),
        mesh: parts[at].mesh.clone(),
        part_number: (at + 1).to_string(),
        content_hash: format!("{}-{at}", parts[at].source_hash),
    };
    let item = |placement: &Placement| BuildItem {
        object: used.partition_point(|&at| at < placement.item),
        pose: placement.pose,
        order: None,
        copy: placement.copy + 1,
        source_name: parts[placement.item].source_name.clone(),
        source_hash: parts[placement.item].source_hash.clone(),
        clearance_mm: None,
        orientation: rule.clone(),
        tilts: (!machine.orientation.tilts.is_empty()).then(|| nest::write_tilts(&machine.orientation.tilts)),
    };
    let drawn = |p: &Placement| Drawn { mesh: &parts[p.item].mesh, pose: p.pose, kind: p.item };
    let bodies: Vec<Drawn> = moved.placements.iter().map(drawn).collect();
    BuildFile {
        title: format!("nestd nest, {}", format::counted(moved.placements.len(), "part", "parts")),
        profile: machine.name.clone(),
        build_id: "0".to_owned(),
        created: Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string(),
        seed: machine.config.seed,
        volume_mm: machine.volume_mm,
        keep_out: machine.keep_out.clone(),
        margins_mm: machine.margins.as_dvec3(),
        clearance_mm: machine.clearance_mm,
        clearance_z_extra_mm: machine.clearance_z_extra_mm,
        layer_mm: machine.layer_mm,
        layer_area_cap_mm2: machine.layer_cap().capped_mm2(),
        height_mm: moved.height_mm,
        density: solution.density(instance),
        interlock: machine.config.interlock().word().to_owned(),
        application: format!("nestd {}", env!("CARGO_PKG_VERSION")),
        objects: used.iter().map(object).collect(),
        items: moved.placements.iter().map(item).collect(),
        instances: machine.instances,
        arrangement: machine.arrangement,
        thumbnail_png: Some(format::picture(&bodies, machine.volume_mm, Viewpoint::Iso, THUMBNAIL)),
    }
}

/// Reads the written file back and proves it: every copy once, walls, clearance, containment, orientation, and that it comes
/// apart.
fn prove(
    written: &Path,
    machine: &Machine,
    parts: &[Part],
    placed: &[Placement],
) -> Result<(Proof, Option<Separability>)> {
    let read = format::read_build(written, &machine.limits).context("reading the written build back")?;
    let asked: BTreeSet<(usize, u32)> = placed.iter().map(|p| (p.item, p.copy)).collect();
    let mut found = BTreeSet::new();
    let mut bodies = Vec::with_capacity(read.len());
    let mut keys = Vec::with_capacity(read.len());
    for item in read {
        let number = item.part_number.as_deref().and_then(|n| n.parse::<usize>().ok()).unwrap_or(0);
        let copy = item.copy.unwrap_or(0);
        let key = (number.wrapping_sub(1), copy.wrapping_sub(1));
        ensure!(asked.contains(&key), "the written build holds copy {copy} of {}, which was not placed", item.name);
        ensure!(found.insert(key), "the written build holds copy {copy} of {} twice", item.name);
        let mesh = &parts[key.0].mesh;
        let same = item.mesh.triangles().len() == mesh.triangles().len()
            && (item.mesh.volume_mm3() - mesh.volume_mm3()).abs() <= 1e-6 * (1.0 + mesh.volume_mm3());
        ensure!(same, "{} came back from the written build with another mesh", item.name);
        let pose = Pose { translation: item.pose.translation - machine.origin_mm(), ..item.pose };
        ensure!(nest::rotation_obeys(&machine.orientation, &pose), "{} is turned against its rule", item.name);
        keys.push(key);
        bodies.push(Body { name: item.name, mesh: item.mesh, pose, clearance_mm: machine.clearance_mm });
    }
    ensure!(found == asked, "the written build lacks {} placements", asked.len() - found.len());
    let (room, extra_mm) = (machine.room().size_mm, machine.clearance_z_extra_mm);
    let proof = nest::prove_with(&bodies, room, extra_mm, &machine.keep_out_in_room());
    if !proof.is_proved() {
        let name = |at: usize| &bodies[at].name;
        let close = proof.too_close.first().map(|p| {
            format!(
                "{} and {} are {:.6} mm apart instead of {}",
                name(p.first),
                name(p.second),
                p.distance_mm,
                p.wanted_mm
            )
        });
        let outside = proof.outside.first().map(|&(at, by)| format!("{} stands out by {by:.6} mm", name(at)));
        let inside = proof.inside.first().map(|&(outer, inner)| format!("{} is inside {}", name(inner), name(outer)));
        let intruding = proof.intruding.first().map(|&(at, _)| format!("{} stands in a keep-out box", name(at)));
        let fault = close.or(outside).or(inside).or(intruding).unwrap_or_default();
        bail!("the written build is not proved and was taken back: {fault}");
    }
    let areas = LayerAreas::of(bodies.iter().map(|b| (&*b.mesh, b.pose)), machine.layer_cap());
    ensure!(areas.keeps_cap(), "the written build was taken back: {}", areas.in_words());
    let name = |at: usize| (parts[keys[at].0].name.clone(), keys[at].1);
    let rule = machine.config.interlock();
    let separable = Separability::look(rule, &bodies, machine.clearance_mm, name);
    if let Some(found) = separable.as_ref().filter(|found| !found.locked.is_empty()) {
        ensure!(found.obeys(rule), "the written build was taken back: {}", found.in_words());
        tell(&found.in_words());
    }
    Ok((proof, separable))
}
