//! The status texts of the farm are true: while it runs, after it has stopped, and for cancelled and dismissed parts.

use std::fs;

use ledger::PartState;

use crate::support::{MACHINE, QUICK, TestFarm, block, stl, wait_until_or};

fn read_status(farm: &TestFarm) -> (String, serde_json::Value) {
    let read = |name: &str| fs::read_to_string(farm.folder("inbox").join(name)).unwrap_or_default();
    (read("STATUS.txt"), serde_json::from_str(&read("status.json")).unwrap_or_default())
}

/// Waits until the output of `status` contains the words, or no longer contains them.
fn status_says(farm: &TestFarm, words: &str, is_said: bool) {
    let status = || farm.nestd_ok(&["status"]);
    let what = format!("status says {words:?}: {is_said}");
    wait_until_or(&what, 20.0, || format!("{}\n{}", status(), farm.log()), || status().contains(words) == is_said);
}

#[test]
fn the_status_files_say_of_when_they_are_and_that_nobody_looks_after_a_stop() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let promises = || read_status(&farm).0.contains("It fires");
    wait_until_or("STATUS.txt promises a build", 20.0, || read_status(&farm).0, promises);
    let (text, json) = read_status(&farm);
    assert!(text.contains("1 copy of 1 part waits.") && text.contains("Written 20"), "{text}");
    assert!(text.contains("renewed at least every 2 minutes while nestd runs"), "{text}");
    assert!(
        json["running"] == true && json["renewed_within_secs"] == 120 && json["written_at"].is_string(),
        "{json:#}"
    );
    farm.stop();
    let (text, json) = read_status(&farm);
    assert!(text.contains("nestd was stopped on 20") && text.contains("this folder is not scanned"), "{text}");
    assert!(!text.contains("fires") && text.contains("1 copy of 1 part waits until then."), "{text}");
    assert!(json["running"] == false && json["fires_at_latest"].is_null() && json["waiting_copies"] == 1, "{json:#}");
    farm.start();
    wait_until_or("it looks again", 20.0, || farm.log(), || read_status(&farm).1["running"] == true);
    farm.kill();
    assert!(read_status(&farm).0.contains("if this is older, nestd is not running"));
}

#[test]
fn what_was_cancelled_needs_nobody_and_promises_nothing() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    status_says(&farm, "10.00 mm, 1 copy", true);
    assert!(farm.nestd_ok(&["status"]).contains("1 machine, 1 copy waits, 0 builds in work"));
    farm.nestd_ok(&["cancel", &part.id.to_string()]);
    let status = farm.nestd_ok(&["status"]);
    assert!(status.contains("0 copies wait") && !status.contains("10.00 mm"), "{status}");
    std::thread::sleep(std::time::Duration::from_secs(4));
    let status = farm.nestd_ok(&["status"]);
    assert!(!status.contains("a person") && !read_status(&farm).0.contains("ATTENTION"), "{status}");
    farm.stop();
}

#[test]
fn a_refused_file_needs_a_person_until_one_has_seen_it() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_bytes("order-7/drawing.pdf", b"%PDF-1.4 a drawing");
    status_says(&farm, "Refused files lie in the error folder: 1 file in", true);
    let reason = fs::read_to_string(farm.folder("error").join("order-7/drawing.pdf.reason.txt")).unwrap();
    assert!(reason.contains("It holds no shape to print: drop the part as STL or 3MF."), "{reason}");
    farm.nestd_ok(&["dismiss", MACHINE]);
    status_says(&farm, "Refused files", false);
    assert!(farm.folder("error").join("order-7/drawing.pdf").exists());
    farm.drop_bytes("b.stl", b"");
    status_says(&farm, "1 file in", true);
    farm.stop();
}

#[test]
fn the_same_file_in_another_unit_is_no_more_copies() {
    let mut farm = TestFarm::running(QUICK);
    let bytes = stl(&block(3.0, 2.0, 1.0));
    farm.drop_bytes("a.stl", &bytes);
    farm.wait_for_parts(PartState::Waiting, 1);
    for (name, ticket, expected) in
        [("b.stl", "unit = \"mm\"", "taken as more copies"), ("c.stl", "unit = \"inch\"", "another unit")]
    {
        fs::write(farm.folder("inbox").join(format!("{name}.toml")), ticket).unwrap();
        farm.drop_bytes(name, &bytes);
        let waiting = farm.wait_for_parts(PartState::Waiting, if name == "b.stl" { 2 } else { 3 });
        let part = waiting.iter().find(|part| part.name == name).unwrap();
        assert!(part.warnings.contains(expected), "{name}: {}", part.warnings);
    }
    farm.stop();
}
