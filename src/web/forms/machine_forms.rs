//! The forms of a machine: what material is loaded, and which of its printers is out of use. As `nestd machine load` and `nestd printer`.

use std::sync::Arc;

use access::Role;
use axum::{
    Form,
    extract::{Path, State},
};
use farm::PrinterFact;
use language::{colon, say};
use ledger::{DownPrinter, MachineStatus, OperatorWord};
use maud::{Markup, html};
use serde::Deserialize;

use super::{build_forms::MAX_NOTE, operate_form::say_word};
use crate::{
    tables::fields,
    web::{
        base::error::{HandlerError, HandlerResult},
        core::{
            form_answer::{FormAnswer, FormButton, key_field},
            request_user::RequestUser,
            state::DashboardState,
        },
    },
};

/// Longest name of a material, letters.
const MAX_LETTERS: usize = 60;

/// What is loaded; empty = nothing.
#[derive(Debug, Deserialize)]
pub(crate) struct LoadForm {
    material: String,
    #[serde(default)]
    lot: String,
}

/// Whether a printer is in use.
#[derive(Debug, Deserialize)]
pub(crate) struct PrinterForm {
    printer: String,
    state: PrinterTurn,
    /// Why it is down.
    #[serde(default)]
    reason: String,
}

/// Whether a printer takes builds.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum PrinterTurn {
    Down,
    Up,
}

/// The form that takes one of the printers that are in use out of it; nothing where none is.
pub(crate) fn down_form(web: &DashboardState, machine: &str, printers: &[PrinterFact]) -> Markup {
    let used: Vec<&str> = printers.iter().filter(|fact| fact.down.is_none()).map(|fact| &*fact.printer).collect();
    html! {
        @if web.offers(Role::Operate) && !used.is_empty() {
            form.tell method="post" action=(format!("/machines/{machine}/printer")) {
                (key_field(web))
                input type="hidden" name="state" value="down";
                p { (say!("printer-down-text")) }
                @match used[..] {
                    [only] => {
                        input type="hidden" name="printer" value=(only);
                        @if printers.len() > 1 { p { (fields::PRINTER.said()) (colon()) (only) } }
                    }
                    _ => { label { (fields::PRINTER.said()) select name="printer" { @for name in &used { option { (name) } } } } }
                }
                label { (fields::REASON.said()) input name="reason" maxlength=(MAX_NOTE); }
                button type="submit" { (say!("printer-down-do")) span.unseen { " " (say!("unseen-of", name = machine)) } }
            }
        }
    }
}

/// The button that puts a printer into use again.
pub(crate) fn up_form(web: &DashboardState, down: &DownPrinter) -> Markup {
    html! {
        @if web.offers(Role::Operate) {
            form.order method="post" action=(format!("/machines/{}/printer", down.machine)) {
                (key_field(web))
                input type="hidden" name="state" value="up";
                input type="hidden" name="printer" value=(down.printer);
                button type="submit" { (say!("printer-up-do")) span.unseen { " " (down.printer) } }
            }
        }
    }
}

/// The form of what is loaded.
pub(crate) fn load_form(web: &DashboardState, status: &MachineStatus) -> Markup {
    html! {
        @if web.offers(Role::Operate) {
            form.tell method="post" action=(format!("/machines/{}/load", status.machine)) {
                (key_field(web))
                label { (fields::LOADED.said()) input name="material" value=(status.material) maxlength=(MAX_LETTERS); }
                label { (fields::LOT.said()) input name="lot" value=(status.lot) maxlength=(MAX_LETTERS); }
                p { (say!("load-text")) }
                button type="submit" { (say!("load")) span.unseen { " " (say!("unseen-of", name = &status.machine)) } }
            }
        }
    }
}

/// Says what is loaded.
pub(crate) async fn post_load(
    State(web): State<Arc<DashboardState>>,
    Path(machine): Path<String>,
    RequestUser(by): RequestUser,
    Form(form): Form<LoadForm>,
) -> HandlerResult<FormAnswer> {
    if !web.current_settings().profiles.contains_key(&machine) {
        return Err(HandlerError::NotFound(say!("machine-named", machine = &machine)));
    }
    let (material, lot) = (form.material.trim().to_owned(), form.lot.trim().to_owned());
    let word = OperatorWord::Load { machine, material, lot };
    say_word(&web, &word, &by, false, "/").await
}

/// Takes a printer out of use, or puts it into use again.
pub(crate) async fn post_printer(
    State(web): State<Arc<DashboardState>>,
    Path(machine): Path<String>,
    RequestUser(by): RequestUser,
    Form(PrinterForm { printer, state, reason }): Form<PrinterForm>,
) -> HandlerResult<FormAnswer> {
    let settings = web.current_settings();
    let has =
        |name: &str| settings.profiles.get(name).is_some_and(|of| of.printers.iter().any(|one| one.name == printer));
    if !has(&machine) {
        return Err(HandlerError::NotFound(say!("printer-named", printer = &printer)));
    }
    let address = format!("/machines/{machine}/printer");
    let undo = FormButton::undo(&address, &[("state", "up".to_owned()), ("printer", printer.clone())]);
    let (word, undo) = match state {
        PrinterTurn::Up => (OperatorWord::PrinterUp { machine, printer }, None),
        PrinterTurn::Down => {
            let reason = reason.trim().to_owned();
            (OperatorWord::PrinterDown { machine, printer, reason }, Some(undo))
        }
    };
    Ok(say_word(&web, &word, &by, false, "/").await?.or_undo(undo))
}
