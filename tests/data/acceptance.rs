//! Random builds of other people's parts (in `nest/` of the data folder), judged twice, as many as `NESTD_BUILDS` says. With
//! `NESTD_REFEREE` (a python) and `NESTD_JUDGE` (the folder of `verify_build.py` and `separable.py`) there is a judge that
//! shares no line with us:
//!
//!     NESTD_DATA=.. NESTD_BUILDS=1000 NESTD_REFEREE=.. NESTD_JUDGE=.. cargo test --release --test data acceptance
//!
//! `NESTD_FIRST=500` begins with build 500: long runs can be split, and a single fault be looked at again.

use std::{
    collections::BTreeMap,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use build_file::{Limits, Unit};
use glam::DVec3;
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use solids::Mesh;

use crate::support::random::{any_clearance_mm, any_tilt};

/// So many builds of other people's parts unless `NESTD_BUILDS` says otherwise.
const FEW_BUILDS: u64 = 4;
/// Builds that the other judge gets at once: starting it costs a second.
const AT_ONCE: u64 = 20;

/// One random build of other people's parts, as a command line.
#[derive(Debug)]
struct Order {
    number: u64,
    parts: Vec<(PathBuf, u32)>,
    volume_mm: DVec3,
    clearance_mm: f64,
    orientation: &'static str,
    /// Options that tilt: a direction that stays up or a face that must not look down.
    tilt: Option<[String; 2]>,
    evaluations: u64,
}

/// Parts of the data folder, read when first needed; `None` is no closed solid, or too large to judge a thousand times.
struct Pool {
    files: Vec<PathBuf>,
    sizes_mm: BTreeMap<usize, Option<DVec3>>,
}

impl Pool {
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
            let contents = build_file::read(file, "part.stl", None, Unit::default(), &Limits::default()).ok()?;
            let mesh: &Mesh = &contents.solids.first()?.mesh;
            let fine = mesh.defects().is_closed() && mesh.triangles().len() < 15_000;
            fine.then(|| mesh.bounds().size())
        })
    }

    fn order(&mut self, number: u64) -> Order {
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
        Order {
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

impl Order {
    fn volume(&self) -> String {
        format!("{}x{}x{}", self.volume_mm.x, self.volume_mm.y, self.volume_mm.z)
    }

    /// Nests into a file; whether all copies found a place. `None` where no part fits under the tilts asked for.
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

    /// What `nestd verify` says.
    fn verified(&self, file: &Path) -> Value {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nestd"));
        command.arg("verify").arg(file).args(["--volume", &self.volume(), "--json"]);
        let out = command.args(["--clearance", &self.clearance_mm.to_string()]).output().unwrap();
        serde_json::from_slice(&out.stdout)
            .unwrap_or_else(|_| json!({ "unreadable": String::from_utf8_lossy(&out.stderr) }))
    }

    /// What the other judge is asked.
    fn question(&self, file: &Path) -> Value {
        let size = self.volume_mm;
        json!({ "file": file, "base": [size.x, size.y], "maxz": size.z, "clearance": self.clearance_mm })
    }
}

/// Judges every build of standard input, a line each. Locked parts are only looked for where voxels of half the clearance are
/// few enough.
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

/// What the other judge says to every question; `None` when there is no other judge.
fn judged(questions: &[Value]) -> Option<Vec<Value>> {
    let (python, folder) = (std::env::var_os("NESTD_REFEREE")?, std::env::var_os("NESTD_JUDGE")?);
    let mut command = Command::new(python);
    command.args(["-c", SCRIPT]).arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut judge = command.spawn().unwrap();
    let lines: String = questions.iter().map(|q| format!("{q}\n")).collect();
    let mut input = judge.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(lines.as_bytes()));
    let out = judge.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(out.status.success(), "the judge did not come to an end");
    let verdicts: Vec<Value> =
        String::from_utf8(out.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(verdicts.len(), questions.len());
    Some(verdicts)
}

/// What is wrong with a build, by both judges.
fn faults(own: &Value, other: Option<&Value>) -> Vec<String> {
    let mut faults = Vec::new();
    if own["proved"] != json!(true) {
        faults.push(format!("nestd verify: {own}"));
    }
    let Some(other) = other else { return faults };
    if other["ok"] != json!(true) {
        faults.push(format!("the other judge: {other}"));
    }
    let differ = |one: &Value, two: &Value| match (one.as_f64(), two.as_f64()) {
        (Some(one), Some(two)) => (one - two).abs() > 1e-3,
        _ => false,
    };
    if differ(&own["height_mm"], &other["height_mm"])
        || differ(&own["least_distance_mm"], &other["min_distance_mm"])
        || own["placements"] != other["parts"]
    {
        faults.push(format!("the judges measure differently: {own} and {other}"));
    }
    faults
}

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).map_or(otherwise, |text| text.parse().unwrap())
}

pub fn random_builds_of_other_peoples_parts_are_proved_by_two_judges() {
    let data = std::env::var_os("NESTD_DATA").unwrap();
    let mut pool = Pool::new(&Path::new(&data).join("nest"));
    let (first, count) = (number("NESTD_FIRST", 0), number("NESTD_BUILDS", FEW_BUILDS));
    let dir = tempfile::tempdir().unwrap();
    let (mut all_faults, mut placed, mut whole, mut looked_at, mut locked) = (Vec::new(), 0, 0, 0, 0);
    for begin in (first..first + count).step_by(AT_ONCE as usize) {
        let orders: Vec<Order> = (begin..(begin + AT_ONCE).min(first + count)).map(|n| pool.order(n)).collect();
        let file = |order: &Order| dir.path().join(format!("{}.build.3mf", order.number));
        let (mut built, mut questions) = (Vec::new(), Vec::new());
        for order in orders {
            match order.nest(&file(&order)) {
                Ok(None) => println!("no part fits: {order:?}"),
                Ok(Some(all)) => {
                    whole += u64::from(all);
                    questions.push(order.question(&file(&order)));
                    built.push(order);
                }
                Err(fault) => all_faults.push(fault),
            }
        }
        let verdicts = judged(&questions);
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
                all_faults.push(format!("build {}: the other judge finds locked parts: {of_other:?}", order.number));
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

/// Keeps a build to look at in `NESTD_KEEP`.
fn keep(file: &Path) {
    if let Some(folder) = std::env::var_os("NESTD_KEEP") {
        std::fs::copy(file, Path::new(&folder).join(file.file_name().unwrap())).unwrap();
    }
}
