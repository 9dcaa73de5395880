//! A message describes one event as JSON. Its format is stable across versions.

use anyhow::{Context, Result};
use build_file::format_count;
use jiff::Timestamp;
use ledger::{BuildRow, EventKind, EventRow, Ledger, PartRow, RefusalCause, UtcTimestamp};
use serde_json::{Value, json};

use crate::settings::NotificationKind;

/// Maximum length of the detail, characters; a reason may quote much of a file.
const MAX_DETAIL: usize = 4000;

/// The kind of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageKind {
    /// A build is in the queue.
    Published,
    /// A part or file was refused or cancelled.
    Refused,
    /// A machine became unavailable.
    Unavailable,
    /// A machine became available again.
    Available,
    /// A due date is at risk.
    AtRisk,
    /// Every copy of an order was printed well.
    OrderComplete,
    /// An order ended with fewer copies than were wanted.
    OrderShort,
    /// Copies left the open build for others that go first.
    PutOut,
    /// Copies of the highest priority find no place in the next build.
    NoRoom,
    /// Messages were dropped.
    Dropped,
    /// A test of the receivers.
    Test,
}

/// What a receiver gets for one event.
#[derive(Debug, Clone, PartialEq)]
pub struct EventMessage {
    /// Unique id of the message. It is the same at every delivery, and stays unique when the ledger is restored from a
    /// backup.
    pub id: String,
    /// Kind of event.
    pub kind: MessageKind,
    /// Machine, "" = none.
    pub machine: String,
    /// Number of the part that it is about.
    pub part: Option<i64>,
    /// Number of the build that it is about.
    pub build: Option<i64>,
    /// One sentence for people.
    pub text: String,
    /// The whole message as a JSON object.
    pub body: String,
}

/// The kinds of ledger events to deliver. The notice that messages were dropped is always delivered.
pub fn event_kinds(events: &[NotificationKind]) -> Vec<EventKind> {
    let kinds_of = |kind: &NotificationKind| match kind {
        NotificationKind::Published => vec![EventKind::Published],
        NotificationKind::Refused => vec![EventKind::Refused],
        NotificationKind::Unavailable => vec![EventKind::Unavailable, EventKind::Available],
        NotificationKind::AtRisk => vec![EventKind::AtRisk],
        NotificationKind::OrderComplete => vec![EventKind::OrderComplete],
        NotificationKind::OrderShort => vec![EventKind::OrderShort],
        NotificationKind::PutOut => vec![EventKind::PutOut],
        NotificationKind::NoRoom => vec![EventKind::NoRoom],
    };
    events.iter().flat_map(kinds_of).chain([EventKind::MessagesDropped]).collect()
}

impl EventMessage {
    /// Builds the message for an event.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn from_event(event: &EventRow, ledger: &Ledger) -> Result<Self> {
        let part = match event.part_id {
            Some(id) => Some(ledger.find_part(id).await?.context("an event is of no part")?),
            None => None,
        };
        let build = match event.build_id {
            Some(id) => Some(ledger.find_build(id).await?.context("an event is of no build")?),
            None => None,
        };
        let detail: String = event.detail.chars().take(MAX_DETAIL).collect();
        let text = message_text(event, &detail, part.as_ref(), build.as_ref());
        let message = Self {
            id: format!("{}@{}", event.id, event.at),
            kind: MessageKind::of_event(&event.kind),
            machine: event.machine.clone(),
            part: event.part_id.map(|id| id.0),
            build: event.build_id.map(|id| id.0),
            text,
            body: String::new(),
        };
        let more = json!({
            "reason": if event.cause.is_empty() { Value::Null } else { json!(event.cause) },
            "detail": detail,
            "part": part.as_ref().map(part_json),
            "build": build.as_ref().map(build_json),
        });
        Ok(message.with_body(event.at, more))
    }

    /// A message for a test of the receivers.
    pub fn trial_message() -> Self {
        let now = UtcTimestamp(Timestamp::now());
        let text = format!("A test message from nestd on {}.", host_name());
        let (id, kind, machine) = (format!("trial@{now}"), MessageKind::Test, String::new());
        let message = Self { id, kind, machine, part: None, build: None, text, body: String::new() };
        message.with_body(now, json!({ "reason": null, "detail": "", "part": null, "build": null }))
    }

    fn with_body(mut self, at: UtcTimestamp, more: Value) -> Self {
        let mut body = json!({
            "id": self.id,
            "kind": self.kind.word(),
            "at": at,
            "host": host_name(),
            "machine": self.machine,
            "text": self.text,
        });
        if let (Some(body), Value::Object(more)) = (body.as_object_mut(), more) {
            body.extend(more);
        }
        self.body = body.to_string();
        self
    }
}

impl MessageKind {
    /// The kind of message for a kind of event in the ledger.
    fn of_event(event: &EventKind) -> Self {
        match event {
            EventKind::Published => Self::Published,
            EventKind::Refused => Self::Refused,
            EventKind::Unavailable => Self::Unavailable,
            EventKind::Available => Self::Available,
            EventKind::AtRisk => Self::AtRisk,
            EventKind::OrderComplete => Self::OrderComplete,
            EventKind::OrderShort => Self::OrderShort,
            EventKind::PutOut => Self::PutOut,
            EventKind::NoRoom => Self::NoRoom,
            _ => Self::Dropped,
        }
    }

    /// The word in messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Refused => "refused",
            Self::Unavailable => "unavailable",
            Self::Available => "available",
            Self::AtRisk => "at-risk",
            Self::OrderComplete => "order-complete",
            Self::OrderShort => "order-short",
            Self::PutOut => "put-out",
            Self::NoRoom => "no-room",
            Self::Dropped => "dropped",
            Self::Test => "test",
        }
    }
}

fn message_text(event: &EventRow, detail: &str, part: Option<&PartRow>, build: Option<&BuildRow>) -> String {
    let machine = &event.machine;
    let first = detail.lines().next().unwrap_or_default();
    match (MessageKind::of_event(&event.kind), part, build) {
        (MessageKind::Published, _, Some(build)) => {
            let (copies, height_mm) =
                (build.measures.copies.unwrap_or_default(), build.measures.height_mm.unwrap_or_default());
            format!(
                "Build {} of {machine} is in the queue: {}, {height_mm:.2} mm high.",
                build.id,
                format_count(copies, "copy", "copies")
            )
        }
        (MessageKind::Refused, Some(part), _) if event.cause == RefusalCause::Cancelled.to_string() => {
            format!("Part {} ({}) of {machine} was taken out. {first}", part.id, part.name)
        }
        (MessageKind::Refused, Some(part), _) => {
            format!("Part {} ({}) of {machine} was refused: {first}", part.id, part.name)
        }
        (MessageKind::Refused, None, _) => format!("A file was refused in {machine}: {first}"),
        (MessageKind::Unavailable, ..) => first.to_owned(),
        (MessageKind::Available, ..) => format!("{machine} is available again."),
        (MessageKind::AtRisk | MessageKind::PutOut | MessageKind::NoRoom, ..) => format!("{machine}: {first}"),
        (MessageKind::OrderComplete, ..) => format!("Complete: {first}."),
        (MessageKind::OrderShort, ..) => format!("Short: {first}."),
        _ => format!("Messages were dropped: {first}."),
    }
}

fn part_json(part: &PartRow) -> Value {
    json!({
        "number": part.id, "name": part.name, "object_name": part.solid.object_name, "order": part.terms.order_name,
        "customer": part.terms.customer,
        "copies": part.owed.copies, "state": part.state, "due_at": part.terms.due_at,
        "due_text": part.terms.due_text, "note": part.terms.note,
    })
}

fn build_json(build: &BuildRow) -> Value {
    json!({
        "number": build.id, "file": build.staged.file_name, "state": build.state, "copies": build.measures.copies,
        "height_mm": build.measures.height_mm, "density": build.measures.density, "layers": build.measures.layers,
    })
}

fn host_name() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}
