//! The pick map of a build as a page, and as a list for programs.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, State},
};
use farm::{CakeContents, build_fact};
use language::{comma, say};
use ledger::{BuildRow, BuildState};
use maud::{Markup, html};
use settings::MachineProfile;

use crate::{
    tables::{PickList, fields},
    web::{
        base::{error::HandlerResult, page::html_page},
        core::{
            cached_render::{CacheLocation, find_build, layout_version, render_cached},
            picture::cake_picture,
            state::DashboardState,
        },
        figures::pick_map::CachedPickMap,
        look::{chip::chip, times::time_of},
    },
};

/// Maps in the cache; about 100 kB each.
pub(crate) const CACHED_MAPS: usize = 8;

/// The page of the pick map.
pub(crate) async fn show_pick_map(
    State(web): State<Arc<DashboardState>>,
    Path(number_of_build): Path<i64>,
) -> HandlerResult<Markup> {
    let (build, profile) = find_build(&web, number_of_build).await?;
    let title = say!("pick-map-of", build = build.id.to_string());
    let CachedPickMap { copies, sheets, .. } = cached_map(&web, &build, &profile).await?;
    let fact = build_fact(&build, &web.read_plans().await?);
    let content = html! {
        h1 { (title) }
        p { (build.machine) (comma()) @if let Some(height) = fields::HEIGHT.with_unit(build.measures.height_mm) { (height) (comma()) } (say!("count-copies", count = copies)) ", " (chip(&fact.word))
            @if let Some(at) = build.times.published_at { " " span.exact-on-paper { (time_of(at, &web.time_view())) } }
            @if let Some(file) = &build.staged.file_name { span.file-on-paper data-file=(file) {} } }
        @if matches!(build.state, BuildState::Open | BuildState::Nesting) {
            p.warn { (say!("pick-forecast")) }
        }
        @if build.times.published_at.is_some() {
            p.links { a href=(format!("/builds/{}/break-out", build.id)) { (say!("break-out-steps")) } }
        }
        @if copies > 0 {
            (cake_picture(build.id.0))
        }
        (sheets)
    };
    Ok(html_page(&title, "", None, &content))
}

/// The copies in removal order, for programs.
pub(crate) async fn get_pick_list(
    State(web): State<Arc<DashboardState>>,
    Path(number_of_build): Path<i64>,
) -> HandlerResult<Json<Arc<PickList>>> {
    let (build, profile) = find_build(&web, number_of_build).await?;
    Ok(Json(cached_map(&web, &build, &profile).await?.list))
}

/// The pick map of a build.
pub(crate) async fn cached_map(
    web: &Arc<DashboardState>,
    build: &BuildRow,
    profile: &MachineProfile,
) -> HandlerResult<CachedPickMap> {
    // Words of orders can change until the build is verified.
    let news = match build.state {
        BuildState::Open | BuildState::Nesting => web.ledger.last_event_id().await?,
        _ => 0,
    };
    let key = format!("{} {news} {} {}", layout_version(build), profile.time_zone.name(), language::current().tag());
    let kept = CacheLocation { cache: |web| &web.caches.picks, key, only: None };
    let number_of_build = build.id.0;
    render_cached(web, build, profile, kept, move |cake: &CakeContents| {
        Ok(CachedPickMap::from_cake(cake, number_of_build))
    })
    .await
}
