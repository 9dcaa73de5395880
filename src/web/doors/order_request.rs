//! What a request orders: lines with files that were put, and what a ticket can say of each. It is checked by what reads tickets.

use std::collections::HashSet;

use intake::{Ticket, TicketError, check_upload_name, is_content_hash, read_copies_in_name};
use jiff::Timestamp;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use settings::{FarmZone, MachineProfile};

/// Lines of one request.
pub(crate) const MAX_LINES: usize = 500;

/// An order, or lines that are added to one.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "OrderRequest")]
pub(crate) struct OrderRequest {
    /// The name of the machine that prints it.
    pub machine: String,
    /// Name of the order. Left out where the address names it.
    #[serde(default)]
    pub order: String,
    /// Who it is for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub customer: Option<String>,
    /// Where the customer gets e-mail when the order is complete.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub email: Option<String>,
    /// When lines are due that do not say it themselves: a day, or a time.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub due: Option<Value>,
    /// Priority of lines that do not say it themselves, 0 to 100; 50 unless said.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<u8>")]
    pub priority: Option<Value>,
    /// Note for lines that have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Its lines, 1 to 500, each with another name.
    pub lines: Vec<LineRequest>,
}

/// A line: a file and its copies.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LineRequest {
    /// File name, such as bracket.stl. A later line of the same name in the same order is a revision of a part that still waits.
    pub name: String,
    /// BLAKE3 of a file that was put before, 64 hex digits. Left out where the file of that name is part of the request.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub content: Option<String>,
    /// Copies, 1 to 10000. Unless said, what the name says, such as bracket_x4.stl, else 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<u32>")]
    pub copies: Option<Value>,
    /// When it is due: 2026-11-25 (the end of that day) or 2026-11-25T17:00:00Z.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub due: Option<Value>,
    /// Priority, 0 to 100. A part with 100 must be in the next build.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<u8>")]
    pub priority: Option<Value>,
    /// How it may be turned: free, upright, axis or fixed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub orientation: Option<Value>,
    /// Directions of the mesh that must point nearly straight up, as in tickets.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<KeepUp>>")]
    pub keep_up: Option<Value>,
    /// Faces, by their outward normals, that must not face down, as in tickets: the normal alone is understood, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<NotDown>>")]
    pub not_down: Option<Value>,
    /// Its own clearance, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<f64>")]
    pub clearance_mm: Option<Value>,
    /// Unit of the file: mm, cm, m, inch, ft or micron.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub unit: Option<Value>,
    /// Note for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// What it is to be made of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Finishing steps after the print, such as "dye black, smooth".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finish: Option<String>,
    /// Whether a mesh that is not closed may be mended; without it such a line is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mend: Option<bool>,
}

/// A direction of the mesh that must point nearly straight up. Tickets read it; this describes it.
#[derive(JsonSchema)]
#[allow(dead_code)]
struct KeepUp {
    /// The direction, of any length, in the frame of the mesh.
    direction: [f64; 3],
    /// The greatest angle between it and straight up, degrees.
    within_deg: f64,
}

/// A face that must not look down. Tickets read it; this describes it.
#[derive(JsonSchema)]
#[allow(dead_code)]
struct NotDown {
    /// Its outward normal, of any length, in the frame of the mesh.
    direction: [f64; 3],
    /// The least angle between it and straight down, degrees.
    spare_deg: f64,
}

/// A line that was checked.
#[derive(Debug, Clone)]
pub(crate) struct CheckedLine {
    pub name: String,
    pub content: String,
    pub ticket: Ticket,
    /// The ticket as the claim holds it.
    pub ticket_text: String,
    /// Copies ordered.
    pub copies: u32,
}

impl OrderRequest {
    /// What two requests have in common that ask for the same: BLAKE3 of all that is asked, 64 hex digits.
    pub(crate) fn fingerprint(&self) -> String {
        blake3::hash(serde_json::to_string(self).unwrap_or_default().as_bytes()).to_hex().to_string()
    }

    /// Checks every line.
    ///
    /// # Errors
    /// All that is wrong, a line of text each.
    pub(super) fn check_lines(&self, profile: &MachineProfile) -> Result<Vec<CheckedLine>, String> {
        let (mut checked, mut wrong, mut names) = (Vec::new(), Vec::new(), HashSet::new());
        if self.order.trim().is_empty() {
            wrong.push("an order needs a name: say order = \"..\"".to_owned());
        }
        if self.lines.is_empty() || self.lines.len() > MAX_LINES {
            wrong.push(format!("an order has 1 to {MAX_LINES} lines; this one has {}", self.lines.len()));
        }
        for (at, line) in self.lines.iter().enumerate() {
            let name = line.name.trim();
            match line.check_line(self, profile) {
                Ok(_) if !names.insert(intake::fold_name(name)) => {
                    wrong.push(format!(
                        "line {}: another line is called {name}, too: a later one would replace it",
                        at + 1
                    ));
                }
                Ok(line) => checked.push(line),
                Err(why) => wrong.push(format!("line {} ({}): {why}", at + 1, build_file::escape_invisible(name))),
            }
        }
        if wrong.is_empty() { Ok(checked) } else { Err(wrong.join("\n")) }
    }
}

impl LineRequest {
    fn check_line(&self, order: &OrderRequest, profile: &MachineProfile) -> Result<CheckedLine, String> {
        let name = self.name.trim();
        let is_plain = check_upload_name(name).map_err(|error| error.to_string())? == *name;
        if !is_plain {
            return Err("a name has no folders".to_owned());
        }
        let content = self.content.clone().unwrap_or_default();
        if !is_content_hash(&content) {
            return Err(match content.is_empty() {
                true => "it names no content, and no file of that name came with the request".to_owned(),
                false => format!("content = {content:?}; it must be a BLAKE3, 64 digits of 0-9 and a-f"),
            });
        }
        let (ticket, ticket_text) = self.read_ticket(order)?;
        due_of(&ticket, &profile.time_zone)?;
        profile
            .materials
            .require_name(ticket.material.as_deref().unwrap_or_default())
            .map_err(|error| error.to_string())?;
        let copies = ticket.copies.unwrap_or(1);
        Ok(CheckedLine { name: name.to_owned(), content, ticket, ticket_text, copies })
    }

    /// The ticket that it stands for, and its text.
    pub(crate) fn read_ticket(&self, order: &OrderRequest) -> Result<(Ticket, String), String> {
        let name = self.name.trim();
        let text = Value::Object(self.ticket_fields(order, name)?).to_string();
        let ticket = Ticket::from_json(&text, name).map_err(|error| match error {
            TicketError::Broken { why, .. } => why,
            other => other.to_string(),
        })?;
        Ok((ticket, text))
    }

    /// The fields of its ticket.
    fn ticket_fields(&self, order: &OrderRequest, name: &str) -> Result<Map<String, Value>, String> {
        let copies = match &self.copies {
            Some(copies) => copies.clone(),
            None => json!(read_copies_in_name(name).number().map_err(|why| format!("{why}: say copies"))?),
        };
        let fields = [
            ("copies", Some(copies)),
            ("order", Some(json!(order.order.trim()))),
            ("customer", order.customer.as_ref().map(|customer| json!(customer))),
            ("email", order.email.as_ref().map(|email| json!(email))),
            ("due", self.due.clone().or_else(|| order.due.clone())),
            ("priority", self.priority.clone().or_else(|| order.priority.clone())),
            ("orientation", self.orientation.clone()),
            ("keep_up", self.keep_up.clone()),
            ("not_down", self.not_down.clone()),
            ("clearance_mm", self.clearance_mm.clone()),
            ("unit", self.unit.clone()),
            ("material", self.material.as_ref().map(|material| json!(material))),
            ("finish", self.finish.as_ref().map(|finish| json!(finish))),
            ("mend", self.mend.map(|mend| json!(mend))),
            ("note", self.note.as_ref().or(order.note.as_ref()).map(|note| json!(note))),
        ];
        Ok(fields.into_iter().filter_map(|(field, value)| Some((field.to_owned(), value?))).collect())
    }
}

/// When a ticket is due, if it says so.
pub(crate) fn due_of(ticket: &Ticket, zone: &FarmZone) -> Result<Option<Timestamp>, String> {
    let at = ticket.due.map(|due| due.to_timestamp(zone.time_zone())).transpose();
    at.map_err(|error| format!("its due date is no date here: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile() -> MachineProfile {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("profiles")).unwrap();
        std::fs::write(folder.path().join("nestd.toml"), "time_zone = \"Europe/Berlin\"\n").unwrap();
        std::fs::write(folder.path().join("profiles/cube.toml"), "volume_mm = [200, 200, 200]\n").unwrap();
        let settings = settings::load_settings(Some(&folder.path().join("nestd.toml")), Some(folder.path())).unwrap();
        settings.profiles["cube"].clone()
    }

    fn request(text: &str) -> OrderRequest {
        let hash = "0".repeat(64);
        serde_json::from_str(&text.replace("HASH", &hash)).unwrap()
    }

    #[test]
    fn a_line_becomes_the_ticket_that_a_person_would_write() {
        let order = request(
            r#"{"machine":"cube","order":" K-12 ","customer":"Brandt","email":"anna@brandt.example","due":"2026-11-25","priority":70,"lines":[
                {"name":"hinge_x4.stl","content":"HASH","material":"PA12","finish":"dye black","note":"for the door"},
                {"name":"cover.3mf","content":"HASH","copies":2,"due":"2026-11-26T17:00:00Z","orientation":"upright",
                 "keep_up":[{"direction":[0,0,1],"within_deg":30}],"clearance_mm":1.5,"unit":"inch","priority":100}]}"#,
        );
        let lines = order.check_lines(&profile()).unwrap();
        let [hinge, cover] = &lines[..] else { panic!("{lines:?}") };
        assert_eq!((hinge.copies, hinge.ticket.priority), (4, Some(70)));
        assert_eq!(hinge.ticket.order.as_deref(), Some("K-12"));
        assert_eq!(hinge.ticket.note.as_deref(), Some("for the door"));
        assert_eq!(hinge.ticket.material.as_deref(), Some("PA12"));
        assert_eq!(hinge.ticket.finish.as_deref(), Some("dye black"));
        assert_eq!(hinge.ticket.customer.as_deref(), Some("Brandt"));
        assert_eq!(hinge.ticket.email.as_deref(), Some("anna@brandt.example"));
        assert_eq!(hinge.ticket.due.unwrap().to_string(), "2026-11-25");
        assert_eq!((cover.copies, cover.ticket.priority, cover.ticket.clearance_mm), (2, Some(100), Some(1.5)));
        assert_eq!(Ticket::from_json(&cover.ticket_text, "t").unwrap(), cover.ticket);
    }

    #[test]
    fn the_same_is_asked_whatever_the_order_of_its_fields() {
        let one = request(r#"{"machine":"cube","order":"K","lines":[{"name":"a.stl","content":"HASH","copies":2}]}"#);
        let same = request(r#"{"lines":[{"copies":2,"content":"HASH","name":"a.stl"}],"order":"K","machine":"cube"}"#);
        let other = request(r#"{"machine":"cube","order":"K","lines":[{"name":"a.stl","content":"HASH","copies":3}]}"#);
        assert_eq!(one.fingerprint(), same.fingerprint());
        assert_ne!(one.fingerprint(), other.fingerprint());
    }

    #[test]
    fn whatever_a_ticket_may_not_say_is_refused_with_its_line() {
        for (line, why) in [
            (r#"{"name":"a.stl","content":"HASH","copies":0}"#, "copies = 0; it must be 1 to 10000"),
            (r#"{"name":"a.stl","content":"HASH","copies":"3"}"#, "without the quotes"),
            (r#"{"name":"a.stl","content":"HASH","priority":101}"#, "0 to 100"),
            (r#"{"name":"a.stl","content":"HASH","unit":"parsec"}"#, "parsec"),
            (r#"{"name":"a.stl","content":"HASH","due":"soon"}"#, "soon"),
            (r#"{"name":"a.stl","content":"HASH","clearance_mm":-1}"#, "clearance_mm"),
            (r#"{"name":"a.stl","content":"HASH","orientation":"sideways"}"#, "sideways"),
            (r#"{"name":"4_5_sets_x.stl","content":"HASH"}"#, "no clear number of copies"),
            (r#"{"name":"../a.stl","content":"HASH"}"#, "no folders"),
            (r#"{"name":"order.csv","content":"HASH"}"#, "list or ticket"),
            (r#"{"name":"a.stl"}"#, "names no content"),
            (r#"{"name":"a.stl","content":"abc"}"#, "BLAKE3"),
        ] {
            let order = request(&format!(r#"{{"machine":"cube","order":"K","lines":[{line}]}}"#));
            let refused = order.check_lines(&profile()).map(|_| ()).unwrap_err();
            assert!(refused.starts_with("line 1 (") && refused.contains(why), "{line}: {refused}");
        }
        let twice = r#"{"name":"a.stl","content":"HASH"},{"name":"A.STL","content":"HASH"}"#;
        for (order, lines, why) in
            [("", r#"{"name":"a.stl","content":"HASH"}"#, "name"), ("K", "", "1 to 500"), ("K", twice, "line 2")]
        {
            let order = request(&format!(r#"{{"machine":"cube","order":"{order}","lines":[{lines}]}}"#));
            assert!(order.check_lines(&profile()).unwrap_err().contains(why));
        }
    }
}
