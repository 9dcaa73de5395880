//! Commands from the pages: they go through the ledger, like those of the command line, and the daemon answers them.

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
    error::{HandlerError, HandlerResult},
    page,
    state::DashboardState,
};
use crate::ledger::{CommandArgument, CommandKind, CommandState, NewCommand, PartId};

/// How long the page waits for the daemon's answer.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);
/// Time between two checks for the answer.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The form that a command button sends.
#[derive(Debug, Deserialize)]
pub(super) struct CommandForm {
    key: String,
    kind: CommandKind,
    #[serde(default)]
    profile: String,
    part: Option<i64>,
}

/// A button that sends a command to the daemon. `about` completes the label for screen readers.
pub(super) fn command_button(
    web: &DashboardState,
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

/// Sends a command to the daemon, then shows the page of its button again, or why the command was refused.
pub(super) async fn post_command(
    State(web): State<Arc<DashboardState>>,
    Form(order): Form<CommandForm>,
) -> HandlerResult<Response> {
    if !web.orders {
        let text = "this farm takes no orders from pages; see web.orders".to_owned();
        return Err(HandlerError::Refused(StatusCode::FORBIDDEN, text));
    }
    if order.key != web.form_key {
        let text = "the page is older than the daemon: load it again and press once more".to_owned();
        return Err(HandlerError::Refused(StatusCode::FORBIDDEN, text));
    }
    let back = match (order.part, order.kind) {
        (Some(part), CommandKind::Retry | CommandKind::Cancel) => format!("/parts/{part}"),
        (None, CommandKind::Flush | CommandKind::Pause | CommandKind::Resume)
            if web.current_settings().profiles.contains_key(&order.profile) =>
        {
            "/".to_owned()
        }
        _ => return Err(HandlerError::NotFound("such order".to_owned())),
    };
    let command = NewCommand {
        kind: order.kind,
        profile: order.profile,
        part: order.part.map(PartId),
        argument: CommandArgument::default(),
        asked_by: "dashboard".to_owned(),
    };
    let id = web.ledger.submit_command(&command).await?;
    let asked = std::time::Instant::now();
    while asked.elapsed() < ANSWER_TIMEOUT {
        tokio::time::sleep(POLL_INTERVAL).await;
        match web.ledger.find_command(id).await? {
            Some(row) if row.state == CommandState::Done => return Ok(Redirect::to(&back).into_response()),
            Some(row) if row.state == CommandState::Refused => return Ok(result_page("Refused", &row.answer, &back)),
            _ => {}
        }
    }
    Ok(result_page(
        "Not answered yet",
        "the daemon has not answered; the order is noted and is done when it runs",
        &back,
    ))
}

fn result_page(title: &str, text: &str, back: &str) -> Response {
    let content = html! {
        h1 { (title) }
        p role="status" { (text) "." }
        p { a href=(back) { "Back" } }
    };
    page::html_page(title, "", None, &content).into_response()
}
