//! Every file of the torture set (opt-in by `NESTD_DATA`) through the real daemon: dropped into its hot folder, each in
//! its own order. The ledger and the error folder must show what the manifest expects.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use ledger::{PartRow, PartState};

use crate::{
    harness::{SectionBudget, SectionResult},
    support::{
        QUICK, TestFarm,
        manifest::{self, EXCEPTIONS, ExpectedFile, FileOutcome},
    },
};

/// A machine of the largest size, because a part that is refused for its size tests no reader. No batch fires.
fn farm() -> TestFarm {
    let large =
        QUICK.replace("[120, 120, 120]", "[10000, 10000, 10000]").replace("arrival_secs = 0.5", "arrival_secs = 0");
    TestFarm::running(&format!("{large}mesh_errors = \"warn\"\nduplicates = \"accept\"\n"))
}

pub fn run(budget: &SectionBudget) -> SectionResult {
    let Some(data) = std::env::var_os("NESTD_DATA").map(PathBuf::from) else {
        return SectionResult { note: "left out: NESTD_DATA is not set".to_owned(), ..SectionResult::default() };
    };
    let names = manifest::unpack_names(&data);
    let every = budget.pick(20, 1);
    let files: Vec<ExpectedFile> = manifest::files(&data).into_iter().step_by(every).collect();
    let farm = farm();
    for (number, expected) in files.iter().enumerate() {
        let file = expected.file(&data, names.path());
        let folder = farm.folder("inbox").join(order(number));
        fs::create_dir_all(&folder).unwrap();
        fs::copy(&file, folder.join(file.file_name().unwrap())).unwrap();
    }
    let mut row = SectionResult { files: files.len() as u64, points: files.len() as u64, ..SectionResult::default() };
    if !all_taken(&farm, budget.secs.max(120.0)) {
        row.broken.push("not every file was taken in time".to_owned());
    }
    check_outcomes(&farm, &files, &data, names.path(), &mut row);
    row
}

fn order(number: usize) -> String {
    format!("t{number:03}")
}

/// Waits until no file is left to take or to read.
fn all_taken(farm: &TestFarm, secs: f64) -> bool {
    let began = Instant::now();
    while began.elapsed().as_secs_f64() < secs {
        std::thread::sleep(std::time::Duration::from_millis(300));
        // Folders may appear and disappear during the listing.
        let Ok(in_inbox) = intake::files_below(&farm.folder("inbox")) else { continue };
        let is_left = |file: &PathBuf| {
            let relative = file.strip_prefix(farm.folder("inbox")).unwrap();
            // A claimed file has no row in the ledger yet.
            let is_claimed = relative.starts_with(".claimed");
            is_claimed || !relative.iter().any(intake::is_ignored) && relative.components().count() > 1
        };
        if !in_inbox.iter().any(is_left) && farm.parts(PartState::Claimed).is_empty() {
            return true;
        }
    }
    false
}

fn check_outcomes(farm: &TestFarm, files: &[ExpectedFile], data: &Path, names: &Path, row: &mut SectionResult) {
    let exceptions: HashMap<&str, &str> = EXCEPTIONS.into_iter().collect();
    let (mut met, mut excepted) = (0, Vec::new());
    for (number, expected) in files.iter().enumerate() {
        let file = expected.file(data, names);
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let parts = farm.query_ledger(async |ledger| ledger.parts_of_order(&order(number)).await.unwrap());
        let complaint = match expected.expect.starts_with("ignore") {
            true => (!parts.is_empty()).then(|| "taken".to_owned()),
            false => expected.find_difference(&outcome(farm, &order(number), &parts)),
        };
        match (complaint, exceptions.get(name.as_str())) {
            (None, None) => met += 1,
            (Some(_), Some(reason)) => excepted.push(format!("{name} ({reason})")),
            (Some(complaint), None) => row.broken.push(format!("{name}: expected {}; {complaint}", expected.expect)),
            (None, Some(reason)) => {
                row.broken.push(format!("{name}: is as expected, though excepted because {reason}"))
            }
        }
    }
    row.note = format!("{met} of {} files met the expectation; exceptions: {}", files.len(), excepted.join("; "));
}

/// The result of a file in the ledger, or the reason in the error folder if it never became a part.
fn outcome(farm: &TestFarm, order: &str, parts: &[PartRow]) -> FileOutcome {
    let messages: Vec<&str> =
        parts.iter().flat_map(|part| [part.warnings.as_str(), part.refused.reason.as_str()]).collect();
    let is_refused = parts.is_empty() || parts.iter().any(|part| part.state == PartState::Refused);
    if is_refused {
        let error = farm.folder("error").join(order);
        let reasons = fs::read_dir(&error).map_or(0, |entries| {
            entries.filter(|e| e.as_ref().unwrap().path().to_string_lossy().ends_with(".reason.txt")).count()
        });
        let lost = if reasons == 1 { "" } else { " BUT there is not one reason in the error folder" };
        return FileOutcome { triangles: None, left_out: 0, messages: messages.join("\n") + lost };
    }
    let triangles = parts.iter().map(|p| p.measures.triangles.unwrap_or(0) as usize * in_file(p)).sum();
    FileOutcome { triangles: Some(triangles), left_out: left_out(parts), messages: messages.join("\n") }
}

/// The copies of a part in its file. A name such as "rail-2x" multiplies the copies, which the manifest does not
/// consider.
fn in_file(part: &PartRow) -> usize {
    (part.owed.copies / intake::copies_in_name(&part.name).unwrap_or(1)) as usize
}

/// "5 triangles without an area (3 left out, 2 kept to stay closed)", copies counted each.
fn left_out(parts: &[PartRow]) -> usize {
    let of_part = |part: &PartRow| -> usize {
        let lines = part.warnings.lines().filter(|line| line.contains("without an area"));
        let count = |line: &str| line.split_once('(')?.1.split_once(" left out")?.0.parse::<usize>().ok();
        lines.filter_map(count).sum::<usize>() * in_file(part)
    };
    parts.iter().map(of_part).sum()
}
