//! Where else could a part stand? Flower pollination over the whole volume: cheap questions to an occupancy grid, the best
//! answers by overlap, the very best pushed out of it.

use glam::{DQuat, DVec3, Vec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    Orientation, OrientationRule,
    first_turns::first_turns,
    layout::{Layout, Stand},
    push::Guide,
};
use crate::pollination::{Edge, Gene, Pollination, Setup};

/// Cells of the occupancy grid, about.
const CELLS: f32 = 40_000.0;
/// Flowers of a part that are kept for its next relocation.
const KEPT_FLOWERS: usize = 16;
/// Depths are summed in fixed point, so that taking a part out again leaves nothing.
const DEPTH_UNIT: f32 = 64.0;

/// How deep every cell's middle lies in the parts (grown by their clearance), summed over all parts.
pub(crate) struct DepthGrid {
    pitch: f32,
    cells: [usize; 3],
    depths: Vec<i32>,
    drawn: Vec<Option<Guide>>,
    reach: f32,
}

impl DepthGrid {
    /// An empty grid for a layout.
    pub(crate) fn new(layout: &Layout<'_>) -> Self {
        let room = layout.task.room.with_z(layout.lid_mm).as_vec3();
        let pitch = (room.element_product() / CELLS).cbrt().max(0.5);
        let cells = (room / pitch).ceil().max(Vec3::ONE).to_array().map(|n| n as usize);
        let depths = vec![0; cells.iter().product()];
        Self { pitch, cells, depths, drawn: vec![None; layout.len()], reach: layout.task.reach_mm as f32 }
    }

    /// Draws every part where it stands now, except `left_out`.
    pub(crate) fn follow(&mut self, layout: &Layout<'_>, left_out: usize) {
        for part in 0..layout.len() {
            let now = &layout.guides[part];
            let tolerance = 0.3 * self.pitch;
            let stays = self.drawn[part].as_ref().is_some_and(|drawn| {
                part != left_out
                    && (drawn.min - now.min).abs().max_element() < tolerance
                    && (drawn.max - now.max).abs().max_element() < tolerance
            });
            if stays {
                continue;
            }
            if let Some(drawn) = self.drawn[part].take() {
                self.draw(&drawn, -1);
            }
            if part != left_out {
                self.draw(now, 1);
                self.drawn[part] = Some(now.clone());
            }
        }
    }

    fn draw(&mut self, guide: &Guide, sign: i32) {
        let low = ((guide.min - self.reach) / self.pitch).max(Vec3::ZERO).to_array().map(|n| n as usize);
        let high = ((guide.max + self.reach) / self.pitch + 1.0).max(Vec3::ZERO).to_array().map(|n| n as usize);
        let back = guide.turn.transpose();
        for z in low[2]..high[2].min(self.cells[2]) {
            for y in low[1]..high[1].min(self.cells[1]) {
                for x in low[0]..high[0].min(self.cells[0]) {
                    let middle = (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * self.pitch;
                    let depth = self.reach - guide.shape.field.distance(back * (middle - guide.place));
                    if depth > 0.0 {
                        let cell = (z * self.cells[1] + y) * self.cells[0] + x;
                        self.depths[cell] += sign * (depth * DEPTH_UNIT) as i32;
                    }
                }
            }
        }
    }

    /// Mean depth of a guide's points.
    fn depth(&self, guide: &Guide) -> f64 {
        let scale = 1.0 / self.pitch;
        let most = Vec3::new(self.cells[0] as f32, self.cells[1] as f32, self.cells[2] as f32) - 1.0;
        let points = guide.shape.coarse.points();
        let sum: i64 = (points.iter())
            .map(|&p| {
                let at = ((guide.turn * p + guide.place) * scale).clamp(Vec3::ZERO, most);
                let cell = (at.z as usize * self.cells[1] + at.y as usize) * self.cells[0] + at.x as usize;
                i64::from(self.depths[cell])
            })
            .sum();
        sum as f64 / points.len() as f64
    }
}

/// How a genome stands for a rotation of a part.
struct Turning<'t> {
    orientation: &'t Orientation,
    bases: Vec<DQuat>,
}

impl<'t> Turning<'t> {
    fn new(layout: &Layout<'t>, part: usize) -> Self {
        let kind = layout.task.kind(layout.copies[part].0);
        let room = layout.task.room.with_z(layout.lid_mm);
        let mut bases = match kind.orientation.rule {
            OrientationRule::Fixed => vec![DQuat::IDENTITY],
            _ => first_turns(&kind.orientation, kind.shape.frame, &kind.shape.extremes, room, 24),
        };
        bases.push(layout.stands[part].turn);
        Self { orientation: &kind.orientation, bases }
    }

    fn genes(&self) -> Vec<Gene> {
        let gene = |upper: f64, edge: Edge| Gene { lower: 0.0, upper, edge };
        let turning = [gene(2.0, Edge::Wrap), gene(1.0, Edge::Reflect), gene(1.0, Edge::Wrap), gene(1.0, Edge::Wrap)];
        turning.into_iter().chain([gene(1.0, Edge::Reflect); 3]).collect()
    }

    /// The first gene below 1 picks one of the bases; above, the other three turn freely as far as the rule allows.
    fn turn(&self, genome: &[f64]) -> DQuat {
        let base = |share: f64| self.bases[((share * self.bases.len() as f64) as usize).min(self.bases.len() - 1)];
        match self.orientation.rule {
            _ if genome[0] < 1.0 => base(genome[0]),
            OrientationRule::Free => {
                let genes = [genome[1], genome[2], genome[3]];
                self.orientation.turn_of_genes(genes).unwrap_or_else(|| base(genome[0] - 1.0))
            }
            OrientationRule::Upright => DQuat::from_rotation_z(genome[2] * std::f64::consts::TAU),
            OrientationRule::Axis | OrientationRule::Fixed => base(genome[0] - 1.0),
        }
    }
}

/// A stand of a part anywhere in the room, at any rotation that its rule allows; its own where that one finds no room.
pub(crate) fn anywhere(layout: &Layout<'_>, part: usize, rng: &mut ChaCha8Rng) -> Stand {
    let turning = Turning::new(layout, part);
    let genome: Vec<f64> = turning.genes().iter().map(|gene| rng.random_range(gene.lower..gene.upper)).collect();
    let turn = turning.turn(&genome);
    let mut guide = layout.guides[part].clone();
    guide.set(turn, DVec3::ZERO);
    let (min, max) = (guide.min.as_dvec3(), guide.max.as_dvec3());
    let free = layout.task.room.with_z(layout.lid_mm) - (max - min);
    if free.min_element() < 0.0 {
        return layout.stands[part];
    }
    Stand { turn, place: DVec3::new(genome[4], genome[5], genome[6]) * free - min }
}

/// How much work a relocation may cost.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Questions to the occupancy grid.
    pub(crate) asked: usize,
    /// Candidates looked at by coarse overlap.
    pub(crate) looked_at: usize,
    /// Candidates pushed out.
    pub(crate) pushed: usize,
}

/// Moves a part to a better place when there is one: less weighted overlap than where it stands.
pub(crate) fn relocate(
    layout: &mut Layout<'_>,
    grid: &mut DepthGrid,
    part: usize,
    effort: Effort,
    rng: &mut ChaCha8Rng,
) -> bool {
    let here = layout.energy_at(part, &layout.guides[part], false, f32::INFINITY);
    relocate_below(layout, grid, part, effort, here, rng)
}

/// Moves a part to the best other place that is found, better or not.
pub(crate) fn move_away(
    layout: &mut Layout<'_>,
    grid: &mut DepthGrid,
    part: usize,
    effort: Effort,
    rng: &mut ChaCha8Rng,
) {
    relocate_below(layout, grid, part, effort, f32::INFINITY, rng);
}

/// Moves a part to the best place that is found where it has less weighted overlap than `energy`.
fn relocate_below(
    layout: &mut Layout<'_>,
    grid: &mut DepthGrid,
    part: usize,
    effort: Effort,
    energy: f32,
    rng: &mut ChaCha8Rng,
) -> bool {
    grid.follow(layout, part);
    let turning = Turning::new(layout, part);
    let mut guide = layout.guides[part].clone();
    let candidates = propose(layout, part, grid, &turning, &mut guide, effort, rng);
    layout.evaluations += (effort.asked / 40) as u64;
    let mut ranked: Vec<(f32, Stand)> = Vec::with_capacity(candidates.len());
    for stand in candidates {
        let least = if ranked.len() < effort.pushed { f32::INFINITY } else { ranked[effort.pushed - 1].0 };
        let stand = layout.clamp(&mut guide, stand);
        layout.evaluations += 1;
        let energy = layout.energy_at(part, &guide, true, least);
        if energy < least {
            let at = ranked.partition_point(|(known, _)| *known <= energy);
            ranked.insert(at, (energy, stand));
            ranked.truncate(effort.pushed);
        }
    }
    let here = layout.stands[part];
    let mut best = (energy, here);
    for (_, stand) in ranked {
        layout.set(part, stand);
        for _ in 0..5 {
            if layout.step(part) <= 0.0 {
                break;
            }
        }
        let energy = layout.energy_at(part, &layout.guides[part], false, best.0);
        if energy < best.0 {
            best = (energy, layout.stands[part]);
            if energy <= 0.0 {
                break;
            }
        }
    }
    layout.set(part, best.1);
    best.1.place != here.place
}

/// The best stands that the flowers found, by depth in the occupancy grid.
fn propose(
    layout: &mut Layout<'_>,
    part: usize,
    grid: &DepthGrid,
    turning: &Turning<'_>,
    guide: &mut Guide,
    effort: Effort,
    rng: &mut ChaCha8Rng,
) -> Vec<Stand> {
    let even = !layout.task.organs.flowers_in_relocation;
    let setup = Setup { population: 40, switch_probability: 0.4, even, ..Setup::default() };
    // The layout changes little from one relocation of a part to the next: its best flowers go on growing.
    let before = if even { Vec::new() } else { std::mem::take(&mut layout.flowers[part]) };
    let mut flowers = Pollination::new(setup, turning.genes(), rng.random()).starting_at(before);
    let room = layout.task.room.with_z(layout.lid_mm);
    let mut best: Vec<(f64, Stand)> = Vec::with_capacity(effort.looked_at + 1);
    for _ in 0..effort.asked {
        let genome = flowers.ask();
        let turn = turning.turn(genome);
        let share = DVec3::new(genome[4], genome[5], genome[6]);
        guide.set(turn, DVec3::ZERO);
        let (min, max) = (guide.min.as_dvec3(), guide.max.as_dvec3());
        let free = room - (max - min);
        if free.min_element() < 0.0 {
            flowers.tell(1e9 - free.min_element());
            continue;
        }
        let place = share * free - min;
        guide.place = place.as_vec3();
        let depth = grid.depth(guide);
        flowers.tell(depth);
        if best.len() < effort.looked_at || best.last().is_some_and(|(worst, _)| depth < *worst) {
            let at = best.partition_point(|(known, _)| *known <= depth);
            best.insert(at, (depth, Stand { turn, place }));
            best.truncate(effort.looked_at);
        }
    }
    if !even {
        layout.flowers[part] = flowers.ranked().into_iter().take(KEPT_FLOWERS).map(<[f64]>::to_vec).collect();
    }
    best.into_iter().map(|(_, stand)| stand).collect()
}
