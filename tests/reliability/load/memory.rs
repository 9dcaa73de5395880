//! Files that need all available memory to read. With a limit on its address space the daemon ends and is restarted, as
//! the service manager does; at last it refuses such a file with the reason and prints the other parts.

use std::{thread, time::Duration};

use ledger::PartState;

use crate::{
    harness::{SectionBudget, SectionResult},
    support::{MACHINE, QUICK, TestFarm, block, greedy},
};

/// Address space of the daemon, bytes, and memory limit of a separate reading process. The files need more than either.
const MEMORY: u64 = 400 << 20;
const FARM: &str = "scan_secs = 0.5\n[limits]\nread_memory_bytes = 536870912\n[log]\nfilter = \"info\"\n";
/// Number of starts per file after which the daemon must keep running: each file ends it at most twice.
const STARTS_PER_FILE: u64 = 2;
/// Time limit of a farm, seconds.
const PATIENCE: f64 = 400.0;

/// A function that makes a file.
type FileMaker = fn() -> Vec<u8>;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let mut row = SectionResult::default();
    let files: [(&str, FileMaker); 4] = [
        ("many", || greedy::equal_components(99_000, 200)),
        ("deep", || greedy::deep_components(15, 600)),
        ("idle", || greedy::idle_vertices(12_000_000)),
        ("wide", || greedy::equal_components(20_000, 990)),
    ];
    let most = budget.pick(1, files.len());
    loop {
        for (name, make) in &files[..most] {
            one_farm(&mut row, &[(name, *make)]);
        }
        if budget.is_long {
            one_farm(&mut row, &files);
        }
        if !budget.is_long || budget.is_spent() {
            break;
        }
    }
    row.note =
        format!("{} of {} files were more than there was memory for; the others were read", row.points, row.files);
    row
}

/// A farm with these files and an ordinary one: each is refused with a reason or read, and the ordinary one is printed.
fn one_farm(row: &mut SectionResult, files: &[(&str, FileMaker)]) {
    let mut farm = TestFarm::new(QUICK);
    std::fs::write(farm.config(), FARM).unwrap();
    farm.start_with_memory(MEMORY);
    farm.drop_part("good.stl", &block(10.0, 12.0, 5.0));
    files.iter().for_each(|(name, make)| farm.drop_bytes(&format!("{name}.3mf"), &make()));
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    let (began, mut ends) = (std::time::Instant::now(), 0);
    let is_read = |farm: &TestFarm| {
        let count = |state| farm.parts(state).len();
        count(PartState::Claimed) == 0 && count(PartState::Waiting) + count(PartState::Refused) == files.len() + 1
    };
    while !is_read(&farm) {
        ends += u64::from(farm.start_again_where_it_ended(MEMORY));
        if began.elapsed().as_secs_f64() > PATIENCE {
            row.broken.push(format!("{names:?}: not all is read after {PATIENCE} s and {ends} ends of the daemon"));
            return;
        }
        thread::sleep(Duration::from_millis(100));
    }
    let refused = farm.parts(PartState::Refused);
    for part in &refused {
        if part.name == "good.stl" || !part.refused.reason.contains("limits.") {
            row.broken.push(format!("{} is refused because: {}", part.name, part.refused.reason));
        }
    }
    if ends > STARTS_PER_FILE * files.len() as u64 {
        row.broken.push(format!("{names:?} ended the daemon {ends} times"));
    }
    // A file that was read may be left out of the build: only the ordinary one must be printed.
    for part in farm.parts(PartState::Waiting).iter().filter(|part| part.name != "good.stl") {
        farm.nestd(&["cancel", &part.id.to_string()]);
    }
    farm.nestd(&["flush", MACHINE]);
    farm.wait_for_queued(1);
    row.points += refused.len() as u64;
    row.files += files.len() as u64 + 1;
    row.faults += ends;
    row.builds += 1;
}
