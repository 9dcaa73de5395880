//! The facts of a part, line by line.

use farm::said_state;
use language::say;
use ledger::{PartMending, PartRow, PartState, is_missing_file};

use super::build_sheet::{content, joined};
use crate::tables::{
    columns::{
        field_definition::{FieldDefinition, SheetFact},
        time_view::{GivenDate, TimeView},
    },
    fields,
};

/// The facts of a part. `copies` is the text that says how many copies there are and where they are.
pub fn part_facts(row: &PartRow, copies: String, view: &TimeView) -> Vec<SheetFact> {
    let state = language::say_word("state", said_state(&row.state.to_string()));
    let state = say!("state-since", state = state, time = view.time_text(row.times.state_at));
    let size =
        row.size_mm().map(|size_mm| joined(size_mm.map(|mm| fields::SIZE.plain_text(&mm.into())), " x ") + " mm");
    let triangles = row.measures.triangles.map(|triangles| say!("triangles", count = triangles.to_string()));
    let volume = row.measures.volume_mm3.and_then(|mm3| fields::PART_VOLUME.with_unit(mm3 / 1000.0));
    let volume = volume.or_else(|| (row.state == PartState::Claimed).then(|| say!("not-read-yet")));
    let clearance = fields::CLEARANCE.with_unit(row.terms.clearance_mm);
    let optional_fact = |field: FieldDefinition, text: Option<String>| text.map(|text| field.fact_of(text));
    let lines = [
        Some(fields::STATE.fact_of(state)),
        fields::MACHINE.fact(&row.machine),
        fields::ORDER.fact(&row.terms.order_name),
        fields::CUSTOMER.fact(&row.terms.customer),
        fields::EMAIL.fact(&row.terms.email),
        fields::MATERIAL.fact(&row.terms.material),
        fields::FINISH.fact(&row.terms.finish),
        Some(fields::COPIES.fact_of(copies)),
        fields::PRIORITY.fact(row.terms.priority),
        view.due_fact(fields::DUE, GivenDate::of_terms(&row.terms)),
        Some(fields::ORIENTATION.fact_of(orientation(row))),
        optional_fact(fields::CLEARANCE, clearance.map(|clearance| say!("as-ticket-says", clearance = clearance))),
        optional_fact(fields::SIZE, size.map(|size| joined([Some(size), triangles], ", "))),
        optional_fact(fields::PART_VOLUME, volume),
        fields::NOTE.fact(&row.terms.note),
        fields::REFERENCE.fact(&row.terms.reference),
        optional_fact(fields::MENDED, mended(row)),
        (!is_missing_file(&row.file.claim))
            .then(|| fields::CONTENT.fact_of(content(row.file.bytes, &row.file.content_hash))),
        view.time_fact(fields::CLAIMED, row.times.claimed_at),
    ];
    lines.into_iter().flatten().collect()
}

/// What was done to its mesh, and who allowed it.
fn mended(row: &PartRow) -> Option<String> {
    let PartMending { mend_allowed_by, mended, mended_hash } = &row.mending;
    let told = || say!("mended-text", what = language::told(mended), by = mend_allowed_by, hash = mended_hash);
    (!mended_hash.is_empty()).then(told)
}

fn orientation(row: &PartRow) -> String {
    let tilts = row.terms.tilts.0.iter().map(|tilt| format!(", {}", tilt.in_words()));
    let word = format!("{:?}", row.terms.orientation).to_lowercase();
    language::say_word("turned", &word) + &tilts.collect::<String>()
}
