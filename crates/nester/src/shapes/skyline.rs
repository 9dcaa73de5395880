//! A height map of the base for stacking boxes: the first layout that always succeeds, and the fallback for all others.

use glam::{DVec3, IVec2};
use solids::Bounds;

use crate::problem::fit_check::WALL_SPARE_MM;

/// A zone that begins no higher than this stands on the floor, mm.
const ON_FLOOR_MM: f64 = 1.0;
/// Distance that boxes keep from a zone above them, mm.
const ZONE_SPARE_MM: f64 = 1e-3;

/// For each cell of the base, the top of what is placed there.
#[derive(Debug, Clone)]
pub(crate) struct SkylineGrid {
    room: DVec3,
    cells: IVec2,
    pitch: DVec3,
    tops: Vec<f64>,
    /// The height of the lowest zone above each cell, negated so that the greatest value is the lowest zone; empty
    /// without zones.
    ceilings: Vec<f64>,
}

impl SkylineGrid {
    /// An empty base with about `cell_target` cells.
    pub(crate) fn new(room: DVec3, cell_target: f64) -> Self {
        let pitch = (room.x * room.y / cell_target).sqrt();
        let cells = IVec2::new((room.x / pitch).ceil() as i32, (room.y / pitch).ceil() as i32).max(IVec2::ONE);
        let pitch = DVec3::new(room.x / f64::from(cells.x), room.y / f64::from(cells.y), 0.0);
        Self { room, cells, pitch, tops: vec![0.0; (cells.x * cells.y) as usize], ceilings: Vec::new() }
    }

    /// Cells that a range along one axis touches.
    fn touched_cells(&self, low: f64, high: f64, axis: usize) -> (i32, i32) {
        let (pitch, count) = (self.pitch[axis], self.cells[axis]);
        let first = ((low / pitch + 1e-9).floor() as i32).clamp(0, count - 1);
        (first, ((high / pitch - 1e-9).ceil() as i32 - 1).clamp(first, count - 1))
    }

    /// The lowest position for a box inside the room, at least `floor_mm` above the lowest in an empty room, as its least
    /// corner. Boxes keep `clearance_mm` from the boxes below them and sideways.
    pub(crate) fn lowest_position(&self, size: DVec3, clearance_mm: f64, floor_mm: f64) -> Option<DVec3> {
        let room = self.room - 2.0 * WALL_SPARE_MM;
        if size.cmpgt(room).any() {
            return None;
        }
        // Start positions along x: at every cell's edge, and flush with the far wall. The same along y.
        let starts = |axis: usize| {
            let far = room[axis] - size[axis];
            let count = ((far / self.pitch[axis]).floor() as i32 + 1).max(1);
            (0..count).map(move |n| f64::from(n) * self.pitch[axis]).chain([far]).collect::<Vec<f64>>()
        };
        let (xs, ys) = (starts(0), starts(1));
        let wide: Vec<(i32, i32)> =
            xs.iter().map(|&x| self.touched_cells(x - clearance_mm, x + size.x + clearance_mm, 0)).collect();
        let deep: Vec<(i32, i32)> =
            ys.iter().map(|&y| self.touched_cells(y - clearance_mm, y + size.y + clearance_mm, 1)).collect();
        let rows = self.row_maxima(&self.tops, &wide);
        let ceilings = self.row_maxima(&self.ceilings, &wide);
        let mut best: Option<(f64, DVec3)> = None;
        for (at_x, &x) in xs.iter().enumerate() {
            let column = &rows[at_x * self.cells.y as usize..(at_x + 1) * self.cells.y as usize];
            let ceiling = ceilings.get(at_x * self.cells.y as usize..(at_x + 1) * self.cells.y as usize);
            let (mut window, mut above) = (SlidingMaximum::default(), SlidingMaximum::default());
            for (at_y, &y) in ys.iter().enumerate() {
                let top = window.maximum_in(column, deep[at_y].0 as usize, deep[at_y].1 as usize);
                let z = if top > 0.0 { (top + clearance_mm).max(floor_mm) } else { floor_mm };
                let lowest = ceiling.map(|line| -above.maximum_in(line, deep[at_y].0 as usize, deep[at_y].1 as usize));
                let fits_below = lowest.is_none_or(|lowest| z + size.z + ZONE_SPARE_MM <= lowest);
                if fits_below && best.is_none_or(|(least, _)| z < least) {
                    best = Some((z, DVec3::new(x, y, z)));
                }
            }
        }
        best.filter(|(z, _)| z + size.z <= room.z).map(|(_, corner)| corner + WALL_SPARE_MM)
    }

    /// For every x range, the greatest value in every row; stored at index range * rows + row.
    fn row_maxima(&self, values: &[f64], ranges: &[(i32, i32)]) -> Vec<f64> {
        if values.is_empty() {
            return Vec::new();
        }
        let (nx, ny) = (self.cells.x as usize, self.cells.y as usize);
        let mut maxima = vec![0.0; ranges.len() * ny];
        for row in 0..ny {
            let line = &values[row * nx..(row + 1) * nx];
            let mut window = SlidingMaximum::default();
            for (at, &(first, last)) in ranges.iter().enumerate() {
                maxima[at * ny + row] = window.maximum_in(line, first as usize, last as usize);
            }
        }
        maxima
    }

    /// Keeps boxes out of a zone: none is placed in it, and none above it unless the zone stands on the floor.
    pub(crate) fn add_keep_out(&mut self, zone: &Bounds) {
        if zone.min.z <= ON_FLOOR_MM {
            return self.add_box(zone);
        }
        if self.ceilings.is_empty() {
            self.ceilings = vec![f64::NEG_INFINITY; self.tops.len()];
        }
        let (x0, x1) = self.touched_cells(zone.min.x, zone.max.x, 0);
        let (y0, y1) = self.touched_cells(zone.min.y, zone.max.y, 1);
        for y in y0..=y1 {
            for x in x0..=x1 {
                let ceiling = &mut self.ceilings[(y * self.cells.x + x) as usize];
                *ceiling = ceiling.max(-zone.min.z);
            }
        }
    }

    /// Adds a box.
    pub(crate) fn add_box(&mut self, bounds: &Bounds) {
        let (x0, x1) = self.touched_cells(bounds.min.x, bounds.max.x, 0);
        let (y0, y1) = self.touched_cells(bounds.min.y, bounds.max.y, 1);
        for y in y0..=y1 {
            for x in x0..=x1 {
                let top = &mut self.tops[(y * self.cells.x + x) as usize];
                *top = top.max(bounds.max.z);
            }
        }
    }
}

/// The maximum of a window that only moves forward.
#[derive(Default)]
struct SlidingMaximum {
    falling: std::collections::VecDeque<usize>,
    next: usize,
}

impl SlidingMaximum {
    fn maximum_in(&mut self, line: &[f64], first: usize, last: usize) -> f64 {
        while self.next <= last {
            while self.falling.back().is_some_and(|&at| line[at] <= line[self.next]) {
                self.falling.pop_back();
            }
            self.falling.push_back(self.next);
            self.next += 1;
        }
        while self.falling.front().is_some_and(|&at| at < first) {
            self.falling.pop_front();
        }
        self.falling.front().map_or(0.0, |&at| line[at])
    }
}
