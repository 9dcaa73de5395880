//! Tests of the farm's logic that control a farm step by step and need no separate process. The tests of the real
//! daemon are in `tests/it/farm`.

mod camspec;
mod clock;
mod dates;
mod failing_ledger;
mod hand_driven_farm;
mod kept_builds;
mod late;
mod ledger_in_use;
mod life;
mod lists;
mod night;
mod open_build;
mod orders;
mod plans;
mod precedence;
mod printer_recovery;
mod printers;
mod queue_files;
mod repair;
mod reprints;
mod restored;
mod shrunk_machines;
mod tickets;
mod told;
mod triggers;
mod unfinished;
mod units;
mod unordered_files;
mod unread_tickets;
mod waiting_times;
mod week;
mod withdrawals;

use hand_driven_farm::{HandDrivenFarm, PROFILE, QUICK, block, stl};
