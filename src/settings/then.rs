//! The profile that a build was made with: machines are changed and sold, and their builds stay to be looked at.

use build_file::Unit;
use glam::DVec3;
use serde::Deserialize;

use super::{BuildSpace, Folders, Profile, inputs::ProfileInputs, judge::Judge, validate};

/// What is taken from the profile as it was; what an older version did not write down is not there.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Then {
    folders: Option<Folders>,
    volume_mm: Option<DVec3>,
    wall_margin_mm: Option<f64>,
    floor_margin_mm: Option<f64>,
    lid_margin_mm: Option<f64>,
    layer_mm: Option<f64>,
    unit: Option<Unit>,
}

impl Profile {
    /// The profile as it was when a build was made: volume, margins, layer and unit are those of `snapshot` (JSON), everything
    /// else that of `now`. Of a machine that is not configured any more the folders are those of then too; without a snapshot
    /// nothing is known of it, and its volume is nothing.
    pub fn then(name: &str, snapshot: Option<&str>, now: Option<&Self>) -> Self {
        let then: Then = snapshot.and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default();
        let mut profile = match now {
            Some(now) => now.clone(),
            None => Self { folders: then.folders.unwrap_or_default(), ..Self::unknown(name) },
        };
        profile.space.volume_mm = then.volume_mm.unwrap_or(profile.space.volume_mm);
        profile.space.wall_margin_mm = then.wall_margin_mm.unwrap_or(profile.space.wall_margin_mm);
        profile.space.floor_margin_mm = then.floor_margin_mm.unwrap_or(profile.space.floor_margin_mm);
        profile.space.lid_margin_mm = then.lid_margin_mm.unwrap_or(profile.space.lid_margin_mm);
        profile.space.layer_mm = then.layer_mm.unwrap_or(profile.space.layer_mm);
        profile.intake.unit = then.unit.unwrap_or(profile.intake.unit);
        profile
    }

    /// A profile of which nothing but its name is known.
    fn unknown(name: &str) -> Self {
        let mut nobody = Judge::new(Vec::new());
        let bare = validate::profile(name, ProfileInputs::default(), Folders::default(), &mut nobody);
        Self { space: BuildSpace { volume_mm: DVec3::ZERO, ..bare.space }, ..bare }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_keeps_the_volume_and_the_layer_that_it_was_made_with() {
        let mut was = Profile::unknown("m");
        (was.space.volume_mm, was.space.layer_mm) = (DVec3::new(200.0, 160.0, 220.0), 0.08);
        was.folders = Folders { archive: "/farm/archive/m".into(), ..Folders::default() };
        let snapshot = serde_json::to_string(&was).unwrap();
        let sold = Profile::then("m", Some(&snapshot), None);
        assert_eq!(sold, was);
        let mut now = Profile::unknown("m");
        (now.space.volume_mm, now.space.layer_mm, now.output.archive_days) = (DVec3::splat(300.0), 0.1, 7);
        let changed = Profile::then("m", Some(&snapshot), Some(&now));
        assert_eq!(
            (changed.space.volume_mm, changed.space.layer_mm, changed.output.archive_days),
            (was.space.volume_mm, 0.08, 7)
        );
        assert_eq!(changed.folders, now.folders, "folders that were moved are looked for where they are");
        for nothing in [None, Some("{}"), Some("torn")] {
            assert_eq!(Profile::then("m", nothing, Some(&now)), now);
            assert_eq!(Profile::then("m", nothing, None).space.volume_mm, DVec3::ZERO);
        }
    }
}
