//! The tests of the ledger once more, on PostgreSQL: this test program runs itself, with another database behind the
//! same tests. And tests that hold the two databases against each other.

mod connections;
mod copies;
mod encrypted;
mod frozen;
mod leases;
mod order_of_events;
mod same_rows;
mod schemas;
mod upgrades;

use std::process::Command;

use super::*;
use crate::base::sql::{self, BindValue, FromSqlRow, SqlValue};

/// Tests of what SQLite's files and its planner do.
const SQLITE_ALONE: [&str; 7] = [
    "tests::store::backup",
    "tests::store::migrations",
    "tests::store::opening",
    "tests::store::query_plans",
    "tests::store::upgrade",
    "the_schema_and_the_state_machines_know_the_same_words",
    "the_truth_teller_sees_a_part_whose_state_was_changed_behind_its_back",
];

/// An empty ledger in a file, and one on PostgreSQL.
async fn both() -> (TestLedger, Ledger) {
    (fresh_file().await, fresh_on_server().await)
}

#[test]
fn the_same_tests_pass_on_postgresql() {
    let program = || Command::new(std::env::current_exe().unwrap());
    let listed = program().args(["--list", "--format", "terse"]).output().unwrap();
    let listed = String::from_utf8(listed.stdout).unwrap();
    let names = listed.lines().filter_map(|line| line.strip_suffix(": test"));
    let is_for_both = |name: &&str| {
        name.starts_with("tests::")
            && !name.starts_with("tests::on_postgres")
            && !SQLITE_ALONE.iter().any(|alone| name.contains(alone))
    };
    let ran =
        program().arg("--exact").args(names.filter(is_for_both)).env("NESTD_TEST_POSTGRES", "1").output().unwrap();
    let told = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{told}");
    let summary = told.lines().find(|line| line.starts_with("test result: ok")).unwrap();
    let passed: u32 = summary.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!(passed > 40, "{summary}");
}
