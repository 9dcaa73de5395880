//! What an operator types, and what comes back.

pub mod check;
pub mod commands;
pub mod config;
pub mod new_farm;
pub mod pictures;
pub mod searched;
pub mod verify;
