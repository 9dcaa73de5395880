//! Tests that labels, units and keys agree with each other, and that each field of the JSON is a column.

use std::collections::BTreeSet;

use farm::DatedBuild;
use ledger::HistoryQuery;
use ledger_fixtures::*;
use settings::FarmZone;

use super::{
    columns::table_column::{ColumnAudience, TableColumn},
    *,
};

/// Key and field of the columns of a table that programs see.
fn program_fields<Row>(columns: &[TableColumn<Row>]) -> Vec<(&'static str, FieldDefinition)> {
    let both = columns.iter().filter(|column| column.audience != ColumnAudience::People);
    both.map(|column| (column.key, column.field)).collect()
}

#[test]
fn the_unit_of_a_label_is_the_one_that_its_key_ends_in() {
    let tables = [
        program_fields(HISTORY_COLUMNS),
        program_fields(HEIGHT_SUM_COLUMNS),
        program_fields(PART_COLUMNS),
        program_fields(PICK_COLUMNS),
        program_fields(ORDER_COLUMNS),
        program_fields(ORDER_LINE_COLUMNS),
        program_fields(ORDER_BUILD_COLUMNS),
        program_fields(MACHINE_COLUMNS),
        program_fields(NODE_COLUMNS),
        program_fields(PRINTER_COLUMNS),
        program_fields(PLAN_COLUMNS),
        program_fields(RISK_COLUMNS),
    ];
    for (key, field) in tables.into_iter().flatten() {
        let unit = match key {
            "density" | "mean_density" => "%",
            _ if key.ends_with("_mm") => "mm",
            _ if key.ends_with("_mm3") => "mm3",
            _ if key.ends_with("_secs") => "s",
            _ => "",
        };
        assert_eq!(field.unit(), unit, "{key}");
        let (terminal, page) = (field.terminal_heading(), field.page_heading());
        assert!(terminal.contains(unit) && page.contains(unit), "{terminal} | {page}");
        assert_eq!(page.split([',', '(']).next().unwrap().trim().to_uppercase(), field.label.to_uppercase());
        assert!(terminal.starts_with(&field.label.to_uppercase()), "{terminal}");
    }
}

#[test]
fn no_table_has_two_columns_of_one_label_or_one_key() {
    fn check_columns<Row>(columns: &[TableColumn<Row>]) {
        let labels: BTreeSet<String> = for_people(columns).map(|column| column.field.page_heading()).collect();
        assert_eq!(labels.len(), for_people(columns).count(), "{labels:?}");
        let keys: BTreeSet<&str> = columns.iter().map(|column| column.key).collect();
        assert_eq!(keys.len(), columns.len(), "{keys:?}");
    }
    check_columns(HISTORY_COLUMNS);
    check_columns(HEIGHT_SUM_COLUMNS);
    check_columns(PART_COLUMNS);
    check_columns(BUILD_PART_COLUMNS);
    check_columns(WAITING_PART_COLUMNS);
    check_columns(ORDERED_PART_COLUMNS);
    check_columns(COPY_GROUP_COLUMNS);
    check_columns(EVENT_COLUMNS);
    check_columns(OUTCOME_COLUMNS);
    check_columns(MACHINE_COLUMNS);
    check_columns(PRINTER_COLUMNS);
    check_columns(PLAN_COLUMNS);
    check_columns(RISK_COLUMNS);
    check_columns(PICK_COLUMNS);
    check_columns(CAKE_PART_COLUMNS);
    check_columns(ORDER_COLUMNS);
    check_columns(ORDER_LINE_COLUMNS);
    check_columns(ORDER_BUILD_COLUMNS);
}

#[tokio::test]
async fn each_field_of_the_history_in_json_is_a_column_with_the_same_value() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 2).await;
    published(&ledger, &[(id, 0), (id, 1)]).await;
    let query = HistoryQuery::default();
    let (rows, sums) = (ledger.read_history(&query).await.unwrap(), ledger.height_summaries(&query).await.unwrap());
    let rows = DatedBuild::of_rows(&ledger, [], rows, jiff::Timestamp::now()).await.unwrap();
    fn check_columns<Row: serde::Serialize>(columns: &[TableColumn<Row>], row: &Row) {
        let json = serde_json::to_value(row).unwrap();
        let columns = || columns.iter().filter(|column| column.audience != ColumnAudience::People);
        let fields: BTreeSet<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(columns().map(|column| column.key).collect::<BTreeSet<_>>(), fields);
        for column in columns() {
            assert_eq!(serde_json::to_value((column.value)(row)).unwrap(), json[column.key], "{}", column.key);
        }
    }
    check_columns::<DatedBuild>(HISTORY_COLUMNS, &rows[0]);
    check_columns(HEIGHT_SUM_COLUMNS, &sums[0]);
}

#[test]
fn what_rounds_to_nothing_has_no_sign_and_what_is_not_known_has_no_text() {
    let shown = |field: FieldDefinition, value: f64| field.plain_text(&value.into()).unwrap();
    assert_eq!((shown(fields::TOP, -1e-9), shown(fields::TOP, -0.06)), ("0.0".to_owned(), "-0.1".to_owned()));
    assert_eq!((shown(fields::CENTER_X, -0.2), shown(fields::DENSITY, 0.2149)), ("0".to_owned(), "21.5".to_owned()));
    assert_eq!(fields::HEIGHT.with_unit(87.5).unwrap(), "87.50 mm");
    assert_eq!(fields::LAYER_THICKNESS.with_unit(0.125).unwrap(), "0.125 mm");
    assert_eq!((fields::HEIGHT.with_unit(None::<f64>), fields::ORDER.fact("")), (None, None));
}

#[test]
fn texts_of_a_csv_are_no_formulas_and_numbers_stay_numbers() {
    const COLUMNS: &[TableColumn<(&str, f64)>] = &[
        TableColumn::new("name", fields::NAME, |row| row.0.into()),
        TableColumn::new("height_mm", fields::HEIGHT, |row| row.1.into()),
        TableColumn::for_people("shown", fields::NOTE, |row| row.0.into()),
    ];
    assert_eq!(csv_of(COLUMNS, &[("=1+1", -2.0), ("a,b", 0.1)]).unwrap(), "name,height_mm\n'=1+1,-2.0\n\"a,b\",0.1\n");
}

#[test]
fn times_are_shown_in_the_zone_of_the_farm_and_programs_get_the_instant() {
    let zone = FarmZone::from(jiff::tz::TimeZone::get("Europe/Berlin").unwrap());
    let at = |text: &str| ledger::UtcTimestamp(text.parse().unwrap());
    let (end, now) = (at("2026-12-24T22:59:59Z"), at("2026-12-24T19:54:59Z"));
    let view = TimeView::at(&zone, now.0);
    let cell =
        |due: &str, view: &TimeView| fields::DUE.cell_text(&GivenDate::new(Some(end), due).into(), view).unwrap();
    assert_eq!(cell("2026-12-24", &view), "2026-12-24, in 3h 5m");
    assert_eq!(cell("2026-12-24 23:59", &TimeView::kept(&zone)), "2026-12-24 23:59 CET");
    assert_eq!(fields::TIME.cell_text(&now.into(), &view).unwrap(), "2026-12-24 20:54:59 CET");
    let due: CellValue = GivenDate::new(Some(end), "2026-12-24").into();
    assert_eq!(serde_json::to_value(due).unwrap(), "2026-12-24T22:59:59.000Z");
    const COLUMNS: &[TableColumn<GivenDate>] = &[TableColumn::new("due_at", fields::DUE, |due| due.clone().into())];
    assert_eq!(
        csv_of(COLUMNS, &[GivenDate { due_at: end, text: String::new() }]).unwrap(),
        "due_at\n2026-12-24T22:59:59.000Z\n"
    );
}
