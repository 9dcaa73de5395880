//! Writes the build and has it proved before it gets its name; then report and STL.

use std::{fs::File, io::BufWriter, path::Path};

use anyhow::{Context, Result};
use build_file::{BuildFile, Limits, WriteError};
use jiff::Timestamp;
use nester::{Course, Instance, Report, Solution};
use solids::{Mesh, Pose};

use super::{
    super::{draft::Draft, table::tell},
    args::Args,
    setup::Setup,
};
use crate::build::{BuildHeading, BuildPart, PartPlacement, ProvedBuild, SolvedBuild};

/// Edge lengths of the thumbnail, pixels.
const THUMBNAIL: (u32, u32) = (512, 384);

/// Writes everything that was asked for. Nothing is written under the build's name that is not proved.
pub fn write(
    args: &Args,
    setup: &Setup,
    parts: Vec<BuildPart>,
    instance: &Instance,
    solution: &Solution,
    mut course: Course,
) -> Result<Report> {
    let build = solved_build(setup, parts, instance, solution);
    if build.placed.is_empty() {
        tell(&format!("no copy could be placed; {} is not written", args.files.output.display()));
    } else {
        let (draft, proved) = stage(&args.files.output, &build, &setup.limits, build_file::write_build)?;
        if let Some(found) = proved.separable.as_ref().filter(|found| !found.locked.is_empty()) {
            tell(&found.in_words());
        }
        course.clearance_proved_mm = proved.proof.clearance_proved_mm;
        course.separable = proved.separable;
        draft.publish()?;
    }
    let report = build.report(nester::lower_bound_mm(instance), solution.evaluations, &solution.unplaced, course);
    if let Some(target) = &args.files.stl {
        let poses: Vec<(&Mesh, Pose)> =
            (build.placed.iter()).map(|p| (&*build.parts[p.part].mesh, build.machine.machine_pose(&p.pose))).collect();
        let placed = poses.iter().map(|(mesh, pose)| (*mesh, pose));
        Draft::fill(target, |file| Ok(build_file::write_stl(placed, BufWriter::new(file))?))?.publish()?;
    }
    if let Some(target) = &args.files.report {
        Draft::fill(target, |file| Ok(serde_json::to_writer_pretty(BufWriter::new(file), &report)?))?.publish()?;
    }
    Ok(report)
}

fn solved_build(setup: &Setup, parts: Vec<BuildPart>, instance: &Instance, solution: &Solution) -> SolvedBuild {
    let placed = solution.placements.iter().map(|p| PartPlacement { part: p.item, copy: p.copy, pose: p.pose });
    SolvedBuild {
        heading: BuildHeading {
            title: format!("nestd nest, {}", build_file::counted(solution.placements.len(), "part", "parts")),
            build_id: "0".to_owned(),
            created: Timestamp::now(),
            seed: setup.config.seed,
        },
        machine: setup.machine.clone(),
        parts,
        placed: placed.collect(),
        height_mm: solution.height_mm,
        density: solution.density(instance),
    }
}

/// Writes a build by `write` under a name that nobody looks for, and proves what is there.
fn stage(
    target: &Path,
    build: &SolvedBuild,
    limits: &Limits,
    write: impl FnOnce(&BuildFile, File) -> Result<(), WriteError>,
) -> Result<(Draft, ProvedBuild)> {
    let draft = Draft::fill(target, |file| Ok(write(&build.build_file(THUMBNAIL), file)?))?;
    let proved = build.prove(&draft.hidden, limits).context("the build was taken back")?;
    Ok((draft, proved))
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use super::*;
    use crate::build::tests::{one_cube, with_an_item_more};

    #[test]
    fn a_build_that_a_second_reader_reads_differently_does_not_get_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("build.3mf");
        let (build, limits) = (one_cube(), Limits::for_testing());
        let wrongly = |file: &BuildFile, mut out: File| {
            let mut written = Cursor::new(Vec::new());
            build_file::write_build(file, &mut written)?;
            out.write_all(&with_an_item_more(written.get_ref())).unwrap();
            Ok(())
        };
        let refused = stage(&target, &build, &limits, wrongly).err().unwrap();
        assert!(format!("{refused:#}").contains("a second reader disagrees"), "{refused:#}");
        assert!(folder.path().read_dir().unwrap().next().is_none(), "what was written is taken away");
        stage(&target, &build, &limits, build_file::write_build).unwrap().0.publish().unwrap();
        assert!(target.exists());
    }
}
