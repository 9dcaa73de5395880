//! A farm with a dashboard is as safe as one without: requests delay nothing and lose nothing.

use std::{
    fs,
    io::{Read, Write},
    os::unix::net::UnixStream,
    time::Duration,
};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, wait_until_or};

/// A farm whose dashboard listens on a socket in its folder.
fn farm() -> TestFarm {
    let farm = TestFarm::new(QUICK);
    let config = fs::read_to_string(farm.config()).unwrap();
    let socket = farm.root().join("web.sock");
    fs::write(farm.config(), format!("{config}[web]\nlisten = \"unix:{}\"\n", socket.display())).unwrap();
    farm
}

/// Sends a request to the dashboard; `None` = no response within two seconds.
fn get(farm: &TestFarm, path: &str) -> Option<String> {
    let mut stream = UnixStream::connect(farm.root().join("web.sock")).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(2))).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").ok()?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).ok()?;
    Some(answer)
}

fn wait_for_dashboard(farm: &TestFarm) {
    let answers = || get(farm, "/healthz").is_some_and(|answer| answer.contains("alive"));
    wait_until_or("the dashboard answers", 30.0, || farm.log(), answers);
}

#[test]
fn a_lost_write_ahead_log_is_noticed_before_the_dashboard_looks() {
    let mut farm = farm();
    farm.start();
    farm.drop_part("block_x3.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.kill();
    fs::remove_file(farm.root().join("state/nestd.db-wal")).unwrap();
    let output = farm.nestd(&["run"]);
    let output_text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && output_text.contains("damaged"), "{output_text}");
}

#[test]
fn pages_stay_with_the_ledger_of_the_farm_when_another_is_configured() {
    let mut farm = farm();
    farm.start();
    wait_for_dashboard(&farm);
    farm.drop_part("block_x3.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let config = fs::read_to_string(farm.config()).unwrap();
    fs::write(farm.config(), format!("{config}[folders]\nstate = \"elsewhere\"\n")).unwrap();
    farm.reload();
    let is_told = || get(&farm, "/").is_some_and(|page| page.contains("the state folder cannot change"));
    wait_until_or("the page says that nothing of it applies", 20.0, || farm.log(), is_told);
    assert!(get(&farm, "/healthz").is_some_and(|answer| answer.contains("alive")));
    assert!(!farm.root().join("elsewhere").exists());
    farm.stop();
}

#[test]
fn curve_and_proved_order_stay_when_the_printer_has_emptied_its_folder_and_two_parts_share_a_name() {
    let mut farm = farm();
    farm.start();
    wait_for_dashboard(&farm);
    for (number, size) in [(1, 20.0), (2, 30.0)] {
        farm.drop_part("block.stl", &block(size, size, size));
        farm.wait_for_parts(PartState::Waiting, number);
    }
    farm.flush();
    let build = farm.wait_for_queued(1).remove(0);
    let report = build.to_string_lossy().replace(".build.3mf", ".report.json");
    wait_until_or("the report is there", 20.0, || farm.log(), || fs::exists(&report).unwrap());
    fs::remove_file(&build).unwrap();
    fs::remove_file(&report).unwrap();
    // A pipe in its place blocks nothing, either.
    rustix::fs::mkfifoat(rustix::fs::CWD, &report, rustix::fs::Mode::RWXU).unwrap();
    let sheet = get(&farm, "/api/v1/builds/1").expect("the build for machines");
    assert!(sheet.contains("\"curve\":[{\"wall_secs\":"), "{sheet}");
    assert!(get(&farm, "/builds/1").expect("its page").contains("Build 1 on test"));
    let map = get(&farm, "/builds/1/pick").expect("its pick map");
    assert!(map.contains("proved on the triangles") && map.matches(">up").count() == 2, "{map}");
    let list = get(&farm, "/api/v1/builds/1/pick").expect("the same for machines");
    assert!(list.contains("\"is_proved\":true") && list.contains("\"way\":["), "{list}");
    farm.stop();
}

#[test]
fn a_second_daemon_that_is_refused_leaves_the_first_ones_dashboard_alone() {
    let mut farm = farm();
    farm.start();
    wait_for_dashboard(&farm);
    for _ in 0..5 {
        assert!(!farm.nestd(&["run"]).status.success());
        assert!(get(&farm, "/").is_some_and(|page| page.contains("The daemon runs")));
    }
    farm.stop();
}

#[test]
fn four_hundred_who_connect_and_say_nothing_take_no_files_from_the_farm() {
    let mut farm = farm();
    farm.start_with_open_files(256);
    wait_for_dashboard(&farm);
    let connected = |_| {
        let mut stream = UnixStream::connect(farm.root().join("web.sock")).unwrap();
        stream.set_write_timeout(Some(Duration::from_secs(2))).unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: loc").unwrap();
        stream
    };
    let silent: Vec<UnixStream> = (0..400).map(connected).collect();
    let files = || fs::read_dir(format!("/proc/{}/fd", farm.pid())).unwrap().count();
    std::thread::sleep(Duration::from_secs(1));
    assert!(files() < 160, "{} files are open", files());
    farm.drop_part("block.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert!(!farm.log().contains("Too many open files"), "{}", farm.log());
    drop(silent);
    wait_for_dashboard(&farm);
    farm.stop();
}
