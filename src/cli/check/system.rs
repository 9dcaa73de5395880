//! Limits of the system that a farm runs into.

use std::{fs, path::Path};

use rustix::process::{Resource, getrlimit};

use super::report::Report;
use crate::settings::Settings;

/// Open files that a busy daemon needs: ledger connections, a few parts and builds at once, the watch.
const MIN_OPEN_FILES: u64 = 256;
/// Folders that other programs of the same user may watch.
const OTHERS_WATCHES: usize = 1000;
/// Folders are counted up to here; more are more than enough to say so.
const MAX_COUNTED: usize = 1_000_000;

/// Looks at the system.
pub fn look(settings: &Settings, report: &mut Report) {
    open_files(report);
    watches(settings, report);
    threads(settings, report);
}

fn open_files(report: &mut Report) {
    match getrlimit(Resource::Nofile).current {
        Some(limit) if limit < MIN_OPEN_FILES => report.problem(
            "open files",
            format!("at most {limit} may be open, nestd needs {MIN_OPEN_FILES}"),
            "raise LimitNOFILE= of the unit, or ulimit -n",
        ),
        Some(limit) => report.ok("open files", format!("at most {limit}")),
        None => report.ok("open files", "no limit"),
    }
}

/// Each folder below a hot folder takes one watch; without it, it is scanned only.
fn watches(settings: &Settings, report: &mut Report) {
    let limit = |name| -> Option<usize> {
        fs::read_to_string(format!("/proc/sys/fs/inotify/{name}")).ok()?.trim().parse().ok()
    };
    if limit("max_user_instances") == Some(0) {
        report.problem("inotify", "no instance is allowed", "sysctl fs.inotify.max_user_instances=128");
    }
    let Some(allowed) = limit("max_user_watches") else {
        report.note("inotify", "is not there: the hot folders are scanned only");
        return;
    };
    let needed: usize = settings.profiles.values().map(|profile| folders_below(&profile.folders.inbox)).sum();
    if needed + OTHERS_WATCHES > allowed {
        report.problem(
            "inotify",
            format!("{allowed} folders may be watched, the hot folders have {needed}"),
            format!("sysctl fs.inotify.max_user_watches={}", (4 * (needed + OTHERS_WATCHES)).next_power_of_two()),
        );
    } else {
        report.ok("inotify", format!("{allowed} folders may be watched, the hot folders have {needed}"));
    }
}

/// The folder and all below it; links are not followed.
fn folders_below(folder: &Path) -> usize {
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

fn threads(settings: &Settings, report: &mut Report) {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    match settings.threads {
        0 => report.ok("threads", format!("{cores}, one per core")),
        threads if threads > cores => {
            report.note("threads", format!("{threads} on {cores} cores: they wait for one another"))
        }
        threads => report.ok("threads", format!("{threads} of {cores} cores")),
    }
}
