//! Commands from the pages: they go through the ledger, like those of the command line, and the daemon answers them.

use access::Role;
use std::{sync::Arc, time::Duration};

use axum::{Form, extract::State, http::StatusCode};
use language::say;
use ledger::{CommandArgument, CommandKind, CommandState, LedgerError, NewCommand, PartId, PartRow};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    form_answer::{FormAnswer, FormButton, key_field},
    request_user::RequestUser,
    state::DashboardState,
};
use crate::web::base::error::{HandlerError, HandlerResult};

/// How long the page waits for the daemon's answer.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);
/// Time between two checks for the answer.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The form that a command button sends.
#[derive(Debug, Deserialize)]
pub(crate) struct CommandForm {
    kind: CommandKind,
    #[serde(default)]
    machine: String,
    part: Option<i64>,
    /// Whether the mesh of a part that is taken back may be mended.
    #[serde(default)]
    mend: bool,
}

/// The button that has the mesh of a refused part mended and printed.
pub(crate) fn mend_button(web: &DashboardState, part: &PartRow) -> Markup {
    html! {
        @if web.orders {
            form.order method="post" action="/commands" {
                (key_field(web))
                input type="hidden" name="kind" value=(CommandKind::Retry);
                input type="hidden" name="part" value=(part.id);
                input type="hidden" name="mend" value="true";
                button type="submit" { (say!("mend-and-print")) span.unseen { " " (part.full_name()) } }
            }
        }
    }
}

/// A button that sends a command to the daemon. `about` completes the label for screen readers.
pub(crate) fn command_button(
    web: &DashboardState,
    kind: CommandKind,
    label: &str,
    about: &str,
    machine: &str,
    part: Option<PartId>,
) -> Markup {
    html! {
        @if web.offers(Role::Operate) {
            form.order method="post" action="/commands" {
                (key_field(web))
                input type="hidden" name="kind" value=(kind);
                @if !machine.is_empty() { input type="hidden" name="machine" value=(machine); }
                @if let Some(part) = part { input type="hidden" name="part" value=(part); }
                button type="submit" { (label) span.unseen { " " (about) } }
            }
        }
    }
}

/// Sends a command to the daemon, then shows the page of its button again, or why the command was refused.
pub(crate) async fn post_command(
    State(web): State<Arc<DashboardState>>,
    RequestUser(asked_by): RequestUser,
    Form(order): Form<CommandForm>,
) -> HandlerResult<FormAnswer> {
    let back = match (order.part, order.kind) {
        (Some(part), CommandKind::Retry | CommandKind::Cancel | CommandKind::Confirm | CommandKind::Move) => {
            format!("/parts/{part}")
        }
        (None, CommandKind::Flush | CommandKind::Pause | CommandKind::Resume)
            if web.current_settings().profiles.contains_key(&order.machine) =>
        {
            "/".to_owned()
        }
        _ => return Err(HandlerError::NotFound(say!("such-order"))),
    };
    let undo = undo_of(&order);
    let command = NewCommand {
        kind: order.kind,
        machine: order.machine,
        part: order.part.map(PartId),
        argument: CommandArgument { mend: order.mend, ..CommandArgument::default() },
        asked_by,
    };
    Ok(send_commands(&web, vec![command], &back).await?.or_undo(undo))
}

/// The button that takes a command back, where another command does that.
fn undo_of(order: &CommandForm) -> Option<FormButton> {
    let (kind, target) = match (order.kind, order.part) {
        (CommandKind::Pause, _) => (CommandKind::Resume, ("machine", order.machine.clone())),
        (CommandKind::Resume, _) => (CommandKind::Pause, ("machine", order.machine.clone())),
        (CommandKind::Cancel, Some(part)) => (CommandKind::Retry, ("part", part.to_string())),
        _ => return None,
    };
    Some(FormButton::undo("/commands", &[("kind", kind.to_string()), target]))
}

/// Refuses whatever changes something where the farm takes no orders from pages and programs.
pub(crate) fn check_takes_orders(web: &DashboardState) -> HandlerResult<()> {
    let text = || say!("takes-no-orders");
    if web.orders { Ok(()) } else { Err(HandlerError::Refused(StatusCode::FORBIDDEN, text())) }
}

/// What the daemon answered to commands.
#[derive(Debug, Default)]
pub(crate) struct CommandAnswers {
    /// What was done, a sentence each.
    pub(crate) done: Vec<String>,
    /// What was refused, a sentence each.
    pub(crate) refusals: Vec<String>,
    /// Whether all were answered. The others are done when the daemon comes to them.
    pub(crate) is_complete: bool,
}

impl CommandAnswers {
    /// Whether nothing was asked.
    pub(crate) fn is_empty(&self) -> bool {
        self.is_complete && self.done.is_empty() && self.refusals.is_empty()
    }
}

/// Sends commands to the daemon and waits for the answers; then shows the page `back` again, or what was refused.
pub(crate) async fn send_commands(
    web: &DashboardState,
    commands: Vec<NewCommand>,
    back: &str,
) -> HandlerResult<FormAnswer> {
    Ok(show_answers(run_commands(web, commands).await?, back))
}

/// Shows the page `back` again, or what was refused.
pub(crate) fn show_answers(answers: CommandAnswers, back: &str) -> FormAnswer {
    let CommandAnswers { done, mut refusals, is_complete } = answers;
    if !is_complete {
        refusals.push(say!("not-answered-text"));
        return FormAnswer::told(&say!("not-answered"), refusals, back);
    }
    match (refusals.is_empty(), done.is_empty()) {
        (true, _) => FormAnswer::seen_at(back, done),
        (false, true) => FormAnswer::refused(refusals, back),
        // The rest is done: sent again, the form is not carried out again.
        (false, false) => FormAnswer::told(&say!("refused-in-part"), refusals, back),
    }
}

/// Sends commands to the daemon and waits for the answers.
pub(crate) async fn run_commands(web: &DashboardState, commands: Vec<NewCommand>) -> HandlerResult<CommandAnswers> {
    let mut open = Vec::new();
    for command in &commands {
        open.push(web.ledger.submit_command(command).await?);
    }
    let (asked, mut answers) = (std::time::Instant::now(), CommandAnswers::default());
    while !open.is_empty() && asked.elapsed() < ANSWER_TIMEOUT {
        tokio::time::sleep(POLL_INTERVAL).await;
        let mut unanswered = Vec::new();
        for id in open {
            let row = web.ledger.find_command(id).await?;
            let is_late = asked.elapsed() >= ANSWER_TIMEOUT;
            match row.filter(|row| row.is_answered() || is_late && row.state == CommandState::Done) {
                Some(row) if row.state == CommandState::Refused => answers.refusals.push(format!("{}.", row.answer)),
                Some(row) if row.answer.is_empty() => answers.done.push(say!("it-is-done")),
                Some(row) => answers.done.push(format!("{}.", row.answer)),
                None => unanswered.push(id),
            }
        }
        open = unanswered;
    }
    answers.is_complete = open.is_empty();
    Ok(answers)
}

/// What the ledger answers to a form that it carries out itself: sentences, or why it refuses.
pub(crate) fn answer_form(answer: Result<Vec<String>, LedgerError>, back: &str) -> HandlerResult<FormAnswer> {
    match answer {
        Ok(sentences) => Ok(FormAnswer::told(&say!("done"), sentences, back)),
        Err(error) if is_failure_of_ledger(&error) => Err(error.into()),
        Err(refused) => Ok(FormAnswer::refused(vec![format!("{refused}.")], back)),
    }
}

/// Whether the ledger could not be read or written, so that nothing was refused.
pub(crate) fn is_failure_of_ledger(error: &LedgerError) -> bool {
    error.is_trouble()
}
