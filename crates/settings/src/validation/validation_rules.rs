//! The third stage: checks the inputs, reports problems, and converts valid inputs to settings.

use std::path::Path;

use access::FilePermissions;
use glam::DVec3;
use jiff::civil::Time;

use super::printer_validation::{validate_calendar, validate_printing};
use crate::{
    BuildSpace, FarmZone, IntakeRules, MachineFolders, MachineProfile, Materials, OutputRules, SearchRules,
    TriggerRules, TurningRules,
    machine::{
        printer::PrinterRules,
        profile::is_machine_name,
        profile_inputs::{
            IntakeInputs, ProfileFolders, ProfileInputs, SearchInputs, SpaceInputs, TriggerInputs, TurningInputs,
        },
    },
    reading::validator::ConfigValidator,
    service::{
        inputs::{FarmFolders, FarmInputs, FileInputs},
        logging::parse_log_filter,
    },
};

/// Longest edge of a machine, mm. A larger value is taken for a wrong unit.
const MAX_EDGE_MM: f64 = 10_000.0;
/// Longest search, seconds: a week.
const MAX_SEARCH_SECS: f64 = 604_800.0;
/// Longest waiting time of a part, seconds: a year. A farm must never wait forever.
const MAX_WAIT_SECS: f64 = 31_536_000.0;
/// Longest time without news before a build fires for a due date, seconds: a day.
const MAX_GATHER_SECS: f64 = 86_400.0;
/// Maximum number of threads of a search, and of its lanes.
const MAX_THREADS: usize = 1024;

/// Reports invalid values of the farm file.
pub(super) fn validate_farm(inputs: &FarmInputs, validator: &mut ConfigValidator) {
    validator.require_within("scan_secs", inputs.scan_secs.0, 0.05..=3600.0);
    validator.require_within("orphan_ticket_secs", inputs.orphan_ticket_secs.0, 0.0..=MAX_WAIT_SECS);
    validator.require_within("threads", inputs.resources.threads, 0..=MAX_THREADS);
    validator.require_within("cache_bytes", inputs.resources.cache_bytes, 0..=1 << 50);
    let limits = &inputs.limits;
    validator.require_within("limits.max_bytes", limits.max_bytes, 1..=u64::MAX);
    validator.require_within("limits.max_triangles", limits.max_triangles, 4..=u64::MAX);
    validator.require_within("limits.max_unpacked_bytes", limits.max_unpacked_bytes, 1..=u64::MAX);
    validator.require_within("limits.max_entries", limits.max_entries, 1..=u64::MAX);
    validator.require_within("limits.max_instances", limits.max_instances, 1..=u64::MAX);
    validator.require_within("limits.max_depth", limits.max_depth, 1..=1000);
    validator.require_within("limits.max_shells", limits.max_shells, 1..=u64::MAX);
    validator.require_within("limits.max_copies", limits.max_copies, 1..=1_000_000);
    validator.require_within("limits.read_memory_bytes", limits.read_memory_bytes, 64 << 20..=u64::MAX);
    if let Err(error) = parse_log_filter(&inputs.log.filter) {
        let remedy = "write a level (error, warn, info, debug, trace) or levels by module, as in \"info,intake=debug\"";
        validator.report_problem("log.filter", format!("log.filter is no filter: {error}"), remedy);
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
        validator.require_path(key, path);
    }
    validate_ledger(folders, validator);
}

/// Validates the address of a ledger on a server. Its texts never hold the password.
fn validate_ledger(folders: &FarmFolders, validator: &mut ConfigValidator) {
    let address = crate::service::folders::ledger_address(folders, ledger::DAEMON_CONNECTIONS, Path::new(""));
    if let Some((text, remedy)) = address.find_problem() {
        validator.report_problem("folders.ledger", format!("folders.ledger: {text}"), remedy);
    }
    if folders.ledger_password_file.0.is_some() && address.file().is_some() {
        let text = "folders.ledger_password_file is there, and the ledger is a file, which has no password".to_owned();
        validator.report_problem(
            "folders.ledger_password_file",
            text,
            "leave it out, or name a server: postgres://user@host/db",
        );
    }
}

/// Validates mode and group of the files that the daemon creates.
pub(super) fn validate_files(inputs: &FileInputs, validator: &mut ConfigValidator) -> FilePermissions {
    let mode = u32::from_str_radix(&inputs.mode, 8).ok().filter(|mode| mode & !0o666 == 0 && mode & 0o600 == 0o600);
    if mode.is_none() {
        let text = format!("files.mode = \"{}\" is no mode of files", inputs.mode.escape_debug());
        let remedy = "give permissions in octal that let nestd read and write, as in mode = \"0660\"";
        validator.report_problem("files.mode", text, remedy);
    }
    let group = match inputs.group.as_str() {
        "" => None,
        name => access::find_group_id(name).or_else(|| {
            let text = format!("files.group: there is no group \"{}\"", name.escape_debug());
            validator.report_problem("files.group", text, "name a group of /etc/group, or give its number in quotes");
            None
        }),
    };
    FilePermissions { mode: mode.unwrap_or(0o660), group }
}

/// Reports invalid values of `[defaults]`, even if every profile overrides them: the next profile may not.
pub(super) fn validate_defaults(inputs: &ProfileInputs, validator: &mut ConfigValidator) {
    if let Some(edges_mm) = inputs.space.volume_mm {
        validate_box(edges_mm, validator);
    }
    validate_values(inputs, validator);
    validate_trigger(&inputs.trigger, validator);
    validate_printing(&inputs.printing, validator);
    validate_calendar(&inputs.printing, |option| option.to_owned(), validator);
    if !inputs.printer.is_empty() {
        let text = "printers in [defaults] would belong to every machine".to_owned();
        validator.report_problem("printer", text, "name them in the files of their machines");
    }
}

/// Creates a profile from its inputs and reports invalid values.
pub(super) fn validate_profile(
    name: &str,
    inputs: ProfileInputs,
    folders: MachineFolders,
    printers: Vec<PrinterRules>,
    validator: &mut ConfigValidator,
) -> MachineProfile {
    if !is_machine_name(name) {
        let remedy = "rename the file: 1 to 40 of a-z, 0-9 and -, as in mjf-5200.toml; folders are named after it";
        validator.report_problem("", format!("\"{}\" cannot be the name of a machine", name.escape_debug()), remedy);
    }
    validate_values(&inputs, validator);
    let volume_mm = validate_volume(&inputs.space, validator);
    let ProfileInputs {
        space,
        turning,
        intake,
        search,
        output,
        printing,
        folders: _,
        trigger,
        delivery,
        costs,
        printer: _,
    } = inputs;
    MachineProfile {
        name: name.to_owned(),
        folders,
        printers,
        printing: validate_printing(&printing, validator),
        costs,
        time_zone: FarmZone::default(),
        materials: Materials::default(),
        text: String::new(),
        of_node: String::new(),
        space: BuildSpace {
            volume_mm,
            wall_margin_mm: space.wall_margin_mm,
            floor_margin_mm: space.floor_margin_mm,
            lid_margin_mm: space.lid_margin_mm,
            keep_out: space.keep_out,
            clearance_mm: space.clearance_mm,
            clearance_z_extra_mm: space.clearance_z_extra_mm,
            layer_mm: space.layer_mm,
            layer_area_cap: space.layer_area_cap.0,
            print_hours_per_mm: space.print_hours_per_mm,
        },
        turning: TurningRules {
            orientation: turning.orientation,
            keep_up: turning.keep_up,
            not_down: turning.not_down,
        },
        intake: IntakeRules {
            unit: intake.unit,
            settle_secs: intake.settle_secs.0,
            unfinished_secs: intake.unfinished_secs.0,
            incomplete_secs: intake.incomplete_secs.0,
            unlisted: intake.unlisted,
            duplicates: intake.duplicates,
            mesh_errors: intake.mesh_errors,
            min_size_mm: intake.min_size_mm,
        },
        trigger: validate_trigger(&trigger, validator),
        search: SearchRules {
            nest: search.nest,
            final_secs: search.final_secs.0,
            arrival_secs: search.arrival_secs.0,
            improve_secs: search.improve_secs.0,
            max_attempts: search.max_attempts,
        },
        output: OutputRules {
            delivery: delivery.kind,
            arrangement: output.arrangement,
            stl_output: output.stl_output,
            archive_days: output.archive_days,
            archive_builds_days: output.archive_builds_days.0,
        },
    }
}

/// Checks the values that do not depend on the machine.
fn validate_values(inputs: &ProfileInputs, validator: &mut ConfigValidator) {
    validate_folders(&inputs.folders, validator);
    validate_space(&inputs.space, validator);
    validate_turning(&inputs.turning, validator);
    validate_intake(&inputs.intake, validator);
    validator.require_within("archive_days", inputs.output.archive_days, 0..=36_500);
    if let Some(days) = inputs.output.archive_builds_days.0 {
        validator.require_within("archive_builds_days", days, 0..=36_500);
    }
    crate::machine::keep_out::validate_zones(&inputs.space.keep_out, inputs.space.volume_mm, validator);
    validate_search(&inputs.search, validator);
    inputs.costs.validate(validator);
}

fn validate_folders(folders: &ProfileFolders, validator: &mut ConfigValidator) {
    let paths = [
        ("folders.inbox", &folders.inbox),
        ("folders.queue", &folders.queue),
        ("folders.error", &folders.error),
        ("folders.archive", &folders.archive),
    ];
    for (key, path) in paths {
        path.iter().for_each(|path| validator.require_path(key, path));
    }
}

fn validate_space(space: &SpaceInputs, validator: &mut ConfigValidator) {
    validator.require_within("wall_margin_mm", space.wall_margin_mm, 0.0..=MAX_EDGE_MM);
    validator.require_within("floor_margin_mm", space.floor_margin_mm, 0.0..=MAX_EDGE_MM);
    validator.require_within("lid_margin_mm", space.lid_margin_mm, 0.0..=MAX_EDGE_MM);
    validator.require_within("clearance_mm", space.clearance_mm, 0.0..=100.0);
    validator.require_within("clearance_z_extra_mm", space.clearance_z_extra_mm, 0.0..=100.0);
    validator.require_within("layer_mm", space.layer_mm, 0.001..=10.0);
    if space.layer_area_cap.0.is_some_and(|share| !(share > 0.0 && share <= 1.0)) {
        let remedy = "give a number above 0, at most 1, or \"off\"";
        validator.report_problem("layer_area_cap", "layer_area_cap is not a share of the base".into(), remedy);
    }
    validator.require_within("print_hours_per_mm", space.print_hours_per_mm, 0.0..=100.0);
}

fn validate_turning(turning: &TurningInputs, validator: &mut ConfigValidator) {
    for (key, count) in [("keep_up", turning.keep_up.len()), ("not_down", turning.not_down.len())] {
        if count > nester::MAX_TILTS {
            validator.report_problem(
                key,
                format!("{key} names {count} directions"),
                format!("name {} at most", nester::MAX_TILTS),
            );
        }
    }
}

fn validate_intake(intake: &IntakeInputs, validator: &mut ConfigValidator) {
    validator.require_within("settle_secs", intake.settle_secs.0, 0.0..=86_400.0);
    validator.require_within("unfinished_secs", intake.unfinished_secs.0, 0.0..=604_800.0);
    validator.require_within("incomplete_secs", intake.incomplete_secs.0, 0.0..=604_800.0);
}

/// Validates the printable box. The margins must leave some of it.
fn validate_volume(space: &SpaceInputs, validator: &mut ConfigValidator) -> DVec3 {
    let Some(edges_mm) = space.volume_mm else {
        validator.report_problem(
            "volume_mm",
            "there is no volume_mm".into(),
            "add the machine's printable box, as in volume_mm = [200, 200, 200]",
        );
        return DVec3::ONE;
    };
    let [x, y, z] = edges_mm;
    if !validate_box(edges_mm, validator) {
        return edges_mm.into();
    }
    if 2.0 * space.wall_margin_mm >= x.min(y) {
        let text = format!("two wall margins of {} mm leave nothing of {x} x {y} mm", space.wall_margin_mm);
        validator.report_problem("wall_margin_mm", text, "make wall_margin_mm smaller or volume_mm larger");
    }
    if space.floor_margin_mm + space.lid_margin_mm >= z {
        let text = format!(
            "margins of {} and {} mm leave nothing of {z} mm height",
            space.floor_margin_mm, space.lid_margin_mm
        );
        validator.report_problem(
            "floor_margin_mm",
            text,
            "make floor_margin_mm and lid_margin_mm smaller or volume_mm larger",
        );
    }
    edges_mm.into()
}

fn validate_box(edges_mm: [f64; 3], validator: &mut ConfigValidator) -> bool {
    let is_box = edges_mm.iter().all(|edge| *edge > 0.0 && *edge <= MAX_EDGE_MM);
    if !is_box {
        let [x, y, z] = edges_mm;
        let remedy = format!("give three lengths in mm, each more than 0 and at most {MAX_EDGE_MM}");
        validator.report_problem("volume_mm", format!("volume_mm = [{x}, {y}, {z}] is not a box"), remedy);
    }
    is_box
}

fn validate_trigger(inputs: &TriggerInputs, validator: &mut ConfigValidator) -> TriggerRules {
    for (key, share) in [("trigger.fill_height", inputs.fill_height), ("trigger.fill_density", inputs.fill_density)] {
        if share.0.is_some_and(|share| !(share > 0.0 && share <= 1.0)) {
            validator.report_problem(
                key,
                format!("{key} is not a share of the volume"),
                "give a number above 0, at most 1, or \"off\"",
            );
        }
    }
    if inputs.copies.0 == Some(0) {
        validator.report_problem(
            "trigger.copies",
            "trigger.copies = 0 would always fire".into(),
            "give a number of copies or \"off\"",
        );
    }
    validator.require_within("trigger.max_wait_secs", inputs.max_wait_secs.0, 0.0..=MAX_WAIT_SECS);
    if let Some(margin) = inputs.due_margin_secs.0 {
        validator.require_within("trigger.due_margin_secs", margin.0, 0.0..=MAX_WAIT_SECS);
    }
    validator.require_within("trigger.gather_secs", inputs.gather_secs.0, 0.0..=MAX_GATHER_SECS);
    TriggerRules {
        fill_height: inputs.fill_height.0,
        fill_density: inputs.fill_density.0,
        copies: inputs.copies.0,
        max_wait_secs: inputs.max_wait_secs.0,
        due_margin_secs: inputs.due_margin_secs.0.map(|margin| margin.0),
        gather_secs: inputs.gather_secs.0,
        at: parse_times(&inputs.at, validator),
    }
}

/// Parses times of day and sorts them.
fn parse_times(texts: &[String], validator: &mut ConfigValidator) -> Vec<Time> {
    let mut times = Vec::new();
    for text in texts {
        match text.parse::<Time>() {
            Ok(time) => times.push(time),
            Err(_) => {
                let text = format!("trigger.at: \"{}\" is not a time of day", text.escape_debug());
                validator.report_problem(
                    "trigger.at",
                    text,
                    "write hours and minutes, as in at = [\"09:00\", \"17:00\"]",
                );
            }
        }
    }
    times.sort();
    times.dedup();
    times
}

fn validate_search(search: &SearchInputs, validator: &mut ConfigValidator) {
    validator.require_within("final_secs", search.final_secs.0, 0.0..=MAX_SEARCH_SECS);
    validator.require_within("arrival_secs", search.arrival_secs.0, 0.0..=MAX_SEARCH_SECS);
    validator.require_within("improve_secs", search.improve_secs.0, 0.0..=MAX_SEARCH_SECS);
    validator.require_within("max_attempts", search.max_attempts, 1..=100);
    let (config, paper) = (&search.nest, &search.nest.paper);
    validator.require_within("nest.threads", config.threads, 0..=MAX_THREADS);
    validator.require_within("nest.lanes", config.lanes, 0..=MAX_THREADS);
    validator.require_within("nest.paper.population", paper.population, 1..=1_000_000);
    validator.require_within("nest.paper.iterations", paper.iterations, 0..=1_000_000_000);
    validator.require_within("nest.paper.switch_probability", paper.switch_probability, 0.0..=1.0);
    validator.require_within("nest.paper.scale", paper.scale, 1e-6..=1e6);
    // Mantegna's algorithm generates Levy steps only for these exponents.
    validator.require_within("nest.paper.levy_exponent", paper.levy_exponent, 0.3..=1.99);
    validator.require_within("nest.paper.target_height_mm", paper.target_height_mm, 0.0..=MAX_EDGE_MM);
    validator.require_within("nest.paper.relative_height_error", paper.relative_height_error, 0.0..=1.0);
}
