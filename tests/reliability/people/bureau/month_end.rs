//! What must hold at the end of a bureau's month.

use std::collections::BTreeMap;

use farm::InvariantExpectations;
use ledger::{OrderQuery, OrderState, OrderSummary};
use serde_json::Value;

use super::{Bureau, OrderFate, PER_LITRE, PER_PART};
use crate::harness::{DOUBLED, LOST};

/// A build that a printer took.
pub struct PrintedBuild {
    pub number: i64,
    /// What was loaded in its machine.
    pub material: &'static str,
    /// BLAKE3 of the part of each copy.
    pub hashes: Vec<String>,
}

impl Bureau {
    fn order_summaries(&self) -> Vec<OrderSummary> {
        let all = OrderQuery { limit: 10_000, ..OrderQuery::default() };
        self.farm.query_ledger(async |ledger| ledger.order_summaries(&all).await.unwrap())
    }

    /// The orders that have not ended. One of which nothing is wanted any more is closed by a person.
    pub(super) fn open_orders(&self) -> Vec<String> {
        let summaries = self.order_summaries();
        let mut open = Vec::new();
        for order in &self.orders {
            let Some(found) = summaries.iter().find(|found| found.order.name == order.name) else {
                open.push(format!("{} is not known, and", order.name));
                continue;
            };
            match (found.order.state, found.order.closing.closed_at) {
                (OrderState::Complete, _) | (OrderState::Short, Some(_)) => {}
                (OrderState::Short, None) if order.fate == OrderFate::Cancelled => {
                    self.farm.nestd_ok(&["close", &order.name]);
                }
                (state, _) => open.push(format!("{} ({state})", order.name)),
            }
        }
        open
    }

    /// Holds the builds against the orders.
    pub(super) fn compare(&mut self) {
        let mut broken = Vec::new();
        let count = |hash: &str, all: &mut dyn Iterator<Item = &String>| all.filter(|h| *h == hash).count() as u32;
        for order in &self.orders {
            for line in &order.lines {
                let printed = count(&line.hash, &mut self.taken.iter().flat_map(|build| &build.hashes));
                let good = printed - count(&line.hash, &mut self.bad.iter());
                let may_be_less = matches!(order.fate, OrderFate::Cancelled | OrderFate::Closed);
                if good > line.copies || good < line.copies && !may_be_less {
                    let what = if good > line.copies { DOUBLED } else { LOST };
                    broken.push(format!(
                        "{what}: {} of {} ({:?}): {good} good copies of {}",
                        line.file, order.name, order.fate, line.copies
                    ));
                }
                let wrong = self.taken.iter().find(|build| {
                    order.names_material && build.material != order.material && build.hashes.contains(&line.hash)
                });
                if let Some(build) = wrong {
                    broken.push(format!(
                        "{} of {} is for {}, and build {} is of {}",
                        line.file, order.name, order.material, build.number, build.material
                    ));
                }
            }
        }
        let summaries = self.order_summaries();
        for order in self.orders.iter().filter(|order| order.names_material) {
            let customer = summaries.iter().find(|found| found.order.name == order.name).map(|o| &o.order.customer);
            if customer != Some(&order.customer) {
                broken.push(format!("{} is of {}, and the farm says {customer:?}", order.name, order.customer));
            }
        }
        broken.extend(self.compare_costs());
        broken.extend(self.farm.broken_invariants(&InvariantExpectations::default()));
        self.broken.extend(broken);
    }

    /// What each build costs, by the prices of a copy and of a litre, against the shares of the orders.
    fn compare_costs(&self) -> Vec<String> {
        let mut broken = Vec::new();
        let report: Value = serde_json::from_str(&self.farm.nestd_ok(&["costs", "--json"])).unwrap();
        let cents = |value: &Value| (value.as_f64().unwrap() * 100.0).round() as i64;
        let sum = |rows: &Value| rows.as_array().unwrap().iter().map(|row| cents(&row["price"])).sum::<i64>();
        let sums = [sum(&report["totals"]), sum(&report["orders"]), sum(&report["shares"])];
        if sums.iter().any(|cents| *cents != sums[0]) {
            broken.push(format!("all builds, all orders and all shares cost {sums:?} cents"));
        }
        let litres: BTreeMap<&str, f64> =
            self.orders.iter().flat_map(|order| &order.lines).map(|line| (line.hash.as_str(), line.litres)).collect();
        let shares = report["shares"].as_array().unwrap();
        for build in &self.taken {
            let own = shares.iter().filter(|share| share["build"] == build.number);
            let told: i64 = own.map(|share| cents(&share["price"])).sum();
            let price: f64 = build.hashes.iter().map(|hash| PER_PART + PER_LITRE * litres[hash.as_str()]).sum();
            // A corner in single precision moves a volume a little.
            if (told as f64 - price * 100.0).abs() > 0.51 {
                broken.push(format!("build {} costs {price:.4}, and its shares are {told} cents", build.number));
            }
        }
        broken
    }
}
