//! Pictures of builds for pages, rendered one at a time and cached, because every view of the farm page requests them
//! again.

use std::sync::Arc;

use anyhow::Context;
use axum::{
    body::Bytes,
    extract::{Path, State},
    http::header,
    response::{IntoResponse, Response},
};
use build_file::{PictureScheme, Viewpoint, draw_part};
use farm::CakeContents;
use language::say;
use ledger::{BuildId, MachineStatus, PartId, PartRow, PartState, RefusalCause};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    cached_render::{CacheLocation, find_build, layout_version, render_cached},
    state::DashboardState,
};
use crate::{
    tables::fields,
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            query::Query,
        },
        figures::pick_map::picture_text,
        look::pieces::THUMBNAIL_WIDTH,
    },
};

pub(crate) use crate::web::look::pieces::themed_picture;

/// Widths that pages request, pixels. Any other width is rounded up to the next of them.
const WIDTHS: [u32; 3] = [SMALL_WIDTH, 480, 640];
/// Width of a picture that shows what stands in a build without the height that is free above it, pixels.
const SMALL_WIDTH: u32 = 112;
/// Width and height of the picture of a part, pixels.
const PART_PICTURE_SIZE: (u32, u32) = (400, 300);
/// Width of the picture of a part on its page, pixels.
const LONE_WIDTH: u32 = 400;
/// Stands for a picture that cannot be drawn: a dashed box.
const NO_PICTURE: &str = include_str!("../assets/no-picture.svg");
/// Pictures of parts in the cache; most of them are thumbnails of 3 kB.
pub(crate) const CACHED_PARTS: usize = 600;
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
        return Ok(no_picture());
    }
    let stays = asked.of.is_some_and(|of| of == layout_version(&build));
    Ok(png_answer(png, stays))
}

/// A small picture of a build; what it shows is said beside it.
pub(crate) fn small_picture(build: BuildId, version: &str) -> Markup {
    let source = format!("/builds/{build}/picture?width={SMALL_WIDTH}&of={version}");
    themed_picture(&source, &html! { img loading="lazy" width="56" height="42" alt="" src=(source); })
}

/// The picture of a whole build.
pub(crate) fn cake_picture(build: i64) -> Markup {
    let source = format!("/builds/{build}/picture");
    themed_picture(&source, &html! { img.cake alt=(picture_text()) width="640" height="480" src=(source); })
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
        Ok(mesh.map_or_else(Bytes::new, |mesh| Bytes::from(draw_part(mesh, &[], kind, scheme, PART_PICTURE_SIZE))))
    };
    let png = render_cached(&web, &build, &profile, kept, draw).await?;
    if png.is_empty() {
        return Ok(no_picture());
    }
    Ok(png_answer(png, true))
}

/// A picture; `stays` = it never changes.
fn png_answer(png: Bytes, stays: bool) -> Response {
    let keep = if stays { "private, max-age=31536000, immutable" } else { "private, no-cache" };
    ([(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, keep)], png).into_response()
}

/// Stands for a picture that cannot be drawn: what it would show is no longer kept, or not there yet.
fn no_picture() -> Response {
    ([(header::CONTENT_TYPE, "image/svg+xml"), (header::CACHE_CONTROL, "private, no-cache")], NO_PICTURE)
        .into_response()
}

/// The query of the address of the picture of a part by itself.
#[derive(Debug, Deserialize)]
pub(crate) struct LonePictureQuery {
    width: Option<u32>,
    /// As it is mended, with the mended places in red, or `false` as it was dropped; not said = as it is printed.
    mended: Option<bool>,
    #[serde(default)]
    scheme: PictureScheme,
}

/// The picture of a part, whatever became of it: a PNG. It never changes, but where the part may still be mended. Where the surface is not closed, its open edges are red; where it
/// was mended, the mended places.
pub(crate) async fn get_lone_picture(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(asked): Query<LonePictureQuery>,
) -> HandlerResult<Response> {
    let missing = || HandlerError::NotFound(say!("part-named", part = number.to_string()));
    let part = web.ledger.find_part(PartId(number)).await?.ok_or_else(missing)?;
    let width = if asked.width.is_some_and(|width| width <= THUMBNAIL_WIDTH) { THUMBNAIL_WIDTH } else { LONE_WIDTH };
    let scheme = asked.scheme;
    let mended = asked.mended.unwrap_or(!part.mending.mended_hash.is_empty());
    let key = format!(
        "{} {} {:?} {:?} {width} {scheme:?} {mended}",
        part.file.content_hash, part.solid.object_index, part.terms.unit, part.measures.read_unit
    );
    let png = match web.caches.parts.get(&key) {
        Some(png) => png,
        None => {
            let _turn = web.render_slot.clone().acquire_owned().await.context("waiting for a turn")?;
            let shown = farm::load_part_mesh(&web.current_settings(), &web.ledger, &part, mended).await?;
            let size = (width, width / 4 * 3);
            let draw = move || {
                shown.map_or_else(Bytes::new, |shown| {
                    Bytes::from(draw_part(&shown.mesh, &shown.mended, 0, scheme, size))
                })
            };
            let png = tokio::task::spawn_blocking(draw).await.context("drawing a part")?;
            web.caches.parts.insert(key, png.clone());
            png
        }
    };
    // Once somebody says yes and it is read, the same address shows the mended part.
    let may_change = asked.mended.is_none() && (is_mendable(&part) || part.state == PartState::Claimed);
    Ok(if png.is_empty() { no_picture() } else { png_answer(png, !may_change) })
}

/// Whether a part was refused and would be printed if somebody said that it may be mended.
pub(crate) fn is_mendable(part: &PartRow) -> bool {
    part.state == PartState::Refused && part.refused.refusal == Some(RefusalCause::Mendable)
}

/// The picture of a part on its page; of a mesh that was or can be mended two, before and after.
pub(crate) fn part_picture(part: &PartRow) -> Markup {
    let source = format!("/parts/{}/picture", part.id);
    let picture = |source: &str, alt: String| {
        themed_picture(
            source,
            &html! { img.part-picture alt=(alt) title=(alt) width=(LONE_WIDTH) height=(LONE_WIDTH / 4 * 3) src=(source); },
        )
    };
    match (part.state, is_mendable(part) || !part.mending.mended_hash.is_empty()) {
        (_, true) => html! {
            (picture(&format!("{source}?mended=false"), say!("picture-of-refused")))
            (picture(&format!("{source}?mended=true"), say!("picture-of-mended")))
        },
        (PartState::Refused, _) => picture(&source, say!("picture-of-refused")),
        _ => picture(&source, say!("picture-of-part")),
    }
}

/// The picture on a machine's card: the open build, else the build that is being nested, else the last published one.
pub(crate) async fn machine_picture(web: &DashboardState, status: &MachineStatus) -> HandlerResult<Markup> {
    let open = status.open.as_ref().filter(|open| open.copies.unwrap_or(0) > 0);
    let (id, what) = match (open, status.nesting.first(), &status.last_published) {
        (Some(open), _, _) => (open.build, say!("picture-so-far")),
        (None, Some(nesting), _) => (nesting.build, language::say_word("state", "being made")),
        (None, None, Some(last)) => (last.build, say!("picture-published-last")),
        (None, None, None) => return Ok(html! {}),
    };
    let Some(build) = web.ledger.find_build(id).await? else { return Ok(html! {}) };
    // A build that fired without a layout has no height yet.
    let height = fields::HEIGHT
        .with_unit(build.measures.height_mm)
        .map_or_else(|| say!("height-not-known"), |height| say!("so-high", height = height));
    let copies = say!("count-copies", count = build.measures.copies.unwrap_or(0));
    let alt = say!("picture-of-build", build = id.to_string(), what = what, copies = copies, height = height);
    let source = format!("/builds/{id}/picture?width=480&of={}", layout_version(&build));
    Ok(html! {
        a.shot href=(format!("/builds/{id}")) {
            (themed_picture(&source, &html! { img loading="lazy" width="240" height="180" alt=(alt) src=(source); }))
        }
    })
}
