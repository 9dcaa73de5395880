//! The rims of the holes of a surface: closed loops of open edges.

use super::edges::EdgeUses;

/// The rim of a hole. Its edges run against those of the triangles beside it, as the triangles that close it will.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Rim {
    /// Its corners, in order.
    pub(super) corners: Vec<u32>,
    /// For each edge from a corner to the next one the triangle beside it.
    pub(super) beside: Vec<usize>,
}

/// All rims. Where several meet in a corner they are parted there, each as short as it can be. `None` = an open edge belongs to no loop.
pub(super) fn find_rims(uses: &EdgeUses) -> Option<Vec<Rim>> {
    let mut open: Vec<(u32, u32, usize)> = Vec::new();
    for at_edge in uses.edges() {
        if let [used] = at_edge {
            let (from, to) = used.ends();
            open.push((to, from, used.triangle()));
        }
    }
    open.sort_unstable();
    let mut is_used = vec![false; open.len()];
    let (mut rims, mut first_left) = (Vec::new(), 0);
    while first_left < open.len() {
        if is_used[first_left] {
            first_left += 1;
            continue;
        }
        // Walks along open edges; each time the walk comes back to a corner, what lies between is a rim.
        let mut path: Vec<usize> = Vec::new();
        let mut at = first_left;
        loop {
            is_used[at] = true;
            path.push(at);
            let end = open[at].1;
            if let Some(since) = path.iter().position(|&step| open[step].0 == end) {
                let loop_: Vec<usize> = path.drain(since..).collect();
                rims.push(Rim {
                    corners: loop_.iter().map(|&step| open[step].0).collect(),
                    beside: loop_.iter().map(|&step| open[step].2).collect(),
                });
            }
            let from = match path.last() {
                Some(&last) => open[last].1,
                None => break,
            };
            let begin = open.partition_point(|&(start, ..)| start < from);
            let free = (begin..open.len()).take_while(|&step| open[step].0 == from).find(|&step| !is_used[step]);
            at = free?;
        }
    }
    Some(rims)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_holes_that_meet_in_a_corner_are_two_rims() {
        // Six triangles of an octahedron: the two that are missing meet in corner 0.
        let ring = [1, 2, 3, 4];
        let mut triangles = Vec::new();
        for side in 0..4 {
            let (a, b) = (ring[side], ring[(side + 1) % 4]);
            if side % 2 == 0 {
                triangles.push([0, a, b]);
            }
            triangles.push([5, b, a]);
        }
        let rims = find_rims(&EdgeUses::of(&triangles)).expect("they are closed");
        assert_eq!(rims.iter().map(|rim| rim.corners.len()).collect::<Vec<_>>(), [3, 3]);
        assert!(rims.iter().all(|rim| rim.corners.contains(&0)));
    }
}
