//! Finds and reads a configuration: files -> fragments -> inputs -> settings.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use serde::de::DeserializeOwned;
use thiserror::Error;
use toml::{Table, Value};

use super::{
    Folders, Logging, Problem, Profile, Settings,
    clash::{self, Claim},
    folders,
    fragment::{Fragment, read_text},
    inputs::{FarmInputs, ProfileInputs},
    judge::Judge,
    validate,
};

/// Where a configuration is looked for when none is named.
const DEFAULT_FILES: [&str; 2] = ["config/nestd.toml", "/etc/nestd/nestd.toml"];
/// The folder of the machine files, beside the farm file.
const PROFILES: &str = "profiles";

/// Why there are no settings.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// No file was named and none stands in the default places, or the named one is not there.
    #[error("no configuration: {}; name one with -c FILE, or take a copy of nestd's config folder", not_there(.looked))]
    NotFound {
        /// Where it was looked for.
        looked: Vec<PathBuf>,
    },
    /// The configuration is wrong; every problem that could be found at once.
    #[error("the configuration is wrong:\n{}", .0.iter().map(|p| format!("  {p}")).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Problem>),
}

fn not_there(looked: &[PathBuf]) -> String {
    let names: Vec<String> = looked.iter().map(|file| file.display().to_string()).collect();
    match names.as_slice() {
        [one] => format!("{one} is not there"),
        several => format!("neither {} is there", several.join(" nor ")),
    }
}

/// Reads `config`, else `config/nestd.toml`, else `/etc/nestd/nestd.toml`, and the machine files in `profiles/` beside it;
/// `root` moves all folders of the farm but those that the configuration names by an absolute path.
///
/// # Errors
/// When there is no configuration, or with everything that is wrong with it.
pub fn load(config: Option<&Path>, root: Option<&Path>) -> Result<Settings, SettingsError> {
    let file = find(config)?;
    let mut problems = Vec::new();
    let settings = read(&file, root, &mut problems);
    match settings {
        Some(settings) if problems.is_empty() => Ok(settings),
        _ => Err(SettingsError::Invalid(problems)),
    }
}

/// As [`load`] for those who only ask the ledger: when the machine files are wrong, but the farm file says for certain where
/// the farm is, the settings are those of the other machines, together with all that is wrong.
///
/// # Errors
/// When there is no configuration, or when it does not say where the farm is.
pub fn load_to_look(config: Option<&Path>, root: Option<&Path>) -> Result<(Settings, Vec<Problem>), SettingsError> {
    let file = find(config)?;
    let mut problems = Vec::new();
    match read(&file, root, &mut problems) {
        Some(settings) if problems.iter().all(|problem| problem.file != file) => Ok((settings, problems)),
        _ => Err(SettingsError::Invalid(problems)),
    }
}

fn find(config: Option<&Path>) -> Result<PathBuf, SettingsError> {
    let candidates = match config {
        Some(file) => vec![file.to_owned()],
        None => DEFAULT_FILES.map(PathBuf::from).to_vec(),
    };
    match candidates.iter().find(|file| file.exists()) {
        Some(file) => Ok(file.clone()),
        None => Err(SettingsError::NotFound { looked: candidates }),
    }
}

/// All stages. `None` when the farm file is of no use.
fn read(file: &Path, root: Option<&Path>, problems: &mut Vec<Problem>) -> Option<Settings> {
    let farm_text = read_text(file, problems);
    let machine_texts = machine_texts(file, problems);
    let machines: Vec<(&str, Option<Fragment>)> = (machine_texts.iter())
        .map(|(name, file, text)| (name.as_str(), Fragment::parse::<ProfileInputs>(file, text, problems)))
        .collect();
    let farm_text = farm_text?;
    let farm = Fragment::parse::<FarmInputs>(file, &farm_text, problems)?;
    let inputs: FarmInputs = from_table(farm.values(), file, problems)?;
    let mut judge = Judge::new(vec![(&farm, "")]);
    validate::farm(&inputs, &mut judge);
    let files = validate::files(&inputs.files, &mut judge);
    let web = super::web::web(&inputs.web, &mut judge);
    let metrics = super::metrics::metrics(&inputs.metrics, &mut judge);
    let notify = super::notify::notify(&inputs.notify, &mut judge);
    let root = folders::root(&inputs, root);
    let state_dir = folders::below(&root, &inputs.folders.state);
    let state =
        Claim { folder: state_dir.clone(), what: "the state directory".into(), place: judge.place("folders.state") };
    problems.append(&mut judge.problems);
    let mut judge = Judge::new(vec![(&farm, "defaults.")]);
    validate::defaults(&inputs.defaults, &mut judge);
    problems.append(&mut judge.problems);

    let mut profiles = BTreeMap::new();
    let mut claims = Vec::new();
    for (name, own) in machines {
        let Some(own) = own else { continue };
        let judge = &mut Judge::new(vec![(&own, ""), (&farm, "defaults."), (&farm, "")]);
        let profile = machine(name, &own, &farm, &root, &inputs, judge);
        if let Some(profile) = profile {
            claims.extend(folder_claims(name, &profile.folders, judge));
            profiles.insert(name.to_owned(), profile);
        }
        // A wrong default is wrong in every profile, but is told once.
        judge.problems.retain(|problem| !problems.contains(problem));
        problems.append(&mut judge.problems);
    }
    problems.extend(clash::objections(&claims, &state));
    let log = Logging { filter: inputs.log.filter, format: inputs.log.format };
    Some(Settings {
        file: file.to_owned(),
        ledger: folders::below(&state_dir, &inputs.folders.ledger),
        inbox_base: folders::below(&root, &inputs.folders.inbox),
        root,
        state_dir,
        scan_secs: inputs.scan_secs.0,
        orphan_ticket_secs: inputs.orphan_ticket_secs.0,
        threads: inputs.threads,
        cache_bytes: inputs.cache_bytes,
        limits: inputs.limits,
        files,
        log,
        web,
        metrics,
        notify,
        profiles,
    })
}

/// Name, file and text of every machine file, by name.
fn machine_texts(farm_file: &Path, problems: &mut Vec<Problem>) -> Vec<(String, PathBuf, String)> {
    let folder = farm_file.parent().unwrap_or(Path::new("")).join(PROFILES);
    let mut files: Vec<PathBuf> = match fs::read_dir(&folder) {
        Ok(entries) => {
            entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| is_machine_file(path)).collect()
        }
        Err(_) => Vec::new(),
    };
    files.sort();
    if files.is_empty() {
        problems.push(Problem {
            file: folder,
            line: None,
            text: "there is no machine profile".into(),
            remedy: "put one file per machine here, as in profiles/mjf-5200.toml; its name is the profile's name"
                .into(),
        });
    }
    let named = |file: PathBuf| {
        let text = read_text(&file, problems)?;
        Some((file.file_stem()?.to_string_lossy().into_owned(), file, text))
    };
    files.into_iter().filter_map(named).collect()
}

fn is_machine_file(path: &Path) -> bool {
    let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    !hidden && path.extension().is_some_and(|extension| extension == "toml")
}

/// Merges a machine file over the farm's defaults and checks the result.
fn machine(
    name: &str,
    own: &Fragment,
    farm: &Fragment,
    root: &Path,
    farm_inputs: &FarmInputs,
    judge: &mut Judge,
) -> Option<Profile> {
    let mut merged = match farm.values().remove("defaults") {
        Some(Value::Table(defaults)) => defaults,
        _ => Table::new(),
    };
    merge(&mut merged, own.values());
    let inputs: ProfileInputs = from_table(merged, &own.file, &mut judge.problems)?;
    let folders = folders::of_profile(root, &farm_inputs.folders, &inputs.folders, name);
    if own.was_taken_out("volume_mm") && inputs.volume_mm.is_none() {
        return None; // its volume has been complained of already
    }
    Some(validate::profile(name, inputs, folders, judge))
}

/// Lays `over` over `base`, table by table.
fn merge(base: &mut Table, over: Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => merge(below, above),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// Fragments were read as `T` before, so that this finds nothing new; if it does, it says so instead of panicking.
fn from_table<T: DeserializeOwned>(table: Table, file: &Path, problems: &mut Vec<Problem>) -> Option<T> {
    T::deserialize(table)
        .map_err(|error| {
            problems.push(Problem {
                file: file.to_owned(),
                line: None,
                text: format!("does not fit together with the farm's defaults: {}", error.message()),
                remedy: "correct the value here or in [defaults]".into(),
            });
        })
        .ok()
}

fn folder_claims(name: &str, folders: &Folders, judge: &Judge) -> Vec<Claim> {
    let Folders { inbox, queue, error, archive } = folders;
    [
        ("inbox", "inbox", inbox),
        ("queue folder", "queue", queue),
        ("error folder", "error", error),
        ("archive", "archive", archive),
    ]
    .map(|(what, key, folder)| Claim {
        folder: folder.clone(),
        what: format!("the {what} of {name}"),
        place: judge.place(&format!("folders.{key}")),
    })
    .into()
}
