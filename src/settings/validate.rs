//! The third stage: inputs that make sense become settings; whatever does not is objected to.

use std::path::Path;

use glam::DVec3;
use jiff::civil::Time;

use super::{
    BuildSpace, Folders, IntakeRules, OutputRules, Profile, SearchRules, Trigger, TurningRules,
    inputs::{FarmInputs, FileInputs, ProfileInputs, TriggerInputs},
    judge::Judge,
    logging::parse_log_filter,
};
use crate::access::{self, Access};

/// Longest edge of a machine, mm; more is a slip of the unit.
const MAX_EDGE_MM: f64 = 10_000.0;
/// Longest search, seconds: a week.
const MAX_SEARCH_SECS: f64 = 604_800.0;
/// Longest wait of a part, seconds: a year. A farm must never wait for ever.
const MAX_WAIT_SECS: f64 = 31_536_000.0;
/// Most threads that a search may be given.
const MAX_THREADS: usize = 1024;

/// Objects to what makes no sense in the farm file.
pub(super) fn farm(inputs: &FarmInputs, judge: &mut Judge) {
    judge.within("scan_secs", inputs.scan_secs.0, 0.05..=3600.0);
    judge.within("orphan_ticket_secs", inputs.orphan_ticket_secs.0, 0.0..=MAX_WAIT_SECS);
    judge.within("threads", inputs.threads, 0..=MAX_THREADS);
    judge.within("cache_bytes", inputs.cache_bytes, 0..=1 << 50);
    let limits = &inputs.limits;
    judge.within("limits.max_bytes", limits.max_bytes, 1..=u64::MAX);
    judge.within("limits.max_triangles", limits.max_triangles, 4..=u64::MAX);
    judge.within("limits.max_unpacked_bytes", limits.max_unpacked_bytes, 1..=u64::MAX);
    judge.within("limits.max_entries", limits.max_entries, 1..=u64::MAX);
    judge.within("limits.max_instances", limits.max_instances, 1..=u64::MAX);
    judge.within("limits.max_depth", limits.max_depth, 1..=1000);
    judge.within("limits.max_shells", limits.max_shells, 1..=u64::MAX);
    judge.within("limits.max_copies", limits.max_copies, 1..=1_000_000);
    judge.within("limits.read_memory_bytes", limits.read_memory_bytes, 64 << 20..=u64::MAX);
    if let Err(error) = parse_log_filter(&inputs.log.filter) {
        let remedy =
            "write a level (error, warn, info, debug, trace) or levels by module, as in \"info,nestd::intake=debug\"";
        judge.object("log.filter", format!("log.filter is no filter: {error}"), remedy);
    }
    let folders = &inputs.folders;
    let paths = [
        ("root", &inputs.root),
        ("folders.inbox", &folders.inbox),
        ("folders.queue", &folders.queue),
        ("folders.error", &folders.error),
        ("folders.archive", &folders.archive),
        ("folders.state", &folders.state),
        ("folders.ledger", &folders.ledger),
    ];
    for (key, path) in paths {
        path_makes_sense(key, path, judge);
    }
}

/// Mode and group of what the daemon makes.
pub(super) fn files(inputs: &FileInputs, judge: &mut Judge) -> Access {
    let mode = u32::from_str_radix(&inputs.mode, 8).ok().filter(|mode| mode & !0o666 == 0 && mode & 0o600 == 0o600);
    if mode.is_none() {
        let text = format!("files.mode = \"{}\" is no mode of files", inputs.mode.escape_debug());
        let remedy = "give permissions in octal that let nestd read and write, as in mode = \"0660\"";
        judge.object("files.mode", text, remedy);
    }
    let group = match inputs.group.as_str() {
        "" => None,
        name => access::group_number(name).or_else(|| {
            let text = format!("files.group: there is no group \"{}\"", name.escape_debug());
            judge.object("files.group", text, "name a group of /etc/group, or give its number in quotes");
            None
        }),
    };
    Access { mode: mode.unwrap_or(0o660), group }
}

/// Objects to what makes no sense in `[defaults]`, also where every profile has a value of its own: the next one may not.
pub(super) fn defaults(inputs: &ProfileInputs, judge: &mut Judge) {
    if let Some(edges_mm) = inputs.volume_mm {
        box_makes_sense(edges_mm, judge);
    }
    values(inputs, judge);
    trigger(&inputs.trigger, judge);
}

/// Makes a profile of its inputs and objects to what makes no sense.
pub(super) fn profile(name: &str, inputs: ProfileInputs, folders: Folders, judge: &mut Judge) -> Profile {
    if !is_profile_name(name) {
        let remedy = "rename the file: 1 to 40 of a-z, 0-9 and -, as in mjf-5200.toml; folders are named after it";
        judge.object("", format!("\"{}\" cannot be the name of a profile", name.escape_debug()), remedy);
    }
    values(&inputs, judge);
    let volume_mm = volume(&inputs, judge);
    Profile {
        name: name.to_owned(),
        folders,
        space: BuildSpace {
            volume_mm,
            wall_margin_mm: inputs.wall_margin_mm,
            floor_margin_mm: inputs.floor_margin_mm,
            lid_margin_mm: inputs.lid_margin_mm,
            keep_out: inputs.keep_out,
            clearance_mm: inputs.clearance_mm,
            clearance_z_extra_mm: inputs.clearance_z_extra_mm,
            layer_mm: inputs.layer_mm,
            layer_area_cap: inputs.layer_area_cap.0,
            print_hours_per_mm: inputs.print_hours_per_mm,
        },
        turning: TurningRules { orientation: inputs.orientation, keep_up: inputs.keep_up, not_down: inputs.not_down },
        intake: IntakeRules {
            unit: inputs.unit,
            settle_secs: inputs.settle_secs.0,
            unfinished_secs: inputs.unfinished_secs.0,
            incomplete_secs: inputs.incomplete_secs.0,
            unlisted: inputs.unlisted,
            duplicates: inputs.duplicates,
            mesh_errors: inputs.mesh_errors,
        },
        trigger: trigger(&inputs.trigger, judge),
        search: SearchRules {
            nest: inputs.nest,
            final_secs: inputs.final_secs.0,
            arrival_secs: inputs.arrival_secs.0,
            max_attempts: inputs.max_attempts,
        },
        output: OutputRules {
            instances: inputs.instances,
            arrangement: inputs.arrangement,
            stl_output: inputs.stl_output,
            archive_days: inputs.archive_days,
        },
    }
}

/// What makes sense or not by itself, whatever the machine.
fn values(inputs: &ProfileInputs, judge: &mut Judge) {
    let own = &inputs.folders;
    let paths = [
        ("folders.inbox", &own.inbox),
        ("folders.queue", &own.queue),
        ("folders.error", &own.error),
        ("folders.archive", &own.archive),
    ];
    for (key, path) in paths {
        path.iter().for_each(|path| path_makes_sense(key, path, judge));
    }
    judge.within("wall_margin_mm", inputs.wall_margin_mm, 0.0..=MAX_EDGE_MM);
    judge.within("floor_margin_mm", inputs.floor_margin_mm, 0.0..=MAX_EDGE_MM);
    judge.within("lid_margin_mm", inputs.lid_margin_mm, 0.0..=MAX_EDGE_MM);
    judge.within("clearance_mm", inputs.clearance_mm, 0.0..=100.0);
    judge.within("clearance_z_extra_mm", inputs.clearance_z_extra_mm, 0.0..=100.0);
    judge.within("layer_mm", inputs.layer_mm, 0.001..=10.0);
    if inputs.layer_area_cap.0.is_some_and(|share| !(share > 0.0 && share <= 1.0)) {
        let remedy = "give a number above 0, at most 1, or \"off\"";
        judge.object("layer_area_cap", "layer_area_cap is not a share of the base".into(), remedy);
    }
    judge.within("print_hours_per_mm", inputs.print_hours_per_mm, 0.0..=100.0);
    for (key, count) in [("keep_up", inputs.keep_up.len()), ("not_down", inputs.not_down.len())] {
        if count > nester::MAX_TILTS {
            judge.object(key, format!("{key} names {count} directions"), format!("name {} at most", nester::MAX_TILTS));
        }
    }
    judge.within("settle_secs", inputs.settle_secs.0, 0.0..=86_400.0);
    judge.within("unfinished_secs", inputs.unfinished_secs.0, 0.0..=604_800.0);
    judge.within("incomplete_secs", inputs.incomplete_secs.0, 0.0..=604_800.0);
    judge.within("final_secs", inputs.final_secs.0, 0.0..=MAX_SEARCH_SECS);
    judge.within("arrival_secs", inputs.arrival_secs.0, 0.0..=MAX_SEARCH_SECS);
    judge.within("max_attempts", inputs.max_attempts, 1..=100);
    judge.within("archive_days", inputs.archive_days, 0..=36_500);
    super::keep_out::judge(&inputs.keep_out, inputs.volume_mm, judge);
    search(&inputs.nest, judge);
}

fn is_profile_name(name: &str) -> bool {
    let known = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    (1..=40).contains(&name.len()) && name.chars().all(known)
}

/// A path that would surprise: an empty one is the folder above, `~` is known to shells only.
fn path_makes_sense(key: &str, path: &Path, judge: &mut Judge) {
    if path.as_os_str().is_empty() {
        judge.object(key, format!("{key} is empty"), "name a folder or leave the option out");
    } else if path.starts_with("~") {
        judge.object(key, format!("{key}: \"~\" means nothing in a configuration"), "write the whole path");
    }
}

/// The printable box; the margins must leave something of it.
fn volume(inputs: &ProfileInputs, judge: &mut Judge) -> DVec3 {
    let Some(edges_mm) = inputs.volume_mm else {
        judge.object(
            "volume_mm",
            "there is no volume_mm".into(),
            "add the machine's printable box, as in volume_mm = [200, 200, 200]",
        );
        return DVec3::ONE;
    };
    let [x, y, z] = edges_mm;
    if !box_makes_sense(edges_mm, judge) {
        return edges_mm.into();
    }
    if 2.0 * inputs.wall_margin_mm >= x.min(y) {
        let text = format!("two wall margins of {} mm leave nothing of {x} x {y} mm", inputs.wall_margin_mm);
        judge.object("wall_margin_mm", text, "make wall_margin_mm smaller or volume_mm larger");
    }
    if inputs.floor_margin_mm + inputs.lid_margin_mm >= z {
        let text = format!(
            "margins of {} and {} mm leave nothing of {z} mm height",
            inputs.floor_margin_mm, inputs.lid_margin_mm
        );
        judge.object("floor_margin_mm", text, "make floor_margin_mm and lid_margin_mm smaller or volume_mm larger");
    }
    edges_mm.into()
}

fn box_makes_sense(edges_mm: [f64; 3], judge: &mut Judge) -> bool {
    let is_box = edges_mm.iter().all(|edge| *edge > 0.0 && *edge <= MAX_EDGE_MM);
    if !is_box {
        let [x, y, z] = edges_mm;
        let remedy = format!("give three lengths in mm, each more than 0 and at most {MAX_EDGE_MM}");
        judge.object("volume_mm", format!("volume_mm = [{x}, {y}, {z}] is not a box"), remedy);
    }
    is_box
}

fn trigger(inputs: &TriggerInputs, judge: &mut Judge) -> Trigger {
    for (key, share) in [("trigger.fill_height", inputs.fill_height), ("trigger.fill_density", inputs.fill_density)] {
        if share.0.is_some_and(|share| !(share > 0.0 && share <= 1.0)) {
            judge.object(
                key,
                format!("{key} is not a share of the volume"),
                "give a number above 0, at most 1, or \"off\"",
            );
        }
    }
    if inputs.copies.0 == Some(0) {
        judge.object(
            "trigger.copies",
            "trigger.copies = 0 would always fire".into(),
            "give a number of copies or \"off\"",
        );
    }
    judge.within("trigger.max_wait_secs", inputs.max_wait_secs.0, 0.0..=MAX_WAIT_SECS);
    if let Some(margin) = inputs.due_margin_secs.0 {
        judge.within("trigger.due_margin_secs", margin.0, 0.0..=MAX_WAIT_SECS);
    }
    Trigger {
        fill_height: inputs.fill_height.0,
        fill_density: inputs.fill_density.0,
        copies: inputs.copies.0,
        max_wait_secs: inputs.max_wait_secs.0,
        due_margin_secs: inputs.due_margin_secs.0.map(|margin| margin.0),
        at: times(&inputs.at, judge),
    }
}

/// Times of day in their order.
fn times(texts: &[String], judge: &mut Judge) -> Vec<Time> {
    let mut times = Vec::new();
    for text in texts {
        match text.parse::<Time>() {
            Ok(time) => times.push(time),
            Err(_) => {
                let text = format!("trigger.at: \"{}\" is not a time of day", text.escape_debug());
                judge.object("trigger.at", text, "write hours and minutes, as in at = [\"09:00\", \"17:00\"]");
            }
        }
    }
    times.sort();
    times.dedup();
    times
}

fn search(config: &nester::Config, judge: &mut Judge) {
    let paper = &config.paper;
    judge.within("nest.threads", config.threads, 0..=MAX_THREADS);
    judge.within("nest.paper.population", paper.population, 1..=1_000_000);
    judge.within("nest.paper.iterations", paper.iterations, 0..=1_000_000_000);
    judge.within("nest.paper.switch_probability", paper.switch_probability, 0.0..=1.0);
    judge.within("nest.paper.scale", paper.scale, 1e-6..=1e6);
    // Mantegna's algorithm makes Levy steps for these exponents only.
    judge.within("nest.paper.levy_exponent", paper.levy_exponent, 0.3..=1.99);
    judge.within("nest.paper.target_height_mm", paper.target_height_mm, 0.0..=MAX_EDGE_MM);
    judge.within("nest.paper.relative_height_error", paper.relative_height_error, 0.0..=1.0);
}
