//! The proof of a layout by the nester's prover, which relies on no result of the search.

use nester::{InterlockRule, LayoutProof, LayoutProver, PlacedSolid, Separability, obeys_orientation};
use pyo3::prelude::*;

use crate::{errors::ProofError, found_layout::FoundLayout};

/// Maximum number of faults named in one message.
const NAMED_FAULTS: usize = 5;

/// Height (mm); least distance (mm; `None` where no pair is near); locked placements; removal order: placements, each
/// with its direction.
pub(crate) type ProofFigures = (f64, Option<f64>, Vec<usize>, Vec<(usize, [f64; 3])>);

/// Proves volume, clearance, containment, orientations and, unless it is allowed, that no part is locked into others.
///
/// # Errors
/// `ProofError` with the faults.
pub(crate) fn prove_found(found: &FoundLayout) -> PyResult<ProofFigures> {
    let (instance, placements) = (&found.instance, &found.solution.placements);
    let bodies = PlacedSolid::of_layout(instance, placements);
    let prover = LayoutProver::new(&bodies, found.config.thread_count());
    let proof = prover.prove_layout(instance.volume().size_mm, instance.clearance_z_extra_mm(), &instance.keep_out());
    let mut faults = faults_of(&proof, &bodies);
    for (placement, body) in placements.iter().zip(&bodies) {
        if !obeys_orientation(&instance.items()[placement.item].orientation, &placement.pose) {
            faults.push(format!("{} is turned against its orientation rule", body.name));
        }
    }
    refuse_faults("the layout", &faults)?;
    let rule = found.config.effective_interlock();
    let apart = Separability::disassemble_under(rule, &prover);
    let (locked, order) = apart.map_or_else(Default::default, |apart| (apart.locked, apart.order));
    if rule == InterlockRule::Forbid {
        let locked: Vec<String> =
            locked.iter().map(|&at| format!("{} is locked into others", bodies[at].name)).collect();
        refuse_faults("the layout", &locked)?;
    }
    let order = order.into_iter().map(|(body, direction)| (body, direction.to_array())).collect();
    Ok((proof.height_mm, proof.clearance_proved_mm, locked, order))
}

/// The faults that a proof has found, one phrase each.
pub(crate) fn faults_of(proof: &LayoutProof, bodies: &[PlacedSolid]) -> Vec<String> {
    let name = |at: usize| &bodies[at].name;
    let too_close = proof.too_close.iter().map(|pair| {
        format!(
            "{} and {} are {:.4} mm apart instead of {} mm",
            name(pair.first),
            name(pair.second),
            pair.distance_mm,
            pair.wanted_mm
        )
    });
    let outside = proof.outside.iter().map(|&(at, excess_mm)| format!("{} is {excess_mm:.4} mm outside", name(at)));
    let inside = proof.inside.iter().map(|&(outer, inner)| format!("{} is inside {}", name(inner), name(outer)));
    let intruding = proof.intruding.iter().map(|&(at, zone)| format!("{} is in zone {zone}", name(at)));
    too_close.chain(outside).chain(inside).chain(intruding).collect()
}

/// `ProofError` where there are faults; names the first of them.
pub(crate) fn refuse_faults(what: &str, faults: &[String]) -> PyResult<()> {
    let named = faults.iter().take(NAMED_FAULTS).map(String::as_str).collect::<Vec<_>>().join("; ");
    let more = match faults.len().saturating_sub(NAMED_FAULTS) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    if faults.is_empty() { Ok(()) } else { Err(ProofError::new_err(format!("{what} is not proved: {named}{more}"))) }
}
