//! What the farm does, driven by hand: tests of its logic that need no process. The real daemon has its own in `tests/it/farm`.

mod hand_driven_farm;
mod life;
mod lists;
mod open_build;
mod orders;
mod triggers;

use hand_driven_farm::{HandDrivenFarm, PROFILE, QUICK, block, stl};
