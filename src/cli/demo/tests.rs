//! The demo's folder: what it writes, and what it leaves alone.

use super::*;

#[test]
fn a_folder_with_other_files_is_left_alone() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("thesis.txt"), "years of work").unwrap();
    let error = DemoFarm::prepare(dir.path()).unwrap_err();
    assert!(error.is::<Usage>(), "{error:#}");
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn a_second_demo_keeps_the_configuration_that_somebody_has_edited() {
    let dir = tempfile::tempdir().unwrap();
    let farm = DemoFarm::prepare(&dir.path().join("farm")).unwrap();
    fs::write(farm.config(), "# mine").unwrap();
    let again = DemoFarm::prepare(&dir.path().join("farm")).unwrap();
    assert_eq!(fs::read_to_string(again.config()).unwrap(), "# mine");
}

#[test]
fn the_configuration_is_a_valid_one() {
    let dir = tempfile::tempdir().unwrap();
    let farm = DemoFarm::prepare(&dir.path().join("a \"farm\"")).unwrap();
    let settings = crate::settings::load(Some(&farm.config()), None).unwrap();
    let profile = &settings.profiles[PROFILE];
    assert_eq!(settings.ledger, farm.ledger());
    assert_eq!((&profile.folders.inbox, &profile.folders.queue), (&farm.folder("inbox"), &farm.folder("queue")));
    assert_eq!(profile.folders.error, farm.folder("error"));
}

#[test]
fn at_least_twelve_kinds_are_dropped_with_a_ticket_an_order_and_a_torn_part() {
    let dir = tempfile::tempdir().unwrap();
    let farm = DemoFarm::prepare(dir.path()).unwrap();
    let dropped = farm.drop_parts().unwrap();
    let inbox = farm.folder("inbox");
    let files = files_of(&inbox, |name| name.ends_with(".stl")).unwrap();
    let order = files_of(&inbox.join("order-1042"), |name| name.ends_with(".stl")).unwrap();
    assert!(files.len() + order.len() == dropped.files && dropped.files > 12 && order.len() >= 2);
    assert!(inbox.join(TORN).exists() && inbox.join("knob.stl.toml").exists());
    assert!(files_of(&inbox, |name| name.starts_with('.')).unwrap().is_empty(), "half-written files are left");
}
