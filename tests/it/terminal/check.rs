//! `nestd check` on real folders and a real ledger.

use std::{
    fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
};

use assert_cmd::Command;
use ledger::Ledger;
use serde_json::Value;

/// A farm of one machine in a temporary folder.
struct CheckedFarm {
    dir: tempfile::TempDir,
}

impl CheckedFarm {
    fn new() -> Self {
        let farm = Self { dir: tempfile::tempdir().unwrap() };
        farm.write("etc/nestd.toml", "");
        farm.write("etc/profiles/cube.toml", "volume_mm = [200, 200, 200]\n");
        farm
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), text).unwrap();
    }

    /// Exit code, problems as `what: text`, and all of the output.
    fn check(&self) -> (i32, Vec<String>, String) {
        let config = self.path("etc/nestd.toml");
        let output = Command::cargo_bin("nestd")
            .unwrap()
            .args(["check", "--json", "-c"])
            .arg(config)
            .arg("--root")
            .arg(self.path("farm"))
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout.clone()).unwrap();
        let report: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text} {output:?}"));
        let findings = report["findings"].as_array().unwrap();
        let problems: Vec<String> = (findings.iter().filter(|finding| finding["level"] == "problem"))
            .map(|finding| {
                assert!(finding["remedy"].as_str().is_some_and(|remedy| !remedy.is_empty()), "{finding}");
                format!("{}: {}", finding["what"].as_str().unwrap(), finding["text"].as_str().unwrap())
            })
            .collect();
        assert_eq!(report["problems"], problems.len());
        (output.status.code().unwrap(), problems, text)
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_farm_that_is_not_there_yet_is_well_and_stays_not_there() {
    let farm = CheckedFarm::new();
    let (code, problems, _) = farm.check();
    assert_eq!((code, problems), (0, vec![]));
    assert_eq!(names(farm.dir.path()), ["etc"]);
}

#[test]
fn a_farm_that_is_there_is_well_and_nothing_is_left_in_it() {
    let farm = CheckedFarm::new();
    for folder in ["inbox/cube", "queue/cube", "error/cube", "archive/cube", "state"] {
        fs::create_dir_all(farm.path("farm").join(folder)).unwrap();
    }
    let (code, problems, text) = farm.check();
    assert_eq!((code, problems), (0, vec![]), "{text}");
    assert_eq!(names(&farm.path("farm/inbox/cube")), Vec::<String>::new());
    assert_eq!(names(&farm.path("farm/state")), Vec::<String>::new());
}

#[test]
fn a_wrong_configuration_ends_with_2_and_names_file_and_line() {
    let farm = CheckedFarm::new();
    farm.write("etc/nestd.toml", "\nscan_sec = 10\n");
    let (code, problems, text) = farm.check();
    assert_eq!((code, problems), (2, vec!["configuration: unknown option \"scan_sec\"".to_owned()]));
    assert!(text.contains("\"line\": 2") && text.contains("etc/nestd.toml"), "{text}");
}

#[test]
fn a_file_in_the_place_of_a_folder_is_a_problem() {
    let farm = CheckedFarm::new();
    farm.write("farm/queue/cube", "not a folder");
    let (code, problems, _) = farm.check();
    assert_eq!(code, 1);
    assert!(problems.len() == 1 && problems[0].ends_with("farm/queue/cube is not a folder"), "{problems:?}");
}

#[test]
fn two_names_of_one_folder_are_a_problem() {
    let farm = CheckedFarm::new();
    fs::create_dir_all(farm.path("farm/inbox/cube")).unwrap();
    fs::create_dir_all(farm.path("farm/queue")).unwrap();
    symlink(farm.path("farm/inbox/cube"), farm.path("farm/queue/cube")).unwrap();
    let (code, problems, _) = farm.check();
    assert_eq!(code, 2);
    assert!(problems.len() == 1 && problems[0].contains("also the inbox of cube"), "{problems:?}");
}

#[test]
fn a_folder_that_cannot_be_made_is_a_problem() {
    let farm = CheckedFarm::new();
    farm.write("farm/plain", "a file");
    farm.write("etc/nestd.toml", "[folders]\nerror = \"plain/error\"\n");
    let (code, problems, _) = farm.check();
    assert_eq!(code, 1);
    assert!(problems.len() == 1 && problems[0].contains("plain/error/cube is not there"), "{problems:?}");
}

#[test]
fn a_folder_that_the_farm_has_used_and_that_is_not_mounted_is_a_problem_as_the_daemon_says() {
    let farm = CheckedFarm::new();
    let known: serde_json::Map<String, Value> = ["inbox/cube", "queue/cube", "error/cube"]
        .map(|folder| (farm.path("farm").join(folder).display().to_string(), serde_json::json!([1, 1])))
        .into_iter()
        .collect();
    farm.write("farm/state/nestd.folders", &Value::Object(known).to_string());
    // An empty mount point stands in the place of one; those of the others are not there at all.
    fs::create_dir_all(farm.path("farm/error/cube")).unwrap();
    let (code, problems, text) = farm.check();
    assert_eq!((code, problems.len()), (1, 3), "{text}");
    let is_said = |what: &str, text: &str| problems.iter().any(|one| one.starts_with(what) && one.contains(text));
    assert!(is_said("inbox of cube: ", "inbox/cube is not there, and this farm has used it before"), "{text}");
    assert!(is_said("queue of cube: ", "queue/cube is not there, and this farm has used it before"), "{text}");
    assert!(is_said("error folder of cube: ", "is not the folder that was there before"), "{text}");
    assert!(text.contains("mount it again") && text.contains("archive/cube will be made"), "{text}");
}

#[test]
fn a_ledger_that_is_up_to_date_is_well_and_one_that_is_none_is_a_problem() {
    let farm = CheckedFarm::new();
    let path = farm.path("farm/state/nestd.db");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { Ledger::open(&path).await.unwrap().close().await });
    let (code, problems, text) = farm.check();
    assert_eq!((code, problems), (0, vec![]));
    assert!(text.contains("schema is current"), "{text}");

    // A dashboard with sign-in on which nobody can.
    farm.write("etc/nestd.toml", "[web]\nlisten = \"127.0.0.1:0\"\nsign_in = true\n");
    let (code, problems, text) = farm.check();
    assert_eq!((code, problems.len()), (1, 1), "{problems:?}");
    assert!(problems[0].starts_with("people: ") && text.contains("nestd people add NAME --role admin"), "{text}");

    let other = CheckedFarm::new();
    other.write("farm/state/nestd.db", &"this is no database. ".repeat(100));
    let (code, problems, _) = other.check();
    assert_eq!(code, 1);
    assert!(problems.len() == 1 && problems[0].starts_with("ledger: "), "{problems:?}");
}

#[test]
fn what_lies_beside_the_hot_folders_is_warned_of_with_a_remedy() {
    let farm = CheckedFarm::new();
    let left = ["inbox/gone/.nestd-owner", "inbox/gone/STATUS.txt", "inbox/gone/c.stl"];
    for file in ["inbox/lost.stl", "inbox/cubes/a.stl", "inbox/cube/b.stl", "inbox/.DS_Store"].into_iter().chain(left) {
        farm.write(&format!("farm/{file}"), "solid");
    }
    let (code, problems, text) = farm.check();
    assert_eq!((code, problems), (0, vec![]), "{text}");
    let report: Value = serde_json::from_str(&text).unwrap();
    let warnings: Vec<&Value> =
        report["findings"].as_array().unwrap().iter().filter(|finding| finding["level"] == "warning").collect();
    let text_of = |at: usize, key: &str| warnings[at][key].as_str().unwrap();
    assert_eq!(warnings.len(), 3, "{text}");
    assert!(text_of(0, "text").starts_with("the folder \"cubes\" in "), "{text}");
    assert!(
        text_of(1, "text").starts_with("the folder \"gone\" in ") && text_of(1, "text").contains("was that of"),
        "{text}"
    );
    assert!(text_of(1, "remedy").contains("the parts in it, and nothing else"), "{text}");
    assert!(text_of(2, "text").starts_with("\"lost.stl\" lies in "), "{text}");
    assert!(
        text_of(0, "remedy").contains("add a machine of that name") && text_of(2, "remedy").starts_with("move it"),
        "{text}"
    );
}

#[test]
fn folders_of_the_farm_that_lie_beside_the_hot_folders_are_not_stray() {
    let farm = CheckedFarm::new();
    farm.write("etc/nestd.toml", "[folders]\ninbox = \".\"\n");
    for folder in ["cube", "queue/cube", "error/cube", "archive/cube", "state"] {
        fs::create_dir_all(farm.path("farm").join(folder)).unwrap();
    }
    let (code, _, text) = farm.check();
    assert!(code == 0 && !text.contains("\"warning\""), "{text}");
}

#[test]
fn without_a_configuration_it_is_said_what_to_do() {
    let dir = tempfile::tempdir().unwrap();
    let output = Command::cargo_bin("nestd").unwrap().arg("check").current_dir(dir.path()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    // The machine that runs these tests may have a configuration of its own.
    if !Path::new("/etc/nestd/nestd.toml").exists() {
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr.contains("neither config/nestd.toml nor /etc/nestd/nestd.toml is there"), "{stderr}");
    }
}
