//! A message: one event, with what it is about, as JSON that stays as it is from version to version.

use anyhow::{Context, Result};
use build_file::counted;
use jiff::Timestamp;
use serde_json::{Value, json};

use crate::{
    ledger::{BuildRow, DROPPED, EventRow, Ledger, PartRow, Refusal, Utc},
    settings::Told,
};

/// Longest detail that is told, characters; a reason may quote much of a file.
const MOST_DETAIL: usize = 4000;

/// What a receiver is told of one event.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// The same however often it is told, and no other message's: also of a ledger that was put back from a backup.
    pub id: String,
    /// What happened, as one word.
    pub kind: &'static str,
    /// Machine profile, "" = none.
    pub profile: String,
    /// Number of the part that it is about.
    pub part: Option<i64>,
    /// Number of the build that it is about.
    pub build: Option<i64>,
    /// One sentence for people.
    pub text: String,
    /// All of it, a JSON object.
    pub body: String,
}

/// The kinds of events in the ledger that are to be told; that some were dropped is told always.
pub fn kinds(events: &[Told]) -> Vec<&'static str> {
    let of = |told: &Told| -> &[&'static str] {
        match told {
            Told::Published => &["published"],
            Told::Refused => &["rejected", "refused"],
            Told::Unavailable => &["unavailable", "available"],
            Told::AtRisk => &["at_risk"],
        }
    };
    events.iter().flat_map(of).copied().chain([DROPPED]).collect()
}

impl Message {
    /// What is told of an event.
    ///
    /// # Errors
    /// When the ledger does not answer.
    pub async fn of(event: &EventRow, ledger: &Ledger) -> Result<Self> {
        let part = match event.part_id {
            Some(id) => Some(ledger.part(id).await?.context("an event is of no part")?),
            None => None,
        };
        let build = match event.build_id {
            Some(id) => Some(ledger.build(id).await?.context("an event is of no build")?),
            None => None,
        };
        let detail: String = event.detail.chars().take(MOST_DETAIL).collect();
        let text = sentence(event, &detail, part.as_ref(), build.as_ref());
        let message = Self {
            id: format!("{}@{}", event.id, event.at),
            kind: kind_of(&event.kind),
            profile: event.profile.clone(),
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

    /// A trial message.
    pub fn trial() -> Self {
        let now = Utc(Timestamp::now());
        let text = format!("A trial message of nestd on {}.", host());
        let (id, kind, profile) = (format!("trial@{now}"), "test", String::new());
        let message = Self { id, kind, profile, part: None, build: None, text, body: String::new() };
        message.with_body(now, json!({ "reason": null, "detail": "", "part": null, "build": null }))
    }

    fn with_body(mut self, at: Utc, more: Value) -> Self {
        let mut body = json!({
            "id": self.id,
            "kind": self.kind,
            "at": at,
            "host": host(),
            "profile": self.profile,
            "text": self.text,
        });
        if let (Some(body), Value::Object(more)) = (body.as_object_mut(), more) {
            body.extend(more);
        }
        self.body = body.to_string();
        self
    }
}

/// The word of a message for the word of an event.
fn kind_of(event: &str) -> &'static str {
    match event {
        "published" => "published",
        "rejected" | "refused" => "refused",
        "unavailable" => "unavailable",
        "available" => "available",
        "at_risk" => "at-risk",
        _ => "dropped",
    }
}

fn sentence(event: &EventRow, detail: &str, part: Option<&PartRow>, build: Option<&BuildRow>) -> String {
    let profile = &event.profile;
    let first = detail.lines().next().unwrap_or_default();
    match (kind_of(&event.kind), part, build) {
        ("published", _, Some(build)) => {
            let (copies, height_mm) =
                (build.measures.copies.unwrap_or_default(), build.measures.height_mm.unwrap_or_default());
            format!(
                "Build {} of {profile} is in the queue: {}, {height_mm:.2} mm high.",
                build.id,
                counted(copies, "copy", "copies")
            )
        }
        ("refused", Some(part), _) if event.cause == Refusal::Cancelled.to_string() => {
            format!("Part {} ({}) of {profile} was taken out. {first}", part.id, part.name)
        }
        ("refused", Some(part), _) => format!("Part {} ({}) of {profile} was refused: {first}", part.id, part.name),
        ("refused", None, _) => format!("A file was refused in {profile}: {first}"),
        ("unavailable", ..) => first.to_owned(),
        ("available", ..) => format!("{profile} is available again."),
        ("at-risk", ..) => format!("{profile}: {first}"),
        _ => format!("Messages were dropped: {first}."),
    }
}

fn part_json(part: &PartRow) -> Value {
    json!({
        "number": part.id, "name": part.name, "object_name": part.solid.object_name, "order": part.terms.order_name,
        "copies": part.copies, "state": part.state, "due_at": part.terms.due_at, "note": part.terms.note,
    })
}

fn build_json(build: &BuildRow) -> Value {
    json!({
        "number": build.id, "file": build.staged.file_name, "state": build.state, "copies": build.measures.copies,
        "height_mm": build.measures.height_mm, "density": build.measures.density, "layers": build.measures.layers,
    })
}

fn host() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}
