//! Claims of two farms: gives up the parts of claims that another farm has taken over, and leaves the claims of another
//! farm alone until a person adopts them.

use std::{collections::HashSet, io};

use anyhow::{Context, Result, bail};
use ledger::SharedFarm;
use settings::{MachineProfile, Settings};
use tracing::warn;

use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry},
    core::{desks::Batching, machine_state::MachineStates},
    leases::{
        folder_lease::{FolderLease, LeaseError},
        lease_holder::{FarmIdentity, LeaseHolder},
    },
    receive::{claim_completion, mark_note},
};

/// Takes over the claims of other farms in the hot folder of a machine; returns their number. Works with or without a
/// daemon; a running one finds them at its next tick.
///
/// # Errors
/// Another daemon serves the folder, this farm has never run, or the folder cannot be changed.
pub fn adopt_claims(settings: &Settings, profile: &MachineProfile) -> Result<usize> {
    let inbox = &profile.folders.inbox;
    if !LeaseHolder::has_farm_id(&settings.state_dir) {
        bail!("there is no farm in {} yet: start nestd once, then adopt", settings.state_dir.display());
    }
    let me = LeaseHolder::for_this_process(&settings.state_dir, jiff::Timestamp::now())
        .with_context(|| format!("reading the farm's number in {}", settings.state_dir.display()))?;
    let farm = me.farm_id().to_owned();
    let mut lease = FolderLease::new(me, inbox);
    loop {
        match lease.check_usable() {
            Ok(()) => break,
            // The other daemon may be dead: it takes a while to see that its number does not change.
            Err(LeaseError::HolderUnclear { .. }) => std::thread::sleep(std::time::Duration::from_millis(500)),
            Err(refused) => return Err(refused.into()),
        }
    }
    intake::adopt_claims(inbox, &farm).with_context(|| format!("taking over the claims in {}", inbox.display()))
}

/// Makes this farm the one that its ledger says, before it takes any file: the nodes of a shared ledger are one farm, and each of them
/// has the claims of the machines that it serves. Claims that this state folder made under another number, before it came to the ledger,
/// keep their farm; those in a folder that is away now are left to [`adopt_claims`].
pub(crate) fn join_farm(settings: &Settings, shared: Option<SharedFarm>) -> io::Result<()> {
    let known = FarmIdentity::read(&settings.state_dir)?;
    let Some(now) = FarmIdentity::of_ledger(known.clone(), shared) else { return Ok(()) };
    if known.as_ref() == Some(&now) {
        return Ok(());
    }
    for profile in settings.profiles.values() {
        let Some(known) = known.as_ref().filter(|known| known.id != now.id) else { break };
        if let Err(error) = intake::rename_claims(&profile.folders.inbox, &known.id, &now.id) {
            warn!(machine = %profile.name, "Claims of this nestd could not be renamed: {error}.");
        }
    }
    now.write_into(&settings.state_dir)
}

/// Fails if any claim of the batch is not released by this farm: another farm may take over a remaining claim, and a
/// claim that was taken over is printed by the other farm.
pub fn check_claims_released(profile: &MachineProfile, farm: &str, claims: &HashSet<String>) -> Result<(), LeaseError> {
    if claims.is_empty() {
        return Ok(());
    }
    let folder = profile.folders.inbox.clone();
    match intake::unreleased_claims(&folder, farm, claims) {
        Ok(left) if left.is_empty() => Ok(()),
        Ok(left) => Err(LeaseError::ClaimsNotReleased { folder, claims: left.len() }),
        Err(why) => Err(LeaseError::Io { folder, why }),
    }
}

/// Gives up the parts of claims that another farm has taken over, before anything else is done with them.
pub(super) async fn give_up_taken_over_claims(desk: &mut Batching<'_>, machine: &str, claims: &[String]) -> Result<()> {
    const REASON: &str = "Another nestd has taken over this file while this one did not answer, and prints it.";
    if claims.is_empty() {
        return Ok(());
    }
    for build in desk.shared.ledger.nesting_builds_of_claims(claims).await? {
        desk.nesting.searches.stop_for(build);
        desk.nesting.just_fired.remove(&build);
        desk.shared.ledger.fail_build(build, REASON).await?;
    }
    for part in desk.shared.ledger.give_up_claims(claims, REASON).await? {
        warn!(part.id = %part.id, machine, "Part {} ({}) is given up: {REASON}", part.id, part.name);
        mark_note::update_decision_count(&mut desk.receiving(), &part).await;
        claim_completion::copy_given_up_part(&mut desk.receiving(), &part, REASON);
    }
    claims.iter().for_each(|claim| drop(desk.completion.claims.remove(claim)));
    Ok(())
}

/// Raises or clears the alert on claims of other farms; picks up claims that a person has adopted.
pub(super) fn update_foreign_claims_alert(
    machines: &mut MachineStates,
    alerts: &mut AlertRegistry,
    name: &str,
    before: usize,
    now: usize,
) {
    match now {
        0 => alerts.clear(AlertKind::ForeignClaims, name, ""),
        _ => alerts.raise(AlertKind::ForeignClaims, name, "", &format!("{now} in its .claimed folder")),
    }
    if now < before
        && let Some(machine) = machines.get_mut(name)
    {
        machine.inbox.relist = true;
    }
}
