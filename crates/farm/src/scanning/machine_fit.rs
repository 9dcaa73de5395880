//! Whether a proved build still fits its machine, whose file people edit. Whatever puts the file of a build into a queue folder asks
//! this first: `publish` has the build made again, `build_move` leaves it where it is, and `queue_files` tells of one that lies there.

use anyhow::Result;
use ledger::{BuildRow, EventKind, Ledger};
use settings::MachineProfile;
use tracing::warn;

/// Why a build does not fit its machine as it is set now, or its file what printers' software opens; `None` = it does.
pub(crate) fn find_misfit(profile: &MachineProfile, build: &BuildRow) -> Option<String> {
    let was = snapshot_of(profile, build);
    let (now, before) = (profile.output.delivery, was.output.delivery);
    let other_kind =
        || (now != before).then(|| format!("builds are delivered as {}, and it is {}", now.name(), before.name()));
    let why = find_stricter(profile, &was, build).or_else(other_kind)?;
    Some(format!("the machine has changed since it was proved: {why}"))
}

/// The machine that a build was made for.
fn snapshot_of(profile: &MachineProfile, build: &BuildRow) -> MachineProfile {
    MachineProfile::from_snapshot(&build.machine, build.kept.profile_snapshot.as_deref(), Some(profile))
}

fn find_stricter(profile: &MachineProfile, was: &MachineProfile, build: &BuildRow) -> Option<String> {
    profile.to_machine().find_stricter_than(&was.to_machine(), build.measures.height_mm)
}

/// A build that is issued once more was to be as it was: where its machine has changed so that it does not fit any more, it is not.
pub(crate) async fn report_changed_machine(ledger: &Ledger, profile: &MachineProfile, build: &BuildRow) -> Result<()> {
    let Some(printed) = build.search.repeats else { return Ok(()) };
    let before = ledger.find_build(printed).await?;
    let stricter = |before: BuildRow| find_stricter(profile, &snapshot_of(profile, &before), &before);
    let Some(why) = before.and_then(stricter) else { return Ok(()) };
    let detail = format!("not as build {printed} was, for the machine has changed since it was proved: {why}");
    warn!(build.id = %build.id, machine = %build.machine, "Build {} is {detail}.", build.id);
    Ok(ledger.write_event(EventKind::Requeued, &build.machine, None, Some(build.id), &detail).await?)
}
