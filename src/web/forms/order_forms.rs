//! The forms of the page of an order: what waits of it is changed, moved or cancelled, what was printed is printed again, and the order is
//! closed as it is. The forms of a line are on the page of its part.

use access::Role;
use std::sync::Arc;

use axum::{
    Form,
    extract::{Path, State},
    http::StatusCode,
};
use language::say;
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
use crate::tables::fields;
use crate::web::{
    base::{
        error::{HandlerError, HandlerResult},
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

/// The forms that concern a whole order, each a button with its sheet. `emails` = where its customer gets e-mail, `arriving` = lines that
/// are no parts yet.
pub(crate) fn order_forms(
    web: &DashboardState,
    (order, emails): (&OrderRow, &[String]),
    lines: &[OrderLine],
    arriving: usize,
) -> Markup {
    let address = order_address(&order.name);
    let waiting = waiting_lines(lines).count() as u32;
    let read = lines.iter().filter(|line| line.state == PartState::Claimed).count();
    let open = waiting + (read + arriving) as u32;
    let is_printed = lines.iter().any(|line| line.copies.published() + line.copies.good > 0);
    html! {
        @if web.offers(Role::Order) {
            div.buttons.acts {
                (sheet("change", &say!("change-order"), false, &edit_form(web, (order, emails), &address, waiting)))
                @if waiting > 0 && web.current_settings().profiles.len() > 1 {
                    (sheet("move", &say!("move-to"), false, &move_form(web, &address, waiting)))
                }
                @if is_printed && web.offers(Role::Operate) { (sheet("reprint", &say!("print-again"), false, &reprint_form(web, &address))) }
                @if web.offers(Role::Operate) { (close_form(web, order, &address, lines)) }
                @if open > 0 { (sheet("cancel", &say!("cancel"), false, &cancel_form(web, &address, open))) }
            }
        }
    }
}

fn edit_form(web: &DashboardState, (order, emails): (&OrderRow, &[String]), address: &str, waiting: u32) -> Markup {
    // Of several, none stands for all.
    let email = if let [one] = emails { one } else { "" };
    html! {
        form.tell method="post" action=(format!("{address}/edit")) {
            (key_field(web))
            label { (fields::CUSTOMER.said()) input name="customer" value=(order.customer) maxlength=(MAX_NOTE); }
            input type="hidden" name="was_customer" value=(order.customer);
            label { (fields::EMAIL.said()) input name="email" type="email" value=(email) maxlength=(MAX_NOTE); }
            input type="hidden" name="was_email" value=(email);
            label { (fields::FINISH.said()) input name="finish" maxlength=(MAX_NOTE); }
            @if waiting > 0 {
                p { (say!("change-order-text", parts = waiting)) }
                label { (say!("due-example-none")) input name="due" maxlength=(MAX_NOTE); }
                label { (say!("priority-range")) input type="number" name="priority" min="0" max="100"; }
                label { (fields::MATERIAL.said()) input name="material" maxlength=(MAX_NOTE); }
                label { (fields::NOTE.said()) input name="note" maxlength=(MAX_NOTE); }
            }
            button type="submit" { (say!("change-order")) }
        }
    }
}

fn move_form(web: &DashboardState, address: &str, waiting: u32) -> Markup {
    html! {
        form.tell method="post" action=(format!("{address}/move")) {
            (key_field(web))
            label { (fields::MACHINE.said()) select name="machine" { @for name in web.current_settings().profiles.keys() { option value=(name) { (name) } } } }
            p { (say!("move-order-text", parts = waiting)) }
            button type="submit" { (say!("move-order")) }
        }
    }
}

fn reprint_form(web: &DashboardState, address: &str) -> Markup {
    html! {
        p { (say!("reprint-order-text")) }
        form.tell method="post" action=(format!("{address}/reprint")) {
            (key_field(web))
            button type="submit" { (say!("reprint-order")) }
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
    let accept =
        say!("accept-of", copies = sum.good + sum.in_builds + sum.published(), all = sum.wanted + sum.cancelled);
    let form = html! {
        p { (say!("close-order-text"))
            @if sum.waiting > 0 { " " (say!("close-cancels", copies = sum.waiting)) }
            @if sum.refused > 0 { " " (say!("close-asks-not", copies = sum.refused)) } }
        form.tell method="post" action=(format!("{address}/close")) {
            (key_field(web))
            button type="submit" { (accept) }
        }
    };
    sheet("close", &accept, is_short, &form)
}

fn cancel_form(web: &DashboardState, address: &str, open: u32) -> Markup {
    html! {
        p { (say!("cancel-order-text", parts = open)) }
        form.tell method="post" action=(format!("{address}/cancel")) {
            (key_field(web))
            button type="submit" { (say!("cancel-order")) }
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
    HandlerError::Refused(StatusCode::CONFLICT, say!("nothing-of-order-waits"))
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
        return Err(refused(say!("nothing-filled-in")));
    }
    let command = |line: &OrderLine| {
        let edit = Some(edit.possible_in(line.state)).filter(|edit| !edit.is_empty())?;
        Some(NewCommand {
            kind: CommandKind::Edit,
            machine: String::new(),
            part: Some(line.part),
            argument: CommandArgument { copies: None, edit: Some(edit), ..CommandArgument::default() },
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
        return Err(HandlerError::NotFound(say!("machine-named", machine = &form.machine)));
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
