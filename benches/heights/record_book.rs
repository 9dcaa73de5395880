//! The record of all measurements, `docs/benchmark.json`, so that a long bench can be made of short ones.

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::{
    repository,
    trial::{SearchFinding, SearchTrial},
};

const FILE: &str = "docs/benchmark.json";

/// Where and when a measurement was made.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct MeasurementOrigin {
    /// Version and commit; `+` when the work tree had uncommitted changes.
    pub commit: String,
    /// Day.
    pub date: String,
    /// Processor and cores.
    pub machine: String,
}

impl MeasurementOrigin {
    /// This machine and the current time.
    pub fn here() -> Self {
        let git = |args: &[&str]| {
            let out = std::process::Command::new("git").args(args).current_dir(repository("")).output().ok()?;
            out.status.success().then(|| String::from_utf8_lossy(&out.stdout).trim().to_owned())
        };
        let commit = git(&["rev-parse", "--short=9", "HEAD"]).unwrap_or_else(|| "unknown commit".to_owned());
        let changed = git(&["status", "--porcelain", "--", "src", "crates", "benches", "Cargo.toml"])
            .is_some_and(|s| !s.is_empty());
        let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split(": ").nth(1));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            commit: format!("{} ({commit}{})", env!("CARGO_PKG_VERSION"), if changed { "+" } else { "" }),
            date: jiff::Zoned::now().date().to_string(),
            machine: format!("{}, {cores} cores", model.unwrap_or("unknown processor")),
        }
    }
}

/// A finding and its origin.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SearchRecord {
    /// What was found.
    #[serde(flatten)]
    pub finding: SearchFinding,
    /// Where and when.
    pub origin: MeasurementOrigin,
}

/// Distance queries of both kernels on the same pairs.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct KernelRecord {
    /// The parts and their distance.
    pub pairs: String,
    /// Mean triangles of a part.
    pub triangles: usize,
    /// Exact distances capped at the clearance, per second.
    pub distances_per_sec: f64,
    /// Queries that only ask whether the clearance holds, per second.
    pub answers_per_sec: f64,
    /// parry3d's exact distances without a cap, per second.
    pub parry_distances_per_sec: f64,
    /// parry3d's nearest points within the clearance, per second.
    pub parry_capped_per_sec: f64,
    /// Greatest difference between the two kernels' distances, mm.
    pub difference_mm: f64,
    /// Where and when.
    pub origin: MeasurementOrigin,
}

/// All measurements so far; a new one replaces an older one of the same trial.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct RecordBook {
    /// Searches.
    pub records: Vec<SearchRecord>,
    /// Kernels.
    #[serde(default)]
    pub kernel: Vec<KernelRecord>,
}

impl RecordBook {
    /// Reads the record; empty when there is none.
    pub fn read() -> Result<Self> {
        match std::fs::read(repository(FILE)) {
            Ok(bytes) => serde_json::from_slice(&bytes).with_context(|| format!("reading {FILE}")),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(error).with_context(|| format!("reading {FILE}")),
        }
    }

    /// Writes one line per record, so that a diff shows changes line by line.
    pub fn write(&self) -> Result<()> {
        let lines = |texts: Vec<String>| texts.join(",\n");
        let of = |record: &SearchRecord| serde_json::to_string(record);
        let records = self.records.iter().map(of).collect::<Result<Vec<String>, _>>()?;
        let kernel = self.kernel.iter().map(serde_json::to_string).collect::<Result<Vec<String>, _>>()?;
        let text = format!("{{\"records\":[\n{}\n],\"kernel\":[\n{}\n]}}\n", lines(records), lines(kernel));
        std::fs::write(repository(FILE), text).with_context(|| format!("writing {FILE}"))
    }

    /// Adds a finding.
    pub fn add_finding(&mut self, finding: SearchFinding, origin: &MeasurementOrigin) {
        let record = SearchRecord { finding, origin: origin.clone() };
        match self.records.iter_mut().find(|r| r.finding.trial == record.finding.trial) {
            Some(known) => *known = record,
            None => self.records.push(record),
        }
        self.records.sort_by_key(|r| serde_json::to_string(&r.finding.trial).unwrap_or_default());
    }

    /// The record of a trial.
    pub fn find_record(&self, trial: &SearchTrial) -> Option<&SearchRecord> {
        self.records.iter().find(|r| r.finding.trial == *trial)
    }
}
