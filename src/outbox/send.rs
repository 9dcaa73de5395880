//! Sending one message to one receiver, once.

use std::time::Duration;

use anyhow::{Context, Result};

use super::{Message, command, webhook};
use crate::{ledger::Receiver, settings::Notify};

/// The receivers that are configured.
pub fn configured(notify: &Notify) -> Vec<Receiver> {
    let webhook = notify.webhook.as_ref().map(|_| Receiver::Webhook);
    webhook.into_iter().chain(notify.command.as_ref().map(|_| Receiver::Command)).collect()
}

/// Sends a message and waits until the receiver has it. Takes up to the timeout, on the calling thread.
///
/// # Errors
/// When the receiver does not have it, for certain or perhaps.
pub fn send(notify: &Notify, receiver: Receiver, message: &Message) -> Result<()> {
    let timeout = Duration::from_secs_f64(notify.timeout_secs);
    match receiver {
        Receiver::Webhook => webhook::post(notify.webhook.as_ref().context("there is no webhook")?, timeout, message),
        Receiver::Command => command::run(notify.command.as_deref().context("there is no command")?, timeout, message),
    }
}
