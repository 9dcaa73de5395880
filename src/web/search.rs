//! What the report of the search tells of a build file that it lies beside; of a build in the ledger its rows tell the same.

use std::path::Path;

use build_file::name_in_build_file;
use nester::DrawnCopy;

use crate::{
    farm::{Cake, Standing},
    intake,
    ledger::DrawnOut,
};

/// What a report is read of at most.
const MAX_REPORT_BYTES: u64 = 32 << 20;

/// What pages show of it.
#[derive(Debug, Default)]
pub(super) struct Told {
    /// (seconds, height in mm) of every improvement.
    pub(super) curve: Vec<(f64, f64)>,
    /// The copies in an order in which they can be drawn out, as it was proved.
    pub(super) order: Vec<DrawnCopy>,
}

impl Told {
    /// From the folder that a build file lies in; nothing when there is no report.
    pub(super) fn beside(file: &Path) -> Self {
        let read = || -> Option<serde_json::Value> {
            let stem = file.file_name()?.to_str()?.strip_suffix(".build.3mf")?;
            let folder = file.parent().unwrap_or(Path::new("."));
            // Others may write into this folder.
            let report = intake::read_start(&folder.join(format!("{stem}.report.json")), MAX_REPORT_BYTES).ok()??;
            serde_json::from_slice(&report).ok()
        };
        let report = read().unwrap_or_default();
        Self {
            curve: serde_json::from_value(report["curve"].clone()).unwrap_or_default(),
            order: serde_json::from_value(report["separable"]["order"].clone()).unwrap_or_default(),
        }
    }

    /// Marks how the copies come out of the cake. Where the report names two parts by the same name, which of them it means
    /// is not said, and they stay unmarked.
    pub(super) fn mark(&self, cake: &mut Cake) {
        for (place, drawn) in (1..).zip(&self.order) {
            let mut meant: Vec<&mut Standing> = Vec::new();
            for part in cake.parts.iter_mut().filter(|part| is_of(&part.name, &drawn.part)) {
                meant.extend(part.copies.iter_mut().filter(|standing| standing.copy == drawn.copy + 1));
            }
            if let [one] = &mut meant[..] {
                one.drawn = Some(DrawnOut { place, way: drawn.way });
            }
        }
    }
}

/// Whether a part is the one that a report names: by the file that it was dropped as; the cake names its solid as well.
fn is_of(name: &str, reported: &str) -> bool {
    let name = name_in_build_file(name);
    name.strip_prefix(reported).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ("))
}
