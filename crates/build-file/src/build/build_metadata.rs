//! What a build file says of itself, in words that each kind of file holds: names and texts.

use glam::{DQuat, DVec3};
use solids::{Bounds, Pose};

use crate::{
    Arrangement, BuildFile, BuildMetadata, HeadingMetadata, RulesMetadata,
    threemf::{model::ModelMetadata, xml_names::XmlNamespace},
};

/// Before the names that no specification has.
const OWN: &str = "nestd:";

/// Names and values of the metadata of a build, as they are written.
pub(super) fn metadata_of(build: &BuildFile) -> Vec<(String, String)> {
    let (heading, rules) = (&build.heading, &build.rules);
    let vector = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let corners = |b: &Bounds| format!("{} {}", vector(b.min), vector(b.max));
    let boxes: Vec<String> = rules.keep_out.iter().map(corners).collect();
    let arrangement = if build.arrangement == Arrangement::Locked { "locked" } else { "items" };
    let standard = [
        ("Title", heading.title.clone()),
        ("Application", heading.application.clone()),
        ("CreationDate", heading.created.clone()),
    ];
    let own = [
        ("machine", Some(heading.machine.clone())),
        ("build", Some(heading.build_id.clone())),
        ("seed", Some(heading.seed.to_string())),
        ("volume_mm", Some(vector(rules.volume_mm))),
        ("keep_out_mm", (!boxes.is_empty()).then(|| boxes.join("; "))),
        ("margins_mm", Some(vector(rules.margins_mm))),
        ("clearance_mm", Some(rules.clearance_mm.to_string())),
        ("clearance_z_extra_mm", Some(rules.clearance_z_extra_mm.to_string())),
        ("layer_mm", Some(rules.layer_mm.to_string())),
        ("layer_area_cap_mm2", rules.layer_area_cap_mm2.map(|cap_mm2| cap_mm2.to_string())),
        ("height_mm", Some(build.height_mm.to_string())),
        ("density", Some(build.density.to_string())),
        ("interlock", Some(rules.interlock.clone())),
        ("arrangement", Some(arrangement.to_owned())),
    ];
    let standard = standard.map(|(name, value)| (name.to_owned(), value));
    standard
        .into_iter()
        .chain(own.into_iter().filter_map(|(name, value)| Some((format!("{OWN}{name}"), value?))))
        .collect()
}

/// The metadata that were read as names and values.
pub(super) fn from_pairs(pairs: impl IntoIterator<Item = (String, String)>) -> ModelMetadata {
    let entry = |(name, value): (String, String)| match name.strip_prefix(OWN) {
        Some(own) => (XmlNamespace::Nestd, own.to_owned(), value),
        None => (XmlNamespace::None, name, value),
    };
    ModelMetadata(pairs.into_iter().map(entry).collect())
}

pub(super) fn heading_metadata(metadata: &ModelMetadata) -> HeadingMetadata {
    HeadingMetadata {
        title: metadata.standard_value("Title"),
        application: metadata.standard_value("Application"),
        created: metadata.standard_value("CreationDate"),
        // Earlier versions called a machine by its profile.
        machine: metadata.nestd_value("machine").or_else(|| metadata.nestd_value("profile")),
        build_id: metadata.nestd_value("build"),
        seed: metadata.nestd_value("seed").and_then(|text| text.parse().ok()),
    }
}

pub(super) fn build_metadata(metadata: &ModelMetadata) -> BuildMetadata {
    let number = |name: &str| metadata.nestd_value(name).and_then(|text| text.parse().ok());
    BuildMetadata {
        heading: heading_metadata(metadata),
        rules: RulesMetadata {
            volume_mm: metadata.nestd_value("volume_mm").and_then(|text| parse_vector(&text)),
            keep_out: metadata.nestd_value("keep_out_mm").map(|text| parse_boxes(&text)).unwrap_or_default(),
            margins_mm: metadata.nestd_value("margins_mm").and_then(|text| parse_vector(&text)),
            clearance_mm: number("clearance_mm"),
            clearance_z_extra_mm: number("clearance_z_extra_mm"),
            layer_mm: number("layer_mm"),
            layer_area_cap_mm2: number("layer_area_cap_mm2"),
            interlock: metadata.nestd_value("interlock"),
        },
        height_mm: number("height_mm"),
        density: number("density"),
    }
}

fn parse_vector(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
    <[f64; 3]>::try_from(numbers).ok().map(DVec3::from_array)
}

/// Parses boxes of six numbers each. A box that cannot be parsed covers everything, so that it is never taken for
/// respected.
fn parse_boxes(text: &str) -> Vec<Bounds> {
    let everywhere = Bounds { min: DVec3::splat(-1e6), max: DVec3::splat(1e6) };
    let corners = |text: &str| -> Option<Bounds> {
        let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
        let [a, b, c, d, e, f] = <[f64; 6]>::try_from(numbers).ok()?;
        Some(Bounds { min: DVec3::new(a, b, c), max: DVec3::new(d, e, f) })
    };
    text.split(';').map(|text| corners(text).unwrap_or(everywhere)).collect()
}

/// How a pose is written in metadata: a quaternion, with its real part last, and a translation in mm.
pub(super) fn format_pose(pose: &Pose) -> String {
    let numbers = pose.rotation.to_array().into_iter().chain(pose.translation.to_array());
    numbers.map(|number| number.to_string()).collect::<Vec<_>>().join(" ")
}

pub(super) fn parse_pose(text: &str) -> Option<Pose> {
    let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
    let [i, j, k, w, x, y, z] = <[f64; 7]>::try_from(numbers).ok()?;
    Pose::from_stored(DQuat::from_xyzw(i, j, k, w), DVec3::new(x, y, z)).ok()
}
