//! Which printer the file of a published build is taken back for: its own went down before it took the file, or the move has begun.

use anyhow::{Context, Result, ensure};
use delivery::queue::OpenQueue;
use ledger::{BuildRow, BuildState, TakeBackEnd};

use super::taken_file::TakeBackTarget;
use crate::{
    core::{desks::Building, machine_state::MachineState},
    printers::printers::{choose_for_build, usable_printers},
    scanning::machine_fit::find_misfit,
};

/// A build between two printers: its row, the queue where it was published, and where it goes.
pub(super) type MovingBuild = (BuildRow, OpenQueue, TakeBackTarget);

/// Finds out where a build goes that moves, or lies at a printer that is down; `None` = nothing is done now. `source` = the queue where it
/// was published.
pub(super) async fn find_other_printer(
    desk: &mut Building<'_>,
    mut build: BuildRow,
    source: Option<OpenQueue>,
) -> Result<Option<MovingBuild>> {
    let machine = &desk.machines[&build.machine];
    let misfit = find_misfit(&machine.profile, &build);
    // What does not fit any more stays where it lies, and is told (`queue_files`).
    if build.place.move_to.is_none() && (source.is_none() || misfit.is_some()) {
        return Ok(None);
    }
    if source.is_none() {
        check_missing_source(machine, &build)?;
    }
    let open_queue = |machine: &MachineState, printer: &str| machine.printers.find(printer)?.opened.clone();
    let mut abandoned = None;
    let target = match (build.place.move_queue_id.clone(), build.place.move_to.clone()) {
        (Some(id), _) => machine.printers.queue_with_id(Some(&id)),
        // It is not wanted any more: what was taken back is removed.
        (None, Some(to)) if build.state != BuildState::Published => open_queue(machine, &to).or_else(|| source.clone()),
        (None, before) => {
            let Some(printer) = choose_for_build(desk.shared.ledger, desk.machines, &build, desk.shared.date()).await?
            else {
                ensure!(
                    before.is_none(),
                    "it was taken back from a printer that is down, and no printer of the machine can be given builds: \
                     `nestd printer NAME up`"
                );
                return Ok(None);
            };
            let machine = &desk.machines[&build.machine];
            let chosen = open_queue(machine, &printer);
            if let Some(before) = before.filter(|before| *before != printer) {
                abandoned = open_queue(machine, &before);
                desk.shared.ledger.begin_move(build.id, &printer).await?;
                build = desk.shared.ledger.find_build(build.id).await?.context("its row is gone")?;
            }
            chosen
        }
    };
    let Some(queue) = target else {
        if build.place.move_to.is_none() {
            return Ok(None);
        }
        ensure!(
            source.is_none(),
            "the queue folder that it goes to is not available; where its printer was removed from the machine's file, configure \
             that printer again: the file may be in its folder"
        );
        // Neither of the two printers is configured any more: nothing of it can be printed here.
        desk.shared.ledger.end_take_back(build.id, TakeBackEnd::Removed).await?;
        return Ok(None);
    };
    // Without a queue of origin, it is only removed from the other one.
    let source = source.unwrap_or_else(|| queue.clone());
    let usable = usable_printers(&desk.machines[&build.machine]).into_iter().map(str::to_owned).collect();
    Ok(Some((build, source, TakeBackTarget::Printer { queue, usable, abandoned, misfit })))
}

/// Fails unless a move can be ended without the queue where the build was published: if that is no printer's any more, and the outcome
/// was told.
fn check_missing_source(machine: &MachineState, build: &BuildRow) -> Result<()> {
    ensure!(machine.printers.are_all_open(), "the queue folder that it is taken from is not available");
    let id = build.id;
    ensure!(
        build.state != BuildState::Published,
        "its file was taken back in a queue folder that is no printer's any more: configure that printer again, or have its \
         parts printed again with `nestd outcome {id} failed`"
    );
    Ok(())
}
