//! What one part of many triangles costs on its way to a proved build: CPU seconds, wall seconds and peak memory of each
//! step.
//!
//! `cargo bench --bench large_meshes -- 1000000` makes a part of about so many triangles and takes it from its STL file to
//! the proof of the written build; `-- --file part.stl` takes a file. `--copies` is the number of copies in the build.
#![allow(clippy::print_stdout)] // a bench prints its measurements

#[path = "common/cpu_time.rs"]
mod cpu_time;
#[path = "common/memory.rs"]
mod memory;

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use anyhow::{Context, Result, ensure};
use build_file::{
    Arrangement, BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, DeliveryKind, LengthUnit,
    OrderWords, PlacedMesh, ReadLimits,
};
use clap::Parser;
use glam::{DQuat, DVec3};
use nester::{
    BuildVolume, LayoutProver, NestingConfig, NestingInstance, NestingItem, NestingSolution, PlacedSolid,
    PreparedMeshes, SearchComponents, StopCondition, nest_with_cache,
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use solids::{ClearanceTree, Mesh, Pose};

use cpu_time::cpu_secs;
use memory::status_mib;

/// Least distance of two copies, mm.
const CLEARANCE_MM: f64 = 3.0;
/// The greatest extent of the part that is made, mm.
const DIAMETER_MM: f64 = 120.0;

/// Measures each step of a build with one large mesh.
#[derive(Debug, Parser)]
struct LargeMeshArguments {
    /// Triangles of the part that is made.
    #[arg(default_value_t = 1_000_000)]
    triangles: u32,
    /// Writes its triangles in a random order, as some programs do.
    #[arg(long)]
    shuffled: bool,
    /// Measures this STL or 3MF file instead.
    #[arg(long)]
    file: Option<PathBuf>,
    /// Copies of the part in the build.
    #[arg(long, default_value_t = 2)]
    copies: u32,
    /// Threads of the preparation; 0 = one per core.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Set by cargo; no meaning here.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<()> {
    let arguments = LargeMeshArguments::parse();
    let folder = tempfile_folder()?;
    let part = match &arguments.file {
        Some(file) => file.clone(),
        None => make_part(&folder, arguments.triangles, arguments.shuffled)?,
    };
    println!("{:<40} {:>8} {:>8} {:>9} {:>9}", "step", "CPU s", "wall s", "peak MiB", "end MiB");
    let whole = measure_build(&part, &folder, &arguments);
    std::fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
    whole
}

/// A folder of this process for its files.
fn tempfile_folder() -> Result<PathBuf> {
    let folder = std::env::temp_dir().join(format!("large-meshes-{}", std::process::id()));
    std::fs::create_dir_all(&folder).with_context(|| format!("creating {}", folder.display()))?;
    Ok(folder)
}

/// Writes a boulder of about `triangles` triangles as binary STL.
fn make_part(folder: &Path, triangles: u32, shuffled: bool) -> Result<PathBuf> {
    let steps = (f64::from(triangles) / 12.0).sqrt().round() as u32;
    let mut mesh = sample_parts::boulder(DIAMETER_MM, steps);
    if shuffled {
        let mut order = mesh.triangles().to_vec();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        (1..order.len()).rev().for_each(|at| order.swap(at, (rng.next_u64() % (at as u64 + 1)) as usize));
        mesh = Mesh::new(mesh.vertices().to_vec(), order)?;
    }
    let file = folder.join("boulder.stl");
    let mut out = BufWriter::new(File::create(&file).context("creating the part's file")?);
    build_file::write_stl(std::iter::once((&mesh, &Pose::IDENTITY)), &mut out)?;
    out.flush()?;
    Ok(file)
}

fn measure_build(part: &Path, folder: &Path, arguments: &LargeMeshArguments) -> Result<()> {
    let limits = ReadLimits { max_unpacked_bytes: 64 << 30, ..ReadLimits::default() };
    let begun = StepClock::start();
    let mut contents = step("read the part's file", || {
        build_file::read_part_file(part, "boulder.stl", None, LengthUnit::Millimeter, &limits)
    })?;
    let mesh = contents.solids.remove(0).mesh;
    drop(contents);
    println!("{} triangles, {} vertices", mesh.triangles().len(), mesh.vertices().len());
    step("a box tree by itself", || ClearanceTree::new(mesh.clone()));
    let solution = search(&mesh, arguments, &begun)?;
    let build = build_of(&mesh, &solution, arguments.copies);
    let written = folder.join("boulder.build.3mf");
    step("write the build file", || -> Result<()> { Ok(build_file::write_build(&build, File::create(&written)?)?) })?;
    drop((build, mesh));
    println!("{:.1} MB of build file", std::fs::metadata(&written)?.len() as f64 * 1e-6);
    let proving = StepClock::start();
    let read = step("read the build file back", || build_file::read_build(&written, &limits))?;
    step("compare with the second reader", || build_file::cross_check(&written, &read, &limits))?;
    let bodies: Vec<PlacedSolid> = read.iter().map(placed_solid).collect();
    let prover = LayoutProver::new(&bodies, arguments.threads);
    let proof = step("prove the layout", || prover.prove_layout(DVec3::splat(1000.0), 0.0, &[]));
    ensure!(proof.is_proved(), "the layout is not proved: {proof:?}");
    let apart = step("prove that it comes apart", || prover.find_removal_order());
    ensure!(apart.locked.is_empty(), "parts are locked");
    proving.print("all from the build file to its proof");
    begun.print("all");
    println!("closest pair {:?} mm", proof.clearance_proved_mm);
    Ok(())
}

/// Ends a search after its first layouts.
struct FirstLayoutsOnly;

impl StopCondition for FirstLayoutsOnly {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        if evaluations == 0 { 0.0 } else { 1.0 }
    }
}

fn search(mesh: &Arc<Mesh>, arguments: &LargeMeshArguments, begun: &StepClock) -> Result<NestingSolution> {
    let item = NestingItem::new("boulder", mesh.clone(), arguments.copies);
    let size_mm = DVec3::splat(1000.0);
    let instance = NestingInstance::new(BuildVolume { size_mm }, CLEARANCE_MM, vec![item])?;
    let components = SearchComponents { fine_proxies: false, ..SearchComponents::default() };
    let config = NestingConfig { seed: 1, threads: arguments.threads, components, ..NestingConfig::default() };
    let prepared = PreparedMeshes::default();
    let mut is_first = true;
    let mut listener = |_: &NestingSolution, _: u64| {
        if std::mem::take(&mut is_first) {
            begun.print("from the file to stacked boxes");
        }
    };
    let solution = step("search the first layouts", || {
        nest_with_cache(&instance, &config, &[], &prepared, &FirstLayoutsOnly, &mut listener)
    });
    ensure!(solution.unplaced.is_empty(), "a copy found no place");
    begun.print("from the file to the first layouts");
    Ok(solution)
}

fn build_of(mesh: &Arc<Mesh>, solution: &NestingSolution, copies: u32) -> BuildFile {
    let item = |copy: u32| BuildFileItem {
        object: 0,
        pose: solution.placements[copy as usize].pose,
        words: OrderWords::default(),
        copy: copy + 1,
        source_name: "boulder.stl".to_owned(),
        source_hash: "0".to_owned(),
        clearance_mm: None,
        orientation: None,
        tilts: None,
    };
    let object = BuildFileObject {
        name: "boulder".to_owned(),
        mesh: mesh.clone(),
        part_number: "P-1".to_owned(),
        content_hash: "0".to_owned(),
    };
    BuildFile {
        heading: BuildFileHeading {
            title: "bench".to_owned(),
            application: "nestd bench".to_owned(),
            created: "2026-11-20T04:49:00Z".to_owned(),
            machine: "bench".to_owned(),
            build_id: "1".to_owned(),
            seed: 1,
        },
        rules: BuildFileRules {
            volume_mm: DVec3::splat(1000.0),
            keep_out: Vec::new(),
            margins_mm: DVec3::ZERO,
            clearance_mm: CLEARANCE_MM,
            clearance_z_extra_mm: 0.0,
            layer_mm: 0.1,
            layer_area_cap_mm2: None,
            interlock: "forbid".to_owned(),
        },
        height_mm: solution.height_mm,
        density: 0.1,
        objects: vec![object],
        items: (0..copies).map(item).collect(),
        delivery: DeliveryKind::Shared,
        arrangement: Arrangement::Items,
        thumbnail_png: None,
    }
}

fn placed_solid(placed: &PlacedMesh) -> PlacedSolid {
    PlacedSolid {
        name: placed.name.clone(),
        mesh: placed.mesh.clone(),
        pose: Pose::new(DQuat::IDENTITY, DVec3::ZERO).compose_with(&placed.pose),
        clearance_mm: CLEARANCE_MM,
    }
}

/// Runs a step and prints what it cost.
fn step<T>(name: &str, work: impl FnOnce() -> T) -> T {
    let clock = StepClock::start();
    let made = work();
    clock.print(name);
    made
}

/// What was used when a step began.
struct StepClock {
    cpu_secs: f64,
    wall: Instant,
}

impl StepClock {
    fn start() -> Self {
        // Sets the peak to what is resident now. Where that is not allowed, the peaks are those since the start.
        let _ = std::fs::write("/proc/self/clear_refs", "5");
        Self { cpu_secs: cpu_secs(), wall: Instant::now() }
    }

    fn print(&self, name: &str) {
        let (cpu_secs, wall_secs) = (cpu_secs() - self.cpu_secs, self.wall.elapsed().as_secs_f64());
        let (peak, end) = (status_mib("VmHWM:"), status_mib("VmRSS:"));
        println!("{name:<40} {cpu_secs:>8.3} {wall_secs:>8.3} {peak:>9.0} {end:>9.0}");
    }
}
