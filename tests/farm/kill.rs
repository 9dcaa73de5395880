//! kill -9 at random moments: no part lost, none in two builds, no build file twice.

use std::{
    collections::BTreeSet,
    fs,
    time::{Duration, Instant},
};

use nestd::{ledger::PartState, samples};
use rand::{RngExt, SeedableRng};

use super::support::{QUICK, TestFarm, stl};

/// Kills in an ordinary test run; `NESTD_KILLS` asks for more.
const KILLS: usize = 12;

#[test]
fn a_killed_farm_loses_nothing_and_prints_nothing_twice() {
    let kills = std::env::var("NESTD_KILLS").map_or(KILLS, |n| n.parse().unwrap());
    let profile = QUICK
        .replace("[120, 120, 120]", "[200, 200, 200]")
        .replace("final_secs = 0.5", "final_secs = 0.2")
        .replace("arrival_secs = 0.5", "arrival_secs = 0.2");
    let mut farm = TestFarm::new(&format!("{profile}duplicates = \"accept\"\n[trigger]\ncopies = 6\n"));
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let all = samples::all();
    let (mut dropped, mut taken) = (0, BTreeSet::new());
    let mut copies = 0;
    for round in 0..kills {
        farm.start();
        for _ in 0..rng.random_range(1..4) {
            let n = rng.random_range(1..4);
            let mesh = &all[rng.random_range(0..all.len())].mesh;
            farm.drop_bytes(&format!("part{dropped}_x{n}.stl"), &stl(mesh));
            dropped += 1;
            copies += n;
        }
        // A kill a few milliseconds after the start meets the recovery, a later one the work.
        let wait_ms = if round % 3 == 0 { rng.random_range(5..400) } else { rng.random_range(300..2500) };
        std::thread::sleep(Duration::from_millis(wait_ms));
        farm.kill();
        take_as_a_printer_does(&farm, &mut taken, round % 4 == 3);
    }
    farm.start();
    let began = Instant::now();
    loop {
        farm.flush();
        let built: usize = farm.parts(PartState::Built).iter().map(|p| p.copies as usize).sum();
        if built == copies {
            break;
        }
        assert!(began.elapsed().as_secs() < 120, "{built} of {copies} copies are built\n{}", farm.log());
        std::thread::sleep(Duration::from_millis(300));
    }
    take_as_a_printer_does(&farm, &mut taken, false);
    assert_eq!(farm.parts(PartState::Built).len(), dropped, "a drop was lost or doubled");
    assert!(farm.parts(PartState::Rejected).is_empty(), "{:#?}", farm.parts(PartState::Rejected));
    let faults = farm.ask(async |ledger| ledger.faults().await.unwrap());
    assert!(faults.is_empty(), "{faults:#?}");
    assert_eq!(taken.len(), copies, "copies in the published builds");
}

/// Notes every copy of every build file in the queue; with `remove`, the files go, as a printer takes them.
fn take_as_a_printer_does(farm: &TestFarm, taken: &mut BTreeSet<(String, u32, String)>, remove: bool) {
    for file in farm.queued() {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        for placed in nestd::format::read_build(&file, &Default::default()).unwrap() {
            let copy = (placed.part_number.unwrap(), placed.copy.unwrap());
            let elsewhere =
                taken.iter().find(|(part, number, build)| (part, *number) == (&copy.0, copy.1) && *build != name);
            assert!(elsewhere.is_none(), "copy {copy:?} is in {name} and in {elsewhere:?}");
            taken.insert((copy.0, copy.1, name.clone()));
        }
        if remove {
            fs::remove_file(&file).unwrap();
        }
    }
}
