//! Orders that come by request, each under a key of its client: recorded once, whatever is sent again. The farm makes a claim of each
//! line, and goes on making it until there is a part of that claim.

use build_file::LengthUnit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    AnsweredRequest, Ledger, RefusalCause, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    store::change::LedgerChange,
};

/// A line of an order that came by request.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct OrderedLine {
    /// Its claim: one for ever, made of the client, its key and the request.
    pub claim: String,
    /// Who ordered it.
    pub client: String,
    /// Machine. Notes of orders call it `profile` where an earlier version wrote them.
    #[serde(alias = "profile")]
    pub machine: String,
    /// The order that it belongs to.
    pub order_name: String,
    /// File name.
    pub name: String,
    /// BLAKE3 of its file, 64 hex digits.
    pub content_hash: String,
    /// Copies ordered.
    pub copies: u32,
    /// What was asked with it, as a ticket in JSON.
    pub ticket: String,
    /// Unit of a file that states none: its machine's when the line was judged.
    #[serde(default)]
    #[schemars(with = "Option<String>")]
    pub read_unit: Option<LengthUnit>,
}

sql_row!(OrderedLine { claim, client, machine, order_name, name, content_hash, copies, ticket, read_unit });

/// An order as it is to be recorded.
#[derive(Debug, Clone)]
pub struct NewOrderRequest {
    /// Who sent it.
    pub client: String,
    /// The key that its client gave it.
    pub key: String,
    /// What was asked, and what is answered.
    pub answered: AnsweredRequest,
    /// Its lines.
    pub lines: Vec<OrderedLine>,
}

/// Result of recording an order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordedRequest {
    /// It is recorded now.
    New,
    /// It is recorded now, and was carried out before: its lines are there. Its key was forgotten, or the ledger was put back to an earlier
    /// time.
    NewAgain,
    /// A request with this key was carried out before.
    Known(AnsweredRequest),
}

/// A line whose part is being recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TakenLine {
    /// Who ordered it.
    pub client: String,
    /// Whether it was cancelled before: its claim was made at the same time.
    pub is_cancelled: bool,
}

sql_row!(TakenLine { client, is_cancelled });

/// The lines of which no part was recorded. One that was cancelled before counts as taken, and has no part.
const ARRIVING: &str =
    "FROM ordered_line l WHERE taken_at IS NULL AND NOT EXISTS (SELECT 1 FROM part p WHERE p.claim = l.claim)";

impl Ledger {
    /// Records an order and its key in one change, unless its key was used before. A line whose part is there, because the ledger was put
    /// back to a time before the order came, counts as taken.
    pub async fn record_order_request(&self, order: &NewOrderRequest) -> Result<RecordedRequest> {
        let mut change = self.begin_change().await?;
        if let Some(known) = change.find_request_key(&order.client, &order.key).await? {
            return Ok(RecordedRequest::Known(known));
        }
        change.write_request_key(&order.client, &order.key, &order.answered).await?;
        let mut is_known = false;
        for line in &order.lines {
            is_known |= !insert_line(&mut change, line).await?;
        }
        change.commit().await?;
        Ok(if is_known { RecordedRequest::NewAgain } else { RecordedRequest::New })
    }

    /// The lines for a machine of which the ledger has no part, oldest first, at most `most`.
    pub async fn arriving_lines(&self, machine: &str, most: u32) -> Result<Vec<OrderedLine>> {
        let query = sql::select_as(&format!("{ARRIVING} AND machine = $1 ORDER BY ordered_at, claim LIMIT $2"));
        Ok(query.bind(machine).bind(most).fetch_all(self.reader()?).await?)
    }

    /// The claim of the newest line for a machine of which the ledger has no part.
    pub async fn newest_arriving_line(&self, machine: &str) -> Result<Option<String>> {
        let newest = sql::query_scalar(
            "SELECT claim FROM ordered_line WHERE taken_at IS NULL AND machine = $1 ORDER BY ordered_at DESC, claim DESC LIMIT 1",
        );
        Ok(newest.bind(machine).fetch_optional(self.reader()?).await?)
    }

    /// The lines of an order of which the ledger has no part.
    pub async fn arriving_lines_of_order(&self, order_name: &str) -> Result<Vec<OrderedLine>> {
        let query = sql::select_as(&format!("{ARRIVING} AND order_name = $1 ORDER BY ordered_at, claim"));
        Ok(query.bind(order_name).fetch_all(self.reader()?).await?)
    }

    /// The lines of a request of which the ledger has no part. The ids of their claims begin with that of the request.
    pub async fn arriving_lines_of_request(&self, request_id: &str) -> Result<Vec<OrderedLine>> {
        let query = sql::select_as(&format!("{ARRIVING} AND claim >= $1 || '-' AND claim < $1 || '.' ORDER BY claim"));
        Ok(query.bind(request_id).fetch_all(self.reader()?).await?)
    }

    /// Those of these claims of lines of which the ledger has neither the line nor a part.
    pub async fn unknown_ordered_lines(&self, claims: &[String]) -> Result<Vec<String>> {
        let unknown = self.unknown_claims(claims).await?;
        self.find_unknown("ordered_line WHERE claim = value", &unknown).await
    }

    /// How many lines arrive for each machine for which any do.
    pub async fn count_arriving_lines(&self) -> Result<Vec<(String, u32)>> {
        let query = format!("SELECT machine, count(*) {ARRIVING} GROUP BY machine ORDER BY machine");
        Ok(sql::query_as(sqlx::AssertSqlSafe(query)).fetch_all(self.reader()?).await?)
    }

    /// Whether a line of an order was cancelled before it was a part; `None` = there is no such line, or it was forgotten.
    pub async fn is_cancelled_line(&self, order_name: &str, claim: &str) -> Result<Option<bool>> {
        let query = sql::query_scalar(
            "SELECT taken_at IS NOT NULL AND NOT EXISTS (SELECT 1 FROM part p WHERE p.claim = l.claim) \
             FROM ordered_line l WHERE order_name = $1 AND claim = $2",
        );
        Ok(query.bind(order_name).bind(claim).fetch_optional(self.reader()?).await?)
    }

    /// Whether lines of an order were cancelled before they were parts.
    pub async fn has_cancelled_lines(&self, order_name: &str) -> Result<bool> {
        let query = sql::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM ordered_line l WHERE order_name = $1 AND taken_at IS NOT NULL \
             AND NOT EXISTS (SELECT 1 FROM part p WHERE p.claim = l.claim))",
        );
        Ok(query.bind(order_name).fetch_one(self.reader()?).await?)
    }

    /// Cancels a line of which the ledger has no part; `false` = it has one, or the line was cancelled before. A claim that is being made
    /// of it becomes a part that is refused with it.
    pub async fn cancel_arriving_line(&self, line: &OrderedLine, reason: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        let cancel = sql::query(
            "UPDATE ordered_line SET taken_at = $1 WHERE claim = $2 AND taken_at IS NULL \
             AND NOT EXISTS (SELECT 1 FROM part p WHERE p.claim = ordered_line.claim)",
        );
        if cancel.bind(now).bind(&line.claim).execute(change.db()).await? == 0 {
            return Ok(false);
        }
        let detail = format!("{} of order {}, ordered by {}: {reason}", line.name, line.order_name, line.client);
        change.write_refusal_event(&line.machine, None, RefusalCause::Cancelled, &detail).await?;
        change.commit().await?;
        Ok(true)
    }

    /// The contents that lines need of which the ledger has no part.
    pub async fn contents_of_arriving_lines(&self) -> Result<Vec<String>> {
        let query = sql::query_scalar("SELECT DISTINCT content_hash FROM ordered_line WHERE taken_at IS NULL");
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// Forgets the keys of requests, and the lines that were taken, of before a time.
    pub async fn forget_order_requests(&self, before: UtcTimestamp) -> Result<()> {
        let mut change = self.begin_change().await?;
        let keys = sql::query("DELETE FROM request_key WHERE answered_at < $1").bind(before);
        let forgotten = keys.execute(change.db()).await?;
        let lines = sql::query("DELETE FROM ordered_line WHERE ordered_at < $1 AND taken_at IS NOT NULL").bind(before);
        if forgotten + lines.execute(change.db()).await? == 0 {
            return Ok(());
        }
        change.commit().await
    }
}

/// Records a line, unless it is recorded. `false` = it is, or its part is there.
async fn insert_line(change: &mut LedgerChange, line: &OrderedLine) -> Result<bool> {
    let now = change.now;
    let is_new: Option<bool> = sql::query_scalar(
        "INSERT INTO ordered_line (claim, client, machine, order_name, name, content_hash, copies, ticket, ordered_at, read_unit, taken_at) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, (SELECT max(p.claimed_at) FROM part p WHERE p.claim = $1)) \
         ON CONFLICT (claim) DO NOTHING RETURNING taken_at IS NULL",
    )
    .bind(&line.claim)
    .bind(&line.client)
    .bind(&line.machine)
    .bind(&line.order_name)
    .bind(&line.name)
    .bind(&line.content_hash)
    .bind(line.copies)
    .bind(&line.ticket)
    .bind(now)
    .bind(line.read_unit)
    .fetch_optional(change.db())
    .await?;
    Ok(is_new.unwrap_or(false))
}

impl LedgerChange {
    /// The part of a claim is being recorded. Returns the line that ordered it by request.
    pub(crate) async fn take_ordered_line(&mut self, claim: &str) -> Result<Option<TakenLine>> {
        let now = self.now;
        let find =
            sql::query_as("SELECT client, taken_at IS NOT NULL AS is_cancelled FROM ordered_line WHERE claim = $1");
        let found: Option<TakenLine> = find.bind(claim).fetch_optional(self.db()).await?;
        if found.as_ref().is_some_and(|line| !line.is_cancelled) {
            let take = sql::query("UPDATE ordered_line SET taken_at = $1 WHERE claim = $2");
            take.bind(now).bind(claim).execute(self.db()).await?;
        }
        Ok(found)
    }
}
