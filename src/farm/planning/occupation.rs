//! Which builds occupy the printers of a machine, how long prints take there, and which builds wait for a person's yes.

use anyhow::Result;
use jiff::Timestamp;
use ledger::{BuildRow, BuildState, Ledger, OccupyingBuild};

use super::packing_experience::{LEARN_FROM, PackingExperience};
use crate::{
    farm::{decisions::print_times::PrintTimes, scanning::machine_fit::find_misfit},
    settings::MachineProfile,
};

/// What a machine's prints take, and the builds that occupy its printers. The height of one that is not searched yet is an estimate.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_occupation(
    ledger: &Ledger,
    profile: &MachineProfile,
    now: Timestamp,
) -> Result<(Vec<OccupyingBuild>, PrintTimes)> {
    let mut builds = ledger.occupying_builds(&profile.name, now.into()).await?;
    if builds.iter().any(|build| build.height_mm.is_none()) {
        let experience = ledger.published_experience(&profile.name, LEARN_FROM).await?;
        let packing = PackingExperience::learn(profile, &experience);
        for build in builds.iter_mut().filter(|build| build.height_mm.is_none()) {
            let height_mm = packing.height_mm(ledger.volume_of_build(build.build).await?, 0.0);
            build.height_mm = Some(height_mm.min(profile.build_volume().size_mm.z));
        }
    }
    let told = ledger.told_prints(&profile.name).await?;
    Ok((builds, PrintTimes::learn(profile, &told)))
}

/// Whether a proved build waits for a person's yes. One that does not fit its machine any more is made again first.
pub fn awaits_release(profile: &MachineProfile, build: &BuildRow) -> bool {
    let share = build.measures.height_mm.unwrap_or_default() / profile.space.volume_mm.z;
    build.state == BuildState::Verified
        && build.place.released_at.is_none()
        && build.staged.publishing_at.is_none()
        && profile.printing.needs_release(share)
        && find_misfit(profile, build).is_none()
}
