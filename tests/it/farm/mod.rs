//! The farm as its users meet it: the real binary on real folders, a real SQLite ledger and real inotify.

mod attention;
mod bad_input;
mod dashboard;
mod decided;
mod deep;
mod full_disk;
mod interlock;
mod kept_time;
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
mod slow;
mod watchers;
mod words;

use crate::support::{self, greedy};
