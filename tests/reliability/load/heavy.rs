//! Heavy parts through the real daemon: a mesh of very many triangles, a part of very many shells, very many copies.
//! Measures time and peak memory of each, and checks that files above the stated limits are refused with the reason.

use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    path::Path,
    time::{Duration, Instant},
};

use glam::{DVec3, Vec3};
use ledger::PartState;
use solids::Pose;

use crate::{
    harness::{SectionBudget, SectionResult},
    support::{TestFarm, stl},
};

/// A common machine; searches are short, because the height is not measured.
const PROFILE: &str =
    "volume_mm = [380, 284, 380]\nclearance_mm = 3.0\nsettle_secs = 0.3\nfinal_secs = 5\narrival_secs = 2\n";
/// Memory limit of the daemon for each of these parts, MiB.
const MAX_MEMORY_MIB: u64 = 8192;

/// The measured cost of a part.
struct MeasuredCost {
    what: String,
    read_secs: f64,
    build_secs: f64,
    peak_mib: u64,
}

/// Writes a part of a size.
type PartWriter = fn(&Path, u64);

pub fn run(budget: &SectionBudget) -> SectionResult {
    let mut row = SectionResult::default();
    let cases: [(&str, &str, PartWriter, u64); 3] = [
        ("triangles", "ball.stl", write_sphere, budget.pick(100_000, 10_000_000)),
        ("shells", "crowd.stl", write_cubes, budget.pick(200, 2000)),
        ("copies", "block.stl", write_block, budget.pick(100, 5000)),
    ];
    let mut notes = Vec::new();
    for (what, name, write, size) in cases {
        match measure_cost(what, name, write, size, budget) {
            Ok(cost) => {
                if cost.peak_mib > MAX_MEMORY_MIB {
                    row.broken.push(format!("{} took {} MiB", cost.what, cost.peak_mib));
                }
                notes.push(format!(
                    "{}: read in {:.1} s, published after {:.1} s, peak {} MiB",
                    cost.what, cost.read_secs, cost.build_secs, cost.peak_mib
                ));
                row.files += 1;
                row.builds += 1;
            }
            Err(why) => row.broken.push(why),
        }
    }
    refused_above_the_limits(&mut row);
    row.points = row.files;
    row.note = notes.join("; ");
    row
}

fn measure_cost(
    what: &str,
    name: &str,
    write: fn(&Path, u64),
    size: u64,
    budget: &SectionBudget,
) -> Result<MeasuredCost, String> {
    let farm = TestFarm::running(PROFILE);
    let what = format!("{size} {what}");
    if name == "block.stl" {
        farm.drop_bytes("block.stl.toml", format!("copies = {size}").as_bytes());
    }
    let file = farm.root().join("sending");
    write(&file, size);
    let began = Instant::now();
    fs::rename(&file, farm.folder("inbox").join(name)).unwrap();
    let limit = Duration::from_secs_f64(budget.secs.max(60.0));
    let waits = |state: PartState| !farm.parts(state).is_empty();
    wait(&farm, &what, limit, || waits(PartState::Waiting))?;
    let read_secs = began.elapsed().as_secs_f64();
    let began = Instant::now();
    farm.flush();
    wait(&farm, &what, limit, || !farm.queued().is_empty())?;
    Ok(MeasuredCost { what, read_secs, build_secs: began.elapsed().as_secs_f64(), peak_mib: peak_mib(farm.pid()) })
}

fn wait(farm: &TestFarm, what: &str, limit: Duration, mut holds: impl FnMut() -> bool) -> Result<(), String> {
    let began = Instant::now();
    while !holds() {
        if let Some(part) = farm.parts(PartState::Refused).first() {
            return Err(format!("{what}: refused: {}", part.refused.reason));
        }
        if began.elapsed() > limit {
            return Err(format!("{what}: not done within {limit:?}\n{}", farm.log()));
        }
        std::thread::sleep(Duration::from_millis(200));
    }
    Ok(())
}

/// The peak memory of a process, MiB.
pub fn peak_mib(pid: i32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() / 1024
}

/// Sets each limit low and checks that a part above it is refused.
fn refused_above_the_limits(row: &mut SectionResult) {
    let cube = stl(&sample_parts::cuboid(DVec3::splat(10.0)));
    let cases = [
        ("max_triangles = 11", "a.stl", "it has 12 triangles; at most 11 are allowed"),
        ("max_bytes = 600", "a.stl", "it is 684 bytes long; at most 600 are allowed"),
        ("max_shells = 1", "two.stl", "2 separate pieces"),
        ("max_copies = 4", "a_x5.stl", "5 copies"),
    ];
    for (limit, name, expected) in cases {
        let mut farm = TestFarm::new(PROFILE);
        let config = fs::read_to_string(farm.config()).unwrap();
        fs::write(farm.config(), format!("{config}[limits]\n{limit}\n")).unwrap();
        farm.start();
        if name == "two.stl" {
            write_cubes(&farm.root().join("sending"), 2);
            fs::rename(farm.root().join("sending"), farm.folder("inbox").join(name)).unwrap();
        } else {
            farm.drop_bytes(name, &cube);
        }
        let reason = match wait(&farm, limit, Duration::from_secs(30), || !farm.parts(PartState::Waiting).is_empty()) {
            Ok(()) => "it was taken".to_owned(),
            Err(reason) => reason,
        };
        row.points += 1;
        if !reason.contains(expected) {
            row.broken.push(format!("{limit}: {reason}"));
        }
    }
}

/// Writes a sphere of about `triangles` triangles, 100 mm wide, as rings of latitude.
fn write_sphere(file: &Path, triangles: u64) {
    let rings = ((triangles as f64 / 4.0).sqrt() as u32).max(4);
    let around = 2 * rings;
    let corner = |ring: u32, step: u32| {
        let (polar, turn) = (
            f64::from(ring) / f64::from(rings) * std::f64::consts::PI,
            f64::from(step % around) / f64::from(around) * std::f64::consts::TAU,
        );
        let place = match ring {
            0 => DVec3::Z,
            r if r == rings => -DVec3::Z,
            _ => DVec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()),
        };
        (50.0 * place).as_vec3()
    };
    let mut out = BufWriter::new(File::create(file).unwrap());
    out.write_all(&[b' '; 80]).unwrap();
    out.write_all(&(2 * around * (rings - 1)).to_le_bytes()).unwrap();
    for ring in 0..rings {
        for step in 0..around {
            let [a, b] = [corner(ring, step), corner(ring + 1, step)];
            let [c, d] = [corner(ring + 1, step + 1), corner(ring, step + 1)];
            if ring + 1 < rings {
                facet(&mut out, [a, b, c]);
            }
            if ring > 0 {
                facet(&mut out, [a, c, d]);
            }
        }
    }
    out.flush().unwrap();
}

fn facet(out: &mut impl Write, corners: [Vec3; 3]) {
    let mut bytes = [0; 50];
    for (at, number) in corners.iter().flat_map(Vec3::to_array).enumerate() {
        bytes[12 + 4 * at..16 + 4 * at].copy_from_slice(&number.to_le_bytes());
    }
    out.write_all(&bytes).unwrap();
}

/// Writes one file of `shells` small cubes that do not touch.
fn write_cubes(file: &Path, shells: u64) {
    let cube = sample_parts::cuboid(DVec3::splat(2.0));
    let side = (shells as f64).cbrt().ceil() as u64;
    let poses: Vec<Pose> = (0..shells)
        .map(|n| DVec3::new((n % side) as f64, (n / side % side) as f64, (n / side / side) as f64) * 6.0)
        .map(|translation| Pose { translation, ..Pose::IDENTITY })
        .collect();
    let mut out = BufWriter::new(File::create(file).unwrap());
    build_file::write_stl(poses.iter().map(|pose| (&cube, pose)), &mut out).unwrap();
    out.flush().unwrap();
}

fn write_block(file: &Path, _copies: u64) {
    fs::write(file, stl(&sample_parts::cuboid(DVec3::new(14.0, 11.0, 8.0)))).unwrap();
}
