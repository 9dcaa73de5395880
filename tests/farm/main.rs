//! The farm as its users meet it: the real binary on real folders, a real SQLite ledger and real inotify.
#![allow(clippy::unwrap_used)] // a test that cannot go on fails

mod attention;
mod bad_input;
mod deep;
mod interlock;
mod kill;
mod life;
mod open;
mod operations;
mod orders;
mod privilege;
mod restore;
mod support;
mod triggers;
