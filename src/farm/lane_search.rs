//! The final search for a build on several nodes: its owner cuts it into lanes, which all nodes search, itself included, and takes the
//! best of them. Lanes and what they found are rows of the ledger: after a restart, the search goes on where it was.

use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use nester::{
    ItemPlacement, LaneEnd, LanePlan, LaneTask, NestingConfig, NestingInstance, NestingMethod, NestingSolution,
    PreparedMeshes, ProgressListener, SearchBudget, StopCondition, finish_lanes, nest_with_cache, run_lane,
};
use serde::{Deserialize, Serialize};
use tokio::runtime::Handle;
use tracing::{info, warn};

use super::lane_problem::{LaneProblem, mesh_files};
use crate::{
    intake::ContentStore,
    ledger::{BuildId, LaneRow, LaneSearchRow, Ledger, NodeRow},
    settings::Settings,
};

/// A search that is shorter than this is not worth the way to other nodes.
const SHORTEST_SECS: f64 = 2.0;
/// Share of the time for the first layouts, which the owner makes alone.
const FIRST_SHARE: f64 = 0.15;
/// Share of the time after which the owner knows how many evaluations a lane makes in a second.
const TRIAL_SHARE: f64 = 0.2;
/// Share of the time that is left for the lanes; the rest is for their way.
const LANE_SHARE: f64 = 0.9;
/// A search that takes longer than its time by this share ends with what its lanes have found.
const OVERTIME_SHARE: f64 = 0.5;
/// Number of rounds, after each of which the better half of the lanes goes on.
const ROUNDS: u32 = 4;
/// Most lanes of a search.
const MAX_LANES: u32 = 64;
/// Share of the evaluations of a lane for the criteria that count after the height.
const FINISH_SHARE: f64 = 0.02;
/// Interval at which the owner looks for the ends of lanes.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// What a lane has found.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct LaneResult {
    /// The layout.
    pub(super) end: LaneEnd,
    /// What it took, CPU seconds.
    pub(super) cpu_secs: f64,
}

/// The final search for a build on several nodes.
pub(super) struct LaneSearch {
    ledger: Ledger,
    runtime: Handle,
    build: BuildId,
    files: ContentStore,
    /// Number of lanes.
    lanes: u32,
}

/// What is searched, and from where.
pub(super) struct NestingProblem<'a> {
    pub(super) instance: &'a NestingInstance,
    pub(super) config: &'a NestingConfig,
    pub(super) prepared: &'a PreparedMeshes,
    /// An earlier layout to continue from.
    pub(super) start: &'a [ItemPlacement],
}

/// What a search on several nodes has found.
pub(super) struct LaneSearchEnd {
    pub(super) solution: NestingSolution,
    /// What lanes on all nodes took, CPU seconds.
    pub(super) lane_cpu_secs: f64,
}

/// A budget of which only a share may be used.
struct BudgetShare<'a> {
    budget: &'a SearchBudget,
    until: f64,
}

impl StopCondition for BudgetShare<'_> {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        self.budget.spent_share_at(evaluations) / self.until
    }
}

impl LaneSearch {
    /// The search for a build of this farm that takes `secs`; `None` = this node searches alone: no other one that runs offers lanes, or the
    /// published method is asked for.
    pub(super) async fn for_build(
        ledger: &Ledger,
        settings: &Settings,
        build: BuildId,
        (method, secs): (NestingMethod, f64),
    ) -> Result<Option<Self>> {
        if ledger.file().is_some() || secs < SHORTEST_SECS || method != NestingMethod::Nestd {
            return Ok(None);
        }
        let nodes = ledger.list_nodes().await?;
        let offered = |row: &NodeRow| if row.alive { row.lanes } else { 0 };
        let own = &settings.node.name;
        if !nodes.iter().any(|row| row.name != *own && offered(row) > 0) {
            return Ok(None);
        }
        Ok(Some(Self {
            ledger: ledger.clone(),
            runtime: Handle::current(),
            build,
            files: mesh_files(&settings.state_dir),
            lanes: nodes.iter().map(offered).sum::<u32>().min(MAX_LANES),
        }))
    }

    /// Searches until all rounds have ended, the time is over, or the budget is cancelled. Where the other nodes are of no use, this node
    /// goes on alone.
    pub(super) fn run(
        &self,
        problem: &NestingProblem<'_>,
        budget: &SearchBudget,
        listener: &mut dyn ProgressListener,
    ) -> LaneSearchEnd {
        let mut known = problem.start.to_vec();
        match self.search_together(problem, budget, &mut known, listener) {
            Ok(Some(found)) => return found,
            Ok(None) => {}
            Err(failure) => {
                warn!(build.id = %self.build, "The search for build {} goes on without other nodes: {failure:#}.", self.build);
            }
        }
        let NestingProblem { instance, config, prepared, .. } = *problem;
        let solution = nest_with_cache(instance, config, &known, prepared, budget, listener);
        LaneSearchEnd { solution, lane_cpu_secs: 0.0 }
    }

    /// `None` = it is better to go on alone, from `known`: not all copies have a place, or the budget is used up.
    fn search_together(
        &self,
        problem: &NestingProblem<'_>,
        budget: &SearchBudget,
        known: &mut Vec<ItemPlacement>,
        listener: &mut dyn ProgressListener,
    ) -> Result<Option<LaneSearchEnd>> {
        let NestingProblem { instance, config, prepared, .. } = *problem;
        let deadline =
            Instant::now() + Duration::from_secs_f64(budget.secs_left().unwrap_or(0.0) * (1.0 + OVERTIME_SHARE));
        let text = serde_json::to_string(&LaneProblem::describe(instance, config, &self.files)?)?;
        let begun = self.runtime.block_on(self.ledger.find_lane_search(self.build))?;
        let plan = match begun.filter(|row| row.problem == text) {
            Some(row) => serde_json::from_str(&row.plan).context("reading the plan of its lanes")?,
            None => match self.begin(problem, text, budget, known, listener)? {
                Some(plan) => plan,
                None => return Ok(None),
            },
        };
        let found = self.runtime.block_on(self.follow_rounds(&plan, budget, deadline, listener))?;
        let Some(best) = found.best else { return Ok(None) };
        let finish = SearchBudget::of_evaluations((plan.evaluations as f64 * FINISH_SHARE) as u64);
        let finished = finish_lanes(instance, config, prepared, &best.placements, &finish);
        let solution = NestingSolution { evaluations: found.evaluations, ..finished };
        Ok(Some(LaneSearchEnd { solution, lane_cpu_secs: found.cpu_secs }))
    }

    /// Makes first layouts, learns what a lane costs, and begins the search with as many evaluations as the time allows.
    fn begin(
        &self,
        problem: &NestingProblem<'_>,
        text: String,
        budget: &SearchBudget,
        known: &mut Vec<ItemPlacement>,
        listener: &mut dyn ProgressListener,
    ) -> Result<Option<LanePlan>> {
        let NestingProblem { instance, config, prepared, start } = *problem;
        let share = |until: f64| BudgetShare { budget, until };
        let first = nest_with_cache(instance, config, start, prepared, &share(FIRST_SHARE), listener);
        *known = first.placements;
        if !first.unplaced.is_empty() || budget.spent_share() >= 1.0 {
            return Ok(None);
        }
        let trial = LaneTask { round: 1, lane: 0, seed: config.seed, evaluations: u64::MAX, start: known.clone() };
        let began = Instant::now();
        let tried = run_lane(instance, config, prepared, &trial, &share(TRIAL_SHARE));
        let per_second = tried.evaluations as f64 / began.elapsed().as_secs_f64().max(1e-3);
        let evaluations = (per_second * budget.secs_left().unwrap_or(0.0) * LANE_SHARE) as u64;
        if evaluations == 0 || tried.placements.len() < known.len() {
            return Ok(None);
        }
        *known = tried.placements;
        let plan = LanePlan { lanes: self.lanes, rounds: ROUNDS, evaluations, seed: config.seed };
        let search = LaneSearchRow { problem: text, plan: serde_json::to_string(&plan)? };
        let tasks = written_tasks(&plan.first_tasks(known))?;
        self.runtime.block_on(self.ledger.begin_lane_search(self.build, &search, &tasks))?;
        info!(build.id = %self.build, lanes = plan.lanes, evaluations, "Build {} is searched in {} lanes.", self.build, plan.lanes);
        Ok(Some(plan))
    }

    /// Waits for the lanes of each round, and begins the next one.
    async fn follow_rounds(
        &self,
        plan: &LanePlan,
        budget: &SearchBudget,
        deadline: Instant,
        listener: &mut dyn ProgressListener,
    ) -> Result<LanesFound> {
        loop {
            // Where the ledger cannot be reached, what the nodes have found is not lost: they tell it when they reach it again.
            let looked = self.begin_next_round(plan, listener).await;
            if matches!(looked, Ok(true)) || budget.is_cancelled() {
                break;
            }
            if Instant::now() >= deadline {
                looked?;
                info!(build.id = %self.build, "Not all lanes of build {} have ended in time: what they have found is taken.", self.build);
                break;
            }
            tokio::time::sleep(POLL_INTERVAL).await;
        }
        LanesFound::read(&self.ledger.list_lanes(self.build).await?)
    }

    /// Begins the next round where all lanes of one have ended. Returns whether the search has ended.
    async fn begin_next_round(&self, plan: &LanePlan, listener: &mut dyn ProgressListener) -> Result<bool> {
        let Some((round, open)) = self.ledger.lane_progress(self.build).await? else { return Ok(true) };
        if open > 0 {
            return Ok(false);
        }
        let rows = self.ledger.list_lanes(self.build).await?;
        LanesFound::read(&rows)?.report(listener);
        let of_round = rows.iter().filter(|row| row.round == round).filter_map(read_result);
        let ends: Vec<LaneEnd> = of_round.map(|found| Ok(found?.end)).collect::<Result<_>>()?;
        let tasks = plan.next_tasks(round, &ends);
        if !tasks.is_empty() {
            self.ledger.add_lane_round(self.build, round + 1, &written_tasks(&tasks)?).await?;
        }
        Ok(tasks.is_empty())
    }
}

/// What the lanes have found so far.
#[derive(Default)]
struct LanesFound {
    /// The best of all rounds; `None` = no lane has ended.
    best: Option<LaneEnd>,
    evaluations: u64,
    cpu_secs: f64,
}

impl LanesFound {
    fn read(rows: &[LaneRow]) -> Result<Self> {
        let mut found = Self::default();
        for result in rows.iter().filter_map(read_result) {
            let LaneResult { end, cpu_secs } = result?;
            found.evaluations += end.evaluations;
            found.cpu_secs += cpu_secs;
            let ends: Vec<LaneEnd> = found.best.take().into_iter().chain([end]).collect();
            found.best = LanePlan::best_end(&ends).cloned();
        }
        Ok(found)
    }

    /// Tells of the best layout.
    fn report(&self, listener: &mut dyn ProgressListener) {
        if let Some(best) = &self.best {
            let (placements, height_mm, evaluations) = (best.placements.clone(), best.height_mm, self.evaluations);
            let solution = NestingSolution { placements, unplaced: Vec::new(), height_mm, evaluations };
            listener.on_improved(&solution, evaluations);
        }
    }
}

/// What was found in a lane; `None` = nothing yet.
fn read_result(row: &LaneRow) -> Option<Result<LaneResult>> {
    let read = serde_json::from_str(row.result.as_ref()?);
    Some(read.with_context(|| format!("reading what lane {} of round {} has found", row.lane + 1, row.round + 1)))
}

fn written_tasks(tasks: &[LaneTask]) -> Result<Vec<String>> {
    Ok(tasks.iter().map(serde_json::to_string).collect::<Result<_, _>>()?)
}
