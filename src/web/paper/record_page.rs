//! The record of a part, as page and PDF: how its copies were made, for a customer or an auditor who asks.

use std::sync::Arc;

use axum::{
    extract::{Path, State},
    http::HeaderMap,
    response::Response,
};
use farm::{RecordedBuild, RecordedCopy, read_part_record};
use language::say;
use ledger::{FinishingStep, PartFinishing, PartId, PartRow, UtcTimestamp};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    label_form::PaperFile,
    label_layout::{Label, split_into_pages},
    label_pdf::write_labels,
    label_sheet::SheetShape,
    labels_of::LinkRoot,
    system_fonts::SystemFont,
};
use crate::{
    tables::{
        CellValue, RECORDED_COPY_COLUMNS, SheetFact, TableColumn, TimeView, fields, part_facts, people_columns,
        record_facts, wanted_text,
    },
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            listing::{table_of, whole_fact_sheet},
            page::html_page,
            query::Query,
        },
        core::state::DashboardState,
    },
};

/// A part, and how its copies were made.
pub(crate) struct MadePart {
    pub(crate) part: PartRow,
    /// What was done with them afterwards.
    pub(crate) finishing: PartFinishing,
    /// The builds that made copies of it.
    pub(crate) builds: Vec<RecordedBuild>,
}

impl MadePart {
    /// The record of a part; an error if there is none of this number.
    pub(crate) async fn read(web: &DashboardState, number: i64) -> HandlerResult<Self> {
        let id = PartId(number);
        let missing = || HandlerError::NotFound(say!("part-named", part = number.to_string()));
        let part = web.ledger.find_part(id).await?.ok_or_else(missing)?;
        let builds = read_part_record(&web.ledger, id, &web.read_plans().await?).await?;
        Ok(Self { finishing: web.ledger.finishing_of_part(&part).await?, part, builds })
    }

    /// What was done with it after the print, a line for each step.
    fn finishing_lines(&self, time_text: impl Fn(UtcTimestamp) -> String) -> Vec<String> {
        let line = |step: &FinishingStep| {
            let how = match step.done_by.as_ref().zip(step.done_at) {
                Some((by, at)) => say!("time-by", time = time_text(at), by = by),
                None => say!("finishing-open"),
            };
            labelled(&step.step, &how)
        };
        self.finishing.steps.iter().map(line).collect()
    }
}

/// The record as a page.
pub(crate) async fn show_record(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Markup> {
    let made = MadePart::read(&web, number).await?;
    let (part, builds) = (&made.part, &made.builds);
    let (title, view) = (title_of(part), web.time_view());
    let content = html! {
        h1 { (title) }
        div.buttons.acts {
            a.button href=(format!("/parts/{number}/record.pdf")) { (say!("open-pdf")) }
            a.button href=(format!("/parts/{number}")) { (say!("part-number", part = number.to_string())) }
        }
        (whole_fact_sheet(told_facts(part, &view), &view))
        @if builds.is_empty() { p { (say!("record-empty")) } }
        @for build in builds {
            h2 { a href=(format!("/builds/{}", build.build)) { (say!("build-number", build = build.build.to_string())) } }
            (whole_fact_sheet(record_facts(build, &view), &view))
            (table_of(&fields::COPIES.said(), None, RECORDED_COPY_COLUMNS, &build.copies, &view))
        }
        @if !made.finishing.steps.is_empty() {
            h2 { (fields::FINISH.said()) }
            ul { @for line in made.finishing_lines(|at| view.near_text(at)) { li { (line) } } }
        }
    };
    Ok(html_page(&title, "/parts", None, &content))
}

/// What was asked, and what was read. How far it is, its builds say.
fn told_facts(part: &PartRow, view: &TimeView) -> Vec<SheetFact> {
    let mut known = part_facts(part, wanted_text(part), view);
    known.retain(|fact| ![fields::STATE, fields::PRIORITY].iter().any(|field| field.label == fact.label));
    known
}

fn title_of(part: &PartRow) -> String {
    say!("record-of-part", part = part.id.to_string(), name = part.full_name())
}

/// How the PDF is asked for.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub(crate) struct RecordQuery {
    /// Sent if letters that no font has may be boxes.
    boxes: Option<String>,
}

/// The record as PDF.
pub(crate) async fn get_record_pdf(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(query): Query<RecordQuery>,
    headers: HeaderMap,
) -> HandlerResult<Response> {
    let made = MadePart::read(&web, number).await?;
    let address = LinkRoot::of_request(&headers).of_page(&format!("/parts/{number}/record"));
    let text = Label { title: title_of(&made.part), lines: record_lines(&made, &web.time_view()), address };
    let file = PaperFile {
        title: text.title.clone(),
        name: format!("part-{number}-record.pdf"),
        with_boxes: format!("/parts/{number}/record.pdf?boxes=yes"),
    };
    let write = |title: &str, texts: Vec<Label>, fonts: &[SystemFont]| {
        let shape = SheetShape::PAGE;
        let pages =
            texts.iter().map(|text| split_into_pages(text, shape, fonts)).collect::<anyhow::Result<Vec<_>>>()?;
        write_labels(title, &pages.concat(), (shape, 0), fonts)
    };
    file.answer(vec![text], query.boxes.is_some(), write).await
}

/// The record, line by line.
fn record_lines(made: &MadePart, view: &TimeView) -> Vec<String> {
    let (part, builds) = (&made.part, &made.builds);
    // A text of several lines is one on paper.
    let plain = |text: &str| text.lines().collect::<Vec<_>>().join(" / ");
    let fact_line = |fact: SheetFact| labelled(&language::say_word("field", fact.label), &plain(&fact.text));
    let mut lines: Vec<String> = told_facts(part, view).into_iter().map(fact_line).collect();
    if builds.is_empty() {
        lines.extend([String::new(), say!("record-empty")]);
    }
    for build in builds {
        lines.extend([String::new(), say!("build-number", build = build.build.to_string())]);
        lines.extend(record_facts(build, view).into_iter().map(fact_line));
        let columns = people_columns(RECORDED_COPY_COLUMNS, &build.copies);
        lines.extend(build.copies.iter().map(|copy| copy_line(copy, &columns, view)));
    }
    if !made.finishing.steps.is_empty() {
        lines.extend([String::new(), fields::FINISH.said()]);
        lines.extend(made.finishing_lines(|at| view.time_text(at)));
    }
    lines
}

/// A copy with what is known of it.
fn copy_line(copy: &RecordedCopy, columns: &[&TableColumn<RecordedCopy>], view: &TimeView) -> String {
    let said = |column: &&TableColumn<RecordedCopy>| {
        let text = match (column.value)(copy) {
            CellValue::State(word) => language::say_word("state", &word),
            value => column.field.cell_text(&value, view)?,
        };
        Some(labelled(&column.field.said(), &text))
    };
    columns.iter().filter_map(said).collect::<Vec<_>>().join("; ")
}

/// `Material: PA12`.
fn labelled(label: &str, text: &str) -> String {
    say!("labelled-text", label = label, text = text)
}
