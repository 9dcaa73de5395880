//! Final searches that are cut into lanes, so that several nodes search for one build. A lane is one descent with a seed and a budget of
//! evaluations of its own: whoever searches it finds the same, so a lane whose node is gone is searched again by another one. What a
//! lane starts from and what it finds are text to the ledger.

use std::fmt;

use super::{
    BuildId, BuildState, Ledger,
    error::Result,
    sql::{self, SqlTransaction, sql_row},
};

/// A lane that was taken this often without an end is not taken again: it may be what ends the nodes.
const MAX_LANE_ATTEMPTS: i64 = 4;

/// One round of one lane of the search for a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneId {
    /// The build.
    pub build: BuildId,
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
    /// What is searched.
    pub problem: String,
    /// How it is cut into lanes and rounds.
    pub plan: String,
}

sql_row!(LaneSearchRow { problem, plan });

/// One round of one lane.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaneRow {
    /// The round, from 0.
    pub round: u32,
    /// The lane, from 0.
    pub lane: u32,
    /// What it starts from.
    pub task: String,
    /// How often it was taken.
    pub epoch: i64,
    /// The node that has it; "" = none.
    pub node: String,
    /// What was found; `None` = nothing yet.
    pub result: Option<String>,
}

sql_row!(LaneRow { round, lane, task, epoch, node, result });

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

impl Ledger {
    /// Begins the search for a build in lanes, in place of an earlier one of the same build. Searches of builds that are not nested any
    /// more go.
    pub async fn begin_lane_search(&self, build: BuildId, search: &LaneSearchRow, tasks: &[String]) -> Result<()> {
        let mut change = self.begin_change().await?;
        let forget = sql::query(
            "DELETE FROM lane_search WHERE build_id = $1 OR NOT EXISTS \
             (SELECT 1 FROM build WHERE build.id = lane_search.build_id AND build.state = $2)",
        );
        forget.bind(build).bind(BuildState::Nesting).execute(change.db()).await?;
        let begin = sql::query("INSERT INTO lane_search (build_id, problem, plan) VALUES ($1, $2, $3)");
        begin.bind(build).bind(&search.problem).bind(&search.plan).execute(change.db()).await?;
        add_tasks(change.db(), build, 0, tasks).await?;
        change.commit().await
    }

    /// The search for a build in lanes; `None` = there is none.
    pub async fn find_lane_search(&self, build: BuildId) -> Result<Option<LaneSearchRow>> {
        let query = sql::query_as("SELECT problem, plan FROM lane_search WHERE build_id = $1").bind(build);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Adds the lanes of a further round. Nothing happens if they are there.
    pub async fn add_lane_round(&self, build: BuildId, round: u32, tasks: &[String]) -> Result<()> {
        let mut change = self.begin_change().await?;
        add_tasks(change.db(), build, round, tasks).await?;
        change.commit().await
    }

    /// The last round of the search for a build, and how many of all its lanes have no result; `None` = there is no search.
    pub async fn lane_progress(&self, build: BuildId) -> Result<Option<(u32, u32)>> {
        let query = sql::query_as(
            "SELECT max(round), count(*) - count(result) FROM lane WHERE build_id = $1 GROUP BY build_id",
        );
        Ok(query.bind(build).fetch_optional(self.reader()?).await?)
    }

    /// All lanes of the search for a build, by round and lane.
    pub async fn list_lanes(&self, build: BuildId) -> Result<Vec<LaneRow>> {
        let query = sql::query_as(
            "SELECT round, lane, task, epoch, node, result FROM lane WHERE build_id = $1 ORDER BY round, lane",
        );
        Ok(query.bind(build).fetch_all(self.reader()?).await?)
    }

    /// Builds that are searched for in lanes.
    pub async fn builds_in_lanes(&self) -> Result<Vec<BuildId>> {
        let query = sql::query_scalar("SELECT build_id FROM lane_search ORDER BY build_id");
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// Takes a lane that no live node has. `searched` are those that this node has and searches; one that it had before it was started
    /// again is taken again. `None` = there is none.
    pub async fn take_lane(&self, node: &str, searched: &[LaneId]) -> Result<Option<TakenLane>> {
        let open = "SELECT l.build_id, l.round, l.lane, l.node FROM lane_search s JOIN lane l ON l.build_id = s.build_id \
                    WHERE l.result IS NULL AND l.epoch < $1 ORDER BY l.build_id, l.round, l.lane";
        let open = || sql::query_as::<(BuildId, u32, u32, String)>(open).bind(MAX_LANE_ATTEMPTS);
        // Without the lock first: mostly there is nothing to take.
        if open().fetch_all(self.reader()?).await?.is_empty() {
            return Ok(None);
        }
        let live = self.leased_rights().await?.map(|rights| rights.nodes).unwrap_or_default();
        let mut change = self.begin_change().await?;
        let is_free = |(build, round, lane, holder): &(BuildId, u32, u32, String)| {
            let id = LaneId { build: *build, round: *round, lane: *lane };
            if holder == node { !searched.contains(&id) } else { !live.contains(holder) }
        };
        let found = open().fetch_all(change.db()).await?.into_iter().find(is_free);
        let Some((build, round, lane, _)) = found else { return Ok(None) };
        let take =
            sql::query("UPDATE lane SET epoch = epoch + 1, node = $1 WHERE build_id = $2 AND round = $3 AND lane = $4");
        take.bind(node).bind(build).bind(round).bind(lane).execute(change.db()).await?;
        let taken = sql::query_as::<(i64, String, String)>(
            "SELECT l.epoch, s.problem, l.task FROM lane_search s JOIN lane l ON l.build_id = s.build_id \
             WHERE l.build_id = $1 AND l.round = $2 AND l.lane = $3",
        );
        let (epoch, problem, task) = taken.bind(build).bind(round).bind(lane).fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(Some(TakenLane { id: LaneId { build, round, lane }, epoch, problem, task }))
    }

    /// Records what was found in a lane. `false` = it was taken by another node meanwhile, or its search has ended.
    pub async fn end_lane(&self, id: LaneId, epoch: i64, result: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let end = sql::query(
            "UPDATE lane SET result = $1, node = '' \
             WHERE build_id = $2 AND round = $3 AND lane = $4 AND epoch = $5 AND result IS NULL",
        );
        let end = end.bind(result).bind(id.build).bind(id.round).bind(id.lane).bind(epoch);
        let ended = end.execute(change.db()).await?;
        change.commit().await?;
        Ok(ended > 0)
    }

    /// Gives a lane back that this node cannot search, for another one.
    pub async fn give_lane_back(&self, id: LaneId, epoch: i64) -> Result<()> {
        let mut change = self.begin_change().await?;
        let give =
            sql::query("UPDATE lane SET node = '' WHERE build_id = $1 AND round = $2 AND lane = $3 AND epoch = $4");
        give.bind(id.build).bind(id.round).bind(id.lane).bind(epoch).execute(change.db()).await?;
        change.commit().await
    }

    /// Ends the search for a build in lanes. What is still searched is for nothing.
    pub async fn end_lane_search(&self, build: BuildId) -> Result<()> {
        let mut change = self.begin_change().await?;
        sql::query("DELETE FROM lane_search WHERE build_id = $1").bind(build).execute(change.db()).await?;
        change.commit().await
    }
}

async fn add_tasks(db: &mut SqlTransaction, build: BuildId, round: u32, tasks: &[String]) -> Result<()> {
    for (lane, task) in tasks.iter().enumerate() {
        let add =
            sql::query("INSERT INTO lane (build_id, round, lane, task) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING");
        add.bind(build).bind(round).bind(lane as i64).bind(task).execute(&mut *db).await?;
    }
    Ok(())
}
