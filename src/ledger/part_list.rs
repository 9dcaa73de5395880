//! Lists of parts for people and programs, the newest first, so many at a time.

use super::{Ledger, PartId, PartRow, PartState, error::Result};

/// Which parts to list.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PartQuery {
    /// Of this file name as dropped, or of this order; `None` = of any.
    pub name: Option<String>,
    /// In this state; `None` = in any, but without a name only those that are not built yet.
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
            .bind(query.limit);
        Ok(rows.fetch_all(self.reader()).await?)
    }
}

/// The question. Numbers are looked up first, in an index; of built parts, of which nearly all are, from the newest on.
pub(super) fn sql(query: &PartQuery) -> String {
    let mut wanted = match (&query.name, query.state) {
        (Some(_), None) => OF_NAME.to_owned(),
        (Some(_), Some(state)) => format!("{OF_NAME} AND +state = '{state}'"),
        (None, Some(PartState::Built)) => "+state = 'built'".to_owned(),
        (None, Some(state)) => format!("state = '{state}'"),
        (None, None) => {
            let states = PartState::ALL.into_iter().filter(|state| *state != PartState::Built);
            format!("state IN ({})", states.map(|state| format!("'{state}'")).collect::<Vec<_>>().join(", "))
        }
    };
    if query.profile.is_some() {
        wanted += " AND profile = ?2";
    }
    if query.before.is_some() {
        wanted += " AND id < ?3";
    }
    let numbers = format!("SELECT id FROM part WHERE {wanted} ORDER BY id DESC LIMIT ?4");
    format!("SELECT * FROM part WHERE id IN ({numbers}) ORDER BY id DESC")
}

const OF_NAME: &str = "id IN (SELECT id FROM part WHERE name = ?1 \
    UNION SELECT id FROM part WHERE order_name = ?1 AND order_name <> '')";
