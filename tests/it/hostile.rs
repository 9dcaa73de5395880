//! Files made to break readers: no reader may panic, hang, or allocate memory that a file only claims to need.

use std::{fs, path::PathBuf, process::Command};

use build_file::{FileReadError, LengthUnit, PartFileContents, ReadLimits, has_end, read_build, read_part_file};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use zip::CompressionMethod;

use crate::support::samples::{MESH, RELATIONSHIPS, binary_stl, honest, model, mutated, package, text_stl, threemf};

/// Peak memory limit of the process, MiB; the limits for testing allow files of 4 MiB.
const MAX_MEMORY_MIB: u64 = 400;
const ROUNDS: usize = 400;

/// A scratch file for all readers.
struct ScratchFile(tempfile::TempDir);

impl ScratchFile {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, bytes: &[u8]) -> PathBuf {
        let file = self.0.path().join("f");
        fs::write(&file, bytes).unwrap();
        file
    }

    fn read(&self, bytes: &[u8], name: &str) -> Result<PartFileContents, FileReadError> {
        let result = read_part_file(&self.file(bytes), name, None, LengthUnit::Millimeter, &ReadLimits::for_testing());
        assert!(!result.as_ref().is_err_and(FileReadError::is_io), "{result:?} blames the disk");
        result
    }

    /// Runs all readers, to find panics.
    fn try_all(&self, bytes: &[u8], name: &str) {
        let _ = self.read(bytes, name);
        let file = self.file(bytes);
        let _ = read_build(&file, &ReadLimits::for_testing());
        let _ = has_end(&mut fs::File::open(&file).unwrap(), name);
    }

    fn refusal(&self, bytes: &[u8]) -> String {
        match self.read(bytes, "x.3mf") {
            Ok(contents) => panic!("accepted: {:?}", contents.warnings),
            Err(error) => error.to_string(),
        }
    }
}

/// Tells the process that [`in_a_process_of_its_own`] starts that it is the child.
const ALONE: &str = "NESTD_TEST_ALONE";

/// Runs the work of a test in a separate process, where no other test uses memory, and asserts its peak memory.
fn in_a_process_of_its_own(test: &str, work: fn()) {
    if std::env::var_os(ALONE).is_some() {
        work();
        return assert!(peak_memory_mib() < MAX_MEMORY_MIB, "{} MiB", peak_memory_mib());
    }
    let name = format!("hostile::{test}");
    let mut command = Command::new(std::env::current_exe().unwrap());
    let output = command.args(["--exact", &name, "--nocapture"]).env(ALONE, "1").output().unwrap();
    let output_text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && output_text.contains("1 passed"), "{output_text}");
}

fn peak_memory_mib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() / 1024
}

#[test]
fn the_honest_files_are_read() {
    let scratch = ScratchFile::new();
    assert_eq!(scratch.read(&binary_stl(), "a.stl").unwrap().solids[0].mesh.triangles().len(), 4);
    assert_eq!(scratch.read(&text_stl(), "a.stl").unwrap().solids[0].mesh.triangles().len(), 4);
    let contents = scratch.read(&threemf(honest().as_bytes()), "a.3mf").unwrap();
    assert_eq!(contents.solids.iter().map(|s| s.mesh.triangles().len()).collect::<Vec<_>>(), [4, 8]);
    assert_eq!(contents.solids[1].mesh.bounds().min.to_array(), [-9.0, 0.0, 0.0], "components are moved, items turned");
}

#[test]
fn thousands_of_damaged_files_are_read_or_refused() {
    in_a_process_of_its_own("thousands_of_damaged_files_are_read_or_refused", || {
        let scratch = ScratchFile::new();
        let mut rng = ChaCha8Rng::seed_from_u64(42);
        let (binary, text, xml) = (binary_stl(), text_stl(), honest().into_bytes());
        let packed = threemf(&xml);
        for _ in 0..ROUNDS {
            scratch.try_all(&mutated(&binary, &mut rng), "a.stl");
            scratch.try_all(&mutated(&text, &mut rng), "a.stl");
            scratch.try_all(&mutated(&packed, &mut rng), "a.3mf");
            scratch.try_all(&threemf(&mutated(&xml, &mut rng)), "a.3mf");
        }
    });
}

#[test]
fn bombs_are_refused_before_they_go_off() {
    in_a_process_of_its_own("bombs_are_refused_before_they_go_off", || {
        let scratch = ScratchFile::new();
        let blank = |bytes: usize| model("", "").replace("<build>", &format!("<build>{}", " ".repeat(bytes)));
        assert!(scratch.refusal(&threemf(blank(3 << 20).as_bytes())).contains("token"));
        let comments = format!("<!--{}-->", "x".repeat(1 << 19)).repeat(40);
        assert!(scratch.refusal(&threemf((comments + &honest()).as_bytes())).contains("unpacked"));
        let many: String = (0..300).map(|i| format!(r#"<object id="{i}"/>"#)).collect();
        assert!(scratch.refusal(&threemf(model(&many, "").as_bytes())).contains("objects"));
        let doubled = (1..20).map(|i| {
            let inner = format!(r#"<component objectid="{i}"/>"#).repeat(10);
            format!(r#"<object id="{}"><components>{inner}</components></object>"#, i + 1)
        });
        let doubling = format!(r#"<object id="1">{MESH}</object>"#) + &doubled.collect::<String>();
        for (top, word) in [(4, "instances"), (19, "depth")] {
            let bomb = model(&doubling, &format!(r#"<item objectid="{top}"/>"#));
            let refusal = scratch.refusal(&threemf(bomb.as_bytes()));
            assert!(refusal.contains(word), "{refusal}");
        }
        let deep = "<x>".repeat(100_000);
        assert!(scratch.refusal(&threemf(model(&deep, "").as_bytes())).contains("deep"));
    });
}

#[test]
fn a_torn_binary_stl_whose_header_says_solid_is_reported_as_truncated() {
    let mut bytes = binary_stl();
    bytes.truncate(84 + 2 * 50 + 7);
    let error = ScratchFile::new().read(&bytes, "a.stl").unwrap_err();
    assert_eq!(error.to_string(), "the file is truncated: only 2 of 4 triangles are in the file");
}

#[test]
fn lies_about_structure_are_refused_by_name() {
    let scratch = ScratchFile::new();
    let cases = [
        (r#"v1="0""#, r#"v1="-1""#, "index"),
        (r#"v1="0""#, r#"v1="4""#, "of 4 vertices"),
        (r#"v1="0""#, r#"v1="4294967296""#, "index"),
        (r#"x="9""#, r#"x="nan""#, "finite"),
        (r#"transform="1 0 0 0 1 0 0 0 1 20 0 0""#, r#"transform="1 0 0""#, "12 finite numbers"),
        (r#"transform="1 0 0 0 1 0 0 0 1 20 0 0""#, r#"transform="1 0 0 0 1 0 0 0 0 20 0 0""#, "singular"),
        (r#"<component objectid="1"/>"#, r#"<component objectid="2"/>"#, "component of itself"),
        (r#"<component objectid="1"/>"#, r#"<component objectid="7"/>"#, "no object 7"),
        (r#"<component objectid="1"/>"#, r#"<component objectid="1" p:path="/3D/x.model"/>"#, "there is no"),
        (r#"id="2""#, r#"id="1""#, "two objects 1"),
        ("<model ", r#"<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><model "#, "DTD"),
        ("<model ", r#"<model requiredextensions="q" "#, "does not declare"),
        ("<model ", r#"<model requiredextensions="q" xmlns:q="http://example.com/q" "#, "http://example.com/q"),
        ("millimeter", "parsec", "parsec"),
        (">T<", ">&x;<", "entity"),
    ];
    for (from, to, word) in cases {
        assert!(honest().contains(from));
        let refusal = scratch.refusal(&threemf(honest().replace(from, to).as_bytes()));
        assert!(refusal.contains(word), "{from} -> {to}: {refusal}");
    }
}

#[test]
fn words_for_people_do_not_decide_whether_a_file_is_read() {
    let scratch = ScratchFile::new();
    let with = |words: &str| threemf(honest().replacen("<resources>", &format!("{words}<resources>"), 1).as_bytes());
    for words in [
        r#"<metadata name="Description">a</metadata><metadata name="Description">b</metadata>"#,
        "<metadata>nameless</metadata>",
        r#"<metadata name="nobody:declared">x</metadata>"#,
    ] {
        let contents = scratch.read(&with(words), "a.3mf").unwrap();
        assert!(
            contents.warnings[0].starts_with("1 metadata entry breaks the rules of 3MF"),
            "{:?}",
            contents.warnings
        );
    }
}

#[test]
fn every_refusal_of_a_foreign_file_says_what_to_do() {
    let scratch = ScratchFile::new();
    let zip = |name: &str| package(&[(name, &b"solid x"[..])], CompressionMethod::Stored);
    let obj = "# Blender\nmtllib a.mtl\no Cube\nv 1.0 1.0 -1.0\nv 1 -1 -1\nf 1 2 3\n";
    let curved = "v 1 1 -1\ncstype bspline\nsurf 0 1 0 1 1 2 3 4\n";
    let torn = &binary_stl()[..200];
    for (bytes, name, what, remedy) in [
        (&b""[..], "a.stl", "empty", "Copy it once more"),
        (torn, "a.stl", "truncated", "Copy the whole file"),
        (obj.as_bytes(), "a.obj", "names corner `3`, and 2 come before it", "STL or 3MF"),
        (obj.as_bytes(), "a.stl", "not valid OBJ: line 6", "STL or 3MF"),
        (curved.as_bytes(), "a.obj", "free-form surface (line 3)", "triangles only"),
        (&b"newmtl steel\nKd 1 1 1\n"[..], "a.mtl", "colours", "Delete it"),
        (&b"ply\nformat ascii 1.0\nend_header\n"[..], "a.ply", "no face", "STL or 3MF"),
        (&b"ISO-10303-21;\nHEADER;"[..], "a.step", "STEP", "as STL or 3MF"),
        (&b"%PDF-1.4 x"[..], "a.pdf", "PDF", "no shape to print"),
        (&zip("a.stl"), "a.zip", "ZIP archive", "Unpack it"),
        (&zip("parts/a.STL"), "a.3mf", "ZIP archive", "Unpack it"),
        (&b"\x01\x02"[..], "a.sldprt", "CAD program", "as STL or 3MF"),
        (&b"hello"[..], "readme.txt", "text", "no shape to print"),
    ] {
        let error = scratch.read(bytes, name).unwrap_err();
        assert!(
            error.to_string().contains(what) && error.remedy().contains(remedy),
            "{name}: {error} {}",
            error.remedy()
        );
    }
}

#[test]
fn two_entries_of_one_name_are_refused_whatever_their_case() {
    let scratch = ScratchFile::new();
    let model = honest();
    let entries: [(&str, &[u8]); 3] = [
        ("_rels/.rels", RELATIONSHIPS.as_bytes()),
        ("3D/3dmodel.model", model.as_bytes()),
        ("3d/3DMODEL.model", b"<x/>"),
    ];
    let mut twice = package(&entries, CompressionMethod::Stored);
    assert!(scratch.refusal(&twice).contains("twice"));
    for at in 0..twice.len() - 16 {
        if twice[at..].starts_with(b"3d/3DMODEL.model") {
            twice[at..at + 16].copy_from_slice(b"3D/3dmodel.model");
        }
    }
    assert!(scratch.refusal(&twice).contains("twice"));
}

#[test]
fn more_entries_than_the_limit_are_refused() {
    let names: Vec<String> = (0..51).map(|i| format!("e{i}")).collect();
    let entries: Vec<(&str, &[u8])> = names.iter().map(|n| (n.as_str(), [].as_slice())).collect();
    assert!(ScratchFile::new().refusal(&package(&entries, CompressionMethod::Stored)).contains("entries"));
}

#[test]
fn sizes_that_the_directory_claims_are_not_believed() {
    in_a_process_of_its_own("sizes_that_the_directory_claims_are_not_believed", || {
        let scratch = ScratchFile::new();
        let honest = threemf(honest().as_bytes());
        for signature in [b"PK\x01\x02".as_slice(), b"PK\x03\x04"] {
            let size_at = if signature == b"PK\x01\x02" { 24 } else { 22 };
            let mut lying = honest.clone();
            for at in 0..lying.len() - 46 {
                if lying[at..].starts_with(signature) {
                    lying[at + size_at..at + size_at + 4].copy_from_slice(&0xffff_fff0_u32.to_le_bytes());
                }
            }
            scratch.try_all(&lying, "a.3mf");
        }
    });
}

#[test]
fn a_file_beyond_the_limits_is_refused_unread() {
    let scratch = ScratchFile::new();
    let large = vec![b' '; (4 << 20) + 1];
    assert!(matches!(scratch.read(&large, "a.stl"), Err(FileReadError::TooLarge { .. })));
    let mut many = vec![0; 84 + 50 * 50_001];
    many[80..84].copy_from_slice(&50_001_u32.to_le_bytes());
    assert!(matches!(scratch.read(&many, "a.stl"), Err(FileReadError::TooLarge { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_do_no_harm(
        start in prop::sample::select(vec![&b""[..], b"solid ", b"PK\x03\x04", b"facet", b"\xef\xbb\xbf", b"<?xml"]),
        bytes in prop::collection::vec(any::<u8>(), 0..600),
        name in prop::sample::select(vec!["a.stl", "a.3mf", "a", "a.txt"]),
    ) {
        let whole = [start, &bytes].concat();
        ScratchFile::new().try_all(&whole, name);
    }

    #[test]
    fn arbitrary_xml_does_no_harm(inside in "[<>/a-z\"= 0-9&;:!\\-\\[\\]?]{0,200}") {
        let scratch = ScratchFile::new();
        scratch.try_all(&threemf(model(&inside, &inside).as_bytes()), "a.3mf");
        scratch.try_all(&threemf(inside.as_bytes()), "a.3mf");
    }

    #[test]
    fn arbitrary_words_do_no_harm(words in prop::collection::vec(
        prop::sample::select(vec!["solid", "facet", "normal", "outer", "loop", "vertex", "0", "1e9", "-", "endloop",
            "endfacet", "endsolid", "\n", "\r", "#", "x"]), 0..80)
    ) {
        ScratchFile::new().try_all(format!("solid {}", words.join(" ")).as_bytes(), "a.stl");
    }
}
