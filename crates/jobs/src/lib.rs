#![doc = include_str!("../README.md")]

mod job;
mod loop_event;
mod runner;
#[cfg(test)]
mod tests;

pub use job::{BackgroundJob, Carried};
pub use loop_event::LoopEvent;
pub use runner::JobRunner;
