//! One attempt to send one message to one receiver.

use std::time::Duration;

use anyhow::{Context, Result};
use ledger::ReceiverKind;

use super::{EventMessage, command, webhook};
use crate::settings::NotifySettings;

/// The configured receivers.
pub fn configured_receivers(notify: &NotifySettings) -> Vec<ReceiverKind> {
    let webhook = notify.webhook.as_ref().map(|_| ReceiverKind::Webhook);
    webhook.into_iter().chain(notify.command.as_ref().map(|_| ReceiverKind::Command)).collect()
}

/// Sends a message and waits until the receiver has accepted it. Blocks the calling thread, at most for the timeout.
///
/// # Errors
/// The receiver did not accept it, or it is not known whether it did.
pub fn send_message(notify: &NotifySettings, receiver: ReceiverKind, message: &EventMessage) -> Result<()> {
    let timeout = Duration::from_secs_f64(notify.timeout_secs);
    match receiver {
        ReceiverKind::Webhook => {
            webhook::post_message(notify.webhook.as_ref().context("there is no webhook")?, timeout, message)
        }
        ReceiverKind::Command => {
            command::run_command(notify.command.as_deref().context("there is no command")?, timeout, message)
        }
    }
}
