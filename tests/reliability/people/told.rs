//! What operators say of builds whose files are in the queue, taken, truncated or replaced: with and without insisting. Counts the copies
//! in all files that printers could print; these are never more than wanted.

use std::{fs, thread, time::Duration};

use ledger::{BuildState, PartId, PartState};

use crate::{
    harness::{SectionBudget, SectionResult},
    support::{MACHINE, QUICK, TestFarm, block, wait_until_or},
};

/// Copies of each part.
const COPIES: usize = 3;
/// The words: what is said after the number of the build, and how many copies it makes bad.
const WORDS: [(&str, usize); 7] = [
    ("outcome B failed", 3),
    ("outcome B complete --bad P=1", 1),
    ("outcome B interrupted --bad P=2", 2),
    ("reprint bB", 3),
    ("requeue B", 3),
    ("withdraw B", 3),
    ("outcome B complete", 0),
];

/// What became of the file before the word.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FileFate {
    Queued,
    Taken,
    Truncated,
    Replaced,
}

pub fn run(budget: &SectionBudget) -> SectionResult {
    let budget = budget.at_least(20.0);
    let farm = TestFarm::running(QUICK);
    let mut row = SectionResult::default();
    let fates = [FileFate::Queued, FileFate::Taken, FileFate::Truncated, FileFate::Replaced];
    let mut cases: Vec<_> = fates.into_iter().flat_map(|fate| WORDS.map(|word| (fate, word))).collect();
    cases.sort_by_key(|(fate, _)| *fate != FileFate::Queued);
    for (number, (fate, word)) in cases.into_iter().cycle().enumerate() {
        if budget.is_spent() || (number >= 28 && !budget.is_long) {
            break;
        }
        let name = format!("{number}.stl");
        row.broken.extend(say_one(&farm, &name, fate, word));
        (row.points, row.files, row.builds) = (row.points + 1, row.files + 1, row.builds + 2);
        row.faults += u64::from(fate != FileFate::Queued);
    }
    row.note =
        "outcome, reprint, requeue and withdraw, on files that are queued, taken, truncated and replaced".to_owned();
    row
}

fn say_one(farm: &TestFarm, name: &str, fate: FileFate, (word, bad): (&str, usize)) -> Option<String> {
    farm.drop_bytes(&format!("{name}.toml"), format!("copies = {COPIES}\n").as_bytes());
    farm.drop_part(name, &block(20.0, 20.0, 20.0));
    let of = |state: PartState| farm.parts(state).into_iter().find(|part| part.name == name);
    wait_until_or("the part waits", 60.0, || farm.log(), || of(PartState::Waiting).is_some());
    farm.flush();
    wait_until_or("the build is in the queue", 60.0, || farm.log(), || of(PartState::Built).is_some());
    let part = of(PartState::Built)?.id;
    let build = farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()).pop()?;
    let file = farm.folder("queue").join(build.staged.file_name.as_deref()?);
    if printable(farm, part) != COPIES {
        return Some(format!("{word}: the copies of part {part} are not seen in the queue"));
    }
    match fate {
        FileFate::Queued => {}
        FileFate::Taken => fs::remove_file(&file).unwrap(),
        FileFate::Truncated => fs::write(&file, b"").unwrap(),
        FileFate::Replaced => fs::write(&file, b"another file").unwrap(),
    }
    let text = word.replace('B', &build.id.to_string()).replace('P', &part.to_string());
    let words: Vec<&str> = text.split(' ').collect();
    farm.nestd(&words);
    let refused = printable(farm, part);
    if !word.starts_with("withdraw") {
        farm.nestd(&[&words[..], &["--anyway"]].concat());
    }
    farm.nestd(&["resume", MACHINE]);
    thread::sleep(Duration::from_millis(600));
    farm.nestd(&["flush", MACHINE]);
    wait_until_or("what waits is built", 60.0, || farm.log(), || of(PartState::Built).is_some());
    let counts = [refused, printable(farm, part)];
    let most = if fate == FileFate::Taken { bad } else { COPIES };
    farm.queued().into_iter().for_each(|file| fs::remove_file(file).unwrap());
    counts
        .iter()
        .any(|count| *count > most)
        .then(|| format!("{text}, {fate:?}: {counts:?} copies in files that printers see, and {most} are wanted"))
}

/// Copies of a part in all files that a printer could print.
fn printable(farm: &TestFarm, part: PartId) -> usize {
    let number = part.to_string();
    let builds = farm.queued().into_iter().filter_map(|file| build_file::read_build(&file, &Default::default()).ok());
    builds.flatten().filter(|copy| copy.part_number.as_ref() == Some(&number)).count()
}
