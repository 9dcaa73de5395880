//! One attempt to send one message to one receiver.

use std::time::Duration;

use anyhow::{Context, Result, bail};
use ledger::{EventKind, ReceiverKind};
use settings::{NotifySettings, Settings};

use super::{
    EventMessage, command, email,
    mail::{self, addresses_of},
    message::event_kinds,
    webhook,
};

/// The configured receivers.
pub fn configured_receivers(notify: &NotifySettings) -> Vec<ReceiverKind> {
    let is_configured = |receiver: &ReceiverKind| match (receiver, &notify.email) {
        (ReceiverKind::Webhook, _) => notify.webhook.is_some(),
        (ReceiverKind::Command, _) => notify.command.is_some(),
        (ReceiverKind::EmailOrderComplete, Some(email)) => email.customers,
        (mail, Some(email)) => !addresses_of(email, *mail).is_empty(),
        (_, None) => false,
    };
    ReceiverKind::ALL.into_iter().filter(is_configured).collect()
}

/// The kinds of events that a receiver gets.
pub fn kinds_for(receiver: ReceiverKind, notify: &NotifySettings) -> Vec<EventKind> {
    match receiver {
        ReceiverKind::Webhook | ReceiverKind::Command => event_kinds(&notify.events),
        ReceiverKind::EmailAlert => vec![EventKind::Alert, EventKind::MessagesDropped],
        ReceiverKind::EmailRefused => vec![EventKind::Refused],
        ReceiverKind::EmailAtRisk => vec![EventKind::AtRisk],
        ReceiverKind::EmailOrderComplete => vec![EventKind::OrderComplete],
    }
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
        _ => bail!("mails are gathered"),
    }
}

/// Sends a receiver a message for a test, and says what it has got. Blocks the calling thread, at most for the timeout.
///
/// # Errors
/// As [`send_message`].
pub fn send_trial(settings: &Settings, receiver: ReceiverKind) -> Result<String> {
    let notify = &settings.interfaces.notify;
    let timeout = Duration::from_secs_f64(notify.timeout_secs);
    match (receiver, &notify.email) {
        (ReceiverKind::Webhook | ReceiverKind::Command, _) => {
            let message = EventMessage::trial_message();
            send_message(notify, receiver, &message)?;
            Ok(format!("The {receiver} has the message {}.", message.id))
        }
        (_, None) => bail!("there is no mail server"),
        // To customers nothing is sent that they did not ask for.
        (ReceiverKind::EmailOrderComplete, Some(email)) => {
            email::greet_server(email, timeout)?;
            Ok(format!("The mail server {} would take mails to customers; none was sent.", email.host))
        }
        (_, Some(email)) => {
            let mail = settings.language.within(|| mail::trial_mail(email, receiver));
            email::send_mail(email, timeout, &mail)?;
            Ok(format!("The mail server {} has taken a {} to {}.", email.host, receiver.noun(), mail.to.join(", ")))
        }
    }
}
