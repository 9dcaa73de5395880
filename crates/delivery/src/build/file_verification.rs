//! Checks a build file on its own, whichever program wrote it.

use std::path::Path;

use build_file::{BuildMetadata, PlacedMesh, ReadLimits};
use nester::{OrientationLimits, OrientationRule, PlacedSolid, TiltLimit};
use serde_json::Value;

use super::{MachineSpec, PlacementVerification};

/// All results of checking a build file.
#[derive(Debug)]
pub struct BuildFileVerification {
    /// Its placements in the build volume's frame.
    pub bodies: Vec<PlacedSolid>,
    /// The checks of its placements.
    pub placement_checks: PlacementVerification,
    /// Placements that violate the orientation rule stored with them.
    pub wrongly_turned: Vec<usize>,
    /// The difference that the second reader reports; `None` = it agrees.
    pub second_reader_error: Option<String>,
}

impl BuildFileVerification {
    /// Checks a file that was read, for a machine.
    pub fn verify_file(
        file: &Path,
        info: &BuildMetadata,
        placed: &[PlacedMesh],
        machine: &MachineSpec,
        limits: &ReadLimits,
    ) -> Self {
        let second_reader = second_reader_error(file, info, placed, limits);
        let turned = (0..placed.len()).filter(|&i| !obeys_orientation(&placed[i])).collect();
        let body =
            |item: &PlacedMesh| machine.placed_body(item_label(item), item.mesh.clone(), &item.pose, item.clearance_mm);
        let bodies: Vec<PlacedSolid> = placed.iter().map(body).collect();
        let checks = machine.verify_placements(&bodies);
        Self { bodies, placement_checks: checks, wrongly_turned: turned, second_reader_error: second_reader }
    }

    /// Whether all checks passed.
    pub fn is_proved(&self) -> bool {
        self.placement_checks.is_proved() && self.wrongly_turned.is_empty() && self.second_reader_error.is_none()
    }

    /// The faults, one line each.
    pub fn fault_messages(&self) -> Vec<String> {
        let name = |i: usize| format!("{} (item {})", self.bodies[i].name, i + 1);
        let mut faults = self.placement_checks.placement_faults(name);
        faults.extend(
            self.placement_checks.locked_bodies().iter().map(|&i| format!("{} is locked into others", name(i))),
        );
        faults
            .extend(self.wrongly_turned.iter().map(|&i| format!("{} is turned against its orientation rule", name(i))));
        faults.extend(self.placement_checks.layer_fault());
        faults.extend(self.second_reader_error.clone());
        faults
    }
}

/// The second reader is asked only for models of nestd: it does not support everything that other packers write.
fn second_reader_error(
    file: &Path,
    info: &BuildMetadata,
    placed: &[PlacedMesh],
    limits: &ReadLimits,
) -> Option<String> {
    info.heading.application.as_ref().filter(|application| application.starts_with("nestd"))?;
    build_file::is_model_package(file, limits).then_some(())?;
    build_file::cross_check(file, placed, limits).err().map(|error| error.to_string())
}

fn obeys_orientation(item: &PlacedMesh) -> bool {
    let word = item.orientation.as_deref().unwrap_or("free");
    let rule = serde_json::from_value::<OrientationRule>(Value::String(word.to_owned()));
    let tilts = TiltLimit::parse_list(item.tilts.as_deref().unwrap_or_default());
    // An unknown rule counts as violated.
    let (Ok(rule), Ok(tilts)) = (rule, tilts) else { return false };
    nester::obeys_orientation(&OrientationLimits { rule, tilts }, &item.pose)
}

fn item_label(item: &PlacedMesh) -> String {
    match item.copy {
        Some(copy) => format!("{} #{copy}", item.name),
        None => item.name.clone(),
    }
}
