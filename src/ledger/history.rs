//! The history: builds with their heights, newest first.

use jiff::Timestamp;
use schemars::JsonSchema;
use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, BuildMeasures, BuildState, Ledger, SearchEffort, Utc, error::Result};

/// Which builds to list. A build's time is when it was published, else when it entered its state.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HistoryQuery {
    /// Not before.
    pub since: Option<Timestamp>,
    /// Before.
    pub until: Option<Timestamp>,
    /// Of one machine profile only.
    pub profile: Option<String>,
    /// In this state only.
    pub state: Option<BuildState>,
    /// Only those that hold a copy of a part of this file name or order.
    pub part: Option<String>,
    /// In which order.
    pub sort: HistorySort,
    /// Only those that come after this build in that order.
    pub after: Option<BuildId>,
    /// So many at most; `None` = all.
    pub limit: Option<u32>,
}

/// What comes first in a history; of what is alike the newest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HistorySort {
    /// The newest.
    #[default]
    Newest,
    /// The lowest.
    Height,
    /// The densest.
    Density,
    /// The one with the most copies.
    Copies,
    /// The profile that comes first in the alphabet.
    Profile,
}

/// A build that is past nesting.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow, JsonSchema)]
pub struct HistoryRow {
    /// Its number.
    pub build: BuildId,
    /// Machine profile.
    pub profile: String,
    /// Where it stands.
    pub state: BuildState,
    /// When it was published, else when it entered its state.
    pub at: Utc,
    /// When it came into the queue; `None` = never.
    pub published_at: Option<Utc>,
    /// Height of the machine's volume when it was made, mm.
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
    /// Why it failed, or the outcome's note.
    pub reason: String,
    /// The note of the outcome that was told last, "" when there is none.
    pub note: String,
}

/// What the published builds of a machine come to: a powder-bed machine is paid by its height.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow, JsonSchema)]
pub struct HeightSum {
    /// Machine profile.
    pub profile: String,
    /// Builds that came into the queue.
    pub builds: u32,
    /// Copies in them.
    pub copies: u32,
    /// Sum of their heights, mm.
    pub height_mm: f64,
    /// Mean of their densities, 0..1.
    pub mean_density: Option<f64>,
}

impl HeightSum {
    /// The sums with that of all machines at the end, where there are several.
    pub fn with_all(mut sums: Vec<Self>) -> Vec<Self> {
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

/// What a row of the history is made of.
const COLUMNS: &str = "b.id AS build, b.profile, b.state, coalesce(b.published_at, b.state_at) AS at, b.published_at, \
    b.height_mm, \
    iif(json_valid(b.profile_snapshot), json_extract(b.profile_snapshot, '$.volume_mm[2]'), NULL) AS volume_z_mm, \
    b.density, b.lower_bound_mm, b.layers, \
    (SELECT count(DISTINCT l.part_id) FROM placement l WHERE l.build_id = b.id) AS parts, b.copies, \
    b.part_volume_mm3, b.clearance_mm, b.clearance_proved_mm, b.cpu_secs, b.wall_secs, b.evaluations, \
    b.seed, b.method, b.version, b.fired_by, b.file_name, b.reason, \
    coalesce((SELECT o.note FROM outcome o WHERE o.build_id = b.id ORDER BY o.id DESC LIMIT 1), '') AS note";

impl HistoryRow {
    /// Share of the height of the machine's volume that it uses, 0..1.
    pub fn used(&self) -> Option<f64> {
        Some(self.measures.height_mm? / self.volume_z_mm.filter(|z| *z > 0.0)?)
    }
}

impl Ledger {
    /// Builds that are past nesting with their heights, sorted as asked.
    pub async fn history(&self, query: &HistoryQuery) -> Result<Vec<HistoryRow>> {
        let rows = sqlx::query_as(sqlx::AssertSqlSafe(sql(query)))
            .bind(query.since.map(Utc))
            .bind(query.until.map(Utc))
            .bind(&query.profile)
            .bind(query.state)
            .bind(&query.part)
            .bind(query.limit.map_or(-1, i64::from))
            .bind(query.after);
        Ok(rows.fetch_all(self.reader()?).await?)
    }

    /// What the published builds of a history come to, by machine; of all of them, whatever its limit and its page.
    pub async fn height_sums(&self, query: &HistoryQuery) -> Result<Vec<HeightSum>> {
        let rows = sqlx::query_as(sqlx::AssertSqlSafe(sums(query)))
            .bind(query.since.map(Utc))
            .bind(query.until.map(Utc))
            .bind(&query.profile)
            .bind(query.state)
            .bind(&query.part);
        Ok(rows.fetch_all(self.reader()?).await?)
    }
}

/// The time of a build.
const TIME: &str = "coalesce(b.published_at, b.state_at)";

/// The question. Without a sorting of its own it walks an index from the newest build on; where few rows are meant (a rare
/// state, the builds of a part) these are looked up and sorted. Times are text that begins with a digit, so that '' is before
/// all of them and ':' after.
pub(super) fn sql(query: &HistoryQuery) -> String {
    let of_after = |what: &str| format!("(SELECT {} FROM build n WHERE n.id = ?7)", what.replace("b.", "n."));
    let (from, mut given) = (from(query), given(query));
    let (mut end, order) = (format!("{TIME} < coalesce(?2, ':')"), query.sort.order());
    if query.after.is_some() {
        let newer = format!("({TIME}, b.id) < ({}, ?7)", of_after(TIME));
        given += &match order {
            None => {
                // One end of the index's range, not two of which it might take the wrong one.
                end = format!("{TIME} <= min(coalesce(?2, ':'), {}) AND +{TIME} < coalesce(?2, ':')", of_after(TIME));
                format!(" AND {newer}")
            }
            Some((key, is_falling)) => {
                let (sign, of_after) = (if is_falling { '<' } else { '>' }, of_after(key));
                format!(" AND ({key} {sign} {of_after} OR {key} = {of_after} AND {newer})")
            }
        };
    }
    let first = order.map(|(key, is_falling)| format!("{key}{}, ", if is_falling { " DESC" } else { "" }));
    let order = format!("ORDER BY {}{TIME} DESC, b.id DESC", first.unwrap_or_default());
    // Of the rows that are shown alone the parts are counted.
    let numbers = format!(
        "SELECT b.id FROM {from} WHERE b.state NOT IN ('open', 'nesting') AND {TIME} >= coalesce(?1, '') \
         AND {end}{given} {order} LIMIT ?6"
    );
    format!("SELECT {COLUMNS} FROM build b WHERE b.id IN ({numbers}) {order}")
}

/// Where rows are looked for.
fn from(query: &HistoryQuery) -> &'static str {
    let is_rare = !matches!(query.state, None | Some(BuildState::Published | BuildState::Complete));
    match (&query.part, is_rare) {
        (Some(_), _) => "build b NOT INDEXED",
        (None, true) => "build b INDEXED BY build_by_state",
        (None, false) => "build b",
    }
}

/// What is demanded of them beside their time.
fn given(query: &HistoryQuery) -> String {
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

/// The question for sums, of published builds.
fn sums(query: &HistoryQuery) -> String {
    format!(
        "SELECT b.profile, count(*) AS builds, coalesce(sum(b.copies), 0) AS copies, \
         coalesce(sum(b.height_mm), 0.0) AS height_mm, avg(b.density) AS mean_density FROM {} \
         WHERE b.state NOT IN ('open', 'nesting') AND b.published_at IS NOT NULL \
         AND {TIME} >= coalesce(?1, '') AND {TIME} < coalesce(?2, ':'){} GROUP BY b.profile ORDER BY b.profile",
        from(query),
        given(query)
    )
}

/// Those that hold a copy of a part of that file name or order.
const WITH_PART: &str = " AND b.id IN (SELECT l.build_id FROM part p CROSS JOIN placement l ON l.part_id = p.id \
    WHERE p.name = ?5 UNION SELECT l.build_id FROM part p CROSS JOIN placement l ON l.part_id = p.id \
    WHERE p.order_name = ?5 AND p.order_name <> '')";

impl HistorySort {
    /// What is sorted by before the time, and whether the greatest comes first; what is not known comes last.
    fn order(self) -> Option<(&'static str, bool)> {
        match self {
            Self::Newest => None,
            Self::Height => Some(("coalesce(b.height_mm, 9e999)", false)),
            Self::Density => Some(("coalesce(b.density, -1)", true)),
            Self::Copies => Some(("coalesce(b.copies, -1)", true)),
            Self::Profile => Some(("b.profile", false)),
        }
    }
}
