//! Orders: what a customer wants, by name. The lines of an order are the parts that carry its name.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use super::order_line::{LineCopies, OrderLine};
use crate::{
    EventKind, Ledger, PartId, UtcTimestamp,
    base::{
        error::Result,
        name_pattern::NamePattern,
        sql::{self, sql_row},
        text_column::own_word,
    },
    store::change::LedgerChange,
};

/// State of an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OrderState {
    /// Copies wait, stand in builds, or were printed and nobody said how.
    Open,
    /// Every copy that is still wanted was told good.
    Complete,
    /// Nothing of it is under way any more, and a line of it was refused, or nothing of it is wanted any more.
    Short,
}

own_word!(OrderState);

impl OrderState {
    /// That of an order with these copies.
    pub fn of_copies(copies: &LineCopies) -> Self {
        match copies {
            _ if copies.under_way() > 0 => Self::Open,
            _ if copies.good > 0 && copies.refused == 0 => Self::Complete,
            _ => Self::Short,
        }
    }
}

/// An order with a name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OrderRow {
    /// Its name.
    pub name: String,
    /// For whom its parts are, "" = not said; several are joined by ", ".
    pub customer: String,
    /// Its state.
    pub state: OrderState,
    /// When its first part came.
    pub opened_at: UtcTimestamp,
    /// When it entered its state.
    pub state_at: UtcTimestamp,
    /// How a person closed it as it was.
    #[serde(flatten)]
    pub closing: OrderClosing,
}

sql_row!(OrderRow { name, customer, state, opened_at, state_at; closing });

/// How a person closed an order as it was. `None` = nobody did, or more of it is wanted since.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct OrderClosing {
    /// When.
    pub closed_at: Option<UtcTimestamp>,
    /// Who, as user@host.
    pub closed_by: Option<String>,
    /// Copies that were accepted: those that were good, printed or in builds.
    pub accepted_copies: Option<u32>,
    /// Of how many copies wanted.
    pub closed_of: Option<u32>,
}

sql_row!(OrderClosing { closed_at, closed_by, accepted_copies, closed_of });

impl OrderRow {
    /// An order of which no part has come yet.
    pub fn arriving(name: &str) -> Self {
        let now = UtcTimestamp(jiff::Timestamp::now());
        let closing = OrderClosing::default();
        Self {
            name: name.to_owned(),
            customer: String::new(),
            state: OrderState::Open,
            opened_at: now,
            state_at: now,
            closing,
        }
    }

    /// Whether nothing of it is under way, and it asks nobody: it is complete, or a person closed it.
    pub fn is_over(&self) -> bool {
        self.state == OrderState::Complete || self.state == OrderState::Short && self.closing.closed_at.is_some()
    }
}

/// An order with the sums over its lines.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OrderSummary {
    /// Its row.
    #[serde(flatten)]
    pub order: OrderRow,
    /// Number of its lines.
    pub lines: u32,
    /// Number of those of which it is not known how many copies are wanted.
    pub lines_without_number: u32,
    /// The earliest due date among the lines that are not good.
    pub due_at: Option<UtcTimestamp>,
    /// That date as it was given, "" = none.
    pub due_text: String,
    /// What became of its copies.
    #[serde(flatten)]
    pub copies: LineCopies,
}

impl OrderSummary {
    /// Sums up the lines of an order.
    pub fn of_lines(order: OrderRow, lines: &[OrderLine]) -> Self {
        let mut copies = LineCopies::default();
        lines.iter().for_each(|line| copies.add(&line.copies));
        let open = lines.iter().filter(|line| line.copies.good < line.copies.wanted);
        let first_due = open.filter(|line| line.due_at.is_some()).min_by_key(|line| line.due_at);
        let (due_at, due_text) = first_due.map(|line| (line.due_at, line.due_text.clone())).unwrap_or_default();
        let lines_without_number = lines.iter().filter(|line| !line.is_number_known).count() as u32;
        Self { order, lines: lines.len() as u32, lines_without_number, due_at, due_text, copies }
    }
}

/// Filter of the list of orders.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OrderQuery {
    /// Part of a name, in any case; `None` = any.
    pub name: Option<String>,
    /// Part of the name of a customer, in any case; `None` = any.
    pub customer: Option<String>,
    /// Only orders in this state.
    pub state: Option<OrderState>,
    /// Only orders that are not over: something of them is under way, or asks a person.
    pub is_asking: bool,
    /// Maximum number of orders.
    pub limit: u32,
}

/// The orders with those that are over last, and the earliest due date of each that is not. One that is over has none.
pub(crate) const ORDER_LIST: &str = "FROM (SELECT o.*, o.state = 'complete' OR o.state = 'short' AND o.closed_at IS NOT NULL AS is_over, \
    CASE WHEN o.state <> 'complete' THEN (SELECT min(v.due_at) FROM v_order_line v \
    WHERE v.order_name = o.name AND v.order_name <> '' AND v.good < v.wanted) END AS due_at FROM customer_order o \
    WHERE ($1 IS NULL OR instr(o.folded, $1) > 0) AND ($2 IS NULL OR o.state = $2) \
    AND ($3 IS NULL OR lower(o.customer) LIKE $3 ESCAPE '!')) AS listed WHERE NOT ($4 AND is_over) \
    ORDER BY is_over, due_at IS NULL, due_at, CASE WHEN is_over THEN state_at END DESC, opened_at DESC, name";

impl Ledger {
    /// Finds an order by its whole name.
    pub async fn find_order(&self, name: &str) -> Result<Option<OrderRow>> {
        let query = sql::select_as("FROM customer_order WHERE name = $1").bind(name);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Where the customers of an order get e-mail, each address once.
    pub async fn emails_of_order(&self, name: &str) -> Result<Vec<String>> {
        let query = sql::query_scalar(
            "SELECT DISTINCT email FROM part WHERE order_name = $1 AND order_name <> '' AND email <> '' ORDER BY email",
        );
        Ok(query.bind(name).fetch_all(self.reader()?).await?)
    }

    /// Lists the orders that match the query: by due date, those without one after that, and last those that are over.
    pub async fn list_orders(&self, query: &OrderQuery) -> Result<Vec<OrderRow>> {
        let rows = sql::select_as(ORDER_LIST);
        let folded = query.name.as_ref().map(|name| name.to_lowercase());
        let customer = query.customer.as_ref().map(|name| name.to_lowercase());
        let pattern = query.customer.as_ref().map(|name| NamePattern::containing(name).text().to_owned());
        let mut found: Vec<OrderRow> = Vec::new();
        let most = query.limit as usize;
        let take = |order: OrderRow| {
            if customer.as_ref().is_none_or(|customer| order.customer.to_lowercase().contains(customer)) {
                found.push(order);
            }
            found.len() < most
        };
        if most > 0 {
            rows.bind(folded)
                .bind(query.state)
                .bind(pattern)
                .bind(query.is_asking)
                .for_each_while(self.reader()?, take)
                .await?;
        }
        Ok(found)
    }
}

impl Ledger {
    /// Lists the orders that match the query with the sums over their lines, as [`Ledger::list_orders`] does.
    pub async fn order_summaries(&self, query: &OrderQuery) -> Result<Vec<OrderSummary>> {
        let mut summaries = Vec::new();
        for order in self.list_orders(query).await? {
            let lines = self.order_lines(&order.name).await?;
            summaries.push(OrderSummary::of_lines(order, &lines));
        }
        Ok(summaries)
    }
}

impl LedgerChange {
    /// Inserts the row of an order, unless it is there. A part without an order has none.
    pub async fn open_order(&mut self, name: &str) -> Result<()> {
        if name.is_empty() {
            return Ok(());
        }
        let now = self.now;
        sql::query(
            "INSERT INTO customer_order (name, folded, state, opened_at, state_at) VALUES ($1, $2, 'open', $3, $4) \
             ON CONFLICT (name) DO UPDATE SET state = 'open', state_at = excluded.state_at WHERE customer_order.state <> 'open'",
        )
        .bind(name)
        .bind(name.to_lowercase())
        .bind(now)
        .bind(now)
        .execute(self.db())
        .await?;
        self.forget_closing(name).await
    }

    /// Whether a person closed the order of a part: what is cancelled of it is not wanted any more.
    pub async fn is_order_closed(&mut self, part: PartId) -> Result<bool> {
        let closed = sql::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM part p JOIN customer_order o ON o.name = p.order_name WHERE p.id = $1 AND o.closed_at IS NOT NULL)",
        );
        Ok(closed.bind(part).fetch_one(self.db()).await?)
    }

    /// More is wanted of an order that a person closed.
    async fn forget_closing(&mut self, name: &str) -> Result<()> {
        let forget = "UPDATE customer_order SET closed_at = NULL, closed_by = NULL, accepted_copies = NULL, closed_of = NULL \
                      WHERE name = $1 AND closed_at IS NOT NULL";
        sql::query(forget).bind(name).execute(self.db()).await?;
        Ok(())
    }

    /// Removes the row of an order whose parts all went to other orders, and to which no program ordered anything: then `true`.
    async fn forget_empty_order(&mut self, name: &str) -> Result<bool> {
        let forget = sql::query(
            "DELETE FROM customer_order WHERE name = $1 AND NOT EXISTS (SELECT 1 FROM part WHERE order_name = $1 AND order_name <> '') \
             AND NOT EXISTS (SELECT 1 FROM ordered_line WHERE order_name = $1)",
        );
        Ok(forget.bind(name).execute(self.db()).await? > 0)
    }

    /// Writes for whom the lines of an order are.
    pub async fn update_customer(&mut self, name: &str) -> Result<()> {
        let query = sql::query_scalar(
            "SELECT DISTINCT customer FROM part WHERE order_name = $1 AND order_name <> '' AND customer <> '' ORDER BY customer",
        );
        let customers: Vec<String> = query.bind(name).fetch_all(self.db()).await?;
        let set = sql::query("UPDATE customer_order SET customer = $1 WHERE name = $2 AND customer <> $1");
        set.bind(customers.join(", ")).bind(name).execute(self.db()).await?;
        Ok(())
    }

    /// Sets the state of an order according to its lines, and writes an event when it becomes complete or short.
    pub async fn update_order(&mut self, name: &str) -> Result<()> {
        if name.is_empty() {
            return Ok(());
        }
        let lines = self.lines_of_order(name).await?;
        if lines.is_empty() && self.forget_empty_order(name).await? {
            return Ok(());
        }
        let mut sum = LineCopies::default();
        lines.iter().for_each(|line| sum.add(&line.copies));
        let (state, now) = (OrderState::of_copies(&sum), self.now);
        if sum.refused > 0 {
            self.forget_closing(name).await?;
        }
        let set = sql::query("UPDATE customer_order SET state = $1, state_at = $2 WHERE name = $3 AND state <> $1");
        if set.bind(state).bind(now).bind(name).execute(self.db()).await? == 0 {
            return Ok(());
        }
        let kind = match state {
            OrderState::Open => return Ok(()),
            OrderState::Complete => EventKind::OrderComplete,
            OrderState::Short => EventKind::OrderShort,
        };
        let detail = match state {
            OrderState::Short => format!(
                "order {name}: {} good of {} wanted, {} refused, {} cancelled",
                sum.good, sum.wanted, sum.refused, sum.cancelled
            ),
            _ => format!("order {name}: {} good of {} wanted", sum.good, sum.wanted),
        };
        let last = lines.last().map(|line| (line.part, line.machine.clone()));
        let (part, machine) = last.map_or((None, String::new()), |(part, machine)| (Some(part), machine));
        self.write_event(kind, &machine, part, None, &detail).await
    }

    /// Updates the orders of these parts.
    pub async fn update_orders_of(&mut self, parts: impl IntoIterator<Item = PartId>) -> Result<()> {
        let mut names = BTreeSet::new();
        for part in parts {
            names.insert(self.require_part(part).await?.terms.order_name);
        }
        for name in names {
            self.update_order(&name).await?;
        }
        Ok(())
    }
}
