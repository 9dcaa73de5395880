//! Tests over customers' parts, which are not in the repository: `NESTD_DATA=<folder> cargo test --test data`. What cannot run
//! here is reported as ignored, with the reason.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test that cannot go on fails; these say what they measured

mod acceptance;
mod referees;
#[path = "../support/mod.rs"]
mod support;
mod torture;

use std::process::ExitCode;

use libtest_mimic::Arguments;
use support::trial::{trial, unset};

fn main() -> ExitCode {
    let trials = vec![
        trial(
            "acceptance::random_builds_of_other_peoples_parts_are_proved_by_two_judges",
            unset(&["NESTD_DATA"]),
            acceptance::random_builds_of_other_peoples_parts_are_proved_by_two_judges,
        ),
        trial(
            "referees::other_readers_read_our_builds_without_a_warning",
            unset(&["NESTD_DATA", "NESTD_REFEREE"]),
            referees::other_readers_read_our_builds_without_a_warning,
        ),
        trial(
            "torture::every_torture_file_gives_what_the_manifest_expects",
            unset(&["NESTD_DATA"]),
            torture::every_torture_file_gives_what_the_manifest_expects,
        ),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}
