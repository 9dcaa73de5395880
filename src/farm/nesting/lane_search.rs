//! The final search for a build on several nodes: its owner cuts it into lanes, which all nodes search, itself included, and takes the
//! best of them. Lanes and what they found are rows of the ledger: after a restart, the search goes on where it was.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use anyhow::{Context, Result, ensure};
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
    ledger::{BuildId, LaneProgress, LaneRow, Ledger, NodeRow},
    settings::Settings,
};

/// A search that is shorter than this is not worth the way to other nodes.
const SHORTEST_SECS: f64 = 5.0;
/// Share of the time for the first layouts, which the owner makes alone.
const FIRST_SHARE: f64 = 0.15;
/// Share of the time after which the owner knows how many evaluations a lane makes in a second.
const TRIAL_SHARE: f64 = 0.2;
/// Share of the time that is left for the lanes; the rest is for their way.
const LANE_SHARE: f64 = 0.9;
/// A search that takes longer than its time by this share ends with what its lanes have found.
const OVERTIME_SHARE: f64 = 0.5;
/// While no lane has ended, the owner waits for this share of the time.
const GIVE_UP_SHARE: f64 = 0.6;
/// From the end of a round until all nodes search the next one, seconds.
const ROUND_DELAY_SECS: f64 = 0.7;
/// Most lanes of a search.
const MAX_LANES: u32 = 64;
/// Share of the evaluations of a lane for the criteria that count after the height.
const FINISH_SHARE: f64 = 0.02;
/// Interval at which the owner looks for the ends of lanes.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// What a lane has found.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct LaneResult {
    /// The layout.
    pub(crate) end: LaneEnd,
    /// What it took, CPU seconds.
    pub(crate) cpu_secs: f64,
}

/// The final search for a build on several nodes.
pub(crate) struct LaneSearch {
    ledger: Ledger,
    runtime: Handle,
    build: BuildId,
    files: ContentStore,
    /// Number of lanes.
    lanes: u32,
    is_in_lanes: Arc<AtomicBool>,
}

/// What is searched, and from where.
pub(crate) struct NestingProblem<'a> {
    pub(crate) instance: &'a NestingInstance,
    pub(crate) config: &'a NestingConfig,
    pub(crate) prepared: &'a PreparedMeshes,
    /// An earlier layout to continue from.
    pub(crate) start: &'a [ItemPlacement],
    /// What ends the searches of this thread: the budget, which counts their CPU time.
    pub(crate) stop: &'a dyn StopCondition,
}

/// What a search on several nodes has found.
pub(crate) struct LaneSearchEnd {
    pub(crate) solution: NestingSolution,
    /// What lanes on all nodes took, CPU seconds.
    pub(super) lane_cpu_secs: f64,
}

/// A budget of which only a share may be used.
struct BudgetShare<'a> {
    stop: &'a dyn StopCondition,
    until: f64,
}

impl StopCondition for BudgetShare<'_> {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        self.stop.spent_share_at(evaluations) / self.until
    }
}

impl LaneSearch {
    /// The search for a build of this node that takes `secs`; `None` = this node searches alone: the other nodes that run and have the same
    /// version offer too few lanes to be better than its own threads, they cannot reach it, or the published method is asked for.
    /// `is_in_lanes` tells while it is made in lanes.
    pub(crate) async fn for_build(
        ledger: &Ledger,
        settings: &Settings,
        build: BuildId,
        (config, secs): (&NestingConfig, f64),
        is_in_lanes: &Arc<AtomicBool>,
    ) -> Option<Self> {
        let is_reached = settings.node.address.is_some() && settings.interfaces.web.is_some();
        if ledger.file().is_some() || !is_reached || secs < SHORTEST_SECS || config.method != NestingMethod::Nestd {
            return None;
        }
        let nodes = ledger.list_nodes().await;
        let nodes = nodes.inspect_err(|error| warn!("This node searches alone for build {build}: {error}.")).ok()?;
        let is_other =
            |row: &&NodeRow| row.name != settings.node.name && row.alive && row.version == env!("CARGO_PKG_VERSION");
        let others: u32 = nodes.iter().filter(is_other).map(|row| row.lanes).sum();
        let lanes = u32::try_from(settings.node.lanes).unwrap_or(MAX_LANES).saturating_add(others).min(MAX_LANES);
        if others == 0 || lanes as usize <= config.thread_count() {
            return None;
        }
        Some(Self {
            ledger: ledger.clone(),
            runtime: Handle::current(),
            build,
            files: mesh_files(&settings.state_dir),
            lanes,
            is_in_lanes: is_in_lanes.clone(),
        })
    }

    /// Searches until all rounds have ended or the time is over. Where the other nodes are of no use, this node goes on alone.
    ///
    /// # Errors
    /// The budget was cancelled: the next start goes on with the search.
    pub(crate) fn run(
        &self,
        problem: &NestingProblem<'_>,
        budget: &SearchBudget,
        listener: &mut dyn ProgressListener,
    ) -> Result<LaneSearchEnd> {
        let mut known = problem.start.to_vec();
        let together = self.search_together(problem, budget, &mut known, listener);
        self.is_in_lanes.store(false, Ordering::Relaxed);
        ensure!(!budget.is_cancelled(), "the search was stopped");
        match together {
            Ok(Some(found)) => return Ok(found),
            Ok(None) => {}
            Err(failure) => {
                warn!(build.id = %self.build, "The search for build {} goes on without other nodes: {failure:#}.", self.build);
            }
        }
        let NestingProblem { instance, config, prepared, stop, .. } = *problem;
        let solution = nest_with_cache(instance, config, &known, prepared, stop, listener);
        Ok(LaneSearchEnd { solution, lane_cpu_secs: 0.0 })
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
        let text = serde_json::to_string(&LaneProblem::describe(instance, config, &self.files)?)?;
        let times = SearchTimes::of_secs(budget.secs_left().unwrap_or(0.0));
        let begun = self.runtime.block_on(self.ledger.find_lane_search(self.build))?;
        let (search, plan) = match begun.filter(|row| row.problem == text) {
            Some(row) => {
                info!(build.id = %self.build, "The search for build {} goes on with its lanes.", self.build);
                (row.id, serde_json::from_str(&row.plan).context("reading the plan of its lanes")?)
            }
            None => match self.begin(problem, &text, budget, known, listener)? {
                Some(begun) => begun,
                None => return Ok(None),
            },
        };
        self.is_in_lanes.store(true, Ordering::Relaxed);
        let followed = self.runtime.block_on(self.follow_rounds(search, &plan, budget, &times, listener));
        let Some(found) = followed? else { return Ok(None) };
        let Some(best) = found.best.filter(|best| best.placements.len() == instance.copy_count()) else {
            return Ok(None);
        };
        let finish = SearchBudget::of_evaluations((plan.evaluations as f64 * FINISH_SHARE) as u64);
        let finished = finish_lanes(instance, config, prepared, &best.placements, &finish);
        if !finished.unplaced.is_empty() {
            return Ok(None);
        }
        let solution = NestingSolution { evaluations: found.evaluations, ..finished };
        Ok(Some(LaneSearchEnd { solution, lane_cpu_secs: found.cpu_secs }))
    }

    /// Makes first layouts, learns what a lane costs, and begins the search with as many evaluations as the time allows.
    fn begin(
        &self,
        problem: &NestingProblem<'_>,
        text: &str,
        budget: &SearchBudget,
        known: &mut Vec<ItemPlacement>,
        listener: &mut dyn ProgressListener,
    ) -> Result<Option<(i64, LanePlan)>> {
        let NestingProblem { instance, config, prepared, start, stop } = *problem;
        let share = |until: f64| BudgetShare { stop, until };
        let first = nest_with_cache(instance, config, start, prepared, &share(FIRST_SHARE), listener);
        *known = first.placements;
        if !first.unplaced.is_empty() || budget.spent_share() >= 1.0 {
            return Ok(None);
        }
        let trial = LanePlan { lanes: 1, rounds: 1, evaluations: u64::MAX, seed: config.seed }.first_tasks(known);
        let began = Instant::now();
        let tried = run_lane(instance, config, prepared, &trial[0], &share(TRIAL_SHARE));
        let per_second = tried.evaluations as f64 / began.elapsed().as_secs_f64().max(1e-3);
        let lane_secs =
            budget.secs_left().unwrap_or(0.0) * LANE_SHARE - f64::from(LanePlan::USUAL_ROUNDS) * ROUND_DELAY_SECS;
        let evaluations = (per_second * lane_secs.max(0.0)) as u64;
        if evaluations == 0 || tried.placements.len() < known.len() {
            return Ok(None);
        }
        *known = tried.placements;
        let plan = LanePlan { lanes: self.lanes, rounds: LanePlan::USUAL_ROUNDS, evaluations, seed: config.seed };
        let (written, tasks) = (serde_json::to_string(&plan)?, written_tasks(&plan.first_tasks(known))?);
        let begun = self.ledger.begin_lane_search(self.build, text, &written, &tasks);
        let search = self.runtime.block_on(begun)?;
        info!(build.id = %self.build, lanes = plan.lanes, evaluations, "Build {} is searched in {} lanes.", self.build, plan.lanes);
        Ok(Some((search, plan)))
    }

    /// Waits for the lanes of each round, and begins the next one. `None` = no lane ends, and it is better to go on alone.
    async fn follow_rounds(
        &self,
        search: i64,
        plan: &LanePlan,
        budget: &SearchBudget,
        times: &SearchTimes,
        listener: &mut dyn ProgressListener,
    ) -> Result<Option<LanesFound>> {
        loop {
            // Where the ledger cannot be reached, what the nodes have found is not lost: they tell it when they reach it again.
            let looked = self.begin_next_round(search, plan, listener).await;
            let now = Instant::now();
            match looked {
                Ok(None) => break,
                Ok(Some(progress)) if progress.ended == 0 && now >= times.give_up_at => {
                    warn!(build.id = %self.build, "No node has searched a lane of build {} in time.", self.build);
                    self.ledger.end_lane_search(self.build).await?;
                    return Ok(None);
                }
                Err(failure) if now >= times.deadline => return Err(failure),
                Ok(Some(_)) if now >= times.deadline => {
                    info!(build.id = %self.build, "Not all lanes of build {} have ended in time: what they have found is taken.", self.build);
                    break;
                }
                Ok(Some(_)) | Err(_) => {}
            }
            if budget.is_cancelled() {
                return Ok(None);
            }
            tokio::time::sleep(POLL_INTERVAL).await;
        }
        Ok(Some(LanesFound::read(&self.ledger.list_lanes(search).await?)?))
    }

    /// Begins the next round where all lanes of one have ended. Returns how far the search is; `None` = it has ended.
    async fn begin_next_round(
        &self,
        search: i64,
        plan: &LanePlan,
        listener: &mut dyn ProgressListener,
    ) -> Result<Option<LaneProgress>> {
        let Some(progress) = self.ledger.lane_progress(search).await? else { return Ok(None) };
        if progress.open > 0 {
            return Ok(Some(progress));
        }
        let rows = self.ledger.list_lanes(search).await?;
        LanesFound::read(&rows)?.report(listener);
        let of_round = rows.iter().filter(|row| row.round == progress.round).filter_map(read_result);
        let ends: Vec<LaneEnd> = of_round.map(|found| Ok(found?.end)).collect::<Result<_>>()?;
        let tasks = plan.next_tasks(progress.round, &ends);
        if tasks.is_empty() {
            return Ok(None);
        }
        self.ledger.add_lane_round(search, progress.round + 1, &written_tasks(&tasks)?).await?;
        Ok(Some(progress))
    }
}

/// When the owner of a search gives up waiting.
struct SearchTimes {
    /// While no lane has ended, it waits until then.
    give_up_at: Instant,
    /// Then it takes what there is.
    deadline: Instant,
}

impl SearchTimes {
    /// Of a search that has so many seconds from now.
    fn of_secs(secs: f64) -> Self {
        let after = |share: f64| Instant::now() + Duration::from_secs_f64(secs * share);
        Self { give_up_at: after(GIVE_UP_SHARE), deadline: after(1.0 + OVERTIME_SHARE) }
    }
}

/// What the lanes have found so far.
struct LanesFound {
    /// The best of all rounds; `None` = no lane has ended.
    best: Option<LaneEnd>,
    evaluations: u64,
    cpu_secs: f64,
}

impl LanesFound {
    fn read(rows: &[LaneRow]) -> Result<Self> {
        let results: Vec<LaneResult> = rows.iter().filter_map(read_result).collect::<Result<_>>()?;
        let cpu_secs = results.iter().map(|result| result.cpu_secs).sum();
        let ends: Vec<LaneEnd> = results.into_iter().map(|result| result.end).collect();
        let evaluations = ends.iter().map(|end| end.evaluations).sum();
        Ok(Self { best: LanePlan::best_end(&ends).cloned(), evaluations, cpu_secs })
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
