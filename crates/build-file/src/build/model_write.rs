//! Writes the model part of a build file as a stream. `threemf2` cannot write metadata of items, holds the whole XML in
//! memory and escapes nothing. Names come from outside, so they are mapped to characters that every reader handles
//! correctly.

use std::io::{self, Write};

use glam::DVec3;
use solids::Mesh;

use crate::{
    Arrangement, BuildFile, BuildFileItem, InstanceSharing, OrderWords,
    common::uuid::derive_uuid,
    is_invisible,
    threemf::xml_names::{CORE, NESTD, PRODUCTION},
};

/// Greatest excess over the volume that counts as rounding, mm. A greater excess is written unchanged, so that the
/// proof refuses it.
const MAX_MOVED_IN_MM: f64 = 1e-6;
/// Distance from zero that the rounding of other readers does not reach.
const CLEAR_OF_ZERO_MM: f64 = 1e-9;
/// Greatest length of a written name; the rest is cut off.
const MAX_NAME: usize = 200;

/// Greatest length of a written note; the end of a longer one is replaced by an ellipsis.
const MAX_NOTE: usize = 500;

/// Writes the `<model>` of a build.
pub(super) fn write_model(build: &BuildFile, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        out,
        r#"<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}" xmlns:p="{PRODUCTION}" xmlns:nestd="{NESTD}">"#
    )?;
    write_package_metadata(build, out)?;
    let ids = ResourceIds::for_build(build);
    writeln!(out, "<resources>")?;
    for &(id, object) in &ids.meshes {
        write_mesh_object(build, id, object, out)?;
    }
    let locked = match build.arrangement {
        Arrangement::Items => None,
        Arrangement::Locked => Some(write_locked_object(build, &ids, out)?),
    };
    writeln!(out, "</resources>")?;
    writeln!(out, r#"<build p:UUID="{}">"#, derive_uuid(&[&build.heading.build_id, "build"]))?;
    match locked {
        Some(id) => {
            let uuid = derive_uuid(&[&build.heading.build_id, "item", "locked"]);
            writeln!(out, r#"<item objectid="{id}" p:UUID="{uuid}"/>"#)?;
        }
        None => {
            for (number, item) in build.items.iter().enumerate() {
                write_build_item(build, number, item, ids.of_item[number], out)?;
            }
        }
    }
    writeln!(out, "</build>\n</model>")
}

/// Resource ids, unique across the package.
struct ResourceIds {
    /// (id, index of the object) of each mesh to write.
    meshes: Vec<(usize, usize)>,
    /// Id of each item's mesh.
    of_item: Vec<usize>,
}

impl ResourceIds {
    fn for_build(build: &BuildFile) -> Self {
        let mut ids = Self { meshes: Vec::new(), of_item: Vec::new() };
        let mut known = vec![None; build.objects.len()];
        for item in &build.items {
            let id = match (build.instances, known[item.object]) {
                (InstanceSharing::Shared, Some(id)) => id,
                _ => {
                    ids.meshes.push((ids.meshes.len() + 1, item.object));
                    ids.meshes.len()
                }
            };
            known[item.object] = Some(id);
            ids.of_item.push(id);
        }
        ids
    }
}

fn write_package_metadata(build: &BuildFile, out: &mut impl Write) -> io::Result<()> {
    let (heading, rules) = (&build.heading, &build.rules);
    let (volume, margins) = (rules.volume_mm, rules.margins_mm);
    let locked = if build.arrangement == Arrangement::Locked { "locked" } else { "items" };
    write_metadata(out, "Title", &heading.title)?;
    write_metadata(out, "Application", &heading.application)?;
    write_metadata(out, "CreationDate", &heading.created)?;
    write_metadata(out, "nestd:machine", &heading.machine)?;
    write_metadata(out, "nestd:build", &heading.build_id)?;
    write_metadata(out, "nestd:seed", &heading.seed.to_string())?;
    write_metadata(out, "nestd:volume_mm", &format!("{} {} {}", volume.x, volume.y, volume.z))?;
    if !rules.keep_out.is_empty() {
        let corner = |c: DVec3| format!("{} {} {}", c.x, c.y, c.z);
        let boxes: Vec<String> =
            rules.keep_out.iter().map(|b| format!("{} {}", corner(b.min), corner(b.max))).collect();
        write_metadata(out, "nestd:keep_out_mm", &boxes.join("; "))?;
    }
    write_metadata(out, "nestd:margins_mm", &format!("{} {} {}", margins.x, margins.y, margins.z))?;
    write_metadata(out, "nestd:clearance_mm", &rules.clearance_mm.to_string())?;
    write_metadata(out, "nestd:clearance_z_extra_mm", &rules.clearance_z_extra_mm.to_string())?;
    write_metadata(out, "nestd:layer_mm", &rules.layer_mm.to_string())?;
    if let Some(cap_mm2) = rules.layer_area_cap_mm2 {
        write_metadata(out, "nestd:layer_area_cap_mm2", &cap_mm2.to_string())?;
    }
    write_metadata(out, "nestd:height_mm", &build.height_mm.to_string())?;
    write_metadata(out, "nestd:density", &build.density.to_string())?;
    write_metadata(out, "nestd:interlock", &rules.interlock)?;
    write_metadata(out, "nestd:arrangement", locked)
}

fn write_item_metadata(item: &BuildFileItem, out: &mut impl Write) -> io::Result<()> {
    write!(out, "<metadatagroup>")?;
    let OrderWords { order, due, note, reference, material } = &item.words;
    if let Some(order) = order {
        write_metadata(out, "nestd:order", order)?;
    }
    if let Some(due) = due {
        write_metadata(out, "nestd:due", due)?;
    }
    if let Some(note) = note {
        writeln!(out, r#"<metadata name="nestd:note">{}</metadata>"#, sanitize_note(note))?;
    }
    if let Some(reference) = reference {
        write_metadata(out, "nestd:reference", reference)?;
    }
    if let Some(material) = material {
        write_metadata(out, "nestd:material", material)?;
    }
    write_metadata(out, "nestd:copy", &item.copy.to_string())?;
    write_metadata(out, "nestd:source", &item.source_name)?;
    write_metadata(out, "nestd:source_hash", &item.source_hash)?;
    if let Some(clearance_mm) = item.clearance_mm {
        write_metadata(out, "nestd:clearance_mm", &clearance_mm.to_string())?;
    }
    if let Some(orientation) = &item.orientation {
        write_metadata(out, "nestd:orientation", orientation)?;
    }
    if let Some(tilts) = &item.tilts {
        // Not truncated like a name: a part of a rule would be another rule.
        let number = |c: &char| c.is_ascii_alphanumeric() || matches!(c, ',' | ';' | ':' | '.' | '-' | '+');
        let text: String = tilts.chars().filter(number).collect();
        writeln!(out, r#"<metadata name="nestd:tilts">{text}</metadata>"#)?;
    }
    writeln!(out, "</metadatagroup>")
}

fn write_metadata(out: &mut impl Write, name: &str, value: &str) -> io::Result<()> {
    writeln!(out, r#"<metadata name="{name}">{}</metadata>"#, sanitize_name(value))
}

fn write_mesh_object(build: &BuildFile, id: usize, object: usize, out: &mut impl Write) -> io::Result<()> {
    let described = &build.objects[object];
    let uuid = derive_uuid(&[&build.heading.build_id, "object", &described.content_hash, &id.to_string()]);
    let (name, part) = (sanitize_name(&described.name), sanitize_name(&described.part_number));
    writeln!(out, r#"<object id="{id}" type="model" name="{name}" partnumber="{part}" p:UUID="{uuid}">"#)?;
    write_mesh(&described.mesh, out)?;
    writeln!(out, "</object>")
}

fn write_mesh(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<mesh>\n<vertices>")?;
    for DVec3 { x, y, z } in mesh.vertices() {
        // `{}` prints the shortest digits that read back as the same number.
        writeln!(out, r#"<vertex x="{x}" y="{y}" z="{z}"/>"#)?;
    }
    writeln!(out, "</vertices>\n<triangles>")?;
    for [a, b, c] in mesh.triangles() {
        writeln!(out, r#"<triangle v1="{a}" v2="{b}" v3="{c}"/>"#)?;
    }
    writeln!(out, "</triangles>\n</mesh>")
}

/// Writes one object made of components, which a consumer must not move relative to each other. In between, one object
/// per placement holds its metadata, since components cannot have metadata.
fn write_locked_object(build: &BuildFile, ids: &ResourceIds, out: &mut impl Write) -> io::Result<usize> {
    let first = ids.meshes.len() + 1;
    for (number, item) in build.items.iter().enumerate() {
        let described = &build.objects[item.object];
        let (name, part) = (sanitize_name(&described.name), sanitize_name(&described.part_number));
        let own = derive_uuid(&[&build.heading.build_id, "placement", &described.content_hash, &number.to_string()]);
        let inner = derive_uuid(&[&build.heading.build_id, "mesh", &described.content_hash, &number.to_string()]);
        let id = first + number;
        writeln!(out, r#"<object id="{id}" type="model" name="{name}" partnumber="{part}" p:UUID="{own}">"#)?;
        write_item_metadata(item, out)?;
        writeln!(out, r#"<components><component objectid="{}" p:UUID="{inner}"/></components>"#, ids.of_item[number])?;
        writeln!(out, "</object>")?;
    }
    let id = first + build.items.len();
    let name = sanitize_name(&build.heading.title);
    let own = derive_uuid(&[&build.heading.build_id, "locked"]);
    writeln!(out, r#"<object id="{id}" type="model" name="{name}" p:UUID="{own}">"#)?;
    writeln!(out, "<components>")?;
    for (number, item) in build.items.iter().enumerate() {
        let uuid = derive_uuid(&[&build.heading.build_id, "component", &number.to_string()]);
        let transform = format_transform(item, build);
        writeln!(out, r#"<component objectid="{}" transform="{transform}" p:UUID="{uuid}"/>"#, first + number)?;
    }
    writeln!(out, "</components>\n</object>")?;
    Ok(id)
}

fn write_build_item(
    build: &BuildFile,
    number: usize,
    item: &BuildFileItem,
    id: usize,
    out: &mut impl Write,
) -> io::Result<()> {
    let described = &build.objects[item.object];
    let uuid = derive_uuid(&[&build.heading.build_id, "item", &described.content_hash, &number.to_string()]);
    let (transform, part) = (format_transform(item, build), sanitize_name(&described.part_number));
    writeln!(out, r#"<item objectid="{id}" transform="{transform}" partnumber="{part}" p:UUID="{uuid}">"#)?;
    write_item_metadata(item, out)?;
    writeln!(out, "</item>")
}

/// Twelve numbers for row vectors: the images of x, y and z, then the translation, mm. 3MF forbids coordinates below
/// zero, but a part as large as its volume may stand less than a millionth of a millimetre outside: such a part is
/// moved inside.
fn format_transform(item: &BuildFileItem, build: &BuildFile) -> String {
    let mut pose = item.pose;
    let mesh = &build.objects[item.object].mesh;
    let local = mesh.bounds();
    let reach = local.min.abs().max(local.max.abs()).length();
    if pose.translation.min_element() <= reach + CLEAR_OF_ZERO_MM {
        let lowest = mesh.bounds_at(&pose).min;
        let out = (DVec3::splat(CLEAR_OF_ZERO_MM) - lowest).clamp(DVec3::ZERO, DVec3::splat(MAX_MOVED_IN_MM));
        pose.translation += out;
    }
    let matrix = pose.rotation_matrix();
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, pose.translation];
    let numbers: Vec<String> = columns.iter().flat_map(|v| v.to_array()).map(|n| (n + 0.0).to_string()).collect();
    numbers.join(" ")
}

/// Maps a name to the characters used in build files, none of which needs an escape: a widely used reader handles
/// escapes wrongly.
pub fn sanitize_name(name: &str) -> String {
    name.chars().take(MAX_NAME).map(safe_character).collect()
}

/// Maps a note to the same characters, on one line.
fn sanitize_note(note: &str) -> String {
    let line = note.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.chars().count() > MAX_NOTE {
        true => line.chars().take(MAX_NOTE - 1).map(safe_character).chain(['…']).collect(),
        false => line.chars().map(safe_character).collect(),
    }
}

fn safe_character(c: char) -> char {
    if is_invisible(c) || matches!(c, '&' | '<' | '>' | '"' | '\'') { '_' } else { c }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_need_no_escapes() {
        assert_eq!(sanitize_name("a & <b>\n\"c\" 'd' \u{fffe} Größe 简"), "a _ _b___c_ _d_ _ Größe 简");
        assert_eq!(sanitize_name(&"x".repeat(1000)).len(), MAX_NAME);
        assert_eq!(
            sanitize_note("für Jörg:\r\n  kein <Strahlen> & \"Färben\"\n"),
            "für Jörg: kein _Strahlen_ _ _Färben_"
        );
        let long = sanitize_note(&"w".repeat(5000));
        assert!(long.chars().count() == MAX_NOTE && long.ends_with("w…"), "{long}");
    }
}
