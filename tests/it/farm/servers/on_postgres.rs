//! The farm with its ledger on a PostgreSQL server: the real binary, a private server.

use std::{fs, path::Path, process::Command};

use ledger::PartState;
use ledger_fixtures::postgres_cluster::PostgresCluster;

use crate::support::{MACHINE, QUICK, TestFarm, block, wait_until_or};

/// The factor by which a lease is shorter than in production.
const HURRY: &str = "10";

fn use_server(farm: &TestFarm, url: &str) {
    let config = fs::read_to_string(farm.config()).unwrap();
    fs::write(farm.config(), format!("{config}[folders]\nledger = {url:?}\n")).unwrap();
}

fn start(farm: &mut TestFarm) {
    let mut command = farm.command(&["run"]);
    command.env("NESTD_TEST_HURRY", HURRY);
    farm.start_as(command);
}

fn new_database(server: &PostgresCluster) -> String {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    server.url(&runtime.block_on(server.make_database(None)))
}

fn says(farm: &TestFarm, words: &str) {
    wait_until_or(&format!("the log says {words:?}"), 60.0, || farm.log(), || farm.log().contains(words));
}

fn failure(farm: &TestFarm, args: &[&str]) -> String {
    let output = farm.nestd(args);
    assert!(!output.status.success(), "{args:?} should fail");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_farm_on_a_server_takes_prints_and_tells() {
    let server = PostgresCluster::start();
    let mut farm = TestFarm::new(QUICK);
    use_server(&farm, &new_database(&server));
    start(&mut farm);
    farm.drop_part("bracket_x2.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    for (args, words) in [
        (&["status"][..], "The daemon"),
        (&["history"], MACHINE),
        (&["show", "b1"], "bracket_x2.stl"),
        (&["check"], "rows hold together"),
        (&["check", "--deep"], "I1 to I5 hold"),
        (&["metrics"], "nestd_"),
    ] {
        let text = farm.nestd_ok(args);
        assert!(text.contains(words), "{args:?}: {text}");
    }
    farm.assert_nothing_lost_or_doubled();
    farm.stop();
    // A restart finds everything.
    start(&mut farm);
    wait_until_or("it is open again", 60.0, || farm.log(), || farm.log().matches("The farm is open").count() == 2);
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
}

#[test]
fn while_its_server_is_away_the_farm_takes_nothing_and_afterwards_it_goes_on() {
    let server = PostgresCluster::start();
    let mut farm = TestFarm::new(QUICK);
    use_server(&farm, &new_database(&server));
    start(&mut farm);
    farm.drop_part("first.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    server.stop_server();
    says(&farm, "The server of the ledger cannot be reached");
    farm.drop_part("second.stl", &block(20.0, 20.0, 12.0));
    let told = farm.nestd(&["status"]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned() + &String::from_utf8_lossy(&told.stderr);
    assert!(told.contains("cannot be reached"), "{told}");
    std::thread::sleep(std::time::Duration::from_secs(3));
    assert!(farm.folder("inbox").join("second.stl").exists(), "it was taken without a ledger");
    server.start_server();
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.flush();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 2);
    farm.assert_nothing_lost_or_doubled();
    farm.stop();
}

#[test]
fn a_second_daemon_of_another_host_is_refused_until_the_first_has_gone() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let (mut first, second) = (TestFarm::new(QUICK), TestFarm::new(QUICK));
    use_server(&first, &url);
    use_server(&second, &url);
    start(&mut first);
    says(&first, "The farm is open");
    let told = failure(&second, &["run"]);
    assert!(
        told.contains("another nestd serves this ledger") && told.contains(&*first.root().to_string_lossy()),
        "{told}"
    );
    first.stop();
    let mut second = second;
    start(&mut second);
    says(&second, "The farm is open");
    second.stop();
}

#[test]
fn a_server_that_lost_the_last_changes_is_older_than_the_folders() {
    let server = PostgresCluster::start();
    let mut farm = TestFarm::new(QUICK);
    use_server(&farm, &new_database(&server));
    start(&mut farm);
    let backup = farm.root().join("early.backup");
    farm.nestd_ok(&["backup", &backup.to_string_lossy()]);
    farm.drop_part("later.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    farm.nestd_ok(&["ledger", "copy", &backup.to_string_lossy(), &new_url(&farm, &server)]);
    let told = failure(&farm, &["run"]);
    assert!(told.contains("older than the folders"), "{told}");
    farm.nestd_ok(&["check", "--deep", "--repair"]);
    start(&mut farm);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
}

#[test]
fn a_daemon_sees_at_once_that_a_standby_took_the_servers_place_without_the_last_changes() {
    let server = PostgresCluster::start();
    let mut farm = TestFarm::new(QUICK);
    use_server(&farm, &new_database(&server));
    start(&mut farm);
    farm.drop_part("early.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    server.keep_standby();
    farm.drop_part("late.stl", &block(20.0, 20.0, 12.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.flush();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 2);
    server.promote_standby();
    says(&farm, "has lost the last changes of this nestd");
    farm.drop_part("later.stl", &block(20.0, 20.0, 14.0));
    std::thread::sleep(std::time::Duration::from_secs(5));
    assert!(farm.folder("inbox").join("later.stl").exists(), "it was taken into a ledger that is too old");
    assert_eq!(farm.queued().len(), 1, "the parts were published twice");
    farm.stop();
    let told = failure(&farm, &["run"]);
    assert!(told.contains("older than the folders"), "{told}");
    farm.nestd_ok(&["check", "--deep", "--repair"]);
    start(&mut farm);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.wait_for_parts(PartState::Built, 2);
    farm.assert_nothing_lost_or_doubled();
    farm.stop();
}

/// Points the farm to another database, which is empty.
fn new_url(farm: &TestFarm, server: &PostgresCluster) -> String {
    let url = new_database(server);
    let config = fs::read_to_string(farm.config()).unwrap();
    let kept: Vec<&str> = config.lines().filter(|line| !line.starts_with("ledger = ")).collect();
    fs::write(farm.config(), format!("{}\nledger = {url:?}\n", kept.join("\n"))).unwrap();
    url
}

#[test]
fn a_farm_moves_to_a_server_and_back() {
    let server = PostgresCluster::start();
    let mut farm = TestFarm::new(QUICK);
    start(&mut farm);
    farm.drop_part("moved.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let (file, url) = (farm.root().join("state/nestd.db"), new_database(&server));
    let copy = |farm: &TestFarm, from: &Path, to: &str| farm.nestd_ok(&["ledger", "copy", &from.to_string_lossy(), to]);
    let refused = failure(&farm, &["ledger", "copy", &file.to_string_lossy(), &url]);
    assert!(refused.contains("another nestd serves"), "{refused}");
    farm.stop();
    let told = copy(&farm, &file, &url);
    assert!(told.contains("hold the same"), "{told}");
    let again = failure(&farm, &["ledger", "copy", &file.to_string_lossy(), &url]);
    assert!(again.contains("not empty"), "{again}");
    use_server(&farm, &url);
    start(&mut farm);
    farm.flush();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
    let back = farm.root().join("state/back.db");
    farm.nestd_ok(&["ledger", "copy", &url, &back.to_string_lossy()]);
    let config = fs::read_to_string(farm.config()).unwrap().replace(&format!("{url:?}"), "\"back.db\"");
    fs::write(farm.config(), config).unwrap();
    start(&mut farm);
    says(&farm, &format!("ledger={}", back.display()));
    farm.wait_for_parts(PartState::Built, 1);
    farm.assert_nothing_lost_or_doubled();
    farm.stop();
}

#[test]
fn no_password_is_in_a_log_or_an_answer() {
    let mut farm = TestFarm::new(QUICK);
    use_server(&farm, "postgres://farm:very-secret-word@localhost/nestd?host=/nonexistent");
    for args in [&["check"][..], &["status"], &["history"]] {
        let output = farm.nestd(args);
        let told = [output.stdout, output.stderr].concat();
        let told = String::from_utf8_lossy(&told);
        assert!(!told.contains("very-secret-word"), "{args:?}: {told}");
    }
    let mut daemon: Command = farm.command(&["run"]);
    daemon.env("NESTD_LOG", "trace,notify=error");
    let log = fs::File::create(farm.root().join("log")).unwrap();
    let mut child = daemon.stderr(log).spawn().unwrap();
    says(&farm, "cannot be reached");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!farm.log().contains("very-secret-word"), "{}", farm.log());
    farm.kill();
}
