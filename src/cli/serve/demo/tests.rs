//! The demo's folder: which files it writes, and which it leaves alone.

use super::*;

#[test]
fn a_folder_with_other_files_is_left_alone() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("thesis.txt"), "years of work").unwrap();
    let error = DemoFarm::open_or_make(dir.path()).unwrap_err();
    assert!(error.is::<UsageError>(), "{error:#}");
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn a_second_demo_keeps_the_configuration_that_somebody_has_edited() {
    let dir = tempfile::tempdir().unwrap();
    let farm = DemoFarm::open_or_make(&dir.path().join("farm")).unwrap();
    fs::write(farm.config_file(), "# mine").unwrap();
    let again = DemoFarm::open_or_make(&dir.path().join("farm")).unwrap();
    assert_eq!(fs::read_to_string(again.config_file()).unwrap(), "# mine");
}

#[test]
fn the_configuration_is_a_valid_one() {
    let dir = tempfile::tempdir().unwrap();
    let farm = DemoFarm::open_or_make(&dir.path().join("a \"farm\"")).unwrap();
    let settings = settings::load_settings(Some(&farm.config_file()), None).unwrap();
    let profile = &settings.profiles[MACHINE];
    assert_eq!(settings.ledger.file(), Some(&*farm.ledger_file()));
    assert_eq!(
        (&profile.folders.inbox, &profile.folders.queue),
        (&farm.machine_folder("inbox"), &farm.machine_folder("queue"))
    );
    assert_eq!(profile.folders.error, farm.machine_folder("error"));
}

#[test]
fn at_least_twelve_kinds_are_dropped_with_a_ticket_an_order_and_a_torn_part() {
    let dir = tempfile::tempdir().unwrap();
    let farm = DemoFarm::open_or_make(dir.path()).unwrap();
    let dropped = farm.drop_parts().unwrap();
    let inbox = farm.machine_folder("inbox");
    let files = matching_files(&inbox, |name| name.ends_with(".stl")).unwrap();
    let order = matching_files(&inbox.join("order-1042"), |name| name.ends_with(".stl")).unwrap();
    assert!(files.len() + order.len() == dropped.files && dropped.files > 12 && order.len() >= 2);
    assert!(inbox.join(TORN_FILE).exists() && inbox.join("knob.stl.toml").exists());
    assert!(matching_files(&inbox, |name| name.starts_with('.')).unwrap().is_empty(), "half-written files are left");
}
