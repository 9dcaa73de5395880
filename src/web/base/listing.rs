//! Tables and fact sheets for pages, made from the columns and facts of `tables`.

use maud::{Markup, html};

use super::{
    format::{DASH, prose_with_code},
    query::order_address,
};
use crate::{
    tables::{CellValue, FieldDefinition, SheetFact, TableColumn, TimeView, fields, people_columns},
    web::look::{
        chip::chip,
        times::{due_of, promise_of, time_of},
    },
};

/// A table of rows with the columns that people see. `name` is its label for screen readers, `view` how times are shown.
pub(crate) fn table_of<Row>(
    name: &str,
    caption: Option<String>,
    columns: &[TableColumn<Row>],
    rows: &[Row],
    view: &TimeView,
) -> Markup {
    let columns = people_columns(columns, rows);
    html! {
        div.wide.listed tabindex="0" role="region" aria-label=(name) {
            table {
                @if let Some(caption) = caption { caption { (caption) } }
                thead { tr { @for column in &columns { (heading(&column.field)) } } }
                tbody { @for row in rows { tr {
                    @for column in &columns { (cell(&column.field, &(column.value)(row), true, view)) }
                } } }
            }
        }
    }
}

/// The heading of a column.
pub(crate) fn heading(field: &FieldDefinition) -> Markup {
    html! { th class=[class_of(field)] scope="col" { (field.page_heading()) } }
}

/// The CSS class that aligns numbers to the right.
fn class_of(field: &FieldDefinition) -> Option<&'static str> {
    field.is_number().then_some("n")
}

/// A table cell. It tells its heading where its row is shown as a card, and stays away there if it is empty. If `has_pages`, parts and
/// builds are links to their pages.
pub(crate) fn cell(field: &FieldDefinition, value: &CellValue, has_pages: bool, view: &TimeView) -> Markup {
    let class = match (class_of(field), field.cell_text(value, view)) {
        (_, None) => Some("none"),
        (class, Some(_)) => class,
    };
    html! { td class=[class] data-of=(field.page_heading()) { (shown(field, value, has_pages, view)) } }
}

fn shown(field: &FieldDefinition, value: &CellValue, has_pages: bool, view: &TimeView) -> Markup {
    let text = field.cell_text(value, view);
    let text = text.as_deref().unwrap_or(DASH);
    match value {
        CellValue::Build(build) if has_pages => html! { a href=(format!("/builds/{build}")) { (text) } },
        CellValue::BuildWithPart(build, part) if has_pages => {
            html! { a href=(format!("/builds/{build}#part-{part}")) { (text) ", marked" } }
        }
        CellValue::Part(part) | CellValue::NamedPart(part, _) if has_pages => {
            html! { a href=(format!("/parts/{part}")) { (text) } }
        }
        CellValue::Order(name) if has_pages && !name.is_empty() => html! { a href=(order_address(name)) { (text) } },
        CellValue::Prose(_) => prose_with_code(text),
        CellValue::State(_) => chip(text),
        CellValue::Time(at) => time_of(*at, view),
        CellValue::Due(due) => due_of(due, view),
        CellValue::Promise(promise) => promise_of(promise, view),
        _ => html! { (text) },
    }
}

/// Facts that only some want to know.
const DETAILS: [FieldDefinition; 4] = [fields::SEARCH, fields::FILE, fields::CONTENT, fields::REFERENCE];

/// The facts as a description list; what only some want to know is folded.
pub(crate) fn fact_sheet(known: Vec<SheetFact>, view: &TimeView) -> Markup {
    let is_detail = |fact: &SheetFact| DETAILS.iter().any(|field| field.label == fact.label);
    let (details, main): (Vec<_>, Vec<_>) = known.into_iter().partition(is_detail);
    html! {
        (fact_list(&main, view))
        @if !details.is_empty() { details { summary { "Details" } (fact_list(&details, view)) } }
    }
}

/// The facts as a description list.
pub(crate) fn fact_list(known: &[SheetFact], view: &TimeView) -> Markup {
    html! {
        @if !known.is_empty() { dl.facts { @for fact in known { div { dt { (fact.label) } dd {
            @match fact.at { Some(at) => (time_of(at, view)), None => (fact.text) }
        } } } } }
    }
}
