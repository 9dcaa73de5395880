//! When an order is done, and whether that is late: a function of its lines and of the plans of the machines.

use ledger::{OrderSummary, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;

use crate::farm::planning::MachinePlan;

/// What is so of an order.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct OrderFact {
    /// When all of it can be unpacked if nothing more arrives, as far as is known, to the minute; `None` = that is not known, or nothing
    /// of it is under way.
    pub done_at: Option<UtcTimestamp>,
    /// Whether a due date of it is missed, or will be.
    pub is_late: bool,
    /// Whether a due date of it is at risk: it is late, or less time is left than such plans are wrong by.
    pub is_at_risk: bool,
    /// Why, as the end of a sentence; "" = it is kept, as far as is known.
    pub risk_reason: String,
}

/// An order, and what is so of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DatedOrder {
    /// Its row and its copies.
    #[serde(flatten)]
    pub order: OrderSummary,
    /// When it is done.
    #[serde(flatten)]
    pub fact: OrderFact,
}

/// What is so of an order, if the machines do as they plan.
pub fn order_fact(order: &OrderSummary, plans: &[MachinePlan]) -> OrderFact {
    let name = order.order.name.as_str();
    let (mut planned, mut done_at) = (0, None);
    for build in plans.iter().flat_map(|plan| &plan.builds) {
        let copies: u32 = build.parts.iter().filter(|part| part.order == name).map(|part| part.copies).sum();
        // Where it is not known when one of its builds is done, it is not known of the order.
        if copies > 0 && build.ends_at.is_some() {
            planned += copies;
            done_at = done_at.max(build.ends_at);
        }
    }
    let under_way = order.copies.waiting + order.copies.in_builds + order.copies.printed;
    let risks = plans.iter().flat_map(|plan| &plan.risks).filter(|risk| risk.order == name);
    let worst = risks.max_by_key(|risk| (risk.is_late, risk.done_at));
    OrderFact {
        done_at: done_at.filter(|_| under_way > 0 && planned >= under_way),
        is_late: worst.is_some_and(|risk| risk.is_late),
        is_at_risk: worst.is_some(),
        risk_reason: worst.map(|risk| risk.reason.clone()).unwrap_or_default(),
    }
}

impl DatedOrder {
    /// The orders with what is so of each.
    pub fn of_plans(orders: Vec<OrderSummary>, plans: &[MachinePlan]) -> Vec<Self> {
        orders.into_iter().map(|order| Self { fact: order_fact(&order, plans), order }).collect()
    }
}

impl OrderFact {
    /// `late` or `tight`; nothing where its dates are kept.
    pub fn risk_word(&self) -> Option<&'static str> {
        self.is_at_risk.then_some(if self.is_late { "late" } else { "tight" })
    }
}
