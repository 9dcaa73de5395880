//! Delivers events: each ledger event that somebody subscribed to becomes a message, which is posted to a webhook,
//! passed to a command, or both.
//!
//! The ledger's events are the outbox, and each receiver has a position in them. Nothing is lost at a restart, and each
//! event is delivered at least once, in order. A message carries an id, so that a receiver can drop duplicates. The
//! module is independent of the farm: a receiver that hangs blocks nothing else.

mod command;
mod delivery;
mod message;
mod send;
mod webhook;

#[cfg(test)]
mod tests;

pub use delivery::{deliver_events, forget_unconfigured_receivers};
pub use message::{EventMessage, event_kinds};
pub use send::{configured_receivers, send_message};
pub use webhook::sign_body;
