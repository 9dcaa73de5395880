//! The printers of a machine: several of one kind behind one hot folder, each with its queue folder. A machine whose file
//! names none is one printer, with the name and the queue folder of the machine.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    ConfigProblem, FarmZone, MachineProfile, WorkCalendar,
    folders::path_below,
    profile_inputs::{PrintingInputs, ProfileInputs},
    validation_rules::is_profile_name,
    validator::ConfigValidator,
};

/// A printer of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct PrinterRules {
    /// Its name, unique in the farm.
    pub name: String,
    /// Its queue folder.
    pub queue: PathBuf,
    /// When its prints begin.
    pub calendar: WorkCalendar,
}

/// `[[printer]]` of a machine's file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrinterInputs {
    #[serde(default)]
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub queue: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hours: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub days_off: Option<Vec<String>>,
}

/// When a person must release a proved build before it is published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ApprovalPolicy {
    /// Never.
    #[default]
    Never,
    /// Where the build is thin.
    Thin,
    /// Always.
    Always,
}

/// How the machine is used: what a print takes beside its height, and which builds wait for a yes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PrintingRules {
    /// Hours from the end of a print to the begin of the next one on the same printer: cooling and unpacking.
    pub cool_down_hours: f64,
    /// Which builds wait for a person's yes.
    pub approve: ApprovalPolicy,
    /// A build lower than this share of the volume's height is thin, 0..1.
    pub thin: f64,
}

impl PrintingRules {
    /// Whether a build of this height waits for a person's yes; `share` = its height / that of the volume.
    pub fn needs_release(&self, share: f64) -> bool {
        match self.approve {
            ApprovalPolicy::Never => false,
            ApprovalPolicy::Thin => share < self.thin,
            ApprovalPolicy::Always => true,
        }
    }
}

impl MachineProfile {
    /// Its queue folders, one per printer.
    pub fn queue_folders(&self) -> impl Iterator<Item = &PathBuf> {
        self.printers.iter().map(|printer| &printer.queue)
    }

    /// Whether its file names printers.
    pub fn has_named_printers(&self) -> bool {
        self.printers.len() > 1 || self.printers.iter().any(|printer| printer.name != self.name)
    }

    /// What messages call the queue folder of a printer.
    pub fn queue_description(&self, printer: &PrinterRules) -> String {
        match printer.name == self.name {
            true => format!("queue of {}", self.name),
            false => format!("queue of {}, printer {}", self.name, printer.name),
        }
    }

    /// The first of its printers in whose queue folder a file of this name is visible, else the first one's folder.
    pub fn queue_with_file(&self, name: &str) -> &Path {
        let holds = self.queue_folders().find(|folder| folder.join(name).exists());
        holds.unwrap_or(&self.folders.queue)
    }
}

/// The printers of a machine whose queue folder is `queue` if it names none. `farm_queue` is the folder of the farm that
/// holds the queue folders.
pub(super) fn validate_printers(
    name: &str,
    inputs: &ProfileInputs,
    (root, farm_queue, queue): (&Path, &Path, &Path),
    validator: &mut ConfigValidator,
) -> Vec<PrinterRules> {
    let calendar = validate_calendar(&inputs.printing, validator);
    if inputs.printer.is_empty() {
        return vec![PrinterRules { name: name.to_owned(), queue: queue.to_owned(), calendar }];
    }
    if inputs.folders.queue.is_some() {
        let text = "folders.queue is the queue folder of a machine without [[printer]]".to_owned();
        validator.report_problem("folders.queue", text, "give each printer its queue instead");
    }
    let mut printers = Vec::new();
    for printer in &inputs.printer {
        if !is_profile_name(&printer.name) {
            let text = format!("\"{}\" cannot be the name of a printer", printer.name.escape_debug());
            validator.report_problem("printer", text, "give 1 to 40 of a-z, 0-9 and -, as in name = \"mjf-left\"");
        }
        let own = PrintingInputs {
            hours: printer.hours.clone().unwrap_or_else(|| inputs.printing.hours.clone()),
            days_off: printer.days_off.clone().unwrap_or_else(|| inputs.printing.days_off.clone()),
            ..inputs.printing.clone()
        };
        let queue = match &printer.queue {
            Some(exact) if !exact.as_os_str().is_empty() => path_below(root, exact),
            _ => path_below(root, farm_queue).join(&printer.name),
        };
        printers.push(PrinterRules { name: printer.name.clone(), queue, calendar: validate_calendar(&own, validator) });
    }
    printers
}

/// Reports values that make no sense, and reads the calendar.
pub(super) fn validate_calendar(inputs: &PrintingInputs, validator: &mut ConfigValidator) -> WorkCalendar {
    WorkCalendar::parse(&inputs.hours, &inputs.days_off).unwrap_or_else(|why| {
        let remedy = "write hours as in \"Mon-Fri 6-22, Sat 8:30-12\" or \"always\", and days off as in \
                      [\"2026-12-25\", \"2026-12-28..2027-01-01\"]";
        validator.report_problem("hours", format!("hours or days_off: {why}"), remedy);
        WorkCalendar::default()
    })
}

/// The rules of a machine's prints.
pub(super) fn validate_printing(inputs: &PrintingInputs, validator: &mut ConfigValidator) -> PrintingRules {
    validator.require_within("cool_down_hours", inputs.cool_down_hours, 0.0..=1000.0);
    validator.require_within("thin", inputs.thin, 0.0..=1.0);
    PrintingRules { cool_down_hours: inputs.cool_down_hours, approve: inputs.approve, thin: inputs.thin }
}

/// Reports printers of one name: a person names one without its machine.
pub(super) fn find_same_names(
    profiles: &BTreeMap<String, MachineProfile>,
    places: &BTreeMap<String, (PathBuf, Option<usize>)>,
) -> Vec<ConfigProblem> {
    let mut machines: BTreeMap<&str, &str> = profiles.keys().map(|name| (name.as_str(), name.as_str())).collect();
    let (mut problems, mut own) = (Vec::new(), Vec::new());
    for profile in profiles.values().filter(|profile| profile.has_named_printers()) {
        for printer in &profile.printers {
            let is_taken = machines.insert(&printer.name, &profile.name).is_some_and(|other| other != profile.name);
            if is_taken || own.contains(&(&profile.name, &printer.name)) {
                let (file, line) = places.get(&profile.name).cloned().unwrap_or_default();
                let text = format!("the name {} of a printer of {} is taken", printer.name, profile.name);
                let remedy = "give each printer of the farm a name of its own".to_owned();
                problems.push(ConfigProblem { file, line, text, remedy });
            }
            own.push((&profile.name, &printer.name));
        }
    }
    problems
}

/// The moment from which a print may begin on a printer, at or after `at`.
impl PrinterRules {
    /// The first moment from `at` on in which a print may begin; a calendar that is never open again says nothing.
    pub fn begins_at(&self, at: jiff::Timestamp, zone: &FarmZone) -> jiff::Timestamp {
        self.calendar.next_open(at, zone.time_zone()).unwrap_or(jiff::Timestamp::MAX)
    }
}
