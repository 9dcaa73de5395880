//! Final searches that are cut into lanes, so that several nodes search for one build. A lane is one descent with a seed and a budget of
//! evaluations of its own: whoever searches it finds the same, so a lane whose node is gone is searched again by another one. What a
//! lane starts from and what it finds are text to the ledger.

use std::fmt;

use crate::ledger::{
    BuildId, Ledger,
    base::{
        error::Result,
        sql::{self, FromSqlRow, SqlRow, SqlTransaction, sql_row},
    },
};

/// A lane that was taken this often without an end is not taken again: it may be what ends the nodes.
const MAX_LANE_ATTEMPTS: i64 = 4;

/// One round of one lane of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneId {
    /// The build that is searched for.
    pub build: BuildId,
    /// Number of the search. A build that is searched for anew has another one.
    pub search: i64,
    /// The round, from 0.
    pub round: u32,
    /// The lane, from 0.
    pub lane: u32,
}

impl fmt::Display for LaneId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "lane {} of build {}, round {}", self.lane + 1, self.build, self.round + 1)
    }
}

/// A final search in lanes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaneSearchRow {
    /// Its number.
    pub id: i64,
    /// What is searched.
    pub problem: String,
    /// How it is cut into lanes and rounds.
    pub plan: String,
}

sql_row!(LaneSearchRow { id, problem, plan });

/// How far a search in lanes is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaneProgress {
    /// Its last round, from 0.
    pub round: u32,
    /// Lanes of all rounds that have a result.
    pub ended: u32,
    /// Lanes of all rounds that have none.
    pub open: u32,
}

sql_row!(LaneProgress { round, ended, open });

/// One round of one lane.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaneRow {
    /// The round, from 0.
    pub round: u32,
    /// The lane, from 0.
    pub lane: u32,
    /// What it starts from.
    pub task: String,
    /// The node that has it; "" = none.
    pub node: String,
    /// What was found; `None` = nothing yet.
    pub result: Option<String>,
}

sql_row!(LaneRow { round, lane, task, node, result });

/// A lane that a node has taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TakenLane {
    /// Which one.
    pub id: LaneId,
    /// Of the several times that it was taken, this one.
    pub epoch: i64,
    /// What is searched.
    pub problem: String,
    /// What it starts from.
    pub task: String,
}

/// A lane without a result.
struct OpenLane {
    id: LaneId,
    node: String,
}

impl FromSqlRow for OpenLane {
    fn from_sql_row(row: &SqlRow) -> sqlx::Result<Self> {
        let (build, search) = (row.column("build_id")?, row.column("search_id")?);
        let id = LaneId { build, search, round: row.column("round")?, lane: row.column("lane")? };
        Ok(Self { id, node: row.column("node")? })
    }
}

impl Ledger {
    /// Begins the search for a build in lanes, in place of an earlier one of the same build. Returns its number.
    pub async fn begin_lane_search(&self, build: BuildId, problem: &str, plan: &str, tasks: &[String]) -> Result<i64> {
        let search = rand::random_range(1..i64::MAX);
        let mut change = self.begin_change().await?;
        sql::query("DELETE FROM lane_search WHERE build_id = $1").bind(build).execute(change.db()).await?;
        let begin = sql::query("INSERT INTO lane_search (id, build_id, problem, plan) VALUES ($1, $2, $3, $4)");
        begin.bind(search).bind(build).bind(problem).bind(plan).execute(change.db()).await?;
        add_tasks(change.db(), search, 0, tasks).await?;
        change.commit().await?;
        Ok(search)
    }

    /// The search for a build in lanes; `None` = there is none.
    pub async fn find_lane_search(&self, build: BuildId) -> Result<Option<LaneSearchRow>> {
        let query = sql::query_as("SELECT id, problem, plan FROM lane_search WHERE build_id = $1").bind(build);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Adds the lanes of a further round. Nothing happens if they are there.
    pub async fn add_lane_round(&self, search: i64, round: u32, tasks: &[String]) -> Result<()> {
        let mut change = self.begin_change().await?;
        add_tasks(change.db(), search, round, tasks).await?;
        change.commit().await
    }

    /// How far a search is; `None` = it has ended.
    pub async fn lane_progress(&self, search: i64) -> Result<Option<LaneProgress>> {
        let query = sql::query_as(
            "SELECT max(round) AS round, count(result) AS ended, count(*) - count(result) AS open FROM lane \
             WHERE search_id = $1 GROUP BY search_id",
        );
        Ok(query.bind(search).fetch_optional(self.reader()?).await?)
    }

    /// All lanes of a search, by round and lane.
    pub async fn list_lanes(&self, search: i64) -> Result<Vec<LaneRow>> {
        let query =
            sql::query_as("SELECT round, lane, task, node, result FROM lane WHERE search_id = $1 ORDER BY round, lane");
        Ok(query.bind(search).fetch_all(self.reader()?).await?)
    }

    /// Numbers of the searches in lanes that go on.
    pub async fn searches_in_lanes(&self) -> Result<Vec<i64>> {
        Ok(sql::query_scalar("SELECT id FROM lane_search ORDER BY id").fetch_all(self.reader()?).await?)
    }

    /// Takes a lane that no live node has. `searched` are those that this node has and searches; one that it had before it was started
    /// again is taken again. Searches that are in `refused` are none for this node. `None` = there is none.
    pub async fn take_lane(&self, node: &str, searched: &[LaneId], refused: &[i64]) -> Result<Option<TakenLane>> {
        let open = "SELECT s.build_id, l.search_id, l.round, l.lane, l.node FROM lane_search s \
                    JOIN lane l ON l.search_id = s.id WHERE l.result IS NULL AND l.epoch < $1 \
                    ORDER BY s.build_id, l.round, l.lane";
        let open = || sql::query_as::<OpenLane>(open).bind(MAX_LANE_ATTEMPTS);
        let find_free = |lanes: Vec<OpenLane>, live: &[String]| {
            let is_free = |lane: &OpenLane| {
                let is_held = if lane.node == node { searched.contains(&lane.id) } else { live.contains(&lane.node) };
                !is_held && !refused.contains(&lane.id.search)
            };
            lanes.into_iter().find(is_free).map(|lane| lane.id)
        };
        // Without the lock of all changes first: mostly there is nothing to take.
        let lanes = open().fetch_all(self.reader()?).await?;
        if lanes.is_empty() {
            return Ok(None);
        }
        let live = self.leased_rights().await?.map_or_else(Vec::new, |rights| rights.nodes);
        if find_free(lanes, &live).is_none() {
            return Ok(None);
        }
        let mut change = self.begin_change().await?;
        let Some(id) = find_free(open().fetch_all(change.db()).await?, &live) else { return Ok(None) };
        let take = sql::query(
            "UPDATE lane SET epoch = epoch + 1, node = $1 WHERE search_id = $2 AND round = $3 AND lane = $4",
        );
        take.bind(node).bind(id.search).bind(id.round).bind(id.lane).execute(change.db()).await?;
        let taken = sql::query_as::<(i64, String, String)>(
            "SELECT l.epoch, s.problem, l.task FROM lane_search s JOIN lane l ON l.search_id = s.id \
             WHERE s.id = $1 AND l.round = $2 AND l.lane = $3",
        );
        let taken = taken.bind(id.search).bind(id.round).bind(id.lane);
        let (epoch, problem, task) = taken.fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(Some(TakenLane { id, epoch, problem, task }))
    }

    /// Records what was found in a lane. `false` = it was taken by another node meanwhile, or its search has ended.
    pub async fn end_lane(&self, id: LaneId, epoch: i64, result: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let end = sql::query(
            "UPDATE lane SET result = $1, node = '' \
             WHERE search_id = $2 AND round = $3 AND lane = $4 AND epoch = $5 AND result IS NULL",
        );
        let end = end.bind(result).bind(id.search).bind(id.round).bind(id.lane).bind(epoch);
        let ended = end.execute(change.db()).await?;
        change.commit().await?;
        Ok(ended > 0)
    }

    /// Gives a lane back that this node cannot search, for another one.
    pub async fn give_lane_back(&self, id: LaneId, epoch: i64) -> Result<()> {
        let mut change = self.begin_change().await?;
        let give =
            sql::query("UPDATE lane SET node = '' WHERE search_id = $1 AND round = $2 AND lane = $3 AND epoch = $4");
        give.bind(id.search).bind(id.round).bind(id.lane).bind(epoch).execute(change.db()).await?;
        change.commit().await
    }

    /// Ends the search for a build in lanes. What is still searched is for nothing.
    pub async fn end_lane_search(&self, build: BuildId) -> Result<()> {
        let mut change = self.begin_change().await?;
        sql::query("DELETE FROM lane_search WHERE build_id = $1").bind(build).execute(change.db()).await?;
        change.commit().await
    }
}

async fn add_tasks(db: &mut SqlTransaction, search: i64, round: u32, tasks: &[String]) -> Result<()> {
    for (lane, task) in tasks.iter().enumerate() {
        let add = sql::query(
            "INSERT INTO lane (search_id, round, lane, task) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING",
        );
        add.bind(search).bind(round).bind(lane as i64).bind(task).execute(&mut *db).await?;
    }
    Ok(())
}
