//! Exact contacts: where guides say that two parts are clear and their triangles say that they are not, the triangles'
//! nearest points stand in for the guides. Seen from the parts, a contact is a plane that the other part must not pass.

use glam::Vec3;

use super::{
    piece::{Piece, Task},
    push::{Guide, Push},
};

/// A contact that slid so far sideways says nothing any more, mm.
const SLIDE_MM: f32 = 1.5;
/// A contact so much deeper than when it was found belongs to another place, mm.
const SUNK_MM: f32 = 1.5;
/// Contacts that are kept per pair.
const MOST: usize = 24;

/// Two points, one on each part, that come too near each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch {
    /// Point of the first part in its own frame, mm.
    arm1: Vec3,
    /// Point of the second part in its own frame, mm.
    arm2: Vec3,
    /// Unit direction from the second part to the first, in the second's frame.
    way2: Vec3,
}

/// A contact as it is now.
struct Pressed {
    point1: Vec3,
    point2: Vec3,
    way: Vec3,
    depth: f32,
}

impl Touch {
    fn pressed(&self, first: &Guide, second: &Guide, wanted: f32) -> Option<Pressed> {
        let point1 = first.turn * self.arm1 + first.place;
        let point2 = second.turn * self.arm2 + second.place;
        let way = second.turn * self.way2;
        let apart = point1 - point2;
        let along = apart.dot(way);
        let depth = wanted - along;
        let holds = depth > 0.0 && along > -SUNK_MM && (apart - way * along).length_squared() < SLIDE_MM * SLIDE_MM;
        holds.then_some(Pressed { point1, point2, way, depth })
    }
}

/// Surface that one contact stands for, mm2.
fn area(first: &Guide, second: &Guide) -> f32 {
    4.0 * first.shape.fine.point_area.max(second.shape.fine.point_area)
}

/// How far the contacts of a pair are from `wanted`: surface times depth, mm3.
pub(crate) fn energy(touches: &[Touch], first: &Guide, second: &Guide, wanted: f32) -> f32 {
    let depth: f32 = touches.iter().filter_map(|t| t.pressed(first, second, wanted)).map(|p| p.depth).sum();
    depth * area(first, second)
}

/// Adds to `push` what moves one of the two parts (the first or the second) out of the contacts.
pub(crate) fn push(
    touches: &[Touch],
    (first, second): (&Guide, &Guide),
    moves_first: bool,
    (wanted, weight): (f32, f32),
    push: &mut Push,
) {
    let share = weight * area(first, second);
    for pressed in touches.iter().filter_map(|t| t.pressed(first, second, wanted)) {
        if moves_first {
            push.add(pressed.point1 - first.place, pressed.way, pressed.depth, share);
        } else {
            push.add(pressed.point2 - second.place, -pressed.way, pressed.depth, share);
        }
    }
}

/// Finds the contacts of two pieces nearer than `limit_mm` and adds them to the known ones: of every neighbourhood the
/// nearest.
pub(crate) fn find(task: &Task, first: &Piece, second: &Piece, limit_mm: f64, touches: &mut Vec<Touch>) {
    let (shape1, shape2) = (&task.kind(first.item).shape, &task.kind(second.item).shape);
    let pose12 = first.pose.seen(&second.pose);
    let pose21 = pose12.inverse();
    let cell_mm = 0.3 * shape1.radius_mm.min(shape2.radius_mm);
    let mut found: Vec<(glam::IVec3, f64, Touch)> = Vec::new();
    shape1.tree.contacts(&shape2.tree, &pose12, limit_mm, &mut |contact| {
        let distance = contact.distance_mm();
        let cell = (contact.point1 / cell_mm).floor().as_ivec3();
        let way = pose21.direction(contact.point1 - contact.point2) / distance;
        let touch = Touch {
            arm1: (contact.point1 - shape1.center).as_vec3(),
            arm2: (pose21.point(contact.point2) - shape2.center).as_vec3(),
            way2: way.as_vec3(),
        };
        match found.iter_mut().find(|known| known.0 == cell) {
            Some(known) if known.1 > distance => *known = (cell, distance, touch),
            Some(_) => {}
            None => found.push((cell, distance, touch)),
        }
    });
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    touches.splice(0..0, found.into_iter().map(|(_, _, touch)| touch));
    touches.truncate(MOST);
}
