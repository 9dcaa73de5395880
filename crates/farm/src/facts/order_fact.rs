//! How an order stands: when all of it is done, whether that is late, and what becomes of its copies. It is a function of its lines, of the
//! plans of the machines, and of the time.

use jiff::{SignedDuration, Timestamp};
use language::say;
use ledger::{OrderState, OrderSummary, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;

use super::copy_fact::copy_counts;
use crate::planning::{MachinePlan, RiskCause};

/// How an order stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OrderWord {
    /// Its due date has passed, and not all of it is good.
    Overdue,
    /// A due date of it will be missed.
    Late,
    /// Less time is left than such plans are wrong by.
    Tight,
    /// Its due dates are kept, as far as is known.
    OnTime,
    /// It is under way: it has no due date, or nobody knows yet when it is done.
    UnderWay,
    /// Some of it was refused, or nothing of it is under way any more and not all is good: a person must say what becomes of it.
    Short,
    /// A person closed it as it was.
    Closed,
    /// All of it is good.
    Done,
}

/// What is so of an order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OrderFact {
    /// How it stands.
    #[serde(rename = "standing")]
    pub word: OrderWord,
    /// When all of it can be unpacked if nothing more arrives, as far as is known, to the minute; when it was over, where it is. `None` =
    /// that is not known.
    pub done_at: Option<UtcTimestamp>,
    /// Whether nobody told that all of it is done: `done_at` goes by the plan.
    pub is_estimated: bool,
    /// Whether a due date of it is missed, or will be.
    pub is_late: bool,
    /// Whether a due date of it is at risk: it is late, or less time is left than such plans are wrong by.
    pub is_at_risk: bool,
    /// The due date that is missed; `None` = none is.
    pub missed_at: Option<UtcTimestamp>,
    /// Why, as the end of a sentence; "" = it is kept, as far as is known.
    pub risk_reason: String,
    /// The cause of that.
    #[serde(skip)]
    pub risk_cause: Option<RiskCause>,
}

/// An order, and what is so of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DatedOrder {
    /// Its row and its copies.
    #[serde(flatten)]
    pub order: OrderSummary,
    /// How it stands.
    #[serde(flatten)]
    pub fact: OrderFact,
}

impl OrderWord {
    /// All of them.
    pub const ALL: [Self; 8] =
        [Self::Overdue, Self::Late, Self::Tight, Self::OnTime, Self::UnderWay, Self::Short, Self::Closed, Self::Done];

    /// The word for people.
    pub fn word(self) -> &'static str {
        match self {
            Self::Overdue => "overdue",
            Self::Late => "late",
            Self::Tight => "tight",
            Self::OnTime => "on time",
            Self::UnderWay => "under way",
            Self::Short => "short",
            Self::Closed => "closed",
            Self::Done => "done",
        }
    }

    /// That of an order; `risk` = whether a due date of it is at risk, and then whether it is missed. `is_end_known` = it is known when all
    /// of it is done.
    fn of_order(order: &OrderSummary, risk: Option<bool>, is_end_known: bool, now: Timestamp) -> Self {
        let is_closed = order.order.closing.closed_at.is_some();
        match (order.order.state, risk) {
            (OrderState::Short | OrderState::Complete, _) if is_closed => Self::Closed,
            (OrderState::Complete, _) => Self::Done,
            (OrderState::Short, _) => Self::Short,
            (OrderState::Open, _) if order.due_at.is_some_and(|due| due.0 <= now) => Self::Overdue,
            (OrderState::Open, Some(true)) => Self::Late,
            (OrderState::Open, _) if order.copies.refused > 0 => Self::Short,
            (OrderState::Open, Some(false)) => Self::Tight,
            (OrderState::Open, None) if order.due_at.is_some() && is_end_known => Self::OnTime,
            (OrderState::Open, None) => Self::UnderWay,
        }
    }
}

/// What is so of an order, if the machines do as they plan.
pub fn order_fact(order: &OrderSummary, plans: &[MachinePlan], now: Timestamp) -> OrderFact {
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
    let under_way = order.copies.under_way();
    let risks = plans.iter().flat_map(|plan| &plan.risks).filter(|risk| risk.order == name);
    let worst = risks.max_by_key(|risk| (risk.is_late, risk.done_at));
    let done_at = done_at.filter(|_| under_way > 0 && planned >= under_way);
    let word = OrderWord::of_order(order, worst.map(|risk| risk.is_late), done_at.is_some() || under_way == 0, now);
    let is_over = matches!(word, OrderWord::Done | OrderWord::Closed);
    let passed = order.due_at.filter(|_| word == OrderWord::Overdue);
    OrderFact {
        word,
        done_at: match is_over {
            true => Some(order.order.state_at),
            false => done_at,
        },
        is_estimated: !is_over,
        is_late: worst.is_some_and(|risk| risk.is_late) || passed.is_some(),
        is_at_risk: worst.is_some() || passed.is_some(),
        missed_at: passed.or(worst.filter(|risk| risk.is_late).map(|risk| risk.due_at)),
        risk_reason: worst.map(|risk| risk.reason.clone()).unwrap_or_default(),
        risk_cause: worst.map(|risk| risk.cause),
    }
}

impl DatedOrder {
    /// An order with what is so of it and of its copies.
    pub fn of_plans(order: OrderSummary, plans: &[MachinePlan], now: Timestamp) -> Self {
        let copies = copy_counts(&order.copies, plans, |part| part.order == order.order.name);
        let fact = order_fact(&order, plans, now);
        Self { order: OrderSummary { copies, ..order }, fact }
    }
}

impl OrderFact {
    /// By how much it is late, as far as is known when it is done.
    pub fn lateness(&self) -> Option<SignedDuration> {
        let (done_at, missed_at) = (self.done_at?.0, self.missed_at?.0);
        Some(done_at.duration_since(missed_at)).filter(|late| late.is_positive())
    }
}

/// A duration as people say it of a delay: `28 h`, `3 days`.
pub fn delay_text(late: SignedDuration) -> String {
    let hours = late.as_secs().div_euclid(3600);
    match hours {
        0 => say!("delay-min", minutes = late.as_secs().div_euclid(60).max(1)),
        1..=71 => say!("delay-hours", hours = hours),
        _ => say!("delay-days", days = hours / 24),
    }
}
