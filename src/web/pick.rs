//! The pick map of a build as a page, and as a list for machines.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, State},
};
use maud::{Markup, html};

use super::{
    page::page,
    pick_map::{Map, PICTURE},
    problem::Answer,
    render::{Kept, build_of, of_cake, version},
    state::Web,
    words::{count, time_utc},
};
use crate::{
    farm::Cake,
    ledger::{BuildRow, BuildState},
    settings::Profile,
    tables::{PickList, fields},
};

/// Maps that are kept; some 100 kB each.
pub(super) const KEPT: usize = 8;

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let title = format!("Pick map of build {}", build.id);
    let Map { copies, sheets, .. } = map_of(&web, &build, &profile).await?;
    let content = html! {
        h1 { (title) }
        p { (build.profile) ", " @if let Some(height) = fields::HEIGHT.with_unit(build.measures.height_mm) { (height) ", " } (count(copies as u32, "copy", "copies")) ", " (build.state)
            @if let Some(at) = build.times.published_at { " " (time_utc(at)) }
            @if let Some(file) = &build.staged.file_name { ": " (file) } "." }
        @if matches!(build.state, BuildState::Open | BuildState::Nesting) {
            p.warn { "A forecast: what stands where changes until the build is published. Not for breaking out." }
        }
        @if copies > 0 {
            img.cake alt=(PICTURE) width="640" height="480" src=(format!("/builds/{}/picture", build.id));
        }
        (sheets)
    };
    Ok(page(&title, "", None, &content))
}

/// The list, for machines.
pub(super) async fn list(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Json<Arc<PickList>>> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    Ok(Json(map_of(&web, &build, &profile).await?.list))
}

async fn map_of(web: &Arc<Web>, build: &BuildRow, profile: &Profile) -> Answer<Map> {
    let kept = Kept { cache: |web| &web.caches.picks, key: version(build) };
    let number_of_build = build.id.0;
    of_cake(web, build, profile, kept, move |cake: &Cake| Ok(Map::of(cake, number_of_build))).await
}
