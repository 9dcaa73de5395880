//! The form that says what material is loaded in a machine.

use std::sync::Arc;

use axum::{
    Form,
    extract::{Path, State},
};
use language::say;
use ledger::{MachineStatus, OperatorWord};
use maud::{Markup, html};
use serde::Deserialize;

use super::operate_form::say_word;
use crate::{
    tables::fields,
    web::{
        base::error::{HandlerError, HandlerResult},
        core::{
            form_answer::{FormAnswer, key_field},
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
}

/// The form of a machine.
pub(crate) fn load_form(web: &DashboardState, status: &MachineStatus) -> Markup {
    html! {
        @if web.orders {
            form.tell method="post" action=(format!("/machines/{}/load", status.machine)) {
                (key_field(web))
                label { (fields::LOADED.said()) input name="material" value=(status.material) maxlength=(MAX_LETTERS); }
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
    let word = OperatorWord::Load { machine, material: form.material.trim().to_owned() };
    say_word(&web, &word, &by, false, "/").await
}
