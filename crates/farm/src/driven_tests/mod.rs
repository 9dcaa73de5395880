//! Tests of the farm's logic that control a farm step by step and need no separate process. The tests of the real
//! daemon are in `tests/it/farm`.

mod hand_driven_farm;
mod kept;
mod nested;
mod printed;
mod received;

use hand_driven_farm::{HandDrivenFarm, MACHINE, QUICK, block, stl};
