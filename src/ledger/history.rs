//! The history: builds with their heights, newest first.

use jiff::Timestamp;
use schemars::JsonSchema;
use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, BuildMeasures, BuildState, Ledger, SearchEffort, UtcTimestamp, error::Result};

/// Filter and order of the history. The time of a build is when it was published, or else when it entered its current
/// state.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HistoryQuery {
    /// Earliest time.
    pub since: Option<Timestamp>,
    /// Latest time, exclusive.
    pub until: Option<Timestamp>,
    /// Only builds of this machine profile.
    pub profile: Option<String>,
    /// Only builds in this state.
    pub state: Option<BuildState>,
    /// Only builds with a copy of a part of this file name or order.
    pub part: Option<String>,
    /// Sort order.
    pub sort: HistorySort,
    /// Only builds after this one in the sort order.
    pub after: Option<BuildId>,
    /// Maximum number of builds; `None` = all.
    pub limit: Option<u32>,
}

/// Sort order of the history. Among equals, the newest comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HistorySort {
    /// The newest first.
    #[default]
    Newest,
    /// The lowest first.
    Height,
    /// The densest first.
    Density,
    /// The most copies first.
    Copies,
    /// By machine profile, alphabetically.
    Profile,
}

/// A build that has been nested.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow, JsonSchema)]
pub struct HistoryRow {
    /// Its number.
    pub build: BuildId,
    /// Machine profile.
    pub profile: String,
    /// Current state.
    pub state: BuildState,
    /// When it was published, or else when it entered its current state.
    pub at: UtcTimestamp,
    /// When its file was put into the queue; `None` = never.
    pub published_at: Option<UtcTimestamp>,
    /// Height of the machine's volume at the time of the build, mm.
    pub volume_z_mm: Option<f64>,
    /// Distinct parts.
    pub parts: u32,
    /// What was measured of it.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub measures: BuildMeasures,
    /// What the search for it took.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub search: SearchEffort,
    /// Trigger.
    pub fired_by: String,
    /// What came of it.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub result: BuildResult,
}

/// What came of a build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, FromRow)]
pub struct BuildResult {
    /// Name of the build file.
    pub file_name: Option<String>,
    /// Why it failed, or the note of the outcome.
    pub reason: String,
    /// Note of the last reported outcome; "" if there is none.
    pub note: String,
}

/// Totals of the published builds of a machine. The cost of a powder-bed machine is determined by the height.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow, JsonSchema)]
pub struct HeightSummary {
    /// Machine profile.
    pub profile: String,
    /// Number of published builds.
    pub builds: u32,
    /// Copies in them.
    pub copies: u32,
    /// Sum of their heights, mm.
    pub height_mm: f64,
    /// Mean of their densities, 0..1.
    pub mean_density: Option<f64>,
}

impl HeightSummary {
    /// Adds a row with the total of all machines if there are several.
    pub fn with_total(mut sums: Vec<Self>) -> Vec<Self> {
        if sums.len() > 1 {
            let builds: u32 = sums.iter().map(|sum| sum.builds).sum();
            let known = sums.iter().filter_map(|sum| Some((sum.mean_density?, sum.builds)));
            let (density, of) = known.fold((0.0, 0), |(sum, of), (mean, n)| (sum + mean * f64::from(n), of + n));
            sums.push(Self {
                profile: "all machines".to_owned(),
                builds,
                copies: sums.iter().map(|sum| sum.copies).sum(),
                height_mm: sums.iter().map(|sum| sum.height_mm).sum(),
                mean_density: (of > 0).then(|| density / f64::from(of)),
            });
        }
        sums
    }
}

/// Columns of the history query.
const COLUMNS: &str = "b.id AS build, b.profile, b.state, coalesce(b.published_at, b.state_at) AS at, b.published_at, \
    b.height_mm, \
    iif(json_valid(b.profile_snapshot), json_extract(b.profile_snapshot, '$.volume_mm[2]'), NULL) AS volume_z_mm, \
    b.density, b.lower_bound_mm, b.layers, \
    (SELECT count(*) FROM (SELECT l.part_id FROM placement l WHERE l.build_id = b.id \
    UNION SELECT l.part_id FROM bad_placement l WHERE l.build_id = b.id)) AS parts, b.copies, \
    b.part_volume_mm3, b.clearance_mm, b.clearance_proved_mm, b.cpu_secs, b.wall_secs, b.evaluations, \
    b.seed, b.method, b.version, b.repeats, b.fired_by, b.file_name, b.reason, \
    coalesce((SELECT o.note FROM outcome o WHERE o.build_id = b.id ORDER BY o.id DESC LIMIT 1), '') AS note";

impl HistoryRow {
    /// Share of the machine's height that the build uses, 0..1.
    pub fn height_share(&self) -> Option<f64> {
        Some(self.measures.height_mm? / self.volume_z_mm.filter(|z| *z > 0.0)?)
    }
}

impl Ledger {
    /// Lists nested builds with their heights, in the requested order.
    pub async fn read_history(&self, query: &HistoryQuery) -> Result<Vec<HistoryRow>> {
        let rows = sqlx::query_as(sqlx::AssertSqlSafe(history_sql(query)))
            .bind(query.since.map(UtcTimestamp))
            .bind(query.until.map(UtcTimestamp))
            .bind(&query.profile)
            .bind(query.state)
            .bind(&query.part)
            .bind(query.limit.map_or(-1, i64::from))
            .bind(query.after);
        Ok(rows.fetch_all(self.reader()?).await?)
    }

    /// Totals of the published builds that match the query, by machine. Limit and page of the query are ignored.
    pub async fn height_summaries(&self, query: &HistoryQuery) -> Result<Vec<HeightSummary>> {
        let rows = sqlx::query_as(sqlx::AssertSqlSafe(summary_sql(query)))
            .bind(query.since.map(UtcTimestamp))
            .bind(query.until.map(UtcTimestamp))
            .bind(&query.profile)
            .bind(query.state)
            .bind(&query.part);
        Ok(rows.fetch_all(self.reader()?).await?)
    }
}

/// SQL expression for the time of a build.
const BUILD_TIME: &str = "coalesce(b.published_at, b.state_at)";

/// Builds the SQL query. Without a sort key it walks an index from the newest build. If few rows match (a rare state,
/// the builds of a part), these are looked up and sorted. Times are stored as text that begins with a digit, so ''
/// sorts before and ':' after all of them.
pub(super) fn history_sql(query: &HistoryQuery) -> String {
    let of_after = |what: &str| format!("(SELECT {} FROM build n WHERE n.id = ?7)", what.replace("b.", "n."));
    let (from, mut given) = (from_clause(query), filter_clause(query));
    let (mut end, order) = (format!("{BUILD_TIME} < coalesce(?2, ':')"), query.sort.sort_key());
    if query.after.is_some() {
        let newer = format!("({BUILD_TIME}, b.id) < ({}, ?7)", of_after(BUILD_TIME));
        given += &match order {
            None => {
                // A single bound for the index range: with two, SQLite might use the wrong one.
                end = format!(
                    "{BUILD_TIME} <= min(coalesce(?2, ':'), {}) AND +{BUILD_TIME} < coalesce(?2, ':')",
                    of_after(BUILD_TIME)
                );
                format!(" AND {newer}")
            }
            Some((key, is_falling)) => {
                let (sign, of_after) = (if is_falling { '<' } else { '>' }, of_after(key));
                format!(" AND ({key} {sign} {of_after} OR {key} = {of_after} AND {newer})")
            }
        };
    }
    let first = order.map(|(key, is_falling)| format!("{key}{}, ", if is_falling { " DESC" } else { "" }));
    let order = format!("ORDER BY {}{BUILD_TIME} DESC, b.id DESC", first.unwrap_or_default());
    // Parts are counted only for the rows that are returned.
    let numbers = format!(
        "SELECT b.id FROM {from} WHERE b.state NOT IN ('open', 'nesting') AND {BUILD_TIME} >= coalesce(?1, '') \
         AND {end}{given} {order} LIMIT ?6"
    );
    format!("SELECT {COLUMNS} FROM build b WHERE b.id IN ({numbers}) {order}")
}

/// The FROM clause.
fn from_clause(query: &HistoryQuery) -> &'static str {
    let is_rare = !matches!(query.state, None | Some(BuildState::Published | BuildState::Complete));
    match (&query.part, is_rare) {
        (Some(_), _) => "build b NOT INDEXED",
        (None, true) => "build b INDEXED BY build_by_state",
        (None, false) => "build b",
    }
}

/// The conditions besides the time.
fn filter_clause(query: &HistoryQuery) -> String {
    let mut given = String::new();
    if query.profile.is_some() {
        given += " AND b.profile = ?3";
    }
    if query.state.is_some() {
        given += " AND b.state = ?4";
    }
    if query.part.is_some() {
        given += WITH_PART;
    }
    given
}

/// Builds the SQL query for the totals of published builds.
fn summary_sql(query: &HistoryQuery) -> String {
    format!(
        "SELECT b.profile, count(*) AS builds, coalesce(sum(b.copies), 0) AS copies, \
         coalesce(sum(b.height_mm), 0.0) AS height_mm, avg(b.density) AS mean_density FROM {} \
         WHERE b.state NOT IN ('open', 'nesting') AND b.published_at IS NOT NULL \
         AND {BUILD_TIME} >= coalesce(?1, '') AND {BUILD_TIME} < coalesce(?2, ':'){} GROUP BY b.profile ORDER BY b.profile",
        from_clause(query),
        filter_clause(query)
    )
}

/// Condition for builds with a copy of a part of that file name or order.
const WITH_PART: &str = " AND b.id IN (SELECT l.build_id FROM part p CROSS JOIN placement l ON l.part_id = p.id \
    WHERE p.name = ?5 UNION SELECT l.build_id FROM part p CROSS JOIN placement l ON l.part_id = p.id \
    WHERE p.order_name = ?5 AND p.order_name <> '')";

impl HistorySort {
    /// The expression to sort by before the time, and whether it is descending. Unknown values come last.
    fn sort_key(self) -> Option<(&'static str, bool)> {
        match self {
            Self::Newest => None,
            Self::Height => Some(("coalesce(b.height_mm, 9e999)", false)),
            Self::Density => Some(("coalesce(b.density, -1)", true)),
            Self::Copies => Some(("coalesce(b.copies, -1)", true)),
            Self::Profile => Some(("b.profile", false)),
        }
    }
}
