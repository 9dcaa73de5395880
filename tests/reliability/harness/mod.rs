//! The run itself: its arguments, its time, its table; and the reference life-cycle that its sections play.

pub mod arguments;
pub mod budget;
pub mod life_cycle;
pub mod pool;
pub mod printer;
pub mod section_result;
pub mod table;

pub use budget::SectionBudget;
pub use pool::{catch_panic, in_parallel, seed, spread_order};
pub use section_result::{ActionCounts, DOUBLED, LOST, SectionResult, WRONG_IN_SIZE};
