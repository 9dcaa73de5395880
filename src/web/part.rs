//! Parts: those of a state or a name, and one part: where it is, in which build, where in the cake.

use std::sync::Arc;

use axum::extract::{Path, Query, State};
use maud::{Markup, html};
use serde::{Deserialize, Serialize};

use super::{
    asked::{known, query},
    order::button,
    page::{facts, page},
    problem::{Answer, Problem},
    state::Web,
    words::{DASH, count, number, prose, text, time},
};
use crate::{
    farm::copies_so_far,
    ledger::{BuildId, BuildState, CommandKind, PartId, PartQuery, PartRow, PartState, PlacementRow},
};

/// Parts on a page.
const MOST_PARTS: u32 = 500;

/// What is asked for; empty fields ask for nothing.
#[derive(Debug, Clone, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct Asked {
    #[serde(skip_serializing_if = "String::is_empty")]
    state: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    profile: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    /// The last part of the page before.
    #[serde(skip_serializing_if = "String::is_empty")]
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
            label { "State" select name="state" {
                option value="" { "all" }
                @for state in &states { option value=(state) selected[*state == asked.state] { (state) } }
            } }
            label { "Profile" select name="profile" {
                option value="" { "all" }
                @for name in settings.profiles.keys() { option value=(name) selected[*name == asked.profile] { (name) } }
            } }
            button type="submit" { "Show" }
        }
        @if asked.name.is_empty() && asked.state.is_empty() {
            p { "Parts that are claimed, wait, are in a build that is being made, or were refused in the last 30 days. Ask for others by state or name." }
        }
        (table(&parts, more, "Copies"))
        @if let Some(next) = next { p { a rel="next" href=(format!("/parts?{next}")) { "The parts before these" } } }
    };
    Ok(page("Parts", "/parts", None, &content))
}

/// Parts as a table, of which there are more or not; `copies` is what their copies are counted of.
pub(super) fn table(parts: &[PartRow], more: bool, copies: &str) -> Markup {
    html! {
        @if parts.is_empty() { p { "No parts." } }
        @else {
            div.wide tabindex="0" role="region" aria-label="Parts" {
                table {
                    caption { (count(parts.len() as u32, "part", "parts")) @if more { ", the newest of more" } }
                    thead { tr {
                        th scope="col" { "Part" } th scope="col" { "File" } th scope="col" { "Order" } th scope="col" { "Profile" }
                        th scope="col" { "State" } th.n scope="col" { (copies) } th scope="col" { "Due" } th scope="col" { "Reason or warning" }
                    } }
                    tbody { @for part in parts { tr {
                        td { a href=(format!("/parts/{}", part.id)) { (part.id) } }
                        td { (part.full_name()) } td { (text(&part.order_name)) } td { (part.profile) } td { (part.state) }
                        td.n { (part.copies) } td { (time(part.due_at)) }
                        td { (prose(if part.reason.is_empty() { text(&part.warnings) } else { &part.reason })) }
                    } } }
                }
            }
        }
    }
}

/// One part.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number): Path<i64>) -> Answer<Markup> {
    let id = PartId(number);
    let part = web.ledger.part(id).await?.ok_or_else(|| Problem::NotFound(format!("part {number}")))?;
    let placements = web.ledger.placements_of_part(id).await?;
    let events = web.ledger.events_of_part(id).await?;
    let others = |parts: Vec<PartRow>| parts.into_iter().filter(|other| other.id != id).collect::<Vec<_>>();
    let same = others(web.ledger.parts_of_content(&part.content_hash).await?);
    let mut named = others(web.ledger.parts_named(&part.name).await?);
    named.retain(|other| other.content_hash != part.content_hash);
    let open = open_build_with(&web, &part).await?;
    let about = format!("part {number}");
    let content = html! {
        h1 { "Part " (number) ": " (part.full_name()) }
        @if !part.reason.is_empty() { p.bad role="status" { (prose(&part.reason)) } }
        @for warning in part.warnings.lines() { p.warn { (prose(warning)) } }
        (what_it_is(&part))
        div.buttons {
            @if part.state == PartState::Rejected { (button(&web, CommandKind::Retry, "Retry", &about, "", Some(id))) }
            @if part.state == PartState::Waiting { (button(&web, CommandKind::Cancel, "Cancel", &about, "", Some(id))) }
        }
        h2 { "Where its copies are" }
        (copies(&part, &placements, open))
        h2 { "What happened" }
        ul { @for event in &events { li { (time(Some(event.at))) " " (event.kind)
            @if let Some(build) = event.build_id { " (build " a href=(format!("/builds/{build}")) { (build) } ")" }
            @if !event.detail.is_empty() { ": " (event.detail) } } } }
        @if !same.is_empty() { h2 { "The same file at other times" } (newest(same)) }
        @if !named.is_empty() { h2 { "Other files of this name" } (newest(named)) }
    };
    Ok(page(&format!("Part {number}"), "/parts", None, &content))
}

fn newest(mut parts: Vec<PartRow>) -> Markup {
    let more = parts.len() > MOST_PARTS as usize;
    parts.reverse();
    parts.truncate(MOST_PARTS as usize);
    table(&parts, more, "Copies")
}

fn what_it_is(part: &PartRow) -> Markup {
    let size = part.size_mm().map_or_else(|| DASH.to_owned(), |[x, y, z]| format!("{x:.1} x {y:.1} x {z:.1} mm"));
    facts(&[
        ("State", html! { (part.state) " since " (time(Some(part.state_at))) }),
        ("Profile", html! { (part.profile) }),
        ("Order", html! { (text(&part.order_name)) }),
        ("Copies", html! { (part.copies) }),
        ("Priority, due", html! { (part.priority) ", " (time(part.due_at)) }),
        ("Size", html! { (size) }),
        (
            "Volume",
            html! {
                @if let (Some(volume_mm3), Some(triangles)) = (part.volume_mm3, part.triangles) {
                    (number(Some(volume_mm3 / 1000.0), 2)) " cm3, " (triangles) " triangles"
                } @else { "not read yet" }
            },
        ),
        ("Orientation", html! { (format!("{:?}", part.orientation).to_lowercase()) }),
        ("Note", html! { (text(&part.note)) }),
        ("Content", html! { code { (part.content_hash) } }),
    ])
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
            div.wide tabindex="0" role="region" aria-label="Copies" {
                table {
                    thead { tr { th.n scope="col" { "Copy" } th scope="col" { "Build" } th scope="col" { "State" }
                        th scope="col" { "Published" } th scope="col" { "Origin of its mesh in the cake, mm" } } }
                    tbody { @for placed in placements { tr {
                        td.n { (placed.copy + 1) }
                        td { a href=(format!("/builds/{}#part-{}", placed.build_id, part.id)) { (placed.build_id) ", marked" } }
                        td { (placed.build_state) } td { (time(placed.published_at)) }
                        td { @if placed.tx_mm.is_some() {
                            (number(placed.tx_mm, 1)) ", " (number(placed.ty_mm, 1)) ", " (number(placed.tz_mm, 1))
                        } @else { "not placed yet" } }
                    } } }
                }
            }
        }
    }
}
