//! The printers of a week: each takes the oldest build file out of its queue folder, prints for as long as its height
//! takes, and somebody tells what became of it. What was printed is read from the files, never from the ledger.

use std::{collections::BTreeMap, fs, time::Duration};

use glam::DVec3;
use ledger::{BuildId, PartId, PrintOutcome, ToldOutcome};
use ledger_fixtures::ToldWords;

use crate::{
    driven_tests::hand_driven_farm::{HandDrivenFarm, farm_files::list_build_files},
    records::build_record::parse_build_file_name,
};

/// A copy of a part, by the part's number and its own.
pub type PrintedCopy = (i64, u32);

/// What a build file says.
#[derive(Debug)]
pub struct PrintedBuild {
    /// Its number.
    pub build: BuildId,
    /// The machine that prints it.
    pub machine: usize,
    /// Each copy with its order and the BLAKE3 of the dropped file.
    pub copies: BTreeMap<PrintedCopy, (String, String)>,
    /// Volumes of the meshes in the file by the BLAKE3 of the dropped file, mm³.
    pub volumes_mm3: BTreeMap<String, f64>,
    /// Top of the highest copy, mm.
    pub height_mm: f64,
    /// Volume of the parts / (base area x height).
    pub density: f64,
}

/// A printer.
#[derive(Debug)]
pub struct WeekPrinter {
    /// Number of the machine.
    pub machine: usize,
    /// Its machine.
    pub name: &'static str,
    /// Edge lengths of its build volume, mm.
    pub volume_mm: DVec3,
    /// Hours per mm of height.
    pub hours_per_mm: f64,
    /// What it prints, and when that is done, after the start.
    printing: Option<(PrintedBuild, Duration)>,
}

impl WeekPrinter {
    /// A printer that is idle.
    pub fn new(machine: usize, name: &'static str, volume_mm: DVec3, hours_per_mm: f64) -> Self {
        Self { machine, name, volume_mm, hours_per_mm, printing: None }
    }

    /// Whether it prints.
    pub fn is_printing(&self, now: Duration) -> bool {
        self.printing.as_ref().is_some_and(|(_, until)| *until > now)
    }

    /// Takes the next build file if it is idle. Returns a build that is done by now.
    pub fn work(&mut self, farm: &HandDrivenFarm, now: Duration) -> Option<PrintedBuild> {
        let done = self.printing.take_if(|(_, until)| *until <= now).map(|(build, _)| build);
        if self.printing.is_none()
            && let Some(file) = list_build_files(&farm.folder_of("queue", self.name)).first()
        {
            let build = self.read_file(file);
            fs::remove_file(file).unwrap();
            let hours = build.height_mm * self.hours_per_mm;
            self.printing = Some((build, now + Duration::from_secs_f64(hours * 3600.0)));
        }
        done
    }

    fn read_file(&self, file: &std::path::Path) -> PrintedBuild {
        let name = file.file_name().unwrap().to_str().unwrap();
        let (mut copies, mut volumes_mm3) = (BTreeMap::new(), BTreeMap::new());
        let (mut height_mm, mut volume_mm3) = (0.0_f64, 0.0);
        for placed in build_file::read_build(file, &build_file::ReadLimits::default()).unwrap() {
            let key = (placed.part_number.unwrap().parse().unwrap(), placed.copy.unwrap());
            let hash = placed.source_hash.unwrap();
            height_mm = height_mm.max(placed.mesh.bounds_at(&placed.pose).max.z);
            volume_mm3 += placed.mesh.volume_mm3();
            volumes_mm3.insert(hash.clone(), placed.mesh.volume_mm3());
            let twice = copies.insert(key, (placed.words.order.unwrap_or_default(), hash));
            assert!(twice.is_none(), "copy {key:?} is twice in {name}");
        }
        let density = volume_mm3 / (self.volume_mm.x * self.volume_mm.y * height_mm);
        let build = BuildId(parse_build_file_name(name).unwrap().1);
        PrintedBuild { build, machine: self.machine, copies, volumes_mm3, height_mm, density }
    }
}

impl PrintedBuild {
    /// Tells that the print failed.
    pub fn tell_failed(&self, farm: &HandDrivenFarm) {
        self.tell(farm, ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm"));
    }

    /// Tells that it is complete but for these numbers of copies of parts.
    pub fn tell_complete(&self, farm: &HandDrivenFarm, bad: &BTreeMap<i64, u32>) {
        let bad = bad.iter().map(|(part, copies)| (PartId(*part), *copies)).collect();
        self.tell(farm, ToldOutcome { bad, ..ToldOutcome::new(PrintOutcome::Complete, "", "ann@farm") });
    }

    fn tell(&self, farm: &HandDrivenFarm, told: ToldOutcome) {
        farm.ask(async |ledger| ledger.record_outcome(self.build, &told).await.unwrap());
    }
}
