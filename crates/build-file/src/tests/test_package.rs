//! Small 3MF packages for tests.

use std::io::Write;

use zip::{ZipWriter, write::SimpleFileOptions};

use crate::{threemf::xml_names, *};

const RELATIONSHIPS: &str = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

/// A mesh of boxes from a corner at the origin, 12 triangles each.
pub(crate) fn boxes(sizes: &[[f64; 3]]) -> String {
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let (mut vertices, mut triangles) = (String::new(), String::new());
    for (number, size) in sizes.iter().enumerate() {
        for corner in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { size[axis] } else { 0.0 });
            vertices += &format!(r#"<vertex x="{x}" y="{y}" z="{z}"/>"#);
        }
        for [a, b, c, d] in quads.map(|quad: [usize; 4]| quad.map(|corner| corner + 8 * number)) {
            triangles += &format!(r#"<triangle v1="{a}" v2="{b}" v3="{c}"/><triangle v1="{a}" v2="{c}" v3="{d}"/>"#);
        }
    }
    format!("<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>")
}

/// The document of a model part.
pub(crate) fn model(resources: &str, build: &str) -> String {
    let (core, production) = (xml_names::CORE, xml_names::PRODUCTION);
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" xmlns="{core}" xmlns:p="{production}"><resources>{resources}</resources><build>{build}</build></model>"#
    )
}

/// The bytes of a package with these entries and the relationships.
pub(crate) fn package(entries: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, text) in [("_rels/.rels", RELATIONSHIPS)].iter().chain(entries) {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Reads bytes as a dropped file of this name.
pub(super) fn read_bytes(bytes: &[u8], name: &str) -> Result<PartFileContents, FileReadError> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    read_part_file(file.path(), name, None, LengthUnit::Millimeter, &ReadLimits::for_testing())
}

/// Reads a package with these entries.
pub(crate) fn read_package(entries: &[(&str, &str)]) -> Result<PartFileContents, FileReadError> {
    read_bytes(&package(entries), "project.3mf")
}
