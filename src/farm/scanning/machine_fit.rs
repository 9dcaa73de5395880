//! Whether a proved build still fits its machine, whose file people edit. Whatever puts the file of a build into a queue folder asks
//! this first: `publish` has the build made again, `build_move` leaves it where it is, and `queue_files` tells of one that lies there.

use ledger::BuildRow;

use crate::settings::MachineProfile;

/// Why a build does not fit its machine as it is set now; `None` = it does.
pub(crate) fn find_misfit(profile: &MachineProfile, build: &BuildRow) -> Option<String> {
    let was = MachineProfile::from_snapshot(&build.profile, build.kept.profile_snapshot.as_deref(), Some(profile));
    let why = profile.to_machine().find_stricter_than(&was.to_machine(), build.measures.height_mm)?;
    Some(format!("the machine has changed since it was proved: {why}"))
}
