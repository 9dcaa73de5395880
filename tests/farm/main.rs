//! The farm as its users meet it: the real binary on real folders, a real SQLite ledger and real inotify.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot go on fails

#[path = "../hook/mod.rs"]
mod hook;

mod attention;
mod bad_input;
mod dashboard;
mod deep;
mod full_disk;
mod interlock;
mod life;
mod names;
mod open;
mod operations;
mod orders;
mod pictures;
mod privilege;
mod restore;
mod share;
mod support;
mod triggers;
mod watchers;
