//! Everything that is read a second time after settings changed: parts that state no unit are dropped, and while they wait, are printed,
//! told bad, issued again, moved, refused, taken back and edited, the units of the machines' files change, and the daemon is reloaded, ended
//! or killed. Each copy in each build file that the printers take has the size in which its part was read first.

use std::{collections::BTreeMap, fs, time::Duration};

use ledger::{BuildState, PartRow, PartState};
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

use crate::{
    harness::{SectionBudget, SectionResult, catch_panic, in_parallel, seed},
    support::{
        MACHINE, QUICK, TestFarm, block,
        farm_files::{drop_file, list_build_files},
        stl, wait_until, wait_until_or,
    },
};

/// The machines, and the units that their files may say, with their millimetres.
const MACHINES: [&str; 2] = [MACHINE, "other"];
const UNITS: [(&str, f64); 3] = [("millimeter", 1.0), ("centimeter", 10.0), ("inch", 25.4)];
/// Operations of a story.
const STEPS: usize = 14;
/// Volumes may differ by this share: numbers are written and read again.
const TOLERANCE: f64 = 1e-4;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let seed = seed();
    let stories: Vec<u64> = (0..budget.pick(4, 100_000)).map(|number| seed.wrapping_add(number)).collect();
    let rows = in_parallel(stories, budget, |seed| {
        catch_panic(&format!("NESTD_SEED={seed}"), || Story::begin(seed).play(budget.pick(STEPS / 2, STEPS)))
    });
    let note = format!("{} farms whose units change; NESTD_SEED={seed}", rows.len());
    SectionResult { note, ..SectionResult::sum(&rows) }
}

/// A farm with two machines.
struct Story {
    farm: TestFarm,
    rng: ChaCha8Rng,
    /// Millimetres of the units of the machines.
    units: [f64; 2],
    /// Volume of each dropped file in the unit of its machine at the drop, mm3.
    volumes: BTreeMap<String, f64>,
    result: SectionResult,
    seed: u64,
}

impl Story {
    fn begin(seed: u64) -> Self {
        let farm = TestFarm::new(QUICK);
        farm.write_profile(MACHINES[1], QUICK);
        let (rng, result) = (ChaCha8Rng::seed_from_u64(seed), SectionResult::default());
        let mut story = Self { farm, rng, units: [1.0; 2], volumes: BTreeMap::new(), result, seed };
        story.start();
        story
    }

    fn play(mut self, steps: usize) -> SectionResult {
        self.drop_parts();
        for _ in 0..steps {
            match self.rng.random_range(0..8) {
                0 => self.drop_parts(),
                1 | 2 => self.change_unit(),
                3 | 4 => self.print(),
                _ => self.tell(),
            }
            self.result.points += 1;
        }
        self.print();
        let asked: Vec<PartRow> = self.farm.parts(PartState::Waiting);
        let asked = asked.iter().find(|part| !part.owed.question.is_empty());
        self.result.broken.extend(asked.map(|part| format!("NESTD_SEED={}: {}", self.seed, part.owed.question)));
        self.result.files = self.volumes.len() as u64;
        self.result
    }

    /// Drops a part of its own size on each machine, and waits until it is read.
    fn drop_parts(&mut self) {
        for (machine, unit) in MACHINES.into_iter().zip(self.units) {
            let [x, y, z] = [(); 3].map(|()| self.rng.random_range(2.0..4.0_f64));
            let (mesh, name) = (block(x, y, z), format!("p{}.stl", self.volumes.len()));
            self.volumes.insert(name.clone(), mesh.volume_mm3() * unit.powi(3));
            let folder = self.farm.root().join("inbox").join(machine);
            drop_file(self.farm.root(), &folder.join(&name), &stl(&mesh));
            self.await_reading(&name);
        }
    }

    /// Waits until a dropped part is read.
    fn await_reading(&self, name: &str) {
        wait_until_or(
            &format!("{name} is read"),
            60.0,
            || self.farm.log(),
            || {
                let parts = self.farm.query_ledger(async |ledger| ledger.parts_named(name).await.unwrap());
                parts.iter().any(|part| part.state != PartState::Claimed)
            },
        );
    }

    /// Another unit stands in the file of a machine; the daemon learns it by a signal, or by an orderly or a hard restart.
    fn change_unit(&mut self) {
        let at = self.rng.random_range(0..MACHINES.len());
        let &(word, mm) = UNITS.choose(&mut self.rng).unwrap();
        self.farm.write_profile(MACHINES[at], &format!("unit = \"{word}\"\n{QUICK}"));
        self.units[at] = mm;
        match self.rng.random_range(0..3) {
            0 => {
                self.farm.reload();
                std::thread::sleep(Duration::from_millis(1500));
            }
            1 => {
                self.farm.stop();
                self.start();
            }
            _ => {
                self.farm.kill();
                self.start();
                self.result.faults += 1;
            }
        }
    }

    /// Starts the daemon, and waits until it is open: a signal that comes before would end it.
    fn start(&mut self) {
        let opened = |farm: &TestFarm| farm.log().matches("The farm is open.").count();
        let before = opened(&self.farm);
        self.farm.start();
        wait_until("the farm is open", 60.0, || opened(&self.farm) > before);
    }

    /// Both machines print what waits; the printers take the files, and what is in them is measured.
    fn print(&mut self) {
        for machine in MACHINES {
            self.farm.nestd(&["flush", machine]);
        }
        wait_until("nothing is being made", 120.0, || {
            self.farm.query_ledger(async |ledger| {
                let mut making = ledger.parts_in_state(PartState::Claimed).await.unwrap().len();
                for state in [BuildState::Nesting, BuildState::Verified] {
                    making += ledger.builds_in_state(state).await.unwrap().len();
                }
                making == 0
            })
        });
        for file in MACHINES.iter().flat_map(|machine| list_build_files(&self.farm.root().join("queue").join(machine)))
        {
            for copy in build_file::read_build(&file, &Default::default()).unwrap() {
                let (name, volume) = (copy.source_name.clone().unwrap_or_default(), copy.mesh.volume_mm3());
                let told = self.volumes.get(&name).copied();
                if told.is_none_or(|told| (told - volume).abs() > TOLERANCE * told) {
                    let text =
                        format!("{name} has {volume:.1} mm3 in {}, and was dropped with {told:?}", file.display());
                    self.result.broken.push(format!("NESTD_SEED={}: {text}", self.seed));
                }
            }
            fs::remove_file(file).unwrap();
            self.result.builds += 1;
        }
    }

    /// A person says something of a printed build, or of a part. What cannot be done just now is refused.
    fn tell(&mut self) {
        let builds = self.farm.query_ledger(async |ledger| ledger.read_history(&Default::default()).await.unwrap());
        let build = builds.choose(&mut self.rng).map_or_else(|| "1".to_owned(), |row| row.build.to_string());
        let part = self.rng.random_range(1..=self.volumes.len()).to_string();
        let machine = *MACHINES.choose(&mut self.rng).unwrap();
        let number = self.rng.random_range(2..5).to_string();
        let words: &[&[&str]] = match self.rng.random_range(0..6) {
            0 => &[&["outcome", &build, "failed"]],
            1 => &[&["requeue", &build]],
            2 => &[&["move", &part, "--to", machine]],
            3 => &[&["cancel", &part], &["retry", &part]],
            4 => &[&["edit", &part, "--copies", &number]],
            _ => &[&["outcome", &build, "complete"], &["reprint", &part]],
        };
        words.iter().for_each(|words| drop(self.farm.nestd(words)));
    }
}
