//! The forms of the page of a build, for what became of its print: the outcome, printing it again, and that somebody has
//! seen to a failed print. They are words, as those of `nestd outcome`, `reprint`, `requeue`, `release` and `dismiss`.

use std::{collections::BTreeMap, sync::Arc};

use access::Role;
use axum::{
    Form,
    extract::{Path, State},
    http::StatusCode,
};
use farm::{awaits_release, preview_release};
use jiff::Timestamp;
use language::say;
use ledger::{
    BuildId, BuildRow, BuildState, OperatorWord, PartId, PlacementRow, PrintOutcome, ReprintTarget, ToldOutcome,
};
use maud::{Markup, html};
use serde::Deserialize;
use settings::MachineProfile;

use super::operate_form::say_word;
use crate::{
    tables::{CountedPart, fields},
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
    /// Bad copies of each part, `bad_7` for part 7, as the page asks for them.
    #[serde(flatten)]
    others: BTreeMap<String, String>,
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

/// The forms that say how a published build printed, each a button with its sheet. `placements` are its copies, those that were printed
/// badly included, and `parts` what they are of.
pub(crate) fn outcome_forms(
    web: &DashboardState,
    build: &BuildRow,
    placements: &[PlacementRow],
    parts: &[CountedPart],
) -> Markup {
    let is_told = matches!(build.state, BuildState::Complete | BuildState::Interrupted | BuildState::Failed);
    let tell = if is_told { say!("correct-told") } else { say!("tell-printed") };
    // Nobody tells how a build printed that lies in the queue.
    let is_awaited = build.state == BuildState::Printing || build.place.taken_at.is_some() && !is_told;
    html! {
        @if web.offers(Role::Operate) && build.times.published_at.is_some() {
            @if build.place.withdrawn_at.is_none() { (sheet("tell", &tell, is_awaited, &outcome_form(web, build, &bad_fields(build, placements, parts), is_told))) }
            @if build.state == BuildState::Published && !build.place.is_on_its_way() {
                (act_form(web, build.id, "printing", &say!("it-prints")))
            }
        }
    }
}

/// The forms by which a published build, or its copies, are printed again.
pub(crate) fn again_forms(web: &DashboardState, build: &BuildRow, placements: &[PlacementRow]) -> Markup {
    let has_counted = placements.iter().any(|placed| !placed.is_bad);
    html! {
        @if web.offers(Role::Operate) && build.times.published_at.is_some() {
            (sheet("requeue", &say!("requeue"), false, &requeue_form(web, build.id)))
            @if has_counted { (sheet("reprint", &say!("copies-again"), false, &reprint_form(web, build.id))) }
            @if build.state == BuildState::Published && build.place.taken_at.is_none() {
                (sheet("withdraw", &say!("withdraw"), false, &withdraw_form(web, build)))
            }
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
                @if web.offers(Role::Operate) { (act_form(web, build.id, "seen", &say!("second-file-unprinted"))) }
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
            @if web.offers(Role::Operate) { (act_form(web, build.id, "seen", &say!("seen-to"))) }
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
            ul { @for sentence in preview.sentences(&profile.time_zone) { li { (web.time_view().near_times(&sentence)) } } }
            @if web.offers(Role::Operate) { (act_form_with(web, build.id, ("release", &say!("publish-it")), build.staged.file_hash.as_deref())) }
        }
    })
}

fn outcome_form(web: &DashboardState, build: &BuildRow, bad: &Markup, is_told: bool) -> Markup {
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
            (bad)
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

/// Asks how many copies of each part are bad, with what was told; nothing was of a failed print, in which all are.
fn bad_fields(build: &BuildRow, placements: &[PlacementRow], parts: &[CountedPart]) -> Markup {
    let is_bad = |placed: &&PlacementRow| placed.is_bad && build.state != BuildState::Failed;
    let bad = |part: PartId| placements.iter().filter(is_bad).filter(|placed| placed.part_id == part).count();
    html! {
        details open[placements.iter().any(|placed| is_bad(&placed))] {
            summary { (say!("copies-that-are-bad")) }
            @for CountedPart { part, copies, .. } in parts {
                label { (part.full_name()) input type="number" inputmode="numeric" name=(format!("bad_{}", part.id)) min="0" max=(copies) value=(bad(part.id)); }
            }
        }
    }
}

/// The bad copies that a form names.
fn bad_copies(form: &BuildTellForm) -> Result<Vec<(PartId, u32)>, String> {
    let mut bad = parse_bad_copies(&form.bad)?;
    for (part, copies) in form.others.iter().filter_map(|(name, copies)| Some((name.strip_prefix("bad_")?, copies))) {
        let wrong = || say!("names-no-bad-copies", text = format!("{part}={copies}"));
        let (part, copies) = (part.parse().map_err(|_| wrong())?, copies.trim());
        let copies: u32 = if copies.is_empty() { 0 } else { copies.parse().map_err(|_| wrong())? };
        bad.extend((copies > 0).then_some((PartId(part), copies)));
    }
    Ok(bad)
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
    let bad = bad_copies(&form).map_err(|wrong| HandlerError::Refused(StatusCode::BAD_REQUEST, wrong))?;
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
