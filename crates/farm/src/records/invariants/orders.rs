//! I5 from outside: the copies in the build files themselves, against what was asked as a witness wrote it down.

use std::{collections::BTreeMap, path::PathBuf};

use anyhow::Result;
use ledger::{Ledger, LineCopies};
use settings::Settings;

use super::report::{
    AskedCopies,
    Invariant::{I3, I5},
    InvariantExpectations, InvariantReport,
};

/// For each dropped file: copies in build files that are not told bad are at most those wanted, and, with the copies that
/// the ledger says wait, stand in builds or are refused, exactly those.
pub async fn check_asked_copies(
    settings: &Settings,
    ledger: &Ledger,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> Result<()> {
    let Some(asked) = &witness.asked else { return Ok(()) };
    let mut printed = count_printed_copies(settings, witness, report);
    for (hash, asked) in asked {
        let mut line = LineCopies::default();
        let parts = ledger.parts_with_content(hash).await?;
        for part in &parts {
            line.add(&ledger.line_of_part(part.id).await?.copies);
        }
        let name = parts.first().map_or_else(|| hash.clone(), |part| format!("{} (part {})", part.name, part.id));
        let printed = printed.remove(hash).unwrap_or_default();
        if let Some(fault) = compare_line(asked, printed, &line, witness.at_rest && !parts.is_empty()) {
            report.add_violation(I5, format!("{name}: {fault}"), REPORT_IT);
        }
    }
    for (hash, copies) in printed {
        let text = format!("{copies} copies of a file that nobody dropped are in build files (BLAKE3 {hash})");
        report.add_violation(I5, text, REPORT_IT);
    }
    Ok(())
}

/// What is wrong with a line: `printed` = its copies in build files, `is_settled` = no copy is on its way from one place to
/// another.
fn compare_line(asked: &AskedCopies, printed: u32, line: &LineCopies, is_settled: bool) -> Option<String> {
    let AskedCopies { wanted, bad } = *asked;
    let told = format!("{wanted} copies wanted, {printed} in build files, of which {bad} are told bad");
    if printed < bad {
        return Some(format!("{told}: more than there are"));
    }
    let live = printed - bad;
    if live > wanted {
        return Some(format!("{told}: {} printed more often than asked for", live - wanted));
    }
    let elsewhere = line.waiting + line.in_builds + line.refused;
    if is_settled && live + elsewhere != wanted {
        let LineCopies { waiting, in_builds, refused, .. } = *line;
        return Some(format!("{told}, {waiting} wait, {in_builds} in builds that are made, {refused} refused"));
    }
    if is_settled && (line.wanted, line.bad) != (wanted, bad) {
        return Some(format!("{told}; the ledger says {} wanted and {} bad", line.wanted, line.bad));
    }
    None
}

/// The copies in all build files that printers took or can take, by BLAKE3 of the dropped file.
fn count_printed_copies(
    settings: &Settings,
    witness: &InvariantExpectations,
    report: &mut InvariantReport,
) -> BTreeMap<String, u32> {
    let queues = settings.profiles.values().flat_map(|profile| &profile.printers).map(|printer| &printer.queue);
    let queued = queues.flat_map(|queue| {
        let names = queue.visible_builds().unwrap_or_default();
        names.into_iter().map(|name| queue.visible_file(&name))
    });
    let files: Vec<PathBuf> = queued.chain(witness.taken.iter().cloned()).collect();
    let mut printed: BTreeMap<String, u32> = BTreeMap::new();
    for file in files {
        match build_file::read_build(&file, &settings.limits) {
            Ok(placed) => {
                report.files_read += 1;
                for copy in placed {
                    *printed.entry(copy.source_hash.unwrap_or_default()).or_default() += 1;
                }
            }
            Err(error) => report.add_violation(I3, format!("{}: {error}", file.display()), REPORT_IT),
        }
    }
    printed
}

const REPORT_IT: &str = "keep all folders as they are and report it to nestd's makers";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_that_is_lost_or_printed_more_often_than_asked_is_told_and_bad_ones_are_printed_again() {
        let line = |waiting, refused| LineCopies { wanted: 3, waiting, refused, bad: 1, ..LineCopies::default() };
        let asked = AskedCopies { wanted: 3, bad: 1 };
        let fault = |printed, line: LineCopies, is_settled| compare_line(&asked, printed, &line, is_settled);
        assert_eq!(fault(4, line(0, 0), true), None, "three are good");
        assert_eq!(fault(3, line(1, 0), true), None, "one waits");
        assert_eq!(fault(2, line(0, 2), true), None, "two were refused");
        assert!(fault(5, line(0, 0), false).unwrap().contains("1 printed more often than asked for"));
        assert!(fault(3, line(0, 0), true).unwrap().contains("3 in build files"), "one is lost");
        assert_eq!(fault(3, line(0, 0), false), None, "it may be on its way");
        assert!(fault(0, line(3, 0), true).unwrap().contains("more than there are"));
        let other = LineCopies { wanted: 4, ..line(0, 0) };
        assert!(fault(4, other, true).unwrap().contains("the ledger says 4 wanted"));
    }
}
