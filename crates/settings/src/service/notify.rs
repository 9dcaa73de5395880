//! Receivers of notifications and the events that they get.

use std::path::PathBuf;

use serde::Serialize;

use super::{
    email::{EmailSettings, validate_email},
    inputs::NotifyInputs,
};
use crate::{NotificationKind, reading::validator::ConfigValidator};

/// Settings of notifications.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotifySettings {
    /// Events that are sent.
    pub events: Vec<NotificationKind>,
    /// Webhook to which events are posted; `None` = none.
    pub webhook: Option<WebhookSettings>,
    /// Program that gets the events, with its arguments; `None` = none.
    pub command: Option<Vec<String>>,
    /// Time after which a delivery counts as failed, seconds.
    pub timeout_secs: f64,
    /// Time after which an undelivered event is dropped, seconds.
    pub keep_secs: f64,
    /// E-mail; `None` = none is sent.
    pub email: Option<EmailSettings>,
}

/// Settings of a webhook.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct WebhookSettings {
    /// URL, http or https.
    pub url: String,
    /// The file with the key that messages are signed with.
    pub secret_file: PathBuf,
}

impl NotifySettings {
    /// Whether there is any receiver.
    pub fn is_enabled(&self) -> bool {
        self.webhook.is_some() || self.command.is_some() || self.email.is_some()
    }
}

/// Validates the notification settings. Reports problems.
pub(crate) fn validate_notify(inputs: &NotifyInputs, validator: &mut ConfigValidator) -> NotifySettings {
    validator.require_within("notify.timeout_secs", inputs.timeout_secs.0, 0.1..=600.0);
    validator.require_within("notify.keep_secs", inputs.keep_secs.0, 60.0..=31_536_000.0);
    let webhook = inputs.webhook.0.as_ref().map(|url| {
        let rest = url.strip_prefix("https://").or(url.strip_prefix("http://")).unwrap_or_default();
        if rest.starts_with('/') || rest.is_empty() || !url.chars().all(|c| c.is_ascii_graphic()) {
            let text = format!("notify.webhook = \"{}\" is no address of a web server", url.escape_debug());
            validator.report_problem("notify.webhook", text, "write \"https://host/path\" or \"off\"");
        }
        let secret_file = inputs.secret_file.0.clone().unwrap_or_else(|| {
            let text =
                "there is a notify.webhook and no notify.secret_file: receivers could not verify that messages come from you";
            let remedy =
                "name a file with a key of 16 letters or more: head -c 24 /dev/urandom | base64 > FILE; chmod 640 FILE";
            validator.report_problem("notify.webhook", text.to_owned(), remedy);
            PathBuf::new()
        });
        WebhookSettings { url: url.clone(), secret_file }
    });
    let command = (!inputs.command.is_empty()).then(|| inputs.command.clone());
    if command.as_ref().is_some_and(|words| !words[0].starts_with('/') || words.iter().any(|w| w.contains('\0'))) {
        let text = format!("notify.command: \"{}\" is no whole path", inputs.command[0].escape_debug());
        let remedy = "name the program by its whole path; no shell is used: [\"/usr/local/bin/tell\", \"--loud\"]";
        validator.report_problem("notify.command", text, remedy);
    }
    let events = inputs.events.clone();
    let email = validate_email(&inputs.email, validator);
    let (timeout_secs, keep_secs) = (inputs.timeout_secs.0, inputs.keep_secs.0);
    NotifySettings { events, webhook, command, timeout_secs, keep_secs, email }
}
