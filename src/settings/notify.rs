//! Who is told what happens, and what of it.

use std::path::PathBuf;

use serde::Serialize;

use super::{Told, inputs::NotifyInputs, judge::Judge};

/// Who is told.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Notify {
    /// What is told.
    pub events: Vec<Told>,
    /// Where it is posted; `None` = nowhere.
    pub webhook: Option<Webhook>,
    /// The program that it is given to, with its arguments; `None` = to none.
    pub command: Option<Vec<String>>,
    /// A receiver that takes longer has not been told, seconds.
    pub timeout_secs: f64,
    /// What could not be told for so long is dropped, seconds.
    pub keep_secs: f64,
}

/// A webhook.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Webhook {
    /// Its address, http or https.
    pub url: String,
    /// The file with the key that messages are signed with.
    pub secret_file: PathBuf,
}

impl Notify {
    /// Whether anybody is told anything.
    pub fn is_on(&self) -> bool {
        self.webhook.is_some() || self.command.is_some()
    }
}

/// Who is told. What makes no sense is objected to.
pub(super) fn notify(inputs: &NotifyInputs, judge: &mut Judge) -> Notify {
    judge.within("notify.timeout_secs", inputs.timeout_secs.0, 0.1..=600.0);
    judge.within("notify.keep_secs", inputs.keep_secs.0, 60.0..=31_536_000.0);
    let webhook = inputs.webhook.0.as_ref().map(|url| {
        let rest = url.strip_prefix("https://").or(url.strip_prefix("http://")).unwrap_or_default();
        if rest.starts_with('/') || rest.is_empty() || !url.chars().all(|c| c.is_ascii_graphic()) {
            let text = format!("notify.webhook = \"{}\" is no address of a web server", url.escape_debug());
            judge.object("notify.webhook", text, "write \"https://host/path\" or \"off\"");
        }
        let secret_file = inputs.secret_file.0.clone().unwrap_or_else(|| {
            let text =
                "there is a notify.webhook and no notify.secret_file: nobody could tell your messages from others'";
            let remedy =
                "name a file with a key of 16 letters or more: head -c 24 /dev/urandom | base64 > FILE; chmod 640 FILE";
            judge.object("notify.webhook", text.to_owned(), remedy);
            PathBuf::new()
        });
        Webhook { url: url.clone(), secret_file }
    });
    let command = (!inputs.command.is_empty()).then(|| inputs.command.clone());
    if command.as_ref().is_some_and(|words| !words[0].starts_with('/') || words.iter().any(|w| w.contains('\0'))) {
        let text = format!("notify.command: \"{}\" is no whole path", inputs.command[0].escape_debug());
        let remedy = "name the program by its whole path; no shell is asked: [\"/usr/local/bin/tell\", \"--loud\"]";
        judge.object("notify.command", text, remedy);
    }
    let events = inputs.events.clone();
    Notify { events, webhook, command, timeout_secs: inputs.timeout_secs.0, keep_secs: inputs.keep_secs.0 }
}
