//! Pictures of builds for pages, drawn one at a time and kept: the same picture is asked for by every look at the farm.

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
    problem::Answer,
    render::{Kept, build_of, of_cake, version},
    state::Web,
    words::count,
};
use crate::{farm::Cake, ledger::ProfileStatus, tables::fields};

/// Widths that pages ask for, pixels; whatever is asked becomes the next of them.
const WIDTHS: [u32; 2] = [480, 640];
/// Pictures that are kept; some 50 kB each.
pub(super) const KEPT: usize = 64;

/// What a picture is asked with.
#[derive(Debug, Deserialize)]
pub(super) struct Asked {
    width: Option<u32>,
    /// What the page knew the build by; a browser may keep that picture.
    of: Option<String>,
}

/// The picture of a build, a PNG.
pub(super) async fn picture(
    State(web): State<Arc<Web>>,
    Path(number): Path<i64>,
    Query(asked): Query<Asked>,
) -> Answer<Response> {
    let (build, profile) = build_of(&web, number).await?;
    let wanted = asked.width.unwrap_or(WIDTHS[WIDTHS.len() - 1]);
    let width = WIDTHS.into_iter().find(|&width| width >= wanted).unwrap_or(WIDTHS[WIDTHS.len() - 1]);
    let kept = Kept { cache: |web| &web.caches.pictures, key: format!("{} {width}", version(&build)) };
    let draw = move |cake: &Cake| Ok(Bytes::from(cake.picture(Viewpoint::Iso, (width, width / 4 * 3))));
    let png = of_cake(&web, &build, &profile, kept, draw).await?;
    let stays = asked.of.is_some_and(|of| of == version(&build));
    let keep = if stays { "private, max-age=31536000, immutable" } else { "private, no-cache" };
    Ok(([(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, keep)], png).into_response())
}

/// The picture on a machine's card: of what waits, else of what is being made, else of what was published last.
pub(super) async fn of_profile(web: &Web, status: &ProfileStatus) -> Answer<Markup> {
    let open = status.open.as_ref().filter(|open| open.copies.unwrap_or(0) > 0);
    let (id, what) = match (open, status.nesting.first(), &status.last_published) {
        (Some(open), _, _) => (open.build, "so far"),
        (None, Some(nesting), _) => (nesting.build, "being made"),
        (None, None, Some(last)) => (last.build, "published last"),
        (None, None, None) => return Ok(html! {}),
    };
    let Some(build) = web.ledger.build(id).await? else { return Ok(html! {}) };
    // A build that has just fired without a layout has nothing to show yet.
    let height = fields::HEIGHT
        .with_unit(build.measures.height_mm)
        .map_or_else(|| "height not known yet".to_owned(), |height| height + " high");
    let copies = count(build.measures.copies.unwrap_or(0), "copy", "copies");
    let alt = format!("Build {id}, {what}: {copies}, {height}");
    let source = format!("/builds/{id}/picture?width=480&of={}", version(&build));
    Ok(html! {
        a.shot href=(format!("/builds/{id}")) {
            img loading="lazy" width="240" height="180" alt=(alt) src=(source);
        }
    })
}
