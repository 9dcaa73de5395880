//! The fast tests: all that runs on any machine in minutes. `cargo test --test it` runs them, `cargo test --test it -- farm::life`
//! some of them.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot go on fails

mod acceptance;
mod check;
mod config;
mod faces;
mod farm;
mod floors;
mod fuzz;
mod hostile;
mod kernel;
mod pictures;
mod readme;
mod rules;
mod supply;
#[path = "../support/mod.rs"]
mod support;
mod tidy;
mod verify;
