//! Words of rows that an earlier version wrote into files: before schema 40, a machine was called by its profile, and a part that was
//! refused, rejected.

use serde_json::{Map, Value};

use crate::PartState;

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
