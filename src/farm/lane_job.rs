//! The lanes that this node searches, for builds of any node of the farm. A node without machines does nothing else.

use std::{
    sync::{Arc, PoisonError},
    time::Duration,
};

use anyhow::{Result, ensure};
use nester::{LaneTask, NestingConfig, NestingInstance, PreparedMeshes, SearchBudget, run_lane};
use tracing::{debug, info, warn};

use super::{
    batch::ImproveLayoutJob,
    farm::Farm,
    jobs::BackgroundJob,
    lane_problem::{LaneProblem, SharedLaneProblem, mesh_files},
    lane_search::LaneResult,
    nesting_search::cpu_secs,
    node_content::{OtherNodes, remove_unneeded},
    state::NestingState,
};
use crate::{
    intake::ContentStore,
    ledger::{LaneId, TakenLane},
};

/// How long the meshes of a search are kept: the same parts are often nested again.
const KEEP_MESHES: Duration = Duration::from_secs(86_400);

/// Searches a lane.
#[derive(Clone)]
pub(super) struct LaneJob {
    id: LaneId,
    epoch: i64,
}

impl BackgroundJob<Farm> for LaneJob {
    const KIND: &'static str = "Lane";
    /// What was found, as the ledger keeps it.
    type Outcome = Result<String>;

    fn subject(&self) -> String {
        self.id.to_string()
    }

    async fn on_done(self, farm: &mut Farm, outcome: Self::Outcome) -> Result<()> {
        match outcome {
            Ok(found) => {
                farm.nesting.lanes.remove(&self.id);
                farm.nesting.lane_backoff.record_success(&self.id.build);
                if !farm.ledger.end_lane(self.id, self.epoch, &found).await? {
                    debug!("What was found in {} is not needed any more.", self.id);
                }
                Ok(())
            }
            Err(failure) => self.give_back(farm, &format!("{failure:#}")).await,
        }
    }

    async fn on_panic(self, farm: &mut Farm, message: &str) -> Result<()> {
        self.give_back(farm, message).await
    }

    fn on_not_started(self, farm: &mut Farm, _why: &str) {
        farm.nesting.lanes.remove(&self.id);
        farm.nesting.lane_backoff.record_failure(self.id.build);
    }
}

impl LaneJob {
    /// Another node may be able to search it.
    async fn give_back(self, farm: &mut Farm, why: &str) -> Result<()> {
        farm.nesting.lanes.remove(&self.id);
        if !farm.lifecycle.is_stopping {
            warn!("This node cannot search {}: {why}.", self.id);
            farm.nesting.lane_backoff.record_failure(self.id.build);
        }
        Ok(farm.ledger.give_lane_back(self.id, self.epoch).await?)
    }
}

/// Number of lanes that this node offers the farm.
pub(super) fn offered_lanes(farm: &Farm) -> usize {
    if farm.ledger.file().is_some() { 0 } else { farm.settings.node.lanes }
}

/// Takes as many lanes as this node can search besides its own builds, and ends those whose search has ended.
pub(super) async fn search_lanes(farm: &mut Farm) -> Result<()> {
    let offered = offered_lanes(farm);
    if offered == 0 {
        return Ok(());
    }
    if !farm.nesting.lanes.is_empty() {
        let searched = farm.ledger.builds_in_lanes().await?;
        let ended = farm.nesting.lanes.iter().filter(|(id, _)| !searched.contains(&id.build));
        ended.for_each(|(_, budget)| budget.cancel());
    }
    while farm.nesting.lanes.len() < offered && !is_searching_alone(farm) {
        let searched: Vec<LaneId> = farm.nesting.lanes.keys().copied().collect();
        let Some(taken) = farm.ledger.take_lane(&farm.settings.node.name, &searched).await? else { return Ok(()) };
        if farm.nesting.lane_backoff.is_waiting(&taken.id.build) {
            return Ok(farm.ledger.give_lane_back(taken.id, taken.epoch).await?);
        }
        start_lane(farm, taken).await?;
    }
    Ok(())
}

/// Removes meshes of searches that ended long ago, while this node has no part in any.
pub(super) fn forget_old_meshes(farm: &Farm) {
    let NestingState { lanes, final_searches, .. } = &farm.nesting;
    if farm.ledger.file().is_some() || !lanes.is_empty() || final_searches.values().any(|search| search.is_in_lanes) {
        return;
    }
    if let Err(failure) = remove_unneeded(&mesh_files(&farm.settings.state_dir), KEEP_MESHES, |_| false) {
        warn!("Meshes of ended searches could not be removed: {failure:#}.");
    }
}

/// Whether this node's threads work for its own builds.
fn is_searching_alone(farm: &Farm) -> bool {
    farm.jobs.running_subjects::<ImproveLayoutJob>().next().is_some()
        || farm.nesting.final_searches.values().any(|search| !search.is_in_lanes)
}

async fn start_lane(farm: &mut Farm, taken: TakenLane) -> Result<()> {
    let nodes = OtherNodes::of_ledger(&farm.settings, &farm.ledger).await?;
    let files = mesh_files(&farm.settings.state_dir);
    let (shared, prepared) = (farm.nesting.lane_problem.clone(), farm.meshes.prepared.clone());
    info!(build.id = %taken.id.build, "Searching {}.", taken.id);
    let budget = SearchBudget::until_cancelled();
    farm.nesting.lanes.insert(taken.id, budget.clone());
    farm.jobs.start(LaneJob { id: taken.id, epoch: taken.epoch }, move || {
        let problem = load_problem(&taken.problem, &shared, &files, &nodes)?;
        let task: LaneTask = serde_json::from_str(&taken.task)?;
        search_lane(&problem, &task, &prepared, &budget)
    });
    Ok(())
}

/// The search with its meshes. The lanes of a search wait for each other here, so that one of them fetches the meshes.
fn load_problem(
    text: &str,
    shared: &SharedLaneProblem,
    files: &ContentStore,
    nodes: &OtherNodes,
) -> Result<Arc<(NestingInstance, NestingConfig)>> {
    let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((known, problem)) = &*shared
        && known == text
    {
        return Ok(problem.clone());
    }
    let problem: LaneProblem = serde_json::from_str(text)?;
    let loaded = Arc::new(problem.load(files, |hash| {
        ensure!(nodes.fetch_into_store(files, hash)?, "no node that runs has the mesh {hash}");
        Ok(())
    })?);
    *shared = Some((text.to_owned(), loaded.clone()));
    Ok(loaded)
}

fn search_lane(
    (instance, config): &(NestingInstance, NestingConfig),
    task: &LaneTask,
    prepared: &PreparedMeshes,
    budget: &SearchBudget,
) -> Result<String> {
    let before = cpu_secs(true);
    let end = run_lane(instance, config, prepared, task, budget);
    ensure!(!budget.is_cancelled(), "its search has ended");
    Ok(serde_json::to_string(&LaneResult { end, cpu_secs: cpu_secs(true) - before })?)
}
