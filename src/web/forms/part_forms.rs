//! The forms of the page of a part: what was asked with it is changed, it moves to another machine, printed copies are
//! printed again. The daemon carries out the first two, like `nestd edit` and `nestd move`.

use std::sync::Arc;

use access::Role;
use axum::{
    Form,
    extract::{Path, State},
    http::StatusCode,
};
use build_file::{MAX_COPIES, MAX_PRIORITY};
use language::say;
use ledger::{
    CommandArgument, CommandKind, NewCommand, OperatorWord, PartEdit, PartId, PartRow, PartState, QuestionKind,
    ReprintTarget,
};
use maud::{Markup, html};
use serde::Deserialize;
use settings::FarmZone;

use super::{build_forms::MAX_NOTE, operate_form::say_word};
use crate::{
    tables::fields,
    web::{
        base::error::{HandlerError, HandlerResult},
        core::{
            command::send_commands,
            form_answer::{FormAnswer, key_field},
            request_user::RequestUser,
            state::DashboardState,
        },
        look::pieces::sheet,
    },
};

/// The form that changes what was asked. Each field comes with the value that the page showed, so that only what a
/// person changed is changed.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct PartEditForm {
    copies: String,
    was_copies: String,
    due: String,
    was_due: String,
    priority: String,
    was_priority: String,
    note: String,
    was_note: String,
    customer: String,
    was_customer: String,
    email: String,
    was_email: String,
    material: String,
    was_material: String,
    finish: String,
    was_finish: String,
}

/// The form that prints copies of a part again.
#[derive(Debug, Deserialize)]
pub(crate) struct ReprintForm {
    #[serde(default)]
    copies: String,
    /// Sent if it is meant although the file of a build lies in the queue.
    anyway: Option<String>,
}

/// The forms for a part, each a button with its sheet. `printed` is the number of its copies in published builds that count.
pub(crate) fn part_forms(web: &DashboardState, part: &PartRow, printed: u32) -> Markup {
    let can_edit = matches!(part.state, PartState::Waiting | PartState::Batched | PartState::Built);
    let can_move = part.state == PartState::Waiting && web.current_settings().profiles.len() > 1;
    html! {
        @if web.offers(Role::Order) {
            @if can_edit { (sheet("edit", &say!("edit"), false, &edit_form(web, part))) }
            @if can_move { (sheet("move", &say!("move-to"), false, &move_form(web, part))) }
            @if printed > 0 && web.offers(Role::Operate) { (sheet("reprint", &say!("print-again"), false, &reprint_form(web, part.id, printed))) }
        }
    }
}

fn edit_form(web: &DashboardState, part: &PartRow) -> Markup {
    let field = |label: &str, name: &str, value: &str| {
        html! {
            label { (label) input name=(name) value=(value) maxlength=(MAX_NOTE); }
            input type="hidden" name=(format!("was_{name}")) value=(value);
        }
    };
    let number = |label: &str, name: &str, value: &str, (least, most): (u32, u32)| {
        html! {
            label { (label) input type="number" name=(name) value=(value) min=(least) max=(most); }
            input type="hidden" name=(format!("was_{name}")) value=(value);
        }
    };
    // Where it is asked for, whatever is said answers it, also the number that it was taken as.
    let copies = match QuestionKind::of_part(part).contains(&QuestionKind::Copies) {
        true => String::new(),
        false => part.wanted_copies().to_string(),
    };
    html! {
            form.tell method="post" action=(format!("/parts/{}/edit", part.id)) {
                (key_field(web))
                (number(&say!("copies-wanted"), "copies", &copies, (1, MAX_COPIES)))
                @if part.state == PartState::Waiting {
                    (field(&say!("due-example"), "due", &due_text(part)))
                    (number(&say!("priority-range"), "priority", &part.terms.priority.to_string(), (0, MAX_PRIORITY.into())))
                    (field(&fields::MATERIAL.said(), "material", &part.terms.material))
                    (field(&fields::NOTE.said(), "note", &part.terms.note))
                } @else {
                    p { (say!("no-copy-waits")) }
                }
                (field(&fields::FINISH.said(), "finish", &part.terms.finish))
                (field(&fields::CUSTOMER.said(), "customer", &part.terms.customer))
                (field(&fields::EMAIL.said(), "email", &part.terms.email))
                button type="submit" { (say!("change")) }
            }
    }
}

fn move_form(web: &DashboardState, part: &PartRow) -> Markup {
    let settings = web.current_settings();
    let others: Vec<&String> = settings.profiles.keys().filter(|name| **name != part.machine).collect();
    html! {
        form.tell method="post" action="/commands" {
            (key_field(web))
            input type="hidden" name="kind" value=(CommandKind::Move);
            input type="hidden" name="part" value=(part.id);
            label { (fields::MACHINE.said()) select name="machine" { @for name in &others { option value=(name) { (name) } } } }
            p { (say!("move-part-text")) }
            button type="submit" { (say!("move-part")) }
        }
    }
}

fn reprint_form(web: &DashboardState, part: PartId, printed: u32) -> Markup {
    html! {
        form.tell method="post" action=(format!("/parts/{part}/reprint")) {
            (key_field(web))
            label { (say!("copies-that-are-bad")) input type="number" name="copies" value="1" min="1" max=(printed); }
            p { (say!("reprint-part-text")) }
            button type="submit" { (say!("print-again")) }
        }
    }
}

/// The due date as it was given.
fn due_text(part: &PartRow) -> String {
    match part.terms.due_text.as_str() {
        "" => part.terms.due_at.map(|at| at.to_string()).unwrap_or_default(),
        text => text.to_owned(),
    }
}

/// Changes what was asked with a part.
pub(crate) async fn post_edit(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(asked_by): RequestUser,
    Form(form): Form<PartEditForm>,
) -> HandlerResult<FormAnswer> {
    let part = require_part(&web, number).await?;
    let edit = form
        .to_edit(&web.current_settings().time_zone)
        .map_err(|wrong| HandlerError::Refused(StatusCode::BAD_REQUEST, wrong))?;
    let command = (!edit.is_empty()).then(|| NewCommand {
        kind: CommandKind::Edit,
        machine: String::new(),
        part: Some(part),
        argument: CommandArgument { copies: None, edit: Some(edit), ..CommandArgument::default() },
        asked_by,
    });
    send_commands(&web, command.into_iter().collect(), &format!("/parts/{number}")).await
}

/// Puts printed copies of a part back among the waiting ones.
pub(crate) async fn post_reprint(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    Form(form): Form<ReprintForm>,
) -> HandlerResult<FormAnswer> {
    let part = require_part(&web, number).await?;
    let copies = parse_number(&form.copies, 1..=MAX_COPIES, &say!("a-number-of-copies"))
        .map_err(|wrong| HandlerError::Refused(StatusCode::BAD_REQUEST, wrong))?;
    let word = OperatorWord::Reprint(ReprintTarget::Part(part, Some(copies)));
    say_word(&web, &word, &by, form.anyway.is_some(), &format!("/parts/{number}")).await
}

pub(super) async fn require_part(web: &DashboardState, number: i64) -> HandlerResult<PartId> {
    let part = web.ledger.find_part(PartId(number)).await?;
    part.map(|part| part.id).ok_or_else(|| HandlerError::NotFound(say!("part-named", part = number.to_string())))
}

impl PartEditForm {
    /// The fields that differ from what the page showed.
    pub(crate) fn to_edit(&self, zone: &FarmZone) -> Result<PartEdit, String> {
        let changed = |new: &str, old: &str| Some(new.trim().to_owned()).filter(|new| new != old.trim());
        let due = |text: String| match text.is_empty() || text.eq_ignore_ascii_case("none") {
            true => Ok(None),
            false => intake::parse_due_text(&text, zone.time_zone()).map(Some),
        };
        let copies = changed(&self.copies, &self.was_copies);
        let priority = changed(&self.priority, &self.was_priority);
        let edit = PartEdit {
            copies: copies.map(|text| parse_number(&text, 1..=MAX_COPIES, &say!("a-number-of-copies"))).transpose()?,
            priority: priority.map(|text| parse_number(&text, 0..=MAX_PRIORITY, &say!("a-priority"))).transpose()?,
            due: changed(&self.due, &self.was_due).map(due).transpose()?,
            note: changed(&self.note, &self.was_note),
            customer: changed(&self.customer, &self.was_customer),
            email: changed(&self.email, &self.was_email),
            material: changed(&self.material, &self.was_material),
            finish: changed(&self.finish, &self.was_finish),
            ..PartEdit::default()
        };
        edit.checked()
    }
}

/// Parses a number within limits.
fn parse_number<T>(text: &str, limits: std::ops::RangeInclusive<T>, what: &str) -> Result<T, String>
where
    T: std::str::FromStr + PartialOrd + std::fmt::Display,
{
    let number = text.trim().parse().ok().filter(|number| limits.contains(number));
    number.ok_or_else(|| {
        say!(
            "not-in-range",
            text = text,
            what = what,
            least = limits.start().to_string(),
            most = limits.end().to_string()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_person_changed_is_changed() {
        let shown = || PartEditForm {
            copies: "3".to_owned(),
            was_copies: "3".to_owned(),
            due: "2026-11-25".to_owned(),
            was_due: "2026-11-25".to_owned(),
            note: "a".to_owned(),
            was_note: "a".to_owned(),
            ..PartEditForm::default()
        };
        assert!(shown().to_edit(&FarmZone::default()).unwrap().is_empty());
        let edit = PartEditForm { copies: "5".to_owned(), due: String::new(), ..shown() }
            .to_edit(&FarmZone::default())
            .unwrap();
        assert_eq!(edit, PartEdit { copies: Some(5), due: Some(None), ..PartEdit::default() });
        // Where the number was asked for, nothing stood there.
        let one = PartEditForm { copies: "1".to_owned(), was_copies: String::new(), ..shown() };
        assert_eq!(one.to_edit(&FarmZone::default()).unwrap().copies, Some(1));
        for wrong in [
            PartEditForm { copies: "0".to_owned(), ..shown() },
            PartEditForm { priority: "101".to_owned(), ..shown() },
            PartEditForm { due: "soon".to_owned(), ..shown() },
        ] {
            assert!(wrong.to_edit(&FarmZone::default()).is_err(), "{wrong:?}");
        }
    }
}
