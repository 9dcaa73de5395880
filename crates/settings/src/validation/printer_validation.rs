//! Checks what a machine's file says of its printers.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use delivery::queue::QueueAddress;

use crate::{
    ConfigProblem, MachineProfile, Materials, PrinterRules, PrintingRules, WorkCalendar,
    machine::{
        printer::PrinterInputs,
        profile::is_machine_name,
        profile_inputs::{PrintingInputs, ProfileInputs},
    },
    reading::validator::ConfigValidator,
    service::folders::path_below,
};

/// The printers of a machine whose queue folder is `queue` if it names none. `farm_queue` is the folder of the farm that
/// holds the queue folders.
pub(super) fn validate_printers(
    name: &str,
    inputs: &ProfileInputs,
    (root, farm_queue, queue): (&Path, &Path, &Path),
    validator: &mut ConfigValidator,
) -> Vec<PrinterRules> {
    let calendar = validate_calendar(&inputs.printing, |option| option.to_owned(), validator);
    if inputs.printer.is_empty() {
        return vec![PrinterRules { name: name.to_owned(), queue: QueueAddress::Folder(queue.to_owned()), calendar }];
    }
    if inputs.folders.queue.is_some() {
        let text = "folders.queue is the queue folder of a machine without [[printer]]".to_owned();
        validator.report_problem("folders.queue", text, "give each printer its queue instead");
    }
    let mut printers = Vec::new();
    for (at, printer) in inputs.printer.iter().enumerate() {
        if !is_machine_name(&printer.name) {
            let text = format!("\"{}\" cannot be the name of a printer", printer.name.escape_debug());
            validator.report_problem("printer", text, "give 1 to 40 of a-z, 0-9 and -, as in name = \"mjf-left\"");
        }
        let own = PrintingInputs {
            hours: printer.hours.clone().unwrap_or_else(|| inputs.printing.hours.clone()),
            days_off: printer.days_off.clone().unwrap_or_else(|| inputs.printing.days_off.clone()),
            ..inputs.printing.clone()
        };
        printer.queue.iter().for_each(|queue| validator.require_path("printer.queue", queue));
        let queue = match &printer.queue {
            Some(exact) if !exact.as_os_str().is_empty() => path_below(root, exact),
            _ => path_below(root, farm_queue).join(&printer.name),
        };
        let calendar = match printer.hours.is_some() || printer.days_off.is_some() {
            true => validate_calendar(&own, |option| key_of(printer, at, option), validator),
            false => calendar.clone(),
        };
        printers.push(PrinterRules { name: printer.name.clone(), queue: QueueAddress::Folder(queue), calendar });
    }
    printers
}

/// The key of an option of a printer's calendar: its own, or what its machine says for all.
fn key_of(printer: &PrinterInputs, at: usize, option: &str) -> String {
    let is_own = if option == "hours" { printer.hours.is_some() } else { printer.days_off.is_some() };
    if is_own { format!("printer.{at}.{option}") } else { option.to_owned() }
}

/// Reports values that make no sense, and reads the calendar. `key` says where an option of it stands.
pub(super) fn validate_calendar(
    inputs: &PrintingInputs,
    key: impl Fn(&str) -> String,
    validator: &mut ConfigValidator,
) -> WorkCalendar {
    WorkCalendar::parse(&inputs.hours, &inputs.days_off).unwrap_or_else(|(option, why)| {
        let remedy = match option {
            "hours" => "write hours as in \"Mon-Fri 6-22, Sat 8:30-12\" or \"always\"",
            _ => "write days off as in [\"2026-12-25\", \"2026-12-28..2027-01-01\"]",
        };
        validator.report_problem(&key(option), format!("{option}: {why}"), remedy);
        WorkCalendar::default()
    })
}

/// The rules of a machine's prints.
pub(super) fn validate_printing(inputs: &PrintingInputs, validator: &mut ConfigValidator) -> PrintingRules {
    validator.require_within("cool_down_hours", inputs.cool_down_hours, 0.0..=1000.0);
    validator.require_within("thin", inputs.thin, 0.0..=1.0);
    validator.require_within("queue_depth", f64::from(inputs.queue_depth), 0.0..=1000.0);
    PrintingRules {
        material: inputs.material.trim().to_owned(),
        cool_down_hours: inputs.cool_down_hours,
        approve: inputs.approve,
        thin: inputs.thin,
        queue_depth: inputs.queue_depth,
        withdraw: inputs.withdraw,
    }
}

/// Gives a machine the materials of the farm, and what is loaded in it its name.
pub(super) fn name_loaded(profile: &mut MachineProfile, materials: &Materials, validator: &mut ConfigValidator) {
    match materials.require_name(&profile.printing.material) {
        Ok(name) => profile.printing.material = name,
        Err(_) => {
            let text = format!("material = \"{}\" is not in [materials]", profile.printing.material.escape_debug());
            let remedy = format!("name one of {}, or add it to [materials] in the farm file", materials.known_text());
            validator.report_problem("material", text, remedy);
        }
    }
    profile.materials = materials.clone();
}

/// File and line of the name of each printer of a machine.
pub(super) fn places_of_names(profile: &MachineProfile, validator: &ConfigValidator) -> Vec<(PathBuf, Option<usize>)> {
    (0..profile.printers.len()).map(|at| validator.locate_key(&format!("printer.{at}.name"))).collect()
}

/// Reports printers of one name: a person names one without its machine.
pub(super) fn find_same_names(
    profiles: &BTreeMap<String, MachineProfile>,
    places: &BTreeMap<String, Vec<(PathBuf, Option<usize>)>>,
) -> Vec<ConfigProblem> {
    let mut machines: BTreeMap<&str, &str> = profiles.keys().map(|name| (name.as_str(), name.as_str())).collect();
    let (mut problems, mut own) = (Vec::new(), Vec::new());
    for profile in profiles.values().filter(|profile| profile.has_named_printers()) {
        for (at, printer) in profile.printers.iter().enumerate() {
            let is_taken = machines.insert(&printer.name, &profile.name).is_some_and(|other| other != profile.name);
            if is_taken || own.contains(&(&profile.name, &printer.name)) {
                let place = places.get(&profile.name).and_then(|places| places.get(at));
                let (file, line) = place.cloned().unwrap_or_default();
                let text = format!("the name {} of a printer of {} is taken", printer.name, profile.name);
                let remedy = "give each printer of the farm a name of its own".to_owned();
                problems.push(ConfigProblem { file, line, text, remedy });
            }
            own.push((&profile.name, &printer.name));
        }
    }
    problems
}
