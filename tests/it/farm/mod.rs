//! The farm as users see it: the real binary on real folders, with a real SQLite ledger and real inotify.

mod attention;
mod bad_input;
mod change_lock;
mod dashboard;
mod decisions;
mod deep;
mod door;
mod failover;
mod interlock;
mod kept_time;
mod life;
mod lists;
mod lost_ledger;
mod machines_move;
mod memory;
mod names;
mod nodes_on_postgres;
mod on_postgres;
mod open;
mod operations;
mod orders;
mod pictures;
use ledger_fixtures::postgres_cluster;
mod printers;
mod privilege;
mod requests;
mod restore;
mod restored_orders;
mod returned;
mod rot;
mod share;
mod status_texts;
mod test_node;
mod watchers;

use crate::support::{self, greedy};
