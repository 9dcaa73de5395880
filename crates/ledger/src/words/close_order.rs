//! A person closes an order as it is: what is good, printed or in builds is accepted. What was refused asks nobody any more, and what still
//! waits is cancelled by the daemon, which gives the files back.

use build_file::format_count;

use crate::{
    CloseOrderError, CommandArgument, CommandKind, EventKind, Ledger, LineCopies, NewCommand, OrderLine, OrderState,
    PartState,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

impl Ledger {
    /// Closes an order as it is. Returns what was done, in sentences for people.
    pub(super) async fn close_order(&self, name: &str, by: &str) -> Result<Vec<String>> {
        let mut change = self.begin_change().await?;
        let lines = change.lines_of_order(name).await?;
        ensure_all_read(&mut change, name).await?;
        let Some(last) = lines.last() else { return Err(CloseOrderError::Unknown(name.to_owned()).into()) };
        let mut sum = LineCopies::default();
        lines.iter().for_each(|line| sum.add(&line.copies));
        let is_short = OrderState::of_copies(&sum) == OrderState::Short && !change.is_order_closed(last.part).await?;
        if sum.waiting + sum.refused == 0 && !is_short {
            return Err(CloseOrderError::NothingToClose(name.to_owned()).into());
        }
        let accepted = sum.good + sum.in_builds + sum.published();
        let (of, now) = (sum.wanted + sum.cancelled, change.now);
        let close = sql::query(
            "UPDATE customer_order SET closed_at = $1, closed_by = $2, accepted_copies = $3, closed_of = $4 WHERE name = $5",
        );
        let close = close.bind(now).bind(by).bind(accepted).bind(of).bind(name);
        close.execute(change.db()).await?;
        let closed = format!("closed with {accepted} of {}", format_count(of, "copy", "copies"));
        let detail = format!("{by}: order {name} {closed}");
        // First of all: the newest event of a part says how many copies of it are not wanted any more.
        change.write_event(EventKind::OrderClosed, &last.machine, Some(last.part), None, &detail).await?;
        for line in &lines {
            close_line(&mut change, line, by).await?;
        }
        change.update_order(name).await?;
        change.commit().await?;
        let (waiting, refused) = (sum.waiting, sum.refused);
        let in_builds = sum.in_builds + sum.published();
        let told = [
            (waiting, format!("{} cancelled.", copies_are(waiting, "that waits is", "that wait are"))),
            (
                refused,
                format!(
                    "{} asked for any more.",
                    copies_are(refused, "that was refused is not", "that were refused are not")
                ),
            ),
            (
                in_builds,
                format!(
                    "{} in a build: the order is over when its print is told.",
                    copies_are(in_builds, "is still", "are still")
                ),
            ),
        ];
        let told = told.into_iter().filter(|(copies, _)| *copies > 0).map(|(_, sentence)| sentence);
        Ok(std::iter::once(format!("Order {name} is {closed}.")).chain(told).collect())
    }
}

/// `3 copies that wait are`.
fn copies_are(copies: u32, one: &str, several: &str) -> String {
    format!("{} {}", format_count(copies, "copy", "copies"), if copies == 1 { one } else { several })
}

/// A line that arrives, and a file that is read, may become several parts, which nobody has seen yet.
async fn ensure_all_read(change: &mut LedgerChange, name: &str) -> Result<()> {
    let reads: bool = sql::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM part WHERE order_name = $1 AND order_name <> '' AND state = 'claimed' AND triangles IS NULL) \
         OR EXISTS (SELECT 1 FROM ordered_line WHERE order_name = $1 AND taken_at IS NULL)",
    )
    .bind(name)
    .fetch_one(change.db())
    .await?;
    if reads { Err(CloseOrderError::BeingRead(name.to_owned()).into()) } else { Ok(()) }
}

/// Ends what a line asks for.
async fn close_line(change: &mut LedgerChange, line: &OrderLine, by: &str) -> Result<()> {
    let LineCopies { wanted, waiting, refused, .. } = line.copies;
    if refused > 0 {
        change.change_cancelled(line.part, i64::from(refused)).await?;
        let detail = format!("{by}: its order was closed without it");
        change.write_event(EventKind::OrderClosed, &line.machine, Some(line.part), None, &detail).await?;
        change.note_wanted_change(-i64::from(refused)).await?;
        change.count_decision(line.part).await?;
    }
    if waiting > 0 && matches!(line.state, PartState::Waiting | PartState::Claimed) {
        let copies = (waiting < wanted).then_some(waiting);
        let cancel = NewCommand {
            kind: CommandKind::Cancel,
            machine: String::new(),
            part: Some(line.part),
            argument: CommandArgument { copies, edit: None, ..CommandArgument::default() },
            asked_by: by.to_owned(),
        };
        change.insert_command(&cancel).await?;
    }
    Ok(())
}
