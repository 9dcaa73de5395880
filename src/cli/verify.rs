//! `nestd verify`: reads a build file back and proves it on its triangles, whoever wrote it.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::Result;
use glam::DVec3;
use serde_json::{Value, json};

use super::{
    Common, Exit, Usage, asked,
    values::{distance, margins, volume, word},
};
use crate::{
    format::{self, BuildInfo, Limits, PlacedMesh},
    geometry::{Bounds, Pose},
    nest::{
        self, Body, DEFAULT_LAYER_MM, Interlock, LayerAreas, LayerCap, Margins, Orientation, OrientationRule, Proof,
        TakenApart, Tilt,
    },
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit code 0 proved, 1 not proved, 2 wrong use or not readable.")]
pub struct Args {
    /// The build file
    #[arg(value_name = "BUILD.3mf")]
    build: PathBuf,
    /// Build volume in mm, e.g. 380x284x380 [default: what the file says]
    #[arg(long, value_name = "XxYxZ", value_parser = volume)]
    volume: Option<DVec3>,
    /// Least distance between two parts, mm [default: what the file says]
    #[arg(long, value_name = "MM", value_parser = distance)]
    clearance: Option<f64>,
    /// Parts locked into each other: forbid (then they are no proof), warn or allow (nobody looks) [default: what the file
    /// says, else warn]
    #[arg(long, value_name = "RULE", value_parser = word::<Interlock>)]
    interlock: Option<Interlock>,
    /// The clearance also holds when either of two parts is raised by up to this, mm [default: what the file says, else 0]
    #[arg(long, value_name = "MM", value_parser = distance)]
    clearance_z_extra: Option<f64>,
    /// Kept free, mm: all around, or at walls, floor and lid [default: what the file says, else 0]
    #[arg(long, value_name = "MM|WALL,FLOOR,LID", value_parser = margins)]
    margins: Option<Margins>,
    /// Parts that must be in it, each as often as asked: CSV with the columns file and copies (or quantity)
    #[arg(long, value_name = "PARTS.csv")]
    list: Option<PathBuf>,
    /// Folder that the list's files are relative to [default: the list's own]
    #[arg(long, value_name = "DIR", requires = "list")]
    base: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Everything that was found out about a build file.
struct Verdict {
    info: BuildInfo,
    volume_mm: DVec3,
    margins: Margins,
    clearance_mm: f64,
    clearance_z_extra_mm: f64,
    bodies: Vec<Body>,
    proof: Proof,
    interlock: Interlock,
    /// How it comes apart; `None` when locked parts are allowed.
    apart: Option<TakenApart>,
    /// Placements turned against the rule that they were placed under.
    turned: Vec<usize>,
    /// What is filled in each layer, where the file has a cap on it.
    layers: Option<LayerAreas>,
    /// What a second reader says against our own reading.
    second_reader: Option<String>,
    /// Asked, but not in the file, or in it but not asked.
    list_faults: Vec<String>,
}

impl Verdict {
    fn is_proved(&self) -> bool {
        let locked = self.interlock == Interlock::Forbid && !self.locked().is_empty();
        self.proof.is_proved()
            && !locked
            && self.layers.as_ref().is_none_or(LayerAreas::keeps_cap)
            && self.turned.is_empty()
            && self.second_reader.is_none()
            && self.list_faults.is_empty()
    }

    /// Bodies that cannot be drawn out.
    fn locked(&self) -> &[usize] {
        self.apart.as_ref().map_or(&[], |apart| &apart.locked)
    }
}

/// Runs the command.
pub fn run(_common: &Common, args: &Args) -> Result<Exit> {
    let verdict = verify(args)?;
    let text = match args.json {
        true => format!("{:#}", as_json(&verdict)),
        false => format!("{}: {}", args.build.display(), as_text(&verdict).join("\n  ")),
    };
    // Whoever reads only the first lines (`| head`) still gets the exit code.
    let _ = writeln!(std::io::stdout(), "{text}");
    Ok(if verdict.is_proved() { Exit::Success } else { Exit::Failure })
}

fn verify(args: &Args) -> Result<Verdict> {
    let limits = Limits::default();
    let (info, placed) = format::read_build_and_info(&args.build, &limits)
        .map_err(|error| Usage(format!("{}: {:#}", args.build.display(), anyhow::Error::from(error))))?;
    let missing = |what: &str| Usage(format!("the file does not say its {what}: give --{what}"));
    let volume_mm = args.volume.or(info.volume_mm).ok_or_else(|| missing("volume"))?;
    let clearance_mm = args.clearance.or(info.clearance_mm).ok_or_else(|| missing("clearance"))?;
    let clearance_z_extra_mm = args.clearance_z_extra.or(info.clearance_z_extra_mm).unwrap_or(0.0);
    let margins = args.margins.or(info.margins_mm.map(Margins::from)).unwrap_or_default();
    let second_reader = second_opinion(&args.build, &info, &placed, &limits);
    let list_faults = match &args.list {
        Some(list) => {
            let base = args.base.as_deref().or(list.parent()).unwrap_or(Path::new("."));
            asked::faults(&asked::read_list(list, base, &limits)?, &placed)
        }
        None => Vec::new(),
    };
    let turned = (0..placed.len()).filter(|&i| !obeys(&placed[i])).collect();
    let bodies: Vec<Body> = (placed.into_iter())
        .map(|item| Body {
            clearance_mm: item.clearance_mm.unwrap_or(0.0).max(clearance_mm),
            name: named(&item),
            mesh: item.mesh,
            pose: Pose { translation: item.pose.translation - margins.origin_mm(), ..item.pose },
        })
        .collect();
    let origin_mm = margins.origin_mm();
    let moved = |zone: &Bounds| Bounds { min: zone.min - origin_mm, max: zone.max - origin_mm };
    let keep_out: Vec<Bounds> = info.keep_out.iter().map(moved).collect();
    let mut proof = nest::prove_with(&bodies, margins.room(volume_mm).size_mm, clearance_z_extra_mm, &keep_out);
    proof.height_mm += margins.floor_mm;
    let said = || info.interlock.as_deref().and_then(|said| word(said).ok());
    let interlock = args.interlock.or_else(said).unwrap_or(Interlock::Warn);
    let apart = (interlock != Interlock::Allow).then(|| nest::take_apart(&bodies));
    // What stands outside is told anyway, and layers without end are not counted.
    let cap_mm2 = info.layer_area_cap_mm2.filter(|_| proof.outside.is_empty());
    let layer_mm = info.layer_mm.filter(|mm| (0.001..=10.0).contains(mm)).unwrap_or(DEFAULT_LAYER_MM);
    let layers = cap_mm2.map(|area_mm2| {
        let cap = LayerCap { layer_mm, area_mm2 };
        LayerAreas::of(bodies.iter().map(|b| (&*b.mesh, b.pose)), cap)
    });
    Ok(Verdict {
        info,
        volume_mm,
        margins,
        clearance_mm,
        clearance_z_extra_mm,
        bodies,
        proof,
        interlock,
        apart,
        turned,
        layers,
        second_reader,
        list_faults,
    })
}

/// Only for our own files: the other reader does not know everything that other packers write.
fn second_opinion(file: &Path, info: &BuildInfo, placed: &[PlacedMesh], limits: &Limits) -> Option<String> {
    info.application.as_ref().filter(|application| application.starts_with("nestd"))?;
    format::cross_check(file, placed, limits).err().map(|error| error.to_string())
}

fn obeys(item: &PlacedMesh) -> bool {
    let word = item.orientation.as_deref().unwrap_or("free");
    let rule = serde_json::from_value::<OrientationRule>(Value::String(word.to_owned()));
    let tilts = Tilt::parse_list(item.tilts.as_deref().unwrap_or_default());
    // A rule that is not understood is not obeyed.
    let (Ok(rule), Ok(tilts)) = (rule, tilts) else { return false };
    nest::rotation_obeys(&Orientation { rule, tilts }, &item.pose)
}

fn named(item: &PlacedMesh) -> String {
    match item.copy {
        Some(copy) => format!("{} #{copy}", item.name),
        None => item.name.clone(),
    }
}

/// The faults, a line each.
fn faults(verdict: &Verdict) -> Vec<String> {
    let name = |i: usize| format!("{} (item {})", verdict.bodies[i].name, i + 1);
    let proof = &verdict.proof;
    let close = (proof.too_close.iter()).map(|pair| {
        let (first, second) = (name(pair.first), name(pair.second));
        format!("{first} and {second} are {:.6} mm apart instead of {} mm", pair.distance_mm, pair.wanted_mm)
    });
    let outside =
        proof.outside.iter().map(|&(i, excess)| format!("{} stands {excess:.6} mm out of the volume", name(i)));
    let inside = proof.inside.iter().map(|&(outer, inner)| format!("{} lies inside {}", name(inner), name(outer)));
    let intruding = proof.intruding.iter().map(|&(i, zone)| format!("{} stands in keep-out box {}", name(i), zone + 1));
    let locked = verdict.locked().iter().map(|&i| format!("{} is locked into others", name(i)));
    let turned = verdict.turned.iter().map(|&i| format!("{} is turned against its orientation rule", name(i)));
    close
        .chain(outside)
        .chain(inside)
        .chain(intruding)
        .chain(locked)
        .chain(turned)
        .chain(verdict.layers.iter().filter(|layers| !layers.keeps_cap()).map(LayerAreas::in_words))
        .chain(verdict.second_reader.clone())
        .chain(verdict.list_faults.iter().cloned())
        .collect()
}

fn as_text(verdict: &Verdict) -> Vec<String> {
    let (size, proof) = (verdict.volume_mm, &verdict.proof);
    let mut lines = vec![if verdict.is_proved() { "proved".to_owned() } else { "NOT proved".to_owned() }];
    lines.push(format!("placements      {}", verdict.bodies.len()));
    lines.push(format!("build volume    {} x {} x {} mm", size.x, size.y, size.z));
    if !verdict.info.keep_out.is_empty() {
        lines.push(format!("keep-out boxes  {}", verdict.info.keep_out.len()));
    }
    lines.push(format!("build height    {:.4} mm", proof.height_mm));
    lines.push(match proof.clearance_proved_mm {
        Some(least) => format!("least distance  {least:.6} mm, {} mm asked", verdict.clearance_mm),
        None => format!("least distance  more than twice the {} mm asked", verdict.clearance_mm),
    });
    if verdict.margins != Margins::default() {
        let Margins { wall_mm, floor_mm, lid_mm } = verdict.margins;
        lines.push(format!("kept free       {wall_mm} mm at the walls, {floor_mm} at the floor, {lid_mm} at the lid"));
    }
    if verdict.clearance_z_extra_mm > 0.0 {
        lines.push(format!("raised parts    keep it, too, up to {} mm", verdict.clearance_z_extra_mm));
    }
    let gap_mm = nest::drawing_gap_mm(verdict.clearance_mm);
    lines.push(match verdict.locked().len() {
        _ if verdict.apart.is_none() => "comes apart     not asked".to_owned(),
        0 => format!("comes apart     part by part, {gap_mm} mm kept on the way"),
        locked => format!("comes apart     not, {locked} parts are locked"),
    });
    lines.extend(faults(verdict));
    lines
}

fn as_json(verdict: &Verdict) -> Value {
    let name = |i: usize| json!({ "item": i + 1, "name": verdict.bodies[i].name });
    let proof = &verdict.proof;
    let pairs: Vec<Value> = (proof.too_close.iter())
        .map(|p| {
            json!({ "first": name(p.first), "second": name(p.second), "distance_mm": p.distance_mm, "wanted_mm": p.wanted_mm })
        })
        .collect();
    let outside: Vec<Value> =
        proof.outside.iter().map(|&(i, excess)| json!({ "part": name(i), "excess_mm": excess })).collect();
    let inside: Vec<Value> =
        proof.inside.iter().map(|&(outer, inner)| json!({ "outer": name(outer), "inner": name(inner) })).collect();
    let intruding: Vec<Value> =
        proof.intruding.iter().map(|&(i, zone)| json!({ "part": name(i), "keep_out": zone + 1 })).collect();
    json!({
        "proved": verdict.is_proved(),
        "title": verdict.info.title,
        "application": verdict.info.application,
        "profile": verdict.info.profile,
        "placements": verdict.bodies.len(),
        "volume_mm": verdict.volume_mm.to_array(),
        "height_mm": proof.height_mm,
        "clearance_mm": verdict.clearance_mm,
        "clearance_z_extra_mm": verdict.clearance_z_extra_mm,
        "margins_mm": verdict.margins.as_dvec3().to_array(),
        "least_distance_mm": proof.clearance_proved_mm,
        "too_close": pairs,
        "outside": outside,
        "inside": inside,
        "keep_out": verdict.info.keep_out.len(),
        "intruding": intruding,
        "interlock": verdict.interlock.word(),
        "locked": verdict.apart.as_ref().map(|apart| apart.locked.iter().map(|&i| name(i)).collect::<Vec<_>>()),
        "turned": verdict.turned.iter().map(|&i| name(i)).collect::<Vec<_>>(),
        "layers": verdict.layers,
        "second_reader": verdict.second_reader,
        "list": verdict.list_faults,
    })
}
