//! What builds cost is shared among the orders in them, once and for all.

use std::fs;

use ledger::{CommandKind, CostQuery, OperatorWord, PartId, PartState, PrintOutcome, ToldOutcome};

use super::printers::published;
use crate::{
    CostReport,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block},
};

const COSTS: &str =
    "print_hours_per_mm = 0.5\n[costs]\nper_hour = 20\nper_litre = 100\nper_part = 0.25\npowder_kg_per_litre = 0.5\n";

fn report(farm: &HandDrivenFarm, query: &CostQuery) -> CostReport {
    farm.ask(async |ledger| CostReport::read(ledger, query, farm.profiles()).await.unwrap())
}

/// A farm with one published build of two orders.
fn two_orders() -> HandDrivenFarm {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}{COSTS}"));
    for (order, copies, size) in [("brandt", 3, 20.0), ("kobe", 5, 10.0)] {
        let ticket = format!("order = \"{order}\"\ncustomer = \"{order} ltd\"\ncopies = {copies}\n");
        farm.drop_bytes(&format!("{order}.stl.toml"), ticket.as_bytes());
        farm.drop_part(&format!("{order}.stl"), &block(size, size, size));
    }
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 2);
    farm
}

#[test]
fn the_orders_of_a_build_bear_it_to_the_hundredth_and_the_farm_bears_what_is_bad() {
    let mut farm = two_orders();
    let build = published(&farm).remove(0);
    let all = report(&farm, &CostQuery::default());
    let hours = build.measures.height_mm.unwrap() * 0.5;
    let cost = 20.0 * hours + 100.0 * 0.029 + 0.25 * 8.0;
    assert_eq!(all.totals[0].price.0, (cost * 100.0).round() as i64, "{:?}", all.totals);
    let sum: i64 = all.orders.iter().map(|order| order.price.0).sum();
    assert_eq!(sum, all.totals[0].price.0);
    let [brandt, kobe] = &all.orders[..] else { panic!("{:?}", all.orders) };
    assert_eq!((brandt.customer.as_str(), brandt.copies, kobe.copies), ("brandt ltd", 3, 5));
    assert!((brandt.print_hours / kobe.print_hours - 24.0 / 5.0).abs() < 1e-9, "by volume");
    assert!(brandt.powder_kg.unwrap() > kobe.powder_kg.unwrap());

    // A copy of brandt's is bad: nobody but the farm bears it.
    fs::remove_file(farm.queued().remove(0)).unwrap();
    let told = ToldOutcome { bad: vec![(PartId(1), 1)], ..ToldOutcome::new(PrintOutcome::Complete, "", "ann@farm") };
    farm.say(&OperatorWord::Outcome(build.id, told), false).unwrap();
    let after = report(&farm, &CostQuery { build: Some(build.id), ..CostQuery::default() });
    assert_eq!(after.totals, all.totals);
    let bad = after.orders.last().unwrap();
    assert_eq!((bad.is_bad, bad.order_name.as_str(), bad.copies), (true, "brandt", 1));
    assert!(after.sums_of_order("brandt")[0].price < brandt.price);

    // New rates concern new builds.
    farm.write_profile(MACHINE, &format!("{QUICK}{}", COSTS.replace("per_hour = 20", "per_hour = 99")));
    farm.reload();
    assert_eq!(report(&farm, &CostQuery::default()), after);
    farm.order(CommandKind::Flush, None);
    farm.pass_until("the bad copy is printed again", |farm| farm.queued().len() == 1 && published(farm).len() == 1);
    let both = report(&farm, &CostQuery { order_name: Some("brandt".to_owned()), ..CostQuery::default() });
    assert_eq!(both.orders.iter().map(|order| order.builds).max(), Some(2));
    assert!(both.orders.iter().all(|line| line.order_name == "brandt"), "{both:?}");
    let kobe = report(&farm, &CostQuery { order_name: Some("kobe".to_owned()), ..CostQuery::default() });
    assert_eq!(
        kobe.shares,
        after.shares.iter().filter(|share| share.order_name == "kobe").cloned().collect::<Vec<_>>()
    );
    assert_eq!((kobe.orders.len(), kobe.totals[0].price), (1, kobe.orders[0].price), "no row of another order");
    let none = CostQuery { since: Some(jiff::Timestamp::MAX), ..CostQuery::default() };
    assert_eq!(report(&farm, &none), CostReport::default());
}

#[test]
fn a_build_that_was_taken_back_costs_nothing() {
    let mut farm = two_orders();
    let build = published(&farm).remove(0);
    farm.say(&OperatorWord::Withdraw(build.id, "a mistake".to_owned()), false).unwrap();
    farm.wait_for_parts(PartState::Waiting, 2);
    assert_eq!(report(&farm, &CostQuery::default()), CostReport::default());
}
