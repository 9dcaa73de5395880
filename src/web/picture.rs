//! Pictures of builds for pages, rendered one at a time and cached, because every view of the farm page requests them
//! again.

use std::sync::Arc;

use axum::{
    body::Bytes,
    extract::{Path, Query, State},
    http::header,
    response::{IntoResponse, Response},
};
use build_file::Viewpoint;
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    cached_render::{CacheLocation, find_build, layout_version, render_cached},
    error::HandlerResult,
    format::count,
    state::DashboardState,
};
use crate::{farm::CakeContents, ledger::ProfileStatus, tables::fields};

/// Widths that pages request, pixels. Any other width is rounded up to the next of them.
const WIDTHS: [u32; 2] = [480, 640];
/// Pictures in the cache; about 50 kB each.
pub(super) const CACHED_PICTURES: usize = 64;

/// The query of a picture's address.
#[derive(Debug, Deserialize)]
pub(super) struct PictureQuery {
    width: Option<u32>,
    /// The layout version that the page saw. A browser may cache the picture of that version forever.
    of: Option<String>,
}

/// The picture of a build, a PNG.
pub(super) async fn get_picture(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(asked): Query<PictureQuery>,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let wanted = asked.width.unwrap_or(WIDTHS[WIDTHS.len() - 1]);
    let width = WIDTHS.into_iter().find(|&width| width >= wanted).unwrap_or(WIDTHS[WIDTHS.len() - 1]);
    let kept = CacheLocation { cache: |web| &web.caches.pictures, key: format!("{} {width}", layout_version(&build)) };
    let draw = move |cake: &CakeContents| Ok(Bytes::from(cake.render_picture(Viewpoint::Iso, (width, width / 4 * 3))));
    let png = render_cached(&web, &build, &profile, kept, draw).await?;
    let stays = asked.of.is_some_and(|of| of == layout_version(&build));
    let keep = if stays { "private, max-age=31536000, immutable" } else { "private, no-cache" };
    Ok(([(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, keep)], png).into_response())
}

/// The picture on a machine's card: the open build, else the build that is being nested, else the last published one.
pub(super) async fn profile_picture(web: &DashboardState, status: &ProfileStatus) -> HandlerResult<Markup> {
    let open = status.open.as_ref().filter(|open| open.copies.unwrap_or(0) > 0);
    let (id, what) = match (open, status.nesting.first(), &status.last_published) {
        (Some(open), _, _) => (open.build, "so far"),
        (None, Some(nesting), _) => (nesting.build, "being made"),
        (None, None, Some(last)) => (last.build, "published last"),
        (None, None, None) => return Ok(html! {}),
    };
    let Some(build) = web.ledger.find_build(id).await? else { return Ok(html! {}) };
    // A build that fired without a layout has no height yet.
    let height = fields::HEIGHT
        .with_unit(build.measures.height_mm)
        .map_or_else(|| "height not known yet".to_owned(), |height| height + " high");
    let copies = count(build.measures.copies.unwrap_or(0), "copy", "copies");
    let alt = format!("Build {id}, {what}: {copies}, {height}");
    let source = format!("/builds/{id}/picture?width=480&of={}", layout_version(&build));
    Ok(html! {
        a.shot href=(format!("/builds/{id}")) {
            img loading="lazy" width="240" height="180" alt=(alt) src=(source);
        }
    })
}
