//! Exact contacts between two parts. Where the proxies say that two parts are clear but their triangles say that they
//! are not, the nearest points of the triangles are used instead of the proxies. A contact acts as a plane that the
//! other part must not pass.

use glam::Vec3;

use super::separation_step::{CollisionProxy, SeparationStep};
use crate::prepare::prepared_instance::{PlacedItem, PreparedInstance};

/// A contact that slid further sideways than this is no longer valid, mm.
const MAX_SLIDE_MM: f32 = 1.5;
/// A contact that is deeper than this belongs to another place, mm.
const MAX_SUNK_MM: f32 = 1.5;
/// Contacts are collected up to this distance beyond the clearance, mm.
const CONTACT_LIMIT_MM: f64 = 0.1;
/// Greatest number of contacts kept per pair.
const MAX_CONTACTS: usize = 24;

/// Two points, one on each part, that come too near each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExactContact {
    /// Point of the first part in its own frame, mm.
    arm1: Vec3,
    /// Point of the second part in its own frame, mm.
    arm2: Vec3,
    /// Unit direction from the second part to the first, in the second's frame.
    direction2: Vec3,
}

/// A contact at the present poses of its parts.
pub(crate) struct ActiveContact {
    /// The point of the first part, mm.
    pub(crate) point1: Vec3,
    /// The point of the second part, mm.
    pub(crate) point2: Vec3,
    /// Unit direction from the second part to the first.
    pub(crate) direction: Vec3,
    /// How far the points' distance falls short of the wanted one, mm.
    pub(crate) depth: f32,
}

impl ExactContact {
    fn active_contact(&self, first: &CollisionProxy, second: &CollisionProxy, wanted: f32) -> Option<ActiveContact> {
        let point1 = first.rotation * self.arm1 + first.center;
        let point2 = second.rotation * self.arm2 + second.center;
        let direction = second.rotation * self.direction2;
        let apart = point1 - point2;
        let along = apart.dot(direction);
        let depth = wanted - along;
        let is_active = depth > 0.0
            && along > -MAX_SUNK_MM
            && (apart - direction * along).length_squared() < MAX_SLIDE_MM * MAX_SLIDE_MM;
        is_active.then_some(ActiveContact { point1, point2, direction, depth })
    }
}

/// The contacts of a pair that fall short of `wanted`.
pub(crate) fn active_contacts(
    touches: &[ExactContact],
    (first, second): (&CollisionProxy, &CollisionProxy),
    wanted: f32,
) -> impl Iterator<Item = ActiveContact> {
    touches.iter().filter_map(move |touch| touch.active_contact(first, second, wanted))
}

/// Surface area that one contact represents, mm2.
fn contact_area(first: &CollisionProxy, second: &CollisionProxy) -> f32 {
    4.0 * first.shape.fine_points.point_area.max(second.shape.fine_points.point_area)
}

/// How far the contacts of a pair fall short of `wanted`: surface area times depth, mm3.
pub(crate) fn contact_energy(
    touches: &[ExactContact],
    first: &CollisionProxy,
    second: &CollisionProxy,
    wanted: f32,
) -> f32 {
    let depth: f32 = active_contacts(touches, (first, second), wanted).map(|pressed| pressed.depth).sum();
    depth * contact_area(first, second)
}

/// Adds to `push` the contacts that move one of the two parts (the first or the second) away from the other.
pub(crate) fn add_contacts(
    touches: &[ExactContact],
    (first, second): (&CollisionProxy, &CollisionProxy),
    moves_first: bool,
    (wanted, weight): (f32, f32),
    push: &mut SeparationStep,
) {
    let share = weight * contact_area(first, second);
    for pressed in active_contacts(touches, (first, second), wanted) {
        if moves_first {
            push.add_contact(pressed.point1 - first.center, pressed.direction, pressed.depth, share);
        } else {
            push.add_contact(pressed.point2 - second.center, -pressed.direction, pressed.depth, share);
        }
    }
}

/// Finds the contacts of two pieces, the nearest of every neighbourhood. If they tell why the pieces are not clear (the
/// surfaces come too near without meeting, and neither piece is in the other), puts them before the known ones and returns
/// true; otherwise leaves the known ones as they are.
pub(crate) fn find_contacts(
    prepared: &PreparedInstance,
    first: &PlacedItem,
    second: &PlacedItem,
    touches: &mut Vec<ExactContact>,
) -> bool {
    let wanted_mm = prepared.wanted_distance_mm(first, second);
    let (shape1, shape2) = (&prepared.prepared_item(first.item).shape, &prepared.prepared_item(second.item).shape);
    let pose12 = first.pose.relative_pose_of(&second.pose);
    let pose21 = pose12.inverse();
    let cell_mm = 0.3 * shape1.radius_mm.min(shape2.radius_mm);
    let mut found: Vec<(glam::IVec3, f64, ExactContact)> = Vec::new();
    shape1.tree.visit_contacts(&shape2.tree, &pose12, (0.5 * cell_mm, wanted_mm + CONTACT_LIMIT_MM), &mut |contact| {
        let distance = contact.distance_mm();
        let cell = (contact.point1 / cell_mm).floor().as_ivec3();
        let direction = pose21.transform_direction(contact.point1 - contact.point2) / distance;
        let touch = ExactContact {
            arm1: (contact.point1 - shape1.center).as_vec3(),
            arm2: (pose21.transform_point(contact.point2) - shape2.center).as_vec3(),
            direction2: direction.as_vec3(),
        };
        match found.iter_mut().find(|known| known.0 == cell) {
            Some(known) if known.1 > distance => *known = (cell, distance, touch),
            Some(_) => {}
            None => found.push((cell, distance, touch)),
        }
    });
    let is_too_near = found.iter().any(|known| known.1 < wanted_mm);
    if !is_too_near || prepared.encloses(first, second) || prepared.encloses(second, first) {
        return false;
    }
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    touches.splice(0..0, found.into_iter().map(|(_, _, touch)| touch));
    touches.truncate(MAX_CONTACTS);
    true
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::{
        BuildVolume, NestingInstance, NestingItem,
        tests::testing::{block, cells, coarsely_prepared, hollow},
    };

    #[test]
    fn contacts_are_kept_only_where_they_tell_why_two_parts_are_not_clear() {
        // A hook whose long leg comes near where its short one cuts.
        let hook = cells(10.0, [[0, 0, 0], [0, 0, 1], [0, 0, 2], [1, 0, 0]]);
        let items = vec![
            NestingItem::new("shell", hollow(60.0, 2.0), 1),
            NestingItem::new("cube", block(DVec3::splat(10.0)), 1),
            NestingItem::new("hook", hook, 1),
        ];
        let volume = BuildVolume { size_mm: DVec3::splat(300.0) };
        let instance = NestingInstance::new(volume, 1.0, items).expect("fits");
        let prepared = coarsely_prepared(&instance);
        let shell = prepared.place_item((0, 0), DQuat::IDENTITY, DVec3::splat(100.0));
        for (item, x, is_explained, why) in [
            (1, 135.5, true, "half a millimetre apart"),
            (1, 136.05, false, "far enough apart"),
            (1, 170.0, false, "far apart"),
            (1, 132.0, false, "one cuts the other"),
            (1, 100.0, false, "one is in the other, far from its walls"),
            (1, 122.5, false, "one is in the other, near its wall"),
            (2, 69.5, false, "one cuts the other, and is near it elsewhere"),
        ] {
            let piece = prepared.place_item((item, 0), DQuat::IDENTITY, DVec3::new(x, 100.0, 100.0));
            let known = ExactContact { arm1: Vec3::X, arm2: Vec3::ZERO, direction2: Vec3::X };
            let mut touches = vec![known];
            assert_eq!(find_contacts(&prepared, &shell, &piece, &mut touches), is_explained, "{why}");
            let place = touches.iter().position(|touch| touch.arm1 == Vec3::X).expect("it stays");
            assert_eq!((place > 0, place + 1), (is_explained, touches.len()), "{why}");
        }
    }
}
