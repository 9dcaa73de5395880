//! What tests put into a farm's folders and find there. Shared by the farm that a test drives in process and the farm
//! that the real daemon serves.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use solids::{Mesh, Pose};

/// A mesh as the bytes of a binary STL.
pub fn stl(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    build_file::write_stl([(mesh, &Pose::IDENTITY)].into_iter(), &mut bytes).unwrap();
    bytes
}

/// A box of the given size, mm.
pub fn block(x: f64, y: f64, z: f64) -> Mesh {
    sample_parts::cuboid(glam::DVec3::new(x, y, z))
}

/// A part whose final search uses all of its time in the volume of `QUICK`: it has no room to lie as low as it is thick.
pub fn leaning_block() -> Mesh {
    block(130.0, 100.0, 20.0)
}

/// Drops a file as a careful sender does: writes it below `root`, on the same file system, then renames it.
pub fn drop_file(root: &Path, target: &Path, bytes: &[u8]) {
    fs::create_dir_all(target.parent().unwrap()).unwrap();
    let outside = root.join("sending");
    fs::write(&outside, bytes).unwrap();
    fs::rename(outside, target).unwrap();
}

/// The published build files in a queue folder.
pub fn list_build_files(queue: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(queue) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    files.retain(|f| {
        let name = f.file_name().unwrap().to_string_lossy();
        build_file::build_file_stem(&name).is_some() && !name.starts_with('.')
    });
    files.sort();
    files
}

/// Asserts that no copy is in two build files, and that at least `built` copies are in them.
pub fn assert_each_copy_once(files: &[PathBuf], built: usize) {
    let mut seen = BTreeMap::new();
    for file in files {
        for placed in build_file::read_build(file, &build_file::ReadLimits::default()).unwrap() {
            let key = (placed.part_number.unwrap(), placed.copy.unwrap());
            if let Some(other) = seen.insert(key.clone(), file) {
                panic!("copy {key:?} is in {} and in {}", other.display(), file.display());
            }
        }
    }
    assert!(seen.len() >= built, "{built} copies are built, but only {} are in the queue", seen.len());
}
