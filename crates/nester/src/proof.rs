//! The independent proof of a finished layout. It checks clearance and containment on the triangles, and walls on the
//! vertices. It shares only the distance computation with the search: it finds the neighbouring pairs itself and does
//! not rely on any result of the search.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use solids::{Bounds, ClearanceTree, Pose};

use body_trees::PlacedBodyTrees;

use super::{ItemPlacement, NestingInstance, OrientationLimits, OrientationRule, TiltLimit};
use crate::{orientation::rotations::axis_rotations, problem::reserved::box_mesh};

pub use disassembly::{Disassembly, find_removal_order};
pub use placed_solid::PlacedSolid;

/// Allowed shortfall of a clearance, mm.
const CLEARANCE_TOLERANCE_MM: f64 = 1e-6;
/// Allowed excess of a body over the volume, mm.
const WALL_TOLERANCE_MM: f64 = 1e-6;
/// Allowed depth of a body in a zone, mm.
const ZONE_TOLERANCE_MM: f64 = 1e-6;
/// Allowed deviation of a rotation from its rule, radians.
const ANGLE_TOLERANCE: f64 = 1e-6;

/// Two bodies that are too close to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ClearanceViolation {
    /// Index of the first body.
    pub first: usize,
    /// Index of the second body, greater than `first`.
    pub second: usize,
    /// Smallest distance between their surfaces over all required raises of either body, mm; 0 if they touch.
    pub distance_mm: f64,
    /// Required distance, mm.
    pub wanted_mm: f64,
}

/// The result of the proof.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LayoutProof {
    /// Top of the highest body above z = 0, mm; 0 without bodies.
    pub height_mm: f64,
    /// The exact smallest distance between any two bodies, mm. Pairs are measured up to twice the greatest clearance
    /// plus 1 mm; `None` if no pair is closer than that (or there are fewer than two bodies).
    pub clearance_proved_mm: Option<f64>,
    /// Pairs that are closer than their clearance, or whose surfaces touch. Surfaces must not touch even if the
    /// clearance is 0.
    pub too_close: Vec<ClearanceViolation>,
    /// Bodies that extend outside the volume, with their greatest excess over any wall, mm.
    pub outside: Vec<(usize, f64)>,
    /// (outer, inner): the inner body lies inside the outer solid or inside a sealed cavity of it.
    pub inside: Vec<(usize, usize)>,
    /// (body, zone): the body extends into the keep-out zone.
    pub intruding: Vec<(usize, usize)>,
}

impl LayoutProof {
    /// Whether the layout is valid.
    pub fn is_proved(&self) -> bool {
        self.too_close.is_empty() && self.outside.is_empty() && self.inside.is_empty() && self.intruding.is_empty()
    }
}

/// Checks a layout against all requirements of an instance, except its orientation rules ([`obeys_orientation`]) and
/// its layer area cap ([`LayerAreas`](crate::LayerAreas)).
///
/// ```
/// use std::sync::Arc;
/// use glam::{DQuat, DVec3};
/// use nester::{BuildVolume, NestingInstance, NestingItem, ItemPlacement, prove_layout};
/// use solids::{Mesh, Pose};
///
/// let cube = Arc::new(Mesh::cuboid(DVec3::splat(10.0))?);
/// let volume = BuildVolume { size_mm: DVec3::splat(40.0) };
/// let instance = NestingInstance::new(volume, 2.0, vec![NestingItem::new("cube", cube, 2)])?;
/// let at = |copy, x| ItemPlacement { item: 0, copy, pose: Pose::new(DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0)) };
///
/// let proof = prove_layout(&instance, &[at(0, 0.0), at(1, 12.5)]);
/// assert!(proof.is_proved() && proof.clearance_proved_mm == Some(2.5));
///
/// let proof = prove_layout(&instance, &[at(0, 0.0), at(1, 11.0)]);
/// assert_eq!((proof.too_close[0].distance_mm, proof.too_close[0].wanted_mm), (1.0, 2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn prove_layout(instance: &NestingInstance, placements: &[ItemPlacement]) -> LayoutProof {
    let bodies = PlacedSolid::of_layout(instance, placements);
    prove_with_keep_out(&bodies, instance.volume().size_mm, instance.clearance_z_extra_mm(), &instance.keep_out())
}

/// Checks bodies in a box from the origin to `volume_mm`. The tolerance is 1e-6 mm for clearances and for walls. A
/// body whose pose contains NaN or infinite numbers counts as infinitely far outside.
pub fn prove_placed_solids(bodies: &[PlacedSolid], volume_mm: DVec3) -> LayoutProof {
    prove_with_z_extra(bodies, volume_mm, 0.0)
}

/// Like [`prove_placed_solids`], but the clearance between any two bodies must also hold if either is raised by any
/// distance from 0 to `extra_mm`.
pub fn prove_with_z_extra(bodies: &[PlacedSolid], volume_mm: DVec3, extra_mm: f64) -> LayoutProof {
    prove_with_keep_out(bodies, volume_mm, extra_mm, &[])
}

/// Like [`prove_with_z_extra`], with keep-out boxes. A body may extend into a box by up to 1e-6 mm.
pub fn prove_with_keep_out(
    bodies: &[PlacedSolid],
    volume_mm: DVec3,
    extra_mm: f64,
    keep_out: &[Bounds],
) -> LayoutProof {
    LayoutProver::new(bodies, 1).prove_layout(volume_mm, extra_mm, keep_out)
}

/// Proves bodies in several ways. What is prepared for a mesh is prepared once, when the first question needs it.
///
/// ```
/// use std::sync::Arc;
/// use glam::{DQuat, DVec3};
/// use nester::{LayoutProver, PlacedSolid};
/// use solids::{Mesh, Pose};
///
/// let cube = Arc::new(Mesh::cuboid(DVec3::splat(10.0))?);
/// let body = |x: f64| PlacedSolid {
///     name: String::new(),
///     mesh: cube.clone(),
///     pose: Pose::new(DQuat::IDENTITY, DVec3::X * x),
///     clearance_mm: 2.0,
/// };
/// let bodies = [body(0.0), body(12.5)];
/// let prover = LayoutProver::new(&bodies, 1);
/// assert!(prover.prove_layout(DVec3::splat(40.0), 0.0, &[]).is_proved());
/// assert!(prover.find_removal_order().locked.is_empty());
/// # Ok::<(), solids::MeshError>(())
/// ```
#[derive(Debug)]
pub struct LayoutProver<'a> {
    bodies: &'a [PlacedSolid],
    trees: PlacedBodyTrees<'a>,
    /// The bounds of the bodies, of every vertex and not of the trees.
    bounds: Vec<Bounds>,
}

impl<'a> LayoutProver<'a> {
    /// Measures the bodies. `threads` is the number of threads for what is prepared for a mesh.
    pub fn new(bodies: &'a [PlacedSolid], threads: usize) -> Self {
        let bounds = bodies.iter().map(|b| b.mesh.bounds_at(&b.pose)).collect();
        Self { bodies, trees: PlacedBodyTrees::new(bodies, threads), bounds }
    }

    /// Like [`prove_with_keep_out`].
    pub fn prove_layout(&self, volume_mm: DVec3, extra_mm: f64, keep_out: &[Bounds]) -> LayoutProof {
        let (bodies, bounds) = (self.bodies, &self.bounds);
        let outside: Vec<(usize, f64)> = (bounds.iter().map(|b| excess_mm(b, volume_mm)).enumerate())
            .filter(|&(_, excess_mm)| excess_mm > WALL_TOLERANCE_MM)
            .collect();
        let mut proof = LayoutProof {
            height_mm: bounds.iter().map(|b| b.max.z).fold(0.0, f64::max),
            clearance_proved_mm: None,
            too_close: Vec::new(),
            outside,
            inside: Vec::new(),
            intruding: self.find_intrusions(keep_out),
        };
        let cap_mm = 2.0 * bodies.iter().map(|b| b.clearance_mm).fold(0.0, f64::max) + 1.0;
        for (first, second) in nearby_pairs(bounds, cap_mm + extra_mm) {
            self.check_pair((first, second), (cap_mm, extra_mm), &mut proof);
        }
        proof.too_close.sort_by_key(|p| (p.first, p.second));
        proof.inside.sort_unstable();
        proof
    }

    /// Bodies that extend into a zone, each with the index of the zone.
    fn find_intrusions(&self, keep_out: &[Bounds]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        for (number, zone) in keep_out.iter().enumerate() {
            let zone = Bounds { min: zone.min + ZONE_TOLERANCE_MM, max: zone.max - ZONE_TOLERANCE_MM };
            let Some(solid) = box_mesh(&zone).map(|mesh| ClearanceTree::new(Arc::new(mesh))) else { continue };
            let stands_in = |body: usize| {
                let pose = &self.bodies[body].pose;
                self.bounds[body].distance(&zone) <= 0.0
                    && (solid.distance_capped_mm(self.trees.tree(body), pose, 1.0) <= 0.0
                        || solid.contains_part(self.trees.tree(body), pose)
                        || self.trees.tree(body).contains_part(&solid, &pose.inverse()))
            };
            found.extend((0..self.bodies.len()).filter(|&body| stands_in(body)).map(|body| (body, number)));
        }
        found.sort_unstable();
        found
    }

    /// Measures one pair and records its violations.
    fn check_pair(&self, (first, second): (usize, usize), (cap_mm, extra_mm): (f64, f64), proof: &mut LayoutProof) {
        let (body1, body2) = (&self.bodies[first], &self.bodies[second]);
        let (tree1, tree2) = (self.trees.tree(first), self.trees.tree(second));
        let pose12 = body1.pose.relative_pose_of(&body2.pose);
        let distance_mm = tree1.distance_capped_mm(tree2, &pose12, cap_mm);
        if distance_mm < cap_mm {
            proof.clearance_proved_mm =
                Some(proof.clearance_proved_mm.map_or(distance_mm, |least| least.min(distance_mm)));
        }
        let wanted_mm = body1.clearance_mm.max(body2.clearance_mm);
        if extra_mm > 0.0 && distance_mm > 0.0 {
            let slide1 = body1.pose.inverse().transform_direction(DVec3::Z * extra_mm);
            let raised_mm = tree1.distance_sliding_mm(tree2, &pose12, slide1, cap_mm);
            if raised_mm <= 0.0 || raised_mm < wanted_mm - CLEARANCE_TOLERANCE_MM {
                return proof.too_close.push(ClearanceViolation { first, second, distance_mm: raised_mm, wanted_mm });
            }
        }
        if distance_mm <= 0.0 || distance_mm < wanted_mm - CLEARANCE_TOLERANCE_MM {
            proof.too_close.push(ClearanceViolation { first, second, distance_mm, wanted_mm });
        }
        if distance_mm <= 0.0 || self.bounds[first].distance(&self.bounds[second]) > 0.0 {
            return;
        }
        if tree1.contains_part(tree2, &pose12) {
            proof.inside.push((first, second));
        }
        if tree2.contains_part(tree1, &pose12.inverse()) {
            proof.inside.push((second, first));
        }
    }
}

/// Whether the rotation of a pose obeys the orientation limits of a part (within 1e-6 radian).
///
/// ```
/// use glam::{DQuat, DVec3};
/// use nester::{OrientationLimits, OrientationRule, obeys_orientation};
/// use solids::Pose;
///
/// let upright = OrientationLimits::from(OrientationRule::Upright);
/// assert!(obeys_orientation(&upright, &Pose::new(DQuat::from_rotation_z(1.0), DVec3::ZERO)));
/// assert!(!obeys_orientation(&upright, &Pose::new(DQuat::from_rotation_x(1.0), DVec3::ZERO)));
/// ```
pub fn obeys_orientation(orientation: &OrientationLimits, pose: &Pose) -> bool {
    let poses = |tilt: &TiltLimit| {
        let (poses, up) = (pose.transform_direction(tilt.direction()), DVec3::Z);
        poses.cross(up).length().atan2(poses.dot(up)) <= tilt.within_deg().to_radians() + ANGLE_TOLERANCE
    };
    // For two unit quaternions, the length of the vector part of their quotient is |sin| of half the angle between
    // them.
    let is_near = |to: DQuat| {
        let apart = (to.conjugate() * pose.rotation.normalize()).xyz().length();
        2.0 * apart.min(1.0).asin() <= ANGLE_TOLERANCE
    };
    let obeys = match orientation.rule {
        OrientationRule::Free => pose.rotation.is_finite(),
        OrientationRule::Upright => {
            let up = pose.transform_direction(DVec3::Z);
            up.z > 0.0 && up.truncate().length() <= ANGLE_TOLERANCE
        }
        OrientationRule::Axis => axis_rotations().into_iter().any(is_near),
        OrientationRule::Fixed => is_near(DQuat::IDENTITY),
    };
    obeys && orientation.tilts.iter().all(poses)
}

/// Greatest excess of bounds over the volume, mm; infinite for numbers that are not finite.
fn excess_mm(bounds: &Bounds, volume_mm: DVec3) -> f64 {
    if !(bounds.min.is_finite() && bounds.max.is_finite()) {
        return f64::INFINITY;
    }
    (-bounds.min).max(bounds.max - volume_mm).max_element()
}

/// Pairs whose bounds are closer than `cap_mm`, found by a sweep along x.
fn nearby_pairs(bounds: &[Bounds], cap_mm: f64) -> Vec<(usize, usize)> {
    let mut order: Vec<usize> = (0..bounds.len()).collect();
    order.sort_by(|&i, &j| bounds[i].min.x.total_cmp(&bounds[j].min.x));
    let mut open: Vec<usize> = Vec::new();
    let mut pairs = Vec::new();
    for i in order {
        // A body with NaN bounds stays in the list. It is reported as outside anyway.
        open.retain(|&j| bounds[j].max.x.is_nan() || bounds[j].max.x + cap_mm > bounds[i].min.x);
        let near = open.iter().filter(|&&j| bounds[j].distance(&bounds[i]) < cap_mm);
        pairs.extend(near.map(|&j| (i.min(j), i.max(j))));
        open.push(i);
    }
    pairs
}

mod body_trees;
mod disassembly;
mod placed_solid;
#[cfg(test)]
mod tests;
