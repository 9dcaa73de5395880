//! Puts the triangles of a large mesh in an order in which neighbours in space are neighbours in memory. Some programs write
//! triangles in a random order; every later pass over such a mesh would wait for memory at each corner.

use glam::DVec3;

use crate::Bounds;

/// Smaller meshes fit in a cache, so they keep their order.
const MIN_TRIANGLES: usize = 200_000;
/// A triangle that follows another one is a jump if their first corners are numbered farther apart.
const JUMP_VERTICES: u32 = 4096;
/// Share of jumps from which a mesh counts as scattered.
const SCATTERED_SHARE: f64 = 0.25;
/// Bits of a place along each axis.
const AXIS_BITS: u32 = 10;

/// Orders triangles and vertices along a space-filling curve if the mesh is large and scattered.
pub(super) fn put_in_local_order(vertices: &mut Vec<DVec3>, triangles: &mut Vec<[u32; 3]>) {
    if triangles.len() >= MIN_TRIANGLES && is_scattered(triangles) {
        order_along_curve(vertices, triangles);
    }
}

fn is_scattered(triangles: &[[u32; 3]]) -> bool {
    let jumps = triangles.windows(2).filter(|pair| pair[0][0].abs_diff(pair[1][0]) > JUMP_VERTICES).count();
    jumps as f64 > SCATTERED_SHARE * triangles.len() as f64
}

fn order_along_curve(vertices: &mut Vec<DVec3>, triangles: &mut Vec<[u32; 3]>) {
    let bounds = Bounds::from_points(vertices.iter().copied());
    let scale = f64::from((1_u32 << AXIS_BITS) - 1) / bounds.size().max(DVec3::splat(1e-300));
    let code = |corners: &[u32; 3]| {
        let at = (vertices[corners[0] as usize] - bounds.min) * scale;
        spread_bits(at.x as u32) | spread_bits(at.y as u32) << 1 | spread_bits(at.z as u32) << 2
    };
    // The place in the old order makes all keys different, so that the new order is always the same.
    let coded = |(at, corners): (usize, &[u32; 3])| u64::from(code(corners)) << 32 | at as u64;
    let mut order: Vec<u64> = triangles.iter().enumerate().map(coded).collect();
    order.sort_unstable();
    const UNSEEN: u32 = u32::MAX;
    let mut renumbered = vec![UNSEEN; vertices.len()];
    let mut moved = Vec::with_capacity(vertices.len());
    let reordered = order.iter().map(|&key| {
        triangles[key as u32 as usize].map(|vertex| {
            let known = &mut renumbered[vertex as usize];
            if *known == UNSEEN {
                *known = moved.len() as u32;
                moved.push(vertices[vertex as usize]);
            }
            *known
        })
    });
    *triangles = reordered.collect();
    *vertices = moved;
}

/// Moves ten bits two places apart from each other (the Morton code of one axis).
fn spread_bits(value: u32) -> u32 {
    let value = (value | value << 16) & 0x0300_00ff;
    let value = (value | value << 8) & 0x0300_f00f;
    let value = (value | value << 4) & 0x030c_30c3;
    (value | value << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_by_three() {
        for value in [0, 1, 2, 3, 0b10_1010_1010, 1023] {
            let wanted = (0..10).map(|bit| (value >> bit & 1) << (3 * bit)).sum::<u32>();
            assert_eq!(spread_bits(value), wanted, "{value}");
        }
    }

    #[test]
    fn an_order_along_the_curve_keeps_every_triangle_with_its_direction() {
        let places: Vec<DVec3> =
            (0..512).map(|i| DVec3::new(f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64))).collect();
        let scattered: Vec<[u32; 3]> = (0..512_u32).map(|i| [i * 37 % 512, i * 91 % 512, (i * 53 + 7) % 512]).collect();
        let corners = |vertices: &[DVec3], triangles: &[[u32; 3]]| {
            let mut all: Vec<[[u64; 3]; 3]> =
                (triangles.iter()).map(|t| t.map(|v| vertices[v as usize].to_array().map(f64::to_bits))).collect();
            all.sort_unstable();
            all
        };
        let (mut vertices, mut triangles) = (places.clone(), scattered.clone());
        order_along_curve(&mut vertices, &mut triangles);
        assert_eq!(corners(&vertices, &triangles), corners(&places, &scattered));
        assert!(triangles[0].contains(&0) && triangles != scattered);
        let (mut few, mut same) = (places.clone(), scattered.clone());
        put_in_local_order(&mut few, &mut same);
        assert_eq!((few, same), (places, scattered), "a small mesh keeps its order");
    }
}
