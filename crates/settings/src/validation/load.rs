//! Finds and loads a configuration: files -> fragments -> inputs -> settings.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use serde::{Deserialize, de::DeserializeOwned};
use thiserror::Error;
use toml::{Table, Value};

use super::{printer_validation, validation_rules};
use crate::{
    ConfigProblem, InterfaceSettings, LogSettings, MachineFolders, MachineProfile, PrinterRules, ResourceSettings,
    Settings,
    machine::{farm_zone, materials, profile_inputs::ProfileInputs},
    reading::{
        folder_conflicts::{self, FolderClaim},
        fragment::{ConfigFragment, read_config_text},
        validator::ConfigValidator,
    },
    service::{
        folders,
        inputs::{FarmFolders, FarmInputs},
    },
};

/// Default paths of the configuration.
const DEFAULT_FILES: [&str; 2] = ["config/nestd.toml", "/etc/nestd/nestd.toml"];
/// The folder of the machine files, beside the farm file.
const PROFILES_DIR: &str = "profiles";

/// Why the configuration could not be loaded.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// No file was named and none exists at the default paths, or the named file does not exist.
    #[error("no configuration: {}; name one with -c FILE, or take a copy of nestd's config folder", not_found_text(.searched))]
    NotFound {
        /// The paths that were searched.
        searched: Vec<PathBuf>,
    },
    /// The configuration is invalid. Lists all problems that were found.
    #[error("the configuration is wrong:\n{}", .0.iter().map(|p| format!("  {p}")).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<ConfigProblem>),
}

fn not_found_text(searched: &[PathBuf]) -> String {
    let names: Vec<String> = searched.iter().map(|file| file.display().to_string()).collect();
    match names.as_slice() {
        [one] => format!("{one} is not there"),
        several => format!("neither {} is there", several.join(" nor ")),
    }
}

/// Loads `config`, or else `config/nestd.toml`, or else `/etc/nestd/nestd.toml`, and the machine files in `profiles/`
/// beside it. `root` moves all folders of the farm except those that the configuration gives as absolute paths.
///
/// There is no configuration, or it is invalid; then all its problems.
pub fn load_settings(config: Option<&Path>, root: Option<&Path>) -> Result<Settings, SettingsError> {
    let file = find_config_file(config)?;
    let mut problems = Vec::new();
    let settings = read_settings(&file, root, &mut problems, true);
    match settings {
        Some(settings) if problems.is_empty() => Ok(settings),
        _ => Err(SettingsError::Invalid(problems)),
    }
}

/// Like [`load_settings`], for callers that only read the ledger. If machine files are invalid but the farm file is valid and so
/// tells where the farm is, it returns the settings with the remaining machines, together with all problems.
///
/// There is no configuration, or the farm file is invalid.
pub fn load_for_viewing(
    config: Option<&Path>,
    root: Option<&Path>,
) -> Result<(Settings, Vec<ConfigProblem>), SettingsError> {
    let file = find_config_file(config)?;
    let mut problems = Vec::new();
    // Links are not followed: a share that hangs must not hold up whoever only looks.
    match read_settings(&file, root, &mut problems, false) {
        Some(settings) if problems.iter().all(|problem| problem.file != file) => Ok((settings, problems)),
        _ => Err(SettingsError::Invalid(problems)),
    }
}

/// The farm file: `config`, or else the first of the usual places where there is one.
///
/// # Errors
/// When there is none.
pub fn find_config_file(config: Option<&Path>) -> Result<PathBuf, SettingsError> {
    let candidates = match config {
        Some(file) => vec![file.to_owned()],
        None => DEFAULT_FILES.map(PathBuf::from).to_vec(),
    };
    match candidates.iter().find(|file| file.exists()) {
        Some(file) => Ok(file.clone()),
        None => Err(SettingsError::NotFound { searched: candidates }),
    }
}

/// Runs all stages. `None` if the farm file cannot be used.
fn read_settings(
    file: &Path,
    root: Option<&Path>,
    problems: &mut Vec<ConfigProblem>,
    follows_links: bool,
) -> Option<Settings> {
    let farm_text = read_config_text(file, problems);
    let machine_texts = read_machine_files(file, problems);
    let has_machines = !machine_texts.is_empty();
    let machines: Vec<(&str, Option<ConfigFragment>)> = (machine_texts.iter())
        .map(|(name, file, text)| (name.as_str(), ConfigFragment::parse_toml::<ProfileInputs>(file, text, problems)))
        .collect();
    let farm_text = farm_text?;
    let farm = ConfigFragment::parse_toml::<FarmInputs>(file, &farm_text, problems)?;
    let inputs: FarmInputs = from_table(farm.to_table(), file, problems)?;
    let mut validator = ConfigValidator::new(vec![(&farm, "")]);
    validation_rules::validate_farm(&inputs, &mut validator);
    let (time_zone, language) = farm_zone::validate_place(&inputs.time_zone, &inputs.language, &mut validator);
    let files = validation_rules::validate_files(&inputs.files, &mut validator);
    let node = crate::service::node::validate_node(&inputs.node, &mut validator);
    let web = crate::service::web::validate_web(&inputs.web, &mut validator);
    let metrics = crate::service::metrics::validate_metrics(&inputs.metrics, &mut validator);
    let notify = crate::service::notify::validate_notify(&inputs.notify, &mut validator);
    let materials = materials::validate_materials(&inputs.materials, &mut validator);
    let root = folders::farm_root(&inputs, root);
    let state_dir = folders::path_below(&root, &inputs.folders.state);
    let state = state_claim(&state_dir, &validator);
    problems.append(&mut validator.problems);
    problems.append(&mut problems_of_defaults(&farm, &inputs.defaults));

    let mut profiles = BTreeMap::new();
    let (mut claims, mut places) = (Vec::new(), BTreeMap::new());
    for (name, own) in machines {
        let Some(own) = own else { continue };
        let validator = &mut ConfigValidator::new(vec![(&own, ""), (&farm, "defaults."), (&farm, "")]);
        if let Some(mut profile) = build_profile(name, &own, &farm, &root, &inputs, validator) {
            profile.time_zone = time_zone.clone();
            printer_validation::name_loaded(&mut profile, &materials, validator);
            claims.extend(folder_claims(&profile, &own.file, validator));
            places.insert(name.to_owned(), printer_validation::places_of_names(&profile, validator));
            profiles.insert(name.to_owned(), profile);
        }
        // An invalid default affects every profile but is reported only once.
        validator.problems.retain(|problem| !problems.contains(problem));
        problems.append(&mut validator.problems);
    }
    problems.extend(printer_validation::find_same_names(&profiles, &places));
    problems.extend(folder_conflicts::find_all_conflicts(claims, state, follows_links));
    let ledger = folders::ledger_address(&inputs.folders, inputs.node.connections, &state_dir);
    problems.extend((!has_machines && problems.is_empty() && ledger.file().is_some()).then(|| missing_machine(file)));
    let log = LogSettings { filter: inputs.log.filter, format: inputs.log.format };
    Some(Settings {
        file: file.to_owned(),
        ledger,
        inbox_base: folders::path_below(&root, &inputs.folders.inbox),
        root,
        time_zone,
        language,
        node,
        state_dir,
        scan_secs: inputs.scan_secs.0,
        orphan_ticket_secs: inputs.orphan_ticket_secs.0,
        resources: ResourceSettings { threads: inputs.resources.threads, cache_bytes: inputs.resources.cache_bytes },
        limits: inputs.limits,
        files,
        interfaces: InterfaceSettings { log, web, metrics, notify },
        materials,
        profiles,
    })
}

fn problems_of_defaults(farm: &ConfigFragment, inputs: &ProfileInputs) -> Vec<ConfigProblem> {
    let mut validator = ConfigValidator::new(vec![(farm, "defaults.")]);
    validation_rules::validate_defaults(inputs, &mut validator);
    validator.problems
}

fn state_claim(state_dir: &Path, validator: &ConfigValidator<'_>) -> FolderClaim {
    FolderClaim {
        folder: state_dir.to_owned(),
        description: "the state directory".into(),
        location: validator.locate_key("folders.state"),
        is_named: false,
    }
}

/// The folder of the machine files.
fn machine_folder(farm_file: &Path) -> PathBuf {
    farm_file.parent().unwrap_or(Path::new("")).join(PROFILES_DIR)
}

/// A farm has machines. Of the nodes that share a ledger on a server, some may have none: theirs may just go to another one.
fn missing_machine(farm_file: &Path) -> ConfigProblem {
    ConfigProblem {
        file: machine_folder(farm_file),
        line: None,
        text: "there is no machine".into(),
        remedy: "put one file per machine here, as in profiles/mjf-5200.toml; its name is the machine's name".into(),
    }
}

/// Name, file and text of every machine file, by name.
fn read_machine_files(farm_file: &Path, problems: &mut Vec<ConfigProblem>) -> Vec<(String, PathBuf, String)> {
    let folder = machine_folder(farm_file);
    let listed = fs::read_dir(&folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<PathBuf>>>());
    let mut files = match listed {
        Ok(files) => files,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
        // A folder that cannot be read is never taken for one without machines.
        Err(error) => {
            let (line, text) = (None, format!("cannot be read: {error}"));
            let remedy = "make it readable for nestd's user".into();
            problems.push(ConfigProblem { file: folder, line, text, remedy });
            return Vec::new();
        }
    };
    files.retain(|path| is_machine_file(path));
    files.sort();
    let named = |file: PathBuf| {
        let text = read_config_text(&file, problems)?;
        Some((file.file_stem()?.to_string_lossy().into_owned(), file, text))
    };
    files.into_iter().filter_map(named).collect()
}

fn is_machine_file(path: &Path) -> bool {
    let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    !hidden && path.extension().is_some_and(|extension| extension == "toml")
}

/// Merges a machine file with the farm's defaults and checks the result.
fn build_profile(
    name: &str,
    own: &ConfigFragment,
    farm: &ConfigFragment,
    root: &Path,
    farm_inputs: &FarmInputs,
    validator: &mut ConfigValidator,
) -> Option<MachineProfile> {
    let mut merged = match farm.to_table().remove("defaults") {
        Some(Value::Table(defaults)) => defaults,
        _ => Table::new(),
    };
    merge_tables(&mut merged, own.to_table());
    let inputs: ProfileInputs = from_table(merged.clone(), &own.file, &mut validator.problems)?;
    if own.was_removed("volume_mm") && inputs.space.volume_mm.is_none() {
        return None; // the problem with its volume was already reported
    }
    let profile = profile_of(name, inputs, root, &farm_inputs.folders, validator);
    Some(MachineProfile { text: text_for_others(merged, &profile), ..profile })
}

/// The file of a machine for other nodes: its folders are those of its server.
fn text_for_others(mut file: Table, profile: &MachineProfile) -> String {
    let place = |folder: &Path| Value::String(folder.to_string_lossy().into_owned());
    let MachineFolders { inbox, queue, error, archive } = &profile.folders;
    let named = [("inbox", inbox), ("error", error), ("archive", archive)];
    let mut folders: Table = named.into_iter().map(|(name, folder)| (name.to_owned(), place(folder))).collect();
    match file.get_mut("printer") {
        Some(Value::Array(printers)) if !printers.is_empty() => {
            for (printer, rules) in printers.iter_mut().zip(&profile.printers) {
                if let (Value::Table(printer), Some(folder)) = (printer, rules.queue.folder()) {
                    printer.insert("queue".to_owned(), place(folder));
                }
            }
        }
        _ => drop(folders.insert("queue".to_owned(), place(queue))),
    }
    file.insert("folders".to_owned(), Value::Table(folders));
    file.to_string()
}

fn profile_of(
    name: &str,
    inputs: ProfileInputs,
    root: &Path,
    farm: &FarmFolders,
    validator: &mut ConfigValidator,
) -> MachineProfile {
    let mut folders = folders::machine_folders(root, farm, &inputs.folders, name);
    let queue = (root, farm.queue.as_path(), folders.queue.as_path());
    let printers = printer_validation::validate_printers(name, &inputs, queue, validator);
    folders.queue = printers.first().and_then(|first| Some(first.queue.folder()?.to_owned())).unwrap_or_default();
    validation_rules::validate_profile(name, inputs, folders, printers, validator)
}

/// A machine of another node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OtherMachine {
    /// Its name.
    pub name: String,
    /// The node that serves it.
    pub node: String,
    /// Its file with the defaults of its farm, in TOML.
    pub text: String,
}

impl Settings {
    /// The settings with the machines of other nodes as these say them. What this version does not understand is left out. Their folders are
    /// those on their servers.
    pub fn with_machines_of_others(&self, machines: &[OtherMachine]) -> Self {
        let mut all = self.clone();
        for OtherMachine { name, node, text } in machines {
            let inputs = text.parse::<Table>().ok().and_then(|table| ProfileInputs::deserialize(table).ok());
            let (Some(inputs), false) = (inputs, text.is_empty()) else { continue };
            let mut unused = ConfigValidator::new(Vec::new());
            let mut profile = profile_of(name, inputs, &self.root, &FarmInputs::default().folders, &mut unused);
            profile.time_zone = self.time_zone.clone();
            printer_validation::name_loaded(&mut profile, &self.materials, &mut unused);
            (profile.text, profile.of_node) = (text.clone(), node.clone());
            all.profiles.insert(name.clone(), profile);
        }
        all
    }
}

/// Merges `over` into `base`, table by table. Values of `over` take precedence.
fn merge_tables(base: &mut Table, over: Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => merge_tables(below, above),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// The fragments were already parsed as `T`, so no error is expected here. If there is one, it is reported instead of
/// causing a panic.
fn from_table<T: DeserializeOwned>(table: Table, file: &Path, problems: &mut Vec<ConfigProblem>) -> Option<T> {
    T::deserialize(table)
        .map_err(|error| {
            problems.push(ConfigProblem {
                file: file.to_owned(),
                line: None,
                text: format!("does not fit together with the farm's defaults: {}", error.message()),
                remedy: "correct the value here or in [defaults]".into(),
            });
        })
        .ok()
}

/// The folders of a machine, each with where `own_file` or the farm's file names it.
fn folder_claims(profile: &MachineProfile, own_file: &Path, validator: &ConfigValidator) -> Vec<FolderClaim> {
    let MachineFolders { inbox, queue: _, error, archive } = &profile.folders;
    let claim = |folder: &Path, description: String, key: &str| {
        let (file, line) = validator.locate_key(key);
        let is_named = line.is_some() && file == own_file && !key.ends_with(".name");
        FolderClaim { folder: folder.to_owned(), description, location: (file, line), is_named }
    };
    let name = &profile.name;
    let queue = |(at, printer): (usize, &PrinterRules)| {
        let folder = printer.queue.folder()?;
        let (description, usual) = match printer.name == *name {
            true => (format!("the queue folder of {name}"), "folders.queue".to_owned()),
            false => (format!("the queue folder of the printer {}", printer.name), format!("printer.{at}.name")),
        };
        let exact = format!("printer.{at}.queue");
        let key = if validator.locate_key(&exact).1.is_some() { exact } else { usual };
        Some(claim(folder, description, &key))
    };
    let others = [
        claim(inbox, format!("the inbox of {name}"), "folders.inbox"),
        claim(error, format!("the error folder of {name}"), "folders.error"),
        claim(archive, format!("the archive of {name}"), "folders.archive"),
    ];
    others.into_iter().chain(profile.printers.iter().enumerate().filter_map(queue)).collect()
}
