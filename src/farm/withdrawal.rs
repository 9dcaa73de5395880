//! Published builds that are taken back out of the queue, because a person says so or because the next build is better with their
//! copies. `ledger/withdrawal` says in which steps, and `queue/withdrawal` how the file is taken back.

use anyhow::{Context, Result};
use tracing::info;

use super::{
    alert::AlertKind,
    build_move::queue_with_marker,
    farm::Farm,
    folder_leases::FolderLeases,
    jobs::BackgroundJob,
    printer_choice::printer_loads,
    printers::occupation_of,
    withdrawal_decision::{WithdrawalFacts, decide_withdrawal},
};
use crate::{
    ledger::{BuildId, BuildRow, BuildState, Ledger, WITHDRAWN_BY_NESTD, WithdrawalEnd},
    queue::{QueueFolder, WithdrawalOutcome},
    settings::WithdrawalPolicy,
};

/// Takes the file of a build one step further out of the queue.
#[derive(Clone)]
pub(super) struct WithdrawBuildJob {
    build: BuildId,
}

/// How far the file has come.
#[derive(Debug)]
pub(super) enum WithdrawalStep {
    /// Its printer took it before it was taken back.
    Taken,
    /// It is under a dot-name: its copies are to wait again.
    TakenBack,
    /// It is in the queue folder no more.
    Removed,
}

impl BackgroundJob<Farm> for WithdrawBuildJob {
    const KIND: &'static str = "Withdraw";
    type Outcome = Result<WithdrawalStep>;

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, farm: &mut Farm, step: Self::Outcome) -> Result<()> {
        on_withdrawal_step(farm, self.build, step).await
    }

    async fn on_panic(self, farm: &mut Farm, message: &str) -> Result<()> {
        on_withdrawal_step(farm, self.build, Err(anyhow::anyhow!("panicked: {message}"))).await
    }
}

/// A build that is taken back.
struct WithdrawnBuild {
    build: BuildRow,
    queue: QueueFolder,
    leases: FolderLeases,
    ledger: Ledger,
}

impl WithdrawnBuild {
    /// The next step, from what the ledger has recorded.
    fn go_on(&self) -> Result<WithdrawalStep> {
        self.ledger.ensure_served()?;
        self.leases.check_publish_folders(self.queue.folder_path())?;
        let name = self.build.staged.file_name.as_deref().context("its row names no file")?;
        if self.build.state != BuildState::Published {
            // Somebody told that it failed before the file was taken back: its copies wait, and must not be printed from it.
            if self.build.state == BuildState::Failed {
                self.queue.withdraw(name)?;
            }
            self.queue.remove_withdrawn(name)?;
            return Ok(WithdrawalStep::Removed);
        }
        Ok(match self.queue.withdraw(name)? {
            WithdrawalOutcome::Gone => WithdrawalStep::Taken,
            WithdrawalOutcome::TakenBack => WithdrawalStep::TakenBack,
        })
    }
}

/// Takes every build further that is being withdrawn.
pub(super) async fn withdraw_builds(farm: &mut Farm) -> Result<()> {
    let names: Vec<String> = farm.machines.keys().cloned().collect();
    for name in names {
        for build in farm.ledger.builds_to_withdraw(&name).await? {
            let machine = &farm.machines[&name];
            let is_served = machine.agreed_folders.is_some() && machine.leases.are_fresh();
            let queue = queue_with_marker(machine, build.staged.queue_id.as_deref());
            let (true, Some(queue)) = (is_served && !farm.nesting.backoff.is_waiting(&build.id), queue) else {
                continue;
            };
            let (id, leases, ledger) = (build.id, machine.leases.clone(), farm.ledger.clone());
            let withdrawn = WithdrawnBuild { build, queue, leases, ledger };
            farm.jobs.start(WithdrawBuildJob { build: id }, move || withdrawn.go_on());
        }
    }
    Ok(())
}

/// Commits a step of a withdrawal.
async fn on_withdrawal_step(farm: &mut Farm, id: BuildId, step: Result<WithdrawalStep>) -> Result<()> {
    let Some(build) = farm.ledger.find_build(id).await? else { return Ok(()) };
    let profile = build.profile.clone();
    match step {
        Ok(WithdrawalStep::TakenBack) => {
            // It must be there to fire at once.
            farm.ledger.open_build(&profile).await?;
            if let Some(report) = farm.ledger.finish_withdrawal(id).await? {
                let told = report.sentences().join(" ");
                info!(build.id = %id, profile = %profile, "Build {id} was taken back out of the queue. {told}");
            }
            return withdraw_builds(farm).await;
        }
        Ok(WithdrawalStep::Taken) => {
            farm.ledger.end_withdrawal(id, WithdrawalEnd::Taken).await?;
            info!(build.id = %id, profile = %profile, "Build {id} stays: its printer took it.");
        }
        Ok(WithdrawalStep::Removed) => farm.ledger.end_withdrawal(id, WithdrawalEnd::Removed).await?,
        Err(failure) => {
            farm.nesting.backoff.record_failure(id);
            farm.report_failure(AlertKind::PublishingFails, &profile, &format!("build {id}"), &failure);
            return Ok(());
        }
    }
    farm.nesting.backoff.record_success(&id);
    farm.alerts.clear(AlertKind::PublishingFails, &profile, &format!("build {id}"));
    Ok(())
}

/// Withdraws the newest build in the queue of a machine where the settings say so, for what has arrived since.
pub(super) async fn consider_withdrawal(farm: &mut Farm, name: &str) -> Result<()> {
    let Some(machine) = farm.machines.get(name) else { return Ok(()) };
    if machine.profile.printing.withdraw == WithdrawalPolicy::Never || !farm.schedule.clock.is_date_trusted() {
        return Ok(());
    }
    let Some(queued) = farm.ledger.newest_queued(name, 1).await?.pop() else { return Ok(()) };
    let Some(build) = farm.ledger.find_build(queued.build).await? else { return Ok(()) };
    let Some(published_at) = build.times.published_at else { return Ok(()) };
    let waiting = farm.ledger.waiting_copies(name).await?;
    let now = farm.date();
    let (builds, times) = occupation_of(&farm.ledger, &machine.profile, now).await?;
    let is_making = builds.iter().any(|other| matches!(other.state, BuildState::Nesting | BuildState::Verified));
    let others: Vec<_> = builds.into_iter().filter(|other| other.build != build.id).collect();
    let loads = printer_loads(&machine.profile, &others, &times, now);
    let open = &machine.open;
    let facts = WithdrawalFacts {
        published_at: published_at.0,
        height_mm: build.measures.height_mm.unwrap_or(0.0),
        printer_free_at: loads.get(&queued.printer).map_or(now, |load| load.free_at),
        open_height_mm: (open.holds_all(&waiting)).then_some(open.layout.height_mm),
        waiting: &waiting,
        is_hindered: machine.paused || machine.printers.are_all_down() || is_making,
    };
    if let Some(why) = decide_withdrawal(&machine.profile, &facts, now) {
        farm.ledger.begin_withdrawal(build.id, WITHDRAWN_BY_NESTD, why).await?;
        info!(build.id = %build.id, profile = %name, "Build {} is taken back out of the queue: {why}.", build.id);
    }
    Ok(())
}
