//! The door: Instance -> Solution.

use super::{Config, Instance, Listener, Placement, Solution, Stop};

/// Nests. `start` is an earlier layout of (part of) the same instance to go on from; copies that it lacks are inserted.
/// Always returns a layout in which every placement is inside the volume and keeps its clearance on the triangles;
/// copies that found no place are in `unplaced`.
pub fn nest(
    instance: &Instance,
    _config: &Config,
    start: &[Placement],
    _stop: &dyn Stop,
    _listener: &mut dyn Listener,
) -> Solution {
    let unplaced = (instance.items().iter().enumerate()).flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)));
    Solution { placements: start.to_vec(), unplaced: unplaced.collect(), height_mm: 0.0, evaluations: 0 }
}
