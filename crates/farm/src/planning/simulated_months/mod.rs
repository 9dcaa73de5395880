//! Months of a farm, played in simulated time with the pure functions of the plan: heights are estimates with noise, builds fail, copies
//! are bad, words come late. It tells how often quoted dates are kept, and compares rules for firing and printers.
//!
//! `cargo test --release --lib simulated_months -- --ignored --nocapture` plays 20 months; `NESTD_SEED` sets the seed.

mod month_machine;
mod month_orders;
mod month_play;
mod month_size;
mod month_table;

use std::io::Write;

use month_play::play_months;
use month_size::{MonthRules, MonthSize};
use month_table::TABLE_HEAD;

const SMALL: MonthSize =
    MonthSize { seed: 11, months: 2, orders: 60, printers: 2, lines: 6, volume: 1.0, wish_hours: (60.0, 192.0) };

#[test]
fn quoted_dates_are_kept_although_prints_fail_and_words_come_late() {
    let report = play_months(&SMALL, &MonthRules::HOUSE.with_quotes());
    assert_eq!(report.orders(), 120, "all orders are delivered");
    assert!(report.kept_share() >= 0.9, "{report:?}");
    let again = play_months(&SMALL, &MonthRules::HOUSE.with_quotes());
    assert_eq!(again, report, "one seed, one result");
}

/// The rules that are compared, each with and without what the plan knows of printers.
fn compared_rules() -> Vec<MonthRules> {
    let (simple, house) = (MonthRules::SIMPLE, MonthRules::HOUSE);
    let quoted = MonthRules { name: "the same, dates as quoted", ..house.with_quotes() };
    vec![
        simple,
        MonthRules { name: "simple, or a day old", max_wait_days: 1.0, ..simple },
        MonthRules { name: "plan's rule, parts wait a week at most", max_wait_days: 7.0, ..house },
        MonthRules { name: "the same, margin 24 h", max_wait_days: 7.0, margin_hours: Some(24.0), ..house },
        MonthRules {
            name: "the same, margin 24 h, fires for a free printer only",
            max_wait_days: 7.0,
            margin_hours: Some(24.0),
            awaits_printer: true,
            ..house
        },
        house,
        MonthRules { name: "the same, fires for a free printer only", awaits_printer: true, ..house },
        MonthRules { name: "the same, a hot folder per printer", is_split: true, ..house },
        quoted,
        MonthRules { name: "dates as quoted, parts wait a week at most", max_wait_days: 7.0, ..quoted },
    ]
}

#[test]
#[ignore = "takes minutes: 5,000 orders for each of the rules, three times"]
fn twenty_months_of_orders_for_each_of_the_rules() {
    let seed = std::env::var("NESTD_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(20_261_123);
    let half =
        MonthSize { seed, months: 20, orders: 250, printers: 4, lines: 12, volume: 1.0, wish_hours: (60.0, 192.0) };
    let sizes = [
        ("printers used for half of the time, dates after 60 to 192 h", half),
        ("parts of a quarter of that volume", MonthSize { volume: 0.25, ..half }),
        (
            "parts of a quarter of that volume, dates after 30 to 96 h",
            MonthSize { volume: 0.25, wish_hours: (30.0, 96.0), ..half },
        ),
    ];
    for (name, size) in sizes {
        writeln!(std::io::stdout(), "\nseed {seed}: {name}\n\n{TABLE_HEAD}").unwrap();
        for rules in compared_rules() {
            let report = play_months(&size, &rules);
            writeln!(std::io::stdout(), "{}", report.table_row(rules.name)).unwrap();
            assert!(!rules.has_quotes || report.kept_share() >= 0.95, "{}: {}", rules.name, report.kept_share());
        }
    }
}
