//! The proof of a layout by the nester's prover, which relies on no result of the search.

use glam::{DMat3, DQuat, DVec3};
use nester::{InterlockRule, ItemPlacement, LayoutProof, LayoutProver, PlacedSolid, Separability, obeys_orientation};
use numpy::{PyReadonlyArray3, ndarray::ArrayView2};
use pyo3::prelude::*;
use solids::Pose;

use crate::{
    errors::{InputError, ProofError},
    found_layout::FoundLayout,
};

/// Allowed difference of a matrix from a rotation, in each element of its product with its transpose.
const RIGID_TOLERANCE: f64 = 1e-6;
/// Maximum number of faults named in one message.
const NAMED_FAULTS: usize = 5;

/// Height (mm); least distance (mm; `None` where no pair is near); locked placements; removal order: placements, each
/// with its direction.
pub(crate) type ProofFigures = (f64, Option<f64>, Vec<usize>, Vec<(usize, [f64; 3])>);

/// The placements of a layout at other poses, given as n x 4 x 4 numbers: as many matrices on column vectors as there
/// are placements.
///
/// # Errors
/// `InputError` where a matrix is not a rotation and a translation.
pub(crate) fn posed_placements(
    found: &FoundLayout,
    matrices: &PyReadonlyArray3<'_, f64>,
) -> PyResult<Vec<ItemPlacement>> {
    let matrices = matrices.as_array();
    let moved = found.solution.placements.iter().zip(matrices.outer_iter()).enumerate();
    moved
        .map(|(at, (placement, matrix))| {
            let pose = rigid_pose(&matrix).ok_or_else(|| {
                InputError::new_err(format!(
                    "pose {at} is no rotation and translation: parts are not scaled or mirrored."
                ))
            })?;
            Ok(ItemPlacement { pose, ..*placement })
        })
        .collect()
}

/// The pose of a 4 x 4 matrix; `None` where it is no rotation and translation.
fn rigid_pose(matrix: &ArrayView2<'_, f64>) -> Option<Pose> {
    let column = |at: usize| DVec3::new(matrix[[0, at]], matrix[[1, at]], matrix[[2, at]]);
    let (turn, translation) = (DMat3::from_cols(column(0), column(1), column(2)), column(3));
    let off = turn.transpose() * turn - DMat3::IDENTITY;
    let is_rigid = matrix.iter().all(|number| number.is_finite())
        && off.to_cols_array().into_iter().all(|number| number.abs() <= RIGID_TOLERANCE)
        && turn.determinant() > 0.0
        && matrix.row(3).iter().eq(&[0.0, 0.0, 0.0, 1.0]);
    is_rigid.then(|| Pose::new(DQuat::from_mat3(&turn), translation))
}

/// Proves volume, clearance, containment, orientations and, unless it is allowed, that no part is locked into others.
///
/// # Errors
/// `ProofError` with the faults.
pub(crate) fn prove_placements(found: &FoundLayout, placements: &[ItemPlacement]) -> PyResult<ProofFigures> {
    let instance = &found.instance;
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
