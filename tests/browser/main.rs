//! The farm with what not every machine has: its pages in a real Chromium, its hot folder behind a real Samba server, clients that
//! others' generators make, disks that are mounted and full, processes that are traced. And the judge of the benchmark, which is Python. A
//! test that cannot run on this machine is reported as ignored, with the reason.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test that cannot continue fails; these print their figures

mod break_out;
mod clients;
mod documented;
mod full_disk;
mod judged;
mod pages;
mod paper;
mod quiet;
mod remounted;
mod samba;
mod slow;
#[path = "../support/mod.rs"]
mod support;
mod tasks;

use std::process::ExitCode;

use ledger_fixtures::postgres_cluster::find_programs;
use libtest_mimic::{Arguments, Trial};
use support::{
    small_disk::SmallDisk,
    trial::{missing_variables, trial},
};

/// Clients of a share mostly wait.
const AT_ONCE: usize = 3;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(AT_ONCE);
    let trials = [pages_in_a_browser(), programs(), disks_and_processes(), judge()].into_iter().flatten().collect();
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn pages_in_a_browser() -> Vec<Trial> {
    let missing = || missing_variables(&["NESTD_BROWSER"]);
    vec![
        trial(
            "pages::every_page_is_what_it_should_be_in_a_real_browser",
            missing(),
            pages::every_page_is_what_it_should_be_in_a_real_browser,
        ),
        trial(
            "pages::the_view_of_700_parts_and_four_million_triangles_opens_in_time",
            missing(),
            pages::the_view_of_700_parts_and_four_million_triangles_opens_in_time,
        ),
        trial(
            "tasks::tasks_take_few_clicks_by_mouse_touch_and_keyboard_and_a_slow_line_shows_a_picture_soon",
            missing(),
            tasks::tasks_take_few_clicks_by_mouse_touch_and_keyboard_and_a_slow_line_shows_a_picture_soon,
        ),
        trial(
            "tasks::tasks_are_done_whichever_of_three_nodes_answers",
            missing().or_else(missing_postgres),
            tasks::tasks_are_done_whichever_of_three_nodes_answers,
        ),
        beside_others(
            "break_out::two_devices_break_out_a_build_whichever_of_three_nodes_answers",
            missing().or_else(missing_postgres),
            break_out::two_devices_break_out_a_build_whichever_of_three_nodes_answers,
        ),
        beside_others(
            "break_out::two_devices_break_out_a_build_and_no_copy_is_shown_to_both",
            missing(),
            break_out::two_devices_break_out_a_build_and_no_copy_is_shown_to_both,
        ),
        beside_others(
            "paper::pick_map_and_history_lose_nothing_on_paper",
            missing().or_else(paper::missing),
            paper::pick_map_and_history_lose_nothing_on_paper,
        ),
    ]
}

fn missing_postgres() -> Option<String> {
    find_programs().is_none().then(|| "needs PostgreSQL".to_owned())
}

/// What talks to the farm as others' programs do.
fn programs() -> Vec<Trial> {
    let mut trials = vec![
        beside_others(
            "documented::the_examples_of_the_interface_for_programs_work_as_they_stand_there",
            documented::missing("curl"),
            documented::the_examples_of_the_interface_for_programs_work_as_they_stand_there,
        ),
        beside_others(
            "documented::the_examples_work_whichever_of_three_nodes_answers",
            documented::missing("curl").or_else(missing_postgres),
            documented::the_examples_work_whichever_of_three_nodes_answers,
        ),
        beside_others(
            "documented::the_documented_receiver_takes_our_messages_and_refuses_others",
            documented::missing("python3"),
            documented::the_documented_receiver_takes_our_messages_and_refuses_others,
        ),
        beside_others(
            "clients::a_python_client_made_of_the_description_runs_the_examples_of_the_document",
            missing_variables(&["NESTD_API_TOOLS"]),
            clients::a_python_client_made_of_the_description_runs_the_examples_of_the_document,
        ),
        beside_others(
            "clients::a_typescript_client_made_of_the_description_runs_the_examples_of_the_document",
            missing_variables(&["NESTD_API_TOOLS"]).or_else(|| documented::missing("node")),
            clients::a_typescript_client_made_of_the_description_runs_the_examples_of_the_document,
        ),
    ];
    trials.extend(samba::CASES.iter().map(|&(name, case)| {
        let name = format!("samba::{name}");
        beside_others(&name, samba::missing(), case)
    }));
    trials
}

fn disks_and_processes() -> Vec<Trial> {
    let (no_disk, no_trace) = (SmallDisk::missing(), slow::missing());
    let remounted = "remounted::a_share_that_is_unmounted_and_mounted_again_goes_on_where_it_was";
    let of_disks = full_disk::CASES.map(|(name, case)| (format!("full_disk::{name}"), no_disk.clone(), case));
    let of_traces = slow::CASES.map(|(name, case)| (format!("slow::{name}"), no_trace.clone(), case));
    let mut trials: Vec<Trial> = of_disks
        .into_iter()
        .chain(of_traces)
        .map(|(name, missing, case)| beside_others(&name, missing, case))
        .collect();
    let share = remounted::a_share_that_is_unmounted_and_mounted_again_goes_on_where_it_was;
    trials.push(beside_others(remounted, remounted::missing(), share));
    trials
}

/// The judge of the benchmark of 3D packing.
fn judge() -> Vec<Trial> {
    let cases: [(&str, fn()); 3] = [
        ("judged::good_entries_count_in_each_form", judged::good_entries_count_in_each_form),
        ("judged::each_fault_of_an_entry_is_named", judged::each_fault_of_an_entry_is_named),
        (
            "judged::a_record_is_what_the_judge_says_of_its_entry_and_the_table_is_made_of_all",
            judged::a_record_is_what_the_judge_says_of_its_entry_and_the_table_is_made_of_all,
        ),
    ];
    cases.into_iter().map(|(name, case)| beside_others(name, judged::missing(), case)).collect()
}

/// A test that runs while no other one measures time.
fn beside_others(name: &str, missing: Option<String>, case: fn()) -> Trial {
    trial(name, missing, move || {
        let _busy = quiet::run_beside_others();
        case();
    })
}
