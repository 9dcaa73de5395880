//! A field that people see: its label, its unit and how its values print. A heading names the unit, so that the cells below it
//! are plain numbers; elsewhere the unit stands behind the value.

use super::cell_value::CellValue;

/// A field that people see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldDefinition {
    /// What it is called, as at the beginning of a sentence.
    pub label: &'static str,
    kind: FieldKind,
}

/// What kind of values a field has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FieldKind {
    /// Texts.
    Text,
    /// Whole numbers.
    Whole,
    /// Numbers with so many decimals.
    Real { unit: &'static str, decimals: usize },
    /// Numbers that somebody wrote, with as many decimals as they have.
    Exact { unit: &'static str },
    /// Shares 0..1, which people read in percent.
    Share,
    /// Points in time, UTC.
    Time,
}

/// A line of a sheet: a label and what is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SheetFact {
    /// The label of its field.
    pub label: &'static str,
    /// What is known, with units.
    pub text: String,
}

impl FieldDefinition {
    /// A field of texts.
    pub const fn text(label: &'static str) -> Self {
        Self { label, kind: FieldKind::Text }
    }

    /// A field of whole numbers.
    pub const fn whole(label: &'static str) -> Self {
        Self { label, kind: FieldKind::Whole }
    }

    /// A field of numbers in a unit, with so many decimals.
    pub const fn real(label: &'static str, unit: &'static str, decimals: usize) -> Self {
        Self { label, kind: FieldKind::Real { unit, decimals } }
    }

    /// A field of numbers in a unit that print as somebody wrote them.
    pub const fn exact(label: &'static str, unit: &'static str) -> Self {
        Self { label, kind: FieldKind::Exact { unit } }
    }

    /// A field of shares, in percent.
    pub const fn share(label: &'static str) -> Self {
        Self { label, kind: FieldKind::Share }
    }

    /// A field of points in time.
    pub const fn time(label: &'static str) -> Self {
        Self { label, kind: FieldKind::Time }
    }

    /// The unit of its values, "" = they have none.
    pub fn unit(&self) -> &'static str {
        match self.kind {
            FieldKind::Text | FieldKind::Whole => "",
            FieldKind::Real { unit, .. } | FieldKind::Exact { unit } => unit,
            FieldKind::Share => "%",
            FieldKind::Time => "UTC",
        }
    }

    /// Whether its cells stand to the right.
    pub fn is_number(&self) -> bool {
        !matches!(self.kind, FieldKind::Text | FieldKind::Time)
    }

    /// Its heading on a page: `Height, mm`.
    pub fn page_heading(&self) -> String {
        match self.unit() {
            "" => self.label.to_owned(),
            "UTC" => format!("{} (UTC)", self.label),
            unit => format!("{}, {unit}", self.label),
        }
    }

    /// Its heading in a terminal: `HEIGHT mm`.
    pub fn terminal_heading(&self) -> String {
        let label = self.label.to_uppercase();
        match self.unit() {
            "" => label,
            "UTC" => format!("{label} (UTC)"),
            unit => format!("{label} {unit}"),
        }
    }

    /// A value below its heading, without the unit; `None` when there is none.
    pub fn cell_text(&self, value: &CellValue) -> Option<String> {
        Some(match value {
            CellValue::Missing => return None,
            CellValue::Text(text) | CellValue::Prose(text) if text.is_empty() => return None,
            CellValue::Text(text) | CellValue::Prose(text) | CellValue::NamedPart(_, text) => text.clone(),
            CellValue::Whole(number) => number.to_string(),
            CellValue::Real(number) => self.real_text(*number),
            CellValue::Time(time) => time.strftime("%Y-%m-%d %H:%M:%S").to_string(),
            CellValue::Build(build) | CellValue::BuildWithPart(build, _) => build.to_string(),
            CellValue::Part(part) => part.to_string(),
        })
    }

    /// A value with its unit: `87.50 mm`; `None` when there is none.
    pub fn with_unit(&self, value: impl Into<CellValue>) -> Option<String> {
        let text = self.cell_text(&value.into())?;
        Some(match self.unit() {
            "" => text,
            unit => format!("{text} {unit}"),
        })
    }

    /// A line of a sheet with a value of this field; `None` when there is none.
    pub fn fact(&self, value: impl Into<CellValue>) -> Option<SheetFact> {
        Some(self.fact_of(self.with_unit(value)?))
    }

    /// A line of a sheet with a text of its own.
    pub fn fact_of(&self, text: String) -> SheetFact {
        SheetFact { label: self.label, text }
    }

    fn real_text(&self, number: f64) -> String {
        let (number, decimals) = match self.kind {
            FieldKind::Real { decimals, .. } => (number, decimals),
            FieldKind::Share => (100.0 * number, 1),
            _ => return number.to_string(),
        };
        let text = format!("{number:.decimals$}");
        // A value that rounds to zero has no sign.
        match text.strip_prefix('-') {
            Some(nothing) if nothing.bytes().all(|b| b == b'0' || b == b'.') => nothing.to_owned(),
            _ => text,
        }
    }
}
