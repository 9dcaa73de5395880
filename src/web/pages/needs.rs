//! What needs a person, the most urgent first: each with its buttons, and with what to do where no button does it.

use access::Role;
use std::sync::Arc;

use anyhow::Context;
use axum::extract::{Path, State};
use farm::{AlertKind, FarmAlert, awaits_release};
use jiff::Timestamp;
use language::{colon, comma, say};
use ledger::{
    BuildRow, BuildState, CommandKind, PartRow, PartState, QuestionKind, QuestionedPart, RETRY_PERIOD, RefusalCause,
};
use maud::{Markup, html};

use crate::web::{
    base::{
        error::{HandlerError, HandlerResult},
        format::prose_with_code,
    },
    core::{
        command::{command_button, mend_button},
        form_answer::{FormAnswer, key_field},
        picture::is_mendable,
        state::DashboardState,
    },
    forms::build_forms::unseen_failure,
    look::{pieces::thumbnail, times::time_of},
};

/// Parts of an entry that are named.
const MAX_NAMED: usize = 4;
/// Refused parts that are looked at to name some.
const MAX_REFUSED: u32 = 200;
/// Entries that are shown at once; the others are folded, so that the machines stay in sight.
const MAX_SHOWN: usize = 3;

/// What the entries are made of.
struct NeededFacts {
    failures: Vec<BuildRow>,
    questions: Vec<QuestionedPart>,
    refused: Vec<PartRow>,
    /// Proved builds that are not published.
    verified: Vec<BuildRow>,
}

/// Something that needs a person.
struct NeedEntry {
    /// What it is, in a line.
    line: String,
    /// What it is, with its buttons.
    content: Markup,
}

impl NeedEntry {
    /// On a phone its line, which opens the rest as a sheet; elsewhere all of it.
    fn draw(&self, place: usize) -> Markup {
        let id = format!("need-{place}");
        html! {
            div.need {
                button.row.need-line type="button" popovertarget=(id) { span { (self.line) } }
                div.sheet-box.need-body #(id) popover role="group" aria-label=(self.line) {
                    div.sheet-head { h2 { (say!("needs")) } button.close type="button" popovertarget=(id) popovertargetaction="hide" { (say!("close")) } }
                    (self.content)
                }
            }
        }
    }
}

/// What needs a person, with buttons; nothing if nothing does.
pub(super) async fn needs_section(web: &DashboardState, alerts: &[FarmAlert], now: Timestamp) -> HandlerResult<Markup> {
    let since = now.checked_sub(RETRY_PERIOD).unwrap_or(Timestamp::MIN);
    let mut refused = web.ledger.parts_in_state_between(PartState::Refused, since, now, MAX_REFUSED).await?;
    // Another one took its place, or its order was closed without it.
    let is_wanted = |part: &PartRow| part.wanted_copies() > 0;
    refused.retain(|part| is_wanted(part) && !part.refused.refusal.is_some_and(RefusalCause::is_intended));
    let facts = NeededFacts {
        failures: web.ledger.unseen_failures().await?,
        questions: web.ledger.parts_with_questions(MAX_NAMED as u32).await?,
        refused,
        verified: web.ledger.builds_in_state(BuildState::Verified).await?,
    };
    let mut entries: Vec<NeedEntry> = facts.failures.iter().map(|build| failure_entry(web, build)).collect();
    // A failed print has its own entry.
    let has_entry = |alert: &FarmAlert| {
        alert.kind == AlertKind::PrintFailed && facts.failures.iter().any(|build| build.machine == alert.machine)
    };
    let others = alerts.iter().filter(|alert| !has_entry(alert));
    entries.extend(others.map(|alert| alert_entry(web, alert, &facts)));
    entries.extend(copies_question(&facts.questions));
    let folded = entries.split_off(entries.len().min(MAX_SHOWN));
    let total = entries.len() + folded.len();
    Ok(html! {
        @if total > 0 {
            section.needs aria-label=(say!("needs")) {
                h2 { (say!("things-need", count = total)) }
                div.need-list {
                    @for (place, entry) in entries.iter().enumerate() { (entry.draw(place)) }
                    @if !folded.is_empty() {
                        details { summary { (say!("more-things", count = folded.len())) }
                            @for (place, entry) in folded.iter().enumerate() { (entry.draw(MAX_SHOWN + place)) } }
                    }
                }
            }
        }
    })
}

/// A failed print that nobody has seen to.
fn failure_entry(web: &DashboardState, build: &BuildRow) -> NeedEntry {
    let (number, machine) = (build.id.to_string(), &build.machine);
    let line = match build.reason.is_empty() {
        true => say!("print-failed", build = number, machine = machine),
        false => say!("print-failed-why", build = number, machine = machine, why = language::told(&build.reason)),
    };
    NeedEntry { line, content: unseen_failure(web, build) }
}

/// An alert with its buttons.
fn alert_entry(web: &DashboardState, alert: &FarmAlert, facts: &NeededFacts) -> NeedEntry {
    let (line, whole) = (text_without_paths(web, alert), alert.alert_text());
    let buttons = alert_buttons(web, alert, facts);
    // Where buttons do it, the commands are a detail.
    let has_buttons = web.offers(Role::Operate) && !buttons.0.trim().is_empty();
    let content = html! {
        p { b { (line) } " " span.soft { (phrase!("since-sentence", time = time_of(alert.since.into(), &web.time_view()))) } }
        (buttons)
        details { summary { @if has_buttons { (say!("details")) } @else { (say!("what-to-do")) } }
            p { (prose_with_code(&alert.kind.remedy())) }
            @if whole != line { p.soft { (whole) } }
        }
    };
    NeedEntry { line, content }
}

/// What is wrong, with words in the place of the paths of the server.
fn text_without_paths(web: &DashboardState, alert: &FarmAlert) -> String {
    if alert.kind == AlertKind::Refused {
        // Its detail is how many files lie in which folder; they stand below.
        return FarmAlert { detail: String::new(), ..alert.clone() }.alert_text();
    }
    let (settings, text) = (web.current_settings(), alert.alert_text());
    let Some(machine) = settings.profiles.get(&alert.machine) else { return text };
    let queues = machine.printers.iter().map(|printer| (printer.queue.to_string(), say!("its-queue")));
    let folders = [
        (&machine.folders.inbox, say!("its-inbox")),
        (&machine.folders.error, say!("its-errors")),
        (&machine.folders.archive, say!("its-archive")),
    ];
    let folders = folders.map(|(folder, name)| (folder.display().to_string(), name)).into_iter().chain(queues);
    folders.fold(text, |text, (path, name)| text.replace(&path, &name))
}

/// The buttons and links that end an alert.
fn alert_buttons(web: &DashboardState, alert: &FarmAlert, facts: &NeededFacts) -> Markup {
    let machine = alert.machine.as_str();
    let waiting = format!("/parts?state=waiting&machine={machine}");
    let of_kind = |kind: QuestionKind| {
        let own = facts.questions.iter().filter(move |asked| asked.kind == kind && asked.part.machine == machine);
        own.map(|asked| &asked.part).take(MAX_NAMED)
    };
    html! {
        @match alert.kind {
            AlertKind::BuildFailed => {
                div.buttons {
                    (command_button(web, CommandKind::Resume, &say!("resume"), machine, machine, None))
                    a.button href=(format!("/history?machine={machine}&state=failed")) { (say!("failed-builds")) }
                }
            }
            AlertKind::Question => { @for part in of_kind(QuestionKind::Confirmation) {
                (part_line(part, &part.owed.question, &html! {
                    (part_button(web, CommandKind::Confirm, &say!("print-as-is"), part))
                    (part_button(web, CommandKind::Cancel, &say!("cancel"), part))
                }))
            } }
            AlertKind::FileDamaged => { @for part in of_kind(QuestionKind::Original) {
                (part_line(part, "", &part_button(web, CommandKind::Cancel, &say!("cancel"), part)))
            } }
            AlertKind::Refused => { (refused_parts(web, machine, &facts.refused)) }
            AlertKind::Incomplete => { div.buttons { a.button href=(format!("/machines/{machine}/drop")) { (say!("add-files")) } } }
            AlertKind::ReleaseDue => { div.buttons {
                @for build in facts.verified.iter().filter(|build| build.machine == machine && awaits_yes(web, build)) {
                    a.button href=(format!("/builds/{}#release", build.id)) { (say!("build-number", build = build.id.to_string())) }
                }
            } }
            AlertKind::MachineGone => { div.buttons { a.button href=(waiting) { (say!("parts-that-wait")) } } }
            _ => {}
        }
    }
}

/// Whether a proved build waits for a person's yes.
fn awaits_yes(web: &DashboardState, build: &BuildRow) -> bool {
    web.current_settings().profiles.get(&build.machine).is_some_and(|machine| awaits_release(machine, build))
}

fn part_button(web: &DashboardState, kind: CommandKind, label: &str, part: &PartRow) -> Markup {
    command_button(web, kind, label, &part.full_name(), "", Some(part.id))
}

/// A part with what is to say of it, and buttons.
fn part_line(part: &PartRow, text: &str, buttons: &Markup) -> Markup {
    html! {
        div.part-line {
            p { a href=(format!("/parts/{}", part.id)) { (thumbnail(part.id)) (part.full_name()) }
                @if !part.terms.order_name.is_empty() { (comma()) (say!("order-of", order = &part.terms.order_name)) }
                @if !text.is_empty() { (colon()) (prose_with_code(text)) } }
            div.buttons { (buttons) }
        }
    }
}

/// The refused parts of a machine, newest first.
fn refused_parts(web: &DashboardState, machine: &str, refused: &[PartRow]) -> Markup {
    let own: Vec<&PartRow> = refused.iter().filter(|part| part.machine == machine).collect();
    html! {
        @for part in own.iter().take(MAX_NAMED) {
            @let reason = part.refused.reason.lines().next().unwrap_or_default();
            // Its name stands before it.
            @let reason = reason.strip_prefix(part.name.as_str()).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(reason);
            @let reason = RefusalCause::introduce(part.refused.refusal, reason);
            // What was found; what to do is on the page of the part.
            @let ends = reason.find(". ").map(|at| at + 1).into_iter().chain(reason.find('。').map(|at| at + '。'.len_utf8()));
            (part_line(part, &reason[..ends.min().unwrap_or(reason.len())], &html! {
                @if is_mendable(part) { (mend_button(web, part)) }
                @if part.can_be_read_again() { (part_button(web, CommandKind::Retry, &say!("read-again"), part)) }
            }))
        }
        div.buttons {
            a.button href=(format!("/parts?state=refused&machine={machine}")) { (say!("all-refused")) }
            @if web.offers(Role::Operate) {
                form.order method="post" action=(format!("/machines/{machine}/dismiss")) {
                    (key_field(web))
                    button type="submit" { (say!("seen-to")) span.unseen { (say!("unseen-seen-to", machine = machine)) } }
                }
            }
        }
    }
}

/// Parts whose number of copies is asked for. They are printed as one copy, so nobody is alerted.
fn copies_question(questions: &[QuestionedPart]) -> Option<NeedEntry> {
    let asked: Vec<&QuestionedPart> = questions.iter().filter(|asked| asked.kind == QuestionKind::Copies).collect();
    let parts: Vec<&PartRow> = asked.iter().map(|asked| &asked.part).take(MAX_NAMED).collect();
    (!parts.is_empty()).then(|| {
        let content = html! {
            p { b { (say!("how-many")) } }
            @for part in parts {
                (part_line(part, "", &html! { a.button href=(format!("/parts/{}#edit", part.id)) { (say!("say-how-many")) } }))
            }
        };
        NeedEntry { line: say!("how-many"), content }
    })
}

/// Ends the alert of the refused files of a machine; they stay where they are.
pub(crate) async fn post_dismiss(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<FormAnswer> {
    let settings = web.current_settings();
    let profile =
        settings.profiles.get(&name).ok_or_else(|| HandlerError::NotFound(say!("machine-named", machine = &name)))?;
    let error_dir = profile.folders.error.clone();
    let dismissed = tokio::task::spawn_blocking(move || farm::dismiss_refused(&error_dir)).await;
    dismissed.context("a step ended")?.context("writing into the error folder")?;
    Ok(FormAnswer::back_to("/"))
}
