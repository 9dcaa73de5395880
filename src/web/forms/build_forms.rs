//! The forms of the page of a build, for what became of its print: the outcome, printing it again, and that somebody has
//! seen to a failed print. They are words, as those of `nestd outcome`, `reprint`, `requeue`, `release` and `dismiss`.

use std::{collections::BTreeMap, sync::Arc};

use axum::{
    Form,
    extract::{Path, State},
    http::StatusCode,
};
use jiff::Timestamp;
use language::say;
use ledger::{
    BuildId, BuildRow, BuildState, OperatorWord, PartId, PlacementRow, PrintOutcome, ReprintTarget, ToldOutcome,
};
use maud::{Markup, html};
use serde::Deserialize;

use super::operate_form::say_word;
use crate::{
    farm::{awaits_release, preview_release},
    settings::MachineProfile,
    tables::fields,
    web::{
        base::error::{HandlerError, HandlerResult},
        core::{
            form_answer::{FormAnswer, key_field},
            request_user::RequestUser,
            state::DashboardState,
        },
        look::pieces::sheet,
    },
};

/// Longest note, so that a form stays below the size that is taken.
pub(super) const MAX_NOTE: u32 = 500;

/// A form of the page of a build.
#[derive(Debug, Deserialize)]
pub(crate) struct BuildTellForm {
    act: BuildFormAct,
    #[serde(default)]
    note: String,
    /// Bad copies: `7=2, 9=1`.
    #[serde(default)]
    bad: String,
    /// Sent if bad copies are not to be printed again.
    keep: Option<String>,
    /// Sent if it corrects what was told before.
    correct: Option<String>,
    /// Hash of the build file that was shown.
    seen: Option<String>,
    /// Sent if it is meant although the file of the build lies in the queue.
    anyway: Option<String>,
}

/// What a form of the page of a build asks for.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum BuildFormAct {
    Printing,
    Complete,
    Interrupted,
    Failed,
    Reprint,
    Requeue,
    Seen,
    Release,
    Withdraw,
}

/// The forms for a published build, each a button with its sheet: what a person most probably does comes first. `placements` are its
/// copies, those that were printed badly included.
pub(crate) fn build_forms(web: &DashboardState, build: &BuildRow, placements: &[PlacementRow]) -> Markup {
    let is_told = matches!(build.state, BuildState::Complete | BuildState::Interrupted | BuildState::Failed);
    let has_counted = placements.iter().any(|placed| !placed.is_bad);
    let tell = if is_told { say!("correct-told") } else { say!("tell-printed") };
    html! {
        @if web.orders && build.times.published_at.is_some() {
            @if build.place.withdrawn_at.is_none() { (sheet("tell", &tell, !is_told, &outcome_form(web, build, &bad_text(build, placements), is_told))) }
            @if build.state == BuildState::Published && !build.place.is_on_its_way() {
                (act_form(web, build.id, "printing", &say!("it-prints")))
            }
            @if has_counted { (sheet("reprint", &say!("print-again"), false, &reprint_form(web, build.id))) }
            @if build.state == BuildState::Published && build.place.taken_at.is_none() {
                (sheet("withdraw", &say!("withdraw"), false, &withdraw_form(web, build)))
            }
            (sheet("requeue", &say!("requeue"), false, &requeue_form(web, build.id)))
        }
    }
}

fn reprint_form(web: &DashboardState, build: BuildId) -> Markup {
    html! {
        p { (say!("reprint-build-text")) }
        (act_form(web, build, "reprint", &say!("reprint-build")))
    }
}

fn withdraw_form(web: &DashboardState, build: &BuildRow) -> Markup {
    html! {
        p { (say!("withdraw-text")) }
        @if build.place.withdraw_by.is_some() { p role="status" { (say!("is-taken-back")) } }
        @else { (act_form(web, build.id, "withdraw", &say!("take-back"))) }
    }
}

fn requeue_form(web: &DashboardState, build: BuildId) -> Markup {
    html! {
        p { (say!("requeue-text")) }
        (act_form(web, build, "requeue", &say!("requeue-build")))
    }
}

/// Says that second files of a published build were seen in the queues, with the button that says that nobody prints from them.
pub(crate) async fn second_files(web: &DashboardState, build: &BuildRow) -> HandlerResult<Markup> {
    let second = match build.state {
        BuildState::Published => web.ledger.second_files(build.id).await?,
        _ => Vec::new(),
    };
    Ok(html! {
        @if !second.is_empty() {
            div.failed role="alert" {
                p { (say!("second-file", files = language::join_names(second))) }
                @if web.orders { (act_form(web, build.id, "seen", &say!("second-file-unprinted"))) }
            }
        }
    })
}

/// Says that a failed print needs a person, with the button that dismisses it.
pub(crate) fn unseen_failure(web: &DashboardState, build: &BuildRow) -> Markup {
    html! {
        div.failed role="alert" {
            @let number = html! { a href=(format!("/builds/{}", build.id)) { (build.id) } };
            p { @match build.reason.is_empty() {
                true => (phrase!("print-failed", build = number, machine = &build.machine)),
                false => (phrase!("print-failed-why", build = number, machine = &build.machine, why = language::told(&build.reason))),
            } }
            @if web.orders { (act_form(web, build.id, "seen", &say!("seen-to"))) }
        }
    }
}

/// What publishing a proved build would mean, with the button that has it published; nothing unless it waits for that.
pub(crate) async fn release_form(
    web: &DashboardState,
    build: &BuildRow,
    profile: &MachineProfile,
) -> HandlerResult<Markup> {
    if !awaits_release(profile, build) {
        return Ok(Markup::default());
    }
    let preview = preview_release(&web.ledger, profile, build, Timestamp::now()).await?;
    Ok(html! {
        section.forms #release aria-label=(say!("waits-for-yes")) {
            p role="status" { b { (say!("waits-for-yes-text")) } }
            ul { @for sentence in preview.sentences(&profile.time_zone) { li { (sentence) } } }
            @if web.orders { (act_form_with(web, build.id, ("release", &say!("publish-it")), build.staged.file_hash.as_deref())) }
        }
    })
}

fn outcome_form(web: &DashboardState, build: &BuildRow, bad: &str, is_told: bool) -> Markup {
    let choices = [
        ("complete", say!("outcome-complete")),
        ("interrupted", say!("outcome-interrupted")),
        ("failed", say!("outcome-failed")),
    ];
    html! {
        form.tell method="post" action=(format!("/builds/{}/told", build.id)) {
            (key_field(web))
            @if is_told { input type="hidden" name="correct" value="yes"; }
            label { (say!("the-print-is")) select name="act" {
                @for (word, text) in choices { option value=(word) selected[word == build.state.to_string()] { (text) } }
            } }
            label { (say!("bad-copies")) input name="bad" value=(bad) maxlength=(MAX_NOTE); }
            label { (fields::NOTE.said()) input name="note" maxlength=(MAX_NOTE); }
            label.check { input type="checkbox" name="keep" value="yes"; (say!("keep-bad")) }
            p { (say!("bad-copies-text")) }
            button type="submit" { @if is_told { (say!("correct-outcome")) } @else { (say!("tell-outcome")) } }
        }
    }
}

/// A button that needs no more fields.
fn act_form(web: &DashboardState, build: BuildId, act: &str, label: &str) -> Markup {
    act_form_with(web, build, (act, label), None)
}

/// A button that says which build file was shown.
fn act_form_with(web: &DashboardState, build: BuildId, (act, label): (&str, &str), seen: Option<&str>) -> Markup {
    html! {
        form.order method="post" action=(format!("/builds/{build}/told")) {
            (key_field(web))
            input type="hidden" name="act" value=(act);
            @if let Some(seen) = seen { input type="hidden" name="seen" value=(seen); }
            button type="submit" { (label) span.unseen { " " (say!("unseen-build", build = build.to_string())) } }
        }
    }
}

/// The copies that were told bad, as the form takes them; "" for a failed print, in which all are.
fn bad_text(build: &BuildRow, placements: &[PlacementRow]) -> String {
    let mut bad: BTreeMap<i64, u32> = BTreeMap::new();
    if build.state != BuildState::Failed {
        for placed in placements.iter().filter(|placed| placed.is_bad) {
            *bad.entry(placed.part_id.0).or_default() += 1;
        }
    }
    bad.iter().map(|(part, copies)| format!("{part}={copies}")).collect::<Vec<_>>().join(", ")
}

/// Records what a form says of a build.
pub(crate) async fn post_told(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    Form(form): Form<BuildTellForm>,
) -> HandlerResult<FormAnswer> {
    let build = BuildId(number);
    if web.ledger.find_build(build).await?.is_none() {
        return Err(HandlerError::NotFound(say!("build-named", build = number.to_string())));
    }
    let bad = parse_bad_copies(&form.bad).map_err(|wrong| HandlerError::Refused(StatusCode::BAD_REQUEST, wrong))?;
    let back = format!("/builds/{number}");
    say_word(&web, &word_of(build, &form, bad, &by), &by, form.anyway.is_some(), &back).await
}

/// The word about the build that a form says.
fn word_of(build: BuildId, form: &BuildTellForm, bad: Vec<(PartId, u32)>, by: &str) -> OperatorWord {
    let outcome = match form.act {
        BuildFormAct::Printing => PrintOutcome::Printing,
        BuildFormAct::Complete => PrintOutcome::Complete,
        BuildFormAct::Interrupted => PrintOutcome::Interrupted,
        BuildFormAct::Failed => PrintOutcome::Failed,
        BuildFormAct::Reprint => return OperatorWord::Reprint(ReprintTarget::Build(build)),
        BuildFormAct::Requeue => return OperatorWord::Requeue(build),
        BuildFormAct::Withdraw => return OperatorWord::Withdraw(build, String::new()),
        BuildFormAct::Seen => return OperatorWord::SeenTo(build),
        BuildFormAct::Release => return OperatorWord::Release { build, seen: form.seen.clone() },
    };
    let told = ToldOutcome {
        bad,
        keep: form.keep.is_some(),
        is_correction: form.correct.is_some(),
        ..ToldOutcome::new(outcome, form.note.trim(), by)
    };
    OperatorWord::Outcome(build, told)
}

/// Parses `7=2, p9=1`.
fn parse_bad_copies(text: &str) -> Result<Vec<(PartId, u32)>, String> {
    let pieces = text.split([',', ';']).map(str::trim).filter(|piece| !piece.is_empty());
    let pair = |piece: &str| {
        let (part, copies) = piece.split_once('=')?;
        let part = part.trim().trim_start_matches(['p', 'P']).parse().ok()?;
        Some((PartId(part), copies.trim().parse().ok().filter(|copies| *copies > 0)?))
    };
    let parse = |piece: &str| pair(piece).ok_or_else(|| say!("names-no-bad-copies", text = piece));
    pieces.map(parse).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_copies_are_pairs_of_part_and_number() {
        assert_eq!(parse_bad_copies(" 7=2, p9 = 1;").unwrap(), [(PartId(7), 2), (PartId(9), 1)]);
        assert!(parse_bad_copies("").unwrap().is_empty());
        for wrong in ["7", "7=0", "=1", "7=-1", "a=1", "7=1 9=1"] {
            assert!(parse_bad_copies(wrong).is_err(), "{wrong}");
        }
    }
}
