//! Tests of the paper's method on small instances; on request also on the shared workloads.

use std::{collections::HashMap, sync::Arc};

use glam::DVec3;
use sample_parts::fixtures::{block, mesh_from_data, star};
use solids::{ClearanceTree, Mesh};

use super::*;
use crate::{BuildVolume, NestingConfig, NestingItem, NestingMethod, OrientationRule, PaperConfig};

/// A budget of evaluations.
struct PaperTestBudget(u64);

impl StopCondition for PaperTestBudget {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        evaluations as f64 / self.0 as f64
    }
}

/// A budget of CPU seconds, so that other work on the machine does not count.
struct PaperCpuBudget(f64, f64);

fn cpu_secs() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("the tests run on Linux");
    text.split(' ').next().and_then(|n| n.parse::<f64>().ok()).expect("starts with nanoseconds") * 1e-9
}

impl StopCondition for PaperCpuBudget {
    fn spent_share_at(&self, _: u64) -> f64 {
        (cpu_secs() - self.0) / self.1
    }
}

fn item(mesh: Arc<Mesh>, copies: u32, orientation: OrientationRule) -> NestingItem {
    NestingItem { name: "part".into(), mesh, copies, orientation: orientation.into(), clearance_mm: None }
}

fn instance(size: [f64; 3], clearance_mm: f64, items: Vec<NestingItem>) -> NestingInstance {
    NestingInstance::new(BuildVolume { size_mm: DVec3::from_array(size) }, clearance_mm, items).unwrap()
}

fn config(paper: PaperConfig) -> NestingConfig {
    NestingConfig { method: NestingMethod::Paper, seed: 3, paper, ..NestingConfig::default() }
}

fn quick() -> NestingConfig {
    config(PaperConfig { population: 20, iterations: 15, max_layouts: 3, ..PaperConfig::default() })
}

fn run(instance: &NestingInstance, config: &NestingConfig, evaluations: u64) -> NestingSolution {
    nest_paper(instance, config, &PaperTestBudget(evaluations), &mut |_: &NestingSolution, _: u64| ())
}

/// Checks a solution independently: walls, every pair on the triangles, every copy listed once.
fn holds(instance: &NestingInstance, solution: &NestingSolution) -> bool {
    let trees: Vec<ClearanceTree> = instance.items().iter().map(|i| ClearanceTree::new(i.mesh.clone())).collect();
    let volume = Bounds { min: DVec3::ZERO, max: instance.volume().size_mm };
    let placed = &solution.placements;
    let walls = placed.iter().all(|p| volume.contains_bounds(&instance.items()[p.item].mesh.bounds_at(&p.pose), -1e-6));
    let apart = placed.iter().enumerate().all(|(i, one)| {
        placed[..i].iter().all(|two| {
            let clearance = instance.clearance_between_mm(one.item, two.item);
            let pose12 = one.pose.relative_pose_of(&two.pose);
            !trees[one.item].is_closer_than(&trees[two.item], &pose12, clearance - 1e-6)
                && !trees[one.item].contains_part(&trees[two.item], &pose12)
                && !trees[two.item].contains_part(&trees[one.item], &pose12.inverse())
        })
    });
    let mut copies: Vec<(usize, u32)> =
        placed.iter().map(|p| (p.item, p.copy)).chain(solution.unplaced.clone()).collect();
    copies.sort_unstable();
    copies.dedup();
    walls && apart && copies.len() == instance.copy_count() && placed.len() + solution.unplaced.len() == copies.len()
}

fn mixed() -> NestingInstance {
    let bumpy = star(2, |d| 8.0 + 2.0 * (4.0 * d.x).sin());
    let rules = [OrientationRule::Free, OrientationRule::Upright, OrientationRule::Axis, OrientationRule::Fixed];
    let bars = rules.map(|rule| item(block(30.0, 8.0, 5.0), 2, rule));
    instance([60.0, 50.0, 100.0], 2.0, [vec![item(bumpy, 3, OrientationRule::Free)], bars.to_vec()].concat())
}

#[test]
fn every_copy_gets_a_place_that_keeps_clearance_walls_and_rules() {
    let instance = mixed();
    let solution = run(&instance, &quick(), 100_000);
    assert!(solution.unplaced.is_empty() && holds(&instance, &solution), "{solution:?}");
    assert!(solution.height_mm > 5.0 && solution.height_mm <= 100.0);
    for placement in &solution.placements {
        let (up, east) = (placement.pose.transform_direction(DVec3::Z), placement.pose.transform_direction(DVec3::X));
        match instance.items()[placement.item].orientation.rule {
            OrientationRule::Free => {}
            OrientationRule::Upright => assert!(up.z > 1.0 - 1e-9),
            OrientationRule::Axis => {
                assert!(up.abs().max_element() > 1.0 - 1e-9 && east.abs().max_element() > 1.0 - 1e-9)
            }
            OrientationRule::Fixed => assert!(up.z > 1.0 - 1e-9 && east.x > 1.0 - 1e-9),
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_layout_and_another_seed_another() {
    let instance = mixed();
    let one = run(&instance, &quick(), 30_000);
    assert_eq!(one, run(&instance, &quick(), 30_000));
    assert_ne!(one.placements, run(&instance, &NestingConfig { seed: 4, ..quick() }, 30_000).placements);
}

#[test]
fn what_does_not_fit_is_reported_and_the_rest_is_placed() {
    let items = vec![
        item(block(70.0, 4.0, 4.0), 1, OrientationRule::Free),
        item(block(10.0, 10.0, 10.0), 2, OrientationRule::Free),
    ];
    let instance = instance([30.0, 30.0, 15.0], 1.0, items);
    let solution = run(&instance, &quick(), 50_000);
    assert_eq!(solution.unplaced, [(0, 0)]);
    assert!(holds(&instance, &solution) && solution.height_mm >= 10.0 - 1e-9);
}

#[test]
fn a_full_container_leaves_copies_over() {
    let instance = instance([22.0, 22.0, 10.0], 1.0, vec![item(block(10.0, 10.0, 10.0), 9, OrientationRule::Fixed)]);
    let solution = run(&instance, &quick(), 50_000);
    assert!(!solution.placements.is_empty() && solution.unplaced.len() >= 5 && holds(&instance, &solution));
}

#[test]
fn a_budget_that_is_spent_already_still_gives_a_layout() {
    let instance = mixed();
    struct CancelledPaperSearch;
    impl StopCondition for CancelledPaperSearch {
        fn spent_share_at(&self, _: u64) -> f64 {
            f64::INFINITY
        }
    }
    let solution = nest_paper(&instance, &quick(), &CancelledPaperSearch, &mut |_: &NestingSolution, _: u64| ());
    assert!(solution.unplaced.is_empty() && holds(&instance, &solution), "{solution:?}");
}

#[test]
fn a_part_is_not_put_inside_a_larger_ones_solid() {
    // The shell is so large that the small one fits deep inside its solid without touching any box of its surface.
    let items =
        vec![item(star(3, |_| 30.0), 1, OrientationRule::Free), item(block(4.0, 4.0, 4.0), 6, OrientationRule::Free)];
    let instance = instance([62.0, 62.0, 120.0], 1.0, items);
    let solution = run(&instance, &quick(), 60_000);
    assert!(solution.unplaced.is_empty() && holds(&instance, &solution));
}

#[test]
fn each_convergence_condition_ends_the_search() {
    let instance = instance([40.0, 40.0, 60.0], 1.0, vec![item(block(10.0, 8.0, 5.0), 4, OrientationRule::Free)]);
    let layouts = |paper: PaperConfig, evaluations: u64| {
        let paper = PaperConfig { population: 10, iterations: 10, ..paper };
        let solution = run(&instance, &config(paper.clone()), evaluations);
        assert!(solution.unplaced.is_empty());
        solution
    };
    let off = PaperConfig { max_layouts: 50, ..PaperConfig::default() };
    let long = layouts(off.clone(), u64::MAX);
    let once = layouts(PaperConfig { max_layouts: 1, ..off.clone() }, u64::MAX);
    assert!(long.height_mm <= once.height_mm && long.evaluations >= once.evaluations);
    let target = layouts(PaperConfig { target_height_mm: 55.0, ..off.clone() }, u64::MAX);
    assert_eq!(target, once, "the first layout is low enough");
    let equal = layouts(PaperConfig { relative_height_error: 1e9, ..off.clone() }, u64::MAX);
    assert!(equal.evaluations <= 2 * once.evaluations + 10_000, "ends after two layouts");
    let timed = layouts(off, once.evaluations / 2);
    assert!(timed.evaluations <= once.evaluations);
}

#[test]
fn the_listener_hears_every_better_layout() {
    let mut improvements: Vec<(usize, f64)> = Vec::new();
    let instance = mixed();
    let solution = nest_paper(&instance, &quick(), &PaperTestBudget(200_000), &mut |s: &NestingSolution, _: u64| {
        improvements.push((s.placements.len(), s.height_mm));
    });
    assert!(
        improvements.windows(2).all(|w| w[1].0 > w[0].0 || w[1].0 == w[0].0 && w[1].1 < w[0].1),
        "{improvements:?}"
    );
    assert_eq!(improvements.last(), Some(&(solution.placements.len(), solution.height_mm)));
}

/// A shared workload, or `None` when `NESTD_DATA` does not say where it is.
fn workload(name: &str) -> Option<NestingInstance> {
    let text = |ending: &str| {
        let file = format!("{}/workloads/{name}.{ending}", std::env::var("NESTD_DATA").ok()?);
        Some(std::fs::read_to_string(file).expect("the workload is there"))
    };
    let json: serde_json::Value = serde_json::from_str(&text("json")?).unwrap();
    let size = [0, 1, 2].map(|i| json["volume_mm"][i].as_f64().unwrap());
    let mut meshes: HashMap<String, Arc<Mesh>> = HashMap::new();
    let csv = text("csv")?;
    let items = csv.lines().skip(1).map(|line| {
        let (file, copies) = line.rsplit_once(',').unwrap();
        let mesh = meshes.entry(file.into()).or_insert_with(|| mesh_from_data(file).expect("the data are there"));
        NestingItem { name: file.into(), ..item(mesh.clone(), copies.parse().unwrap(), OrientationRule::Free) }
    });
    let items = items.collect();
    Some(instance(size, json["clearance_mm"].as_f64().unwrap(), items))
}

/// `NESTD_PAPER=fan20:60,small_273:60` names workloads and CPU seconds.
#[test]
#[allow(clippy::print_stderr)]
fn shared_workloads_are_nested() {
    let wanted = std::env::var("NESTD_PAPER").unwrap_or_else(|_| "fan20:1".into());
    for (name, secs) in wanted.split(',').filter_map(|w| w.split_once(':')) {
        let Some(instance) = workload(name) else {
            return eprintln!("skipped: NESTD_DATA is not set");
        };
        let stop = PaperCpuBudget(cpu_secs(), secs.parse().unwrap());
        let mut curve = Vec::new();
        let solution =
            nest_paper(&instance, &config(PaperConfig::default()), &stop, &mut |s: &NestingSolution, _: u64| {
                curve.push(format!("{:.0}s {}: {:.1}", cpu_secs() - stop.0, s.placements.len(), s.height_mm));
            });
        eprintln!(
            "{name}: {:.1} mm, {} placed, {} not, {} evaluations; {}",
            solution.height_mm,
            solution.placements.len(),
            solution.unplaced.len(),
            solution.evaluations,
            curve.join(", ")
        );
        assert!(holds(&instance, &solution));
    }
}
