//! A farm from nothing: `nestd init`, `nestd machine new`, and what shells and `man` are told of nestd.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use glam::dvec3;
use settings::load_settings;

fn nestd(dir: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nestd")).args(words).current_dir(dir).env_remove("NESTD_ROOT").output().unwrap()
}

fn succeed(dir: &Path, words: &[&str]) -> String {
    let output = nestd(dir, words);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The words that a shell offers for the last of these words.
fn offered(dir: &Path, words: &[&str]) -> Vec<String> {
    let output = Command::new(env!("CARGO_BIN_EXE_nestd"))
        .args(["--", "nestd"])
        .args(words)
        .env("COMPLETE", "fish")
        .env_remove("NESTD_ROOT")
        .current_dir(dir)
        .output()
        .unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .filter_map(|line| Some(line.split('\t').next()?.to_owned()))
        .filter(|word| !word.starts_with('-'))
        .collect()
}

/// (exit code, standard error).
fn fail(dir: &Path, words: &[&str]) -> (Option<i32>, String) {
    let output = nestd(dir, words);
    assert!(!output.status.success(), "{words:?}");
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn init_and_machine_new_make_a_farm_that_can_be_checked_and_overwrite_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let told = succeed(dir.path(), &["init", "my farm"]);
    let config = dir.path().join("my farm/config/nestd.toml");
    assert!(told.contains(&config.display().to_string()), "{told}");
    assert_eq!(fail(dir.path(), &["init", "my farm"]).0, Some(2));
    let in_farm = dir.path().join("my farm");
    succeed(&in_farm, &["machine", "new", "hp-1", "--model", "mjf-5200"]);
    succeed(&in_farm, &["machine", "new", "own", "--volume", "250x200.5x300", "--clearance", "2", "--layer", "0.12"]);
    let again = fail(&in_farm, &["machine", "new", "own", "--volume", "9x9x9"]);
    assert!(again.0 == Some(2) && again.1.contains("is there already"), "{again:?}");
    let settings = load_settings(Some(&config), None).unwrap();
    let (hp, own) = (&settings.profiles["hp-1"].space, &settings.profiles["own"].space);
    assert_eq!((hp.volume_mm, hp.layer_mm), (dvec3(356.0, 280.0, 356.0), 0.08));
    assert_eq!((own.volume_mm, own.clearance_mm, own.layer_mm), (dvec3(250.0, 200.5, 300.0), 2.0, 0.12));
    assert_eq!(settings.root, in_farm);
    assert!(settings.profiles["own"].folders.inbox.starts_with(&in_farm));
}

#[test]
fn a_machine_that_cannot_be_is_refused_and_one_in_centimetres_is_doubted() {
    let dir = tempfile::tempdir().unwrap();
    succeed(dir.path(), &["init"]);
    for name in ["../evil", ".hidden", "a b", ""] {
        assert_eq!(fail(dir.path(), &["machine", "new", name, "--volume", "9x9x9"]).0, Some(2), "{name}");
    }
    assert_eq!(fail(dir.path(), &["machine", "new", "m"]).0, Some(2), "neither model nor volume");
    let wrong = fail(dir.path(), &["machine", "new", "m", "--volume", "200x200x200", "--layer", "0"]);
    assert!(wrong.0 == Some(2) && wrong.1.contains("layer_mm"), "{wrong:?}");
    assert!(!dir.path().join("config/profiles/m.toml").exists(), "no wrong file stays");
    let small = nestd(dir.path(), &["machine", "new", "m", "--volume", "38x28.4x38"]);
    assert!(String::from_utf8_lossy(&small.stderr).contains("centimetres (380 x 284 x 380 mm)"), "{small:?}");
    let check = nestd(dir.path(), &["check"]);
    let found = String::from_utf8_lossy(&check.stdout);
    assert!(found.contains("WARNING volume of m: 38 x 28 x 38 mm is smaller than any machine"), "{found}");
}

#[test]
fn shells_and_man_know_every_command_and_the_version_names_the_commit() {
    let dir = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let script = succeed(dir.path(), &["completions", shell]);
        assert!(script.contains("COMPLETE") && script.contains("nestd"), "{shell}: {script}");
    }
    let commands = offered(dir.path(), &[""]);
    assert!(
        ["history", "machine", "completions"].iter().all(|word| commands.contains(&(*word).to_owned())),
        "{commands:?}"
    );
    assert!(!commands.contains(&"read-part".to_owned()), "what is hidden stays so");
    assert_eq!(offered(dir.path(), &["flush", ""]), [""; 0], "no farm, no words, no error");
    succeed(dir.path(), &["init"]);
    succeed(dir.path(), &["machine", "new", "hp-1", "--model", "mjf-5200"]);
    assert_eq!(offered(dir.path(), &["flush", "h"]), ["hp-1"]);
    let config = dir.path().join("config/nestd.toml");
    assert_eq!(offered(Path::new("/"), &["-c", config.to_str().unwrap(), "pause", ""]), ["hp-1"]);
    succeed(dir.path(), &["man", "pages"]);
    let pages: Vec<String> = fs::read_dir(dir.path().join("pages"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(pages.len() > 30 && pages.iter().any(|page| page == "nestd-machine-new.1"), "{pages:?}");
    let page = fs::read_to_string(dir.path().join("pages/nestd-status.1")).unwrap();
    assert!(page.contains(".TH nestd-status 1") && page.contains("watch"), "{page}");
    let version = succeed(dir.path(), &["--version"]);
    assert!(version.starts_with(&format!("nestd {}", env!("CARGO_PKG_VERSION"))), "{version}");
    // Only a release knows its commit: others would be compiled again after each.
    let is_repository = Path::new(env!("CARGO_MANIFEST_DIR")).join(".git").exists();
    assert!(cfg!(debug_assertions) || !is_repository || version.contains(" ("), "{version}");
}
