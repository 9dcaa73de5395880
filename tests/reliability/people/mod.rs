//! What people and programs do, while the daemon is killed: orders, words about prints, settings that change.

pub mod again;
pub mod bureau;
pub mod door;
pub mod orders;
pub mod storm;
pub mod told;
