//! Which builds occupy the printers of a machine, how long prints take there, and which builds wait for a person's yes. What the
//! ledger says of all machines is read once, whoever looks at several of them.

use anyhow::Result;
use jiff::Timestamp;
use ledger::{
    BuildId, BuildRow, BuildState, DownPrinter, Ledger, MachineRow, MachineStatus, OccupyingBuild, ToldPrint,
};
use settings::MachineProfile;

use super::packing_experience::{LEARN_FROM, PackingExperience};
use crate::{decisions::print_times::PrintTimes, scanning::machine_fit::find_misfit};

/// What the ledger says of all machines.
#[derive(Debug, Clone)]
pub struct FarmRows {
    /// What waits for each machine, and what is made for it.
    pub statuses: Vec<MachineStatus>,
    /// What the daemon saw of each last.
    pub observed: Vec<MachineRow>,
    /// The printers that people took out of use.
    pub down: Vec<DownPrinter>,
    /// Proved builds that are not published.
    pub verified: Vec<BuildRow>,
}

/// What a machine's printers have to do.
#[derive(Debug, Clone)]
pub struct Occupation {
    /// The builds that occupy them. The height of one that is not searched yet is an estimate.
    pub builds: Vec<OccupyingBuild>,
    /// The prints whose times people told, the newest first.
    pub told: Vec<ToldPrint>,
    /// How long prints take.
    pub times: PrintTimes,
}

impl FarmRows {
    /// Reads them.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn read(ledger: &Ledger) -> Result<Self> {
        let (statuses, mut observed) = (ledger.machine_statuses().await?, ledger.list_machines().await?);
        if ledger.file().is_none() {
            // What a node saw before it ended is so no more.
            for node in ledger.list_nodes().await?.into_iter().filter(|node| !node.alive) {
                for row in observed.iter_mut().filter(|row| row.node == node.name && row.trouble.is_empty()) {
                    row.trouble = format!("its node {} does not run", node.name);
                    row.trouble_at = Some(node.beat_at);
                }
            }
        }
        let verified = ledger.builds_in_state(BuildState::Verified).await?;
        Ok(Self { statuses, observed, down: ledger.down_printers().await?, verified })
    }

    /// The builds of a machine that wait for a person's yes.
    pub fn awaiting_release(&self, profile: &MachineProfile) -> Vec<BuildId> {
        let own = self.verified.iter().filter(|build| build.machine == profile.name && awaits_release(profile, build));
        own.map(|build| build.id).collect()
    }

    /// What the daemon saw of a machine last.
    pub fn observed(&self, machine: &str) -> Option<&MachineRow> {
        self.observed.iter().find(|row| row.machine == machine)
    }

    /// Who took a printer out of use, if somebody did.
    pub fn down(&self, machine: &str, printer: &str) -> Option<&DownPrinter> {
        self.down.iter().find(|down| down.machine == machine && down.printer == printer)
    }
}

/// Reads what a machine's printers have to do.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_occupation(ledger: &Ledger, profile: &MachineProfile, now: Timestamp) -> Result<Occupation> {
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
    let times = PrintTimes::learn(profile, &told);
    Ok(Occupation { builds, told, times })
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
