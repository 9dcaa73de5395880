//! The table of results of a run, as text and as `docs/reliability.md`.

use std::{fs, path::Path};

use super::section_result::SectionResult;

/// The document, and its heading above the table.
const DOCUMENT: &str = "docs/reliability.md";
const HEADING: &str = "## The last run\n";

const HEAD: [&str; 8] = ["section", "points tried", "faults injected", "files", "builds", "broken", "seconds", "note"];

/// The columns that the document has.
const DOCUMENTED: [usize; 5] = [0, 2, 3, 4, 5];

/// The table, in Markdown.
pub fn table(rows: &[SectionResult]) -> String {
    table_of(rows, &[0, 1, 2, 3, 4, 5, 6, 7])
}

/// The table with these columns.
fn table_of(rows: &[SectionResult], shown: &[usize]) -> String {
    let mut cells: Vec<Vec<String>> = vec![HEAD.map(str::to_owned).to_vec()];
    cells.extend(rows.iter().map(cells_of));
    cells.push(cells_of(&SectionResult { section: "all", ..SectionResult::sum(rows) }));
    let width = |at: usize| cells.iter().map(|row| row[at].chars().count()).max().unwrap_or_default();
    let widths: Vec<usize> = (0..HEAD.len()).map(width).collect();
    let mut lines: Vec<String> = cells.iter().map(|row| line(row, &widths, shown)).collect();
    let rule: Vec<String> = shown.iter().map(|&at| rule(at, widths[at])).collect();
    lines.insert(1, format!("|{}|", rule.join("|")));
    lines.join("\n") + "\n"
}

fn is_number(at: usize) -> bool {
    (1..=6).contains(&at)
}

fn rule(at: usize, width: usize) -> String {
    if is_number(at) { format!("{}:", "-".repeat(width + 1)) } else { "-".repeat(width + 2) }
}

fn line(row: &[String], widths: &[usize], shown: &[usize]) -> String {
    let cell = |&at: &usize| {
        let (text, width) = (&row[at], widths[at]);
        if is_number(at) { format!(" {text:>width$} ") } else { format!(" {text:<width$} ") }
    };
    format!("|{}|", shown.iter().map(cell).collect::<Vec<_>>().join("|"))
}

fn cells_of(row: &SectionResult) -> Vec<String> {
    let numbers = [row.points, row.faults, row.files, row.builds, row.broken.len() as u64].map(|n| n.to_string());
    let mut cells = vec![row.section.to_owned()];
    cells.extend(numbers);
    cells.push(format!("{:.0}", row.seconds));
    cells.push(row.note.replace('|', "/").replace('\n', " "));
    cells
}

/// Writes the section of the last run into the document; only a long run of every section does. What it prints has all columns.
pub fn write_document(rows: &[SectionResult], minutes: f64) {
    let profile = if cfg!(debug_assertions) { "test" } else { "release" };
    let host = rustix::system::uname();
    let threads = std::thread::available_parallelism().map_or(0, usize::from);
    let run = format!(
        "A budget of {minutes} minutes, {profile} profile, nestd {}, {} {}, {threads} threads, on {}.\n\n{}",
        env!("CARGO_PKG_VERSION"),
        host.sysname().to_string_lossy(),
        host.release().to_string_lossy(),
        jiff::Zoned::now().strftime("%Y-%m-%d"),
        table_of(rows, &DOCUMENTED)
    );
    let broken: Vec<String> =
        rows.iter().flat_map(|row| row.broken.iter().map(|b| format!("- {}: {b}\n", row.section))).collect();
    let broken = if broken.is_empty() { String::new() } else { format!("\nBroken:\n\n{}", broken.concat()) };
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(DOCUMENT);
    let text = fs::read_to_string(&file).unwrap();
    let (before, last) = text.split_once(HEADING).expect("the document has a section of the last run");
    let after = last.split_once("\n## ").map_or(String::new(), |(_, after)| format!("\n## {after}"));
    fs::write(file, format!("{before}{HEADING}\n{run}{broken}{after}")).unwrap();
}
