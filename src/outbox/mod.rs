//! Tells others what happens: each event of the ledger that somebody wants to hear of becomes a message, which is posted to a
//! webhook, given to a command, or both.
//!
//! The ledger's events are the outbox, and each receiver has its place in them: nothing is lost over a restart, and each event
//! is told at least once, in order. A message carries an id, so that a receiver can drop one that it has already. The room
//! stands beside the farm, which knows nothing of it: a receiver that hangs holds up nobody.

mod command;
mod message;
mod send;
mod serve;
mod webhook;

#[cfg(test)]
mod tests;

pub use message::{Message, kinds};
pub use send::{configured, send};
pub use serve::{forget_others, serve};
pub use webhook::signature;
