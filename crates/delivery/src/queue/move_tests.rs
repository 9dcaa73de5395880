//! A published build is moved from one printer's folder to another's. The process is killed, and printers take files, at
//! every step: the build is printed exactly once.

use std::{
    fs,
    io::{self, Write},
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use super::*;

const BUILD: &str = "20261120T044900Z_mjf-5200_000042.build.3mf";
const REPORT: &str = "20261120T044900Z_mjf-5200_000042.report.json";

/// What the ledger has recorded of the move.
#[derive(Debug, Clone, Copy, PartialEq)]
enum RecordedStep {
    Begun,
    Copied,
    Finished,
    Taken,
}

/// Two printers, and what they have printed.
struct TwoPrinters {
    _dir: tempfile::TempDir,
    left: QueueFolder,
    right: QueueFolder,
}

impl TwoPrinters {
    /// The build is published on the left.
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let [left, right] = ["left", "right"].map(|name| QueueFolder::open(dir.path().join(name)).unwrap());
        for name in [BUILD, REPORT] {
            left.stage(name, Box::new(|file| Ok(file.write_all(name.as_bytes())?))).unwrap();
        }
        left.publish(BUILD).unwrap();
        Self { _dir: dir, left, right }
    }

    /// The move as the farm does it, from what the ledger has recorded. `step` is called between all operations.
    fn go_on(&self, recorded: &mut RecordedStep, step: &mut dyn FnMut()) {
        if *recorded == RecordedStep::Begun {
            match self.left.take_back_with_hook(BUILD, &is_proved, step).unwrap() {
                TakeBackOutcome::Gone | TakeBackOutcome::Altered => *recorded = RecordedStep::Taken,
                TakeBackOutcome::TakenBack => {
                    self.right.stage_taken_back(&self.left, BUILD).unwrap();
                    step();
                    *recorded = RecordedStep::Copied;
                }
            }
            step();
        }
        if *recorded == RecordedStep::Copied {
            self.left.remove_taken_back(BUILD).unwrap();
            step();
            self.right.publish_with_hook(BUILD, step).unwrap();
            step();
            *recorded = RecordedStep::Finished;
        }
    }
}

/// The build holds its own name.
fn is_proved(file: &Path) -> io::Result<bool> {
    Ok(fs::read_to_string(file)? == BUILD)
}

/// A printer takes the build if it is visible.
fn take(queue: &QueueFolder) -> usize {
    usize::from(fs::remove_file(queue.published_path(BUILD)).is_ok())
}

#[test]
fn a_second_file_under_the_name_of_one_that_was_taken_back_stays_and_hinders_nothing() {
    let printers = TwoPrinters::new();
    assert_eq!(printers.left.take_back(BUILD, &is_proved).unwrap(), TakeBackOutcome::TakenBack);
    fs::write(printers.left.published_path(BUILD), BUILD).unwrap();
    assert_eq!(printers.left.take_back(BUILD, &is_proved).unwrap(), TakeBackOutcome::TakenBack);
    assert!(printers.left.published_path(BUILD).exists());
}

#[test]
fn a_folder_that_is_unmounted_while_a_file_is_taken_back_does_not_say_that_its_printer_took_it() {
    let printers = TwoPrinters::new();
    let [left, away] = ["left", "away"].map(|name| printers._dir.path().join(name));
    let mut steps = 0;
    let told = printers.left.take_back_with_hook(BUILD, &is_proved, &mut || {
        steps += 1;
        if steps == 2 {
            fs::rename(&left, &away).unwrap();
            fs::create_dir(&left).unwrap();
        }
    });
    assert!(matches!(told, Err(QueueError::Unavailable { .. })), "{told:?}");
}

#[test]
fn a_build_moved_between_printers_is_printed_once_wherever_it_is_stopped_and_whoever_takes_it() {
    let mut cases = 0;
    for stop in 1.. {
        let mut ended = 0;
        // Bit 1: the left printer takes at that step; bit 2: the right one.
        for takes in 0..4_u32 {
            let printers = TwoPrinters::new();
            let (mut recorded, mut steps, mut printed) = (RecordedStep::Begun, 0, 0);
            let killed = catch_unwind(AssertUnwindSafe(|| {
                printers.go_on(&mut recorded, &mut || {
                    steps += 1;
                    if steps == stop {
                        printed += if takes & 1 > 0 { take(&printers.left) } else { 0 };
                        printed += if takes & 2 > 0 { take(&printers.right) } else { 0 };
                        // Without a kill, the move goes on after the printers took.
                        assert!(takes == 3, "stop here");
                    }
                });
            }));
            ended += u32::from(killed.is_ok() && steps < stop);
            // A new daemon sweeps the folders and goes on with what the ledger says.
            for queue in [&printers.left, &printers.right] {
                let keep = [BUILD.to_owned()];
                QueueFolder::open(queue.folder_path()).unwrap().sweep(&keep).unwrap();
            }
            printers.go_on(&mut recorded, &mut || {});
            let visible = [&printers.left, &printers.right].map(take);
            printed += visible[0] + visible[1];
            assert_eq!(printed, 1, "stop {stop}, takes {takes}: {recorded:?}");
            assert_eq!(visible[0], 0, "it does not come back to the left");
            for queue in [&printers.left, &printers.right] {
                assert!(!queue.withdrawn_path(BUILD).exists() && !queue.staged_path(BUILD).exists());
            }
            cases += 1;
        }
        if ended == 4 {
            break;
        }
    }
    assert!(cases > 4 * 10, "only {cases} cases");
}

#[test]
fn what_was_taken_back_can_be_published_in_the_same_folder_again_with_its_sidecars() {
    let printers = TwoPrinters::new();
    assert_eq!(printers.left.take_back(BUILD, &is_proved).unwrap(), TakeBackOutcome::TakenBack);
    assert!(!printers.left.published_path(REPORT).exists(), "sidecars do not stay behind");
    assert_eq!(printers.left.take_back(BUILD, &is_proved).unwrap(), TakeBackOutcome::TakenBack, "safe to repeat");
    printers.left.stage_taken_back(&printers.left, BUILD).unwrap();
    printers.left.remove_taken_back(BUILD).unwrap();
    printers.left.publish(BUILD).unwrap();
    assert_eq!(fs::read_to_string(printers.left.published_path(BUILD)).unwrap(), BUILD);
    assert_eq!(fs::read_to_string(printers.left.published_path(REPORT)).unwrap(), REPORT);
}

#[test]
fn an_unmounted_folder_is_not_one_whose_printer_took_the_build() {
    let printers = TwoPrinters::new();
    fs::rename(printers.left.folder_path(), printers.right.folder_path().join("away")).unwrap();
    fs::create_dir(printers.left.folder_path()).unwrap();
    assert!(matches!(printers.left.take_back(BUILD, &is_proved), Err(QueueError::Unavailable { .. })));
}
