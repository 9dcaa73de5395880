//! Taking a layout apart: in which order, and along which straight lines, parts can be drawn out of it one after the other,
//! and which parts are locked into each other. Whatever goes first makes nothing harder for the rest, so that taking the
//! first part that can go is exact for a fixed set of ways.

use glam::DVec3;
use solids::{Bounds, ClearanceTree, Pose};

use super::piece::{Piece, Task};

/// What a part keeps from all others while it is drawn out, at most, mm: what loose powder and warped parts ask for.
const MOST_GAP_MM: f64 = 0.5;
/// The same at clearance 0, where parts stand this far apart twice over.
const LEAST_GAP_MM: f64 = 5e-5;
/// What the search keeps beyond the gap, mm, so that rounding in a written file never locks a part.
const GAP_SPARE_MM: f64 = 2e-5;

/// Number of ways that a part may take.
pub(crate) const WAYS: usize = 26;

/// Of them those up and along the axes, which come first.
const AXIS_WAYS: usize = 6;

/// The ways that a part may take, unit vectors: up first, then along the axes, the edges and the corners of a cube.
pub(crate) fn ways() -> [DVec3; WAYS] {
    let mut ways = [DVec3::Z; WAYS];
    let mut at = 1;
    for axes in 1..=3 {
        for code in 0..27 {
            let way = DVec3::new(f64::from(code % 3 - 1), f64::from(code / 3 % 3 - 1), f64::from(code / 9 - 1));
            if way.length_squared() as i32 == axes && way != DVec3::Z {
                ways[at] = way.normalize();
                at += 1;
            }
        }
    }
    ways
}

/// What two parts keep from each other while one of them is drawn out, mm, by the clearance that they keep at rest: half of
/// it, at most half a millimetre.
///
/// ```
/// assert_eq!((nester::drawing_gap_mm(0.6), nester::drawing_gap_mm(3.0)), (0.3, 0.5));
/// ```
pub fn drawing_gap_mm(clearance_mm: f64) -> f64 {
    (0.5 * clearance_mm).clamp(LEAST_GAP_MM, MOST_GAP_MM)
}

/// A placed part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solid<'a> {
    tree: &'a ClearanceTree,
    pose: &'a Pose,
    bounds: &'a Bounds,
    clearance_mm: f64,
}

impl<'a> Solid<'a> {
    fn new(task: &'a Task, piece: &'a Piece) -> Self {
        let kind = task.kind(piece.item);
        Self { tree: &kind.shape.tree, pose: &piece.pose, bounds: &piece.bounds, clearance_mm: kind.clearance_mm }
    }

    fn gap_mm(&self, other: &Self) -> f64 {
        drawing_gap_mm(self.clearance_mm.max(other.clearance_mm)) + GAP_SPARE_MM
    }

    /// Whether the boxes around both leave it open that this part meets the other on its way.
    fn may_meet(&self, other: &Self, way: DVec3) -> bool {
        let gap = self.gap_mm(other);
        let (low, high) = (other.bounds.min - self.bounds.max - gap, other.bounds.max - self.bounds.min + gap);
        let (mut begin, mut end) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            if way[axis] == 0.0 {
                if low[axis] > 0.0 || high[axis] < 0.0 {
                    return false;
                }
                continue;
            }
            let (one, two) = (low[axis] / way[axis], high[axis] / way[axis]);
            (begin, end) = (begin.max(one.min(two)), end.min(one.max(two)));
        }
        begin <= end
    }

    fn is_free(&self, other: &Self, way: DVec3) -> bool {
        let way1 = self.pose.rotation.conjugate() * way;
        self.tree.is_free_along(other.tree, &self.pose.seen(other.pose), way1, self.gap_mm(other))
    }
}

/// Whether a piece that is not among `others` can be drawn out from between them along an axis; slanted ways cost more to
/// ask than they find.
pub(crate) fn can_leave(task: &Task, piece: &Piece, others: &[Piece]) -> bool {
    let solid = Solid::new(task, piece);
    // Who stands nearest is the likeliest to bar a way.
    let mut nearest: Vec<(f64, Solid<'_>)> =
        others.iter().map(|other| (piece.bounds.distance(&other.bounds), Solid::new(task, other))).collect();
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_free =
        |way: DVec3| nearest.iter().all(|(_, other)| !solid.may_meet(other, way) || solid.is_free(other, way));
    ways().into_iter().take(AXIS_WAYS).any(is_free)
}

/// One part leaves along one way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Leave {
    pub(crate) part: usize,
    pub(crate) way: usize,
}

/// How far a layout could be taken apart.
#[derive(Debug, Clone, Default)]
pub(crate) struct Dismantled {
    /// Who left, in this order.
    pub(crate) leaves: Vec<Leave>,
    /// Who cannot leave, in order.
    pub(crate) locked: Vec<usize>,
    /// Sweeps of one part past another.
    pub(crate) sweeps: u64,
}

/// Takes pieces apart; `known` is an order that served a similar layout and is tried first.
pub(crate) fn dismantle(task: &Task, pieces: &[Piece], known: &[Leave]) -> Dismantled {
    let solids = pieces.iter().map(|piece| Solid::new(task, piece)).collect();
    let mut work = Work::new(solids);
    for leave in known.iter().filter(|leave| leave.part < pieces.len()) {
        work.try_leave(leave.part, leave.way);
    }
    while work.leave_upwards() || work.leave_anyhow() {}
    let locked = (0..pieces.len()).filter(|&part| !work.gone[part]).collect();
    Dismantled { leaves: work.leaves, locked, sweeps: work.sweeps }
}

/// The pieces that must go so that all others can be taken apart: of those who are locked the smallest, again and again. In
/// order.
pub(crate) fn in_the_way(task: &Task, pieces: &[Piece]) -> Vec<usize> {
    let volume = |part: usize| task.kind(pieces[part].item).shape.tree.mesh().volume_mm3();
    let mut work = Work::new(pieces.iter().map(|piece| Solid::new(task, piece)).collect());
    let mut dropped = Vec::new();
    loop {
        while work.leave_upwards() || work.leave_anyhow() {}
        let locked = (0..pieces.len()).filter(|&part| !work.gone[part]);
        let Some(smallest) = locked.min_by(|&a, &b| volume(a).total_cmp(&volume(b))) else { break };
        work.gone[smallest] = true;
        dropped.push(smallest);
    }
    dropped.sort_unstable();
    dropped
}

/// Pairs among the locked parts that are locked by themselves: neither can leave the other, whatever else is taken away.
pub(crate) fn locked_pairs(task: &Task, pieces: &[Piece], locked: &[usize]) -> Vec<(usize, usize)> {
    let ways = ways();
    let mut pairs = Vec::new();
    for (at, &one) in locked.iter().enumerate() {
        let solid1 = Solid::new(task, &pieces[one]);
        for &other in &locked[at + 1..] {
            let solid2 = Solid::new(task, &pieces[other]);
            if ways.into_iter().all(|way| solid1.may_meet(&solid2, way) && !solid1.is_free(&solid2, way)) {
                pairs.push((one, other));
            }
        }
    }
    pairs
}

/// How far it is known who bars a part's way, in the order from the top.
#[derive(Debug, Clone, Copy, Default)]
struct Asked {
    /// All before this one do not stand in the way, or are gone.
    next: u32,
    /// Whether this one does.
    barred: bool,
}

/// A layout while it is being taken apart.
struct Work<'a> {
    solids: Vec<Solid<'a>>,
    ways: [DVec3; WAYS],
    /// For every part and way how far the others were asked: no two parts are asked about the same way twice.
    asked: Vec<[Asked; WAYS]>,
    /// Parts from the highest top to the lowest.
    from_top: Vec<usize>,
    gone: Vec<bool>,
    leaves: Vec<Leave>,
    sweeps: u64,
}

impl<'a> Work<'a> {
    fn new(solids: Vec<Solid<'a>>) -> Self {
        let mut from_top: Vec<usize> = (0..solids.len()).collect();
        from_top.sort_by(|&a, &b| solids[b].bounds.max.z.total_cmp(&solids[a].bounds.max.z));
        let (asked, gone) = (vec![[Asked::default(); WAYS]; solids.len()], vec![false; solids.len()]);
        Self { solids, ways: ways(), asked, from_top, gone, leaves: Vec::new(), sweeps: 0 }
    }

    /// Takes a part away when nothing stands in its way.
    fn try_leave(&mut self, part: usize, way: usize) -> bool {
        if self.gone[part] || self.is_barred(part, way) {
            return false;
        }
        self.gone[part] = true;
        self.leaves.push(Leave { part, way });
        true
    }

    fn is_barred(&mut self, part: usize, way: usize) -> bool {
        let (solid, line) = (&self.solids[part], self.ways[way]);
        let asked = &mut self.asked[part][way];
        while let Some(other) = self.from_top.get(asked.next as usize).copied() {
            if other != part && !self.gone[other] {
                if !asked.barred && solid.may_meet(&self.solids[other], line) {
                    self.sweeps += 1;
                    asked.barred = !solid.is_free(&self.solids[other], line);
                }
                if asked.barred {
                    return true;
                }
            }
            *asked = Asked { next: asked.next + 1, barred: false };
        }
        false
    }

    /// Everybody who can leaves upwards, the highest first. Whether anybody did.
    fn leave_upwards(&mut self) -> bool {
        let before = self.leaves.len();
        for at in 0..self.from_top.len() {
            self.try_leave(self.from_top[at], 0);
        }
        self.leaves.len() > before
    }

    /// The highest part that can leave at all does so. Whether there was one.
    fn leave_anyhow(&mut self) -> bool {
        (0..self.from_top.len()).any(|at| (1..WAYS).any(|way| self.try_leave(self.from_top[at], way)))
    }
}
