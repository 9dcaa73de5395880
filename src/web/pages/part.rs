//! The page that lists parts by state or name, and the page of one part with the builds and positions of its copies.

use std::sync::Arc;

use axum::extract::{Path, State};
use ledger::{BuildId, BuildState, CommandKind, PartId, PartQuery, PartRow, PartState};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    farm::{PartQuestion, count_copies_in_layout},
    tables::{
        EVENT_COLUMNS, PART_COLUMNS, PART_PAGE_KEYS, PLACEMENT_COLUMNS, PlacedCopy, TimeView, fields, gathered_events,
        part_facts,
    },
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            format::{count, prose_with_code},
            listing::{fact_sheet, table_of, table_of_keys},
            page::html_page,
            query::{Query, order_address, parse_field, query_string},
        },
        core::{command::command_button, picture::part_picture, state::DashboardState},
        forms::part_forms::part_forms,
        look::chip::{chip, said},
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
        state: parse_field(&filter.state, "a state of a part")?,
        machine: some(&filter.machine),
        before: parse_field::<i64>(&filter.after, "the number of a part")?.map(PartId),
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
    let settings = web.current_settings();
    let states = PartState::ALL.map(|s| s.to_string());
    let content = html! {
        h1 { "Parts" }
        form.filters method="get" action="/parts" {
            label { "File or order begins with" input name="name" value=(filter.name); }
            label { (fields::STATE.label) select name="state" {
                option value="" { "all" }
                @for state in &states { option value=(state) selected[*state == filter.state] { (said(state)) } }
            } }
            label { (fields::MACHINE.label) select name="machine" {
                option value="" { "all" }
                @for name in settings.profiles.keys() { option value=(name) selected[*name == filter.machine] { (name) } }
            } }
            button type="submit" { "Show" }
        }
        @if filter.name.is_empty() && filter.state.is_empty() {
            p { "Parts that are read, wait, are in a build that is being made, or were refused in the last 30 days. Ask for others by state or name." }
        }
        (parts_table(&parts, more, &web.time_view()))
        @if let Some(next) = next { p { a rel="next" href=(format!("/parts?{next}")) { "The parts before these" } } }
    };
    Ok(html_page("Parts", "/parts", None, &content))
}

/// Parts as a table, of which there are more or not.
fn parts_table(parts: &[PartRow], more: bool, view: &TimeView) -> Markup {
    let caption = count(parts.len() as u32, "part", "parts") + if more { ", the newest of more" } else { "" };
    html! { @if parts.is_empty() { p { "No parts." } } @else { (table_of_keys(("Parts", Some(caption)), PART_COLUMNS, &PART_PAGE_KEYS, parts, view, &|_, _| None)) } }
}

/// The page of one part.
pub(crate) async fn show_part(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Markup> {
    let id = PartId(number);
    let part = web.ledger.find_part(id).await?.ok_or_else(|| HandlerError::NotFound(format!("part {number}")))?;
    let placed = PlacedCopy::of_plans(web.ledger.placements_of_part(id).await?, &web.read_plans().await?);
    let is_published = |copy: &&PlacedCopy| copy.placed.published_at.is_some() && !copy.placed.is_bad;
    let published = placed.iter().filter(is_published).count() as u32;
    let events = web.ledger.events_of_part(id).await?;
    let others = |parts: Vec<PartRow>| parts.into_iter().filter(|other| other.id != id).collect::<Vec<_>>();
    let same = others(web.ledger.parts_with_content(&part.file.content_hash).await?);
    let mut named = others(web.ledger.parts_named(&part.name).await?);
    named.retain(|other| other.file.content_hash != part.file.content_hash);
    let open = find_open_build(&web, &part).await?;
    let view = web.time_view();
    let elsewhere = [fields::STATE, fields::ORDER];
    let content = html! {
        h1 { "Part " (number) ": " (part.full_name()) " " (chip(&part.state.to_string())) }
        @if !part.refused.reason.is_empty() { p.bad role="status" { (prose_with_code(&part.refused.reason)) } }
        @for warning in part.told_warnings() { p.warn { (prose_with_code(warning)) } }
        @for question in PartQuestion::of_part(&part) {
            p.bad role="status" { (prose_with_code(&format!("{} {}", question.text, question.remedy))) }
        }
        (part_buttons(&web, &part, published))
        div.part-head {
            (part_picture(&part))
            div {
                @if !part.terms.order_name.is_empty() {
                    p { "Part of the order " a href=(order_address(&part.terms.order_name)) { (part.terms.order_name) } "." }
                }
                (fact_sheet(part_facts(&part, part.wanted_copies().to_string(), &view), &elsewhere, &view))
            }
        }
        h2 { "Where its copies are" }
        (copies_section(&part, &placed, open, &view))
        h2 { "What happened" }
        (table_of("Events", None, EVENT_COLUMNS, &gathered_events(events), &view))
        @if !same.is_empty() { h2 { "The same file at other times" } (newest_table(same, &view)) }
        @if !named.is_empty() { h2 { "Other files of this name" } (newest_table(named, &view)) }
    };
    Ok(html_page(&format!("Part {number}"), "/parts", None, &content))
}

/// What can be done with a part, what a person most probably does first.
fn part_buttons(web: &DashboardState, part: &PartRow, published: u32) -> Markup {
    let about = format!("part {}", part.id);
    let command = |kind: CommandKind, label: &str| command_button(web, kind, label, &about, "", Some(part.id));
    html! {
        div.buttons.acts {
            @if !part.owed.question.is_empty() && part.state == PartState::Waiting { (command(CommandKind::Confirm, "Print as it is")) }
            @if part.state == PartState::Refused { (command(CommandKind::Retry, "Read it again")) }
            (part_forms(web, part, published))
            @if part.state == PartState::Waiting { (command(CommandKind::Cancel, "Cancel")) }
        }
    }
}

fn newest_table(mut parts: Vec<PartRow>, view: &TimeView) -> Markup {
    let more = parts.len() > MAX_PARTS as usize;
    parts.reverse();
    parts.truncate(MAX_PARTS as usize);
    parts_table(&parts, more, view)
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
        @if part.state == PartState::Refused { p { "In no build: the part was refused or cancelled." } }
        @else if waiting > 0 {
            p { (count(waiting, "copy waits", "copies wait"))
                @if let Some((build, copies)) = open {
                    "; in the open build " a href=(format!("/builds/{build}#part-{}", part.id)) { (build) }
                    " so far: " (count(copies, "copy", "copies")) "."
                } @else { ", in no build yet." }
            }
        }
        @if !placed.is_empty() {
            (table_of("Copies", None, PLACEMENT_COLUMNS, placed, view))
        }
    }
}
