//! How a search of `nestd nest` ends, and what is said of it.

use std::{
    fs::File,
    path::Path,
    process::{Command, Output},
};

use build_file::write_stl;
use glam::DVec3;
use nix::sys::signal::{Signal, kill};
use solids::Pose;

use super::pictures::{PseudoTerminal, nestd};

/// Two copies of a brick fit beside each other in this one,
const WIDE: &str = "80x80x120";
/// and in this one no layout reaches the lower bound.
const NARROW: &str = "31x31x120";

/// A folder with a brick of 30 x 20 x 10 mm.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let brick = sample_parts::cuboid(DVec3::new(30.0, 20.0, 10.0));
    write_stl([(&brick, &Pose::IDENTITY)].into_iter(), File::create(dir.path().join("brick.stl")).unwrap()).unwrap();
    dir
}

fn nest(dir: &Path, volume: &str, more: &[&str]) -> Command {
    let fixed =
        ["nest", "brick.stl=3", "--volume", volume, "--clearance", "1", "-o", "x.build.3mf", "--report", "x.json"];
    nestd(dir, &[&fixed[..], more].concat())
}

/// What a search that succeeds says, and its report.
fn told(dir: &Path, output: &Output) -> (String, serde_json::Value) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
    (text(&output.stdout), serde_json::from_slice(&std::fs::read(dir.join("x.json")).unwrap()).unwrap())
}

#[test]
fn it_ends_when_no_lower_layout_exists() {
    let dir = folder();
    let (line, report) = told(dir.path(), &nest(dir.path(), WIDE, &["--budget", "1h"]).output().unwrap());
    assert!(line.starts_with("10.00 mm high, no lower layout exists, 3 of 3 copies placed, density "), "{line}");
    assert_eq!(report["ended"], "no lower layout exists");
    let (line, report) =
        told(dir.path(), &nest(dir.path(), WIDE, &["--until-bound", "--margins", "1,5,0"]).output().unwrap());
    assert!(line.starts_with("15.00 mm high, no lower layout exists"), "the bound stands above the floor: {line}");
    assert!(report["lower_bound_mm"].as_f64().unwrap() > 14.99, "{report}");
}

#[test]
fn it_ends_when_its_patience_is_over() {
    let dir = folder();
    let more = ["--until-bound", "--budget", "1s", "--patience", "2s"];
    let (line, report) = told(dir.path(), &nest(dir.path(), NARROW, &more).output().unwrap());
    assert!(line.contains(" mm high, nothing gained for 2 s, bound 18.73, gap "), "{line}");
    assert!(report["wall_secs"].as_f64().unwrap() > 2.0, "{report}");
    assert_eq!(
        nest(dir.path(), NARROW, &["--until-bound", "--method", "paper"]).output().unwrap().status.code(),
        Some(2)
    );
}

#[test]
fn ctrl_c_writes_what_it_has_found() {
    let dir = folder();
    let mut terminal = PseudoTerminal::of(nest(dir.path(), NARROW, &["--until-bound"]), true);
    terminal.until("a layout and the bound are told", |seen| seen.contains(" mm high, bound 18.73, gap "));
    kill(nix::unistd::Pid::from_raw(terminal.child.id() as i32), Signal::SIGINT).unwrap();
    assert!(terminal.child.wait().unwrap().success());
    terminal.until("it is told", |seen| seen.contains("what it has found is proved and written"));
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(dir.path().join("x.json")).unwrap()).unwrap();
    assert_eq!((&report["ended"], &report["placed"]), (&"stopped".into(), &3.into()));
    assert!(dir.path().join("x.build.3mf").exists());
}
