//! The form that puts files into the hot folder of a machine, and what it says of them: the ticket that is written beside each.

use build_file::MAX_COPIES;
use build_file::part_endings;
use intake::Ticket;
use language::say;
use maud::{Markup, html};
use settings::{FarmZone, MachineProfile};

use crate::{
    tables::fields,
    web::core::{form_answer::key_field, state::DashboardState},
};

/// Longest text of a field.
pub(crate) const MAX_FIELD_BYTES: usize = 1000;

/// What the form says of its files; empty fields say nothing.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct DropFields {
    pub(crate) key: String,
    order: String,
    customer: String,
    email: String,
    material: String,
    finish: String,
    copies: String,
    due: String,
    due_time: String,
    orientation: String,
    priority: String,
    note: String,
}

impl DropFields {
    /// Sets the field of this name. Returns whether there is one.
    pub(crate) fn set_field(&mut self, name: &str, text: String) -> bool {
        let field = match name {
            "key" => &mut self.key,
            "order" => &mut self.order,
            "customer" => &mut self.customer,
            "email" => &mut self.email,
            "material" => &mut self.material,
            "finish" => &mut self.finish,
            "copies" => &mut self.copies,
            "due" => &mut self.due,
            "due_time" => &mut self.due_time,
            "orientation" => &mut self.orientation,
            "priority" => &mut self.priority,
            "note" => &mut self.note,
            _ => return false,
        };
        *field = text.trim().to_owned();
        true
    }

    /// The ticket to write beside each file; "" = none.
    ///
    /// # Errors
    /// In words, when a field says what no ticket may.
    pub(crate) fn to_ticket(&self, zone: &FarmZone) -> Result<String, String> {
        let mut ticket = toml::Table::new();
        let mut set = |name: &str, text: &str| {
            if !text.is_empty() {
                ticket.insert(name.to_owned(), toml::Value::String(text.to_owned()));
            }
        };
        set("order", &self.order);
        set("customer", &self.customer);
        set("email", &self.email);
        set("material", &self.material);
        set("finish", &self.finish);
        set("orientation", &self.orientation);
        set("note", &self.note);
        let due = match self.due_time.as_str() {
            "" => self.due.clone(),
            _ if self.due.is_empty() => return Err(say!("drop-time-needs-date")),
            time => format!("{} {time}", self.due),
        };
        set("due", &due);
        for (name, text) in [("copies", &self.copies), ("priority", &self.priority)] {
            if !text.is_empty() {
                let number: i64 = text.parse().map_err(|_| say!("no-whole-number", field = name, text = text))?;
                ticket.insert(name.to_owned(), number.into());
            }
        }
        let text = toml::to_string(&ticket).map_err(|error| error.to_string())?;
        let read = Ticket::from_toml(&text, "of this form").map_err(|error| error.to_string())?;
        let instant = read.due.map(|due| due.to_timestamp(zone.time_zone())).transpose();
        instant.map_err(|error| format!("due: {error}"))?;
        Ok(text)
    }
}

/// The endings that the dialog of a browser offers.
fn accepted_endings() -> String {
    part_endings().chain(["zip"]).map(|ending| format!(".{ending}")).collect::<Vec<_>>().join(",")
}

/// The form. `at` distinguishes its fields from those of the other forms of a page.
pub(crate) fn drop_form(web: &DashboardState, profile: &MachineProfile, max_bytes: u64) -> Markup {
    let name = profile.name.as_str();
    html! {
        form.tell.drop method="post" enctype="multipart/form-data" action=(format!("/machines/{name}/files"))
            data-max-bytes=(max_bytes) data-machine=(name) {
            (key_field(web))
            label.files { (say!("files-of", formats = say!("drop-formats"))) input name="file" type="file" multiple required accept=(accepted_endings()); }
            div.pair {
                label { (fields::ORDER.said()) input name="order" maxlength="200"; }
                label { (fields::CUSTOMER.said()) input name="customer" maxlength="200"; }
            }
            label { (say!("drop-copies"))
                input name="copies" type="number" min="1" max=(MAX_COPIES) inputmode="numeric"; }
            div.pair {
                label { (say!("drop-due")) input name="due" type="date"; }
                label { (fields::TIME.said()) input name="due_time" type="time"; }
            }
            details {
                summary { (say!("drop-more")) }
                label { (say!("drop-orientation")) select name="orientation" {
                    option value="" { (say!("orientation-machine")) }
                    @for (word, text) in orientations() { option value=(word) { (text) } }
                } }
                label { (say!("drop-priority")) input name="priority" type="number" min="0" max="100"; }
                label { (fields::EMAIL.said()) input name="email" type="email" maxlength="200"; }
                label { (fields::MATERIAL.said()) input name="material" maxlength="200"; }
                label { (fields::FINISH.said()) input name="finish" maxlength="200"; }
                label { (fields::NOTE.said()) input name="note" maxlength="500"; }
            }
            p.chosen role="status" {}
            progress.sent max="100" value="0" hidden aria-label=(say!("files-sent-to", machine = name)) {}
            button type="submit" { (say!("add-to", machine = name)) }
        }
    }
}

/// How parts may be turned: the word of a ticket, and what it means.
fn orientations() -> [(&'static str, String); 4] {
    [
        ("free", say!("orientation-free")),
        ("upright", say!("orientation-upright")),
        ("axis", say!("orientation-axis")),
        ("fixed", say!("orientation-fixed")),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticket(fields: &[(&str, &str)]) -> Result<String, String> {
        let mut form = DropFields::default();
        for (name, text) in fields {
            assert!(form.set_field(name, (*text).to_owned()), "{name}");
        }
        form.to_ticket(&FarmZone::default())
    }

    #[test]
    fn the_formats_are_those_that_are_read() {
        let named = say!("drop-formats").to_lowercase();
        assert!(accepted_endings().split(',').all(|ending| named.contains(ending.trim_start_matches('.'))), "{named}");
    }

    #[test]
    fn the_form_writes_a_ticket_that_the_hot_folder_reads() {
        assert_eq!(ticket(&[("order", " "), ("copies", "")]).unwrap(), "", "nothing said, no ticket");
        let said = [
            ("order", "10\"42\n\\"),
            ("customer", "Brandt"),
            ("email", "anna@brandt.example"),
            ("material", "PA 12"),
            ("copies", "12"),
            ("due", "2026-11-27"),
            ("due_time", "17:00"),
            ("orientation", "upright"),
        ];
        let text = ticket(&said).unwrap();
        let read = Ticket::from_toml(&text, "t").unwrap();
        assert_eq!((read.copies, read.due.unwrap().to_string()), (Some(12), "2026-11-27 17:00".to_owned()));
        assert_eq!(read.material.as_deref(), Some("PA 12"));
        assert_eq!(read.email.as_deref(), Some("anna@brandt.example"));
        assert!(read.order.unwrap().starts_with("10\"42") && read.customer.as_deref() == Some("Brandt"));
        for wrong in [
            ("email", "nobody"),
            ("copies", "0"),
            ("copies", "many"),
            ("due", "tomorrow"),
            ("due_time", "17:00"),
            ("priority", "101"),
            ("orientation", "sideways"),
        ] {
            assert!(ticket(&[wrong]).is_err(), "{wrong:?}");
        }
    }
}
