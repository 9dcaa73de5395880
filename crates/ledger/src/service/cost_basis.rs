//! What the cost of a build is shared by: the copies of each order in it.

use jiff::Timestamp;
use sqlx::AssertSqlSafe;

use crate::{
    BuildId, Ledger, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, FromSqlRow, TypedQuery, sql_row},
    },
};

/// Which builds are asked for. All that were published are, but those that were taken back.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CostQuery {
    /// Published then or later.
    pub since: Option<Timestamp>,
    /// Published before.
    pub until: Option<Timestamp>,
    /// Only this one.
    pub build: Option<BuildId>,
    /// Only those with a copy of this order.
    pub order_name: Option<String>,
}

/// A build that costs something.
#[derive(Debug, Clone, PartialEq)]
pub struct CostedBuild {
    /// Its number.
    pub build: BuildId,
    /// Machine.
    pub machine: String,
    /// When it was published.
    pub published_at: UtcTimestamp,
    /// What it is made of; "" = not known.
    pub material: String,
    /// Height, mm.
    pub height_mm: f64,
    /// Part volume / (base area x height), 0..1; `None` = not known.
    pub density: Option<f64>,
    /// Volume of its parts, mm3.
    pub part_volume_mm3: f64,
    /// The machine's profile when it was made, JSON.
    pub profile_snapshot: Option<String>,
}

sql_row!(CostedBuild { build, machine, published_at, material, height_mm, density, part_volume_mm3, profile_snapshot });

/// The copies of an order in a build.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderedCopies {
    /// The build.
    pub build: BuildId,
    /// Order, "" = none.
    pub order_name: String,
    /// Who it is for, "" = not said.
    pub customer: String,
    /// Whether they were told to be bad.
    pub is_bad: bool,
    /// How many.
    pub copies: u32,
    /// Their volume, mm3.
    pub volume_mm3: f64,
}

sql_row!(OrderedCopies { build, order_name, customer, is_bad, copies, volume_mm3 });

/// The builds of a query, by index: `$1` since, `$2` until, `$3` build, `$4` order. Times are stored as text that begins with a digit.
fn matching_builds(query: &CostQuery) -> String {
    let of_build = if query.build.is_some() { "b.id = $3" } else { "$3 IS NULL" };
    let of_order = match query.order_name {
        None => "$4 IS NULL",
        Some(_) => {
            "b.id IN (SELECT o.build_id FROM part q JOIN placement o ON o.part_id = q.id WHERE q.order_name = $4 AND q.order_name <> '' \
             UNION SELECT o.build_id FROM part q JOIN bad_placement o ON o.part_id = q.id WHERE q.order_name = $4 AND q.order_name <> '')"
        }
    };
    format!(
        "build b WHERE b.published_at >= coalesce($1, '') AND b.published_at < coalesce($2, ':') AND b.withdrawn_at IS NULL \
         AND {of_build} AND {of_order}"
    )
}

impl Ledger {
    /// The builds that match, the earliest first, and the copies in them, by build, order and customer.
    pub async fn cost_basis(&self, query: &CostQuery) -> Result<(Vec<CostedBuild>, Vec<OrderedCopies>)> {
        let matching = matching_builds(query);
        let builds = format!(
            "SELECT b.id AS build, b.machine, b.published_at, b.material, coalesce(b.height_mm, 0.0) AS height_mm, b.density, \
             coalesce(b.part_volume_mm3, 0.0) AS part_volume_mm3, b.profile_snapshot FROM {matching} \
             ORDER BY b.published_at, b.id"
        );
        // Not the view of all copies: SQLite would read every copy of the ledger before it groups.
        let copies = format!(
            "SELECT l.build_id AS build, p.order_name, p.customer, l.is_bad, count(*) AS copies, \
             coalesce(sum(p.volume_mm3), 0.0) AS volume_mm3 FROM (\
             SELECT build_id, part_id, 1 = 0 AS is_bad FROM placement WHERE build_id IN (SELECT b.id FROM {matching}) \
             UNION ALL SELECT build_id, part_id, 1 = 1 FROM bad_placement WHERE build_id IN (SELECT b.id FROM {matching})) AS l \
             JOIN part p ON p.id = l.part_id \
             GROUP BY l.build_id, p.order_name, p.customer, l.is_bad ORDER BY l.build_id, p.order_name, p.customer, l.is_bad"
        );
        let builds = with_values(builds, query).fetch_all(self.reader()?).await?;
        Ok((builds, with_values(copies, query).fetch_all(self.reader()?).await?))
    }
}

fn with_values<T: FromSqlRow + Send>(text: String, query: &CostQuery) -> TypedQuery<T> {
    sql::query_as(AssertSqlSafe(text))
        .bind(query.since.map(UtcTimestamp))
        .bind(query.until.map(UtcTimestamp))
        .bind(query.build)
        .bind(&query.order_name)
}
