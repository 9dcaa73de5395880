//! Removes duplicates of a piece of a surface at the same place: as a solid they are one piece, and all later steps
//! would process each of them.

use std::collections::HashMap;

/// A surface without duplicates has about two triangles per vertex. Below this number per vertex, duplicates are not
/// searched.
const SUSPICIOUS: usize = 3;

/// If a connected piece consists of the same triangles several times over, keeps them once; the order is kept. Edges
/// that cancelled in pairs still do.
pub(super) fn keep_one_of_equal_pieces(triangles: Vec<[u32; 3]>, vertices: usize) -> Vec<[u32; 3]> {
    if triangles.len() < SUSPICIOUS * vertices {
        return triangles;
    }
    let mut times: HashMap<[u32; 3], u32> = HashMap::new();
    for &corners in &triangles {
        *times.entry(least_corner_first(corners)).or_default() += 1;
    }
    if times.len() == triangles.len() {
        return triangles;
    }
    let mut piece: Vec<u32> = (0..vertices as u32).collect();
    for &[a, b, c] in times.keys() {
        let top = find_root(&mut piece, a);
        for other in [b, c] {
            let other = find_root(&mut piece, other);
            piece[other as usize] = top;
        }
    }
    // Number of copies of a piece: the common divisor of the counts of its triangles.
    let mut copies = vec![0_u32; vertices];
    for (&[a, ..], &times) in &times {
        let at = find_root(&mut piece, a) as usize;
        copies[at] = common_divisor(copies[at], times);
    }
    let mut left: HashMap<[u32; 3], u32> = times;
    left.iter_mut().for_each(|([a, ..], times)| *times /= copies[find_root(&mut piece, *a) as usize].max(1));
    let mut kept = triangles;
    kept.retain(|&corners| match left.get_mut(&least_corner_first(corners)) {
        Some(0) | None => false,
        Some(more) => {
            *more -= 1;
            true
        }
    });
    kept
}

/// A triangle's corners rotated so that the least one comes first.
fn least_corner_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

fn find_root(above: &mut [u32], mut vertex: u32) -> u32 {
    while above[vertex as usize] != vertex {
        above[vertex as usize] = above[above[vertex as usize] as usize];
        vertex = above[vertex as usize];
    }
    vertex
}

fn common_divisor(mut a: u32, mut b: u32) -> u32 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    #[test]
    fn of_equal_pieces_in_one_place_one_is_left_and_others_stay() {
        let other = TETRAHEDRON.map(|t| t.map(|v| v + 4));
        let mut triangles: Vec<[u32; 3]> = TETRAHEDRON.iter().copied().cycle().take(4 * 99).collect();
        triangles.extend(other);
        let kept = keep_one_of_equal_pieces(triangles, 8);
        assert_eq!(kept, [TETRAHEDRON, other].concat());
    }

    #[test]
    fn a_triangle_that_is_there_twice_among_single_ones_stays() {
        let mut triangles: Vec<[u32; 3]> = TETRAHEDRON.iter().copied().cycle().take(4 * 6).collect();
        triangles.push(TETRAHEDRON[0]);
        assert_eq!(keep_one_of_equal_pieces(triangles.clone(), 4), triangles);
    }
}
