//! Tests with customers' parts, which are not in the repository: `NESTD_DATA=<folder> cargo test --test data`. A test
//! that cannot run on this machine is reported as ignored, with the reason.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test that cannot continue fails; these print their figures

mod acceptance;
mod referees;
#[path = "../support/mod.rs"]
mod support;
mod torture;

use std::process::ExitCode;

use libtest_mimic::Arguments;
use support::trial::{missing_variables, trial};

fn main() -> ExitCode {
    let trials = vec![
        trial(
            "acceptance::random_builds_of_other_peoples_parts_are_proved_by_two_judges",
            missing_variables(&["NESTD_DATA"]),
            acceptance::random_builds_of_other_peoples_parts_are_proved_by_two_judges,
        ),
        trial(
            "referees::other_readers_read_our_builds_without_a_warning",
            missing_variables(&["NESTD_DATA", "NESTD_REFEREE"]),
            referees::other_readers_read_our_builds_without_a_warning,
        ),
        trial(
            "referees::other_programs_find_every_copy_of_each_kind_of_delivery_in_its_place",
            missing_variables(&["NESTD_REFEREE"]),
            referees::other_programs_find_every_copy_of_each_kind_of_delivery_in_its_place,
        ),
        trial(
            "referees::a_slicer_opens_each_kind_of_delivery",
            missing_variables(&["NESTD_SLICER"]),
            referees::a_slicer_opens_each_kind_of_delivery,
        ),
        trial(
            "torture::every_torture_file_gives_what_the_manifest_expects",
            missing_variables(&["NESTD_DATA"]),
            torture::every_torture_file_gives_what_the_manifest_expects,
        ),
        trial(
            "torture::broken_meshes_of_other_people_are_mended_within_measures_or_refused_with_a_reason",
            missing_variables(&["NESTD_DATA"]),
            torture::broken_meshes_of_other_people_are_mended_within_measures_or_refused_with_a_reason,
        ),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}
