//! What can be said of a build file by itself, whoever wrote it.

use std::path::Path;

use build_file::{BuildInfo, Limits, PlacedMesh};
use nester::{Body, Orientation, OrientationRule, Tilt};
use serde_json::Value;

use super::{Judgement, Machine};

/// Everything that was found out about a build file.
#[derive(Debug)]
pub struct Verdict {
    /// Its placements in the build volume's frame.
    pub bodies: Vec<Body>,
    /// What the judge says of them.
    pub judgement: Judgement,
    /// Placements turned against the rule that they were placed under.
    pub turned: Vec<usize>,
    /// What a second reader says against our own reading.
    pub second_reader: Option<String>,
}

impl Verdict {
    /// Judges a file that was read, on a machine.
    pub fn of(file: &Path, info: &BuildInfo, placed: &[PlacedMesh], machine: &Machine, limits: &Limits) -> Self {
        let second_reader = second_opinion(file, info, placed, limits);
        let turned = (0..placed.len()).filter(|&i| !obeys(&placed[i])).collect();
        let body = |item: &PlacedMesh| machine.body(named(item), item.mesh.clone(), &item.pose, item.clearance_mm);
        let bodies: Vec<Body> = placed.iter().map(body).collect();
        let judgement = machine.judge(&bodies);
        Self { bodies, judgement, turned, second_reader }
    }

    /// Whether nothing was found.
    pub fn is_proved(&self) -> bool {
        self.judgement.is_proved() && self.turned.is_empty() && self.second_reader.is_none()
    }

    /// The faults, a line each.
    pub fn faults(&self) -> Vec<String> {
        let name = |i: usize| format!("{} (item {})", self.bodies[i].name, i + 1);
        let mut faults = self.judgement.placement_faults(name);
        faults.extend(self.judgement.locked().iter().map(|&i| format!("{} is locked into others", name(i))));
        faults.extend(self.turned.iter().map(|&i| format!("{} is turned against its orientation rule", name(i))));
        faults.extend(self.judgement.layer_fault());
        faults.extend(self.second_reader.clone());
        faults
    }
}

/// Only for our own files: the other reader does not know everything that other packers write.
fn second_opinion(file: &Path, info: &BuildInfo, placed: &[PlacedMesh], limits: &Limits) -> Option<String> {
    info.application.as_ref().filter(|application| application.starts_with("nestd"))?;
    build_file::cross_check(file, placed, limits).err().map(|error| error.to_string())
}

fn obeys(item: &PlacedMesh) -> bool {
    let word = item.orientation.as_deref().unwrap_or("free");
    let rule = serde_json::from_value::<OrientationRule>(Value::String(word.to_owned()));
    let tilts = Tilt::parse_list(item.tilts.as_deref().unwrap_or_default());
    // A rule that is not understood is not obeyed.
    let (Ok(rule), Ok(tilts)) = (rule, tilts) else { return false };
    nester::rotation_obeys(&Orientation { rule, tilts }, &item.pose)
}

fn named(item: &PlacedMesh) -> String {
    match item.copy {
        Some(copy) => format!("{} #{copy}", item.name),
        None => item.name.clone(),
    }
}
