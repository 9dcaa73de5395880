//! Parts: those of a state or a name, and one part: where it is, in which build, where in the cake.

use std::sync::Arc;

use axum::extract::{Path, Query, State};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    asked::{known, query},
    listing::{facts, table_of},
    order::button,
    page::page,
    problem::{Answer, Problem},
    state::Web,
    words::{count, prose},
};
use crate::{
    farm::copies_so_far,
    ledger::{BuildId, BuildState, CommandKind, PartId, PartQuery, PartRow, PartState, PlacementRow},
    tables::{EVENT_COLUMNS, PART_COLUMNS, PLACEMENT_COLUMNS, fields, part_facts},
};

/// Parts on a page.
const MOST_PARTS: u32 = 500;

/// What is asked for; empty fields ask for nothing.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(super) struct Asked {
    /// In one state.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "PartState")]
    state: String,
    /// Of one machine profile.
    #[serde(skip_serializing_if = "String::is_empty")]
    profile: String,
    /// Whose file name or order begins so.
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    /// Those that come after this part in that order: the last one of the page before.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "i64")]
    after: String,
}

/// The parts of a page, the newest first, and whether there are more.
pub(super) async fn page_of(web: &Web, asked: &Asked) -> Answer<(Vec<PartRow>, bool)> {
    let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    let query = PartQuery {
        name: some(&asked.name),
        state: known(&asked.state, "a state of a part")?,
        profile: some(&asked.profile),
        before: known::<i64>(&asked.after, "the number of a part")?.map(PartId),
        limit: MOST_PARTS + 1,
    };
    let mut parts = web.ledger.parts(&query).await?;
    let more = parts.len() > MOST_PARTS as usize;
    parts.truncate(MOST_PARTS as usize);
    Ok((parts, more))
}

/// Parts by state, or of a name or an order.
pub(super) async fn list(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Markup> {
    let (parts, more) = page_of(&web, &asked).await?;
    let next = parts.last().filter(|_| more).map(|last| Asked { after: last.id.to_string(), ..asked.clone() });
    let next = next.map(|next| query(&next)).transpose()?;
    let settings = web.settings();
    let states = PartState::ALL.map(|s| s.to_string());
    let content = html! {
        h1 { "Parts" }
        form.filters method="get" action="/parts" {
            label { "File or order begins with" input name="name" value=(asked.name); }
            label { (fields::STATE.label) select name="state" {
                option value="" { "all" }
                @for state in &states { option value=(state) selected[*state == asked.state] { (state) } }
            } }
            label { (fields::PROFILE.label) select name="profile" {
                option value="" { "all" }
                @for name in settings.profiles.keys() { option value=(name) selected[*name == asked.profile] { (name) } }
            } }
            button type="submit" { "Show" }
        }
        @if asked.name.is_empty() && asked.state.is_empty() {
            p { "Parts that are claimed, wait, are in a build that is being made, or were refused in the last 30 days. Ask for others by state or name." }
        }
        (table(&parts, more))
        @if let Some(next) = next { p { a rel="next" href=(format!("/parts?{next}")) { "The parts before these" } } }
    };
    Ok(page("Parts", "/parts", None, &content))
}

/// Parts as a table, of which there are more or not.
fn table(parts: &[PartRow], more: bool) -> Markup {
    let caption = count(parts.len() as u32, "part", "parts") + if more { ", the newest of more" } else { "" };
    html! { @if parts.is_empty() { p { "No parts." } } @else { (table_of("Parts", Some(caption), PART_COLUMNS, parts)) } }
}

/// One part.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number): Path<i64>) -> Answer<Markup> {
    let id = PartId(number);
    let part = web.ledger.part(id).await?.ok_or_else(|| Problem::NotFound(format!("part {number}")))?;
    let placements = web.ledger.placements_of_part(id).await?;
    let events = web.ledger.events_of_part(id).await?;
    let others = |parts: Vec<PartRow>| parts.into_iter().filter(|other| other.id != id).collect::<Vec<_>>();
    let same = others(web.ledger.parts_of_content(&part.file.content_hash).await?);
    let mut named = others(web.ledger.parts_named(&part.name).await?);
    named.retain(|other| other.file.content_hash != part.file.content_hash);
    let open = open_build_with(&web, &part).await?;
    let about = format!("part {number}");
    let content = html! {
        h1 { "Part " (number) ": " (part.full_name()) }
        @if !part.reason.is_empty() { p.bad role="status" { (prose(&part.reason)) } }
        @for warning in part.warnings.lines() { p.warn { (prose(warning)) } }
        (facts(&part_facts(&part, part.copies.to_string())))
        div.buttons {
            @if part.state == PartState::Rejected { (button(&web, CommandKind::Retry, "Retry", &about, "", Some(id))) }
            @if part.state == PartState::Waiting { (button(&web, CommandKind::Cancel, "Cancel", &about, "", Some(id))) }
        }
        h2 { "Where its copies are" }
        (copies(&part, &placements, open))
        h2 { "What happened" }
        (table_of("Events", None, EVENT_COLUMNS, &events))
        @if !same.is_empty() { h2 { "The same file at other times" } (newest(same)) }
        @if !named.is_empty() { h2 { "Other files of this name" } (newest(named)) }
    };
    Ok(page(&format!("Part {number}"), "/parts", None, &content))
}

fn newest(mut parts: Vec<PartRow>) -> Markup {
    let more = parts.len() > MOST_PARTS as usize;
    parts.reverse();
    parts.truncate(MOST_PARTS as usize);
    table(&parts, more)
}

/// The open build in whose layout copies of a part stand so far, and how many.
async fn open_build_with(web: &Web, part: &PartRow) -> Answer<Option<(BuildId, u32)>> {
    if part.state != PartState::Waiting {
        return Ok(None);
    }
    let open = web.ledger.builds_in_state(BuildState::Open).await?;
    let build = open.into_iter().find(|build| build.profile == part.profile);
    Ok(build.map(|build| (build.id, copies_so_far(&build, part.id))).filter(|(_, copies)| *copies > 0))
}

fn copies(part: &PartRow, placements: &[PlacementRow], open: Option<(BuildId, u32)>) -> Markup {
    let waiting = part.copies.saturating_sub(placements.len() as u32);
    html! {
        @if part.state == PartState::Rejected { p { "In no build: the part was refused or cancelled." } }
        @else if waiting > 0 {
            p { (count(waiting, "copy waits", "copies wait"))
                @if let Some((build, copies)) = open {
                    "; in the open build " a href=(format!("/builds/{build}#part-{}", part.id)) { (build) ", marked" }
                    " so far: " (count(copies, "copy", "copies")) "."
                } @else { ", in no build yet." }
            }
        }
        @if !placements.is_empty() {
            (table_of("Copies", None, PLACEMENT_COLUMNS, placements))
        }
    }
}
