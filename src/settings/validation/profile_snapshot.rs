//! Restores the machine profile that a build was made with. Machines are changed and sold, but their builds must remain
//! viewable.

use std::path::Path;

use glam::DVec3;
use serde::Deserialize;

use super::{printer_validation, validation_rules};
use crate::settings::{
    BuildSpace, MachineFolders, MachineProfile, machine::profile_inputs::ProfileInputs,
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
    layer_mm: Option<f64>,
}

impl MachineProfile {
    /// Returns the profile at the time of a build: volume, margins and layer come from `snapshot` (JSON),
    /// everything else from `now`. If the machine is not configured any more, the folders come from the snapshot too.
    /// Without a snapshot nothing is known of such a machine, and its volume is zero.
    pub fn from_snapshot(name: &str, snapshot: Option<&str>, now: Option<&Self>) -> Self {
        let stored: ProfileSnapshot = snapshot.and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default();
        let mut profile = match now {
            Some(now) => now.clone(),
            None => Self::with_name_only(name, stored.folders.unwrap_or_default()),
        };
        profile.space.volume_mm = stored.volume_mm.unwrap_or(profile.space.volume_mm);
        profile.space.wall_margin_mm = stored.wall_margin_mm.unwrap_or(profile.space.wall_margin_mm);
        profile.space.floor_margin_mm = stored.floor_margin_mm.unwrap_or(profile.space.floor_margin_mm);
        profile.space.lid_margin_mm = stored.lid_margin_mm.unwrap_or(profile.space.lid_margin_mm);
        profile.space.layer_mm = stored.layer_mm.unwrap_or(profile.space.layer_mm);
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
