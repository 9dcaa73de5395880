//! Cancels what is not in builds yet of an order or of a line of it: lines that arrive, parts that are being read, and parts that wait.

use std::collections::HashSet;

use language::say;
use ledger::{CommandArgument, CommandKind, NewCommand, OrderLine, PartId, PartRow, PartState};

use crate::web::{
    base::error::{HandlerError, HandlerResult},
    core::{
        command::{CommandAnswers, run_commands},
        state::DashboardState,
    },
};

/// How often what came meanwhile is looked for: a file that is read becomes several parts once.
const MAX_ROUNDS: usize = 8;
/// When to ask again whether files were read, s.
const READ_SECS: u64 = 2;

/// What is to be cancelled.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CancelTarget<'a> {
    /// Name of the order.
    pub(crate) order: &'a str,
    /// Claim of the line, or the number of its part; `None` = all lines.
    pub(crate) line: Option<&'a str>,
}

impl CancelTarget<'_> {
    fn includes_part(&self, part: &PartRow) -> bool {
        self.line
            .is_none_or(|line| part.file.claim == line || line.parse().is_ok_and(|number| part.id == PartId(number)))
    }
}

/// Whether the file of a part is read for the first time, so that its solids are not known.
pub(crate) fn is_being_read(part: &PartRow) -> bool {
    part.state == PartState::Claimed && part.measures.triangles.is_none() && part.times.damaged_at.is_none()
}

/// Cancels all of it that is not in builds. Empty answers = nothing of it was left.
///
/// # Errors
/// `TooMany` while files are being read that may become several parts: to ask again cancels the rest.
pub(crate) async fn cancel_lines(
    web: &DashboardState,
    target: CancelTarget<'_>,
    by: &str,
) -> HandlerResult<CommandAnswers> {
    let mut told = CommandAnswers { is_complete: true, ..CommandAnswers::default() };
    let (mut asked, mut being_read) = (HashSet::new(), 0);
    for _ in 0..MAX_ROUNDS {
        told.done.extend(cancel_arriving(web, target, by).await?);
        let lines = web.ledger.order_lines(target.order).await?;
        let mut parts = web.ledger.parts_of_order(target.order).await?;
        parts.retain(|part| {
            let is_open = matches!(part.state, PartState::Waiting | PartState::Claimed);
            is_open && target.includes_part(part) && asked.insert(part.id)
        });
        if parts.is_empty() {
            break;
        }
        being_read = parts.iter().filter(|part| is_being_read(part)).count();
        let answers = run_commands(web, parts.iter().map(|part| cancel_command(part, &lines, by)).collect()).await?;
        told.done.extend(answers.done);
        told.refusals.extend(answers.refusals);
        told.is_complete = answers.is_complete;
        if !told.is_complete {
            break;
        }
    }
    match !told.is_complete && being_read > 0 {
        true => {
            let text = say!("files-are-read");
            Err(HandlerError::TooMany(READ_SECS, format!("{text}. {}", told.done.join(" ")).trim_end().to_owned()))
        }
        false => Ok(told),
    }
}

/// Cancels the lines that have no parts yet. Returns a sentence for each.
async fn cancel_arriving(web: &DashboardState, target: CancelTarget<'_>, by: &str) -> HandlerResult<Vec<String>> {
    let mut done = Vec::new();
    for line in web.ledger.arriving_lines_of_order(target.order).await? {
        let is_meant = target.line.is_none_or(|wanted| wanted == line.claim);
        if is_meant && web.ledger.cancel_arriving_line(&line, &format!("cancelled by {by}")).await? {
            done.push(say!("cancelled-before", name = &line.name));
        }
    }
    if !done.is_empty() {
        farm::update_order_notes(&web.ledger, &web.current_settings().state_dir).await?;
    }
    Ok(done)
}

fn cancel_command(part: &PartRow, lines: &[OrderLine], by: &str) -> NewCommand {
    let line = lines.iter().find(|line| line.part == part.id && part.state == PartState::Waiting);
    NewCommand {
        kind: CommandKind::Cancel,
        machine: String::new(),
        part: Some(part.id),
        argument: CommandArgument {
            copies: line.and_then(waiting_of_several),
            edit: None,
            ..CommandArgument::default()
        },
        asked_by: by.to_owned(),
    }
}

/// The waiting copies of a line, if others of it are in builds; `None` = all copies wait.
fn waiting_of_several(line: &OrderLine) -> Option<u32> {
    (line.copies.waiting < line.copies.wanted).then_some(line.copies.waiting)
}
