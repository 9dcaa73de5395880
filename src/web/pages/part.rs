//! The page that lists parts by state or name, and the page of one part with the builds and positions of its copies.

use std::sync::Arc;

use axum::extract::{Path, State};
use farm::{MachinePlan, MaterialReading, PartQuestion, count_copies_in_layout, read_part_facts};
use language::say;
use ledger::{BuildId, BuildState, CommandKind, PartId, PartQuery, PartRow, PartState, RefusalCause, is_missing_file};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    tables::{
        COPY_GROUP_COLUMNS, CopyGroup, EVENT_COLUMNS, ListedPart, PART_COLUMNS, PART_PAGE_KEYS, PlacedCopy, TimeView,
        fields, gathered_events, part_facts, wanted_text,
    },
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            format::prose_with_code,
            listing::{fact_sheet, table_of, table_of_keys},
            page::html_page,
            query::{Query, order_address, parse_field, query_string},
        },
        core::{
            command::{command_button, mend_button},
            picture::{is_mendable, part_picture},
            state::DashboardState,
        },
        forms::{finish_forms::finishing_section, part_forms::part_forms},
        look::chip::{chip, state_text},
    },
};

/// Parts on a page.
const MAX_PARTS: u32 = 500;

/// The filter of a request; empty fields do not filter.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct PartFilter {
    /// In one state.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "PartState")]
    state: String,
    /// Of one machine.
    #[serde(skip_serializing_if = "String::is_empty")]
    machine: String,
    /// Whose file name or order begins so.
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    /// Those that come after this part in that order: the last one of the page before.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "i64")]
    after: String,
}

/// The parts of one page, newest first, and whether more parts follow.
pub(crate) async fn read_page(web: &DashboardState, filter: &PartFilter) -> HandlerResult<(Vec<PartRow>, bool)> {
    let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    let query = PartQuery {
        name: some(&filter.name),
        state: parse_field(&filter.state, &say!("a-state-of-part"))?,
        machine: some(&filter.machine),
        before: parse_field::<i64>(&filter.after, &say!("the-number-of-part"))?.map(PartId),
        limit: MAX_PARTS + 1,
    };
    let mut parts = web.ledger.list_parts(&query).await?;
    let more = parts.len() > MAX_PARTS as usize;
    parts.truncate(MAX_PARTS as usize);
    Ok((parts, more))
}

/// The page that lists parts by state, name or order.
pub(crate) async fn list_parts(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<PartFilter>,
) -> HandlerResult<Markup> {
    let (parts, more) = read_page(&web, &filter).await?;
    let next = parts.last().filter(|_| more).map(|last| PartFilter { after: last.id.to_string(), ..filter.clone() });
    let next = next.map(|next| query_string(&next)).transpose()?;
    let listed = ListedPart::of_plans(&web.ledger, parts, &web.read_plans().await?).await?;
    let settings = web.current_settings();
    let states = PartState::ALL.map(|s| s.to_string());
    let content = html! {
        h1 { (fields::PARTS.said()) }
        form.filters method="get" action="/parts" {
            label { (say!("file-begins-with")) input name="name" value=(filter.name); }
            label { (fields::STATE.said()) select name="state" {
                option value="" { (say!("all")) }
                @for state in &states { option value=(state) selected[*state == filter.state] { (state_text(state)) } }
            } }
            label { (fields::MACHINE.said()) select name="machine" {
                option value="" { (say!("all-machines")) }
                @for name in settings.profiles.keys() { option value=(name) selected[*name == filter.machine] { (name) } }
            } }
            button type="submit" { (say!("show")) }
        }
        @if filter.name.is_empty() && filter.state.is_empty() {
            p { (say!("parts-text")) }
        }
        (parts_table(&listed, more, &web.time_view()))
        @if let Some(next) = next { p { a rel="next" href=(format!("/parts?{next}")) { (say!("next-parts")) } } }
    };
    Ok(html_page(&fields::PARTS.said(), "/parts", None, &content))
}

/// Parts as a table, of which there are more or not.
fn parts_table(parts: &[ListedPart], more: bool, view: &TimeView) -> Markup {
    let caption = match more {
        true => say!("newest-parts", count = parts.len()),
        false => say!("count-parts", count = parts.len()),
    };
    html! { @if parts.is_empty() { p { (say!("no-parts")) } } @else { (table_of_keys((&fields::PARTS.said(), Some(caption)), PART_COLUMNS, &PART_PAGE_KEYS, parts, view)) } }
}

/// The page of one part.
pub(crate) async fn show_part(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Markup> {
    let id = PartId(number);
    let part = web
        .ledger
        .find_part(id)
        .await?
        .ok_or_else(|| HandlerError::NotFound(say!("part-named", part = number.to_string())))?;
    let plans = web.read_plans().await?;
    let placed = PlacedCopy::of_plans(web.ledger.placements_of_part(id).await?, &plans);
    let word = read_part_facts(&web.ledger, &[(id, part.state)], &plans).await?.remove(&id).unwrap_or_default();
    let is_published = |copy: &&PlacedCopy| copy.placed.published_at.is_some() && !copy.placed.is_bad;
    let published = placed.iter().filter(is_published).count() as u32;
    let events = web.ledger.events_of_part(id).await?;
    let others = |parts: Vec<PartRow>| parts.into_iter().filter(|other| other.id != id).collect::<Vec<_>>();
    let same = others(web.ledger.parts_with_content(&part.file.content_hash).await?);
    let mut named = others(web.ledger.parts_named(&part.name).await?);
    named.retain(|other| other.file.content_hash != part.file.content_hash);
    let open = find_open_build(&web, &part).await?;
    let view = web.time_view();
    let materials = MaterialReading::read(&web.ledger, &web.current_settings().materials).await?;
    let elsewhere = [fields::STATE, fields::ORDER];
    let content = html! {
        h1 { (say!("part-title", part = number.to_string(), name = part.full_name())) " " (chip(&word)) }
        @if !part.refused.reason.is_empty() { p.bad role="status" { (prose_with_code(&RefusalCause::introduce(part.refused.refusal, &part.refused.reason))) } }
        @for warning in part.told_warnings().filter(|warning| !is_asked(&part, warning)) { p.warn { (prose_with_code(warning)) } }
        @for question in PartQuestion::of_part(&part, &materials) {
            p.bad role="status" { (prose_with_code(&question.text)) }
            // Where buttons answer it, the commands are a detail.
            details { summary { (say!("details")) } p { (prose_with_code(&question.remedy)) } }
        }
        (part_buttons(&web, &part, published))
        div.part-head {
            (part_picture(&part))
            div {
                @if !part.terms.order_name.is_empty() {
                    p { (phrase!("part-of-order", order = html! { a href=(order_address(&part.terms.order_name)) { (part.terms.order_name) } })) }
                }
                (fact_sheet(part_facts(&part, wanted_text(&part), &view), &elsewhere, &view))
            }
        }
        h2 { (say!("where-its-copies-are")) }
        (copies_section(&part, &placed, open, &view))
        @if !placed.is_empty() { p { a.button href=(format!("/parts/{number}/record")) { (say!("manufacturing-record")) } } }
        (finishing_section(&web, &[web.ledger.finishing_of_part(&part).await?], &format!("/parts/{number}")))
        h2 { (say!("what-happened")) }
        (table_of(&say!("events"), None, EVENT_COLUMNS, &gathered_events(events), &view))
        @if !same.is_empty() { h2 { (say!("same-file")) } (newest_table(&web, same, &plans).await?) }
        @if !named.is_empty() { h2 { (say!("other-files")) } (newest_table(&web, named, &plans).await?) }
    };
    Ok(html_page(&say!("part-number", part = number.to_string()), "/parts", None, &content))
}

/// Whether a warning is what a question asks.
fn is_asked(part: &PartRow, warning: &str) -> bool {
    let question = part.owed.question.trim_end_matches('.');
    !question.is_empty() && warning.contains(question)
}

/// What can be done with a part, what a person most probably does first.
fn part_buttons(web: &DashboardState, part: &PartRow, published: u32) -> Markup {
    let about = say!("part-named", part = part.id.to_string());
    let command = |kind: CommandKind, label: &str| command_button(web, kind, label, &about, "", Some(part.id));
    html! {
        div.buttons.acts {
            @if !part.owed.question.is_empty() && part.state == PartState::Waiting { (command(CommandKind::Confirm, &say!("print-as-is"))) }
            @if is_mendable(part) { (mend_button(web, part)) }
            @if part.can_be_read_again() { (command(CommandKind::Retry, &say!("read-again"))) }
            (part_forms(web, part, published))
            @if part.state == PartState::Waiting || is_missing_file(&part.file.claim) && part.wanted_copies() > 0 { (command(CommandKind::Cancel, &say!("cancel"))) }
        }
    }
}

async fn newest_table(web: &DashboardState, mut parts: Vec<PartRow>, plans: &[MachinePlan]) -> HandlerResult<Markup> {
    let more = parts.len() > MAX_PARTS as usize;
    parts.reverse();
    parts.truncate(MAX_PARTS as usize);
    let listed = ListedPart::of_plans(&web.ledger, parts, plans).await?;
    Ok(parts_table(&listed, more, &web.time_view()))
}

/// The open build whose current layout holds copies of a part, and how many copies it holds.
async fn find_open_build(web: &DashboardState, part: &PartRow) -> HandlerResult<Option<(BuildId, u32)>> {
    if part.state != PartState::Waiting {
        return Ok(None);
    }
    let open = web.ledger.builds_in_state(BuildState::Open).await?;
    let build = open.into_iter().find(|build| build.machine == part.machine);
    Ok(build.map(|build| (build.id, count_copies_in_layout(&build, part.id))).filter(|(_, copies)| *copies > 0))
}

fn copies_section(part: &PartRow, placed: &[PlacedCopy], open: Option<(BuildId, u32)>, view: &TimeView) -> Markup {
    let live = placed.iter().filter(|copy| !copy.placed.is_bad).count() as u32;
    let waiting = part.wanted_copies().saturating_sub(live);
    html! {
        @if part.state == PartState::Refused { p { (say!("part-in-no-build", why = part.refused.refusal.unwrap_or(RefusalCause::Other).text())) } }
        @else if waiting > 0 {
            p { @match open {
                Some((build, copies)) => (phrase!("part-in-open-build",
                    waiting = waiting, build = html! { a href=(format!("/builds/{build}#part-{}", part.id)) { (build) } }, copies = copies)),
                None => (say!("part-waits", waiting = waiting)),
            } }
        }
        @if !placed.is_empty() {
            (table_of(&fields::COPIES.said(), None, COPY_GROUP_COLUMNS, &CopyGroup::of_copies(placed), view))
        }
    }
}
