//! A field that people see: its label, its unit and its number format. In a table the heading contains the unit, so
//! that the cells are plain numbers. Elsewhere the unit follows the value.

use farm::said_state;
use ledger::UtcTimestamp;

use super::{
    cell_value::CellValue,
    time_view::{GivenDate, TimeView},
};

/// A field that people see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldDefinition {
    /// Its name, with a capital first letter.
    pub label: &'static str,
    kind: FieldKind,
    /// Whether people do not see a column of it in which all is 0.
    pub is_hidden_where_zero: bool,
}

/// The kind of a field's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FieldKind {
    /// Texts.
    Text,
    /// Whole numbers.
    Whole,
    /// Numbers with a fixed number of decimals.
    Real { unit: &'static str, decimals: usize },
    /// Numbers that a person entered. They print with all their decimals.
    Exact { unit: &'static str },
    /// Shares between 0 and 1, printed in percent.
    Share,
    /// Points in time, shown with their zone.
    Time,
}

/// A line of a fact sheet: a label and a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SheetFact {
    /// The label of its field.
    pub label: &'static str,
    /// The value, with its unit.
    pub text: String,
    /// The time that the text tells, if it is one.
    pub at: Option<UtcTimestamp>,
    /// The due date that the text tells, if it is one.
    pub due: Option<GivenDate>,
}

impl FieldDefinition {
    const fn of_kind(label: &'static str, kind: FieldKind) -> Self {
        Self { label, kind, is_hidden_where_zero: false }
    }

    /// A field of texts.
    pub const fn text(label: &'static str) -> Self {
        Self::of_kind(label, FieldKind::Text)
    }

    /// A field of whole numbers.
    pub const fn whole(label: &'static str) -> Self {
        Self::of_kind(label, FieldKind::Whole)
    }

    /// A field of numbers with a unit and a fixed number of decimals.
    pub const fn real(label: &'static str, unit: &'static str, decimals: usize) -> Self {
        Self::of_kind(label, FieldKind::Real { unit, decimals })
    }

    /// A field of numbers with a unit that print with all their decimals.
    pub const fn exact(label: &'static str, unit: &'static str) -> Self {
        Self::of_kind(label, FieldKind::Exact { unit })
    }

    /// A field of shares, printed in percent.
    pub const fn share(label: &'static str) -> Self {
        Self::of_kind(label, FieldKind::Share)
    }

    /// A field of points in time.
    pub const fn time(label: &'static str) -> Self {
        Self::of_kind(label, FieldKind::Time)
    }

    /// The same field; people do not see a column of it in which all is 0.
    pub const fn unless_zero(self) -> Self {
        Self { is_hidden_where_zero: true, ..self }
    }

    /// The unit of its values; "" = none.
    pub fn unit(&self) -> &'static str {
        match self.kind {
            FieldKind::Text | FieldKind::Whole | FieldKind::Time => "",
            FieldKind::Real { unit, .. } | FieldKind::Exact { unit } => unit,
            FieldKind::Share => "%",
        }
    }

    /// Whether its values are numbers; their cells are aligned to the right.
    pub fn is_number(&self) -> bool {
        !matches!(self.kind, FieldKind::Text | FieldKind::Time)
    }

    /// Its heading on a page: `Height, mm`.
    pub fn page_heading(&self) -> String {
        match self.unit() {
            "" => self.said(),
            unit => language::join_names([self.said(), unit.to_owned()]),
        }
    }

    /// Its label in the language that is current.
    pub fn said(&self) -> String {
        language::say_word("field", self.label)
    }

    /// Its heading in a terminal: `HEIGHT mm`.
    pub fn terminal_heading(&self) -> String {
        let label = self.label.to_uppercase();
        match self.unit() {
            "" => label,
            unit => format!("{label} {unit}"),
        }
    }

    /// The text of a value in a table cell, without the unit; `None` if there is no value.
    pub fn cell_text(&self, value: &CellValue, view: &TimeView) -> Option<String> {
        match value {
            CellValue::Time(at) => Some(view.time_text(*at)),
            CellValue::Estimate(at) => Some(view.estimate_text(*at)),
            CellValue::Due(due) => Some(view.due_text(due)),
            CellValue::Promise(promise) => Some(view.promise_text(promise)),
            other => self.plain_text(other),
        }
    }

    /// The text of a value that is no time, without the unit; `None` if there is no value.
    pub fn plain_text(&self, value: &CellValue) -> Option<String> {
        Some(match value {
            // A time is shown by a `TimeView`, which knows the zone.
            CellValue::Missing
            | CellValue::Time(_)
            | CellValue::Estimate(_)
            | CellValue::Due(_)
            | CellValue::Promise(_) => return None,
            CellValue::Text(text) | CellValue::Prose(text) | CellValue::Order(text) if text.is_empty() => return None,
            CellValue::State(word) => said_state(word).to_owned(),
            CellValue::Text(text) | CellValue::Prose(text) | CellValue::Order(text) | CellValue::NamedPart(_, text) => {
                text.clone()
            }
            CellValue::Whole(number) => number.to_string(),
            CellValue::Real(number) => self.real_text(*number),
            CellValue::Build(build) | CellValue::BuildWithPart(build, _) => build.to_string(),
            CellValue::Part(part) => part.to_string(),
        })
    }

    /// A value that is no time, with its unit: `87.50 mm`; `None` if there is no value.
    pub fn with_unit(&self, value: impl Into<CellValue>) -> Option<String> {
        let text = self.plain_text(&value.into())?;
        Some(match self.unit() {
            "" => text,
            unit => format!("{text} {unit}"),
        })
    }

    /// A line of a fact sheet with a value of this field that is no time; `None` if there is no value.
    pub fn fact(&self, value: impl Into<CellValue>) -> Option<SheetFact> {
        Some(self.fact_of(self.with_unit(value)?))
    }

    /// A line of a fact sheet with this field's label and any text.
    pub fn fact_of(&self, text: String) -> SheetFact {
        SheetFact { label: self.label, text, at: None, due: None }
    }

    fn real_text(&self, number: f64) -> String {
        let (number, decimals) = match self.kind {
            FieldKind::Real { decimals, .. } => (number, decimals),
            FieldKind::Share => (100.0 * number, 1),
            _ => return language::decimal(number.to_string()),
        };
        let text = format!("{number:.decimals$}");
        // A value that rounds to zero prints without a sign.
        language::decimal(match text.strip_prefix('-') {
            Some(nothing) if nothing.bytes().all(|b| b == b'0' || b == b'.') => nothing.to_owned(),
            _ => text,
        })
    }
}

impl TimeView {
    /// A line of a fact sheet with a time; `None` if there is no time.
    pub fn time_fact(&self, field: FieldDefinition, at: impl Into<Option<UtcTimestamp>>) -> Option<SheetFact> {
        let at = at.into()?;
        Some(SheetFact { at: Some(at), ..field.fact_of(self.time_text(at)) })
    }

    /// A line of a fact sheet with a due date; `None` if there is none.
    pub fn due_fact(&self, field: FieldDefinition, due: Option<GivenDate>) -> Option<SheetFact> {
        let due = due?;
        Some(SheetFact { due: Some(due.clone()), ..field.fact_of(self.due_text(&due)) })
    }
}
