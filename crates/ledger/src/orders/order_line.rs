//! The lines of orders. For every line, copies wanted = waiting + in builds + queued + printing + printed + good, or, if the line was
//! refused, + refused.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    Ledger, LedgerError, PartId, PartState, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    rows::part_row::name_with_solid,
    store::change::LedgerChange,
};

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
    /// Who it is for, "" = not said.
    pub customer: String,
    /// Finishing steps after the print, "" = none.
    pub finish: String,
    /// State of the part.
    pub state: PartState,
    /// When it is due.
    pub due_at: Option<UtcTimestamp>,
    /// The due date as it was given, "" = none.
    pub due_text: String,
    /// Whether it is known how many copies are wanted; otherwise they are taken as 1.
    pub is_number_known: bool,
    /// What became of its copies.
    #[serde(flatten)]
    pub copies: LineCopies,
}

sql_row!(OrderLine { part, machine, name, object_name, customer, finish, state, due_at, due_text, is_number_known; copies });

/// The copies of a line, each counted once in `wanted` = `waiting` + `in_builds` + `queued` + `printing` + `printed` + `good` + `refused`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct LineCopies {
    /// Copies wanted.
    pub wanted: u32,
    /// Copies that wait for a build.
    pub waiting: u32,
    /// Copies in builds that are being made.
    pub in_builds: u32,
    /// Copies in builds whose file lies in a queue, as far as is known.
    pub queued: u32,
    /// Copies in builds that are printed, as far as is known.
    pub printing: u32,
    /// Copies in builds whose print is over, and of which nobody said that they are good.
    pub printed: u32,
    /// Copies in builds that were told complete.
    pub good: u32,
    /// Copies that are wanted and not made, because the part was refused.
    pub refused: u32,
    /// Copies that were printed badly, each as often as that happened. They are not part of the sum.
    pub bad: u32,
    /// Copies that are not wanted any more. They are not part of the sum.
    pub cancelled: u32,
}

sql_row!(LineCopies { wanted, waiting, in_builds, queued, printing, printed, good, refused, bad, cancelled });

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
        self.queued += other.queued;
        self.printing += other.printing;
        self.printed += other.printed;
        self.good += other.good;
        self.refused += other.refused;
        self.bad += other.bad;
        self.cancelled += other.cancelled;
    }

    /// Copies in published builds of which nobody said that they are good.
    pub fn published(&self) -> u32 {
        self.queued + self.printing + self.printed
    }

    /// Copies that wait, are in builds, or were printed and nobody said how.
    pub fn under_way(&self) -> u32 {
        self.waiting + self.in_builds + self.published()
    }
}

/// The lines of an order. Whether their numbers of copies are known is as [`PartRow::is_number_known`](crate::PartRow::is_number_known) says.
pub(crate) const ORDER_LINES: &str = "FROM (SELECT v.*, p.finish, NOT (p.state IN ('waiting', 'batched') \
    AND p.copies - p.cancelled_copies = 1 AND instr(p.warnings, 'How many copies?') > 0 \
    OR p.state = 'refused' AND coalesce(p.refusal, '') = 'ticket') AS is_number_known \
    FROM v_order_line v JOIN part p ON p.id = v.part) AS line WHERE order_name = $1 AND order_name <> '' ORDER BY part";
/// The line of a part.
pub(crate) const LINE_OF_PART: &str = "FROM (SELECT v.*, p.finish, NOT (p.state IN ('waiting', 'batched') \
    AND p.copies - p.cancelled_copies = 1 AND instr(p.warnings, 'How many copies?') > 0 \
    OR p.state = 'refused' AND coalesce(p.refusal, '') = 'ticket') AS is_number_known \
    FROM v_order_line v JOIN part p ON p.id = v.part) AS line WHERE part = $1";

impl Ledger {
    /// The lines of an order, oldest first.
    pub async fn order_lines(&self, name: &str) -> Result<Vec<OrderLine>> {
        let query = sql::select_as(ORDER_LINES);
        Ok(query.bind(name).fetch_all(self.reader()?).await?)
    }

    /// The line of a part.
    pub async fn line_of_part(&self, part: PartId) -> Result<OrderLine> {
        let query = sql::select_as(LINE_OF_PART).bind(part);
        query.fetch_optional(self.reader()?).await?.ok_or(LedgerError::UnknownPart(part))
    }
}

impl LedgerChange {
    /// The lines of an order, oldest first.
    pub async fn lines_of_order(&mut self, name: &str) -> Result<Vec<OrderLine>> {
        let query = sql::select_as(ORDER_LINES);
        Ok(query.bind(name).fetch_all(self.db()).await?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_of_an_order_know_the_words_by_which_a_number_is_asked_for() {
        assert!([ORDER_LINES, LINE_OF_PART].iter().all(|query| query.contains(build_file::COPIES_QUESTION)));
    }
}
