//! Delivers events: each ledger event that somebody subscribed to becomes a message, which is posted to a webhook, passed to a
//! command, or told in a mail.
//!
//! The ledger's events are the outbox, and each receiver has a position in them. Nothing is lost at a restart, and each
//! event is delivered at least once, in order. A message carries an id, so that a receiver can drop duplicates. The
//! module is independent of the farm: a receiver that hangs blocks nothing else.

mod command;
mod delivery;
mod email;
mod mail;
mod mail_delivery;
mod message;
mod send;
mod webhook;

#[cfg(test)]
mod mail_tests;
#[cfg(test)]
mod tests;

pub use delivery::{deliver_events, forget_unconfigured_receivers};
pub use message::{EventMessage, MessageBody, event_kinds, message_id};
pub use send::{configured_receivers, kinds_for, send_message, send_trial};
pub use webhook::sign_body;
