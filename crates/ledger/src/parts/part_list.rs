//! Paged lists of parts for people and programs, newest first.

use crate::{
    Ledger, PartId, PartRow, PartState,
    base::{error::Result, sql},
};

/// Filter of the list.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PartQuery {
    /// Prefix of the dropped file name or of the order; `None` = any.
    pub name: Option<String>,
    /// Only parts in this state. `None` = any state; but if no name is given either, only parts that are not built, and
    /// refused parts only while they can be retried.
    pub state: Option<PartState>,
    /// Only parts of this machine.
    pub machine: Option<String>,
    /// Only parts that came before this one.
    pub before: Option<PartId>,
    /// Maximum number of parts.
    pub limit: u32,
}

impl Ledger {
    /// Lists the parts that match the query, newest first.
    pub async fn list_parts(&self, query: &PartQuery) -> Result<Vec<PartRow>> {
        let rows = sql::select_as(&part_list_sql(query))
            .bind(&query.name)
            .bind(&query.machine)
            .bind(query.before)
            .bind(query.limit)
            .bind(self.refused_since())
            // The end of the names that begin so: no character sorts after this one.
            .bind(query.name.as_ref().map(|name| format!("{name}\u{10ffff}")));
        Ok(rows.fetch_all(self.reader()?).await?)
    }
}

/// Builds the SQL query, from its FROM on. It first looks up the part numbers in an index. Built parts, which are nearly all parts, are
/// read from the newest on.
pub(crate) fn part_list_sql(query: &PartQuery) -> String {
    let wanted = match (&query.name, query.state) {
        (Some(_), None) => vec![NAME_FILTER.to_owned()],
        (Some(_), Some(state)) => vec![format!("{NAME_FILTER} AND state || '' = '{state}'")],
        (None, Some(PartState::Built)) if query.machine.is_none() => vec!["state || '' = 'built'".to_owned()],
        (None, Some(state)) => vec![format!("state = '{state}'")],
        (None, None) => UNBUILT.map(str::to_owned).to_vec(),
    };
    let machine = query.machine.as_ref().map_or("", |_| " AND machine = $2");
    let before = query.before.map_or("", |_| " AND id < $3");
    let numbers = wanted.iter().map(|wanted| format!("SELECT id FROM part WHERE {wanted}{machine}{before}"));
    let numbers = numbers.collect::<Vec<_>>().join(" UNION ALL ");
    format!("FROM part WHERE id IN ({numbers} ORDER BY id DESC LIMIT $4) ORDER BY id DESC")
}

/// Condition for the prefix of a name.
const NAME_FILTER: &str = "id IN (SELECT id FROM part WHERE name >= $1 AND name < $6 \
    UNION SELECT id FROM part WHERE order_name >= $1 AND order_name < $6 AND order_name <> '')";

/// Conditions for parts that are not built; refused parts only while they can be retried.
const UNBUILT: [&str; 2] = ["state IN ('claimed', 'waiting', 'batched')", "state = 'refused' AND state_at >= $5"];
