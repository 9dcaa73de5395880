//! The history: builds with their heights, newest first.

use jiff::Timestamp;
use schemars::JsonSchema;
use serde::Serialize;

use sqlx::AssertSqlSafe;

use crate::{
    BuildId, BuildMeasures, BuildState, Ledger, SearchEffort, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, FromSqlRow, SqlRow, sql_row},
    },
    rows::build_row::state_word,
};

/// Filter and order of the history. The time of a build is when it was published, or else when it entered its current
/// state.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HistoryQuery {
    /// Earliest time.
    pub since: Option<Timestamp>,
    /// Latest time, exclusive.
    pub until: Option<Timestamp>,
    /// Only builds of this machine.
    pub machine: Option<String>,
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
    /// By machine, alphabetically.
    Machine,
}

/// A build that has been nested.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct HistoryRow {
    /// Its number.
    pub build: BuildId,
    /// Machine.
    pub machine: String,
    /// The printer in whose queue folder its file is, or was; `None` = its machine has only one.
    pub printer: Option<String>,
    /// Current state.
    pub state: BuildState,
    /// When it was published, or else when it entered its current state.
    pub at: UtcTimestamp,
    /// When its file was put into the queue; `None` = never.
    pub published_at: Option<UtcTimestamp>,
    /// When its file was taken back out of the queue: it was not printed; `None` = never.
    pub withdrawn_at: Option<UtcTimestamp>,
    /// Whether its printer took its file out of the queue, as far as is known.
    #[serde(skip)]
    pub is_taken: bool,
    /// Height of the machine's volume at the time of the build, mm.
    pub volume_z_mm: Option<f64>,
    /// Distinct parts.
    pub parts: u32,
    /// What was measured of it.
    #[serde(flatten)]
    pub measures: BuildMeasures,
    /// What the search for it took.
    #[serde(flatten)]
    pub search: SearchEffort,
    /// What it is made of; "" = not known.
    pub material: String,
    /// The lot of its powder, "" = not said.
    pub lot: String,
    /// Trigger.
    pub fired_by: String,
    /// What came of it.
    #[serde(flatten)]
    pub result: BuildResult,
}

impl FromSqlRow for HistoryRow {
    fn from_sql_row(row: &SqlRow) -> sqlx::Result<Self> {
        Ok(Self {
            build: row.column("build")?,
            machine: row.column("machine")?,
            printer: row.column("printer")?,
            state: row.column("state")?,
            at: row.column("at")?,
            published_at: row.column("published_at")?,
            withdrawn_at: row.column("withdrawn_at")?,
            is_taken: row.column("is_taken")?,
            volume_z_mm: row.column::<Option<String>>("profile_snapshot")?.and_then(|json| volume_height(&json)),
            parts: row.column("parts")?,
            measures: FromSqlRow::from_sql_row(row)?,
            search: FromSqlRow::from_sql_row(row)?,
            material: row.column("material")?,
            lot: row.column("lot")?,
            fired_by: row.column("fired_by")?,
            result: FromSqlRow::from_sql_row(row)?,
        })
    }
}

/// Height of the machine's volume according to the profile at the time of a build, mm.
fn volume_height(profile_snapshot: &str) -> Option<f64> {
    let machine: serde_json::Value = serde_json::from_str(profile_snapshot).ok()?;
    machine.get("volume_mm")?.get(2)?.as_f64()
}

/// What came of a build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BuildResult {
    /// Name of the build file.
    pub file_name: Option<String>,
    /// Why it failed, or the note of the outcome.
    pub reason: String,
    /// Note of the last reported outcome; "" if there is none.
    pub note: String,
}

sql_row!(BuildResult { file_name, reason, note });

/// Totals of the published builds of a machine. The cost of a powder-bed machine is determined by the height.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct HeightSummary {
    /// Machine.
    pub machine: String,
    /// Number of published builds.
    pub builds: u32,
    /// Copies in them.
    pub copies: u32,
    /// Sum of their heights, mm.
    pub height_mm: f64,
    /// Mean of their densities, 0..1.
    pub mean_density: Option<f64>,
}

sql_row!(HeightSummary { machine, builds, copies, height_mm, mean_density });

impl HeightSummary {
    /// Adds a row with the total of all machines if there are several.
    pub fn with_total(mut sums: Vec<Self>) -> Vec<Self> {
        if sums.len() > 1 {
            let builds: u32 = sums.iter().map(|sum| sum.builds).sum();
            let known = sums.iter().filter_map(|sum| Some((sum.mean_density?, sum.builds)));
            let (density, of) = known.fold((0.0, 0), |(sum, of), (mean, n)| (sum + mean * f64::from(n), of + n));
            sums.push(Self {
                machine: language::say!("all-machines"),
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
const COLUMNS: &str = "b.id AS build, b.machine, nullif(b.printer, b.machine) AS printer, b.state, coalesce(b.published_at, b.state_at) AS at, b.published_at, \
    b.withdrawn_at, b.taken_at IS NOT NULL AS is_taken, b.height_mm, \
    b.profile_snapshot, \
    b.density, b.lower_bound_mm, b.layers, \
    (SELECT count(*) FROM (SELECT l.part_id FROM placement l WHERE l.build_id = b.id \
    UNION SELECT l.part_id FROM bad_placement l WHERE l.build_id = b.id) AS distinct_part) AS parts, b.copies, \
    b.part_volume_mm3, b.clearance_mm, b.clearance_proved_mm, b.cpu_secs, b.wall_secs, b.evaluations, \
    b.seed, b.method, b.version, b.repeats, b.material, b.lot, b.fired_by, b.file_name, b.reason, \
    coalesce((SELECT o.note FROM outcome o WHERE o.build_id = b.id ORDER BY o.id DESC LIMIT 1), '') AS note";

impl HistoryRow {
    /// Whether its file was put into the queue and not taken back.
    pub fn is_published(&self) -> bool {
        self.published_at.is_some() && self.withdrawn_at.is_none()
    }

    /// Its state for people, who call a build that was taken back out of the queue withdrawn, and not failed.
    pub fn state_word(&self) -> String {
        state_word(self.state, self.withdrawn_at)
    }

    /// Share of the machine's height that the build uses, 0..1.
    pub fn height_share(&self) -> Option<f64> {
        Some(self.measures.height_mm? / self.volume_z_mm.filter(|z| *z > 0.0)?)
    }
}

impl Ledger {
    /// Lists nested builds with their heights, in the requested order.
    pub async fn read_history(&self, query: &HistoryQuery) -> Result<Vec<HistoryRow>> {
        let rows = sql::query_as(AssertSqlSafe(history_sql(query)))
            .bind(query.since.map(UtcTimestamp))
            .bind(query.until.map(UtcTimestamp))
            .bind(&query.machine)
            .bind(query.state)
            .bind(&query.part)
            .bind(query.limit.map_or(i64::MAX, i64::from))
            .bind(query.after);
        Ok(rows.fetch_all(self.reader()?).await?)
    }

    /// Totals of the published builds that match the query, by machine. Limit and page of the query are ignored.
    pub async fn height_summaries(&self, query: &HistoryQuery) -> Result<Vec<HeightSummary>> {
        let rows = sql::query_as(AssertSqlSafe(summary_sql(query)))
            .bind(query.since.map(UtcTimestamp))
            .bind(query.until.map(UtcTimestamp))
            .bind(&query.machine)
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
pub(crate) fn history_sql(query: &HistoryQuery) -> String {
    let time = time_key(query);
    let of_after = |what: &str| format!("(SELECT {} FROM build n WHERE n.id = $7)", what.replace("b.", "n."));
    let mut given = filter_clause(query);
    let (mut end, order) = (format!("{time} < coalesce($2, ':')"), query.sort.sort_key());
    if query.after.is_some() {
        let after = of_after(time);
        let newer = format!("({time}, b.id) < ({after}, $7)");
        given += &match order {
            None => {
                // A single bound for the index range: with two, SQLite might use the wrong one.
                end = format!(
                    "{time} <= CASE WHEN $2 < {after} THEN $2 ELSE {after} END AND {time} || '' < coalesce($2, ':')"
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
    let first = first.unwrap_or_default();
    // Parts are counted only for the rows that are returned.
    let numbers = format!(
        "SELECT b.id FROM build b WHERE b.state NOT IN ('open', 'nesting') AND {time} >= coalesce($1, '') \
         AND {end}{given} ORDER BY {first}{time} DESC, b.id DESC LIMIT $6"
    );
    format!("SELECT {COLUMNS} FROM build b WHERE b.id IN ({numbers}) ORDER BY {first}{BUILD_TIME} DESC, b.id DESC")
}

/// The time of a build, to filter and sort by. When few builds match for another reason, an index by time must not be
/// used: an expression that is in no index keeps a database from it.
fn time_key(query: &HistoryQuery) -> &'static str {
    let is_rare = !matches!(query.state, None | Some(BuildState::Published | BuildState::Complete));
    match query.part.is_some() || is_rare {
        true => "coalesce(b.published_at, b.state_at) || ''",
        false => BUILD_TIME,
    }
}

/// The conditions besides the time.
fn filter_clause(query: &HistoryQuery) -> String {
    let mut given = String::new();
    if query.machine.is_some() {
        given += if query.part.is_some() { " AND b.machine || '' = $3" } else { " AND b.machine = $3" };
    }
    if query.state.is_some() {
        given += " AND b.state = $4";
    }
    if query.part.is_some() {
        given += WITH_PART;
    }
    given
}

/// Builds the SQL query for the totals of published builds.
fn summary_sql(query: &HistoryQuery) -> String {
    format!(
        "SELECT b.machine, count(*) AS builds, CAST(coalesce(sum(b.copies), 0) AS BIGINT) AS copies, \
         coalesce(sum(b.height_mm), 0.0) AS height_mm, avg(b.density) AS mean_density FROM build b \
         WHERE b.state NOT IN ('open', 'nesting') AND b.published_at IS NOT NULL \
         AND b.withdrawn_at IS NULL AND {time} >= coalesce($1, '') AND {time} < coalesce($2, ':'){} GROUP BY b.machine ORDER BY b.machine",
        filter_clause(query),
        time = time_key(query),
    )
}

/// Condition for builds with a copy of a part of that file name or order.
const WITH_PART: &str = " AND b.id IN (SELECT l.build_id FROM placement l WHERE l.part_id IN (\
    SELECT p.id FROM part p WHERE p.name = $5 UNION \
    SELECT p.id FROM part p WHERE p.order_name = $5 AND p.order_name <> ''))";

impl HistorySort {
    /// The expression to sort by before the time, and whether it is descending. Unknown values come last.
    fn sort_key(self) -> Option<(&'static str, bool)> {
        match self {
            Self::Newest => None,
            Self::Height => Some(("coalesce(b.height_mm, 1e300)", false)),
            Self::Density => Some(("coalesce(b.density, -1)", true)),
            Self::Copies => Some(("coalesce(b.copies, -1)", true)),
            Self::Machine => Some(("b.machine", false)),
        }
    }
}
