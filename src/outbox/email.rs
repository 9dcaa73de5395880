//! Delivery of a mail to an SMTP server (RFC 5321). The conversation is held step by step, so that it is known who was refused: the
//! server refuses one recipient, or everything.

use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use lettre::{
    Address, Message,
    message::{
        Mailbox,
        header::{ContentType, HeaderName, HeaderValue},
    },
    transport::smtp::{
        authentication::{Credentials, Mechanism},
        client::{SmtpConnection, TlsParameters},
        commands::{Data, Mail as MailFrom, Rcpt},
        extension::ClientId,
    },
};
use settings::{EmailSettings, MailEncryption};

use super::{mail::Mail, message::host_name};

/// Why a mail was not taken.
#[derive(Debug, thiserror::Error)]
pub(super) enum MailError {
    /// The server will never take a mail to this recipient.
    #[error("{0}")]
    NoRecipient(String),
    /// Anything else.
    #[error("{0:#}")]
    Failed(#[from] anyhow::Error),
}

/// Hands a mail to the server. It counts as delivered only if the server has taken it for all recipients in time.
pub(super) fn send_mail(email: &EmailSettings, timeout: Duration, mail: &Mail) -> Result<(), MailError> {
    let from: Mailbox = email.from.parse().context("reading notify.email.from")?;
    let mut recipients: Vec<Address> = Vec::new();
    for to in &mail.to {
        recipients.push(to.parse().map_err(|_| MailError::NoRecipient(format!("{to} is no address for e-mail")))?);
    }
    let message = make_message(&from, &recipients, mail)?;
    let mut conversation = Conversation::begin(email, timeout)?;
    conversation.step("the sender", |server| server.command(MailFrom::new(Some(from.email.clone()), Vec::new())))?;
    for recipient in recipients {
        conversation.add_recipient(&recipient)?;
    }
    conversation.step("the mail", |server| server.command(Data))?;
    conversation.step("the mail", |server| server.message(&message))?;
    conversation.end();
    Ok(())
}

/// Begins a conversation with the server and ends it: the server answers, and lets nestd in.
pub(super) fn greet_server(email: &EmailSettings, timeout: Duration) -> anyhow::Result<()> {
    Conversation::begin(email, timeout)?.end();
    Ok(())
}

/// The mail as it goes over the wire.
fn make_message(from: &Mailbox, recipients: &[Address], mail: &Mail) -> anyhow::Result<Vec<u8>> {
    let builder = recipients.iter().fold(Message::builder(), |builder, to| builder.to(Mailbox::new(None, to.clone())));
    let mut message = builder
        .from(from.clone())
        .subject(&mail.subject)
        .date_now()
        .message_id(Some(format!("<{}@{}>", mail.id, from.email.domain())))
        .header(ContentType::TEXT_PLAIN)
        .body(mail.text.clone())
        .context("writing the mail")?;
    // So that nobody's absence note is sent back (RFC 3834).
    let name = HeaderName::new_from_ascii_str("Auto-Submitted");
    message.headers_mut().insert_raw(HeaderValue::new(name, "auto-generated".to_owned()));
    Ok(message.formatted())
}

/// A conversation with the server, until its deadline.
struct Conversation<'s> {
    email: &'s EmailSettings,
    server: SmtpConnection,
    deadline: Instant,
}

impl<'s> Conversation<'s> {
    /// Connects, encrypts as the settings say, and signs in.
    fn begin(email: &'s EmailSettings, timeout: Duration) -> anyhow::Result<Self> {
        let deadline = Instant::now() + timeout;
        let hello = ClientId::Domain(host_name());
        let tls = match email.encryption {
            MailEncryption::None => None,
            _ => Some(TlsParameters::new_rustls(email.host.clone()).context("preparing encryption")?),
        };
        let at_once = tls.as_ref().filter(|_| email.encryption == MailEncryption::Tls);
        let place = (email.host.as_str(), email.port);
        let server = SmtpConnection::connect(place, Some(timeout), &hello, at_once, None)
            .map_err(|error| anyhow!("{}:{} {}", email.host, email.port, describe(&error)))?;
        let mut begun = Self { email, server, deadline };
        if let Some(tls) = tls.as_ref().filter(|_| email.encryption == MailEncryption::Starttls) {
            if !begun.server.can_starttls() {
                let text =
                    "does not offer STARTTLS; notify.email.encryption = \"tls\" is for servers that encrypt at once";
                return Err(anyhow!("{}:{} {text}", email.host, email.port));
            }
            begun.remaining()?;
            begun.server.starttls(tls, &hello).map_err(|error| begun.complaint("encryption", &error))?;
        }
        if let Some((user, file)) = &email.login {
            // Read at each mail, so that a new password needs no restart.
            let credentials = Credentials::new(user.clone(), access::read_password(file)?);
            begun.remaining()?;
            let entered = begun.server.auth(&[Mechanism::Plain, Mechanism::Login], &credentials);
            entered.map_err(|error| begun.complaint("the user or the password", &error))?;
        }
        Ok(begun)
    }

    /// One command and its answer; `what` is what the server was given.
    fn step<T>(
        &mut self,
        what: &str,
        command: impl FnOnce(&mut SmtpConnection) -> Result<T, lettre::transport::smtp::Error>,
    ) -> anyhow::Result<T> {
        self.remaining()?;
        command(&mut self.server).map_err(|error| self.complaint(what, &error))
    }

    fn add_recipient(&mut self, recipient: &Address) -> Result<(), MailError> {
        self.remaining()?;
        match self.server.command(Rcpt::new(recipient.clone(), Vec::new())) {
            Ok(_) => Ok(()),
            Err(error) if error.is_permanent() => {
                Err(MailError::NoRecipient(self.complaint(&format!("the recipient {recipient}"), &error).to_string()))
            }
            Err(error) => Err(self.complaint(&format!("the recipient {recipient}"), &error).into()),
        }
    }

    /// Has the next answer come before the deadline.
    fn remaining(&mut self) -> anyhow::Result<()> {
        let left = self.deadline.saturating_duration_since(Instant::now());
        anyhow::ensure!(!left.is_zero(), "{}:{} did not take it in time", self.email.host, self.email.port);
        self.server.set_timeout(Some(left)).context("setting a timeout")
    }

    /// Says goodbye. The mail is taken, whatever comes of that.
    fn end(mut self) {
        if self.remaining().is_ok() {
            let _ = self.server.quit();
        }
    }

    fn complaint(&self, what: &str, error: &lettre::transport::smtp::Error) -> anyhow::Error {
        let (host, port) = (&self.email.host, self.email.port);
        match error.status() {
            Some(_) => anyhow!("{host}:{port} does not accept {what}: {}", describe(error)),
            None => anyhow!("{host}:{port}, when it was given {what}: {}", describe(error)),
        }
    }
}

/// An error with its causes, on one line.
fn describe(error: &lettre::transport::smtp::Error) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(inner) = cause {
        let inner_text = inner.to_string();
        if !text.contains(&inner_text) {
            text.push_str(": ");
            text.push_str(&inner_text);
        }
        cause = inner.source();
    }
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
