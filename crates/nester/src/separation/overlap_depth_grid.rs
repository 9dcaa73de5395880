//! Where a room is full: a grid in which a relocation looks up many places of a part before any overlap is worked out.

use glam::{Vec3, Vec4};

use super::{separation_step::CollisionProxy, working_layout::WorkingLayout};
use crate::shapes::point_block::{BLOCK_POINTS, BlockMotion, PointBlock, floor_values, to_indices};

/// Approximate number of cells of the grid.
const CELLS: f32 = 40_000.0;
/// Depths are summed in fixed point, so that removing a part restores the grid exactly.
const DEPTH_UNIT: f32 = 64.0;
/// Points of a candidate that are looked up before it is compared with what is known.
const POINTS_PER_LOOK: usize = 16;

/// For every cell, the depth of its centre inside the parts (grown by their clearance), summed over all parts.
pub(crate) struct OverlapDepthGrid {
    pitch: f32,
    cells: [usize; 3],
    depths: Vec<i32>,
    added: Vec<AddedPart>,
    reach: f32,
}

/// What a part added to the grid.
#[derive(Default, Clone)]
struct AddedPart {
    /// Its bounds then, mm; `None` when it is not in the grid.
    bounds: Option<(Vec3, Vec3)>,
    /// Cells and depths.
    depths: Vec<(u32, i32)>,
}

impl OverlapDepthGrid {
    /// An empty grid for a layout.
    pub(crate) fn new(layout: &WorkingLayout<'_>) -> Self {
        let room = layout.prepared.room.with_z(layout.height_limit_mm).as_vec3();
        let pitch = (room.element_product() / CELLS).cbrt().max(0.5);
        let cells = (room / pitch).ceil().max(Vec3::ONE).to_array().map(|n| n as usize);
        let depths = vec![0; cells.iter().product()];
        Self {
            pitch,
            cells,
            depths,
            added: vec![AddedPart::default(); layout.part_count()],
            reach: layout.prepared.max_clearance_mm as f32,
        }
    }

    /// Updates the grid to the present pose of every part, except `left_out`, which is removed from it.
    pub(crate) fn update_parts(&mut self, layout: &WorkingLayout<'_>, left_out: usize) {
        for part in 0..layout.part_count() {
            let now = &layout.proxies[part];
            let tolerance = 0.3 * self.pitch;
            let stays = self.added[part].bounds.is_some_and(|(min, max)| {
                part != left_out
                    && (min - now.min).abs().max_element() < tolerance
                    && (max - now.max).abs().max_element() < tolerance
            });
            if stays {
                continue;
            }
            let AddedPart { bounds, mut depths } = std::mem::take(&mut self.added[part]);
            if bounds.is_some() {
                depths.iter().for_each(|&(cell, depth)| self.depths[cell as usize] -= depth);
                depths.clear();
            }
            let bounds = (part != left_out).then(|| {
                self.find_depths(now, &mut depths);
                depths.iter().for_each(|&(cell, depth)| self.depths[cell as usize] += depth);
                (now.min, now.max)
            });
            self.added[part] = AddedPart { bounds, depths };
        }
    }

    /// Finds the cells whose centres are in a part, and their depths.
    fn find_depths(&self, proxy: &CollisionProxy, depths: &mut Vec<(u32, i32)>) {
        let low = ((proxy.min - self.reach) / self.pitch).max(Vec3::ZERO).to_array().map(|n| n as usize);
        let high = ((proxy.max + self.reach) / self.pitch + 1.0).max(Vec3::ZERO).to_array().map(|n| n as usize);
        let back = BlockMotion::new(proxy.rotation.transpose(), Vec3::ZERO);
        let middle = |cell: usize| (cell as f32 + 0.5) * self.pitch;
        let end = high[0].min(self.cells[0]);
        for z in low[2]..high[2].min(self.cells[2]) {
            for y in low[1]..high[1].min(self.cells[1]) {
                for first in (low[0]..end).step_by(BLOCK_POINTS) {
                    let middles = PointBlock {
                        x: Vec4::from_array([0, 1, 2, 3].map(|x| middle(first + x))) - proxy.center.x,
                        y: Vec4::splat(middle(y) - proxy.center.y),
                        z: Vec4::splat(middle(z) - proxy.center.z),
                    };
                    let distances = proxy.shape.distance_field.block_distances(&back.move_block(&middles), self.reach);
                    let cell = (z * self.cells[1] + y) * self.cells[0] + first;
                    for (x, distance) in distances.to_array().into_iter().enumerate().take(end - first) {
                        let depth = self.reach - distance;
                        if depth > 0.0 {
                            depths.push(((cell + x) as u32, (depth * DEPTH_UNIT) as i32));
                        }
                    }
                }
            }
        }
    }

    /// Mean depth of a proxy's points. Where it is not below `enough`, perhaps of some of them only.
    pub(crate) fn mean_depth(&self, proxy: &CollisionProxy, enough: f64) -> f64 {
        let [cells_x, cells_y, cells_z] = self.cells.map(|count| count as f32);
        let scale = 1.0 / self.pitch;
        let cell =
            |place: Vec4, cells: f32| floor_values((place * scale).max(Vec4::ZERO).min(Vec4::splat(cells - 1.0)));
        let motion = BlockMotion::new(proxy.rotation, proxy.center);
        let points = proxy.shape.coarse_points.points();
        let mut sum = 0_i64;
        for some in points.chunks(POINTS_PER_LOOK) {
            for block in some.chunks(BLOCK_POINTS) {
                let there = motion.move_block(&PointBlock::from_points(block));
                let row = cell(there.z, cells_z) * cells_y + cell(there.y, cells_y);
                let cells = to_indices(row * cells_x + cell(there.x, cells_x));
                sum += cells[..block.len()].iter().map(|&cell| i64::from(self.depths[cell])).sum::<i64>();
            }
            if sum as f64 / points.len() as f64 >= enough {
                break;
            }
        }
        sum as f64 / points.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::{
        BuildVolume, NestingInstance, NestingItem,
        tests::testing::{coarsely_prepared, hollow},
    };

    #[test]
    fn the_mean_depth_is_that_of_the_cells_of_all_points() {
        let size_mm = DVec3::new(60.0, 50.0, 80.0);
        let items = vec![NestingItem::new("box", hollow(30.0, 2.0), 1)];
        let instance = NestingInstance::new(BuildVolume { size_mm }, 1.0, items).expect("fits");
        let prepared = coarsely_prepared(&instance);
        let piece = prepared.place_item((0, 0), DQuat::IDENTITY, 0.5 * size_mm);
        let layout = WorkingLayout::new(&prepared, &[piece], size_mm.z);
        let mut grid = OverlapDepthGrid::new(&layout);
        // Every cell has a depth of its own, so that a wrong one shows.
        grid.depths.iter_mut().zip(1..).for_each(|(depth, own)| *depth = own);
        let mut proxy = layout.proxies[0].clone();
        for place in [DVec3::new(30.0, 25.0, 40.0), DVec3::new(58.0, 45.0, 78.0), DVec3::new(3.0, 4.0, 2.0)] {
            proxy.set_pose(DQuat::from_rotation_y(0.3), place);
            let points = proxy.shape.coarse_points.points();
            assert_ne!(points.len() % BLOCK_POINTS, 0, "the last block is not full");
            let depth = |&point: &Vec3| {
                let place = (proxy.rotation * point + proxy.center) * (1.0 / grid.pitch);
                let [x, y, z] = [0, 1, 2].map(|axis| (place[axis].max(0.0) as usize).min(grid.cells[axis] - 1));
                f64::from(grid.depths[(z * grid.cells[1] + y) * grid.cells[0] + x])
            };
            let mean = points.iter().map(depth).sum::<f64>() / points.len() as f64;
            assert_eq!(grid.mean_depth(&proxy, f64::INFINITY), mean);
            let enough = grid.mean_depth(&proxy, 0.5 * mean);
            assert!((0.5 * mean..mean).contains(&enough), "{enough} of {mean}");
        }
    }
}
