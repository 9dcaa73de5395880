//! Time limits: a part that is difficult to nest, render, verify and write takes no longer than its size explains,
//! whatever its time budget is. It does not delay other machines.

use std::{
    fs,
    time::{Duration, Instant},
};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, greedy, stl, wait_until_or};

const SECOND: &str = "second";
/// Number of shells in the same place. They touch everywhere, so that an algorithm that compares pairs of them never
/// ends.
const COMPONENTS: usize = 99_000;
/// Maximum time to nest, render, verify and write a part, as a multiple of the time to read it. Each of these steps
/// processes all triangles of the part. Both times are measured on the same machine in the same test.
const TIMES_READING: f64 = 8.0;
/// Time that any build takes, plus the delay on a busy machine, in seconds.
const ANY_BUILD_SECS: f64 = 8.0;

#[test]
fn the_build_of_an_awkward_part_keeps_its_clock_and_holds_up_no_other_machine() {
    let quick =
        QUICK.replace("final_secs = 0.5", "final_secs = 0.2").replace("arrival_secs = 0.5", "arrival_secs = 0.2");
    let farm = TestFarm::new(&quick);
    farm.write_profile(SECOND, &quick);
    let mut farm = farm;
    farm.start();
    let dropped = Instant::now();
    farm.drop_bytes("awkward.3mf", &greedy::equal_components(COMPONENTS, 8));
    wait(&farm, "it is read", || !farm.parts(PartState::Waiting).is_empty());
    let read_secs = dropped.elapsed().as_secs_f64();
    let fired = Instant::now();
    farm.flush();
    // Meanwhile, another machine accepts and prints a part.
    let outside = farm.root().join("sending");
    fs::write(&outside, stl(&block(10.0, 12.0, 14.0))).unwrap();
    let other = Instant::now();
    fs::rename(outside, farm.root().join("inbox").join(SECOND).join("other.stl")).unwrap();
    wait(&farm, "the other one is read", || farm.parts(PartState::Waiting).iter().any(|part| part.machine == SECOND));
    farm.nestd(&["flush", SECOND]);
    let queue = farm.root().join("queue").join(SECOND);
    let is_printed = || fs::read_dir(&queue).into_iter().flatten().flatten().any(|file| is_build(&file.file_name()));
    wait(&farm, "the other one is printed", is_printed);
    let other_secs = other.elapsed().as_secs_f64();
    wait(&farm, "it is printed", || !farm.queued().is_empty());
    let build_secs = fired.elapsed().as_secs_f64();
    let times_text =
        format!("read in {read_secs:.1} s, built in {build_secs:.1} s, the other one in {other_secs:.1} s");
    eprintln!("{times_text}");
    assert!(build_secs < ANY_BUILD_SECS + TIMES_READING * read_secs, "{times_text}\n{}", farm.log());
    assert!(other_secs < ANY_BUILD_SECS + 2.0 * read_secs, "{times_text}\n{}", farm.log());
}

fn is_build(name: &std::ffi::OsStr) -> bool {
    let name = name.to_string_lossy();
    name.ends_with(".build.3mf") && !name.starts_with('.')
}

fn wait(farm: &TestFarm, what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    wait_until_or(
        what,
        300.0,
        || farm.log(),
        || {
            std::thread::sleep(Duration::from_millis(20));
            assert!(
                farm.parts(PartState::Refused).is_empty() || began.elapsed() < Duration::ZERO,
                "refused: {}",
                farm.log()
            );
            holds()
        },
    );
}
