//! Rows of records as JSON, in the words of this schema: before schema 40, a machine was called by its profile, and a part that was
//! refused, rejected.

use serde_json::{Map, Value};

use crate::{LedgerError, PartState, base::error::Result};

/// A row as JSON: values by column name.
pub(super) type JsonRow = Map<String, Value>;

/// A row with the words of this schema.
pub(super) fn with_words_of_now(mut row: JsonRow) -> JsonRow {
    if let Some(machine) = row.remove("profile") {
        row.insert("machine".to_owned(), machine);
    }
    if row.get("state").is_some_and(|state| state == "rejected") {
        row.insert("state".to_owned(), PartState::Refused.to_string().into());
    }
    row
}

/// Columns of a part that say what was asked for, and what was read of it.
const ASKED_AND_READ: [&str; 27] = [
    "machine",
    "order_name",
    "customer",
    "email",
    "material",
    "material_key",
    "finish",
    "reference",
    "priority",
    "due_at",
    "due_text",
    "orientation",
    "tilts",
    "clearance_mm",
    "unit",
    "read_unit",
    "note",
    "file_copies",
    "triangles",
    "volume_mm3",
    "size_x_mm",
    "size_y_mm",
    "size_z_mm",
    "object_name",
    "mend_allowed_by",
    "mended",
    "mended_hash",
];

/// What the row of a part says of what was asked for and read.
pub(super) fn asked_and_read(part: &JsonRow) -> JsonRow {
    let said = |(column, _): &(&String, &Value)| ASKED_AND_READ.contains(&column.as_str());
    part.iter().filter(said).map(|(column, value)| (column.clone(), value.clone())).collect()
}

/// A record that cannot be taken in.
pub(super) fn invalid_record(why: &str) -> LedgerError {
    LedgerError::InvalidRecord(why.to_owned())
}

/// The text of a record.
pub(super) fn parse_json(text: &str) -> Result<Value> {
    serde_json::from_str(text).map_err(|error| invalid_record(&error.to_string()))
}

/// The number in a column.
pub(super) fn number_column(row: &JsonRow, column: &str) -> Result<i64> {
    row.get(column).and_then(Value::as_i64).ok_or_else(|| invalid_record(&format!("a row has no {column}")))
}

/// The text in a column; "" = there is none.
pub(super) fn text_column<'a>(row: &'a JsonRow, column: &str) -> &'a str {
    row.get(column).and_then(Value::as_str).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use crate::{ImportOutcome, PartState, fixtures::*};

    #[tokio::test]
    async fn a_record_of_an_earlier_version_is_imported_for_its_machine_with_its_refused_part() {
        let ledger = fresh().await;
        let part = waiting(&ledger, "a", 2).await;
        let build = published(&ledger, &[(part, 0)]).await;
        let record = ledger.export_build_record(build).await.unwrap();
        let earlier = record.replace("\"machine\":", "\"profile\":").replace("\"waiting\"", "\"rejected\"");
        let earlier = earlier.replace("\"reason\":\"\"", "\"reason\":\"it is torn\"");
        assert!(earlier.matches("\"profile\":").count() == 2 && earlier.contains("\"rejected\""), "{earlier}");
        let restored = fresh().await;
        let ImportOutcome::Imported(build, doubts) = restored.import_build_record(&earlier, true).await.unwrap() else {
            panic!("it was known");
        };
        assert_eq!((restored.find_build(build).await.unwrap().unwrap().machine, doubts), ("paper-200".into(), vec![]));
        let part = restored.find_part(part).await.unwrap().unwrap();
        assert_eq!((part.machine.as_str(), part.state), ("paper-200", PartState::Refused));
    }
}
