//! Pictures of builds for pages, rendered one at a time and cached, because every view of the farm page requests them
//! again.

use std::sync::Arc;

use axum::{
    body::Bytes,
    extract::{Path, State},
    http::header,
    response::{IntoResponse, Response},
};
use build_file::{PictureScheme, Viewpoint, draw_part};
use ledger::{BuildId, MachineStatus, PartId};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    cached_render::{CacheLocation, find_build, layout_version, render_cached},
    state::DashboardState,
};
use crate::{
    farm::CakeContents,
    tables::fields,
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            format::count,
            query::Query,
        },
        figures::pick_map::PICTURE_ALT_TEXT,
    },
};

/// Widths that pages request, pixels. Any other width is rounded up to the next of them.
const WIDTHS: [u32; 3] = [SMALL_WIDTH, 480, 640];
/// Width of a picture that shows what stands in a build without the height that is free above it, pixels.
const SMALL_WIDTH: u32 = 112;
/// Width and height of the picture of a part, pixels.
const PART_PICTURE_SIZE: (u32, u32) = (400, 300);
/// Number of colours of parts.
const MAX_KINDS: usize = 21;
/// Pictures in the cache; 50 kB each at most.
pub(crate) const CACHED_PICTURES: usize = 160;

/// The query of a picture's address.
#[derive(Debug, Deserialize)]
pub(crate) struct PictureQuery {
    width: Option<u32>,
    /// The layout version that the page saw. A browser may cache the picture of that version forever.
    of: Option<String>,
    #[serde(default)]
    scheme: PictureScheme,
}

/// A picture of a page in the colours of the page; `source` is its address on a light page. Paper is light.
pub(crate) fn themed_picture(source: &str, image: &Markup) -> Markup {
    let mark = if source.contains('?') { '&' } else { '?' };
    html! { picture { source media="screen and (prefers-color-scheme: dark)" srcset=(format!("{source}{mark}scheme=dark")); (image) } }
}

/// The picture of a build, a PNG.
pub(crate) async fn get_picture(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(asked): Query<PictureQuery>,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let wanted = asked.width.unwrap_or(WIDTHS[WIDTHS.len() - 1]);
    let width = WIDTHS.into_iter().find(|&width| width >= wanted).unwrap_or(WIDTHS[WIDTHS.len() - 1]);
    let scheme = asked.scheme;
    let key = format!("{} {width} {scheme:?}", layout_version(&build));
    let kept = CacheLocation { cache: |web| &web.caches.pictures, key, only: None };
    let size = (width, width / 4 * 3);
    let draw = move |cake: &CakeContents| {
        Ok(match (width, cake.top_mm()) {
            (SMALL_WIDTH, None) => Bytes::new(),
            (SMALL_WIDTH, Some(top_mm)) => Bytes::from(cake.render_up_to(top_mm, scheme, size)),
            _ => Bytes::from(cake.render_picture_on(scheme, Viewpoint::Iso, size)),
        })
    };
    let png = render_cached(&web, &build, &profile, kept, draw).await?;
    if png.is_empty() {
        return Err(HandlerError::NotFound(format!("picture of what stands in build {number}")));
    }
    let stays = asked.of.is_some_and(|of| of == layout_version(&build));
    let keep = if stays { "private, max-age=31536000, immutable" } else { "private, no-cache" };
    Ok(([(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, keep)], png).into_response())
}

/// A small picture of a build; what it shows is said beside it.
pub(crate) fn small_picture(build: BuildId, version: &str) -> Markup {
    let source = format!("/builds/{build}/picture?width={SMALL_WIDTH}&of={version}");
    themed_picture(&source, &html! { img loading="lazy" width="56" height="42" alt="" src=(source); })
}

/// The picture of a whole build.
pub(crate) fn cake_picture(build: i64) -> Markup {
    let source = format!("/builds/{build}/picture");
    themed_picture(&source, &html! { img.cake alt=(PICTURE_ALT_TEXT) width="640" height="480" src=(source); })
}

/// The query of the address of a part's picture.
#[derive(Debug, Deserialize)]
pub(crate) struct PartPictureQuery {
    /// Number of its colour: that of its order in the build.
    #[serde(default)]
    kind: usize,
    #[serde(default)]
    scheme: PictureScheme,
}

/// The picture of a part of a build, as it was dropped, a PNG. It never changes.
pub(crate) async fn get_part_picture(
    State(web): State<Arc<DashboardState>>,
    Path((number, part)): Path<(i64, i64)>,
    Query(asked): Query<PartPictureQuery>,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let (kind, scheme) = (asked.kind % MAX_KINDS, asked.scheme);
    let key = format!("part {part} of {} {kind} {scheme:?}", build.id);
    let kept = CacheLocation { cache: |web| &web.caches.pictures, key, only: Some(PartId(part)) };
    let draw = move |cake: &CakeContents| {
        let mesh = cake.parts.first().and_then(|part| part.mesh.as_ref());
        Ok(mesh.map_or_else(Bytes::new, |mesh| Bytes::from(draw_part(mesh, kind, scheme, PART_PICTURE_SIZE))))
    };
    let png = render_cached(&web, &build, &profile, kept, draw).await?;
    if png.is_empty() {
        return Err(HandlerError::NotFound(format!("picture of part {part} in build {number}")));
    }
    let keep = "private, max-age=31536000, immutable";
    Ok(([(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, keep)], png).into_response())
}

/// The picture on a machine's card: the open build, else the build that is being nested, else the last published one.
pub(crate) async fn machine_picture(web: &DashboardState, status: &MachineStatus) -> HandlerResult<Markup> {
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
            (themed_picture(&source, &html! { img loading="lazy" width="240" height="180" alt=(alt) src=(source); }))
        }
    })
}
