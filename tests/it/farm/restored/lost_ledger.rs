//! A ledger that is gone, or that somebody put there by hand: what is told is true, and what is asked for works.

use std::{
    fs,
    os::unix::net::UnixDatagram,
    path::Path,
    sync::mpsc,
    time::{Duration, Instant},
};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, http::send_request, wait_until, wait_until_or};

/// A farm with one waiting part.
fn farm_with_waiting_part() -> TestFarm {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm
}

fn all_output(farm: &TestFarm, args: &[&str]) -> String {
    let output = farm.nestd(args);
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

#[test]
fn a_backup_that_is_not_there_is_not_called_damaged() {
    let mut farm = farm_with_waiting_part();
    farm.stop();
    for (named, said) in [(farm.root().join("gone.backup"), "reading the backup"), (farm.folder("queue"), "is no file")]
    {
        let output = all_output(&farm, &["restore", named.to_str().unwrap()]);
        assert!(output.contains(said) && !output.contains("damaged"), "{output}");
    }
    assert_eq!(farm.parts(PartState::Waiting).len(), 1, "the ledger was touched");
}

#[test]
fn a_ledger_that_was_removed_is_told_truly_everywhere_and_the_saved_copy_is_put_back() {
    let mut farm = farm_with_waiting_part();
    let state = farm.root().join("state");
    for file in fs::read_dir(&state).unwrap().map(|entry| entry.unwrap().path()) {
        if file.file_name().unwrap().to_string_lossy().starts_with("nestd.db") {
            fs::remove_file(file).unwrap();
        }
    }
    wait_until_or(
        "it is noticed",
        20.0,
        || farm.log(),
        || farm.log().contains("removed, replaced or overwritten while nestd ran"),
    );
    let status_txt = farm.folder("inbox").join("STATUS.txt");
    let status_text = || fs::read_to_string(&status_txt).unwrap_or_default();
    wait_until_or("STATUS.txt tells it", 20.0, status_text, || status_text().contains("is not scanned"));
    assert!(status_text().contains("ATTENTION") && !status_text().contains("Nothing waits"), "{}", status_text());
    for command in [&["status"][..], &["show", "1"], &["flush", "test"]] {
        let said = all_output(&farm, command);
        assert!(said.contains("A daemon runs") && !said.contains("makes it"), "{said}");
    }
    farm.stop();
    assert!(
        status_text().contains("ATTENTION") && !status_text().contains("taken when it runs again"),
        "{}",
        status_text()
    );
    assert!(all_output(&farm, &["status"]).contains("No daemon runs, and none starts"));
    let said = all_output(&farm, &["check"]);
    let (_, rest) = said.split_once("nestd saved all that it knew as ").unwrap();
    let saved = rest.split_once(", which is newer").unwrap().0;
    farm.nestd_ok(&["restore", saved]);
    farm.start();
    wait_until_or("it is open", 20.0, || farm.log(), || farm.log().matches("The farm is open").count() == 2);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
}

#[test]
fn a_backup_that_was_copied_over_a_sealed_ledger_is_answered_with_what_works() {
    let mut farm = farm_with_waiting_part();
    let backup = farm.root().join("backup");
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.drop_part("b.stl", &block(10.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.stop();
    fs::copy(&backup, farm.root().join("state/nestd.db")).unwrap();
    let said = all_output(&farm, &["check"]);
    assert!(said.contains("nestd restore FILE") && !said.contains("--repair"), "{said}");
    farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    farm.start();
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.stop();
}

#[test]
fn a_part_whose_file_is_gone_is_not_said_to_be_taken_back_by_retry() {
    let mut farm = farm_with_waiting_part();
    let backup = farm.root().join("backup");
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.flush();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    let store = farm.root().join("state/store");
    let is_empty = || intake::files_below(&store).is_ok_and(|files| files.is_empty());
    wait_until_or("the store has forgotten it", 20.0, || farm.log(), is_empty);
    farm.stop();
    for kind in ["queue", "archive"] {
        for entry in fs::read_dir(farm.folder(kind)).unwrap().map(Result::unwrap) {
            if !entry.file_name().to_string_lossy().starts_with('.') {
                let path = entry.path();
                if path.is_dir() { fs::remove_dir_all(path).unwrap() } else { fs::remove_file(path).unwrap() }
            }
        }
    }
    let said = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(said.contains("drop its file again") && !said.contains("nestd retry") && !said.contains(".."), "{said}");
    let said = all_output(&farm, &["check", "--deep"]);
    assert!(!said.contains("PROBLEM I4") && !said.contains("PROBLEM invariants: I4"), "{said}");
}

/// When the daemon gave the service manager signs of life.
fn hear_signs_of_life(socket: &Path) -> mpsc::Receiver<Instant> {
    let listener = UnixDatagram::bind(socket).unwrap();
    let (heard, signs) = mpsc::channel();
    std::thread::spawn(move || {
        let mut message = [0; 1024];
        while let Ok(length) = listener.recv(&mut message) {
            if message[..length].windows(8).any(|words| words == b"WATCHDOG") && heard.send(Instant::now()).is_err() {
                break;
            }
        }
    });
    signs
}

/// A start that waits for a process that holds the ledger: everybody names it from the first moment on, and between two attempts.
fn assert_start_names(farm: &TestFarm, named: &str) {
    let looks_until = Instant::now() + Duration::from_secs(45);
    wait_until("it has begun", 30.0, || !all_output(farm, &["status"]).contains("does not run"));
    while Instant::now() < looks_until {
        for told in [all_output(farm, &["status"]), all_output(farm, &["check"])] {
            assert_eq!(told.matches(named).count(), 1, "{told}");
            assert!(!told.contains("disk") && !told.contains("does not run"), "{told}");
        }
        std::thread::sleep(Duration::from_millis(700));
    }
    let status = farm.folder("inbox").join("STATUS.txt");
    wait_until("the hot folder says so", 30.0, || fs::read_to_string(&status).unwrap().contains(named));
    let told = fs::read_to_string(&status).unwrap();
    assert!(told.matches(named).count() == 1 && !told.contains("disk"), "{told}");
}

/// A lock is held far longer than the time within which the service manager wants a sign of life would allow for each change that waits.
#[test]
fn a_process_that_holds_the_ledger_is_named_and_the_daemon_tells_the_service_manager_that_it_lives() {
    let mut farm = TestFarm::new(QUICK);
    let (socket, pages) = (farm.root().join("notify"), farm.root().join("web.sock"));
    let config = fs::read_to_string(farm.config()).unwrap();
    fs::write(farm.config(), format!("{config}[web]\nlisten = \"unix:{}\"\n", pages.display())).unwrap();
    let signs = hear_signs_of_life(&socket);
    let mut command = farm.command(&["run"]);
    command.env("NOTIFY_SOCKET", &socket);
    farm.start_as(command);
    let named = format!("process {} (", std::process::id());
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    // The connection is closed in it, also when an assertion fails.
    let _context = runtime.enter();
    let path = format!("sqlite:{}", farm.root().join("state/nestd.db").display());
    let pool = runtime.block_on(sqlx::SqlitePool::connect(&path)).unwrap();
    let mut holder = runtime.block_on(pool.acquire()).unwrap();
    runtime.block_on(sqlx::raw_sql("BEGIN IMMEDIATE").execute(&mut *holder)).unwrap();
    // Before the daemon itself has given up, too.
    let checked = all_output(&farm, &["check"]);
    assert!(checked.contains(&named) && !checked.contains("No problem found"), "{checked}");
    farm.drop_part("b.stl", &block(21.0, 20.0, 10.0));
    let flush = farm.command(&["flush", "test"]).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut last = Instant::now();
    std::thread::sleep(Duration::from_secs(25));
    let mut silence = Duration::ZERO;
    for sign in signs.try_iter().filter(|sign| *sign > last).collect::<Vec<_>>() {
        silence = silence.max(sign - last);
        last = sign;
    }
    silence = silence.max(last.elapsed());
    let checked = all_output(&farm, &["check"]);
    assert!(checked.contains(&named) && !checked.contains("No problem found"), "{checked}");
    let told = all_output(&farm, &["status"]);
    assert!(told.contains("keeps the ledger from being changed") && told.contains(&named), "{told}\n{}", farm.log());
    let page = send_request(&pages, "GET /", b"").unwrap().body;
    assert!(page.contains("has not written") && page.contains(&named) && !page.contains("disk"), "{page}");
    assert!(silence < Duration::from_secs(5), "it gave no sign of life for {silence:?}\n{}", farm.log());
    let flush = flush.wait_with_output().unwrap();
    let refused = String::from_utf8_lossy(&flush.stderr);
    assert!(!flush.status.success() && refused.contains(&named) && !refused.contains("locked"), "{refused}");
    runtime.block_on(sqlx::raw_sql("ROLLBACK").execute(&mut *holder)).unwrap();
    farm.wait_for_parts(PartState::Waiting, 2);
    // A search whose end the ledger did not take is begun again after a while, and a flush waits for it.
    wait_until_or("it is flushed", 120.0, || farm.log(), || farm.nestd(&["flush", "test"]).status.success());
    farm.wait_for_parts(PartState::Built, 2);
    farm.assert_nothing_lost_or_doubled();
    farm.stop();
    // A start waits as well, and everybody names the same reason, once.
    runtime.block_on(sqlx::raw_sql("BEGIN IMMEDIATE").execute(&mut *holder)).unwrap();
    let before = farm.log().len();
    farm.start();
    assert_start_names(&farm, &named);
    let log = farm.log().split_off(before);
    assert_eq!(log.matches(&named).count(), 1, "{log}");
    runtime.block_on(sqlx::raw_sql("ROLLBACK").execute(&mut *holder)).unwrap();
    wait_until("the farm is open", 60.0, || farm.log()[before..].contains("The farm is open"));
    wait_until("it is over", 30.0, || !all_output(&farm, &["status"]).contains(&named));
}
