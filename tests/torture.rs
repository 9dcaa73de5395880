//! Opt-in, with `NESTD_DATA=<folder>`: every file of the torture set gives what its manifest expects.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests, too

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use nestd::format::{Contents, Limits, ReadError, Unit, read};

const ROUNDING: &str = "its open edges are the rounding of 32-bit coordinates: welded";

/// Files whose outcome differs from the manifest on purpose: (file, why). Each must really differ.
const EXCEPTIONS: [(&str, &str); 11] = [
    ("trimesh__idler_riser.STL", ROUNDING),
    ("trimesh__featuretype.STL", ROUNDING),
    ("trimesh__angle_block.STL", ROUNDING),
    ("metres__Base.stl", ROUNDING),
    ("moveo__Tapa_4M1.STL", ROUNDING),
    ("openscad__cubes-touching.stl", "an edge passed twice each way encloses a volume and is no defect"),
    ("trimesh__shared.STL", "an edge passed twice each way encloses a volume and is no defect"),
    ("slic3r__100_000.stl", "edges passed twice each way enclose a volume and are no defect"),
    ("3mfsamples__spinal_implant.3mf", "a beam lattice is refused: the manifest allows that too"),
    ("lib3mf__Box_Attributes_Positive.3mf", "a beam lattice is refused: the manifest allows that too"),
    (
        "3mfsamples__MUSTPASS_Chapter4.1_ExplicitSupport.3mf",
        "the support's 80 triangles are left out with a warning: the manifest allows that too",
    ),
];

struct Row {
    path: String,
    expect: String,
}

fn rows(data: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(data.join("MANIFEST.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|h| h == name).unwrap();
    let (group, path, expect) = (column("group"), column("path"), column("expect"));
    let torture = |r: &csv::StringRecord| r[group] == *"torture";
    let row = |r: csv::StringRecord| Row { path: r[path].to_owned(), expect: r[expect].to_owned() };
    reader.records().map(Result::unwrap).filter(torture).map(row).collect()
}

/// Triangles that the build asks for, copies counted each, those without an area included.
fn triangles(contents: &Contents) -> usize {
    let one = |s: &nestd::format::Solid| s.mesh.triangles().len() + s.mesh.defects().degenerate_triangles;
    contents.solids.iter().map(|s| one(s) * s.copies as usize).sum()
}

/// What is wrong with an outcome, if anything.
fn complaint(expect: &str, outcome: &Result<Contents, ReadError>) -> Option<String> {
    if let Err(error) = outcome
        && error.is_io()
    {
        return Some(format!("counts as a fault of the disk: {error}"));
    }
    let wanted: Option<usize> = expect.strip_prefix("accept:").map(|rest| {
        let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
        digits.parse().unwrap()
    });
    match (wanted, outcome) {
        (Some(count), Ok(contents)) if triangles(contents) == count => warnings_complaint(expect, contents),
        (Some(_), Ok(contents)) => Some(format!("accepted with {} triangles", triangles(contents))),
        (Some(_), Err(error)) => Some(format!("refused: {}", chain(error))),
        (None, Ok(contents)) if expect.starts_with("reject") => {
            Some(format!("accepted with {} triangles", triangles(contents)))
        }
        _ => None,
    }
}

/// Defects and sizes that the manifest wants told.
fn warnings_complaint(expect: &str, contents: &Contents) -> Option<String> {
    let sum = |f: fn(&nestd::geometry::Defects) -> usize| -> usize {
        contents.solids.iter().map(|s| f(&s.mesh.defects())).sum()
    };
    let told = |word: &str| {
        contents.warnings.iter().chain(contents.solids.iter().flat_map(|s| &s.warnings)).any(|w| w.contains(word))
    };
    let wants = [
        ("open edges", sum(|d| d.open_edges + d.non_manifold_edges) > 0),
        ("non-manifold edges", sum(|d| d.non_manifold_edges + d.open_edges + d.inconsistent_edges) > 0),
        ("inconsistently wound", sum(|d| d.inconsistent_edges) > 0),
        ("degenerate triangles", told("without an area")),
        ("inside-out", told("inside out")),
        ("suspicious size", told("suspicious size")),
        ("trailing bytes", told("ignored")),
        ("missing endsolid", told("endsolid")),
        ("slice stack", told("slices")),
        ("object types", told("supports")),
    ];
    let missed: Vec<&str> = wants.iter().filter(|(word, told)| expect.contains(word) && !told).map(|w| w.0).collect();
    (!missed.is_empty()).then(|| format!("not told: {}", missed.join(", ")))
}

fn chain(error: &dyn std::error::Error) -> String {
    match error.source() {
        Some(source) => format!("{error}: {}", chain(source)),
        None => error.to_string(),
    }
}

#[test]
fn every_torture_file_gives_what_the_manifest_expects() {
    let Some(data) = std::env::var_os("NESTD_DATA").map(PathBuf::from) else {
        println!("skipped: NESTD_DATA is not set");
        return;
    };
    let names = tempfile::tempdir().unwrap();
    let tar = std::process::Command::new("tar")
        .arg("xf")
        .arg(data.join("torture/names.tar"))
        .current_dir(names.path())
        .status();
    assert!(tar.unwrap().success());
    let exceptions: HashMap<&str, &str> = EXCEPTIONS.into_iter().collect();
    let (mut bad, mut seen) = (Vec::new(), 0);
    for row in rows(&data) {
        let file = match row.path.strip_prefix("torture/names/") {
            Some(_) => names.path().join(row.path.trim_start_matches("torture/")),
            None => data.join(&row.path),
        };
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let outcome = read(&file, &name, None, Unit::Millimeter, &Limits::default());
        seen += 1;
        match (complaint(&row.expect, &outcome), exceptions.get(name.as_str())) {
            (Some(complaint), None) => bad.push(format!("{name}: expected {}; {complaint}", row.expect)),
            (None, Some(reason)) => bad.push(format!("{name}: is as expected, though excepted because {reason}")),
            _ => {}
        }
    }
    assert!(seen > 200, "only {seen} files");
    assert!(bad.is_empty(), "{} of {seen}:\n{}", bad.len(), bad.join("\n"));
}
