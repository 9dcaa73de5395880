//! Restores the machine profile that a build was made with. Machines are changed and sold, but their builds must remain
//! viewable.

use std::path::Path;

use glam::DVec3;
use nester::{InterlockRule, NestingMethod};
use serde::{Deserialize, Deserializer};

use super::{printer_validation, validation_rules};
use crate::{
    BuildSpace, CostRules, KeepOutZone, MachineFolders, MachineProfile, machine::profile_inputs::ProfileInputs,
    reading::validator::ConfigValidator,
};

/// The values used from a stored profile. Values that an older version did not store are `None`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct ProfileSnapshot {
    folders: Option<MachineFolders>,
    volume_mm: Option<DVec3>,
    wall_margin_mm: Option<f64>,
    floor_margin_mm: Option<f64>,
    lid_margin_mm: Option<f64>,
    keep_out: Option<Vec<KeepOutZone>>,
    clearance_mm: Option<f64>,
    clearance_z_extra_mm: Option<f64>,
    layer_mm: Option<f64>,
    /// The inner `None` = it had none.
    #[serde(deserialize_with = "given_or_null")]
    layer_area_cap: Option<Option<f64>>,
    delivery: Option<build_file::DeliveryKind>,
    print_hours_per_mm: Option<f64>,
    costs: Option<CostRules>,
    nest: NestingSnapshot,
}

/// A value that is null is told from one that is left out.
///
/// # Errors
/// It is no such value.
pub fn given_or_null<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Option<Option<T>>, D::Error> {
    Option::deserialize(from).map(Some)
}

/// The rules for locked parts of a stored profile.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct NestingSnapshot {
    method: Option<NestingMethod>,
    interlock: Option<InterlockRule>,
}

impl MachineProfile {
    /// Returns the profile at the time of a build: what its proof and its cost depend on comes from `snapshot` (JSON), everything
    /// else from `now`.
    /// If the machine is not configured any more, the folders come from the snapshot too.
    /// Without a snapshot nothing is known of such a machine, and its volume is zero.
    pub fn from_snapshot(name: &str, snapshot: Option<&str>, now: Option<&Self>) -> Self {
        let stored: ProfileSnapshot = snapshot.and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default();
        let mut profile = match now {
            Some(now) => now.clone(),
            None => Self::with_name_only(name, stored.folders.unwrap_or_default()),
        };
        let (space, nest) = (&mut profile.space, &mut profile.search.nest);
        space.volume_mm = stored.volume_mm.unwrap_or(space.volume_mm);
        space.wall_margin_mm = stored.wall_margin_mm.unwrap_or(space.wall_margin_mm);
        space.floor_margin_mm = stored.floor_margin_mm.unwrap_or(space.floor_margin_mm);
        space.lid_margin_mm = stored.lid_margin_mm.unwrap_or(space.lid_margin_mm);
        space.keep_out = stored.keep_out.unwrap_or_else(|| std::mem::take(&mut space.keep_out));
        space.clearance_mm = stored.clearance_mm.unwrap_or(space.clearance_mm);
        space.clearance_z_extra_mm = stored.clearance_z_extra_mm.unwrap_or(space.clearance_z_extra_mm);
        space.layer_mm = stored.layer_mm.unwrap_or(space.layer_mm);
        space.layer_area_cap = stored.layer_area_cap.unwrap_or(space.layer_area_cap);
        space.print_hours_per_mm = stored.print_hours_per_mm.unwrap_or(space.print_hours_per_mm);
        profile.costs = stored.costs.unwrap_or(profile.costs);
        profile.output.delivery = stored.delivery.unwrap_or(profile.output.delivery);
        nest.method = stored.nest.method.unwrap_or(nest.method);
        nest.interlock = stored.nest.interlock.unwrap_or(nest.interlock);
        profile
    }

    /// Creates a profile of which only the name is known.
    fn with_name_only(name: &str, folders: MachineFolders) -> Self {
        let mut unused = ConfigValidator::new(Vec::new());
        let inputs = ProfileInputs::default();
        let no_farm = (Path::new(""), Path::new(""), folders.queue.as_path());
        let printers = printer_validation::validate_printers(name, &inputs, no_farm, &mut unused);
        let bare = validation_rules::validate_profile(name, inputs, folders, printers, &mut unused);
        Self { space: BuildSpace { volume_mm: DVec3::ZERO, ..bare.space }, ..bare }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_keeps_the_volume_and_the_layer_that_it_was_made_with() {
        let mut was = MachineProfile::with_name_only("m", MachineFolders::default());
        (was.space.volume_mm, was.space.layer_mm) = (DVec3::new(200.0, 160.0, 220.0), 0.08);
        was.folders = MachineFolders { archive: "/farm/archive/m".into(), ..MachineFolders::default() };
        let snapshot = serde_json::to_string(&was).unwrap();
        let sold = MachineProfile::from_snapshot("m", Some(&snapshot), None);
        assert_eq!(sold, was);
        let mut now = MachineProfile::with_name_only("m", MachineFolders::default());
        (now.space.volume_mm, now.space.layer_mm, now.output.archive_days) = (DVec3::splat(300.0), 0.1, 7);
        let changed = MachineProfile::from_snapshot("m", Some(&snapshot), Some(&now));
        assert_eq!(
            (changed.space.volume_mm, changed.space.layer_mm, changed.output.archive_days),
            (was.space.volume_mm, 0.08, 7)
        );
        assert_eq!(changed.folders, now.folders, "folders that were moved are looked for where they are");
        for nothing in [None, Some("{}"), Some("torn")] {
            assert_eq!(MachineProfile::from_snapshot("m", nothing, Some(&now)), now);
            assert_eq!(MachineProfile::from_snapshot("m", nothing, None).space.volume_mm, DVec3::ZERO);
        }
    }
}
