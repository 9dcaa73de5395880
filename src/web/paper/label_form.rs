//! The form that asks for labels, and the PDF of a build and of an order.

use std::sync::Arc;

use anyhow::Context;
use axum::{
    extract::{Path, State},
    http::{HeaderMap, header},
    response::{IntoResponse, Response},
};
use farm::load_placed_parts;
use language::say;
use maud::{Markup, html};
use serde::{Deserialize, Serialize};

use super::{
    label_layout::Label,
    label_pdf::{fonts_for, write_labels},
    label_sheet::{LabelSheet, SHEETS},
    labels_of::{Bag, LinkRoot, bag_labels, bin_labels},
    system_fonts::{SystemFont, font_folders},
};
use crate::web::{
    base::{
        error::{HandlerError, HandlerResult},
        page::html_page,
        query::{Query, order_address, query_string},
    },
    core::{cached_render::find_build, state::DashboardState},
    look::pieces::sheet,
};

/// What is labelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Labelled {
    /// The copies of an order in a build.
    #[default]
    Bins,
    /// The copies of a part.
    Bags,
}

/// Which labels.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct LabelQuery {
    of: Labelled,
    sheet: LabelSheet,
    /// Labels that the first sheet lacks already.
    used: usize,
    /// Sent if letters that no font has may be boxes.
    #[serde(skip_serializing_if = "Option::is_none")]
    boxes: Option<String>,
}

/// Asks for the labels of a build.
pub(crate) fn build_labels(build: i64) -> Markup {
    label_form(&format!("/builds/{build}/labels.pdf"), true)
}

/// Asks for the labels of an order.
pub(crate) fn order_labels(order: &str) -> Markup {
    label_form(&format!("{}/labels.pdf", order_address(order)), false)
}

fn label_form(address: &str, has_bins: bool) -> Markup {
    let form = html! {
        form.tell method="get" action=(address) {
            @if has_bins { label { (say!("labels-for")) select name="of" {
                option value="bins" { (say!("labels-of-bins")) }
                option value="bags" { (say!("labels-of-bags")) }
            } } }
            label { (say!("label-sheet")) select name="sheet" { @for sheet in SHEETS { option value=(sheet.word()) { (sheet.words()) } } } }
            label { (say!("labels-used")) input type="number" name="used" min="0" max="29" value="0"; }
            button type="submit" { (say!("open-pdf")) }
        }
    };
    let name = if has_bins { say!("labels-bins-bags") } else { say!("labels-bags") };
    sheet("labels", &name, false, &form)
}

/// The labels of a build as PDF.
pub(crate) async fn get_build_labels(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(query): Query<LabelQuery>,
    headers: HeaderMap,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let placed = load_placed_parts(&web.ledger, &build, &profile).await?;
    let bags: Vec<Bag> = placed.iter().map(|(part, copies)| Bag::of_part(part, copies.len() as u32)).collect();
    let root = LinkRoot::of_request(&headers);
    let labels = match query.of {
        Labelled::Bins => bin_labels(&bags, number, &root),
        Labelled::Bags => bag_labels(&bags, Some(number), &root),
    };
    let title = say!("labels-of-build", build = number.to_string());
    answer_labels(title, labels, query, &format!("/builds/{number}/labels.pdf")).await
}

/// The labels of an order as PDF, one for each of its parts.
pub(crate) async fn get_order_labels(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    Query(query): Query<LabelQuery>,
    headers: HeaderMap,
) -> HandlerResult<Response> {
    let lines = web.ledger.order_lines(&name).await?;
    let bags: Vec<Bag> = lines.iter().map(|line| Bag::of_line(&name, line)).collect();
    let labels = bag_labels(&bags, None, &LinkRoot::of_request(&headers));
    let address = format!("{}/labels.pdf", order_address(&name));
    answer_labels(say!("labels-of-order", order = &name), labels, query, &address).await
}

/// Labels as PDF. `address` = where they are.
async fn answer_labels(title: String, labels: Vec<Label>, query: LabelQuery, address: &str) -> HandlerResult<Response> {
    if labels.is_empty() {
        return Err(HandlerError::NotFound(say!("part-to-label")));
    }
    let place = (query.sheet.shape(), query.used);
    let takes_boxes = query.boxes.is_some();
    let anyway = query_string(&LabelQuery { boxes: Some("yes".to_owned()), ..query })?;
    let write = move |title: &str, labels: Vec<Label>, fonts: &[SystemFont]| write_labels(title, &labels, place, fonts);
    let file = PaperFile { title, name: "labels.pdf".to_owned(), with_boxes: format!("{address}?{anyway}") };
    file.answer(labels, takes_boxes, write).await
}

/// A file that is printed.
pub(super) struct PaperFile {
    /// What it is called.
    pub(super) title: String,
    /// Name of the file.
    pub(super) name: String,
    /// Where it is with boxes instead of letters that no font has.
    pub(super) with_boxes: String,
}

impl PaperFile {
    /// The PDF that is written of labels; instead of it a page that names the letters that no font has, unless boxes are meant.
    pub(super) async fn answer(
        self,
        labels: Vec<Label>,
        takes_boxes: bool,
        write: impl FnOnce(&str, Vec<Label>, &[SystemFont]) -> anyhow::Result<Vec<u8>> + Send + 'static,
    ) -> HandlerResult<Response> {
        let title = self.title.clone();
        let write = move || -> anyhow::Result<Result<Vec<u8>, Vec<char>>> {
            let (fonts, missing) = fonts_for(&labels, &font_folders())?;
            if !missing.is_empty() && !takes_boxes {
                return Ok(Err(missing));
            }
            Ok(Ok(write(&title, labels, &fonts)?))
        };
        // Fonts of the system are files.
        match tokio::task::spawn_blocking(write).await.context("a step ended")?? {
            Ok(pdf) => {
                let name = format!("inline; filename=\"{}\"", self.name);
                let headers =
                    [(header::CONTENT_TYPE, "application/pdf".to_owned()), (header::CONTENT_DISPOSITION, name)];
                Ok((headers, pdf).into_response())
            }
            Err(missing) => {
                let content = html! {
                    h1 { (self.title) }
                    p #problem role="alert" { (say!("labels-lack", letters = missing.into_iter().collect::<String>())) }
                    p { (say!("labels-lack-remedy")) }
                    p { a.button href=(self.with_boxes) { (say!("labels-with-boxes")) } }
                };
                Ok(html_page(&self.title, "", None, &content).into_response())
            }
        }
    }
}
