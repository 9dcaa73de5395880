//! The farm with external programs: its pages in a real Chromium, its hot folder behind a real Samba server. A test
//! that cannot run on this machine is reported as ignored, with the reason.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test that cannot continue fails; these print their figures

mod pages;
mod paper;
mod quiet;
mod samba;
#[path = "../support/mod.rs"]
mod support;
mod tasks;

use std::process::ExitCode;

use libtest_mimic::Arguments;
use support::trial::{missing_variables, trial};

/// Clients of a share mostly wait.
const AT_ONCE: usize = 3;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(AT_ONCE);
    let mut trials = vec![
        trial(
            "pages::every_page_is_what_it_should_be_in_a_real_browser",
            missing_variables(&["NESTD_BROWSER"]),
            pages::every_page_is_what_it_should_be_in_a_real_browser,
        ),
        trial(
            "pages::the_view_of_700_parts_and_four_million_triangles_opens_in_time",
            missing_variables(&["NESTD_BROWSER"]),
            pages::the_view_of_700_parts_and_four_million_triangles_opens_in_time,
        ),
    ];
    trials.push(trial(
        "tasks::eight_tasks_take_few_clicks_and_a_slow_line_shows_a_picture_soon",
        missing_variables(&["NESTD_BROWSER"]),
        tasks::eight_tasks_take_few_clicks_and_a_slow_line_shows_a_picture_soon,
    ));
    trials.push(trial(
        "paper::pick_map_and_history_lose_nothing_on_paper",
        missing_variables(&["NESTD_BROWSER"]).or_else(paper::missing),
        paper::pick_map_and_history_lose_nothing_on_paper,
    ));
    let of_samba = |&(name, case): &(&str, fn())| {
        let case = move || {
            let _busy = quiet::run_beside_others();
            case();
        };
        trial(&format!("samba::{name}"), samba::missing(), case)
    };
    trials.extend(samba::CASES.iter().map(of_samba));
    libtest_mimic::run(&arguments, trials).exit_code()
}
