//! Orders: what a customer wants, by name. The lines of an order are the parts that carry its name. For every line,
//! copies wanted = waiting + in builds + printed + good, or, if the line was refused, + refused.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    EventKind, Ledger, LedgerError, PartId, PartState, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
        text_column::own_word,
    },
    rows::part_row::name_with_solid,
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

/// An order with a name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OrderRow {
    /// Its name.
    pub name: String,
    /// Its state.
    pub state: OrderState,
    /// When its first part came.
    pub opened_at: UtcTimestamp,
    /// When it entered its state.
    pub state_at: UtcTimestamp,
}

sql_row!(OrderRow { name, state, opened_at, state_at });

impl OrderRow {
    /// An order of which no part has come yet.
    pub fn arriving(name: &str) -> Self {
        let now = UtcTimestamp(jiff::Timestamp::now());
        Self { name: name.to_owned(), state: OrderState::Open, opened_at: now, state_at: now }
    }
}

/// A line of an order: a part and what became of its copies.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OrderLine {
    /// Number of the part.
    pub part: PartId,
    /// Machine.
    pub machine: String,
    /// File name as dropped.
    pub name: String,
    /// Name of the solid inside a 3MF, "" otherwise.
    pub object_name: String,
    /// State of the part.
    pub state: PartState,
    /// When it is due.
    pub due_at: Option<UtcTimestamp>,
    /// The due date as it was given, "" = none.
    pub due_text: String,
    /// What became of its copies.
    #[serde(flatten)]
    pub copies: LineCopies,
}

sql_row!(OrderLine { part, machine, name, object_name, state, due_at, due_text; copies });

/// The copies of a line, each counted once in `wanted` = `waiting` + `in_builds` + `printed` + `good` + `refused`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct LineCopies {
    /// Copies wanted.
    pub wanted: u32,
    /// Copies that wait for a build.
    pub waiting: u32,
    /// Copies in builds that are being made.
    pub in_builds: u32,
    /// Copies in published builds of which nobody said that the print was good.
    pub printed: u32,
    /// Copies in builds that were told complete.
    pub good: u32,
    /// Copies that are wanted and not made, because the part was refused or cancelled.
    pub refused: u32,
    /// Copies that were printed badly, each as often as that happened. They are not part of the sum.
    pub bad: u32,
    /// Copies that are not wanted any more. They are not part of the sum.
    pub cancelled: u32,
}

sql_row!(LineCopies { wanted, waiting, in_builds, printed, good, refused, bad, cancelled });

impl OrderLine {
    /// Name of the part together with the name of its solid.
    pub fn full_name(&self) -> String {
        name_with_solid(&self.name, &self.object_name)
    }
}

impl LineCopies {
    /// Adds the copies of another line.
    pub fn add(&mut self, other: &Self) {
        self.wanted += other.wanted;
        self.waiting += other.waiting;
        self.in_builds += other.in_builds;
        self.printed += other.printed;
        self.good += other.good;
        self.refused += other.refused;
        self.bad += other.bad;
        self.cancelled += other.cancelled;
    }

    /// The state of an order with these copies.
    pub fn order_state(&self) -> OrderState {
        match self {
            _ if self.waiting + self.in_builds + self.printed > 0 => OrderState::Open,
            _ if self.good > 0 && self.refused == 0 => OrderState::Complete,
            _ => OrderState::Short,
        }
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
        Self { order, lines: lines.len() as u32, due_at, due_text, copies }
    }
}

/// Filter of the list of orders.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OrderQuery {
    /// Part of a name, in any case; `None` = any.
    pub name: Option<String>,
    /// Only orders in this state.
    pub state: Option<OrderState>,
    /// Maximum number of orders.
    pub limit: u32,
}

impl Ledger {
    /// The lines of an order, oldest first.
    pub async fn order_lines(&self, name: &str) -> Result<Vec<OrderLine>> {
        let query = sql::select_as("FROM v_order_line WHERE order_name = $1 AND order_name <> '' ORDER BY part");
        Ok(query.bind(name).fetch_all(self.reader()?).await?)
    }

    /// The line of a part.
    pub async fn line_of_part(&self, part: PartId) -> Result<OrderLine> {
        let query = sql::select_as("FROM v_order_line WHERE part = $1").bind(part);
        query.fetch_optional(self.reader()?).await?.ok_or(LedgerError::UnknownPart(part))
    }

    /// Finds an order by its whole name.
    pub async fn find_order(&self, name: &str) -> Result<Option<OrderRow>> {
        let query = sql::select_as("FROM customer_order WHERE name = $1").bind(name);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Lists the orders that match the query, open ones first, newest first.
    pub async fn list_orders(&self, query: &OrderQuery) -> Result<Vec<OrderRow>> {
        let rows = sql::select_as(
            "FROM customer_order WHERE ($1 IS NULL OR instr(folded, $1) > 0) AND ($2 IS NULL OR state = $2) \
             ORDER BY state <> 'open', opened_at DESC, name LIMIT $3",
        );
        let folded = query.name.as_ref().map(|name| name.to_lowercase());
        Ok(rows.bind(folded).bind(query.state).bind(query.limit).fetch_all(self.reader()?).await?)
    }
}

impl Ledger {
    /// Lists the orders that match the query with the sums over their lines, open ones first, newest first.
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
        Ok(())
    }

    /// Sets the state of an order according to its lines, and writes an event when it becomes complete or short.
    pub async fn update_order(&mut self, name: &str) -> Result<()> {
        if name.is_empty() {
            return Ok(());
        }
        let lines: Vec<OrderLine> =
            sql::select_as("FROM v_order_line WHERE order_name = $1 AND order_name <> '' ORDER BY part")
                .bind(name)
                .fetch_all(self.db())
                .await?;
        let mut sum = LineCopies::default();
        lines.iter().for_each(|line| sum.add(&line.copies));
        let (state, now) = (sum.order_state(), self.now);
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
        let mut names = std::collections::BTreeSet::new();
        for part in parts {
            names.insert(self.require_part(part).await?.terms.order_name);
        }
        for name in names {
            self.update_order(&name).await?;
        }
        Ok(())
    }
}
