//! What is dropped or ordered, and what becomes of it.

pub mod bad_input;
pub mod door;
pub mod interlock;
pub mod kept_time;
pub mod life;
pub mod lists;
pub mod materials;
pub mod memory;
pub mod names;
pub mod open;
pub mod requests;
