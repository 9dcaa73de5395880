//! A message describes one event as JSON. Its format is stable across versions.

use anyhow::{Context, Result};
use build_file::format_count;
use jiff::Timestamp;
use ledger::{BuildRow, BuildState, EventKind, EventRow, Ledger, PartRow, PartState, RefusalCause, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;
use settings::NotificationKind;

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
    /// Something needs a person.
    Alert,
    /// Messages were dropped.
    Dropped,
    /// A test of the receivers.
    Test,
}

/// A message as JSON.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "Message")]
pub struct MessageBody {
    /// Its unique id: the number of its event, and its time. It is the same at every delivery, and stays unique when the ledger is
    /// restored from a backup.
    pub id: String,
    /// What happened: published, refused, unavailable, available, at-risk, order-complete, order-short, put-out, no-room, alert or dropped.
    pub kind: &'static str,
    /// When it happened.
    pub at: UtcTimestamp,
    /// The server that tells it.
    pub host: String,
    /// Machine; "" = none.
    pub machine: String,
    /// One sentence for people.
    pub text: String,
    /// Of a refusal its cause, of an alert its kind, one word.
    pub reason: Option<String>,
    /// Further details.
    pub detail: String,
    /// The part that it is about, as it is now.
    pub part: Option<MessagePart>,
    /// The build that it is about, as it is now.
    pub build: Option<MessageBuild>,
}

/// The part that a message is about.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MessagePart {
    /// Its number.
    number: i64,
    /// Name of its file.
    name: String,
    /// Name of the object in that file; "" = it has none.
    object_name: String,
    /// Order; "" = none.
    order: String,
    /// Who it is for; "" = not said.
    customer: String,
    /// Copies wanted.
    copies: u32,
    /// Its state.
    state: PartState,
    /// When it is due.
    due_at: Option<UtcTimestamp>,
    /// That date as it was given; "" = none.
    due_text: String,
    /// Free text of the ticket.
    note: String,
}

/// The build that a message is about.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MessageBuild {
    /// Its number.
    number: i64,
    /// Name of its file.
    file: Option<String>,
    /// Its state.
    state: BuildState,
    /// Number of placed copies.
    copies: Option<u32>,
    /// Its height, mm.
    height_mm: Option<f64>,
    /// Its density.
    density: Option<f64>,
    /// Number of its layers.
    layers: Option<u32>,
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
    pub json: MessageBody,
    /// The same as text.
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
        NotificationKind::Alert => vec![EventKind::Alert],
    };
    events.iter().flat_map(kinds_of).chain([EventKind::MessagesDropped]).collect()
}

/// The id of the message about an event.
pub fn message_id(event: &EventRow) -> String {
    format!("{}@{}", event.id, event.at)
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
        let json = MessageBody {
            id: message_id(event),
            kind: MessageKind::of_event(&event.kind).word(),
            at: event.at,
            host: host_name(),
            machine: event.machine.clone(),
            text,
            reason: Some(event.cause.clone()).filter(|cause| !cause.is_empty()),
            detail,
            part: part.as_ref().map(MessagePart::from),
            build: build.as_ref().map(MessageBuild::from),
        };
        Ok(Self::of_json(MessageKind::of_event(&event.kind), json))
    }

    /// A message for a test of the receivers.
    pub fn trial_message() -> Self {
        let now = UtcTimestamp(Timestamp::now());
        let json = MessageBody {
            id: format!("trial@{now}"),
            kind: MessageKind::Test.word(),
            at: now,
            host: host_name(),
            machine: String::new(),
            text: format!("A test message from nestd on {}.", host_name()),
            reason: None,
            detail: String::new(),
            part: None,
            build: None,
        };
        Self::of_json(MessageKind::Test, json)
    }

    fn of_json(kind: MessageKind, json: MessageBody) -> Self {
        Self {
            id: json.id.clone(),
            kind,
            machine: json.machine.clone(),
            part: json.part.as_ref().map(|part| part.number),
            build: json.build.as_ref().map(|build| build.number),
            text: json.text.clone(),
            body: json!(json).to_string(),
            json,
        }
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
            EventKind::Alert => Self::Alert,
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
            Self::Alert => "alert",
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
        (MessageKind::Alert, ..) => alert_text(machine, detail),
        _ => format!("Messages were dropped: {first}."),
    }
}

/// An alert as one text: what is wrong, what was found, and what to do.
fn alert_text(machine: &str, detail: &str) -> String {
    let words = AlertWords::of_detail(detail);
    let place = if machine.is_empty() { String::new() } else { format!("{machine}: ") };
    let found = if words.found.is_empty() { String::new() } else { format!(": {}", words.found) };
    format!("{place}{}{found}. {}", words.headline, words.remedy)
}

/// What the event of an alert says, a line for each.
pub(super) struct AlertWords<'e> {
    /// What is wrong in general.
    pub headline: &'e str,
    /// What was found; "" = the headline says everything.
    pub found: &'e str,
    /// What to do.
    pub remedy: &'e str,
}

impl<'e> AlertWords<'e> {
    /// Takes the lines of an event's detail.
    pub fn of_detail(detail: &'e str) -> Self {
        let mut lines = detail.lines();
        let mut next = || lines.next().unwrap_or_default();
        Self { headline: next(), found: next(), remedy: next() }
    }
}

impl From<&PartRow> for MessagePart {
    fn from(part: &PartRow) -> Self {
        Self {
            number: part.id.0,
            name: part.name.clone(),
            object_name: part.solid.object_name.clone(),
            order: part.terms.order_name.clone(),
            customer: part.terms.customer.clone(),
            copies: part.wanted_copies(),
            state: part.state,
            due_at: part.terms.due_at,
            due_text: part.terms.due_text.clone(),
            note: part.terms.note.clone(),
        }
    }
}

impl From<&BuildRow> for MessageBuild {
    fn from(build: &BuildRow) -> Self {
        Self {
            number: build.id.0,
            file: build.staged.file_name.clone(),
            state: build.state,
            copies: build.measures.copies,
            height_mm: build.measures.height_mm,
            density: build.measures.density,
            layers: build.measures.layers,
        }
    }
}

/// The name of this server.
pub(super) fn host_name() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}
