//! What a flush would build now, before a person asks for it.

use std::sync::Arc;

use axum::extract::{Path, State};
use farm::{asked_text, load_placed_parts};
use language::say;
use ledger::{CommandKind, MachineStatus, PartQuery, PartRow, PartState};
use maud::{Markup, html};
use settings::MachineProfile;

use crate::{
    tables::{
        BUILD_PART_COLUMNS, BUILD_PART_PAGE_KEYS, CountedPart, ListedPart, PART_COLUMNS, PART_PAGE_KEYS, fields,
        height_in_volume,
    },
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            listing::table_of_keys,
            page::html_page,
        },
        core::{command::command_button, picture::machine_picture, state::DashboardState},
    },
};

/// Waiting parts that are listed.
const MAX_PARTS: u32 = 200;

/// The preview of a flush, with the button that asks for it.
pub(crate) async fn show_preview(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<Markup> {
    let settings = web.current_settings();
    let profile =
        settings.profiles.get(&name).ok_or_else(|| HandlerError::NotFound(say!("machine-named", machine = &name)))?;
    let status = MachineStatus::of_machine(&web.ledger.machine_statuses().await?, &name);
    let inside = placed_parts(&web, profile, &status).await?;
    let query = PartQuery {
        state: Some(PartState::Waiting),
        machine: Some(name.clone()),
        limit: MAX_PARTS,
        ..PartQuery::default()
    };
    let mut outside: Vec<PartRow> = web.ledger.list_parts(&query).await?;
    outside.retain(|part| !inside.iter().any(|counted| counted.part.id == part.id));
    let outside: Vec<ListedPart> = outside.into_iter().map(ListedPart::unbuilt).collect();
    let picture_html = machine_picture(&web, &status).await?;
    let placed: u32 = inside.iter().map(|counted| counted.copies).sum();
    let later = status.collecting_copies.saturating_sub(placed);
    let view = web.time_view();
    let content = html! {
        h1 { (say!("flush-machine", machine = &name)) }
        @if status.waiting_parts == 0 { p { (say!("nothing-to-build")) } }
        @else {
            (preview_sentence(profile, &status, placed))
            @if later > 0 { p { (say!("in-no-layout", copies = later)) } }
            @if let Some(asked) = asked_text(&status) { p { (asked) (say!("sign-stop")) } }
            div.buttons {
                span.next-step { (command_button(&web, CommandKind::Flush, &say!("flush-now"), &say!("unseen-flush-now", machine = &name), &name, None)) }
                a.button href="/" { (say!("not-now")) }
            }
            (picture_html)
            @if !inside.is_empty() { h2 { (say!("in-layout-so-far")) } (table_of_keys((&say!("in-layout"), None), BUILD_PART_COLUMNS, &BUILD_PART_PAGE_KEYS, &inside, &view)) }
            @if !outside.is_empty() { h2 { (say!("waiting-in-no-layout")) } (table_of_keys((&fields::WAITING.said(), None), PART_COLUMNS, &PART_PAGE_KEYS, &outside, &view)) }
        }
    };
    Ok(html_page(&say!("flush-title", machine = &name), "", None, &content))
}

/// The parts in the layout of the open build, with the copies there.
async fn placed_parts(
    web: &DashboardState,
    profile: &MachineProfile,
    status: &MachineStatus,
) -> HandlerResult<Vec<CountedPart>> {
    let Some(open) = &status.open else { return Ok(Vec::new()) };
    let Some(build) = web.ledger.find_build(open.build).await? else { return Ok(Vec::new()) };
    let parts = load_placed_parts(&web.ledger, &build, profile).await?;
    Ok(parts.into_iter().map(|(part, copies)| CountedPart::new(part, copies.len() as u32)).collect())
}

/// What would be built, and how high it stands.
fn preview_sentence(profile: &MachineProfile, status: &MachineStatus, placed: u32) -> Markup {
    let open = status.open.as_ref().filter(|_| placed > 0);
    let height = open.and_then(|open| height_in_volume(open.height_mm, Some(profile.space.volume_mm.z)));
    let density = open.and_then(|open| fields::DENSITY.with_unit(open.density));
    html! {
        @let waiting = html! { b { (say!("copies-of-parts", copies = status.waiting_copies, parts = status.waiting_parts)) } };
        p { (phrase!("they-wait", waiting = waiting)) " "
            @match (height.map(|height| html! { b { (height) } }), density) {
                (Some(height), Some(density)) => { (phrase!("layout-stands-dense", copies = placed, height = height, density = density)) " " }
                (Some(height), None) => { (phrase!("layout-stands", copies = placed, height = height)) " " }
                (None, _) => {}
            }
            (say!("flush-text", secs = format!("{:.0}", profile.search.final_secs))) }
    }
}
