//! The torture set: the result that its manifest expects for every file, and where nestd differs on purpose. The test
//! of the readers and the reliability run share it.

use std::path::{Path, PathBuf};

const ROUNDING: &str = "its open edges are the rounding of 32-bit coordinates: welded";

/// Files whose outcome differs from the manifest on purpose: (file, why). Each must really differ.
pub const EXCEPTIONS: [(&str, &str); 11] = [
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

/// A file of the set.
pub struct ExpectedFile {
    path: String,
    /// The expectation in the manifest: `accept:<triangles>;warn ...`, `reject:...`, `ignore:...`.
    pub expect: String,
}

/// The result of reading a file.
pub struct FileOutcome {
    /// Triangles of its parts times their copies; `None` = refused.
    pub triangles: Option<usize>,
    /// Triangles that were left out for having no area.
    pub left_out: usize,
    /// The warnings, or the reason of the refusal.
    pub messages: String,
}

/// All files of the set.
pub fn files(data: &Path) -> Vec<ExpectedFile> {
    let mut reader = csv::Reader::from_path(data.join("MANIFEST.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|h| h == name).unwrap();
    let (group, path, expect) = (column("group"), column("path"), column("expect"));
    let torture = |r: &csv::StringRecord| r[group] == *"torture";
    let row = |r: csv::StringRecord| ExpectedFile { path: r[path].to_owned(), expect: r[expect].to_owned() };
    reader.records().map(Result::unwrap).filter(torture).map(row).collect()
}

/// Unpacks the files with odd names, which are kept in an archive.
pub fn unpack_names(data: &Path) -> tempfile::TempDir {
    let names = tempfile::tempdir().unwrap();
    let archive = data.join("torture/names.tar");
    let tar = std::process::Command::new("tar").arg("xf").arg(archive).current_dir(names.path()).status();
    assert!(tar.unwrap().success());
    names
}

impl ExpectedFile {
    /// The path of the file.
    pub fn file(&self, data: &Path, names: &Path) -> PathBuf {
        match self.path.strip_prefix("torture/names/") {
            Some(_) => names.join(self.path.trim_start_matches("torture/")),
            None => data.join(&self.path),
        }
    }

    /// How an outcome differs from the expectation, if it does.
    pub fn find_difference(&self, outcome: &FileOutcome) -> Option<String> {
        let wanted: Option<usize> = self.expect.strip_prefix("accept:").map(|rest| {
            let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
            digits.parse().unwrap()
        });
        match (wanted, outcome.triangles) {
            (Some(count), Some(found)) if found + outcome.left_out == count => self.missing_warnings(&outcome.messages),
            (Some(_), None) => Some(format!("refused: {}", outcome.messages)),
            (Some(_), Some(found)) => Some(format!("accepted with {found} triangles")),
            (None, Some(found)) if self.expect.starts_with("refuse") => {
                Some(format!("accepted with {found} triangles"))
            }
            _ => None,
        }
    }

    /// Warnings that the manifest demands and the outcome lacks.
    fn missing_warnings(&self, messages: &str) -> Option<String> {
        const OPEN: &str = "open edges";
        const MANY: &str = "edges of more than two triangles";
        const WOUND: &str = "face opposite ways";
        let wants: [(&str, &[&str]); 10] = [
            ("open edges", &[OPEN, MANY]),
            ("non-manifold edges", &[MANY, OPEN, WOUND]),
            ("inconsistently wound", &[WOUND]),
            ("degenerate triangles", &["without an area"]),
            ("inside-out", &["inside out"]),
            ("suspicious size", &["suspicious size"]),
            ("trailing bytes", &["ignored"]),
            ("missing endsolid", &["endsolid"]),
            ("slice stack", &["slice stack"]),
            ("object types", &["supports"]),
        ];
        let is_missed = |(word, expected): &&(&str, &[&str])| {
            self.expect.contains(word) && !expected.iter().any(|expected| messages.contains(expected))
        };
        let missed: Vec<&str> = wants.iter().filter(is_missed).map(|want| want.0).collect();
        (!missed.is_empty()).then(|| format!("not told: {}", missed.join(", ")))
    }
}
