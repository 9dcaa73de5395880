//! Checks the system's limits that a farm can reach.

use std::{fs, path::Path};

use jiff::{Timestamp, tz::TimeZone};
use rustix::process::{Resource, getrlimit};
use settings::{FarmZone, Settings};

use super::report::CheckReport;

/// Open files that a busy daemon needs: ledger connections, a few parts and builds at once, inotify.
const MIN_OPEN_FILES: u64 = 256;
/// Watches that are left for other programs of the same user.
const OTHER_PROGRAMS_WATCHES: usize = 1000;
/// Folders are counted up to this number; counting further would not change the result.
const MAX_COUNTED: usize = 1_000_000;

/// Checks the system.
pub fn check_system(settings: &Settings, report: &mut CheckReport) {
    check_open_files(report);
    check_watches(settings, report);
    check_threads(settings, report);
    check_time_zone(settings, report);
}

/// Shows the time zone of the farm: dates of tickets and lists mean days there.
fn check_time_zone(settings: &Settings, report: &mut CheckReport) {
    let (zone, now) = (&settings.time_zone, Timestamp::now());
    match TimeZone::try_system() {
        Err(_) if *zone == FarmZone::default() => report.add_note(
            "time zone",
            "the system names none that it knows: days are days of UTC; set time_zone, or install tzdata",
        ),
        _ => report.add_ok("time zone", format!("{}, now {}", zone.name(), zone.format_minute(now))),
    }
}

fn check_open_files(report: &mut CheckReport) {
    match getrlimit(Resource::Nofile).current {
        Some(limit) if limit < MIN_OPEN_FILES => report.add_problem(
            "open files",
            format!("at most {limit} may be open, nestd needs {MIN_OPEN_FILES}"),
            "raise LimitNOFILE= of the unit, or ulimit -n",
        ),
        Some(limit) => report.add_ok("open files", format!("at most {limit}")),
        None => report.add_ok("open files", "no limit"),
    }
}

/// Checks the inotify limits. Each folder below a hot folder needs one watch; a folder without a watch is only scanned.
fn check_watches(settings: &Settings, report: &mut CheckReport) {
    let limit = |name| -> Option<usize> {
        fs::read_to_string(format!("/proc/sys/fs/inotify/{name}")).ok()?.trim().parse().ok()
    };
    if limit("max_user_instances") == Some(0) {
        report.add_problem("inotify", "no instance is allowed", "sysctl fs.inotify.max_user_instances=128");
    }
    let Some(allowed) = limit("max_user_watches") else {
        report.add_note("inotify", "is not there: the hot folders are scanned only");
        return;
    };
    let needed: usize = settings.profiles.values().map(|profile| count_folders(&profile.folders.inbox)).sum();
    if needed + OTHER_PROGRAMS_WATCHES > allowed {
        report.add_problem(
            "inotify",
            format!("{allowed} folders may be watched, the hot folders have {needed}"),
            format!(
                "sysctl fs.inotify.max_user_watches={}",
                (4 * (needed + OTHER_PROGRAMS_WATCHES)).next_power_of_two()
            ),
        );
    } else {
        report.add_ok("inotify", format!("{allowed} folders may be watched, the hot folders have {needed}"));
    }
}

/// Counts a folder and all folders below it; links are not followed.
fn count_folders(folder: &Path) -> usize {
    let (mut waiting, mut count) = (vec![folder.to_owned()], 0);
    while let Some(folder) = waiting.pop() {
        let Ok(entries) = fs::read_dir(&folder) else { continue };
        count += 1;
        if count >= MAX_COUNTED {
            break;
        }
        let below = entries.flatten().filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
        waiting.extend(below.map(|entry| entry.path()));
    }
    count
}

fn check_threads(settings: &Settings, report: &mut CheckReport) {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    match settings.resources.threads {
        0 => report.add_ok("threads", format!("{cores}, one per core")),
        threads if threads > cores => {
            report.add_note("threads", format!("{threads} on {cores} cores: the threads wait for each other"))
        }
        threads => report.add_ok("threads", format!("{threads} of {cores} cores")),
    }
}
