//! The commands that read the ledger or send commands through it, as an operator types them: exit codes and output.

use std::path::Path;

use assert_cmd::Command;
use ledger::{Ledger, NewPartRow, NewTerms, RequiredTilts, SolidFacts};
use nester::OrientationRule;

/// `nestd` with the shipped configuration for trying it out, and with its folders under `root`.
fn nestd(root: &Path, words: &str) -> Command {
    let mut command = Command::cargo_bin("nestd").unwrap();
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/nestd.toml");
    command.arg("-c").arg(config).arg("--root").arg(root).args(words.split(' '));
    command
}

/// (exit code, standard output, standard error).
fn run(root: &Path, words: &str) -> (i32, String, String) {
    let output = nestd(root, words).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// A farm whose daemon ran before: a ledger with one waiting part.
fn farm() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let ledger = Ledger::open(&root.path().join("state/nestd.db")).await.unwrap();
        let part = NewPartRow {
            claim: "c1".into(),
            machine: "paper-200".into(),
            name: "fan.stl".into(),
            content_hash: "0".repeat(64),
            bytes: 684,
            copies: 2,
            terms: NewTerms {
                due_text: String::new(),
                order_name: "kit 7".into(),
                customer: String::new(),
                email: String::new(),
                material: String::new(),
                finish: String::new(),
                priority: 50,
                due_at: None,
                orientation: OrientationRule::Free,
                tilts: RequiredTilts::default(),
                clearance_mm: None,
                unit: None,
                read_unit: None,
                note: String::new(),
                mend_allowed_by: String::new(),
            },
            warnings: Vec::new(),
            ticket: None,
            dropped: Default::default(),
        };
        let id = ledger.record_claim(&part).await.unwrap().id;
        let solid = SolidFacts {
            request: None,
            copy_of: String::new(),
            question: String::new(),
            object_index: 0,
            object_name: String::new(),
            copies: 2,
            file_copies: 1,
            triangles: 12,
            volume_mm3: 1000.0,
            size_mm: [10.0, 20.0, 30.0],
            read_unit: build_file::LengthUnit::Millimeter,
            warnings: Vec::new(),
            mended: None,
        };
        ledger.accept_solids(id, &[solid]).await.unwrap();
        ledger.close().await;
    });
    root
}

#[test]
fn before_the_daemon_has_ever_run_a_question_fails_and_makes_no_ledger() {
    let root = tempfile::tempdir().unwrap();
    for words in ["status", "history", "show 1", "flush paper-200", "outcome 1 complete"] {
        let (code, out, err) = run(root.path(), words);
        assert_eq!((code, out.as_str()), (1, ""), "{words}");
        assert!(err.starts_with("nestd: there is no ledger at "), "{words}: {err}");
    }
    assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 0);
}

#[test]
fn wrong_use_is_exit_code_2() {
    let farm = farm();
    for words in ["flush nobody", "history --machine nobody", "history --since yesterday", "outcome 1 lost", "cancel x"]
    {
        let (code, out, err) = run(farm.path(), words);
        assert_eq!((code, out.as_str()), (2, ""), "{words}: {err}");
        assert!(!err.is_empty());
    }
    for words in ["history", "nest a.stl", "quote a.stl", "plan", "flush", "pause", "dismiss"] {
        let (code, _, err) = run(farm.path(), &format!("{words} --profile paper-200"));
        let is_named = err.contains("'--machine'") || err.contains("without an option: MACHINE");
        assert!(code == 2 && is_named, "{words}: the name of now: {err}");
    }
    let (code, _, err) = run(farm.path(), "-c /nowhere/nestd.toml status");
    assert_eq!(code, 2, "{err}");
}

#[test]
fn an_operator_sees_what_waits_and_that_nobody_works() {
    let farm = farm();
    let (code, out, _) = run(farm.path(), "status --parts");
    assert_eq!(code, 0);
    assert!(out.starts_with("The daemon does not run.\n"), "{out}");
    assert!(out.contains("collecting") && out.contains("fan.stl") && out.contains("mjf-5200"), "{out}");
    let (code, out, _) = run(farm.path(), "status --json");
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &json["daemon"]), (0, &serde_json::Value::Null));
    let paper = json["machines"].as_array().unwrap().iter().find(|p| p["machine"] == "paper-200").unwrap();
    assert_eq!((&paper["waiting_copies"], &paper["configured"]), (&2.into(), &true.into()));
    let (code, out, _) = run(farm.path(), "show kit 7");
    assert!(code == 0 && out.starts_with("Order kit 7"), "{out}");
    let (code, out, _) = run(farm.path(), "show p1 --json");
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &json["part"]["part"]["name"]), (0, &"fan.stl".into()));
    assert_eq!(run(farm.path(), "show build 1").0, 1);
}

#[test]
fn an_empty_history_is_empty_in_every_format() {
    let farm = farm();
    assert_eq!(run(farm.path(), "history").1, "No builds.\n");
    assert_eq!(run(farm.path(), "history --json --since 7d").1, "[]\n");
    let (code, csv, _) = run(farm.path(), "history --format csv --limit 5");
    assert!(
        code == 0
            && csv.starts_with("build,machine,printer,state,state_word,ends_at,at,published_at,withdrawn_at,height_mm"),
        "{csv}"
    );
}

#[test]
fn orders_are_noted_for_the_daemon_and_an_unknown_part_or_build_fails() {
    let farm = farm();
    for words in ["flush paper-200", "pause fuse-1", "resume fuse-1", "cancel 1", "scan"] {
        let (code, out, err) = run(farm.path(), words);
        assert_eq!(code, 0, "{words}: {err}");
        assert!(out.contains("will be done when it starts"), "{words}: {out}");
    }
    let (code, _, err) = run(farm.path(), "retry 9");
    assert_eq!((code, err.as_str()), (1, "nestd: there is no part 9\n"));
    let (code, _, err) = run(farm.path(), "outcome 9 complete --note x");
    assert_eq!((code, err.as_str()), (1, "nestd: there is no build 9\n"));
}

#[test]
fn a_machine_file_that_is_wrong_hides_neither_status_nor_history_and_forbids_orders() {
    let farm = farm();
    let config = farm.path().join("config");
    std::fs::create_dir_all(config.join("profiles")).unwrap();
    let root = format!("root = {:?}\n", farm.path());
    std::fs::write(config.join("nestd.toml"), &root).unwrap();
    std::fs::write(config.join("profiles/paper-200.toml"), "volume_mm = [200, 200, 200]\n").unwrap();
    std::fs::write(config.join("profiles/odd.toml"), "volume_mm = \"large\"\n").unwrap();
    let asked = |words: &str| {
        let mut command = Command::cargo_bin("nestd").unwrap();
        let output = command.arg("-c").arg(config.join("nestd.toml")).args(words.split(' ')).output().unwrap();
        (
            output.status.code().unwrap(),
            String::from_utf8(output.stdout).unwrap() + str::from_utf8(&output.stderr).unwrap(),
        )
    };
    for (words, expected) in
        [("status", "paper-200"), ("history", "No builds."), ("show fan.stl", "Part 1, fan.stl: waiting")]
    {
        let (code, text) = asked(words);
        assert!(code == 0 && text.contains(expected) && text.contains("odd.toml"), "{words}: {text}");
    }
    assert_eq!(asked("flush paper-200").0, 2);
    std::fs::write(config.join("nestd.toml"), root + "folders = 3\n").unwrap();
    assert_eq!(asked("status").0, 2, "where the ledger is must not be guessed");
}

#[test]
fn numbers_are_taken_as_show_takes_them() {
    let farm = farm();
    assert_eq!(run(farm.path(), "cancel p1").0, 0);
    assert_eq!(run(farm.path(), "outcome b9 complete").2, "nestd: there is no build 9\n");
    assert_eq!(run(farm.path(), "cancel b1").0, 2);
}

#[test]
fn nest_looks_at_its_outputs_before_any_work() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("part.stl"), "kept").unwrap();
    std::os::unix::fs::symlink("part.stl", dir.path().join("link.stl")).unwrap();
    std::fs::write(dir.path().join("list.csv"), "file\npart.stl\n").unwrap();
    let nest = |words: &str| {
        let mut command = Command::cargo_bin("nestd").unwrap();
        let output = command.arg("nest").args(words.split(' ')).current_dir(dir.path()).output().unwrap();
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    for (words, expected) in [
        ("part.stl -o ./part.stl", "a file that is read"),
        ("link.stl -o part.stl", "a file that is read"),
        ("--list list.csv -o o.3mf --report list.csv", "a file that is read"),
        ("part.stl -o o.3mf --stl ../DIR/part.stl", "a file that is read"),
        ("part.stl -o o.3mf --report ./o.3mf", "also -o"),
        ("part.stl -o o.3mf --report r --stl ../DIR/r", "also --report"),
        ("part.stl -o o.3mf --report nowhere/r.json", "there is no folder nowhere"),
        ("part.stl -o o.3mf --stl nowhere/r.stl", "there is no folder nowhere"),
        ("part.stl -o .", "name a file"),
    ] {
        let words = words.replace("DIR", dir.path().file_name().unwrap().to_str().unwrap());
        let (code, err) = nest(&format!("{words} --volume 50x50x50"));
        assert!(code == 2 && err.contains(expected), "{words}: {err}");
    }
    assert_eq!(std::fs::read_to_string(dir.path().join("part.stl")).unwrap(), "kept");
    let (code, err) = nest("part.stl -o o.3mf");
    assert!(code == 2 && err.contains("--machine") && err.contains("--volume"), "{err}");
}
