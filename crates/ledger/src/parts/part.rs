//! Parts: what a customer dropped, one row per solid.

use jiff::Timestamp;

use crate::{
    BuildId, Ledger, PartId, PartRow, PartState, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    rows::precedence::sort_by_precedence,
    store::change::LedgerChange,
};

/// A part with the name of another file of its order, or one that is made of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Namesake {
    /// Its number.
    pub id: PartId,
    /// File name as dropped.
    pub name: String,
    /// Whether a ticket or a row of a list came with it.
    pub has_ticket: bool,
}

sql_row!(Namesake { id, name, has_ticket });

/// How file systems and the programs that copy files round a time, ns.
const TIME_STEPS_NS: [i64; 6] = [100, 1_000, 1_000_000, 10_000_000, 1_000_000_000, 2_000_000_000];

/// Whether two times are one, which one of the two may tell rounded.
fn is_same_time(a_ns: i64, b_ns: i64) -> bool {
    let is_step = |step: &i64| (a_ns % step == 0 || b_ns % step == 0) && a_ns.abs_diff(b_ns) < step.unsigned_abs();
    a_ns == b_ns || TIME_STEPS_NS.iter().any(is_step)
}

/// The parts of earlier claims that may be of the same file as part $1, with their times and that of the file, the latest first.
const SAME_FILES: &str = "SELECT p.id, p.file_mtime_ns, n.file_mtime_ns FROM part n JOIN part p ON p.content_hash = n.content_hash \
    WHERE n.id = $1 AND p.name = n.name AND p.file_folder = n.file_folder AND p.id < n.id AND p.claim <> n.claim \
    AND (p.state <> 'refused' OR p.refusal IN ('cancelled', 'replaced')) AND (p.machine = n.machine \
    OR EXISTS (SELECT 1 FROM event e WHERE e.part_id = p.id AND e.kind = 'moved')) ORDER BY p.id DESC";

/// The first part whose time is that of the file.
fn latest_of_same_time(earlier: Vec<(PartId, Option<i64>, Option<i64>)>) -> Option<PartId> {
    let is_same = |before: Option<i64>, now: Option<i64>| before.zip(now).is_some_and(|(a, b)| is_same_time(a, b));
    earlier.into_iter().find(|&(_, before, now)| is_same(before, now)).map(|(id, ..)| id)
}

impl LedgerChange {
    /// Same as [`Ledger::find_put_back_part`] within a change.
    pub(super) async fn find_put_back(&mut self, part: PartId) -> Result<Option<PartId>> {
        Ok(latest_of_same_time(sql::query_as(SAME_FILES).bind(part).fetch_all(self.db()).await?))
    }
}

impl Ledger {
    /// Finds a part by its number.
    pub async fn find_part(&self, id: PartId) -> Result<Option<PartRow>> {
        let query = sql::select_as("FROM part WHERE id = $1").bind(id);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// All parts in a state, oldest first.
    pub async fn parts_in_state(&self, state: PartState) -> Result<Vec<PartRow>> {
        let query = sql::select_as("FROM part WHERE state = $1 ORDER BY claimed_at, id").bind(state);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The parts that entered a state between two times, newest first, at most `most` of them.
    pub async fn parts_in_state_between(
        &self,
        state: PartState,
        since: Timestamp,
        until: Timestamp,
        most: u32,
    ) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE state = $1 AND state_at >= $2 AND state_at <= $3 ORDER BY state_at DESC, id DESC LIMIT $4",
        );
        Ok(query
            .bind(state)
            .bind(UtcTimestamp(since))
            .bind(UtcTimestamp(until))
            .bind(most)
            .fetch_all(self.reader()?)
            .await?)
    }

    /// The claimed parts of a machine that must be read next, in order, at most `most` of them.
    pub async fn claimed_parts(&self, machine: &str, most: usize) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE state = 'claimed' AND machine = $1 AND damaged_at IS NULL AND fetch_at IS NULL \
             ORDER BY id LIMIT $2",
        );
        Ok(query.bind(machine).bind(most as i64).fetch_all(self.reader()?).await?)
    }

    /// File hashes of all parts that entered a state between two times.
    pub async fn hashes_in_state_between(
        &self,
        state: PartState,
        from: Timestamp,
        to: Timestamp,
    ) -> Result<Vec<String>> {
        let query = sql::query_scalar(
            "SELECT DISTINCT content_hash FROM part WHERE state = $1 AND state_at >= $2 AND state_at <= $3",
        );
        Ok(query.bind(state).bind(UtcTimestamp(from)).bind(UtcTimestamp(to)).fetch_all(self.reader()?).await?)
    }

    /// All solids of a claim, by object index.
    pub async fn parts_of_claim(&self, claim: &str) -> Result<Vec<PartRow>> {
        let query = sql::select_as("FROM part WHERE claim = $1 ORDER BY object_index").bind(claim);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// All parts of an order, oldest first.
    pub async fn parts_of_order(&self, name: &str) -> Result<Vec<PartRow>> {
        let query = sql::select_as("FROM part WHERE order_name = $1 AND order_name <> '' ORDER BY id");
        Ok(query.bind(name).fetch_all(self.reader()?).await?)
    }

    /// All parts with this dropped file name, oldest first.
    pub async fn parts_named(&self, name: &str) -> Result<Vec<PartRow>> {
        let query = sql::select_as("FROM part WHERE name = $1 ORDER BY id").bind(name);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The parts of a machine that are not built or refused, and those built or refused since a time, oldest first.
    pub async fn recent_parts(&self, machine: &str, since: Timestamp) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE id IN (\
             SELECT id FROM part WHERE state IN ('claimed', 'waiting', 'batched') AND machine = $1 \
             UNION ALL SELECT id FROM part WHERE state IN ('built', 'refused') AND state_at >= $2 AND machine || '' = $1) \
             ORDER BY id",
        );
        Ok(query.bind(machine).bind(UtcTimestamp(since)).fetch_all(self.reader()?).await?)
    }

    /// The parts that are not built or refused and whose order or file name matches a pattern with `*` and `?`, oldest
    /// first.
    pub async fn unbuilt_parts_matching(&self, pattern: &str) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE state IN ('claimed', 'waiting', 'batched') AND (glob($1, name) OR glob($1, order_name)) \
             ORDER BY id",
        );
        Ok(query.bind(pattern).fetch_all(self.reader()?).await?)
    }

    /// All parts with this content, whatever their names.
    pub async fn parts_with_content(&self, hash: &str) -> Result<Vec<PartRow>> {
        let query = sql::select_as("FROM part WHERE content_hash = $1 ORDER BY id").bind(hash);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// All parts with a copy in a build, in order of precedence.
    pub async fn parts_of_build(&self, build: BuildId) -> Result<Vec<PartRow>> {
        let query = sql::select_as("FROM part WHERE id IN (SELECT part_id FROM build_copy WHERE build_id = $1)");
        let mut parts: Vec<PartRow> = query.bind(build).fetch_all(self.reader()?).await?;
        sort_by_precedence(&mut parts);
        Ok(parts)
    }

    /// Whether an earlier claim has the content of a part.
    pub async fn has_earlier_content(&self, part: &PartRow) -> Result<bool> {
        let query =
            sql::query_scalar("SELECT EXISTS (SELECT 1 FROM part WHERE content_hash = $1 AND id < $2 AND claim <> $3)");
        Ok(query.bind(&part.file.content_hash).bind(part.id).bind(&part.file.claim).fetch_one(self.reader()?).await?)
    }

    /// The latest part of an earlier claim, not refused, with the same content for the same machine.
    pub async fn find_earlier_part(&self, machine: &str, hash: &str, before: PartId) -> Result<Option<PartId>> {
        let query = sql::query_scalar(
            "SELECT id FROM part WHERE content_hash = $1 AND machine = $2 AND id < $3 AND state <> 'refused' \
             AND claim <> (SELECT claim FROM part WHERE id = $3) ORDER BY id DESC LIMIT 1",
        );
        Ok(query.bind(hash).bind(machine).bind(before).fetch_optional(self.reader()?).await?)
    }

    /// The latest part of an earlier claim whose file had the same folder, name, content and modification time, perhaps rounded: a sync
    /// program may have put that file back. Where nestd refused the part, a person has put its file back; where a person cancelled it, or a
    /// newer revision took its place, nobody may have.
    pub async fn find_put_back_part(&self, part: PartId) -> Result<Option<PartId>> {
        Ok(latest_of_same_time(sql::query_as(SAME_FILES).bind(part).fetch_all(self.reader()?).await?))
    }

    /// The parts of other claims that have one of these names in the order of a part, oldest first: not refused, and not built
    /// before `since`.
    pub async fn namesakes_of_part(&self, part: &PartRow, names: &[String], since: Timestamp) -> Result<Vec<Namesake>> {
        let query = sql::query_as(
            "SELECT id, name, EXISTS (SELECT 1 FROM ticket t WHERE t.part_id = part.id AND t.source <> 'name') AS has_ticket \
             FROM part WHERE name IN (SELECT value FROM json_each($1)) AND machine = $2 AND order_name = $3 AND claim <> $4 \
             AND object_index = 0 AND state <> 'refused' AND (state <> 'built' OR state_at >= $5) ORDER BY id",
        );
        let query = query.bind(serde_json::json!(names).to_string()).bind(&part.machine).bind(&part.terms.order_name);
        Ok(query.bind(&part.file.claim).bind(UtcTimestamp(since)).fetch_all(self.reader()?).await?)
    }

    /// The parts of other claims that are copies of files with these names in the order of a part, oldest first: those that were read, of
    /// which nothing is asked, and that were not built before `since`.
    pub async fn copies_of_files(&self, part: &PartRow, names: &[String], since: Timestamp) -> Result<Vec<Namesake>> {
        let query = sql::query_as(
            "SELECT id, name, EXISTS (SELECT 1 FROM ticket t WHERE t.part_id = part.id AND t.source <> 'name') AS has_ticket \
             FROM part WHERE copy_of <> '' AND copy_of IN (SELECT value FROM json_each($1)) AND machine = $2 AND order_name = $3 \
             AND claim <> $4 AND object_index = 0 AND question = '' AND (state IN ('waiting', 'batched') OR (state = 'built' AND state_at >= $5)) \
             ORDER BY id",
        );
        let query = query.bind(serde_json::json!(names).to_string()).bind(&part.machine).bind(&part.terms.order_name);
        Ok(query.bind(&part.file.claim).bind(UtcTimestamp(since)).fetch_all(self.reader()?).await?)
    }

    /// Whether a ticket or a row of a list came with a part.
    pub async fn has_ticket(&self, part: PartId) -> Result<bool> {
        let query = sql::query_scalar("SELECT EXISTS (SELECT 1 FROM ticket WHERE part_id = $1 AND source <> 'name')");
        Ok(query.bind(part).fetch_one(self.reader()?).await?)
    }

    /// Whether the stored file is needed by a part that is claimed, waiting or batched, or by one that was refused
    /// after `refused_since` and may be retried.
    pub async fn is_hash_in_use(&self, hash: &str, refused_since: Timestamp) -> Result<bool> {
        let query = sql::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM part WHERE content_hash = $1 AND (state IN ('claimed', 'waiting', 'batched') \
             OR (state = 'refused' AND state_at >= $2)))",
        );
        Ok(query.bind(hash).bind(UtcTimestamp(refused_since)).fetch_one(self.reader()?).await?)
    }
}
