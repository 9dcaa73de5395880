//! The life of a part: dropped, claimed, read, waiting, batched, nested, verified, published, history.

use std::{fs, io::Write};

use ledger::{CommandKind, PartState};

use crate::{
    alerts::alert::AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block, stl},
};

#[test]
fn the_originals_of_a_published_build_lie_in_the_archive_and_leave_the_inbox() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let bytes = stl(&block(10.0, 10.0, 10.0));
    farm.drop_bytes("order 7/cube.stl", &bytes);
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(part.terms.order_name, "order 7");
    farm.order(CommandKind::Flush, None);
    let file = farm.wait_for_queued(1).remove(0);
    let stem = file.file_name().unwrap().to_string_lossy().replace(".build.3mf", "");
    let archived = farm.folder("archive").join(stem).join("cube.stl");
    assert_eq!(fs::read(archived).unwrap(), bytes);
    let claims = fs::read_dir(farm.folder("inbox").join(".claimed")).unwrap();
    let left: Vec<_> = claims.map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| name.to_string_lossy().starts_with('.')), "{left:?}");
}

#[test]
fn a_file_that_is_still_being_written_is_taken_once_and_whole() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let bytes = stl(&sample_parts::lattice_block([2, 2, 2], 8.0, 2.0));
    let mut file = fs::File::create(farm.folder("inbox").join("slow.stl")).unwrap();
    for chunk in bytes.chunks(bytes.len() / 12 + 1) {
        file.write_all(chunk).unwrap();
        farm.pass_secs(0.25);
        assert!(farm.parts(PartState::Waiting).is_empty());
    }
    drop(file);
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(part.file.bytes, bytes.len() as u64);
}

#[test]
fn a_stopped_farm_goes_on_where_it_was() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x3.stl", &block(20.0, 30.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(1.5);
    farm.stop();
    farm.drop_part("b_x2.stl", &block(10.0, 10.0, 40.0));
    farm.start();
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 2);
    assert_eq!(farm.queued().len(), 1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_reload_adds_and_changes_machines_and_a_wrong_one_leaves_them_as_they_were() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.write_profile("second", QUICK);
    farm.reload();
    let inbox = farm.root().join("inbox/second");
    farm.pass_until("the new machine has its hot folder", |_| inbox.is_dir());
    fs::write(inbox.join("cube.stl"), stl(&block(10.0, 10.0, 10.0))).unwrap();
    assert_eq!(farm.wait_for_parts(PartState::Waiting, 1)[0].machine, "second");
    farm.write_profile("second", "volume_mm = \"wrong\"");
    farm.reload();
    assert!(farm.has_alert(AlertKind::ConfigurationWrong));
    farm.write_profile("second", &format!("{QUICK}[trigger]\ncopies = 1\n"));
    farm.reload();
    farm.wait_for_parts(PartState::Built, 1);
    assert!(!farm.has_alert(AlertKind::ConfigurationWrong));
}

#[test]
fn a_reload_takes_all_or_nothing() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.write_profile("going", QUICK);
    farm.reload();
    let (config, profiles) = (farm.root().join("config/nestd.toml"), farm.root().join("config/profiles"));
    let (text, before) = (fs::read_to_string(&config).unwrap(), farm.profiles().clone());
    // In each, one machine comes, one goes and one changes.
    fs::remove_file(profiles.join("going.toml")).unwrap();
    farm.write_profile("coming", QUICK);
    farm.write_profile(MACHINE, &QUICK.replace("clearance_mm = 2.0", "clearance_mm = 3.0"));
    for (of_farm, of_last, told) in [
        ("[log]\nfilter = \"debug\"\n", "volume_mm = \"wrong\"", "last.toml:1"),
        ("[log]\nfilter = 3\n", QUICK, "nestd.toml:"),
        ("[node]\nname = \"other\"\n", QUICK, "node.name cannot change while the daemon runs"),
        ("[folders]\nstate = \"elsewhere\"\n", QUICK, "the state folder cannot change while the daemon runs"),
        (
            "[folders]\nledger = \"postgres://db.example/farm\"\n",
            QUICK,
            "the ledger cannot change while the daemon runs",
        ),
    ] {
        fs::write(&config, format!("{text}{of_farm}")).unwrap();
        farm.write_profile("last", of_last);
        farm.reload();
        let alert = farm.alert_text(AlertKind::ConfigurationWrong);
        assert!(alert.contains("nothing of it applies") && alert.contains(told), "{alert}");
        farm.pass_secs(2.0);
        assert_eq!(farm.profiles(), &before, "{told}");
        assert!(!farm.folder_of("inbox", "coming").exists() && farm.folder_of("inbox", "going").exists(), "{told}");
    }
    fs::write(&config, text).unwrap();
    farm.reload();
    assert!(!farm.has_alert(AlertKind::ConfigurationWrong));
    assert_eq!(farm.profiles().keys().collect::<Vec<_>>(), ["coming", "last", MACHINE]);
}

#[test]
fn a_machine_whose_folders_cannot_be_made_does_not_stop_the_others() {
    let mut farm = HandDrivenFarm::closed(QUICK);
    fs::write(farm.root().join("file"), "in the way").unwrap();
    let elsewhere = farm.root().join("file/queue");
    farm.write_profile("broken", &format!("{QUICK}[folders]\nqueue = {:?}\n", elsewhere.to_str().unwrap()));
    farm.start();
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    assert!(farm.has_alert(AlertKind::FoldersMissing));
}

#[test]
fn a_build_that_is_given_up_pauses_its_machine_and_is_told_until_that_is_resumed() {
    let profile = QUICK.replace("max_attempts = 50", "max_attempts = 1");
    let mut farm = HandDrivenFarm::open(&profile);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    // The new build volume is too small for the part.
    let parts = farm.parts(PartState::Waiting);
    let copies: Vec<_> = parts.iter().flat_map(|part| (0..part.owed.copies).map(|copy| (part.id, copy))).collect();
    farm.write_profile(MACHINE, &profile.replace("[120, 120, 120]", "[10, 10, 10]"));
    farm.ask(async |ledger| {
        let build = ledger.open_build(MACHINE).await.unwrap().id;
        ledger.begin_nesting(build, "a test", &copies).await.unwrap();
    });
    farm.reload();
    farm.pass_until("it is given up", |farm| farm.has_alert(AlertKind::BuildFailed));
    assert_eq!(farm.ask(async |ledger| ledger.paused_machines().await.unwrap()), [MACHINE]);
    farm.order_and_wait(CommandKind::Resume, None);
    farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::BuildFailed));
}
