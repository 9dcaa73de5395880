//! Which published build nestd itself takes back out of the queue: the newest one, where the next build is better with its copies. From
//! there on, it is a word like that of a person (`take_back`).

use anyhow::Result;
use ledger::{BuildState, LedgerError, OccupyingBuild, OperatorWord, WITHDRAWN_BY_NESTD};
use settings::WithdrawalPolicy;
use tracing::info;

use crate::{
    core::{desks::Shared, machine_state::MachineStates, state::CompletionState},
    decisions::{
        printer_choice::printer_loads,
        withdrawal_decision::{WithdrawalFacts, decide_withdrawal},
    },
    operate::operate::operate,
    planning::{Occupation, awaits_release, read_occupation},
};

/// Withdraws the newest build in the queue of a machine where the settings say so, for what has arrived since.
pub(crate) async fn consider_withdrawal(
    shared: &Shared<'_>,
    machines: &MachineStates,
    completion: &CompletionState,
    name: &str,
) -> Result<()> {
    let Some(machine) = machines.get(name) else { return Ok(()) };
    if machine.profile.printing.withdraw == WithdrawalPolicy::Never || !shared.schedule.clock.is_date_trusted() {
        return Ok(());
    }
    let Some(queued) = shared.ledger.newest_queued(name, 1).await?.pop() else { return Ok(()) };
    let Some(build) = shared.ledger.find_build(queued.build).await? else { return Ok(()) };
    // Of another material than what is loaded now, its copies would only wait.
    let is_other = build.material != shared.ledger.loaded_material(name).await?;
    if is_other || !shared.ledger.second_files(build.id).await?.is_empty() {
        return Ok(());
    }
    let taken_back = shared.ledger.builds_to_take_back(name).await?;
    let is_ending = taken_back.iter().any(|build| build.place.withdraw_by.is_some())
        || shared.ledger.withdrawn_for_open(name).await?.is_some();
    let mut waiting = shared.ledger.waiting_copies(name).await?;
    waiting.retain(|waiting| !completion.deferred_refusals.contains_key(&waiting.part.id));
    let now = shared.date();
    let Occupation { builds, times, .. } = read_occupation(shared.ledger, &machine.profile, now).await?;
    let waits_for_yes = shared.ledger.builds_in_state(BuildState::Verified).await?;
    let waits_for_yes =
        |id| waits_for_yes.iter().any(|build| build.id == id && awaits_release(&machine.profile, build));
    let is_made = |other: &OccupyingBuild| {
        matches!(other.state, BuildState::Nesting | BuildState::Verified) && !waits_for_yes(other.build)
    };
    let is_making = builds.iter().any(is_made);
    let others: Vec<_> = builds.into_iter().filter(|other| other.build != build.id).collect();
    let loads = printer_loads(&machine.profile, &others, &times, now);
    let open = &machine.open;
    let is_of_now = open.search.is_none() && !open.tried.is_empty();
    let facts = WithdrawalFacts {
        fired_at: build.times.nesting_at.or(build.times.published_at).map_or(now, |at| at.0),
        height_mm: build.measures.height_mm.unwrap_or(0.0),
        printer_free_at: loads.get(&queued.printer).map_or(now, |load| load.free_at),
        open_height_mm: open.layout.height_mm,
        standing: is_of_now.then_some(&open.standing),
        waiting: &waiting,
        is_hindered: machine.paused || machine.printers.are_all_down() || is_making || is_ending,
    };
    if let Some(why) = decide_withdrawal(&machine.profile, &facts, now) {
        let word = OperatorWord::Withdraw(build.id, why.to_owned());
        match operate(shared.ledger, shared.settings, &word, WITHDRAWN_BY_NESTD, false).await {
            // Its printer was first, or its file lies there under another name, which is told.
            Err(LedgerError::InQueue(_) | LedgerError::NotInQueue(_)) => {}
            said => {
                said?;
                info!(build.id = %build.id, machine = %name, "Build {} is taken back out of the queue: {why}.", build.id);
            }
        }
    }
    Ok(())
}
