//! `nestd init` and `nestd machine new`: write the files of a farm and of a machine. Nothing is overwritten.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;
use glam::DVec3;
use settings::{find_config_file, is_machine_name};

use super::check::volume_doubt;
use crate::cli::{
    CommandExit, CommonArgs, UsageError,
    terminal::{
        farm_context::load_settings,
        table::{print_text, print_to_stderr},
        values::{parse_distance, parse_volume},
    },
};

/// The farm file that is shipped; it documents every option.
const FARM_FILE: &str = include_str!("../../../config/nestd.toml");
/// The line of it that names the root.
const ROOT_LINE: &str = "root = \"./farm\"";
/// Models whose files are shipped.
const MODELS: [(&str, &str); 3] = [
    ("fuse-1", include_str!("../../../config/profiles/fuse-1.toml")),
    ("mjf-5200", include_str!("../../../config/profiles/mjf-5200.toml")),
    ("p396", include_str!("../../../config/profiles/p396.toml")),
];

/// Arguments of `nestd init`.
#[derive(Debug, clap::Args)]
pub struct InitArgs {
    /// Folder of the farm; it is made if it is not there
    #[arg(default_value = ".")]
    dir: PathBuf,
}

/// Arguments of `nestd machine new`.
#[derive(Debug, clap::Args)]
pub struct MachineArgs {
    /// Name of the machine; its hot folder has it, too
    name: String,
    /// Begin with the values of a model that nestd knows
    #[arg(long, value_name = "MODEL", value_parser = PossibleValuesParser::new(MODELS.map(|(name, _)| name)), required_unless_present = "volume")]
    model: Option<String>,
    /// Build volume, mm
    #[arg(long, value_name = "XxYxZ", value_parser = parse_volume)]
    volume: Option<DVec3>,
    /// Least distance between two parts, mm
    #[arg(long, value_name = "MM", value_parser = parse_distance)]
    clearance: Option<f64>,
    /// Layer thickness, mm
    #[arg(long, value_name = "MM", value_parser = parse_distance)]
    layer: Option<f64>,
}

/// Writes a farm's configuration.
pub fn run_init(args: &InitArgs) -> Result<CommandExit> {
    let dir = std::path::absolute(&args.dir).context("finding the folder")?;
    let profiles = dir.join("config/profiles");
    fs::create_dir_all(&profiles).with_context(|| format!("making {}", profiles.display()))?;
    let file = dir.join("config/nestd.toml");
    let root = toml::Value::String(dir.to_string_lossy().into_owned());
    if !FARM_FILE.contains(ROOT_LINE) {
        bail!("the shipped farm file has no line {ROOT_LINE}");
    }
    write_new(&file, &FARM_FILE.replacen(ROOT_LINE, &format!("root = {root}"), 1))?;
    let config = file.display();
    print_text(&format!(
        "{config} is written: every option with its default.\n\nNext:\n  \
         nestd -c {config} machine new NAME --model mjf-5200    (or --volume 380x284x380; see --help)\n  \
         nestd -c {config} check\n  nestd -c {config} run\n"
    ))?;
    Ok(CommandExit::Success)
}

/// Writes the file of a machine beside the farm's configuration.
pub fn run_machine(common: &CommonArgs, args: &MachineArgs) -> Result<CommandExit> {
    if !is_machine_name(&args.name) {
        let text = format!("'{}' is no name of a machine: 1 to 40 of a-z, 0-9 and -, for example mjf-2", args.name);
        return Err(UsageError(text).into());
    }
    // A farm without any machine cannot be loaded yet.
    let farm_file = find_config_file(common.config.as_deref()).map_err(|error| UsageError(error.to_string()))?;
    let folder = farm_file.parent().unwrap_or(Path::new(".")).join("profiles");
    fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
    let file = folder.join(format!("{}.toml", args.name));
    write_new(&file, &machine_text(args))?;
    // What is wrong with it is said now, and no wrong file stays.
    if let Err(error) = load_settings(common) {
        let _ = fs::remove_file(&file);
        return Err(error);
    }
    if let Some(doubt) = args.volume.and_then(volume_doubt) {
        print_to_stderr(&format!("warning: {doubt}"));
    }
    print_text(&format!(
        "{} is written. A running daemon reads it on SIGHUP (systemctl reload nestd).",
        file.display()
    ))?;
    Ok(CommandExit::Success)
}

/// The file of a machine: that of its model, with the values that are given instead of the model's.
fn machine_text(args: &MachineArgs) -> String {
    let model = args.model.as_deref().and_then(|model| MODELS.iter().find(|(name, _)| *name == model));
    let mut lines: Vec<String> =
        model.map(|(_, text)| text.lines().map(ToOwned::to_owned).collect()).unwrap_or_default();
    let numbers = |size: DVec3| format!("[{}, {}, {}]", size.x, size.y, size.z);
    let given = [
        ("volume_mm", args.volume.map(numbers)),
        ("clearance_mm", args.clearance.map(|mm| mm.to_string())),
        ("layer_mm", args.layer.map(|mm| mm.to_string())),
    ];
    for (key, value) in given.into_iter().filter_map(|(key, value)| Some((key, value?))) {
        lines.retain(|line| line.split('=').next().map(str::trim) != Some(key));
        lines.push(format!("{key} = {value}"));
    }
    lines.join("\n") + "\n"
}

/// Writes a file that is not there yet.
fn write_new(file: &Path, text: &str) -> Result<()> {
    let made = fs::OpenOptions::new().write(true).create_new(true).open(file);
    match made {
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
            Err(UsageError(format!("{} is there already; nothing was written", file.display())).into())
        }
        made => made
            .and_then(|mut made| made.write_all(text.as_bytes()).and_then(|()| made.sync_all()))
            .with_context(|| format!("writing {}", file.display())),
    }
}
