//! The farm as its users meet it: the real binary on real folders, a real SQLite ledger and real inotify.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot go on fails

#[path = "../hook/mod.rs"]
mod hook;

mod attention;
mod bad_input;
mod dashboard;
mod decided;
mod deep;
mod full_disk;
#[allow(dead_code)] // shared with the reliability run
mod greedy;
mod interlock;
mod life;
mod lists;
mod memory;
mod names;
mod open;
mod operations;
mod orders;
mod pictures;
mod privilege;
mod restore;
mod returned;
mod rot;
mod share;
mod support;
mod triggers;
mod watchers;
mod words;
