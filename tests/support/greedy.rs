//! Small files within all limits that need much memory to read, or much time to nest.

use std::{fmt::Write as _, io::Write};

use zip::{ZipWriter, write::SimpleFileOptions};

/// A 3MF with one part made of `components` equal components in one place, each with about `triangles` triangles.
pub fn equal_components(components: usize, triangles: usize) -> Vec<u8> {
    let instances = "<component objectid=\"1\"/>".repeat(components);
    package(&format!("{}<object id=\"2\"><components>{instances}</components></object>", fan(triangles)), 2)
}

/// The same, but each object holds the previous one twice, `depth` objects deep.
pub fn deep_components(depth: usize, triangles: usize) -> Vec<u8> {
    let mut objects = fan(triangles);
    for id in 2..depth + 2 {
        let twice = format!("<component objectid=\"{}\"/>", id - 1).repeat(2);
        write!(objects, "<object id=\"{id}\"><components>{twice}</components></object>").unwrap();
    }
    package(&objects, depth + 1)
}

/// A small 3MF file of one mesh with `vertices` vertices, nearly all of them unused.
pub fn idle_vertices(vertices: usize) -> Vec<u8> {
    let many = "<vertex x=\"1\" y=\"1\" z=\"1\"/>".repeat(vertices);
    let mesh = "<vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"9\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"9\" z=\"0\"/>\
                <vertex x=\"0\" y=\"0\" z=\"9\"/>";
    let triangles = "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>\
                     <triangle v1=\"1\" v2=\"2\" v3=\"3\"/><triangle v1=\"0\" v2=\"3\" v3=\"2\"/>";
    let mesh = format!("<mesh><vertices>{mesh}{many}</vertices><triangles>{triangles}</triangles></mesh>");
    package(&format!("<object id=\"1\">{mesh}</object>"), 1)
}

/// A 3MF of one small part in a file that is padded by `bytes` bytes.
pub fn padded(bytes: usize) -> Vec<u8> {
    let mut zip = ZipWriter::new_append(std::io::Cursor::new(equal_components(1, 8))).unwrap();
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    zip.start_file("Metadata/padding.bin", stored).unwrap();
    zip.write_all(&vec![7; bytes]).unwrap();
    zip.finish().unwrap().into_inner()
}

/// The object 1: a closed pyramid with about `sides` triangles.
fn fan(sides: usize) -> String {
    let mut vertices = "<vertex x=\"0\" y=\"0\" z=\"10\"/><vertex x=\"0\" y=\"0\" z=\"0\"/>".to_owned();
    let mut triangles = String::new();
    let sides = (sides / 2).max(3);
    for at in 0..sides {
        let (y, x) = (at as f64 / sides as f64 * std::f64::consts::TAU).sin_cos();
        write!(vertices, "<vertex x=\"{:.5}\" y=\"{:.5}\" z=\"0\"/>", 5.0 * x, 5.0 * y).unwrap();
        let (here, next) = (at + 2, (at + 1) % sides + 2);
        write!(
            triangles,
            "<triangle v1=\"{here}\" v2=\"{next}\" v3=\"0\"/><triangle v1=\"{next}\" v2=\"{here}\" v3=\"1\"/>"
        )
        .unwrap();
    }
    let mesh = format!("<vertices>{vertices}</vertices><triangles>{triangles}</triangles>");
    format!("<object id=\"1\"><mesh>{mesh}</mesh></object>")
}

fn package(objects: &str, item: usize) -> Vec<u8> {
    let core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
    let of = "http://schemas.openxmlformats.org/package/2006";
    let model = format!(
        "<?xml version=\"1.0\"?><model unit=\"millimeter\" xmlns=\"{core}\"><resources>{objects}</resources><build>\
         <item objectid=\"{item}\"/></build></model>"
    );
    let types = format!(
        "<?xml version=\"1.0\"?><Types xmlns=\"{of}/content-types\"><Default Extension=\"rels\" \
         ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default Extension=\"bin\" \
         ContentType=\"application/octet-stream\"/><Default Extension=\"model\" \
         ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>"
    );
    let start = format!(
        "<?xml version=\"1.0\"?><Relationships xmlns=\"{of}/relationships\"><Relationship Target=\"/3D/3dmodel.model\" \
         Id=\"rel0\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"
    );
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, text) in [("[Content_Types].xml", types), ("_rels/.rels", start), ("3D/3dmodel.model", model)] {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}
