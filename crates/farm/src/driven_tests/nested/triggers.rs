//! The triggers that fire a batch.

use ledger::PartState;

use crate::driven_tests::{HandDrivenFarm, QUICK, block};

#[test]
fn a_full_volume_fires_and_what_does_not_fit_stays_first_in_line() {
    let mut farm = HandDrivenFarm::open(&QUICK.replace("[120, 120, 120]", "[50, 50, 50]"));
    farm.drop_part("slab_x4.stl", &block(46.0, 46.0, 18.0));
    farm.wait_for_queued(1);
    let placed = build_file::read_build(&farm.queued()[0], &Default::default()).unwrap();
    assert_eq!(placed.len(), 2, "two slabs of 18 mm fit into 50 mm");
    farm.order(ledger::CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 1);
    farm.assert_nothing_lost_or_doubled();
    assert_eq!(farm.queued().len(), 2);
}

#[test]
fn enough_copies_fire() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ncopies = 5\n"));
    farm.drop_part("a_x4.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(60.0);
    assert!(farm.queued().is_empty());
    farm.drop_part("b.stl", &block(10.0, 11.0, 10.0));
    farm.wait_for_parts(PartState::Built, 2);
}

#[test]
fn a_part_that_has_waited_as_long_as_it_may_fires_and_not_before() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\nmax_wait_secs = 60\n"));
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(50.0);
    assert!(farm.queued().is_empty());
    farm.pass_secs(15.0);
    assert_eq!(farm.queued().len(), 1);
}

#[test]
fn a_near_due_date_fires() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ndue_margin_secs = \"2h\"\ngather_secs = 0\n"));
    farm.drop_bytes("a.stl.toml", b"due = 2020-01-01");
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_queued(1);
}

#[test]
fn a_build_that_reaches_its_share_of_the_height_fires() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\nfill_height = 0.5\n"));
    farm.drop_part("tall.stl", &block(100.0, 100.0, 70.0));
    farm.wait_for_queued(1);
}

/// Drops three overdue parts, half a minute apart.
fn drop_three_overdue_parts(farm: &mut HandDrivenFarm) {
    for (count, name) in ["a", "b", "c"].into_iter().enumerate() {
        farm.drop_bytes(&format!("{name}.stl.toml"), b"due = 2020-01-01");
        farm.drop_part(&format!("{name}.stl"), &block(10.0, 10.0 + count as f64, 10.0));
        farm.pass_secs(30.0);
    }
}

#[test]
fn overdue_parts_that_come_one_after_another_are_gathered_into_one_build() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ngather_secs = 60\n"));
    drop_three_overdue_parts(&mut farm);
    assert!(farm.queued().is_empty(), "the last part came 30 s ago");
    let status = farm.status_text();
    assert!(status.contains("It fires when full, or at ") && status.contains(" if nothing more arrives ("), "{status}");
    assert!(status.contains("with 3 copies, ") && status.contains(" mm high: deadline of a.stl"), "{status}");
    farm.wait_for_parts(PartState::Built, 3);
    assert_eq!(farm.queued().len(), 1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn without_gathering_each_overdue_part_has_a_build_of_its_own() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ngather_secs = 0\n"));
    drop_three_overdue_parts(&mut farm);
    farm.wait_for_parts(PartState::Built, 3);
    assert_eq!(farm.queued().len(), 3);
}

#[test]
fn gathering_goes_on_after_a_restart_and_a_flush_ends_it() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ngather_secs = \"10m\"\n"));
    farm.drop_bytes("a.stl.toml", b"due = 2020-01-01");
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(300.0);
    farm.stop();
    farm.start();
    farm.pass_secs(240.0);
    assert!(farm.queued().is_empty());
    farm.pass_secs(60.0);
    farm.wait_for_queued(1);
    farm.drop_bytes("b.stl.toml", b"due = 2020-01-01");
    farm.drop_part("b.stl", &block(10.0, 11.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(10.0);
    assert_eq!(farm.queued().len(), 1);
    farm.order(ledger::CommandKind::Flush, None);
    farm.wait_for_queued(2);
}

#[test]
fn a_drizzle_of_parts_does_not_hold_up_an_overdue_one_for_ever() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ngather_secs = 20\n"));
    farm.drop_bytes("a.stl.toml", b"due = 2020-01-01");
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    for number in 0..9 {
        farm.drop_part(&format!("drizzle {number}.stl"), &block(10.0, 11.0 + f64::from(number), 10.0));
        farm.pass_secs(12.0);
    }
    assert_eq!(farm.queued().len(), 1, "it fires after 80 s at the latest");
}

#[test]
fn overdue_parts_that_are_taken_back_one_after_another_are_gathered_too() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ngather_secs = 60\n"));
    farm.order_and_wait(ledger::CommandKind::Pause, None);
    let mut parts = Vec::new();
    for (count, name) in ["a", "b"].into_iter().enumerate() {
        farm.drop_bytes(&format!("{name}.stl.toml"), b"due = 2020-01-01");
        farm.drop_part(&format!("{name}.stl"), &block(10.0, 10.0 + count as f64, 10.0));
        parts.push(farm.wait_for_parts(PartState::Waiting, 1)[0].id);
        farm.order_and_wait(ledger::CommandKind::Cancel, parts.last().copied());
    }
    farm.order_and_wait(ledger::CommandKind::Resume, None);
    farm.wait_for_parts(PartState::Refused, 2);
    farm.pass_secs(100.0);
    for part in parts {
        farm.order_and_wait(ledger::CommandKind::Retry, Some(part));
        farm.pass_secs(20.0);
    }
    farm.wait_for_parts(PartState::Built, 2);
    assert_eq!(farm.queued().len(), 1);
}

#[test]
fn overdue_specks_that_are_confirmed_one_after_another_are_gathered_too() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ngather_secs = 60\n"));
    let mut parts = Vec::new();
    for (count, name) in ["a", "b"].into_iter().enumerate() {
        farm.drop_bytes(&format!("{name}.stl.toml"), b"due = 2020-01-01");
        farm.drop_part(&format!("{name}.stl"), &block(0.5, 0.4 + 0.1 * count as f64, 0.5));
        parts.push(farm.wait_for_parts(PartState::Waiting, count + 1)[count].id);
    }
    farm.pass_secs(100.0);
    for part in parts {
        farm.order_and_wait(ledger::CommandKind::Confirm, Some(part));
        farm.pass_secs(20.0);
    }
    farm.wait_for_parts(PartState::Built, 2);
    assert_eq!(farm.queued().len(), 1);
}

#[test]
fn overdue_parts_whose_originals_come_back_one_after_another_are_gathered_too() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ngather_secs = 60\n"));
    let size = |count: usize| block(10.0, 10.0 + count as f64, 10.0);
    let mut hashes = Vec::new();
    for count in 0..2 {
        farm.drop_bytes(&format!("{count}.stl.toml"), b"due = 2020-01-01");
        farm.drop_part(&format!("{count}.stl"), &size(count));
        let part = farm.wait_for_parts(PartState::Waiting, count + 1).remove(count);
        hashes.push(part.file.content_hash);
    }
    for file in intake::files_below(&farm.root().join("state/store")).unwrap() {
        if hashes.iter().any(|hash| file.to_string_lossy().contains(hash)) {
            std::fs::remove_file(file).unwrap();
        }
    }
    farm.ask(async |ledger| {
        for hash in &hashes {
            ledger.mark_damaged(hash, "it was removed").await.unwrap();
        }
    });
    farm.pass_secs(100.0);
    assert!(farm.queued().is_empty());
    for count in 0..2 {
        farm.drop_part(&format!("{count}.stl"), &size(count));
        farm.pass_secs(20.0);
    }
    farm.wait_for_parts(PartState::Built, 2);
    assert_eq!(farm.queued().len(), 1);
}
