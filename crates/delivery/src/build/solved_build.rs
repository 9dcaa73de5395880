//! A build with a found layout: it becomes a build file and a report.

use std::collections::BTreeSet;

use build_file::{BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, PictureBody, Viewpoint};
use nester::{ClearanceMeasures, NestingReport, PackingMeasures, PlacedPart, SearchCost, SearchSummary, UnplacedPart};
use solids::{Mesh, Pose};

use super::{BuildPart, MachineSpec, PartPlacement};

/// Metadata of a build file besides machine and placements.
#[derive(Debug, Clone)]
pub struct BuildHeading {
    /// Title shown by viewers.
    pub title: String,
    /// Number of the build in the ledger; 0 = none.
    pub build_id: String,
    /// Creation time.
    pub created: jiff::Timestamp,
    /// Seed of the search.
    pub seed: u64,
}

/// Parts on a machine, each copy at its pose.
#[derive(Debug, Clone)]
pub struct SolvedBuild {
    /// Metadata of the file.
    pub heading: BuildHeading,
    /// The machine.
    pub machine: MachineSpec,
    /// Parts. Those without a placed copy are left out of the file.
    pub parts: Vec<BuildPart>,
    /// Placed copies.
    pub placed: Vec<PartPlacement>,
    /// Top of the highest placement above the build volume's floor, mm.
    pub height_mm: f64,
    /// Part volume / (base area x height) in the build volume.
    pub density: f64,
}

impl SolvedBuild {
    /// Top of the highest placement above the machine's floor, mm.
    pub fn machine_height_mm(&self) -> f64 {
        self.height_mm + self.machine.origin_mm().z
    }

    /// The contents of the build file: one object per part, one item per copy, and a picture.
    pub fn to_build_file(&self, thumbnail_size: (u32, u32)) -> BuildFile {
        let build = self.describe();
        BuildFile { thumbnail_png: Some(render_picture(&build, thumbnail_size)), ..build }
    }

    /// The same without a picture.
    pub(super) fn describe(&self) -> BuildFile {
        let machine = &self.machine;
        let used: BTreeSet<usize> = self.placed.iter().map(|p| p.part).collect();
        let used: Vec<usize> = used.into_iter().collect();
        BuildFile {
            heading: BuildFileHeading {
                title: self.heading.title.clone(),
                application: format!("nestd {}", env!("CARGO_PKG_VERSION")),
                created: self.heading.created.strftime("%Y-%m-%dT%H:%M:%SZ").to_string(),
                machine: machine.name.clone(),
                build_id: self.heading.build_id.clone(),
                seed: self.heading.seed,
            },
            rules: BuildFileRules {
                volume_mm: machine.volume_mm,
                keep_out: machine.keep_out.clone(),
                margins_mm: machine.margins.as_dvec3(),
                clearance_mm: machine.clearance_mm,
                clearance_z_extra_mm: machine.clearance_z_extra_mm,
                layer_mm: machine.layer_cap.layer_mm,
                layer_area_cap_mm2: machine.layer_cap.cap_mm2(),
                interlock: machine.interlock.as_str().to_owned(),
            },
            height_mm: self.machine_height_mm(),
            density: self.density,
            objects: used.iter().map(|&part| to_build_object(&self.parts[part])).collect(),
            items: self
                .placed
                .iter()
                .map(|p| self.to_build_item(p, used.partition_point(|&part| part < p.part)))
                .collect(),
            delivery: machine.delivery,
            arrangement: machine.arrangement,
            thumbnail_png: None,
        }
    }

    fn to_build_item(&self, placed: &PartPlacement, object: usize) -> BuildFileItem {
        let part = &self.parts[placed.part];
        let tilts = &part.orientation.tilts;
        BuildFileItem {
            object,
            pose: self.machine.machine_pose(&placed.pose),
            words: part.words.clone(),
            copy: placed.copy + 1,
            source_name: part.source_name.clone(),
            source_hash: part.source_hash.clone(),
            clearance_mm: part.clearance_mm,
            orientation: serialized_name(&part.orientation.rule),
            tilts: (!tilts.is_empty()).then(|| nester::write_tilts(tilts)),
        }
    }

    /// The report of the build. `unplaced` holds part index and copy number of the copies that found no place.
    pub fn to_report(
        &self,
        lower_bound_mm: f64,
        evaluations: u64,
        unplaced: &[(usize, u32)],
        summary: SearchSummary,
    ) -> NestingReport {
        let name = |part: usize| self.parts[part].name.clone();
        let placed = |p: &PartPlacement| PlacedPart {
            part: name(p.part),
            copy: p.copy,
            pose: self.machine.machine_pose(&p.pose).matrix_rows(),
        };
        let report = NestingReport {
            packing: PackingMeasures {
                height_mm: if self.placed.is_empty() { 0.0 } else { self.machine_height_mm() },
                density: self.density,
                lower_bound_mm,
                ..PackingMeasures::default()
            },
            clearance: ClearanceMeasures {
                clearance_mm: self.machine.clearance_mm,
                clearance_z_extra_mm: self.machine.clearance_z_extra_mm,
                clearance_proved_mm: summary.clearance_proved_mm,
            },
            separable: summary.separable,
            placed: self.placed.len(),
            unplaced: UnplacedPart::name_copies(unplaced, &summary.left_out, name),
            search: SearchCost {
                seed: summary.seed,
                evaluations,
                cpu_secs: summary.cpu_secs,
                wall_secs: summary.wall_secs,
                curve: summary.curve,
                ended: summary.ended,
            },
            placements: self.placed.iter().map(placed).collect(),
        };
        let standing: Vec<(&Mesh, Pose)> = self.placed.iter().map(|p| (&*self.parts[p.part].mesh, p.pose)).collect();
        report.with_measurements(&standing, self.machine.layer_cap)
    }
}

fn to_build_object(part: &BuildPart) -> BuildFileObject {
    BuildFileObject {
        name: part.object_name.clone(),
        mesh: part.mesh.clone(),
        part_number: part.part_number.clone(),
        content_hash: part.content_hash.clone(),
    }
}

/// Renders the build as seen from above one corner. Parts have the colours of their numbers' order, as everywhere.
pub fn render_picture(build: &BuildFile, size: (u32, u32)) -> Vec<u8> {
    let numbers: Vec<&str> = build.objects.iter().map(|object| object.part_number.as_str()).collect();
    let kinds = kinds_by_number(&numbers);
    let picture_body =
        |i: &BuildFileItem| PictureBody { mesh: &build.objects[i.object].mesh, pose: i.pose, kind: kinds[i.object] };
    let bodies: Vec<PictureBody> = build.items.iter().map(picture_body).collect();
    build_file::draw_picture(&bodies, build.rules.volume_mm, Viewpoint::Iso, size)
}

/// The kind of each object: its place in the order of the numbers of their parts. A batch has them in the order of precedence.
fn kinds_by_number(numbers: &[&str]) -> Vec<usize> {
    let mut by_number: Vec<usize> = (0..numbers.len()).collect();
    by_number.sort_by_key(|&object| numbers[object].parse::<i64>().ok());
    let mut kinds = vec![0; numbers.len()];
    by_number.iter().enumerate().for_each(|(kind, &object)| kinds[object] = kind);
    kinds
}

/// The name that serde writes for a unit variant.
fn serialized_name(value: &impl serde::Serialize) -> Option<String> {
    serde_json::to_value(value).ok()?.as_str().map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_has_the_colour_of_its_number_whatever_goes_first() {
        assert_eq!(kinds_by_number(&["12", "7", "9"]), [2, 0, 1]);
        assert_eq!(kinds_by_number(&["", ""]), [0, 1], "parts without numbers keep their order");
    }
}
