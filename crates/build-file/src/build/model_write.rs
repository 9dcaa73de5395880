//! Writes the model part of a build file as a stream. `threemf2` cannot write metadata of items, holds the whole XML in
//! memory and escapes nothing. Names come from outside, so they are mapped to characters that every reader handles
//! correctly.

use std::io::{self, Write};

use glam::DVec3;
use solids::{Mesh, Pose};

use super::build_metadata::{format_pose, metadata_of};
use crate::{
    Arrangement, BuildFile, BuildFileItem, DeliveryKind, OrderWords,
    common::{
        decimal::{push_decimal, push_index},
        uuid::derive_uuid,
    },
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
    for &(id, item) in &ids.meshes {
        write_mesh_object(build, id, &build.items[item], out)?;
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
    /// Id of each mesh to write, and the item that it is written for: the first of its object, or each.
    meshes: Vec<(usize, usize)>,
    /// Id of each item's mesh.
    of_item: Vec<usize>,
}

impl ResourceIds {
    fn for_build(build: &BuildFile) -> Self {
        let mut ids = Self { meshes: Vec::new(), of_item: Vec::new() };
        let mut known = vec![None; build.objects.len()];
        for (number, item) in build.items.iter().enumerate() {
            let id = match known[item.object] {
                Some(id) if build.delivery != DeliveryKind::Expanded => id,
                _ => {
                    ids.meshes.push((ids.meshes.len() + 1, number));
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
    metadata_of(build).iter().try_for_each(|(name, value)| write_metadata(out, name, value))
}

fn write_item_metadata(item: &BuildFileItem, build: &BuildFile, out: &mut impl Write) -> io::Result<()> {
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
    if build.delivery == DeliveryKind::Expanded {
        let pose = format_pose(&written_pose(item, build));
        writeln!(out, r#"<metadata name="nestd:pose">{pose}</metadata>"#)?;
    }
    writeln!(out, "</metadatagroup>")
}

fn write_metadata(out: &mut impl Write, name: &str, value: &str) -> io::Result<()> {
    writeln!(out, r#"<metadata name="{name}">{}</metadata>"#, sanitize_name(value))
}

/// Writes a mesh in its own frame, or in the place of the item.
fn write_mesh_object(build: &BuildFile, id: usize, item: &BuildFileItem, out: &mut impl Write) -> io::Result<()> {
    let described = &build.objects[item.object];
    let place = (build.delivery == DeliveryKind::Expanded).then(|| written_pose(item, build));
    let uuid = derive_uuid(&[&build.heading.build_id, "object", &described.content_hash, &id.to_string()]);
    let (name, part) = (sanitize_name(&described.name), sanitize_name(&described.part_number));
    writeln!(out, r#"<object id="{id}" type="model" name="{name}" partnumber="{part}" p:UUID="{uuid}">"#)?;
    write_mesh(&described.mesh, place, out)?;
    writeln!(out, "</object>")
}

fn write_mesh(mesh: &Mesh, place: Option<Pose>, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<mesh>\n<vertices>")?;
    let placed = |corner: &DVec3| place.map_or(*corner, |pose| pose.transform_point(*corner));
    let mut line = Vec::new();
    for corner in mesh.vertices().iter().map(placed) {
        line.clear();
        for (name, coordinate) in [r#"<vertex x=""#, r#"" y=""#, r#"" z=""#].into_iter().zip(corner.to_array()) {
            line.extend_from_slice(name.as_bytes());
            push_decimal(&mut line, coordinate);
        }
        line.extend_from_slice(b"\"/>\n");
        out.write_all(&line)?;
    }
    writeln!(out, "</vertices>\n<triangles>")?;
    for corners in mesh.triangles() {
        line.clear();
        for (name, corner) in [r#"<triangle v1=""#, r#"" v2=""#, r#"" v3=""#].into_iter().zip(corners) {
            line.extend_from_slice(name.as_bytes());
            push_index(&mut line, *corner);
        }
        line.extend_from_slice(b"\"/>\n");
        out.write_all(&line)?;
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
        write_item_metadata(item, build, out)?;
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
        let transform = transform_attribute(item, build);
        writeln!(out, r#"<component objectid="{}"{transform} p:UUID="{uuid}"/>"#, first + number)?;
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
    let (transform, part) = (transform_attribute(item, build), sanitize_name(&described.part_number));
    writeln!(out, r#"<item objectid="{id}"{transform} partnumber="{part}" p:UUID="{uuid}">"#)?;
    write_item_metadata(item, build, out)?;
    writeln!(out, "</item>")
}

/// The attribute with the twelve numbers for row vectors: the images of x, y and z, then the translation, mm. A mesh that is written in
/// its place has none.
fn transform_attribute(item: &BuildFileItem, build: &BuildFile) -> String {
    if build.delivery == DeliveryKind::Expanded {
        return String::new();
    }
    let pose = written_pose(item, build);
    let matrix = pose.rotation_matrix();
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, pose.translation];
    let numbers: Vec<String> = columns.iter().flat_map(|v| v.to_array()).map(|n| (n + 0.0).to_string()).collect();
    format!(r#" transform="{}""#, numbers.join(" "))
}

/// The pose of an item as it is written. 3MF forbids coordinates below zero, but a part as large as its volume may stand less than a
/// millionth of a millimetre outside: such a part is moved inside.
fn written_pose(item: &BuildFileItem, build: &BuildFile) -> Pose {
    let mut pose = item.pose;
    let mesh = &build.objects[item.object].mesh;
    let local = mesh.bounds();
    let reach = local.min.abs().max(local.max.abs()).length();
    if pose.translation.min_element() <= reach + CLEAR_OF_ZERO_MM {
        let lowest = mesh.bounds_at(&pose).min;
        let out = (DVec3::splat(CLEAR_OF_ZERO_MM) - lowest).clamp(DVec3::ZERO, DVec3::splat(MAX_MOVED_IN_MM));
        pose.translation += out;
    }
    pose
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
