//! Every file of the torture set gives what its manifest expects. The reliability run
//! drops the same files into the hot folder of a daemon.

use std::{collections::HashMap, path::PathBuf};

use build_file::{FileReadError, LengthUnit, PartFileContents, ReadLimits, read_part_file};

use crate::support::manifest::{EXCEPTIONS, FileOutcome, files, unpack_names};

fn outcome(result: Result<PartFileContents, FileReadError>) -> FileOutcome {
    let contents = match result {
        Err(error) => return FileOutcome { triangles: None, left_out: 0, messages: chain(&error) },
        Ok(contents) => contents,
    };
    let (mut triangles, mut left_out, mut messages) = (0, 0, contents.warnings.clone());
    for solid in &contents.solids {
        let defects = solid.mesh.defects();
        triangles += solid.mesh.triangles().len() * solid.copies as usize;
        left_out += defects.degenerate_triangles * solid.copies as usize;
        messages.extend(solid.warnings.iter().cloned());
        let found = [
            (defects.open_edges, "open edges"),
            (defects.non_manifold_edges, "edges of more than two triangles"),
            (defects.inconsistent_edges, "face opposite ways"),
        ];
        messages.extend(found.iter().filter(|(count, _)| *count > 0).map(|(_, what)| (*what).to_owned()));
    }
    FileOutcome { triangles: Some(triangles), left_out, messages: messages.join("\n") }
}

fn chain(error: &dyn std::error::Error) -> String {
    match error.source() {
        Some(source) => format!("{error}: {}", chain(source)),
        None => error.to_string(),
    }
}

pub fn every_torture_file_gives_what_the_manifest_expects() {
    let data = PathBuf::from(std::env::var_os("NESTD_DATA").unwrap());
    let names = unpack_names(&data);
    let exceptions: HashMap<&str, &str> = EXCEPTIONS.into_iter().collect();
    let (mut bad, mut seen) = (Vec::new(), 0);
    for expected in files(&data) {
        let file = expected.file(&data, names.path());
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let result = read_part_file(&file, &name, None, LengthUnit::Millimeter, &ReadLimits::default());
        seen += 1;
        if result.as_ref().is_err_and(FileReadError::is_io) {
            bad.push(format!("{name}: counts as a fault of the disk"));
        }
        match (expected.find_difference(&outcome(result)), exceptions.get(name.as_str())) {
            (Some(complaint), None) => bad.push(format!("{name}: expected {}; {complaint}", expected.expect)),
            (None, Some(reason)) => bad.push(format!("{name}: is as expected, though excepted because {reason}")),
            _ => {}
        }
    }
    assert!(seen > 200, "only {seen} files");
    assert!(bad.is_empty(), "{} of {seen}:\n{}", bad.len(), bad.join("\n"));
}

/// What is mended may change the volume by no more than this share where nothing was turned. The volume of an open surface is that of what is
/// left: a block without one of its twelve triangles lacks a twelfth.
const MOST_VOLUME: f64 = 0.1;

pub fn broken_meshes_of_other_people_are_mended_within_measures_or_refused_with_a_reason() {
    let data = PathBuf::from(std::env::var_os("NESTD_DATA").unwrap());
    let names = unpack_names(&data);
    let (mut broken, mut mended, mut wrong) = (0, 0, Vec::new());
    for expected in files(&data) {
        let file = expected.file(&data, names.path());
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let read = read_part_file(&file, &name, None, LengthUnit::Millimeter, &ReadLimits::default());
        for solid in read.into_iter().flat_map(|contents| contents.solids) {
            if solid.mesh.defects().is_closed() {
                continue;
            }
            broken += 1;
            let before = solid.mesh.defects();
            match solid.mesh.mended() {
                Err(why) => println!(
                    "{name}: refused, {why} ({} open edges of {} triangles)",
                    before.open_edges,
                    solid.mesh.triangles().len()
                ),
                Ok(done) => {
                    mended += 1;
                    let measures = done.measures;
                    println!("{name}: {measures:?}");
                    let change = (measures.volume_after_mm3 / measures.volume_before_mm3 - 1.0).abs();
                    let has_its_size = done.mesh.bounds() == solid.mesh.bounds();
                    let is_small = measures.turned > 0 || change <= MOST_VOLUME;
                    if !done.mesh.defects().is_closed() || !is_small || !has_its_size {
                        wrong.push(format!("{name}: {measures:?}"));
                    }
                }
            }
        }
    }
    println!("{broken} broken meshes, {mended} mended");
    assert!(mended > 0 && wrong.is_empty(), "{}", wrong.join("\n"));
}
