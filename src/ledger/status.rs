//! Status: what waits, what is being nested and what was published last, per machine profile.

use std::collections::BTreeMap;

use jiff::{SignedDuration, Timestamp};
use schemars::JsonSchema;
use serde::Serialize;
use sqlx::{FromRow, SqliteConnection};

use super::{BuildId, BuildState, Ledger, Utc, error::Result};

/// So long a refused part can be retried, and counts as refused.
pub const REFUSED_COUNTS: SignedDuration = SignedDuration::from_hours(30 * 24);

/// A machine profile as it stands. Profiles about which the ledger knows nothing have none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct ProfileStatus {
    /// Its name.
    pub profile: String,
    /// Claimed parts that are not read yet.
    pub claimed_parts: u32,
    /// Parts with a copy that waits.
    pub waiting_parts: u32,
    /// Copies that wait.
    pub waiting_copies: u32,
    /// Parts that were refused in the last 30 days ([`REFUSED_COUNTS`]) and nobody has taken back; cancelled ones do not count.
    pub rejected_parts: u32,
    /// When the oldest waiting part was claimed.
    pub oldest_at: Option<Utc>,
    /// The nearest due date of the waiting parts.
    pub due_at: Option<Utc>,
    /// What is due then: the order, else the file; "" = nothing is.
    pub due_of: String,
    /// The open build.
    pub open: Option<OpenBuild>,
    /// Builds that are being nested or published.
    pub nesting: Vec<NestingBuild>,
    /// Who has paused it.
    pub paused: Option<Paused>,
    /// The build that was published last.
    pub last_published: Option<PublishedBuild>,
}

/// The forecast of the next build.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow, JsonSchema)]
pub struct OpenBuild {
    /// Its number.
    pub build: BuildId,
    /// Height of its layout so far, mm.
    pub height_mm: Option<f64>,
    /// Density of its layout so far, 0..1.
    pub density: Option<f64>,
    /// Copies in its layout so far.
    pub copies: Option<u32>,
}

/// A build that has fired and is not published.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow, JsonSchema)]
pub struct NestingBuild {
    /// Its number.
    pub build: BuildId,
    /// Nesting or verified.
    pub state: BuildState,
    /// Copies taken into it.
    pub copies: u32,
    /// Trigger.
    pub fired_by: String,
    /// How often nesting was begun.
    pub attempts: u32,
    /// When it fired.
    pub nesting_at: Option<Utc>,
}

/// A pause.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow, JsonSchema)]
pub struct Paused {
    /// user@host.
    pub paused_by: String,
    /// When.
    pub paused_at: Utc,
}

/// A build in the queue.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow, JsonSchema)]
pub struct PublishedBuild {
    /// Its number.
    pub build: BuildId,
    /// When it came into the queue.
    pub published_at: Utc,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Density, 0..1.
    pub density: Option<f64>,
    /// Placements.
    pub copies: Option<u32>,
    /// Name of the build file.
    pub file_name: Option<String>,
}

/// A row of one aspect with the profile that it is of.
#[derive(FromRow)]
struct Of<T> {
    profile: String,
    #[sqlx(flatten)]
    row: T,
}

/// The parts of a profile, counted.
#[derive(FromRow)]
struct Counts {
    claimed_parts: u32,
    waiting_parts: u32,
    waiting_copies: u32,
    oldest_at: Option<Utc>,
    due_at: Option<Utc>,
}

/// What is due first.
#[derive(FromRow)]
struct Due {
    due_of: String,
}

const COUNTS: &str = "SELECT p.profile, sum(p.state = 'claimed') AS claimed_parts, \
    sum(p.state = 'waiting') AS waiting_parts, \
    sum(CASE p.state WHEN 'waiting' THEN p.copies - (SELECT count(*) FROM placement l WHERE l.part_id = p.id) \
    ELSE 0 END) AS waiting_copies, \
    min(CASE p.state WHEN 'waiting' THEN p.claimed_at END) AS oldest_at, \
    min(CASE p.state WHEN 'waiting' THEN p.due_at END) AS due_at FROM part p \
    WHERE p.state IN ('claimed', 'waiting') GROUP BY p.profile";

/// Over the years many are rejected: those count that can still be retried, and that nobody has cancelled.
const REJECTED: &str = "SELECT p.profile, count(*) AS parts FROM part p WHERE p.state = 'rejected' AND p.state_at >= ? \
    AND coalesce((SELECT e.cause FROM event e WHERE e.part_id = p.id AND e.kind = 'rejected' ORDER BY e.id DESC LIMIT 1), '') \
    <> 'cancelled' GROUP BY p.profile";

/// Of each profile the part that is due first; SQLite takes the other columns from the row of the least.
const DUE: &str = "SELECT profile, CASE order_name WHEN '' THEN name ELSE 'order ' || order_name END AS due_of, \
    min(due_at) AS at FROM part WHERE state = 'waiting' AND due_at IS NOT NULL GROUP BY profile";

const OPEN: &str = "SELECT profile, id AS build, height_mm, density, copies FROM build WHERE state = 'open'";

const NESTING: &str = "SELECT profile, id AS build, state, coalesce(copies, 0) AS copies, fired_by, attempts, nesting_at \
    FROM build WHERE state IN ('nesting', 'verified') ORDER BY id";

/// The newest published build of each profile: from one profile to the next in the index, then to its newest row, so that
/// the others are not looked at.
const LAST: &str = "WITH RECURSIVE machine (profile) AS (\
    SELECT min(profile) FROM build WHERE state NOT IN ('open', 'nesting') UNION ALL \
    SELECT (SELECT min(b.profile) FROM build b WHERE b.profile > machine.profile \
    AND b.state NOT IN ('open', 'nesting')) FROM machine \
    WHERE machine.profile IS NOT NULL) \
    SELECT b.profile, b.id AS build, b.published_at, b.height_mm, b.density, b.copies, b.file_name FROM machine \
    JOIN build b ON b.id = (SELECT n.id FROM build n WHERE n.profile = machine.profile \
    AND n.state NOT IN ('open', 'nesting') AND n.published_at IS NOT NULL \
    ORDER BY coalesce(n.published_at, n.state_at) DESC, n.id DESC LIMIT 1)";

impl Ledger {
    /// What was refused before does not count any more.
    pub(super) fn refused_since(&self) -> Utc {
        Utc(self.now().checked_sub(REFUSED_COUNTS).unwrap_or(Timestamp::MIN))
    }

    /// Every profile of which the ledger knows something, by name.
    pub async fn status(&self) -> Result<Vec<ProfileStatus>> {
        let mut snapshot = self.snapshot().await?;
        let db = &mut *snapshot;
        let mut profiles = BTreeMap::new();
        for Of { profile, row } in all::<Counts>(db, COUNTS).await? {
            let counted = ProfileStatus {
                claimed_parts: row.claimed_parts,
                waiting_parts: row.waiting_parts,
                waiting_copies: row.waiting_copies,
                oldest_at: row.oldest_at,
                due_at: row.due_at,
                ..of(&mut profiles, &profile).clone()
            };
            profiles.insert(profile, counted);
        }
        let rejected =
            sqlx::query_as::<_, (String, u32)>(REJECTED).bind(self.refused_since()).fetch_all(&mut *db).await?;
        for (profile, parts) in rejected {
            of(&mut profiles, &profile).rejected_parts = parts;
        }
        for Of { profile, row } in all::<Due>(db, DUE).await? {
            of(&mut profiles, &profile).due_of = row.due_of;
        }
        for Of { profile, row } in all::<OpenBuild>(db, OPEN).await? {
            let status = of(&mut profiles, &profile);
            // A layout of more copies than wait is of parts that were taken out since: a forecast of nothing.
            let is_of_now = row.copies.unwrap_or(0) <= status.waiting_copies;
            status.open = Some(match is_of_now {
                true => row,
                false => OpenBuild { height_mm: None, density: None, copies: None, ..row },
            });
        }
        for Of { profile, row } in all(db, NESTING).await? {
            of(&mut profiles, &profile).nesting.push(row);
        }
        for Of { profile, row } in all(db, "SELECT * FROM pause").await? {
            of(&mut profiles, &profile).paused = Some(row);
        }
        for Of { profile, row } in all(db, LAST).await? {
            of(&mut profiles, &profile).last_published = Some(row);
        }
        Ok(profiles.into_values().collect())
    }
}

async fn all<T>(db: &mut SqliteConnection, query: &'static str) -> Result<Vec<Of<T>>>
where
    T: for<'r> FromRow<'r, sqlx::sqlite::SqliteRow> + Send + Unpin,
{
    Ok(sqlx::query_as(query).fetch_all(db).await?)
}

/// The status of a profile, entered when it is new.
fn of<'a>(profiles: &'a mut BTreeMap<String, ProfileStatus>, profile: &str) -> &'a mut ProfileStatus {
    let fresh = || ProfileStatus { profile: profile.to_owned(), ..ProfileStatus::default() };
    profiles.entry(profile.to_owned()).or_insert_with(fresh)
}
