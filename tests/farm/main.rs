//! The farm as its users meet it: the real binary on real folders, a real SQLite ledger and real inotify.

mod bad_input;
mod kill;
mod life;
mod orders;
mod support;
mod triggers;
