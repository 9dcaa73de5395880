//! Reads the search report that lies next to a build file. A build in the ledger has the same facts in its rows.

use std::path::Path;

use build_file::name_in_build_file;
use farm::{CakeContents, CakeCopy};
use ledger::RemovalStep;
use nester::RemovedCopy;

/// Largest report that is read.
const MAX_REPORT_BYTES: u64 = 32 << 20;

/// The facts of a search report that pages show.
#[derive(Debug, Default)]
pub(crate) struct ReportExcerpt {
    /// (seconds, height in mm) of every improvement.
    pub(crate) curve: Vec<(f64, f64)>,
    /// The copies in the proved removal order.
    pub(crate) order: Vec<RemovedCopy>,
}

impl ReportExcerpt {
    /// Reads the report in the folder of a build file; empty when there is none.
    pub(crate) fn read_beside(file: &Path) -> Self {
        let read = || -> Option<serde_json::Value> {
            let stem = build_file::build_file_stem(file.file_name()?.to_str()?)?;
            let folder = file.parent().unwrap_or(Path::new("."));
            // Other users may write into this folder, so the read is limited.
            let report = intake::read_start(&folder.join(format!("{stem}.report.json")), MAX_REPORT_BYTES).ok()??;
            serde_json::from_slice(&report).ok()
        };
        let report = read().unwrap_or_default();
        Self {
            curve: serde_json::from_value(report["curve"].clone()).unwrap_or_default(),
            order: serde_json::from_value(report["separable"]["order"].clone()).unwrap_or_default(),
        }
    }

    /// Sets the removal order and direction of the copies in the cake. Where two parts have the same name, the report
    /// does not say which of them it means; both stay unmarked.
    pub(crate) fn mark_removal_order(&self, cake: &mut CakeContents) {
        for (place, removal) in (1..).zip(&self.order) {
            let mut meant: Vec<&mut CakeCopy> = Vec::new();
            for part in cake.parts.iter_mut().filter(|part| is_reported_part(&part.name, &removal.part)) {
                meant.extend(part.copies.iter_mut().filter(|standing| standing.copy == removal.copy + 1));
            }
            if let [one] = &mut meant[..] {
                one.drawn = Some(RemovalStep { position: place, direction: removal.direction });
            }
        }
    }
}

/// Whether a part of the cake is the one that a report names. The report names the dropped file; the cake adds the name
/// of the solid in parentheses.
fn is_reported_part(name: &str, reported: &str) -> bool {
    let name = name_in_build_file(name);
    name.strip_prefix(reported).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ("))
}
