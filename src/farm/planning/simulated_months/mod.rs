//! Months of a farm, played in simulated time with the pure functions of the plan: heights are estimates with noise, builds fail, copies
//! are bad, words come late. It tells how often quoted dates are kept, and compares rules for firing and printers.
//!
//! `cargo test --release --lib simulated_months -- --ignored --nocapture` plays 20 months; `NESTD_SEED` sets the seed.

mod month_machine;
mod month_orders;
mod month_play;
mod month_table;

use std::io::Write;

use month_play::{MonthRules, MonthSize, play_months};
use month_table::compare_rules;

const SMALL: MonthSize = MonthSize { seed: 11, months: 2, orders: 60, printers: 2, lines: 6 };

#[test]
fn quoted_dates_are_kept_although_prints_fail_and_words_come_late() {
    let report = play_months(&SMALL, &MonthRules::HOUSE.with_quotes());
    assert_eq!(report.orders(), 120, "all orders are delivered");
    assert!(report.kept_share() >= 0.9, "{report:?}");
    let again = play_months(&SMALL, &MonthRules::HOUSE.with_quotes());
    assert_eq!(again, report, "one seed, one result");
}

#[test]
#[ignore = "takes minutes: 5,000 orders for each of the rules"]
fn twenty_months_of_orders_for_each_of_the_rules() {
    let seed = std::env::var("NESTD_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(20_261_123);
    let size = MonthSize { seed, months: 20, orders: 250, printers: 4, lines: 12 };
    let rules = [
        MonthRules::SIMPLE,
        MonthRules::HOUSE,
        MonthRules { name: "plan's rule, margin 24 h", margin_hours: Some(24.0), ..MonthRules::HOUSE },
        MonthRules { name: "plan's rule, fires for a free printer only", awaits_printer: true, ..MonthRules::HOUSE },
        MonthRules {
            name: "the same, margin 24 h",
            awaits_printer: true,
            margin_hours: Some(24.0),
            ..MonthRules::HOUSE
        },
        MonthRules { name: "plan's rule, a hot folder per printer", is_split: true, ..MonthRules::HOUSE },
        MonthRules { name: "plan's rule, dates as quoted", ..MonthRules::HOUSE.with_quotes() },
        MonthRules {
            name: "dates as quoted, fires for a free printer only",
            awaits_printer: true,
            ..MonthRules::HOUSE.with_quotes()
        },
    ];
    let reports: Vec<_> = rules.iter().map(|rules| (rules.name, play_months(&size, rules))).collect();
    writeln!(std::io::stdout(), "NESTD_SEED={seed}\n{}", compare_rules(&reports)).unwrap();
    for (name, report) in reports.iter().filter(|(name, _)| name.contains("quoted")) {
        assert!(report.kept_share() >= 0.95, "{name}: {}", report.kept_share());
    }
}
