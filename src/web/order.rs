//! Orders by hand: they go through the ledger, as those of the command line do, and the daemon answers.

use std::{sync::Arc, time::Duration};

use axum::{
    Form,
    extract::State,
    http::StatusCode,
    response::{IntoResponse, Redirect, Response},
};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    page,
    problem::{Answer, Problem},
    state::Web,
};
use crate::ledger::{CommandKind, CommandState, NewCommand, PartId};

/// How long an answer is waited for.
const ANSWER_WITHIN: Duration = Duration::from_secs(5);
/// Between two looks for it.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A form with a button.
#[derive(Debug, Deserialize)]
pub(super) struct Order {
    key: String,
    kind: CommandKind,
    #[serde(default)]
    profile: String,
    part: Option<i64>,
}

/// A button that gives an order and comes back to the page `back` is of.
pub(super) fn button(
    web: &Web,
    kind: CommandKind,
    label: &str,
    about: &str,
    profile: &str,
    part: Option<PartId>,
) -> Markup {
    html! {
        @if web.orders {
            form.order method="post" action="/orders" {
                input type="hidden" name="key" value=(web.form_key);
                input type="hidden" name="kind" value=(kind);
                @if !profile.is_empty() { input type="hidden" name="profile" value=(profile); }
                @if let Some(part) = part { input type="hidden" name="part" value=(part); }
                button type="submit" { (label) span.unseen { " " (about) } }
            }
        }
    }
}

/// Takes an order and shows the page again on which it was given, or why it was refused.
pub(super) async fn order(State(web): State<Arc<Web>>, Form(order): Form<Order>) -> Answer<Response> {
    if !web.orders {
        let text = "this farm takes no orders from pages; see web.orders".to_owned();
        return Err(Problem::Refused(StatusCode::FORBIDDEN, text));
    }
    if order.key != web.form_key {
        let text = "the page is older than the daemon: load it again and press once more".to_owned();
        return Err(Problem::Refused(StatusCode::FORBIDDEN, text));
    }
    let back = match (order.part, order.kind) {
        (Some(part), CommandKind::Retry | CommandKind::Cancel) => format!("/parts/{part}"),
        (None, CommandKind::Flush | CommandKind::Pause | CommandKind::Resume)
            if web.settings().profiles.contains_key(&order.profile) =>
        {
            "/".to_owned()
        }
        _ => return Err(Problem::NotFound("such order".to_owned())),
    };
    let command = NewCommand {
        kind: order.kind,
        profile: order.profile,
        part: order.part.map(PartId),
        asked_by: "dashboard".to_owned(),
    };
    let id = web.ledger.ask(&command).await?;
    let asked = std::time::Instant::now();
    while asked.elapsed() < ANSWER_WITHIN {
        tokio::time::sleep(LOOK_EVERY).await;
        match web.ledger.command(id).await? {
            Some(row) if row.state == CommandState::Done => return Ok(Redirect::to(&back).into_response()),
            Some(row) if row.state == CommandState::Refused => return Ok(told("Refused", &row.answer, &back)),
            _ => {}
        }
    }
    Ok(told("Not answered yet", "the daemon has not answered; the order stands, and is done when it runs", &back))
}

fn told(title: &str, text: &str, back: &str) -> Response {
    let content = html! {
        h1 { (title) }
        p role="status" { (text) "." }
        p { a href=(back) { "Back" } }
    };
    page::page(title, "", None, &content).into_response()
}
