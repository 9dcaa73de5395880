//! Hostile names and tickets: whatever they hold, every output stays well-formed, and the farm builds their parts.

use std::{
    ffi::OsStr,
    fs,
    os::unix::{ffi::OsStrExt, net::UnixListener},
    path::Path,
    process::Command,
};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, stl, wait_until_or};

/// Asserts that a text has no control characters except line ends.
fn assert_harmless(what: &str, text: &str) {
    let bad = text.chars().find(|&c| c != '\n' && build_file::is_invisible(c));
    assert_eq!(bad, None, "{what}: {}", text.escape_debug());
}

/// Asserts that no cell of a CSV begins like a formula, unless it is a number.
fn assert_no_formula(what: &str, text: &str) {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    for record in reader.records().map(Result::unwrap) {
        let is_formula =
            |cell: &&str| cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err();
        assert_eq!(record.iter().find(is_formula), None, "{what}: {text}");
    }
}

/// A 3MF whose object has a given name.
fn named_package(object: &str) -> Vec<u8> {
    use std::io::Write;
    let model = format!(
        r#"<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" name="{object}"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="9" y="0" z="0"/><vertex x="0" y="9" z="0"/><vertex x="0" y="0" z="9"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh></object></resources><build><item objectid="1"/></build></model>"#
    );
    let relationships = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    // A name that leads out of the package (`../`) is harmless, because packages are never unpacked to disk.
    for (name, text) in
        [("_rels/.rels", relationships), ("3D/3dmodel.model", &model), ("../../../tmp/nestd-escaped", "x")]
    {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

const NAMES: [&[u8]; 8] = [
    b"=HYPERLINK(\"x\").stl",
    b"@SUM(1)\tx.stl",
    b"a\n2026-11-20T00:00:00Z ERROR forged.stl",
    b"\x1b]0;title\x07\x1b[2J.stl",
    b"\xff\xfe\x9b31m.stl",
    b"-rf.stl",
    "\u{202e}lts.exe\u{9b}2J.stl".as_bytes(),
    "<script>alert('x')&amp;\"`$(reboot)`.stl".as_bytes(),
];
const TICKET: &str = "order = \"=cmd|'/C calc'!A1\\u001b[31m\\n\\u202e../../etc\"\nnote = \"-2+3\\u0007\\nline\"\n";

fn drop_all(farm: &TestFarm) -> usize {
    let put = |name: &[u8], bytes: &[u8]| {
        let outside = farm.root().join("sending");
        fs::write(&outside, bytes).unwrap();
        fs::rename(outside, farm.folder("inbox").join(OsStr::from_bytes(name))).unwrap();
    };
    for (at, name) in NAMES.iter().enumerate() {
        put(&[name, ".toml".as_bytes()].concat(), TICKET.as_bytes());
        put(name, &stl(&block(10.0, 10.0, 10.0 + at as f64)));
    }
    put(&[b"x".repeat(251).as_slice(), b".stl"].concat(), &stl(&block(11.0, 11.0, 11.0)));
    put(b"named.3mf", &named_package("=1+1&#27;[31m&#10;&#x9b;x&#x202e;"));
    NAMES.len() + 2
}

#[test]
fn names_and_tickets_that_deceive_reach_no_terminal_spreadsheet_or_log_as_they_are() {
    let farm = TestFarm::running(QUICK);
    let parts = drop_all(&farm);
    farm.wait_for_parts(PartState::Waiting, parts);
    let id = farm.parts(PartState::Waiting)[0].id.to_string();
    farm.flush();
    let file = farm.wait_for_queued(1).remove(0);
    farm.wait_for_parts(PartState::Built, parts);
    let commands = [
        vec!["status", "--parts"],
        vec!["status", "--parts", "--json"],
        vec!["show", "part", &id],
        vec!["show", "part", &id, "--json"],
        vec!["show", "build", "1"],
        vec!["show", "build", "1", "--json"],
        vec!["history"],
        vec!["history", "--json"],
        vec!["history", "--format", "csv"],
        vec!["verify", file.to_str().unwrap()],
    ];
    farm.nestd_ok(&["outcome", "1", "complete", "--note", "=HYPERLINK(\"x\")\u{1b}[2J"]);
    for arguments in &commands {
        let shown = match arguments[0] {
            "verify" => String::from_utf8(farm.nestd(arguments).stdout).unwrap(),
            _ => farm.nestd_ok(arguments),
        };
        assert_harmless(&arguments.join(" "), &shown);
        if arguments.contains(&"--json") {
            serde_json::from_str::<serde_json::Value>(&shown).unwrap();
        }
        if arguments.contains(&"csv") {
            assert!(shown.contains("HYPERLINK"), "{shown}");
            assert_no_formula("history", &shown);
        }
    }
    let picks = fs::read_to_string(sibling_file(&file, ".parts.csv")).unwrap();
    assert!(picks.contains("HYPERLINK"), "{picks}");
    assert_harmless("pick map", &picks);
    assert_no_formula("pick map", &picks);
    assert_harmless("log", &farm.log());
    assert!(farm.log().lines().all(|line| !line.starts_with("2026-11-20T00:00:00Z ERROR forged")), "{}", farm.log());
    assert_harmless("STATUS.txt", &fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap());
    assert!(!Path::new("/tmp/nestd-escaped").exists());
    farm.assert_nothing_lost_or_doubled();
}

/// The file beside it with the same stem and another ending.
fn sibling_file(file: &Path, ending: &str) -> std::path::PathBuf {
    let name = file.file_name().unwrap().to_string_lossy().replace(".build.3mf", ending);
    file.with_file_name(name)
}

#[test]
fn reasons_quote_no_escape_of_a_broken_ticket_or_package() {
    let farm = TestFarm::running(QUICK);
    farm.drop_bytes("a.stl.toml", b"copies = \"\x1b[2Jx\xe2\x80\xae\"\n");
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    let wrong = named_package("x").windows(1).map(|w| w[0]).collect::<Vec<u8>>();
    farm.drop_bytes("b.3mf", &wrong[..wrong.len() / 2]);
    farm.drop_bytes("c\x1b[2J.stl", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex \x1b[31m 0 0\nendsolid");
    farm.wait_for_parts(PartState::Refused, 3);
    // The ledger knows of a refusal before its reason is written.
    let mut reasons = Vec::new();
    wait_until_or(
        "there are three reasons",
        30.0,
        || farm.log(),
        || {
            reasons = intake::files_below(&farm.folder("error")).unwrap();
            reasons.retain(|file| file.to_string_lossy().ends_with(".reason.txt"));
            reasons.len() == 3
        },
    );
    for file in reasons {
        assert_harmless("reason", &fs::read_to_string(file).unwrap());
    }
    assert_harmless("status", &farm.nestd_ok(&["status", "--parts"]));
    assert_harmless("log", &farm.log());
}

#[test]
fn pipes_sockets_links_and_devices_under_the_names_of_our_own_files_stop_nobody() {
    // Parts wait so long for what may be their list.
    let farm = TestFarm::running(&format!("{QUICK}incomplete_secs = 2\n"));
    let inbox = farm.folder("inbox");
    for name in ["pipe.stl", "pipe.stl.toml", "order.csv", "good.stl.reason.txt"] {
        assert!(Command::new("mkfifo").arg(inbox.join(name)).status().unwrap().success());
    }
    let _socket = UnixListener::bind(inbox.join("socket.3mf")).unwrap();
    for (to, name) in [("/dev/zero", "zero.stl"), ("/etc/shadow", "shadow.stl"), ("/", "kit"), (".", "loop")] {
        std::os::unix::fs::symlink(to, inbox.join(name)).unwrap();
    }
    wait_until_or("all are refused", 30.0, || farm.log(), || fs::read_dir(&inbox).unwrap().count() <= 3);
    // The refused files are now in the error folder, where reasons of other files are read and written.
    farm.drop_bytes("good.stl", b"solid good\nnothing\nendsolid");
    farm.drop_bytes("pipe.stl", b"solid pipe\nnothing\nendsolid");
    farm.wait_for_parts(PartState::Refused, 2);
    farm.drop_part("cube.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert!(fs::symlink_metadata("/etc/shadow").unwrap().is_file(), "the link was moved, not what it leads to");
    assert!(fs::symlink_metadata(farm.folder("error").join("shadow.stl")).unwrap().is_symlink());
}
