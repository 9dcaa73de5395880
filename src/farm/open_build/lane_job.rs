//! The lanes that this node searches, for builds of any node of the farm. A node without machines does nothing else.

use std::{
    sync::{Arc, PoisonError},
    time::Duration,
};

use anyhow::{Result, ensure};
use jobs::BackgroundJob;
use nester::{LaneTask, NestingConfig, NestingInstance, PreparedMeshes, SearchBudget, run_lane};
use tracing::{debug, info, warn};

use super::batch::ImproveLayoutJob;
use crate::{
    farm::{
        core::{
            farm::Farm,
            state::{NestingState, RunningFinalSearch},
        },
        nesting::{
            lane_problem::{LaneProblem, SharedLaneProblem, mesh_files},
            lane_search::LaneResult,
            node_content::{OtherNodes, remove_unneeded},
        },
        process::cpu_meter::CpuMeter,
    },
    intake::ContentStore,
    ledger::{LaneId, TakenLane},
    settings::Settings,
};

/// How long the meshes of a search are kept: the same parts are often nested again.
const KEEP_MESHES: Duration = Duration::from_secs(86_400);

/// Searches a lane.
#[derive(Clone)]
pub(crate) struct LaneJob {
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
                farm.nesting.untold_lanes.insert(self.id, (self.epoch, found));
                tell_results(farm).await
            }
            Err(failure) => self.give_back(farm, &format!("{failure:#}")).await,
        }
    }

    async fn on_panic(self, farm: &mut Farm, message: &str) -> Result<()> {
        self.give_back(farm, message).await
    }

    fn on_not_started(self, farm: &mut Farm, _why: &str) {
        farm.nesting.lanes.remove(&self.id);
        farm.nesting.refused_searches.push(self.id.search);
    }
}

impl LaneJob {
    /// Another node may be able to search it.
    async fn give_back(self, farm: &mut Farm, why: &str) -> Result<()> {
        let budget = farm.nesting.lanes.remove(&self.id);
        if budget.is_none_or(|budget| !budget.is_cancelled()) {
            warn!("This node cannot search {}, and leaves the lanes of that build to others: {why}.", self.id);
            farm.nesting.refused_searches.push(self.id.search);
        }
        Ok(farm.ledger.give_lane_back(self.id, self.epoch).await?)
    }
}

/// Tells the ledger what was found. If that cannot be reached, it is told later.
async fn tell_results(farm: &mut Farm) -> Result<()> {
    let untold: Vec<LaneId> = farm.nesting.untold_lanes.keys().copied().collect();
    for id in untold {
        let (epoch, found) = &farm.nesting.untold_lanes[&id];
        if !farm.ledger.end_lane(id, *epoch, found).await? {
            debug!("What was found in {id} is not needed any more.");
        }
        farm.nesting.untold_lanes.remove(&id);
        farm.nesting.lanes.remove(&id);
    }
    Ok(())
}

/// Number of lanes that this node offers the farm now: none while its threads work for its own builds.
pub(crate) fn offered_lanes(farm: &Farm) -> usize {
    if farm.ledger.file().is_some() || is_searching_alone(farm) { 0 } else { farm.settings.node.lanes }
}

/// Takes as many lanes as this node can search besides its own builds, and ends those whose search has ended.
pub(crate) async fn search_lanes(farm: &mut Farm) -> Result<()> {
    if farm.ledger.file().is_some() || farm.settings.node.lanes == 0 {
        return Ok(());
    }
    tell_results(farm).await?;
    let NestingState { lanes, refused_searches, .. } = &mut farm.nesting;
    if !(lanes.is_empty() && refused_searches.is_empty()) {
        let searched = farm.ledger.searches_in_lanes().await?;
        refused_searches.retain(|search| searched.contains(search));
        let ended = lanes.iter().filter(|(id, _)| !searched.contains(&id.search));
        ended.for_each(|(_, budget)| budget.cancel());
    }
    while farm.nesting.lanes.len() < offered_lanes(farm) {
        let NestingState { lanes, refused_searches, .. } = &farm.nesting;
        let searched: Vec<LaneId> = lanes.keys().copied().collect();
        let taken = farm.ledger.take_lane(&farm.settings.node.name, &searched, refused_searches).await?;
        let Some(taken) = taken else { break };
        start_lane(farm, taken).await?;
    }
    if farm.nesting.lanes.is_empty() {
        // Its meshes take memory.
        *farm.nesting.lane_problem.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
    Ok(())
}

/// Whether this node has a part in a search in lanes, whose meshes are then needed.
pub(crate) fn needs_meshes(farm: &Farm) -> bool {
    let NestingState { lanes, final_searches, .. } = &farm.nesting;
    !lanes.is_empty() || final_searches.values().any(RunningFinalSearch::is_in_lanes)
}

/// Removes meshes of searches that ended long ago, and the oldest beyond the size of a cache.
pub(crate) fn forget_old_meshes(settings: &Settings) {
    let files = mesh_files(&settings.state_dir);
    if let Err(failure) = remove_unneeded(&files, KEEP_MESHES, settings.resources.cache_bytes, |_| false) {
        warn!("Meshes of ended searches could not be removed: {failure:#}.");
    }
}

/// Whether this node's threads work for its own builds. Those for an open build give way to the lanes of a fired one.
fn is_searching_alone(farm: &Farm) -> bool {
    let finals = &farm.nesting.final_searches;
    match finals.is_empty() {
        true => farm.jobs.running_subjects::<ImproveLayoutJob>().next().is_some(),
        false => !finals.values().all(RunningFinalSearch::is_in_lanes),
    }
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
    let meter = CpuMeter::begin(budget, f64::INFINITY);
    let end = run_lane(instance, config, prepared, task, &meter);
    ensure!(!budget.is_cancelled(), "its search has ended");
    Ok(serde_json::to_string(&LaneResult { end, cpu_secs: meter.spent_secs() })?)
}
