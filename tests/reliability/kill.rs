//! kill -9 at random moments under load: no part lost, none in two builds, no build file twice.

use std::{
    collections::BTreeSet,
    fs,
    time::{Duration, Instant},
};

use nestd::{ledger::PartState, samples};
use rand::{RngExt, SeedableRng};

use super::{
    budget::Budget,
    row::Row,
    support::{QUICK, TestFarm, stl},
};

/// What the section demands of a long run, and more when it has the time.
const KILLS: u64 = 2000;

pub fn run(budget: &Budget) -> Row {
    let profile = QUICK.replace("_secs = 0.5", "_secs = 0.1").replace("[120, 120, 120]", "[200, 200, 200]");
    let mut farm = TestFarm::new(&format!("{profile}duplicates = \"accept\"\n[trigger]\ncopies = 6\n"));
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let all = samples::all();
    let mut row = Row::default();
    let (mut taken, mut copies) = (BTreeSet::new(), 0);
    while budget.left_secs() > budget.secs * 0.3 && (!budget.is_long || row.faults < 10 * KILLS) {
        farm.start();
        for _ in 0..rng.random_range(0..3) {
            let n = rng.random_range(1..4);
            let mesh = &all[rng.random_range(0..all.len())].mesh;
            farm.drop_bytes(&format!("part{}_x{n}.stl", row.files), &stl(mesh));
            row.files += 1;
            copies += n;
        }
        let wait_ms = if row.faults % 2 == 0 { rng.random_range(5..200) } else { rng.random_range(200..1000) };
        std::thread::sleep(Duration::from_millis(wait_ms));
        farm.kill();
        row.faults += 1;
        take_as_a_printer_does(&farm, &mut taken, row.faults % 4 == 3, &mut row.broken);
    }
    run_to_the_end(&mut farm, copies, &mut row);
    take_as_a_printer_does(&farm, &mut taken, false, &mut row.broken);
    row.points = row.faults;
    row.builds = taken.iter().map(|(_, _, build)| build).collect::<BTreeSet<_>>().len() as u64;
    if farm.parts(PartState::Built).len() as u64 != row.files || taken.len() != copies {
        row.broken.push(format!("{copies} copies were dropped and {} are in published builds", taken.len()));
    }
    row.broken.extend(farm.ask(async |ledger| ledger.faults().await.unwrap()));
    row
}

fn run_to_the_end(farm: &mut TestFarm, copies: usize, row: &mut Row) {
    farm.start();
    let began = Instant::now();
    loop {
        farm.flush();
        let built: usize = farm.parts(PartState::Built).iter().map(|p| p.copies as usize).sum();
        if built == copies {
            return;
        }
        if began.elapsed().as_secs() > 120 {
            row.broken.push(format!("{built} of {copies} copies are built\n{}", farm.log()));
            return;
        }
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// Notes every copy of every build file in the queue; with `remove`, the files go, as a printer takes them.
fn take_as_a_printer_does(
    farm: &TestFarm,
    taken: &mut BTreeSet<(String, u32, String)>,
    remove: bool,
    broken: &mut Vec<String>,
) {
    for file in farm.queued() {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        for placed in nestd::format::read_build(&file, &Default::default()).unwrap() {
            let copy = (placed.part_number.unwrap(), placed.copy.unwrap());
            let elsewhere =
                taken.iter().find(|(part, number, build)| (part, *number) == (&copy.0, copy.1) && *build != name);
            if let Some(elsewhere) = elsewhere {
                broken.push(format!("copy {copy:?} is in {name} and in {elsewhere:?}"));
            }
            taken.insert((copy.0, copy.1, name.clone()));
        }
        if remove {
            fs::remove_file(&file).unwrap();
        }
    }
}
