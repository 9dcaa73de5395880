//! Sets of parts for benches: many copies of one part, all different, and random ones by seed; and the workloads of the
//! public benchmark, with the files from which other packers read them.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// A set of parts to nest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleWorkload {
    /// 20 axial fans of 65 x 65 x 22 mm.
    Fans,
    /// 30 different parts, as in an engine, one copy each; for a base of at least 120 x 120 mm.
    EngineLike,
    /// `copies` small parts of `meshes` different random meshes.
    Small {
        /// Copies of all parts together.
        copies: u32,
        /// Different meshes.
        meshes: u32,
        /// Seed of the meshes.
        seed: u64,
    },
    /// `copies` figures of `meshes` different random meshes: soft bodies with bent limbs, 40 to 110 mm across.
    Organic {
        /// Copies of all figures together.
        copies: u32,
        /// Different meshes.
        meshes: u32,
        /// Seed of the meshes.
        seed: u64,
    },
    /// 42 frames, cages and rings of 20 to 100 mm that can hold each other; for a base of at least 120 x 120 mm.
    Cages,
    /// Two different bent parts, `each` copies of each.
    Twins {
        /// Copies of each part.
        each: u32,
    },
    /// `wheels` wheels of 212 x 25 mm, and fifteen engine-like parts half as large again. Lower than in one pile the wheels
    /// lie only when some lean: for a base that is a little too small for two piles, like 420 x 220 mm.
    Wheels {
        /// Copies of the wheel.
        wheels: u32,
    },
    /// The same with ten windows of 200 x 200 x 22 mm, and twenty engine-like parts a fifth larger; for a base like
    /// 390 x 390 mm.
    Windows,
    /// 48 long rails and ducts of 60 to 200 mm.
    Tall,
}

/// A workload of the public benchmark: what is to be packed, on which base, and how far apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedWorkload {
    /// Name in tables and of its files.
    pub name: &'static str,
    /// Its parts.
    pub parts: SampleWorkload,
    /// Length and width of the base, mm.
    pub base_mm: [f64; 2],
    /// Least distance between two copies, mm.
    pub clearance_mm: f64,
}

/// Height of the room above each base, mm: more than any build needs, because only heights are compared.
pub const COMPARED_ROOM_MM: f64 = 600.0;

/// The workloads whose heights are compared. What has a name here never changes: results of others refer to it.
pub const COMPARED_WORKLOADS: [ComparedWorkload; 13] = [
    compared("fans20", SampleWorkload::Fans, [200.0, 200.0], 3.0),
    compared("engine30", SampleWorkload::EngineLike, [150.0, 150.0], 3.0),
    compared("small200", SampleWorkload::Small { copies: 200, meshes: 40, seed: 7 }, [160.0, 160.0], 2.0),
    compared("small600", SampleWorkload::Small { copies: 600, meshes: 60, seed: 7 }, [250.0, 250.0], 2.0),
    compared("organic88", SampleWorkload::Organic { copies: 88, meshes: 22, seed: 11 }, [200.0, 250.0], 2.0),
    compared("cages42", SampleWorkload::Cages, [160.0, 160.0], 3.0),
    compared("twins120", SampleWorkload::Twins { each: 60 }, [180.0, 180.0], 2.0),
    compared("bulk400", SampleWorkload::Small { copies: 400, meshes: 80, seed: 7 }, [380.0, 284.0], 3.0),
    compared("tall48", SampleWorkload::Tall, [170.0, 170.0], 3.0),
    compared("wheels20", SampleWorkload::Wheels { wheels: 5 }, [424.0, 230.0], 2.0),
    compared("wheels21", SampleWorkload::Wheels { wheels: 6 }, [420.0, 220.0], 2.0),
    compared("wheels23", SampleWorkload::Wheels { wheels: 8 }, [420.0, 220.0], 2.0),
    compared("windows30", SampleWorkload::Windows, [390.0, 390.0], 2.0),
];

const fn compared(name: &'static str, parts: SampleWorkload, base_mm: [f64; 2], clearance_mm: f64) -> ComparedWorkload {
    ComparedWorkload { name, parts, base_mm, clearance_mm }
}

/// A file by which another packer gets a workload.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkloadFile {
    /// Where it belongs, below the folder of all workloads.
    pub path: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

impl ComparedWorkload {
    /// The workload of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        COMPARED_WORKLOADS.iter().find(|workload| workload.name == name)
    }

    /// A binary STL for each different part, the list of their copies, and base and clearance. The same bytes on each call.
    pub fn files(&self) -> Vec<WorkloadFile> {
        let Self { name, base_mm: [length_mm, width_mm], clearance_mm, .. } = self;
        let mut list = "file,quantity\n".to_owned();
        let mut files = Vec::new();
        for (at, (mesh, copies)) in workload_parts(self.parts).iter().enumerate() {
            let path = format!("{name}/part-{at:02}.stl");
            list += &format!("{path},{copies}\n");
            files.push(WorkloadFile { path, bytes: stl_bytes(mesh) });
        }
        let beside = format!(
            "{{\"name\": \"{name}\", \"volume_mm\": [{length_mm}, {width_mm}, {COMPARED_ROOM_MM}], \"clearance_mm\": {clearance_mm}}}\n"
        );
        files.push(WorkloadFile { path: format!("workloads/{name}.csv"), bytes: list.into_bytes() });
        files.push(WorkloadFile { path: format!("workloads/{name}.json"), bytes: beside.into_bytes() });
        files
    }
}

/// A mesh as binary STL; its triangles keep their order.
fn stl_bytes(mesh: &Mesh) -> Vec<u8> {
    let facet = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        let [normal, a, b, c] = [(b - a).cross(c - a).normalize_or_zero(), a, b, c].map(|v| v.as_vec3().to_array());
        stl_io::Triangle { normal: stl_io::Vector::new(normal), vertices: [a, b, c].map(stl_io::Vector::new) }
    };
    let facets: Vec<stl_io::Triangle> = (0..mesh.triangles().len()).map(facet).collect();
    let mut bytes = Vec::new();
    stl_io::write_stl(&mut bytes, facets.iter()).expect("memory takes all that is written");
    bytes
}

/// The meshes of a workload with their numbers of copies, at least 1 each. The result for a workload never changes.
pub fn workload_parts(workload: SampleWorkload) -> Vec<(Mesh, u32)> {
    match workload {
        SampleWorkload::Fans => vec![(axial_fan(65.0, 22.0, 7), 20)],
        SampleWorkload::EngineLike => engine_like().into_iter().map(|mesh| (mesh, 1)).collect(),
        SampleWorkload::Small { copies, meshes, seed } => random_pile(random_part, copies, meshes, seed),
        SampleWorkload::Organic { copies, meshes, seed } => random_pile(random_figure, copies, meshes, seed),
        SampleWorkload::Cages => cages().into_iter().map(|mesh| (mesh, 3)).collect(),
        SampleWorkload::Twins { each } => {
            vec![(hook(18.0, 9.0, 34.0), each), (ribbed_bracket(46.0, 44.0, 4.0, 3), each)]
        }
        SampleWorkload::Wheels { wheels } => around((wheel(212.0, 25.0, 14.0, 5), wheels), 15, 1.5),
        SampleWorkload::Windows => around((frame(200.0, 200.0, 14.0, 22.0, 2), 10), 20, 1.2),
        SampleWorkload::Tall => {
            let rails = (0..6).map(|n| 100.0 + 20.0 * f64::from(n)).map(|long| rail(long, 35.0, 10.0, 2.5));
            let ducts = (0..6).map(|n| 40.0 + 8.0 * f64::from(n)).map(|leg| duct(26.0, 2.5, 30.0, 60.0, leg));
            rails.chain(ducts).map(|mesh| (mesh, 4)).collect()
        }
    }
}

/// `copies` parts of `meshes` different meshes of one random family.
fn random_pile(family: impl Fn(u64) -> Mesh, copies: u32, meshes: u32, seed: u64) -> Vec<(Mesh, u32)> {
    let (copies, meshes) = (copies.max(1), meshes.clamp(1, copies.max(1)));
    let share = |i: u32| copies / meshes + u32::from(i < copies % meshes);
    (0..meshes).map(|i| (family(seed.wrapping_mul(1_000_003).wrapping_add(i.into())), share(i))).collect()
}

/// Copies of a large part, and engine-like parts, `scale` times as large.
fn around(large: (Mesh, u32), others: usize, scale: f64) -> Vec<(Mesh, u32)> {
    let scaled = |mesh: &Mesh| {
        let vertices = mesh.vertices().iter().map(|&vertex| scale * vertex).collect();
        Mesh::new(vertices, mesh.triangles().to_vec()).expect("a scaled solid is a solid")
    };
    std::iter::once(large).chain(engine_like().iter().take(others).map(|mesh| (scaled(mesh), 1))).collect()
}

/// Fourteen open parts that others can stand in.
fn cages() -> Vec<Mesh> {
    vec![
        lattice_block([1, 1, 1], 56.0, 4.0),
        lattice_block([1, 1, 2], 40.0, 4.0),
        lattice_block([2, 1, 1], 34.0, 3.0),
        lattice_block([2, 2, 1], 30.0, 3.0),
        lattice_block([1, 1, 1], 30.0, 3.0),
        lattice_block([1, 2, 3], 22.0, 2.5),
        lattice_block([3, 3, 1], 20.0, 2.5),
        ring(96.0, 84.0, 8.0),
        ring(62.0, 52.0, 20.0),
        ring(36.0, 28.0, 12.0),
        tray([2, 1], 44.0, 30.0, 2.5),
        tray([1, 1], 60.0, 40.0, 2.5),
        lampshade(80.0, 40.0, 60.0, 2.5),
        lampshade(44.0, 30.0, 34.0, 2.0),
    ]
}

/// Thirty different parts of 15 to 110 mm.
fn engine_like() -> Vec<Mesh> {
    vec![
        axial_fan(65.0, 22.0, 7),
        axial_fan(48.0, 16.0, 5),
        bracket(90.0, 30.0, 6.0, 6.0),
        bracket(48.0, 20.0, 4.0, 5.0),
        ribbed_bracket(46.0, 44.0, 4.0, 4),
        ribbed_bracket(30.0, 24.0, 3.0, 3),
        duct(34.0, 2.5, 36.0, 90.0, 16.0),
        duct(22.0, 2.0, 26.0, 135.0, 12.0),
        ring(92.0, 78.0, 6.0),
        ring(60.0, 44.0, 14.0),
        ring(30.0, 18.0, 10.0),
        spur_gear(32, 2.5, 14.0, 16.0),
        spur_gear(20, 2.0, 12.0, 10.0),
        spur_gear(14, 1.5, 20.0, 6.0),
        lattice_block([4, 3, 2], 12.0, 3.0),
        clip(30.0, 3.0, 18.0),
        hinge(70.0, 30.0, 12.0, 5.0, 4),
        knob(50.0, 24.0, 7),
        hook(18.0, 9.0, 34.0),
        tray([2, 2], 36.0, 24.0, 2.5),
        lampshade(84.0, 44.0, 60.0, 2.5),
        pulley(70.0, 18.0, 14.0),
        pulley(36.0, 10.0, 6.0),
        pipe_tee(70.0, 40.0, 30.0, 4.0),
        rail(110.0, 35.0, 10.0, 2.5),
        spring(30.0, 5.0, 11.0, 6.0),
        connecting_rod(78.0, 38.0, 26.0, 16.0),
        connecting_rod(50.0, 26.0, 18.0, 10.0),
        gyroid_ball(40.0, 20.0, 3.6),
        pawn(24.0, 64.0),
    ]
}

/// A small part of a random kind and size, about 10 to 50 mm. The same seed always gives the same part.
pub fn random_part(seed: u64) -> Mesh {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let kind = rng.random_range(0..16u32);
    let mut between = |low: f64, high: f64| rng.random_range(low..high);
    let size = between(12.0, 40.0);
    match kind {
        0 => axial_fan(size.max(20.0), 0.35 * size, between(4.0, 8.0) as usize),
        1 => bracket(size * between(1.5, 2.5), 0.6 * size, between(2.0, 5.0), 0.15 * size),
        2 => ribbed_bracket(size, size * between(0.6, 1.2), between(1.6, 2.4), between(2.0, 5.0) as usize),
        3 => duct(0.5 * size, 0.05 * size, 0.6 * size, between(40.0, 150.0), 0.3 * size),
        4 => ring(size, size * between(0.5, 0.8), size * between(0.1, 0.5)),
        5 => spur_gear((size / 1.6) as usize, 1.5, size * between(0.2, 0.5), 0.25 * size),
        6 => {
            let cells = [between(1.0, 4.0), between(1.0, 4.0), between(2.0, 4.0)].map(|n| n as usize);
            lattice_block(cells, 5.0 + 0.12 * size, 1.8)
        }
        7 => clip(0.7 * size, between(1.6, 2.6), size * between(0.3, 0.7)),
        8 => hinge(size * between(0.8, 1.6), 0.6 * size, 0.25 * size, 0.1 * size, between(2.0, 5.0) as usize),
        9 => knob(size, size * between(0.4, 0.7), between(4.0, 9.0) as usize),
        10 => hook(0.35 * size, 0.2 * size, size * between(0.5, 1.0)),
        11 => tray([between(1.0, 4.0), between(2.0, 4.0)].map(|n| n as usize), 0.5 * size, 0.4 * size, 1.6),
        12 => lampshade(size, size * between(0.4, 0.8), size * between(0.5, 1.0), 1.6),
        13 => pulley(size, 0.25 * size, 0.2 * size),
        14 => pawn(0.6 * size, size * between(0.9, 1.4)),
        _ => spring(0.6 * size, 0.12 * size, 0.24 * size, between(2.0, 6.0)),
    }
}
