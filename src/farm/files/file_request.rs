//! What a file asks for its solids itself, as CAMSPEC packages do, in the words of the ledger and of the search.

use build_file::SolidRequest;
use nester::{FaceNotDown, OrientationLimits, OrientationRule, TiltLimit, TiltLimitError};

use ledger::{RequestedTerms, RequiredTilts};

use crate::settings::MachineProfile;

/// What a file asks for a solid of this machine.
///
/// # Errors
/// A direction or an angle is none.
pub(crate) fn requested_terms(
    request: &SolidRequest,
    profile: &MachineProfile,
) -> Result<RequestedTerms, TiltLimitError> {
    let up = request.up.iter().map(|&(direction, within_deg)| TiltLimit::new(direction, within_deg));
    let up: Vec<TiltLimit> = up.collect::<Result<_, _>>()?;
    let not_down = request.not_down.iter().map(|&(normal, spare_deg)| FaceNotDown::new(normal, spare_deg));
    let not_down: Vec<FaceNotDown> = not_down.collect::<Result<_, _>>()?;
    Ok(RequestedTerms {
        reference: request.reference.clone(),
        material: request.material.as_deref().map(|word| profile.materials.name_of(word)),
        priority: request.priority,
        clearance_mm: request.clearance_mm,
        orientation: request.is_fixed.then_some(OrientationRule::Fixed),
        tilts: RequiredTilts(OrientationLimits::new(OrientationRule::Free, &up, &not_down).tilts),
    })
}
