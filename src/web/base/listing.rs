//! Tables and fact sheets for pages, made from the columns and facts of `tables`.

use language::say;
use maud::{Markup, html};

use super::{
    format::{DASH, prose_with_code},
    query::order_address,
};
use crate::{
    tables::{CellValue, FieldDefinition, SheetFact, TableColumn, TimeView, fields, people_columns},
    web::look::{
        chip::chip,
        pieces::thumbnail,
        times::{due_of, estimate_of, promise_of, time_of},
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
    shown_table(name, caption, &people_columns(columns, rows), rows, view)
}

/// A table with the columns of these keys, in their order.
pub(crate) fn table_of_keys<Row>(
    (name, caption): (&str, Option<String>),
    columns: &[TableColumn<Row>],
    keys: &[&str],
    rows: &[Row],
    view: &TimeView,
) -> Markup {
    let chosen: Vec<&TableColumn<Row>> =
        keys.iter().filter_map(|key| columns.iter().find(|column| column.key == *key)).collect();
    shown_table(name, caption, &chosen, rows, view)
}

/// A table without the columns in which nothing stands. On a narrow screen each row is a card.
fn shown_table<Row>(
    name: &str,
    caption: Option<String>,
    columns: &[&TableColumn<Row>],
    rows: &[Row],
    view: &TimeView,
) -> Markup {
    let is_said = |column: &TableColumn<Row>| {
        let is_nothing = |value: &CellValue| column.field.is_hidden_where_zero && *value == CellValue::Whole(0);
        let values = || rows.iter().map(|row| (column.value)(row)).filter(|value| !is_nothing(value));
        rows.is_empty() || values().any(|value| column.field.cell_text(&value, view).is_some())
    };
    let columns: Vec<&&TableColumn<Row>> = columns.iter().filter(|column| is_said(column)).collect();
    html! {
        div.wide.listed tabindex="0" role="region" aria-label=(name) {
            table {
                @if let Some(caption) = caption { caption { (caption) } }
                thead { tr { @for column in &columns { (heading(&column.field)) } } }
                tbody { @for row in rows { (card_row(columns.iter().map(|column| (column.field, (column.value)(row))), view)) } }
            }
        }
    }
}

/// A row; all of it is the target of its first link.
fn card_row(cells: impl Iterator<Item = (FieldDefinition, CellValue)>, view: &TimeView) -> Markup {
    let mut link = CellLink::Row;
    let cell = |(field, value): (FieldDefinition, CellValue)| {
        let shown = card_cell(&field, &value, link, view);
        link = if page_of(&value).is_some() { CellLink::Own } else { link };
        shown
    };
    let cells: Vec<Markup> = cells.map(cell).collect();
    html! { tr { @for cell in &cells { (cell) } } }
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
    let link = if has_pages { CellLink::Own } else { CellLink::None };
    html! { td class=[class] data-of=(field.page_heading()) { (shown(field, value, link, view)) } }
}

/// Letters from which on a text may be broken anywhere.
const LONG_TEXT: usize = 28;

/// A cell that tells its heading where its row is shown as a card, and stays away there if it is empty. A name is the title of the card.
fn card_cell(field: &FieldDefinition, value: &CellValue, link: CellLink, view: &TimeView) -> Markup {
    let text = field.cell_text(value, view);
    let is_title = field.label == fields::NAME.label || field.label == fields::ORDER.label;
    let classes = [
        class_of(field),
        text.is_none().then_some("none"),
        is_title.then_some("title"),
        matches!(value, CellValue::NamedPart(..)).then_some("pictured"),
        text.is_some_and(|text| text.chars().count() > LONG_TEXT).then_some("long"),
    ];
    let class = classes.into_iter().flatten().collect::<Vec<_>>().join(" ");
    html! { td class=[Some(class).filter(|class| !class.is_empty())] data-of=(field.page_heading()) {
        @if let CellValue::NamedPart(part, _) = value { (thumbnail(*part)) }
        (shown(field, value, link, view))
    } }
}

/// How a cell leads to the page of what it names.
#[derive(Clone, Copy, PartialEq, Eq)]
enum CellLink {
    None,
    /// It leads there.
    Own,
    /// Its whole row does.
    Row,
}

/// The page of what a value names.
fn page_of(value: &CellValue) -> Option<String> {
    Some(match value {
        CellValue::Build(build) => format!("/builds/{build}"),
        CellValue::BuildWithPart(build, part) => format!("/builds/{build}#part-{part}"),
        CellValue::Part(part) | CellValue::NamedPart(part, _) => format!("/parts/{part}"),
        CellValue::Order(name) if !name.is_empty() => order_address(name),
        _ => return None,
    })
}

fn shown(field: &FieldDefinition, value: &CellValue, link: CellLink, view: &TimeView) -> Markup {
    let text = field.cell_text(value, view);
    let text = text.as_deref().unwrap_or(DASH);
    match (value, page_of(value).filter(|_| link != CellLink::None)) {
        (_, Some(page)) => html! { a.lead[link == CellLink::Row] href=(page) { (text) } },
        (CellValue::Prose(_), None) => prose_with_code(text),
        (CellValue::State(_), None) => chip(text),
        (CellValue::Time(at), None) => time_of(*at, view),
        (CellValue::Estimate(at), None) => estimate_of(*at, view),
        (CellValue::Due(due), None) => due_of(due, view),
        (CellValue::Promise(promise), None) => promise_of(promise, view),
        _ => html! { (text) },
    }
}

/// Facts that only some want to know.
const DETAILS: [FieldDefinition; 14] = [
    fields::LOWER_BOUND,
    fields::LAYERS,
    fields::CLEARANCE,
    fields::SEARCH,
    fields::FIRED_BY,
    fields::OPENED,
    fields::NESTING,
    fields::VERIFIED,
    fields::TAKEN,
    fields::CLAIMED,
    fields::ORIENTATION,
    fields::FILE,
    fields::CONTENT,
    fields::REFERENCE,
];

/// The facts as a description list; what only some want to know is folded. `elsewhere` = what the page says in another way.
pub(crate) fn fact_sheet(mut known: Vec<SheetFact>, elsewhere: &[FieldDefinition], view: &TimeView) -> Markup {
    known.retain(|fact| !elsewhere.iter().any(|field| field.label == fact.label));
    parted_facts(known, view, false)
}

/// The facts where all of them are asked for.
pub(crate) fn whole_fact_sheet(known: Vec<SheetFact>, view: &TimeView) -> Markup {
    parted_facts(known, view, true)
}

fn parted_facts(known: Vec<SheetFact>, view: &TimeView, is_open: bool) -> Markup {
    let is_detail = |fact: &SheetFact| DETAILS.iter().any(|field| field.label == fact.label);
    let (details, main): (Vec<_>, Vec<_>) = known.into_iter().partition(is_detail);
    html! {
        (fact_list(&main, view))
        @if !details.is_empty() { details open[is_open] { summary { (say!("details")) } (fact_list(&details, view)) } }
    }
}

/// The facts as a description list.
pub(crate) fn fact_list(known: &[SheetFact], view: &TimeView) -> Markup {
    html! {
        @if !known.is_empty() { dl.facts { @for fact in known { div { dt { (language::say_word("field", fact.label)) } dd {
            @match (fact.at, &fact.due) {
                (Some(at), _) => (time_of(at, view)),
                (None, Some(due)) => (due_of(due, view)),
                (None, None) => (fact.text),
            }
        } } } } }
    }
}
