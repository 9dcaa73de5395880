//! Lists of parts for people and programs, the newest first, so many at a time.

use super::{Ledger, PartId, PartRow, PartState, error::Result};

/// Which parts to list.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PartQuery {
    /// Whose file name as dropped, or whose order, begins so; `None` = of any.
    pub name: Option<String>,
    /// In this state; `None` = in any, but without a name only those that are not built yet, and of the
    /// refused ones those that can still be retried.
    pub state: Option<PartState>,
    /// Of one machine profile only.
    pub profile: Option<String>,
    /// Only those that came before this one.
    pub before: Option<PartId>,
    /// So many at most.
    pub limit: u32,
}

impl Ledger {
    /// The parts that are asked for, the newest first.
    pub async fn parts(&self, query: &PartQuery) -> Result<Vec<PartRow>> {
        let rows = sqlx::query_as(sqlx::AssertSqlSafe(sql(query)))
            .bind(&query.name)
            .bind(&query.profile)
            .bind(query.before)
            .bind(query.limit)
            .bind(self.refused_since());
        Ok(rows.fetch_all(self.reader()?).await?)
    }
}

/// The question. Numbers are looked up first, in an index; of built parts, of which nearly all are, from the newest on.
pub(super) fn sql(query: &PartQuery) -> String {
    let wanted = match (&query.name, query.state) {
        (Some(_), None) => vec![OF_NAME.to_owned()],
        (Some(_), Some(state)) => vec![format!("{OF_NAME} AND +state = '{state}'")],
        (None, Some(PartState::Built)) if query.profile.is_none() => vec!["+state = 'built'".to_owned()],
        (None, Some(state)) => vec![format!("state = '{state}'")],
        (None, None) => UNBUILT.map(str::to_owned).to_vec(),
    };
    let profile = query.profile.as_ref().map_or("", |_| " AND profile = ?2");
    let before = query.before.map_or("", |_| " AND id < ?3");
    let numbers = wanted.iter().map(|wanted| format!("SELECT id FROM part WHERE {wanted}{profile}{before}"));
    let numbers = numbers.collect::<Vec<_>>().join(" UNION ALL ");
    format!("SELECT * FROM part WHERE id IN ({numbers} ORDER BY id DESC LIMIT ?4) ORDER BY id DESC")
}

/// A name is found by how it begins.
const OF_NAME: &str = "id IN (SELECT id FROM part WHERE name >= ?1 AND name < ?1 || char(1114111) \
    UNION SELECT id FROM part WHERE order_name >= ?1 AND order_name < ?1 || char(1114111) AND order_name <> '')";

/// What is not built yet; of the refused ones those that can still be retried.
const UNBUILT: [&str; 2] = ["state IN ('claimed', 'waiting', 'batched')", "state = 'rejected' AND state_at >= ?5"];
