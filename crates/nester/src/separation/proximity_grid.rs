//! Finds the pieces near a place: a grid over the room in which each cell lists the pieces whose bounds touch it.

use glam::{DVec3, UVec3};
use solids::Bounds;

/// Greatest number of cells along the longest edge of the room.
const MAX_CELLS: f64 = 24.0;

/// Pieces by place. The caller identifies each piece by a number.
#[derive(Debug, Clone)]
pub(crate) struct ProximityGrid {
    pitch: DVec3,
    cells: UVec3,
    lists: Vec<Vec<u32>>,
}

impl ProximityGrid {
    /// An empty grid.
    pub(crate) fn new(room: DVec3) -> Self {
        let cells = (room * (MAX_CELLS / room.max_element())).ceil().as_uvec3().max(UVec3::ONE);
        Self { pitch: room / cells.as_dvec3(), cells, lists: vec![Vec::new(); cells.element_product() as usize] }
    }

    fn cells_touching(&self, bounds: &Bounds, reach_mm: f64) -> impl Iterator<Item = usize> + use<> {
        let last = (self.cells - 1).as_dvec3();
        let clamp = |place: DVec3| (place / self.pitch).floor().clamp(DVec3::ZERO, last).as_uvec3();
        let (low, high, cells) = (clamp(bounds.min - reach_mm), clamp(bounds.max + reach_mm), self.cells);
        (low.z..=high.z).flat_map(move |z| {
            let row = move |y| (low.x..=high.x).map(move |x| ((z * cells.y + y) * cells.x + x) as usize);
            (low.y..=high.y).flat_map(row)
        })
    }

    /// Adds a piece.
    pub(crate) fn insert_bounds(&mut self, number: usize, bounds: &Bounds) {
        for cell in self.cells_touching(bounds, 0.0) {
            self.lists[cell].push(number as u32);
        }
    }

    /// Removes a piece that was added with the same bounds.
    pub(crate) fn remove_bounds(&mut self, number: usize, bounds: &Bounds) {
        for cell in self.cells_touching(bounds, 0.0) {
            let list = &mut self.lists[cell];
            if let Some(at) = list.iter().position(|&known| known == number as u32) {
                list.swap_remove(at);
            }
        }
    }

    /// Numbers of the pieces that may be nearer to `bounds` than `reach_mm`, without duplicates, in rising order.
    pub(crate) fn query_near(&self, bounds: &Bounds, reach_mm: f64) -> Vec<usize> {
        let mut found: Vec<usize> = self
            .cells_touching(bounds, reach_mm)
            .flat_map(|cell| self.lists[cell].iter().map(|&n| n as usize))
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn nobody_near_is_missed(
            corners in proptest::collection::vec(proptest::array::uniform3(-5.0..105.0f64), 1..40),
            size in 0.1..60.0f64, reach_mm in 0.0..9.0f64,
        ) {
            let mut near = ProximityGrid::new(DVec3::new(100.0, 40.0, 70.0));
            let at = |c: &[f64; 3]| { let min = DVec3::from_array(*c); Bounds { min, max: min + size } };
            let bounds: Vec<Bounds> = corners.iter().map(at).collect();
            for (number, here) in bounds.iter().enumerate() {
                // First at another place, like a piece that moves.
                let before = Bounds { min: here.min * 0.7, max: here.max * 0.7 };
                near.insert_bounds(number, &before);
                near.remove_bounds(number, &before);
                near.insert_bounds(number, here);
            }
            prop_assert_eq!(near.query_near(&Bounds { min: DVec3::splat(-9.0), max: DVec3::splat(200.0) }, 0.0).len(), bounds.len());
            for one in &bounds {
                let found = near.query_near(one, reach_mm);
                prop_assert!(found.is_sorted_by(|a, b| a < b));
                for (number, other) in bounds.iter().enumerate() {
                    prop_assert!(one.distance(other) >= reach_mm || found.contains(&number));
                }
            }
        }
    }
}
