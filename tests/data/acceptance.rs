//! Random builds of other people's parts (in `nest/` of the data folder); `NESTD_BUILDS` sets their number. Each build
//! is checked by nestd, and by an independent referee that shares no code with nestd if `NESTD_REFEREE` (a Python) and
//! `NESTD_JUDGE` (the folder of `verify_build.py` and `separable.py`) are set:
//!
//!     NESTD_DATA=.. NESTD_BUILDS=1000 NESTD_REFEREE=.. NESTD_JUDGE=.. cargo test --release --test data acceptance
//!
//! `NESTD_FIRST=500` begins with build 500, so that long runs can be split and a single fault can be repeated.

use std::{
    collections::BTreeMap,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use build_file::{LengthUnit, ReadLimits};
use glam::DVec3;
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use solids::Mesh;

use crate::support::random::{any_clearance_mm, any_tilt};

/// Default number of builds of other people's parts.
const FEW_BUILDS: u64 = 4;
/// Builds that the independent referee gets at once, because its start takes a second.
const AT_ONCE: u64 = 20;

/// One random build of other people's parts, as a command line.
#[derive(Debug)]
struct RandomBuild {
    number: u64,
    parts: Vec<(PathBuf, u32)>,
    volume_mm: DVec3,
    clearance_mm: f64,
    orientation: &'static str,
    /// Options for tilts: a direction that stays up, or a face that must not face down.
    tilt: Option<[String; 2]>,
    evaluations: u64,
}

/// Parts of the data folder, read at the first use; `None` = not a closed solid, or too large to check a thousand
/// times.
struct PartPool {
    files: Vec<PathBuf>,
    sizes_mm: BTreeMap<usize, Option<DVec3>>,
}

impl PartPool {
    fn new(folder: &Path) -> Self {
        let mut files = Vec::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
                let ending =
                    entry.path().extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase());
                if entry.path().is_dir() {
                    folders.push(entry.path());
                } else if ending == "stl" {
                    files.push(entry.path());
                }
            }
        }
        files.sort();
        Self { files, sizes_mm: BTreeMap::new() }
    }

    fn size_mm(&mut self, at: usize) -> Option<DVec3> {
        let file = &self.files[at];
        *self.sizes_mm.entry(at).or_insert_with(|| {
            let contents =
                build_file::read_part_file(file, "part.stl", None, LengthUnit::default(), &ReadLimits::default())
                    .ok()?;
            let mesh: &Mesh = &contents.solids.first()?.mesh;
            let fine = mesh.defects().is_closed() && mesh.triangles().len() < 15_000;
            fine.then(|| mesh.bounds().size())
        })
    }

    fn order(&mut self, number: u64) -> RandomBuild {
        let mut rng = ChaCha8Rng::seed_from_u64(number);
        let mut parts = BTreeMap::new();
        let mut largest = DVec3::ZERO;
        let most = rng.random_range(2..26);
        while parts.values().sum::<u32>() < most {
            let at = rng.random_range(0..self.files.len());
            let Some(size) = self.size_mm(at) else { continue };
            let left = most - parts.values().sum::<u32>();
            *parts.entry(self.files[at].clone()).or_insert(0) += rng.random_range(1..=left.min(6));
            largest = largest.max(size);
        }
        let mut stretch = || rng.random_range(1.02..2.5);
        let volume_mm = (largest * DVec3::new(stretch(), stretch(), 2.0 * stretch())).ceil();
        let orientation = ["free", "free", "upright", "axis", "fixed"].choose(&mut rng).copied().unwrap();
        let tilt = match rng.random_range(0..6) {
            0 => Some(["--keep-up".to_owned(), any_tilt(&mut rng, 20..120)]),
            1 => Some(["--not-down".to_owned(), any_tilt(&mut rng, 10..70)]),
            _ => None,
        };
        RandomBuild {
            number,
            parts: parts.into_iter().collect(),
            volume_mm,
            clearance_mm: (any_clearance_mm(&mut rng) * 1000.0).round() / 1000.0,
            orientation,
            tilt: tilt.filter(|_| orientation == "free"),
            evaluations: rng.random_range(200..4000),
        }
    }
}

impl RandomBuild {
    fn volume(&self) -> String {
        format!("{}x{}x{}", self.volume_mm.x, self.volume_mm.y, self.volume_mm.z)
    }

    /// Nests into a file; returns whether all copies found a place. `None` if no part fits with the given tilts.
    fn nest(&self, file: &Path) -> Result<Option<bool>, String> {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nestd"));
        command.arg("nest").args(self.parts.iter().map(|(part, copies)| format!("{}={copies}", part.display())));
        command.args(["--volume", &self.volume(), "--clearance", &self.clearance_mm.to_string()]);
        command.args(["--orientation", self.orientation, "--evaluations", &self.evaluations.to_string()]);
        command.args(self.tilt.iter().flatten());
        let out = command.args(["--seed", &self.number.to_string(), "-o"]).arg(file).output().unwrap();
        match out.status.code() {
            Some(0) => Ok(Some(true)),
            Some(1) if file.exists() => Ok(Some(false)),
            Some(1) if self.tilt.is_some() => Ok(None),
            _ => Err(format!("{self:?}: {}", String::from_utf8_lossy(&out.stderr))),
        }
    }

    /// The JSON output of `nestd verify`.
    fn verified(&self, file: &Path) -> Value {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nestd"));
        command.arg("verify").arg(file).args(["--volume", &self.volume(), "--json"]);
        let out = command.args(["--clearance", &self.clearance_mm.to_string()]).output().unwrap();
        serde_json::from_slice(&out.stdout)
            .unwrap_or_else(|_| json!({ "unreadable": String::from_utf8_lossy(&out.stderr) }))
    }

    /// The question for the independent referee.
    fn referee_question(&self, file: &Path) -> Value {
        let size = self.volume_mm;
        json!({ "file": file, "base": [size.x, size.y], "maxz": size.z, "clearance": self.clearance_mm })
    }
}

/// Checks the builds on standard input, one per line. Looks for locked parts only if the number of voxels of half the
/// clearance is small enough.
const SCRIPT: &str = r#"
import argparse, contextlib, io, json, sys
sys.path.insert(0, sys.argv[1])
import numpy as np
import verify_build as vb
import separable
# The two scripts do not agree on what a read part is made of: the one has a transform more.
read = vb.read_3mf
short = lambda path: [part[:4] for part in read(path)]
for line in sys.stdin:
    asked = json.loads(line)
    vb.read_3mf = read
    parts, notes, _, _ = vb.build_parts(argparse.Namespace(mf=asked['file'], placements=None, stl=None))
    r = vb.verify(parts, asked['base'], asked['maxz'], asked['clearance'], notes)
    pitch = asked['clearance'] / 2
    spread = max(float((np.max([p.hi for p in parts], 0) - np.min([p.lo for p in parts], 0)).max()), 1.0)
    locked = None
    if spread / pitch < 400:
        told = io.StringIO()
        vb.read_3mf = short
        sys.argv[1:] = ['--3mf', asked['file'], '--pitch', str(pitch)]
        with contextlib.redirect_stdout(told):
            try:
                separable.main()
            except SystemExit:
                pass
        locked = [l[8:] for l in told.getvalue().splitlines() if l.startswith('locked: ')]
    keep = ('ok', 'fails', 'parts', 'height_mm', 'min_distance_mm')
    print(json.dumps({**{k: r[k] for k in keep}, 'locked': locked}), flush=True)
"#;

/// The answers of the independent referee; `None` when there is none.
fn ask_referee(questions: &[Value]) -> Option<Vec<Value>> {
    let (python, folder) = (std::env::var_os("NESTD_REFEREE")?, std::env::var_os("NESTD_JUDGE")?);
    let mut command = Command::new(python);
    command.args(["-c", SCRIPT]).arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut referee = command.spawn().unwrap();
    let lines: String = questions.iter().map(|q| format!("{q}\n")).collect();
    let mut input = referee.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(lines.as_bytes()));
    let out = referee.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(out.status.success(), "the referee did not come to an end");
    let verdicts: Vec<Value> =
        String::from_utf8(out.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(verdicts.len(), questions.len());
    Some(verdicts)
}

/// The faults of a build that nestd and the referee find.
fn faults(own: &Value, other: Option<&Value>) -> Vec<String> {
    let mut faults = Vec::new();
    if own["proved"] != json!(true) {
        faults.push(format!("nestd verify: {own}"));
    }
    let Some(other) = other else { return faults };
    if other["ok"] != json!(true) {
        faults.push(format!("the referee: {other}"));
    }
    let differ = |one: &Value, two: &Value| match (one.as_f64(), two.as_f64()) {
        (Some(one), Some(two)) => (one - two).abs() > 1e-3,
        _ => false,
    };
    if differ(&own["height_mm"], &other["height_mm"])
        || differ(&own["least_distance_mm"], &other["min_distance_mm"])
        || own["placements"] != other["parts"]
    {
        faults.push(format!("nestd and the referee measure differently: {own} and {other}"));
    }
    faults
}

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).map_or(otherwise, |text| text.parse().unwrap())
}

pub fn random_builds_of_other_peoples_parts_are_proved_by_two_judges() {
    let data = std::env::var_os("NESTD_DATA").unwrap();
    let mut pool = PartPool::new(&Path::new(&data).join("nest"));
    let (first, count) = (number("NESTD_FIRST", 0), number("NESTD_BUILDS", FEW_BUILDS));
    let dir = tempfile::tempdir().unwrap();
    let (mut all_faults, mut placed, mut whole, mut looked_at, mut locked) = (Vec::new(), 0, 0, 0, 0);
    for begin in (first..first + count).step_by(AT_ONCE as usize) {
        let orders: Vec<RandomBuild> = (begin..(begin + AT_ONCE).min(first + count)).map(|n| pool.order(n)).collect();
        let file = |order: &RandomBuild| dir.path().join(format!("{}.build.3mf", order.number));
        let (mut built, mut questions) = (Vec::new(), Vec::new());
        for order in orders {
            match order.nest(&file(&order)) {
                Ok(None) => println!("no part fits: {order:?}"),
                Ok(Some(all)) => {
                    whole += u64::from(all);
                    questions.push(order.referee_question(&file(&order)));
                    built.push(order);
                }
                Err(fault) => all_faults.push(fault),
            }
        }
        let verdicts = ask_referee(&questions);
        for (at, order) in built.iter().enumerate() {
            let own = order.verified(&file(order));
            let other = verdicts.as_ref().map(|verdicts| &verdicts[at]);
            placed += own["placements"].as_u64().unwrap_or(0);
            let found = faults(&own, other);
            let of_other = other.and_then(|other| other["locked"].as_array());
            looked_at += u64::from(of_other.is_some());
            let stuck = of_other.map_or(0, Vec::len);
            locked += u64::from(stuck > 0);
            if stuck > 0 || !found.is_empty() {
                println!("{order:?}: {found:?}, locked: {of_other:?}");
                keep(&file(order));
            }
            all_faults.extend(found);
            if stuck > 0 {
                all_faults.push(format!("build {}: the referee finds locked parts: {of_other:?}", order.number));
            }
            let _ = std::fs::remove_file(file(order));
        }
        println!(
            "{} builds ({whole} of all copies, {placed} placements), {} faults; parts locked in {locked} of {looked_at}",
            (begin + AT_ONCE).min(first + count) - first,
            all_faults.len()
        );
    }
    assert!(all_faults.is_empty(), "{all_faults:#?}");
}

/// Saves a build in the folder `NESTD_KEEP` for inspection.
fn keep(file: &Path) {
    if let Some(folder) = std::env::var_os("NESTD_KEEP") {
        std::fs::copy(file, Path::new(&folder).join(file.file_name().unwrap())).unwrap();
    }
}
