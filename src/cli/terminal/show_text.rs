//! The output of `nestd show` for people.

use build_file::escape_invisible;
use farm::part_fact;
use ledger::{BuildState, EventRow, PartRow};

use super::{
    lookup::{BuildDetails, LookupResult, OrderDetails, PartDetails},
    table::TextTable,
    terminal::wrap_words,
};
use crate::tables::{
    BUILD_PART_COLUMNS, CountedPart, EVENT_COLUMNS, GivenDate, ORDERED_PART_COLUMNS, OUTCOME_COLUMNS, OrderedPart,
    PromisedDate, SheetFact, TableColumn, TimeView, WAITING_PART_COLUMNS, build_facts, closing_text, fields,
    order_copies_text, part_facts, wanted_text, whereabouts,
};

/// Columns that are left out on a narrow terminal, the first of them first.
const LEAST_COLUMNS: &[&str] = &["machine", "state", "due_at", "reason_or_warning", "where"];
/// Where the texts of facts begin.
const FACT_INDENT: usize = 14;

/// Everything that was found.
pub fn lookup_text(found: &LookupResult, view: &TimeView, columns: usize) -> String {
    let mut sheets = Vec::new();
    sheets.extend(found.build.as_ref().map(|build| build_text(build, view, columns)));
    sheets.extend(found.part.as_ref().map(|part| part_text(part, view, columns)));
    if let (Some(order), false) = (&found.order_sheet, found.order.is_empty()) {
        sheets.push(order_text(order, view, columns) + &parts_table(&found.order, view, columns));
    }
    match found.named.as_slice() {
        [] => {}
        [one] => sheets.push(part_text(one, view, columns)),
        [first, ..] => {
            sheets.push(format!("Parts named {}\n\n{}", first.part.name, parts_table(&found.named, view, columns)))
        }
    }
    sheets.join("\n")
}

fn order_text(sheet: &OrderDetails, view: &TimeView, columns: usize) -> String {
    let (order, fact) = (&sheet.dated.order, &sheet.dated.fact);
    let facts = [
        fields::CUSTOMER.fact(&order.order.customer),
        Some(fields::COPIES.fact_of(order_copies_text(order))),
        view.due_fact(fields::DUE, GivenDate::new(order.due_at, &order.due_text)),
        PromisedDate::of_order(fact).map(|promise| fields::DONE.fact_of(view.promise_text(&promise))),
        fields::RISK.fact(&fact.risk_reason),
        closing_text(&order.order, view).map(|text| fields::CLOSED.fact_of(text)),
        Some(fields::CUSTOMER_NOTE.fact_of(sheet.customer_note.clone())),
    ];
    let facts: Vec<SheetFact> = facts.into_iter().flatten().collect();
    format!("Order {}: {}\n{}\n", order.order.name, fact.word.word(), align_fields(&facts, columns))
}

fn build_text(sheet: &BuildDetails, view: &TimeView, columns: usize) -> String {
    let row = &sheet.build;
    let file = sheet.file.as_ref().map(|file| file.display().to_string());
    let mut facts = build_facts(row, sheet.machine.as_ref(), (copies_in_build(sheet), file), view);
    facts.splice(0..0, fields::REASON.fact(&row.reason));
    let unpacked = sheet.fact.ends_at.map(|at| fields::UNPACKED.fact_of(view.estimate_text(at)));
    facts.splice(0..0, unpacked);
    let mut text =
        format!("Build {} of {}: {}\n{}", row.id, row.machine, sheet.fact.word, align_fields(&facts, columns));
    let here = |id| sheet.placements.iter().filter(|placement| placement.part_id == id).count() as u32;
    let counted = |part: &PartRow| CountedPart::of_build(part.clone(), here(part.id), &sheet.placements);
    let parts: Vec<CountedPart> = sheet.parts.iter().map(counted).collect();
    text += &table_below(BUILD_PART_COLUMNS, &parts, view, columns);
    text += &table_below(WAITING_PART_COLUMNS, &sheet.waiting, view, columns);
    text += &table_below(OUTCOME_COLUMNS, &sheet.outcomes, view, columns);
    text + &events_text(&sheet.events, view, columns)
}

/// The number of copies in a build. An open build has only a forecast: it takes no copies before it fires.
fn copies_in_build(sheet: &BuildDetails) -> String {
    let copies = sheet.build.measures.copies.unwrap_or(0);
    match sheet.build.state {
        BuildState::Open => {
            let waiting: u32 = sheet.waiting.iter().map(|waits| waits.copies).sum();
            format!("{copies} in the layout so far, {waiting} wait")
        }
        _ => copies.to_string(),
    }
}

fn part_text(sheet: &PartDetails, view: &TimeView, columns: usize) -> String {
    let row = &sheet.part;
    let mut facts = part_facts(row, format!("{}, {}", wanted_text(row), whereabouts(&sheet.placements)), view);
    facts.extend(fields::REASON.fact(&row.refused.reason));
    facts.extend(
        sheet
            .questions
            .iter()
            .map(|question| fields::QUESTION.fact_of(format!("{} {}", question.text, question.remedy))),
    );
    facts.extend(row.told_warnings().filter_map(|warning| fields::WARNING.fact(warning)));
    format!(
        "Part {}, {}: {}\n{}{}",
        row.id,
        row.full_name(),
        part_fact(row.state, &sheet.copies),
        align_fields(&facts, columns),
        events_text(&sheet.events, view, columns)
    )
}

fn parts_table(sheets: &[PartDetails], view: &TimeView, columns: usize) -> String {
    let row = |sheet: &PartDetails| OrderedPart {
        part: sheet.part.clone(),
        placed: sheet.placements.clone(),
        copies: sheet.copies,
    };
    TextTable::of(ORDERED_PART_COLUMNS, &sheets.iter().map(row).collect::<Vec<_>>(), view)
        .fit_essentials(columns, LEAST_COLUMNS)
}

fn events_text(events: &[EventRow], view: &TimeView, columns: usize) -> String {
    table_below(EVENT_COLUMNS, events, view, columns)
}

/// A table after an empty line; nothing where it has no row.
fn table_below<Row>(table: &[TableColumn<Row>], rows: &[Row], view: &TimeView, columns: usize) -> String {
    let text = || TextTable::of(table, rows, view).fit_essentials(columns, LEAST_COLUMNS);
    if rows.is_empty() { String::new() } else { format!("\n{}", text()) }
}

fn align_fields(facts: &[SheetFact], columns: usize) -> String {
    let line = |fact: &SheetFact| format!("  {:<12}{}", fact.label.to_lowercase(), escape_invisible(&fact.text));
    facts.iter().map(|fact| wrap_words(&line(fact), columns, FACT_INDENT) + "\n").collect()
}
