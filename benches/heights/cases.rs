//! The workloads: piles of the project's own parts and, if `NESTD_DATA` is set, lists of other people's files.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, Result, bail};
use build_file::{LengthUnit, ReadLimits};
use glam::DVec3;
use nester::{BuildVolume, NestingInstance, NestingItem, OrientationRule};
use sample_parts::{COMPARED_ROOM_MM, ComparedWorkload, SampleWorkload, workload_parts};
use serde::Deserialize;
use solids::Mesh;

/// Numbers of copies of the workloads that show how the search scales.
pub const SCALE: [u32; 6] = [20, 50, 100, 200, 500, 1000];
/// Prefix of the names of listed workloads.
pub const LISTED: &str = "data/";

/// The workload of a name: one of `COMPARED_WORKLOADS`, `small60`, `scale-COPIES`, `first-COPIES-MESHES`, `first-WORKLOAD`
/// or `data/LIST`.
pub fn instance(name: &str) -> Result<NestingInstance> {
    let small = |copies: u32, meshes: u32| SampleWorkload::Small { copies, meshes, seed: 7 };
    if let Some(compared) = ComparedWorkload::named(name.strip_prefix("first-").unwrap_or(name)) {
        return generated(compared.parts, compared.base_mm, compared.clearance_mm);
    }
    match name {
        "small60" => generated(small(60, 30), [100.0, 100.0], 2.0),
        _ => {
            let numbers: Vec<u32> = name.split('-').filter_map(|n| n.parse().ok()).collect();
            match (name.split('-').next(), numbers.as_slice()) {
                (Some("scale"), &[copies]) => generated(small(copies, copies.div_ceil(5)), [200.0, 200.0], 3.0),
                (Some("first"), &[copies, meshes]) => generated(small(copies, meshes), [380.0, 284.0], 3.0),
                _ => match name.strip_prefix(LISTED) {
                    Some(list) => listed(list),
                    None => bail!("there is no workload {name:?}"),
                },
            }
        }
    }
}

/// Base in mm and clearance, for tables.
pub fn machine(instance: &NestingInstance) -> String {
    let size = instance.volume().size_mm;
    format!("{} x {}, {}", size.x, size.y, instance.clearance_mm())
}

/// The different meshes of an instance.
pub fn distinct(instance: &NestingInstance) -> Vec<Arc<Mesh>> {
    let meshes: BTreeMap<usize, Arc<Mesh>> =
        instance.items().iter().map(|item| (Arc::as_ptr(&item.mesh) as usize, item.mesh.clone())).collect();
    meshes.into_values().collect()
}

fn item(name: String, mesh: Arc<Mesh>, copies: u32) -> NestingItem {
    NestingItem { name, mesh, copies, orientation: OrientationRule::Free.into(), clearance_mm: None }
}

fn generated(pile: SampleWorkload, base_mm: [f64; 2], clearance_mm: f64) -> Result<NestingInstance> {
    let parts = workload_parts(pile).into_iter().enumerate();
    let items = parts.map(|(at, (mesh, copies))| item(format!("part {at}"), Arc::new(mesh), copies)).collect();
    let volume = BuildVolume { size_mm: DVec3::new(base_mm[0], base_mm[1], COMPARED_ROOM_MM) };
    Ok(NestingInstance::new(volume, clearance_mm, items)?)
}

/// The settings beside a list of files.
#[derive(Deserialize)]
struct ListSettings {
    volume_mm: [f64; 3],
    clearance_mm: f64,
}

#[derive(Deserialize)]
struct ListRow {
    file: String,
    quantity: u32,
}

fn data_folder() -> Result<PathBuf> {
    Ok(std::env::var_os("NESTD_DATA").context("NESTD_DATA does not say where the lists are")?.into())
}

/// Names of the lists in the data folder.
pub fn lists() -> Result<Vec<String>> {
    let folder = data_folder()?.join("workloads");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(&folder).with_context(|| format!("reading {}", folder.display()))? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "csv") {
            names.extend(path.file_stem().map(|stem| format!("{LISTED}{}", stem.to_string_lossy())));
        }
    }
    names.sort();
    Ok(names)
}

fn listed(list: &str) -> Result<NestingInstance> {
    let folder = data_folder()?;
    let file = |ending: &str| folder.join("workloads").join(format!("{list}.{ending}"));
    let beside: ListSettings = serde_json::from_slice(&std::fs::read(file("json"))?)?;
    let mut known: BTreeMap<[u8; 32], Vec<(Arc<Mesh>, u32)>> = BTreeMap::new();
    let mut items = Vec::new();
    for row in csv::Reader::from_path(file("csv"))?.deserialize() {
        let row: ListRow = row?;
        for (mesh, copies) in solids(&folder.join(&row.file), &row.file, &mut known)? {
            items.push(item(row.file.clone(), mesh, copies * row.quantity));
        }
    }
    let size = DVec3::from_array(beside.volume_mm);
    // As for our own workloads: higher than any build.
    let volume = BuildVolume { size_mm: size.with_z(size.z.max(COMPARED_ROOM_MM)) };
    Ok(NestingInstance::new(volume, beside.clearance_mm, items)?)
}

/// The solids of a file; files with the same content are read once.
fn solids(
    path: &Path,
    name: &str,
    known: &mut BTreeMap<[u8; 32], Vec<(Arc<Mesh>, u32)>>,
) -> Result<Vec<(Arc<Mesh>, u32)>> {
    let hash = *blake3::hash(&std::fs::read(path).with_context(|| format!("reading {}", path.display()))?).as_bytes();
    if let Some(solids) = known.get(&hash) {
        return Ok(solids.clone());
    }
    let contents = build_file::read_part_file(path, name, None, LengthUnit::default(), &ReadLimits::default())?;
    let solids: Vec<_> = contents.solids.into_iter().map(|s| (s.mesh, s.copies)).collect();
    known.insert(hash, solids.clone());
    Ok(solids)
}
