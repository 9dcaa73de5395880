//! The files of a build, to take along: the build file, its report, its pictures and its pick map.

use std::{path::PathBuf, sync::Arc};

use anyhow::Context;
use axum::{
    extract::{Path, State},
    http::{HeaderMap, HeaderValue, header},
    response::{Html, IntoResponse, Response},
};
use build_file::DeliveryKind;
use farm::{CakeContents, find_proved_file, load_placed_parts};
use language::say;
use ledger::BuildRow;
use maud::{Markup, html};
use settings::MachineProfile;

use super::{
    pick_page::cached_map,
    report::{HtmlReport, ReportSource},
};
use crate::{
    tables::{PICK_COLUMNS, csv_of},
    web::{
        base::error::{HandlerError, HandlerResult},
        core::{cached_render::find_build, content::stream_file, state::DashboardState},
        look::pieces::sheet,
    },
};

/// What the name of the report of the search ends in, as it is written beside the build file.
const SEARCH_REPORT: &str = ".report.json";

/// The files of a build that can be had now, behind a button.
pub(super) async fn downloads_sheet(build: &BuildRow, profile: &MachineProfile) -> HandlerResult<Markup> {
    let files = DownloadableFiles::look(build, profile).await?;
    // What lies at another node is asked for there.
    let is_elsewhere = !profile.of_node.is_empty() && build.staged.file_name.is_some();
    let (has_file, has_search) =
        (is_elsewhere || files.proved.is_some(), is_elsewhere || files.search_report.is_some());
    let number = build.id;
    let kind = build.staged.file_name.as_deref().and_then(DeliveryKind::of_name).unwrap_or_default();
    let format = kind.format().0;
    let file = |address: String, name: &str, what: &str| html! { li { a.row href=(address) download { span.row-name { (name) } span.row-more { (what) } } } };
    let content = html! {
        ul.rows {
            @if has_file { (file(format!("/builds/{number}/file"), &say!("file-build", format = format), &say!("file-build-for"))) }
            (file(format!("/builds/{number}/report.html"), &say!("file-report"), &say!("file-report-for")))
            (file(format!("/builds/{number}/picture"), &say!("file-picture"), ""))
            (file(format!("/builds/{number}/pick.csv"), &say!("file-pick-csv"), &say!("file-pick-csv-for")))
            (file(format!("/api/v1/builds/{number}/pick"), &say!("file-pick-json"), ""))
            (file(format!("/api/v1/builds/{number}"), &say!("file-json"), &say!("file-json-for")))
            @if has_search { (file(format!("/builds/{number}/search.json"), &say!("file-search"), "")) }
        }
        @if !has_file { p.soft { (say!("file-not-kept")) } }
    };
    Ok(sheet("files", &say!("files"), false, &content))
}

/// Where the files of a build lie.
struct DownloadableFiles {
    /// The proved build file, in a queue or in the archive.
    proved: Option<PathBuf>,
    /// The report of the search, beside the build file.
    search_report: Option<PathBuf>,
}

impl DownloadableFiles {
    async fn look(build: &BuildRow, profile: &MachineProfile) -> HandlerResult<Self> {
        let (build, profile) = (build.clone(), profile.clone());
        let look = move || {
            let printer = build.place.printer.as_deref();
            let names = build.sidecar_hashes().into_iter().map(|(name, _)| profile.visible_file(&name, printer));
            let search_report =
                names.filter(|path| path.to_string_lossy().ends_with(SEARCH_REPORT)).find(|path| path.is_file());
            Self { proved: find_proved_file(&profile, &build), search_report }
        };
        Ok(tokio::task::spawn_blocking(look).await.context("looking for the files of a build")?)
    }
}

/// The headers of a file that a browser saves under this name.
fn saved_as(name: &str, kind: &'static str) -> HeaderMap {
    let plain: String = name.chars().filter(|c| c.is_ascii_graphic() && !matches!(c, '"' | '\\')).collect();
    let disposition = HeaderValue::from_str(&format!("attachment; filename=\"{plain}\""));
    let kind = (header::CONTENT_TYPE, HeaderValue::from_static(kind));
    disposition.ok().map(|value| (header::CONTENT_DISPOSITION, value)).into_iter().chain([kind]).collect()
}

/// The proved build file, as it lies in its queue or is kept in the archive.
pub(crate) async fn get_build_file(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let missing = || HandlerError::NotFound(say!("build-file-of", build = number.to_string()));
    let file = DownloadableFiles::look(&build, &profile).await?.proved.ok_or_else(missing)?;
    let name = build.staged.file_name.clone().unwrap_or_else(|| format!("build-{number}.build.3mf"));
    stream_file(&file, saved_as(&name, DeliveryKind::of_name(&name).unwrap_or_default().format().1))
}

/// The report of the search for a build, while it lies beside the build file.
pub(crate) async fn get_search_report(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let missing = || HandlerError::NotFound(say!("search-report-of", build = number.to_string()));
    let file = DownloadableFiles::look(&build, &profile).await?.search_report.ok_or_else(missing)?;
    stream_file(&file, saved_as(&format!("build-{number}{SEARCH_REPORT}"), "application/json"))
}

/// The report of a build as one HTML file.
pub(crate) async fn get_report(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let parts = load_placed_parts(&web.ledger, &build, &profile).await?;
    let (settings, turn) = (web.current_settings(), web.render_slot.clone().acquire_owned().await);
    let language = language::current();
    let making = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        let cake = CakeContents::from_ledger(&settings, &profile, &build, parts);
        language.within(|| HtmlReport { cake: &cake, source: ReportSource::Ledger(&build, &profile) }.to_html())
    });
    let html = making.await.context("writing a report")??;
    Ok((saved_as(&format!("build-{number}.html"), "text/html; charset=utf-8"), Html(html)).into_response())
}

/// The pick map for a spreadsheet.
pub(crate) async fn get_pick_csv(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let map = cached_map(&web, &build, &profile).await?;
    let text = csv_of(PICK_COLUMNS, &map.list.copies).map_err(anyhow::Error::from)?;
    Ok((saved_as(&format!("build-{number}.parts.csv"), "text/csv; charset=utf-8"), text).into_response())
}
