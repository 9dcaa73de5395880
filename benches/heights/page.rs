//! Writes `docs/benchmark.md` and its drawings from the record of all measurements.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use sample_parts::ComparedWorkload;

use super::{
    cases::LISTED,
    plot,
    record_book::{MeasurementOrigin, RecordBook, SearchRecord},
    repository, tables,
    trial::TrialBudget,
};

const PAGE: &str = "docs/benchmark.md";

const HEAD: &str = "\
# How low, how fast

Written by `cargo bench --bench heights` from [benchmark.json](benchmark.json), which records every search with its seed, commit and curve.
To measure again:

    cargo bench --bench heights                                        # everything, 90 minutes on two cores
    cargo bench --bench heights -- --only heights --cases engine30 --seeds 10 --secs 10,60
    cargo bench --bench heights -- --only ablation --evaluations 100000 --seeds 8
    cargo bench --bench heights -- --page                              # only this page

Heights are mm, means over the seeds (8 of ours, up to 3 of the published method). Times are CPU seconds of one thread, in a process of its own.
Each last layout is proved on its triangles. The published method is `--method paper`. The lower bound may be out of reach. The searches of
a table may come from different days, commits and processors.
";

/// Writes page and drawings.
pub fn write(book: &RecordBook) -> Result<()> {
    let mut page = HEAD.to_owned();
    let own = |r: &&SearchRecord| ComparedWorkload::named(&r.finding.trial.case).is_some();
    let compared: Vec<&SearchRecord> = book.records.iter().filter(own).collect();
    section(&mut page, "Height at the same CPU seconds", &compared, tables::heights);
    page.push_str(&drawings(&compared)?);
    let listed: Vec<&SearchRecord> = book.records.iter().filter(|r| r.finding.trial.case.starts_with(LISTED)).collect();
    section(&mut page, "Other people's parts", &listed, tables::listed);
    page.push_str(&drawings(&listed)?);
    let all: Vec<&SearchRecord> = book.records.iter().collect();
    section(&mut page, "What each component is worth", &all, tables::ablation);
    section(&mut page, "What flower pollination is worth", &all, tables::flowers);
    section(&mut page, "From 20 to 1,000 copies", &all, tables::scale);
    section(&mut page, "The first layout", &all, tables::first_layouts);
    if !book.kernel.is_empty() {
        page.push_str(&format!("\n## Distance queries beside parry3d\n\n{}", tables::kernel(&book.kernel)));
        page.push_str(&origins(book.kernel.iter().map(|record| &record.origin)));
    }
    std::fs::write(repository(PAGE), page).with_context(|| format!("writing {PAGE}"))
}

/// A table with its title and the machines that measured it; empty without rows.
fn section(
    page: &mut String,
    title: &str,
    records: &[&SearchRecord],
    table: fn(&[&SearchRecord]) -> (String, Vec<MeasurementOrigin>),
) {
    let (text, measured) = table(records);
    if !measured.is_empty() {
        page.push_str(&format!("\n## {title}\n\n{text}{}", origins(measured.iter())));
    }
}

/// When and on what processors it was measured.
fn origins<'a>(measured: impl Iterator<Item = &'a MeasurementOrigin>) -> String {
    let (mut dates, mut machines) = (BTreeSet::new(), BTreeSet::new());
    for origin in measured {
        dates.insert(origin.date.as_str());
        machines.insert(origin.machine.as_str());
    }
    let (first, last) = (dates.first().copied().unwrap_or_default(), dates.last().copied().unwrap_or_default());
    let days = if first == last { first.to_owned() } else { format!("{first} to {last}") };
    format!("\nMeasured {days} on {}.\n", machines.into_iter().collect::<Vec<_>>().join("; "))
}

/// A drawing for each workload, of the searches with the most seeds, and of these the longest.
fn drawings(records: &[&SearchRecord]) -> Result<String> {
    let cases: BTreeSet<&str> = records.iter().map(|r| r.finding.trial.case.as_str()).collect();
    let mut links = "\nHeight over time:\n".to_owned();
    for case in cases {
        let secs = |r: &SearchRecord| match r.finding.trial.budget {
            TrialBudget::CpuSecs(secs) => Some(secs),
            TrialBudget::Evaluations(_) => None,
        };
        let of_case = || records.iter().filter(|r| r.finding.trial.case == case && r.finding.trial.without.is_none());
        let of_secs = |wanted: u64| of_case().filter(move |r| secs(r) == Some(wanted)).copied();
        let Some(drawn_secs) = of_case().filter_map(|r| secs(r)).max_by_key(|&secs| (of_secs(secs).count(), secs))
        else {
            continue;
        };
        let drawn: Vec<&SearchRecord> = of_secs(drawn_secs).collect();
        let name = case.replace('/', "-");
        let file = format!("docs/heights-{name}.svg");
        let drawing = plot::drawing(&format!("{name}: build height over time"), &drawn, drawn_secs as f64);
        std::fs::write(repository(&file), drawing).with_context(|| format!("writing {file}"))?;
        links.push_str(&format!("\n![{name}](heights-{name}.svg)\n"));
    }
    Ok(links)
}
