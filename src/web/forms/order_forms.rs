//! The forms of the page of an order: what waits of it is changed, moved or cancelled, what was printed is printed again, and the order is
//! closed as it is. The forms of a line are on the page of its part.

use std::sync::Arc;

use axum::{
    Form,
    extract::{Path, State},
    http::StatusCode,
};
use ledger::{
    CommandArgument, CommandKind, LineCopies, NewCommand, OperatorWord, OrderLine, OrderRow, OrderState, PartEdit,
    PartState, ReprintTarget,
};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    build_forms::MAX_NOTE,
    operate_form::say_word,
    order_cancel::{CancelTarget, cancel_lines},
    part_forms::PartEditForm,
};
use crate::web::{
    base::{
        error::{HandlerError, HandlerResult},
        format::count,
        query::order_address,
    },
    core::{
        command::{send_commands, show_answers},
        form_answer::{FormAnswer, key_field},
        request_user::RequestUser,
        state::DashboardState,
    },
    look::pieces::sheet,
};

/// The form that moves a whole order.
#[derive(Debug, Deserialize)]
pub(crate) struct MoveOrderForm {
    /// The machine that it is moved to.
    machine: String,
}

/// The button that prints a whole order again.
#[derive(Debug, Deserialize)]
pub(crate) struct ReprintOrderForm {
    /// Sent if it is meant although the file of a build lies in the queue.
    anyway: Option<String>,
}

fn waiting_lines(lines: &[OrderLine]) -> impl Iterator<Item = &OrderLine> {
    lines.iter().filter(|line| line.state == PartState::Waiting)
}

/// The forms that concern a whole order, each a button with its sheet. `arriving` = lines that are no parts yet.
pub(crate) fn order_forms(web: &DashboardState, order: &OrderRow, lines: &[OrderLine], arriving: usize) -> Markup {
    let address = order_address(&order.name);
    let waiting = waiting_lines(lines).count() as u32;
    let read = lines.iter().filter(|line| line.state == PartState::Claimed).count();
    let open = waiting + (read + arriving) as u32;
    let is_printed = lines.iter().any(|line| line.copies.published() + line.copies.good > 0);
    html! {
        @if web.orders {
            div.buttons.acts {
                (sheet("change", "Change the order", false, &edit_form(web, order, &address, waiting)))
                @if waiting > 0 && web.current_settings().profiles.len() > 1 {
                    (sheet("move", "Move to another machine", false, &move_form(web, &address, waiting)))
                }
                @if is_printed { (sheet("reprint", "Print again", false, &reprint_form(web, &address))) }
                (close_form(web, order, &address, lines))
                @if open > 0 { (sheet("cancel", "Cancel", false, &cancel_form(web, &address, open))) }
            }
        }
    }
}

fn edit_form(web: &DashboardState, order: &OrderRow, address: &str, waiting: u32) -> Markup {
    html! {
        form.tell method="post" action=(format!("{address}/edit")) {
            (key_field(web))
            label { "Customer" input name="customer" value=(order.customer) maxlength=(MAX_NOTE); }
            input type="hidden" name="was_customer" value=(order.customer);
            @if waiting > 0 {
                p { "For all " (count(waiting, "waiting part", "waiting parts")) ". An empty field changes nothing." }
                label { "Due, for example 2026-11-25 (the end of that day) or 25.11.2026 17:00; none = no date" input name="due" maxlength=(MAX_NOTE); }
                label { "Priority, 0 to 100" input type="number" name="priority" min="0" max="100"; }
                label { "Note" input name="note" maxlength=(MAX_NOTE); }
            }
            button type="submit" { "Change the order" }
        }
    }
}

fn move_form(web: &DashboardState, address: &str, waiting: u32) -> Markup {
    html! {
        form.tell method="post" action=(format!("{address}/move")) {
            (key_field(web))
            label { "Machine" select name="machine" { @for name in web.current_settings().profiles.keys() { option value=(name) { (name) } } } }
            p { "The " (count(waiting, "waiting part", "waiting parts")) " of this order move, and are read again there." }
            button type="submit" { "Move the order" }
        }
    }
}

fn reprint_form(web: &DashboardState, address: &str) -> Markup {
    html! {
        p { "Every printed copy of this order counts as bad and waits again, first in line, with all that was asked." }
        form.tell method="post" action=(format!("{address}/reprint")) {
            (key_field(web))
            button type="submit" { "Print every printed copy again" }
        }
    }
}

/// The form that closes an order as it is; nothing where nothing of it waits or asks for a person.
fn close_form(web: &DashboardState, order: &OrderRow, address: &str, lines: &[OrderLine]) -> Markup {
    let mut sum = LineCopies::default();
    lines.iter().for_each(|line| sum.add(&line.copies));
    let is_short = order.state == OrderState::Short && !order.is_over();
    if sum.waiting + sum.refused == 0 && !is_short {
        return Markup::default();
    }
    let accept = format!("Accept {} of {}", sum.good + sum.in_builds + sum.published(), sum.wanted + sum.cancelled);
    let form = html! {
        p { "Closes the order as it is: what is good, printed or in a build is accepted."
            @if sum.waiting > 0 { " " (count(sum.waiting, "waiting copy", "waiting copies")) " will be cancelled." }
            @if sum.refused > 0 { " Nobody is asked any more for " (count(sum.refused, "refused copy", "refused copies")) "." } }
        form.tell method="post" action=(format!("{address}/close")) {
            (key_field(web))
            button type="submit" { (accept) }
        }
    };
    sheet("close", &accept, is_short, &form)
}

fn cancel_form(web: &DashboardState, address: &str, open: u32) -> Markup {
    html! {
        p { (count(open, "part waits", "parts wait")) ". Copies that are in builds already stay there." }
        form.tell method="post" action=(format!("{address}/cancel")) {
            (key_field(web))
            button type="submit" { "Cancel what waits" }
        }
    }
}

/// A command for every line of an order that it can concern.
async fn command_lines(
    web: &DashboardState,
    name: &str,
    command: impl Fn(&OrderLine) -> Option<NewCommand>,
) -> HandlerResult<FormAnswer> {
    let commands: Vec<NewCommand> = web.ledger.order_lines(name).await?.iter().filter_map(command).collect();
    if commands.is_empty() {
        return Err(nothing_waits());
    }
    send_commands(web, commands, &order_address(name)).await
}

fn nothing_waits() -> HandlerError {
    HandlerError::Refused(StatusCode::CONFLICT, "nothing of this order waits any more".to_owned())
}

/// Changes what was asked with the waiting parts of an order, and who it is for.
pub(crate) async fn post_edit(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    RequestUser(by): RequestUser,
    Form(form): Form<PartEditForm>,
) -> HandlerResult<FormAnswer> {
    let refused = |wrong| HandlerError::Refused(StatusCode::BAD_REQUEST, wrong);
    let edit: PartEdit = form.to_edit(&web.current_settings().time_zone).map_err(refused)?;
    if edit.is_empty() {
        return Err(refused("nothing was filled in".to_owned()));
    }
    let command = |line: &OrderLine| {
        let edit = Some(edit.possible_in(line.state)).filter(|edit| !edit.is_empty())?;
        Some(NewCommand {
            kind: CommandKind::Edit,
            machine: String::new(),
            part: Some(line.part),
            argument: CommandArgument { copies: None, edit: Some(edit) },
            asked_by: by.clone(),
        })
    };
    command_lines(&web, &name, command).await
}

/// Moves what waits of an order to another machine.
pub(crate) async fn post_move(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    RequestUser(by): RequestUser,
    Form(form): Form<MoveOrderForm>,
) -> HandlerResult<FormAnswer> {
    if !web.current_settings().profiles.contains_key(&form.machine) {
        return Err(HandlerError::NotFound(format!("machine {}", form.machine)));
    }
    let command = |line: &OrderLine| {
        (line.state == PartState::Waiting).then(|| NewCommand {
            kind: CommandKind::Move,
            machine: form.machine.clone(),
            part: Some(line.part),
            argument: CommandArgument::default(),
            asked_by: by.clone(),
        })
    };
    command_lines(&web, &name, command).await
}

/// Puts every printed copy of an order back among the waiting ones.
pub(crate) async fn post_reprint(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    RequestUser(by): RequestUser,
    Form(form): Form<ReprintOrderForm>,
) -> HandlerResult<FormAnswer> {
    let back = order_address(&name);
    let word = OperatorWord::Reprint(ReprintTarget::Order(name));
    say_word(&web, &word, &by, form.anyway.is_some(), &back).await
}

/// Closes an order as it is.
pub(crate) async fn post_close(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<FormAnswer> {
    let back = order_address(&name);
    say_word(&web, &OperatorWord::CloseOrder(name), &by, false, &back).await
}

/// Cancels what waits of an order.
pub(crate) async fn post_cancel(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<FormAnswer> {
    let answers = cancel_lines(&web, CancelTarget { order: &name, line: None }, &by).await?;
    match answers.is_empty() {
        true => Err(nothing_waits()),
        false => Ok(show_answers(answers, &order_address(&name))),
    }
}
