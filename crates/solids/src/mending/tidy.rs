//! Leaves out triangles that say nothing about a solid: doubled ones, and those that hang on it by one edge.

use super::edges::EdgeUses;

/// Triangles that hang on one another are taken away from the outside in, so many times at most.
const MAX_ROUNDS: usize = 8;

/// Which triangles stay.
pub(super) fn kept_triangles(triangles: &[[u32; 3]]) -> Vec<bool> {
    let mut kept = vec![true; triangles.len()];
    leave_out_doubled(triangles, &mut kept);
    for _ in 0..MAX_ROUNDS {
        if !leave_out_hanging(triangles, &mut kept) {
            break;
        }
    }
    kept
}

/// Of triangles with the same corners the first one stays; those that face opposite ways cancel out in pairs.
fn leave_out_doubled(triangles: &[[u32; 3]], kept: &mut [bool]) {
    let turned = |&[a, b, c]: &[u32; 3]| {
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        // A rotation of the sorted corners, or a mirrored one.
        let is_even = [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted);
        (sorted, is_even)
    };
    let mut all: Vec<([u32; 3], usize, bool)> = triangles
        .iter()
        .enumerate()
        .map(|(at, corners)| {
            let (sorted, is_even) = turned(corners);
            (sorted, at, is_even)
        })
        .collect();
    all.sort_unstable();
    for same in all.chunk_by(|one, other| one.0 == other.0).filter(|same| same.len() > 1) {
        let even = same.iter().filter(|triangle| triangle.2).count();
        let odd = same.len() - even;
        let stays = (even != odd).then(|| same.iter().find(|triangle| triangle.2 == (even > odd))).flatten();
        for &(_, at, _) in same {
            kept[at] = stays.is_some_and(|stays| stays.1 == at);
        }
    }
}

/// Leaves out triangles of which one edge is the third one at an edge of others, and the other edges are open. Returns whether any did.
fn leave_out_hanging(triangles: &[[u32; 3]], kept: &mut [bool]) -> bool {
    let numbers: Vec<usize> = (0..triangles.len()).filter(|&at| kept[at]).collect();
    let left: Vec<[u32; 3]> = numbers.iter().map(|&at| triangles[at]).collect();
    let uses = EdgeUses::of(&left);
    let mut open = vec![0_u8; left.len()];
    uses.edges().filter(|uses| uses.len() == 1).for_each(|uses| open[uses[0].triangle()] += 1);
    let mut any = false;
    for at_edge in uses.edges().filter(|uses| uses.len() > 2) {
        let mut hanging = at_edge.iter().map(|used| used.triangle()).filter(|&triangle| open[triangle] == 2);
        // Of two that hang on a sound pair or less, nobody knows which is meant.
        if let (Some(one), None, 3) = (hanging.next(), hanging.next(), at_edge.len()) {
            kept[numbers[one]] = false;
            any = true;
        }
    }
    any
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    #[test]
    fn doubled_and_hanging_triangles_are_left_out_and_the_solid_stays() {
        let mut triangles = TETRAHEDRON.to_vec();
        triangles.push([1, 0, 2]);
        triangles.push([0, 1, 4]);
        assert_eq!(kept_triangles(&triangles), [true, true, true, true, false, false]);
        triangles[4] = [1, 2, 0];
        assert_eq!(
            kept_triangles(&triangles),
            [false, true, true, true, false, true],
            "two that face each other cancel out"
        );
    }
}
