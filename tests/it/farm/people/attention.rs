//! Problems that need a person are shown in `nestd status`, in STATUS.txt and in the journal, with a remedy; nothing
//! else is logged as an error.

use std::{fs, os::unix::fs::FileExt, path::Path};

use farm::{AlertKind, FarmAlert};
use ledger::{BuildState, PartState};

use crate::support::{MACHINE, QUICK, TestFarm, block, leaning_block, wait_until, wait_until_or};

const SECOND: &str = "second";

/// A farm with two machines, so that one can show problems when the other's hot folder is not available.
fn farm(profile: &str) -> TestFarm {
    let farm = TestFarm::new(profile);
    farm.write_profile(SECOND, QUICK);
    farm
}

/// Waits until a kind is shown in all three places; `machine` is the machine whose STATUS.txt is read.
fn is_reported_everywhere(farm: &TestFarm, kind: AlertKind, machine: &str) {
    let status = farm.root().join("inbox").join(machine).join("STATUS.txt");
    let is_named_in = |text: &str| text.contains(&kind.headline()) && text.contains(&kind.remedy());
    let now = || {
        let file = fs::read_to_string(&status).unwrap_or_default();
        let command = farm.nestd(&["status"]);
        (String::from_utf8_lossy(&command.stdout).into_owned(), file, farm.log())
    };
    wait_until_or(
        &format!("{kind:?} is told"),
        40.0,
        || format!("{:#?}", now()),
        || {
            let (command, file, log) = now();
            let logged = log.lines().any(|line| line.contains("ERROR") && is_named_in(line));
            is_named_in(&command) && is_named_in(&file) && logged
        },
    );
}

/// Waits until no problem is left.
fn is_over(farm: &TestFarm, kind: AlertKind) {
    wait_until_or(
        &format!("{kind:?} is over"),
        40.0,
        || farm.log(),
        || !farm.nestd_ok(&["status"]).contains(&kind.headline()),
    );
}

#[test]
fn every_kind_is_reported_by_status_with_its_remedy() {
    let farm = TestFarm::new(QUICK);
    let state = farm.root().join("state");
    fs::create_dir(&state).unwrap();
    for kind in AlertKind::ALL {
        let notice = FarmAlert {
            node: String::new(),
            kind,
            machine: "test".into(),
            detail: "just\u{1b}[2J so".into(),
            since: jiff::Timestamp::now(),
        };
        let text = serde_json::to_string(&[notice]).unwrap();
        fs::write(state.join("attention.json"), text).unwrap();
        // The problem is shown although there is no ledger.
        for args in [&["status"][..], &["status", "--json"]] {
            let output = farm.nestd(args);
            let output_text = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(
                output_text.contains(&kind.headline()) && output_text.contains(&kind.remedy()[..20]),
                "{output_text}"
            );
            assert!(!output_text.contains('\u{1b}'), "an escape sequence came through");
        }
    }
}

#[test]
fn the_document_lists_every_kind_with_its_remedy() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/symptoms.md")).unwrap();
    let missing: Vec<String> = (AlertKind::ALL.iter())
        .map(|kind| format!("- **{}.** {}\n", kind.headline(), kind.remedy()))
        .filter(|row| !text.contains(row))
        .collect();
    assert!(missing.is_empty(), "docs/symptoms.md lacks these rows:\n{}", missing.join("\n"));
}

#[test]
fn nothing_else_is_logged_as_an_error() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = ["src", "crates/farm/src", "crates/settings/src", "crates/delivery/src"]
        .map(|sources| intake::files_below(&root.join(sources)).unwrap())
        .concat();
    let logs = |file: &&std::path::PathBuf| {
        let text = fs::read_to_string(file).unwrap_or_default();
        text.lines().any(|line| line.trim_start().trim_start_matches("tracing::").starts_with(concat!("error", "!(")))
    };
    let found: Vec<_> =
        files.iter().filter(|file| !file.ends_with("src/alerts/alert_registry.rs")).filter(logs).collect();
    assert!(found.is_empty(), "these log errors of their own: {found:?}");
}

#[test]
fn folders_that_are_away_and_refused_and_stray_files_are_reported_until_it_is_over() {
    let mut farm = farm(QUICK);
    fs::create_dir_all(farm.root().join("queue")).unwrap();
    fs::write(farm.folder("queue"), "a file in its place").unwrap();
    farm.start();
    farm.drop_bytes("torn.stl", b"solid torn");
    fs::write(farm.root().join("inbox/forgotten.stl"), "x").unwrap();
    is_reported_everywhere(&farm, AlertKind::QueueAway, SECOND);
    is_reported_everywhere(&farm, AlertKind::Stray, SECOND);
    is_reported_everywhere(&farm, AlertKind::Refused, "test");
    fs::remove_file(farm.folder("queue")).unwrap();
    fs::remove_file(farm.root().join("inbox/forgotten.stl")).unwrap();
    fs::remove_dir_all(farm.folder("error")).unwrap();
    fs::create_dir(farm.folder("error")).unwrap();
    fs::write(farm.folder("error").join(".nestd-owner"), "").unwrap();
    is_over(&farm, AlertKind::QueueAway);
    is_over(&farm, AlertKind::Stray);
    is_over(&farm, AlertKind::Refused);
    fs::rename(farm.folder("inbox"), farm.root().join("elsewhere")).unwrap();
    fs::write(farm.folder("inbox"), "a file in its place").unwrap();
    is_reported_everywhere(&farm, AlertKind::HotFolderAway, SECOND);
}

#[test]
fn a_build_that_is_given_up_is_reported_until_its_machine_is_resumed_also_after_a_restart() {
    let profile = QUICK.replace("max_attempts = 50", "max_attempts = 1");
    let mut farm = TestFarm::new(&profile.replace("final_secs = 0.5", "final_secs = 60"));
    farm.start();
    farm.drop_part("a.stl", &leaning_block());
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    let is_fired =
        || !farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Nesting).await).unwrap().is_empty();
    wait_until("the build is fired", 20.0, is_fired);
    farm.kill();
    // The machine has become too small for the build that is being nested.
    farm.write_profile(MACHINE, &profile.replace("[120, 120, 120]", "[10, 10, 10]"));
    farm.start();
    is_reported_everywhere(&farm, AlertKind::BuildFailed, "test");
    farm.wait_for_parts(PartState::Refused, 1);
    farm.stop();
    fs::write(farm.root().join("log"), "").unwrap();
    farm.write_profile(MACHINE, &profile);
    farm.start();
    is_reported_everywhere(&farm, AlertKind::BuildFailed, "test");
    farm.nestd_ok(&["resume", "test"]);
    is_over(&farm, AlertKind::BuildFailed);
    farm.nestd_ok(&["retry", "1"]);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
}

#[test]
fn a_wrong_configuration_and_a_machine_that_is_gone_are_reported() {
    let mut farm = farm(QUICK);
    farm.start();
    let inbox = farm.root().join("inbox").join(SECOND);
    wait_until_or("the second hot folder", 20.0, || farm.log(), || inbox.is_dir());
    fs::write(inbox.join("x.stl"), crate::support::stl(&block(20.0, 20.0, 20.0))).unwrap();
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.write_profile(SECOND, "volume_mm = \"wrong\"");
    farm.reload();
    is_reported_everywhere(&farm, AlertKind::ConfigurationWrong, "test");
    fs::remove_file(farm.root().join("config/profiles/second.toml")).unwrap();
    farm.reload();
    is_reported_everywhere(&farm, AlertKind::MachineGone, "test");
    is_over(&farm, AlertKind::ConfigurationWrong);
    farm.write_profile(SECOND, QUICK);
    farm.reload();
    is_over(&farm, AlertKind::MachineGone);
}

#[test]
fn a_ledger_that_is_damaged_under_the_daemon_halts_it_and_nothing_is_taken_any_more() {
    let mut farm = TestFarm::running(QUICK);
    for n in 0..5 {
        farm.drop_part(&format!("a{n}.stl"), &block(20.0, 20.0, 20.0 + f64::from(n)));
    }
    farm.wait_for_parts(PartState::Waiting, 5);
    let path = farm.root().join("state/nestd.db");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let pool = sqlx::SqlitePool::connect(&format!("sqlite:{}", path.display())).await.unwrap();
        sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(&pool).await.unwrap();
        let file = fs::File::options().write(true).open(&path).unwrap();
        let bytes = file.metadata().unwrap().len();
        for page in 1..bytes / 4096 {
            file.write_all_at(&[0x55; 4096], page * 4096).unwrap();
        }
        pool.close().await;
    });
    farm.drop_part("late.stl", &block(10.0, 20.0, 20.0));
    is_reported_everywhere(&farm, AlertKind::LedgerDamaged, "test");
    farm.drop_part("later.stl", &block(11.0, 20.0, 20.0));
    std::thread::sleep(std::time::Duration::from_secs(3));
    assert!(farm.folder("inbox").join("later.stl").exists(), "it was taken\n{}", farm.log());
    farm.stop();
    assert!(!farm.root().join("state/nestd.db.b3").exists(), "a damaged ledger was sealed");
    let refused = farm.nestd(&["run"]);
    assert!(!refused.status.success());
    let status_text = fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap();
    assert!(status_text.contains("does not run") && status_text.contains("nestd restore"), "{status_text}");
}
