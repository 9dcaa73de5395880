//! Claims and two farms: what another farm has taken over is given up here, and what another one left is left alone until a
//! person adopts it.

use std::collections::HashSet;

use anyhow::{Context, Result, bail};
use tracing::warn;

use super::{
    attention::Attention,
    farm::Farm,
    owner::{Hold, Owner, OwnerError},
};
use crate::{
    intake,
    settings::{Profile, Settings},
};

/// Takes over what other farms have claimed in the hot folder of a profile; returns how many claims. With or without a
/// daemon; one that runs finds them at its next beat.
///
/// # Errors
/// Another daemon serves the folder, this farm has never run, or the folder does not let it.
pub fn adopt(settings: &Settings, profile: &Profile) -> Result<usize> {
    let inbox = &profile.folders.inbox;
    if !Owner::is_made(&settings.state_dir) {
        bail!("there is no farm in {} yet: start nestd once, then adopt", settings.state_dir.display());
    }
    let me = Owner::of_this_process(&settings.state_dir, jiff::Timestamp::now())
        .with_context(|| format!("reading the farm's number in {}", settings.state_dir.display()))?;
    let farm = me.farm().to_owned();
    let mut hold = Hold::new(me, inbox);
    loop {
        match hold.check() {
            Ok(()) => break,
            // Its number may stand still because it is dead: that takes a while to tell.
            Err(OwnerError::Unclear { .. }) => std::thread::sleep(std::time::Duration::from_millis(500)),
            Err(refused) => return Err(refused.into()),
        }
    }
    intake::adopt(inbox, &farm).with_context(|| format!("taking over the claims in {}", inbox.display()))
}

/// Refuses a batch of parts whose claims were not all let go by this farm: one that still lies there may be taken over, one that
/// was taken over is printed by the other.
pub fn demand_let_go(profile: &Profile, farm: &str, claims: &HashSet<String>) -> Result<(), OwnerError> {
    if claims.is_empty() {
        return Ok(());
    }
    let folder = profile.folders.inbox.clone();
    match intake::not_let_go(&folder, farm, claims) {
        Ok(left) if left.is_empty() => Ok(()),
        Ok(left) => Err(OwnerError::NotLetGo { folder, claims: left.len() }),
        Err(why) => Err(OwnerError::Io { folder, why }),
    }
}

impl Farm {
    /// Gives up the parts of claims that another farm has taken over, before anything else is done with them.
    pub(super) async fn give_up_claims(&mut self, profile: &str, claims: &[String]) -> Result<()> {
        const REASON: &str = "Another nestd has taken over this file while this one did not answer, and prints it.";
        if claims.is_empty() {
            return Ok(());
        }
        for build in self.ledger.nesting_builds_of_claims(claims).await? {
            if let Some((budget, _)) = self.nesting.finals.get(&build) {
                budget.cancel();
            }
            self.nesting.fresh.remove(&build);
            self.ledger.fail_build(build, REASON).await?;
        }
        for part in self.ledger.give_up_claims(claims, REASON).await? {
            warn!(part.id = %part.id, profile, "Part {} ({}) is given up: {REASON}", part.id, part.name);
            self.mark_decided(&part).await;
            self.put_aside(&part, REASON);
        }
        claims.iter().for_each(|claim| drop(self.ending.claims.remove(claim)));
        Ok(())
    }

    /// Tells of claims of other farms; what a person has adopted is taken up.
    pub(super) fn tell_of_foreign_claims(&mut self, name: &str, before: usize, now: usize) {
        match now {
            0 => self.notices.clear(Attention::ForeignClaims, name, ""),
            _ => self.notices.raise(Attention::ForeignClaims, name, "", &format!("{now} in its .claimed folder")),
        }
        if now < before
            && let Some(station) = self.stations.get_mut(name)
        {
            station.inbox.relist = true;
        }
    }
}
