//! Small valid files of every format, from which tests make hostile ones.

use std::io::{Cursor, Write};

use rand::{Rng, RngExt};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

const TYPES: &str = r#"<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"/>"#;
/// Names the model of a package.
pub const RELATIONSHIPS: &str = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
/// A tetrahedron.
pub const MESH: &str = r#"<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="9" y="0" z="0"/><vertex x="0" y="9" z="0"/><vertex x="0" y="0" z="9"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh>"#;
const CORNERS: [[u8; 3]; 4] = [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]];
const TRIANGLES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// A 3MF model with given resources and build items.
pub fn model(resources: &str, build: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"><metadata name="Title">T</metadata><resources>{resources}</resources><build>{build}</build></model>"#
    )
}

/// A valid model with an object, an assembly and rotated build items.
pub fn honest() -> String {
    model(
        &format!(
            r#"<object id="1" name="a" p:UUID="6b0a9b54-58a1-4a38-8d5d-1f2f4ef0b0aa">{MESH}</object><object id="2"><components><component objectid="1"/><component objectid="1" transform="1 0 0 0 1 0 0 0 1 20 0 0"/></components></object>"#
        ),
        r#"<item objectid="1"/><item objectid="2" transform="0 1 0 -1 0 0 0 0 1 5 5 5"/>"#,
    )
}

/// A ZIP package.
pub fn package(entries: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(*name, SimpleFileOptions::default().compression_method(method)).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A 3MF package with a given model.
pub fn threemf(model: &[u8]) -> Vec<u8> {
    let entries: [(&str, &[u8]); 3] = [
        ("[Content_Types].xml", TYPES.as_bytes()),
        ("_rels/.rels", RELATIONSHIPS.as_bytes()),
        ("3D/3dmodel.model", model),
    ];
    package(&entries, CompressionMethod::Deflated)
}

/// A binary tetrahedron whose header claims to be text.
pub fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(4_u32.to_le_bytes());
    for triangle in TRIANGLES {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flat_map(|&i| CORNERS[i]).map(f32::from).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

/// The tetrahedron as text.
pub fn text_stl() -> Vec<u8> {
    let mut text = "solid text\n".to_owned();
    for triangle in TRIANGLES {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in triangle.map(|i| CORNERS[i]) {
            text += &format!("  vertex {x} {y}.0e0 {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    (text + "endsolid text\n").into_bytes()
}

/// Changes a few bytes, cuts, doubles or drops a piece.
pub fn mutated(bytes: &[u8], rng: &mut impl Rng) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(0..=out.len());
        let end = (at + rng.random_range(0..24)).min(out.len());
        let piece = out[at..end].to_vec();
        match rng.random_range(0..6) {
            0 => out.truncate(at),
            1 => drop(out.drain(at..end)),
            2 => drop(out.splice(at..at, piece)),
            3 => out[at..end].fill([0, 0xff, b'9', b'-', b'<', b'"'][rng.random_range(0..6)]),
            4 => out[at..end].iter_mut().for_each(|b| *b ^= 1 << rng.random_range(0..8)),
            _ => out[at..end].iter_mut().for_each(|b| *b = rng.random()),
        }
        if out.is_empty() {
            break;
        }
    }
    out
}

/// A binary STL without the smallest of its triangles: a hole that can be mended.
pub fn with_a_hole(mut stl: Vec<u8>) -> Vec<u8> {
    let corner = |at: usize| {
        let number = |at: usize| f64::from(f32::from_le_bytes(stl[at..at + 4].try_into().unwrap()));
        glam::DVec3::new(number(at), number(at + 4), number(at + 8))
    };
    let double_area = |facet: usize| {
        let [a, b, c] = [12, 24, 36].map(|offset| corner(84 + 50 * facet + offset));
        (b - a).cross(c - a).length()
    };
    let facets = (stl.len() - 84) / 50;
    let smallest = (0..facets).min_by(|one, two| double_area(*one).total_cmp(&double_area(*two))).unwrap();
    stl.drain(84 + 50 * smallest..84 + 50 * (smallest + 1));
    stl[80..84].copy_from_slice(&(facets as u32 - 1).to_le_bytes());
    stl
}

/// A workbook with a title above its rows, as offices write it; a number is a number.
pub fn workbook(rows: &[[String; 4]]) -> Vec<u8> {
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
    let cell = |text: &String| match text.parse::<u32>() {
        Ok(number) => format!("<c><v>{number}</v></c>"),
        Err(_) => format!(r#"<c t="inlineStr"><is><t>{}</t></is></c>"#, escaped(text)),
    };
    let row = |row: &[String; 4]| format!("<row>{}</row>", row.iter().map(cell).collect::<String>());
    let title = r#"<row><c t="inlineStr"><is><t>Order</t></is></c></row><row/>"#;
    let rows: String = rows.iter().map(row).collect();
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
    let related = |kind: &str, target: &str| {
        format!(
            r#"<Relationships xmlns="{PACKAGE}"><Relationship Id="r" Type="{OFFICE}/{kind}" Target="{target}"/></Relationships>"#
        )
    };
    let book = format!(
        r#"<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets><sheet name="Order" sheetId="1" r:id="r"/></sheets></workbook>"#
    );
    let sheet = format!(r#"<worksheet xmlns="{MAIN}"><sheetData>{title}{rows}</sheetData></worksheet>"#);
    let (root, of_book) = (related("officeDocument", "xl/workbook.xml"), related("worksheet", "worksheets/sheet1.xml"));
    let entries: [(&str, &str); 5] = [
        ("[Content_Types].xml", TYPES),
        ("_rels/.rels", &root),
        ("xl/workbook.xml", &book),
        ("xl/_rels/workbook.xml.rels", &of_book),
        ("xl/worksheets/sheet1.xml", &sheet),
    ];
    package(&entries.map(|(name, text)| (name, text.as_bytes())), CompressionMethod::Deflated)
}
