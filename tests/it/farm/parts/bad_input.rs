//! Bad input goes to the error folder with a reason, or gets a warning on the part; the daemon goes on.

use std::{fs, os::unix::net::UnixListener};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, stl, wait_until_or};

/// The reason file of a refused name.
fn reason(farm: &TestFarm, name: &str) -> String {
    let file = farm.folder("error").join(format!("{name}.reason.txt"));
    wait_until_or(&format!("{name} is refused"), 30.0, || farm.log(), || file.exists());
    fs::read_to_string(file).unwrap()
}

#[test]
fn what_cannot_be_printed_is_refused_with_a_reason_and_the_rest_goes_on() {
    let farm = TestFarm::running(&format!("{QUICK}duplicates = \"refuse\"\n"));
    let cube = stl(&block(10.0, 10.0, 10.0));
    farm.drop_bytes("torn.stl", &cube[..cube.len() - 30]);
    farm.drop_bytes("empty.stl", b"");
    farm.drop_bytes("letter.txt", b"Dear farm, please print a cube.");
    farm.drop_bytes("open.stl", &stl_without_last_triangle(&cube));
    farm.drop_part("large.stl", &block(130.0, 10.0, 125.0));
    let _socket = UnixListener::bind(farm.folder("inbox").join("socket.stl")).unwrap();
    fs::create_dir(farm.folder("inbox").join("folder.stl")).unwrap();
    std::os::unix::fs::symlink("/etc/hostname", farm.folder("inbox").join("link.stl")).unwrap();
    farm.drop_bytes("good.stl", &cube);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.drop_bytes("again.stl", &cube);

    for name in ["empty.stl", "letter.txt", "socket.stl", "link.stl", "folder.stl"] {
        assert!(reason(&farm, name).len() > 10, "{name}");
    }
    assert!(reason(&farm, "open.stl").contains("not closed"));
    let large = reason(&farm, "large.stl");
    assert!(large.contains("needs 125.0 x ") && large.contains("120 x 120 x 120"), "{large}");
    assert!(reason(&farm, "again.stl").contains("same file"));
    assert_eq!(farm.wait_for_parts(PartState::Waiting, 1)[0].name, "good.stl");
}

#[test]
fn a_broken_ticket_refuses_its_part_for_its_copies_are_not_known() {
    let farm = TestFarm::running(QUICK);
    farm.drop_bytes("cube.stl.toml", b"copies = \"many\"");
    farm.drop_part("cube.stl", &block(10.0, 10.0, 10.0));
    assert!(reason(&farm, "cube.stl").contains("copies"));
    let part = farm.parts(PartState::Refused).remove(0);
    let retry = farm.nestd(&["retry", &part.id.to_string()]);
    assert_eq!(retry.status.code(), Some(1), "its copies would be guessed");
    assert!(!reason(&farm, "cube.stl").contains("nestd retry"));
}

#[test]
fn a_refused_twin_can_be_taken_back_after_the_other_was_built() {
    let mut farm = TestFarm::running(QUICK);
    let cube = stl(&block(10.0, 10.0, 10.0));
    farm.drop_bytes("one.stl", &cube);
    farm.drop_bytes("two.stl", &cube);
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    let two = parts.iter().find(|p| p.name == "two.stl").unwrap().id.to_string();
    farm.nestd_ok(&["cancel", &two]);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
    farm.start();
    farm.nestd_ok(&["retry", &two]);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 2);
}

#[test]
fn a_ticket_says_copies_order_and_rule() {
    let farm = TestFarm::running(QUICK);
    farm.drop_bytes(
        "cube_x9.stl.toml",
        b"copies = 3\norder = \"A-17\"\npriority = 80\norientation = \"upright\"\nnot_down = [[1, 0, 0]]",
    );
    farm.drop_part("cube_x9.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!((part.owed.copies, part.terms.order_name.as_str(), part.terms.priority), (3, "A-17", 80));
    assert_eq!(part.terms.orientation, nester::OrientationRule::Upright);
    assert_eq!(part.terms.tilts.to_string(), "1,0,0:135");
}

#[test]
fn a_refused_part_is_taken_back_by_retry_once_the_cause_is_gone() {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("large.stl", &block(130.0, 10.0, 125.0));
    let part = farm.wait_for_parts(PartState::Refused, 1).remove(0);
    reason(&farm, "large.stl");
    farm.write_profile("test", &QUICK.replace("[120, 120, 120]", "[150, 150, 150]"));
    farm.reload();
    std::thread::sleep(std::time::Duration::from_millis(500));
    farm.nestd_ok(&["retry", &part.id.to_string()]);
    farm.wait_for_parts(PartState::Waiting, 1);
    let error = farm.folder("error");
    wait_until_or("the error folder is tidy", 5.0, || farm.log(), || !error.join("large.stl").exists());
}

fn stl_without_last_triangle(stl: &[u8]) -> Vec<u8> {
    let mut bytes = stl[..stl.len() - 50].to_vec();
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) - 1;
    bytes[80..84].copy_from_slice(&count.to_le_bytes());
    bytes
}
