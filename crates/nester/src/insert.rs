//! A copy more in a layout that stands: into a gap where there is one, else the parts around the best place make room.
//! Nobody starts over, and whoever stands far from it stays where he is.

use std::{collections::BTreeSet, sync::Arc};

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    Config, Instance, Listener, Placement, PreparedMeshes, Solution, Stop,
    boxes::Boxes,
    construct::Builder,
    course::Course,
    interlock::parted,
    layout::Layout,
    piece::{Piece, Task, height_mm, solution},
    recipe::Recipe,
    relocate::{DepthGrid, Effort, relocate},
    separate::{Outcome, Patience, separate},
    standing::standing,
};

/// Places at which room is made for a copy before it goes on top.
const PLACES: usize = 4;
/// Looks at a part among its neighbours, for each of those places.
const LOOKS: u64 = 1500;
/// How hard a place is looked for.
const EFFORT: Effort = Effort { asked: 2000, looked_at: 48, pushed: 3 };
/// Parts nearer to the copy than this share of its radius make room.
const AROUND: f64 = 0.5;
/// Parts no deeper in each other than this over the copy's section may be clear on the triangles, mm.
const NEARLY_MM: f32 = 0.02;
/// What of a height counts as no gain, mm.
const SAME_MM: f64 = 1e-6;

/// Puts the copies that `standing` lacks into it, as low as they find a gap; where there is none, the parts around the
/// best place make room, and else they go on top. Copies that the instance does not ask for any more are left out, so
/// this removes as well. A typical copy takes a fraction of a second; `stop` ends the making of room.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, Config, Instance, Item, PreparedMeshes, SearchBudget, insert, nest_with};
///
/// let clip = Arc::new(sample_parts::clip(22.0, 2.4, 14.0));
/// let volume = BuildVolume { size_mm: DVec3::new(60.0, 60.0, 120.0) };
/// let asked = |copies| Instance::new(volume, 1.5, vec![Item::new("clip", clip.clone(), copies)]);
/// let (config, prepared) = (Config::default(), PreparedMeshes::default());
/// let budget = || SearchBudget::of_evaluations(1000);
///
/// let five = nest_with(&asked(5)?, &config, &[], &prepared, &budget(), &mut ());
/// let seven = insert(&asked(7)?, &config, &five.placements, &prepared, &budget(), &mut ());
/// assert_eq!((five.placements.len(), seven.placements.len()), (5, 7));
///
/// let three = insert(&asked(3)?, &config, &seven.placements, &prepared, &budget(), &mut ());
/// assert_eq!(three.placements, seven.placements[..3]); // nobody moved
/// # Ok::<(), nester::InstanceError>(())
/// ```
pub fn insert(
    instance: &Instance,
    config: &Config,
    standing: &[Placement],
    prepared: &PreparedMeshes,
    stop: &dyn Stop,
    listener: &mut dyn Listener,
) -> Solution {
    Course::new(instance, config, prepared, stop, listener).insert_only(standing)
}

impl Course<'_> {
    /// Only puts in what is lacking.
    fn insert_only(mut self, start: &[Placement]) -> Solution {
        let Some(task) = self.task(Arc::new(self.lineup())) else {
            return solution(self.instance, &self.best, self.evaluations);
        };
        let standing = standing(&task, self.instance, start);
        self.offer(standing.clone());
        self.insert_each(&task, &standing, &lacking(&task, &standing));
        solution(self.instance, &self.best, self.evaluations)
    }

    /// Puts copies into a layout that stands, the largest first, and offers the layout.
    pub(super) fn insert_each(&mut self, task: &Task, standing: &[Piece], lacking: &[(usize, u32)]) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let recipe = Recipe::FIRST[0];
        let mut builder = Builder::new(task);
        let mut stack = builder.stack(standing);
        for copy in recipe.sorted(&task.lineup, lacking, &mut rng) {
            let before_mm = height_mm(&stack.pieces);
            let placed = builder.put(&recipe, copy, &mut stack);
            let grew = height_mm(&stack.pieces) > before_mm + SAME_MM && before_mm > 0.0;
            if placed && !grew || self.stop.spent(self.evaluations) >= 1.0 {
                continue;
            }
            // Without a place at all, the lid is the machine's own.
            let lid_mm = if placed { before_mm } else { task.room.z };
            let mut pieces = stack.pieces.clone();
            if !placed {
                pieces.push(task.piece(copy, task.lineup.candidate(copy.0).fitting, 0.5 * task.room));
            }
            if let Some(pieces) = self.make_room(task, &pieces, lid_mm, &mut rng) {
                stack = builder.stack(&pieces);
            }
        }
        // What would be locked in goes on top, from where it can always be lifted.
        let (free, locked) = if task.separable { parted(task, stack.pieces) } else { (stack.pieces, Vec::new()) };
        let locked: Vec<(usize, u32)> = locked.iter().map(|piece| (piece.item, piece.copy)).collect();
        self.offer(Boxes::new(&task.lineup).stack(&free, &locked));
    }

    /// Looks for a place of the last piece under a lid at which the parts around it can make room for it.
    fn make_room(&mut self, task: &Task, pieces: &[Piece], lid_mm: f64, rng: &mut ChaCha8Rng) -> Option<Vec<Piece>> {
        let mut layout = Layout::new(task, pieces, lid_mm);
        let (stands, promised, last) = (layout.stands.clone(), layout.fixed.clone(), pieces.len() - 1);
        let radius = layout.guides[last].shape.radius_mm as f32;
        let patience = Patience { rounds: 25, repairs: 8, nearly: NEARLY_MM * radius * radius };
        for _ in 0..PLACES {
            let before = layout.evaluations;
            layout.fixed.clone_from(&promised);
            layout.load(&stands);
            layout.forget();
            let mut grid = DepthGrid::new(&layout);
            relocate(&mut layout, &mut grid, last, EFFORT, rng);
            let reach = (AROUND * layout.guides[last].shape.radius_mm + task.reach_mm) as f32;
            for (part, promised) in promised.iter().enumerate().take(last) {
                let (here, there) = (&layout.guides[last], &layout.guides[part]);
                layout.fixed[part] = *promised || !here.is_near(there, reach);
            }
            let (stop, made) = (self.stop, self.evaluations);
            let over = |looks: u64| looks > before + LOOKS || stop.spent(made + looks - before) >= 1.0;
            let outcome = separate(&mut layout, patience, rng, over);
            self.evaluations += layout.evaluations - before;
            match outcome {
                Outcome::Clear(pieces) if task.keeps_cap(&pieces) => return Some(pieces),
                _ if self.stop.spent(self.evaluations) >= 1.0 => return None,
                _ => {}
            }
        }
        None
    }
}

/// Whether copies are few beside what stands: then they are put in, and nothing is built anew.
pub(super) fn are_few(lacking: &[(usize, u32)], standing: &[Piece]) -> bool {
    !standing.is_empty() && lacking.len() <= 4 + standing.len() / 4
}

/// Copies that neither stand nor are promised elsewhere, in order of precedence.
pub(super) fn lacking(task: &Task, standing: &[Piece]) -> Vec<(usize, u32)> {
    let taken: BTreeSet<(usize, u32)> = standing.iter().map(|p| (p.item, p.copy)).collect();
    let is_free = |copy: &&(usize, u32)| !taken.contains(copy) && !task.pins.contains(copy);
    task.copies.iter().filter(is_free).copied().collect()
}
