//! What a printer does: takes build files out of the queue folder.

use std::{collections::BTreeSet, fs};

use build_file::PlacedMesh;

use crate::support::TestFarm;

/// The build files that a printer took.
#[derive(Debug, Default)]
pub struct ScriptedPrinter {
    /// Their names.
    pub taken: BTreeSet<String>,
}

impl ScriptedPrinter {
    /// Reads and removes every build file in the queue; returns name and copies of each. A file that cannot be read, and
    /// a name that appears again, are violations.
    pub fn take_builds(&mut self, farm: &TestFarm, broken: &mut Vec<String>) -> Vec<(String, Vec<PlacedMesh>)> {
        let mut builds = Vec::new();
        for file in farm.queued() {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            let copies = build_file::read_build(&file, &Default::default()).unwrap_or_else(|error| {
                broken.push(format!("I3: {name} is visible and cannot be read: {error}"));
                Vec::new()
            });
            fs::remove_file(&file).unwrap();
            if !self.taken.insert(name.clone()) {
                broken.push(format!("I3: {name} appeared in the queue again after the printer had taken it"));
            }
            builds.push((name, copies));
        }
        builds
    }
}
