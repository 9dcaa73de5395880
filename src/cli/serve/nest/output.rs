//! Writes the build and proves it before it gets its name; then writes the report and the STL.

use std::{fs::File, io::BufWriter, path::Path};

use anyhow::{Context, Result};
use build_file::{BuildFile, FileWriteError, ReadLimits};
use delivery::build::{BuildHeading, BuildPart, PartPlacement, ProvedBuild, SolvedBuild};
use jiff::Timestamp;
use nester::{NestingInstance, NestingReport, NestingSolution, SearchSummary};
use solids::{Mesh, Pose};

use super::{args::NestArgs, setup::NestingSetup};
use crate::cli::terminal::{atomic_file::AtomicFile, table::print_to_stderr};

/// Edge lengths of the thumbnail, pixels.
const THUMBNAIL: (u32, u32) = (512, 384);

/// Writes all requested outputs; `bound_mm` is the lower bound above the machine's floor. The build file appears under
/// its name only after it is proved.
pub fn write_outputs(
    args: &NestArgs,
    setup: &NestingSetup,
    parts: Vec<BuildPart>,
    (instance, bound_mm): (&NestingInstance, f64),
    solution: &NestingSolution,
    mut summary: SearchSummary,
) -> Result<NestingReport> {
    let build = solved_build(setup, parts, instance, solution);
    if build.placed.is_empty() {
        print_to_stderr(&format!("no copy could be placed; {} is not written", args.files.output.display()));
    } else {
        let (draft, proved) = write_and_prove(&args.files.output, &build, &setup.limits, build_file::write_build)?;
        if let Some(found) = proved.separability.as_ref().filter(|found| !found.locked.is_empty()) {
            print_to_stderr(&found.in_words());
        }
        summary.clearance_proved_mm = proved.proof.clearance_proved_mm;
        summary.separable = proved.separability;
        draft.rename_into_place()?;
    }
    let report = build.to_report(bound_mm, solution.evaluations, &solution.unplaced, summary);
    if let Some(target) = &args.files.stl {
        let poses: Vec<(&Mesh, Pose)> =
            (build.placed.iter()).map(|p| (&*build.parts[p.part].mesh, build.machine.machine_pose(&p.pose))).collect();
        let placed = poses.iter().map(|(mesh, pose)| (*mesh, pose));
        AtomicFile::write_hidden(target, |file| Ok(build_file::write_stl(placed, BufWriter::new(file))?))?
            .rename_into_place()?;
    }
    if let Some(target) = &args.files.report {
        AtomicFile::write_hidden(target, |file| Ok(serde_json::to_writer_pretty(BufWriter::new(file), &report)?))?
            .rename_into_place()?;
    }
    Ok(report)
}

fn solved_build(
    setup: &NestingSetup,
    parts: Vec<BuildPart>,
    instance: &NestingInstance,
    solution: &NestingSolution,
) -> SolvedBuild {
    let placed = solution.placements.iter().map(|p| PartPlacement { part: p.item, copy: p.copy, pose: p.pose });
    SolvedBuild {
        heading: BuildHeading {
            title: format!("nestd nest, {}", build_file::format_count(solution.placements.len(), "part", "parts")),
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

/// Writes a build with `write` under a hidden name, and proves the written file.
fn write_and_prove(
    target: &Path,
    build: &SolvedBuild,
    limits: &ReadLimits,
    write: impl FnOnce(&BuildFile, File) -> Result<(), FileWriteError>,
) -> Result<(AtomicFile, ProvedBuild)> {
    let draft = AtomicFile::write_hidden(target, |file| Ok(write(&build.to_build_file(THUMBNAIL), file)?))?;
    let proved = build.prove_written_file(&draft.hidden, None, limits).context("the build was removed again")?;
    Ok((draft, proved))
}

#[cfg(test)]
#[path = "../../../../crates/delivery/src/build/fixtures.rs"]
mod fixtures;

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use super::{
        fixtures::{one_cube, with_an_item_more},
        *,
    };

    #[test]
    fn a_build_that_a_second_reader_reads_differently_does_not_get_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("build.3mf");
        let (build, limits) = (one_cube(), ReadLimits::for_testing());
        let wrongly = |file: &BuildFile, mut out: File| {
            let mut written = Cursor::new(Vec::new());
            build_file::write_build(file, &mut written)?;
            out.write_all(&with_an_item_more(written.get_ref())).unwrap();
            Ok(())
        };
        let refused = write_and_prove(&target, &build, &limits, wrongly).err().unwrap();
        assert!(format!("{refused:#}").contains("a second reader disagrees"), "{refused:#}");
        assert!(folder.path().read_dir().unwrap().next().is_none(), "what was written is taken away");
        write_and_prove(&target, &build, &limits, build_file::write_build).unwrap().0.rename_into_place().unwrap();
        assert!(target.exists());
    }
}
