//! The fast tests: those that run on any machine within minutes. `cargo test --test it` runs all of them,
//! `cargo test --test it -- farm::parts` some of them.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot continue fails

mod acceptance;
mod farm;
mod floors;
mod fuzz;
mod hostile;
mod kernel;
mod readme;
mod rules;
mod supply;
#[path = "../support/mod.rs"]
mod support;
mod terminal;
mod tidy;
