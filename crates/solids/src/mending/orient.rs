//! Turns triangles so that all of a piece face the same way: by flood fill over the edges of two triangles, then the way most of the
//! surface faces.

use super::edges::EdgeUses;

/// The pieces of a surface that hang together by edges of two triangles, all of each facing one way.
#[derive(Debug)]
pub(super) struct Facing {
    /// The piece of each triangle.
    pub(super) piece_of: Vec<usize>,
    /// Whether a triangle is to be turned.
    pub(super) is_turned: Vec<bool>,
    /// For each piece the share of its area that is turned, 0.5 at most.
    pub(super) turned_share: Vec<f64>,
}

/// Which triangles are to be turned. `None` = there is a piece with one side only.
pub(super) fn find_facing(triangles: &[[u32; 3]], areas: &[f64]) -> Option<Facing> {
    // The neighbours over edges of two triangles, and whether they face different ways.
    let mut neighbours: Vec<(u32, u32, bool)> = Vec::new();
    for uses in EdgeUses::of(triangles).edges() {
        if let [one, other] = *uses {
            let (first, second) = (one.triangle() as u32, other.triangle() as u32);
            let differs = one.ends() == other.ends();
            neighbours.extend([(first, second, differs), (second, first, differs)]);
        }
    }
    neighbours.sort_unstable();
    let around = |triangle: usize| {
        let from = neighbours.partition_point(|&(one, ..)| (one as usize) < triangle);
        neighbours[from..].iter().take_while(move |&&(one, ..)| one as usize == triangle)
    };
    const NONE: usize = usize::MAX;
    let mut facing = Facing {
        piece_of: vec![NONE; triangles.len()],
        is_turned: vec![false; triangles.len()],
        turned_share: Vec::new(),
    };
    for start in 0..triangles.len() {
        if facing.piece_of[start] != NONE {
            continue;
        }
        let piece = facing.turned_share.len();
        facing.piece_of[start] = piece;
        let (mut members, mut next) = (vec![start], 0);
        while let Some(&triangle) = members.get(next) {
            next += 1;
            for &(_, other, differs) in around(triangle) {
                let (other, wanted) = (other as usize, facing.is_turned[triangle] != differs);
                if facing.piece_of[other] == NONE {
                    (facing.piece_of[other], facing.is_turned[other]) = (piece, wanted);
                    members.push(other);
                } else if facing.is_turned[other] != wanted {
                    return None;
                }
            }
        }
        facing.turn_fewer(&members, areas);
    }
    Some(facing)
}

impl Facing {
    /// Of the two ways to have a piece face one way, takes the one that turns less of its area.
    fn turn_fewer(&mut self, members: &[usize], areas: &[f64]) {
        let whole: f64 = members.iter().map(|&at| areas[at]).sum();
        let turned: f64 = members.iter().filter(|&&at| self.is_turned[at]).map(|&at| areas[at]).sum();
        if 2.0 * turned > whole {
            members.iter().for_each(|&at| self.is_turned[at] = !self.is_turned[at]);
        }
        self.turned_share.push(if whole > 0.0 { turned.min(whole - turned) / whole } else { 0.0 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fewer_triangles_of_a_piece_are_turned_and_a_band_with_one_side_is_told() {
        let mut triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        triangles[2].swap(0, 1);
        let facing = find_facing(&triangles, &[1.0; 4]).expect("it has two sides");
        assert_eq!(facing.is_turned, [false, false, true, false]);
        assert_eq!((facing.piece_of, facing.turned_share), (vec![0; 4], vec![0.25]));
        // A Moebius band of five triangles.
        let band = [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]];
        assert!(find_facing(&band, &[1.0; 5]).is_none());
    }
}
