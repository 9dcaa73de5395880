//! Settings of e-mail: the server that takes mails, and the people who get them.

use std::{net::IpAddr, path::PathBuf};

use lettre::{Address, message::Mailbox};
use serde::{Deserialize, Serialize};

use crate::reading::{duration::DurationSecs, optional::OptionalValue, validator::ConfigValidator};

/// `[notify.email]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct EmailInputs {
    pub server: OptionalValue<String>,
    pub encryption: MailEncryption,
    pub user: OptionalValue<String>,
    pub password_file: OptionalValue<PathBuf>,
    pub from: OptionalValue<String>,
    pub technician: Vec<String>,
    pub planner: Vec<String>,
    pub customers: bool,
    pub gather_secs: DurationSecs,
}

impl Default for EmailInputs {
    fn default() -> Self {
        Self {
            server: OptionalValue::OFF,
            encryption: MailEncryption::Starttls,
            user: OptionalValue::OFF,
            password_file: OptionalValue::OFF,
            from: OptionalValue::OFF,
            technician: Vec::new(),
            planner: Vec::new(),
            customers: true,
            gather_secs: DurationSecs(600.0),
        }
    }
}

/// How the conversation with a mail server is kept secret.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MailEncryption {
    /// It begins in plain, and goes on encrypted before anything is said; without encryption nothing is sent.
    Starttls,
    /// It is encrypted from the first byte.
    Tls,
    /// It is not: only to a server on the same machine.
    None,
}

impl MailEncryption {
    /// The port that servers listen to for this.
    fn usual_port(self) -> u16 {
        match self {
            Self::Starttls => 587,
            Self::Tls => 465,
            Self::None => 25,
        }
    }
}

/// Settings of e-mail.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EmailSettings {
    /// Name or address of the SMTP server.
    pub host: String,
    /// Its port.
    pub port: u16,
    /// How the conversation is kept secret.
    pub encryption: MailEncryption,
    /// Who nestd is at the server, and the file with the password; `None` = the server asks nobody.
    pub login: Option<(String, PathBuf)>,
    /// The sender.
    pub from: String,
    /// Addresses that get alerts and refused files.
    pub technician: Vec<String>,
    /// Addresses that get due dates at risk.
    pub planner: Vec<String>,
    /// Whether customers get a mail when their order is complete.
    pub customers: bool,
    /// At most one mail of a kind is sent within this time, seconds.
    pub gather_secs: f64,
}

/// Validates the settings of e-mail. Reports problems.
pub(super) fn validate_email(inputs: &EmailInputs, validator: &mut ConfigValidator) -> Option<EmailSettings> {
    validator.require_within("notify.email.gather_secs", inputs.gather_secs.0, 0.0..=86_400.0);
    for (key, addresses) in [("notify.email.technician", &inputs.technician), ("notify.email.planner", &inputs.planner)]
    {
        for wrong in addresses.iter().filter(|address| address.parse::<Address>().is_err()) {
            let text = format!("{key}: \"{}\" is no address for e-mail", wrong.escape_debug());
            validator.report_problem(key, text, "write addresses alone: [\"name@example.org\"]");
        }
    }
    let server = inputs.server.0.as_ref()?;
    let (host, port) = host_and_port(server);
    let port = port.unwrap_or(inputs.encryption.usual_port());
    if host.is_empty() || !host.chars().all(|c| c.is_ascii_alphanumeric() || "-._:".contains(c)) {
        let text = format!("notify.email.server = \"{}\" is no name of a mail server", server.escape_debug());
        validator.report_problem(
            "notify.email.server",
            text,
            "write \"mail.example.org\", \"mail.example.org:587\" or \"off\"",
        );
    } else if inputs.encryption == MailEncryption::None && !is_loopback(&host) {
        let text = format!(
            "notify.email.encryption = \"none\" would send mails through the network to {host} for everybody to read"
        );
        let remedy =
            "say \"starttls\" or \"tls\"; \"none\" is for a mail server on this machine, such as \"localhost\"";
        validator.report_problem("notify.email.encryption", text, remedy);
    }
    if inputs.technician.is_empty() && inputs.planner.is_empty() && !inputs.customers {
        let text = "there is a notify.email.server, and nobody gets a mail".to_owned();
        let remedy = "name addresses in notify.email.technician or notify.email.planner, or say customers = true";
        validator.report_problem("notify.email.server", text, remedy);
    }
    Some(EmailSettings {
        host,
        port,
        encryption: inputs.encryption,
        login: validate_login(inputs, validator),
        from: validate_sender(inputs, validator),
        technician: inputs.technician.clone(),
        planner: inputs.planner.clone(),
        customers: inputs.customers,
        gather_secs: inputs.gather_secs.0,
    })
}

fn validate_login(inputs: &EmailInputs, validator: &mut ConfigValidator) -> Option<(String, PathBuf)> {
    match (&inputs.user.0, &inputs.password_file.0) {
        (Some(user), Some(file)) => Some((user.clone(), file.clone())),
        (None, None) => None,
        (Some(_), None) => {
            let text = "there is a notify.email.user and no notify.email.password_file".to_owned();
            let remedy =
                "write the password into a file of its own that others may not read (chmod 640), and name the file";
            validator.report_problem("notify.email.user", text, remedy);
            None
        }
        (None, Some(_)) => {
            let text = "there is a notify.email.password_file and no notify.email.user".to_owned();
            validator.report_problem(
                "notify.email.password_file",
                text,
                "say as whom nestd signs in at the mail server",
            );
            None
        }
    }
}

fn validate_sender(inputs: &EmailInputs, validator: &mut ConfigValidator) -> String {
    let remedy = "write the address that mails come from: \"farm@example.org\" or \"Print farm <farm@example.org>\"";
    let Some(from) = inputs.from.0.clone() else {
        let text = "there is a notify.email.server and no notify.email.from".to_owned();
        validator.report_problem("notify.email.server", text, remedy);
        return String::new();
    };
    if from.parse::<Mailbox>().is_err() {
        let text = format!("notify.email.from = \"{}\" is no address for e-mail", from.escape_debug());
        validator.report_problem("notify.email.from", text, remedy);
    }
    from
}

/// Host and port of `host`, `host:port`, `[::1]` or `[::1]:port`.
fn host_and_port(server: &str) -> (String, Option<u16>) {
    if server.parse::<IpAddr>().is_ok() {
        return (server.to_owned(), None);
    }
    let (host, port) = match server.rsplit_once(':').map(|(host, port)| (host, port.parse::<u16>())) {
        Some((host, Ok(port))) => (host, Some(port)),
        _ => (server, None),
    };
    let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
    (bare.to_owned(), port)
}

fn is_loopback(host: &str) -> bool {
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

#[test]
fn host_and_port_of_a_mail_server_are_found() {
    for (server, host, port) in [
        ("mail.example.org", "mail.example.org", None),
        ("mail.example.org:2525", "mail.example.org", Some(2525)),
        ("127.0.0.1:25", "127.0.0.1", Some(25)),
        ("::1", "::1", None),
        ("[::1]:25", "::1", Some(25)),
    ] {
        assert_eq!(host_and_port(server), (host.to_owned(), port), "{server}");
    }
    assert!(is_loopback("localhost") && is_loopback("127.0.0.1") && is_loopback("::1") && !is_loopback("mail"));
}
