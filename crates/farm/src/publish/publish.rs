//! The step "published": moves each verified build into the queue in steps. The ledger records the progress, so that
//! work continues where a crash interrupted it.

use anyhow::Result;
use delivery::queue::{PublishOutcome, QueueError};
use jobs::BackgroundJob;
use ledger::{BuildId, BuildRow, BuildState, PartState};
use tracing::{info, warn};

use super::staged_build::{PublishStep, QueueReplacedError, StagedBuild, check_record_of_away};
use crate::{
    alerts::alert::AlertKind,
    core::{desks::Building, farm::Farm, machine_state::MachineState, state::NestingState},
    decisions::publish_decision::{PublishDecision, PublishFacts, decide_publishing},
    planning::awaits_release,
    printers::{printers, queues},
    receive::forget,
    records::forgettable::Forgettable,
    scanning::machine_fit::find_misfit,
};

/// Takes a verified build one step further into the queue.
#[derive(Clone)]
pub(crate) struct PublishBuildJob {
    build: BuildId,
}

impl BackgroundJob<Farm> for PublishBuildJob {
    const KIND: &'static str = "Publish";
    type Outcome = Result<PublishStep>;
    type Desk<'f> = Building<'f>;

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, step: Self::Outcome) -> Result<()> {
        on_publish_step(&mut desk, self.build, step).await
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_publish_step(&mut desk, self.build, Err(anyhow::anyhow!("panicked: {message}"))).await
    }

    fn on_not_started(self, desk: Self::Desk<'_>, _why: &str) {
        desk.nesting.backoff.record_failure(self.build);
    }
}

/// Whether a build failed recently and waits for a retry.
pub(crate) fn is_build_resting(nesting: &NestingState, build: BuildId) -> bool {
    nesting.backoff.is_waiting(&build)
}

/// Takes every verified build one step further into the queue: check it, record in the ledger that it will be
/// tried, compare it with what was proved, and rename it.
pub(crate) async fn publish_verified_builds(desk: &mut Building<'_>) -> Result<()> {
    for build in desk.shared.ledger.builds_in_state(BuildState::Verified).await? {
        let id = build.id;
        // The alert on a machine that is not configured covers this.
        let Some(machine) = desk.machines.get(&build.machine) else { continue };
        let printer = machine.printers.of_build(&build);
        let misfit = find_misfit(&machine.profile, &build);
        let decision = decide_publishing(&publish_facts(desk, machine, &build, misfit.is_some()));
        if decision == PublishDecision::MakeForAnother {
            start_remake_check(desk, build);
            continue;
        }
        let (PublishDecision::Check | PublishDecision::Rename, Some(queue)) =
            (decision, printer.and_then(|printer| printer.opened.clone()))
        else {
            continue;
        };
        let archive = machine.profile.folders.archive.clone();
        let (record, is_first) =
            (desk.shared.ledger.export_build_record(id).await?, desk.nesting.rename_untried.remove(&id));
        let (leases, ledger) = (machine.leases.clone(), desk.shared.ledger.clone());
        let staged = StagedBuild { queue, build, misfit, archive, leases, ledger };
        desk.jobs.start(PublishBuildJob { build: id }, move || match staged.check_folders() {
            Err(away) if is_first => Ok(PublishStep::NotRenamed(away.into())),
            Err(away) => Err(away.into()),
            Ok(()) if decision == PublishDecision::Rename => staged.try_publish(&record, is_first),
            Ok(()) => staged.check_before_publishing(),
        });
    }
    Ok(())
}

/// What is known of a verified build and its machine.
fn publish_facts(desk: &Building<'_>, machine: &MachineState, build: &BuildRow, is_misfit: bool) -> PublishFacts {
    let printer = machine.printers.of_build(build);
    let is_printer_down = printer.is_some_and(|printer| printer.down.is_some());
    let is_agreed = match (&machine.agreed_folders, printer) {
        (Some(agreed), Some(printer)) => printer.opened.is_none() || agreed.has_queue(&printer.address),
        (agreed, _) => agreed.is_some(),
    };
    PublishFacts {
        is_resting: is_build_resting(desk.nesting, build.id),
        is_running: desk.jobs.is_running::<PublishBuildJob>(build.id),
        is_machine_served: is_agreed && machine.leases.are_fresh(),
        is_queue_open: printer.is_some_and(|printer| printer.opened.is_some()),
        is_printer_down,
        has_better_printer: is_printer_down && !printers::usable_printers(machine).is_empty(),
        awaits_release: awaits_release(&machine.profile, build),
        is_recorded: build.staged.publishing_at.is_some(),
        is_misfit,
    }
}

/// Starts a job that looks whether a build whose printer is down was certainly never published: a restored ledger may have
/// forgotten that it was.
fn start_remake_check(desk: &mut Building<'_>, build: BuildRow) {
    let Some(machine) = desk.machines.get(&build.machine) else { return };
    let queue = machine.printers.of_build(&build).and_then(|printer| printer.opened.clone());
    let (archive, leases) = (machine.profile.folders.archive.clone(), machine.leases.clone());
    let (id, ledger) = (build.id, desk.shared.ledger.clone());
    desk.jobs.start(PublishBuildJob { build: id }, move || match queue {
        None => check_record_of_away(&archive, &build, &leases),
        Some(queue) => {
            let staged = StagedBuild { queue, build, misfit: None, archive, leases, ledger };
            staged.check_folders()?;
            staged.check_before_remaking()
        }
    });
}

/// verified -> nesting: its printer went down before anything was published.
async fn make_for_another_printer(desk: &mut Building<'_>, build: &BuildRow) -> Result<()> {
    let printer = build.place.printer.as_deref().unwrap_or(&build.machine);
    info!(build.id = %build.id, machine = %build.machine, "Build {} is made for another printer: {printer} is down.", build.id);
    queues::discard_staged(desk.machines, desk.jobs, build);
    desk.shared.ledger.reopen_verified_build(build.id, &format!("the printer {printer} is down")).await?;
    // No attempt has failed.
    desk.nesting.just_fired.insert(build.id);
    Ok(())
}

/// Commits the result of a build's step into the queue.
async fn on_publish_step(desk: &mut Building<'_>, id: BuildId, step: Result<PublishStep>) -> Result<()> {
    match step {
        Ok(PublishStep::Ready) => {
            desk.shared.ledger.begin_publishing(id).await?;
            desk.nesting.rename_untried.insert(id);
            publish_verified_builds(desk).await
        }
        Ok(PublishStep::Done(published)) => on_build_published(desk, id, published).await,
        Ok(PublishStep::MadeAgain(why)) => {
            warn!(build.id = %id, "Build {id} is made again: {why}.");
            desk.nesting.backoff.record_failure(id);
            Ok(desk.shared.ledger.reopen_verified_build(id, &format!("made again: {why}")).await?)
        }
        Ok(PublishStep::NeverPublished) => match desk.shared.ledger.find_build(id).await? {
            Some(build) => make_for_another_printer(desk, &build).await,
            None => Ok(()),
        },
        Ok(PublishStep::NotRenamed(failure)) => {
            desk.shared.ledger.cancel_publishing(id).await?;
            report_publish_failure(desk, id, &failure).await
        }
        Err(failure) => report_publish_failure(desk, id, &failure).await,
    }
}

async fn report_publish_failure(desk: &mut Building<'_>, id: BuildId, failure: &anyhow::Error) -> Result<()> {
    desk.nesting.backoff.record_failure(id);
    let machine = desk.shared.ledger.find_build(id).await?.map(|b| b.machine).unwrap_or_default();
    let about = format!("build {id}");
    let kind = match failure.downcast_ref::<QueueError>() {
        Some(QueueError::NameTaken(_)) => Some(AlertKind::QueueAltered),
        _ => failure.is::<QueueReplacedError>().then_some(AlertKind::QueueReplaced),
    };
    match kind {
        Some(kind) => desk.shared.alerts.raise(kind, &machine, &about, &format!("{about}: {failure}")),
        None => desk.shared.report_failure(AlertKind::PublishingFails, &machine, &about, failure),
    }
    Ok(())
}

async fn on_build_published(desk: &mut Building<'_>, id: BuildId, published: PublishOutcome) -> Result<()> {
    desk.shared.ledger.publish_build(id).await?;
    desk.nesting.backoff.record_success(&id);
    let Some(build) = desk.shared.ledger.find_build(id).await? else { return Ok(()) };
    for kind in [AlertKind::QueueReplaced, AlertKind::QueueAltered, AlertKind::PublishingFails] {
        desk.shared.alerts.clear(kind, &build.machine, &format!("build {id}"));
    }
    let height_mm = (build.measures.height_mm.unwrap_or_default() * 1000.0).round() / 1000.0;
    match published {
        PublishOutcome::PublishedNow => {
            info!(build.id = %id, machine = %build.machine, height_mm, "Published build {id} of {}: {height_mm} mm.", build.machine)
        }
        PublishOutcome::AlreadyPublished => {
            warn!(build.id = %id, "Build {id} had been published before a crash; nothing was done twice.")
        }
    }
    remove_built_from_store(desk, &build).await
}

/// The store's copies of parts that are built are needed no more: the archive has them.
async fn remove_built_from_store(desk: &mut Building<'_>, build: &BuildRow) -> Result<()> {
    let mut unneeded = Vec::new();
    for part in desk.shared.ledger.parts_of_build(build.id).await? {
        unneeded.push(Forgettable::StoredFile(part.file.content_hash.clone()));
        if desk.shared.ledger.parts_of_claim(&part.file.claim).await?.iter().all(|p| p.state == PartState::Built) {
            // Where the file is kept for another claim, a note of this one would have it printed again.
            unneeded.push(Forgettable::ClaimNote { hash: part.file.content_hash, claim: part.file.claim });
        }
    }
    forget::forget_data(&mut desk.storing(), unneeded).await
}
