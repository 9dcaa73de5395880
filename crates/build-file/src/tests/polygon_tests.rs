//! OBJ and PLY files.

use std::{fs, fs::File};

use glam::DVec3;

use crate::{FileReadError, LengthUnit, PartFileContents, ReadLimits, has_end, may_grow, read_part_file};

/// The corners of a box of 10 x 20 x 30, and its faces with four corners each.
const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [10.0, 0.0, 0.0],
    [10.0, 20.0, 0.0],
    [0.0, 20.0, 0.0],
    [0.0, 0.0, 30.0],
    [10.0, 0.0, 30.0],
    [10.0, 20.0, 30.0],
    [0.0, 20.0, 30.0],
];
const FACES: [[usize; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

fn read(bytes: &[u8], name: &str) -> Result<PartFileContents, FileReadError> {
    read_in(None, bytes, name)
}

/// Reads with the unit of a ticket.
fn read_in(unit: Option<LengthUnit>, bytes: &[u8], name: &str) -> Result<PartFileContents, FileReadError> {
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), bytes).unwrap();
    read_part_file(file.path(), name, unit, LengthUnit::Millimeter, &ReadLimits::for_testing())
}

fn ends(bytes: &[u8], name: &str) -> bool {
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), bytes).unwrap();
    has_end(&mut File::open(file.path()).unwrap(), name).unwrap()
}

/// The box, with indices as `index` writes them.
fn obj(index: impl Fn(usize) -> String) -> String {
    let corners = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    corners + &FACES.map(|face| format!("f {}\n", face.map(&index).join(" "))).concat()
}

fn is_the_box(contents: &PartFileContents) {
    let [solid] = &contents.solids[..] else { panic!("{} solids", contents.solids.len()) };
    assert_eq!((solid.mesh.triangles().len(), solid.mesh.vertices().len()), (12, 8));
    assert!(solid.mesh.defects().is_closed() && (solid.mesh.volume_mm3() - 6000.0).abs() < 1e-6);
    assert_eq!(solid.mesh.bounds().size(), DVec3::new(10.0, 20.0, 30.0));
    assert_eq!((solid.name.as_str(), solid.copies), ("box", 1));
}

#[test]
fn an_obj_file_is_read_however_its_faces_name_their_corners() {
    let kinds: [fn(usize) -> String; 4] = [
        |at| format!("{}", at + 1),
        |at| format!("{}/7/9", at + 1),
        |at| format!("{}//9", at + 1),
        |at| format!("{}", at as i64 - 8),
    ];
    for index in kinds {
        is_the_box(&read(obj(index).as_bytes(), "box.obj").unwrap());
    }
    let plain = obj(|at| format!("{}", at + 1));
    let with = |text: &str| read(text.as_bytes(), "box.obj").unwrap();
    is_the_box(&with(&plain.replace('\n', "\r\n")));
    is_the_box(&with(&plain.replace("f ", "f \\\n  ")));
    is_the_box(&with(plain.trim_end()));
    is_the_box(&with(&format!("# by a scanner\nmtllib box.mtl\nusemtl steel\ns off\n{plain}")));
    let named = [b"o Geh\xe4use \xbb1\xab\n", plain.as_bytes()].concat();
    is_the_box(&read(&named, "box.obj").unwrap());
    is_the_box(&read(plain.as_bytes(), "box.stl").unwrap());
    let inches = read_in(Some(LengthUnit::Inch), plain.as_bytes(), "box.obj").unwrap();
    assert!((inches.solids[0].mesh.bounds().size().z - 762.0).abs() < 1e-3);
}

#[test]
fn what_an_obj_file_holds_beside_its_faces_is_told() {
    let text = format!("o one\n{}o two\nl 1 2\np 1\nweird 1\n", obj(|at| format!("{}", at + 1)));
    let warnings = read(text.as_bytes(), "box.obj").unwrap().warnings;
    assert_eq!(
        warnings,
        [
            "the file holds 2 objects; they are one part",
            "2 lines and points are left out: there is nothing to print of them",
            "lines that begin with unknown words are left out: weird",
        ]
    );
}

#[test]
fn an_obj_file_that_cannot_be_read_says_where() {
    let said = |text: &str| {
        let error = read(text.as_bytes(), "box.obj").unwrap_err();
        assert!(!error.remedy().is_empty());
        error.to_string()
    };
    for (text, what) in [
        ("v 0 0 0\nv 1 0 nan\n", "line 2: a corner is not three finite decimal numbers"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "line 4: a face names corner `9`, and 3 come before it"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "corner `0`"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "corner `-4`"),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: a face has fewer than three corners"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n", "it holds no face"),
        ("v 0 0 0\nv 1 0 0\nsurf 0 1 0 1 1 2\n", "free-form surface (line 3)"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", "truncated: it ends within line 4"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\0\0\0", "unfinished copy"),
    ] {
        assert!(said(text).contains(what), "{what}: {}", said(text));
    }
    let eight = "v 0 0 0\nv 4 4 0\nv 4 0 0\nv 0 4 0\nf 1 2 3 4\n";
    assert!(said(eight).contains("face 1 has 4 corners, and they enclose no area"), "{}", said(eight));
    let many = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &"f 1 2 3\n".repeat(50_001);
    assert!(matches!(read(many.as_bytes(), "a.obj"), Err(FileReadError::TooLarge { key: "max_triangles", .. })));
}

#[test]
fn an_obj_file_ends_with_a_line_and_may_grow() {
    let text = obj(|at| format!("{}", at + 1));
    assert!(ends(text.as_bytes(), "box.obj") && !ends(&text.as_bytes()[..text.len() - 1], "box.obj"));
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), &text).unwrap();
    assert!(may_grow(&mut File::open(file.path()).unwrap(), "box.obj").unwrap());
}

/// The box as PLY: text, or binary in one order of bytes; corners as 32-bit or 64-bit numbers.
fn ply(encoding: &str, number: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\ncomment by a scanner\nelement vertex 8\nproperty {number} x\nproperty {number} y\nproperty {number} z\n\
         property uchar red\nelement face 6\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\nend_header\n"
    )
    .into_bytes();
    let big = encoding == "binary_big_endian";
    let mut put = |little: &[u8]| match big {
        true => bytes.extend(little.iter().rev()),
        false => bytes.extend(little),
    };
    if encoding == "ascii" {
        let corners = CORNERS.map(|[x, y, z]| format!("{x} {y} {z} 255\n")).concat();
        let faces = FACES.map(|face| format!("4 {}\n", face.map(|at| at.to_string()).join(" "))).concat();
        bytes.extend((corners + &faces + "1\n").bytes());
        return bytes;
    }
    for corner in CORNERS {
        for coordinate in corner {
            match number {
                "double" => put(&coordinate.to_le_bytes()),
                _ => put(&(coordinate as f32).to_le_bytes()),
            }
        }
        put(&[255]);
    }
    for face in FACES {
        put(&[4]);
        face.iter().for_each(|&at| put(&(at as i32).to_le_bytes()));
    }
    put(&1_i32.to_le_bytes());
    bytes
}

#[test]
fn a_ply_file_is_read_as_text_and_in_both_orders_of_bytes() {
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for number in ["float", "double"] {
            let bytes = ply(encoding, number);
            is_the_box(&read(&bytes, "box.ply").unwrap());
            if encoding == "ascii" {
                let text = String::from_utf8(bytes.clone()).unwrap();
                is_the_box(&read(text.replace("end_header\n", "end_header\n\n").as_bytes(), "box.ply").unwrap());
                is_the_box(&read(text.replace('\n', "\r\n").as_bytes(), "box.ply").unwrap());
            }
            assert!(ends(&bytes, "box.ply"), "{encoding}");
            for cut in [1, 3, 100, 270, bytes.len() / 2] {
                assert!(!ends(&bytes[..cut], "box.ply"), "{encoding} {number} {cut}");
            }
            let error = read(&bytes[..bytes.len() - 40], "box.ply").unwrap_err();
            assert!(
                matches!(error, FileReadError::Truncated(_) | FileReadError::Invalid { .. }),
                "{encoding}: {error}"
            );
        }
    }
}

#[test]
fn a_ply_file_that_cannot_be_read_says_why_and_takes_no_memory_for_what_it_claims() {
    let said = |text: &str| read(text.as_bytes(), "box.ply").unwrap_err().to_string();
    let head = |vertices: &str, faces: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let corners = "0 0 0\n1 0 0\n0 1 0\n";
    for (text, what) in [
        (head("3", "0") + corners, "it holds no face"),
        (head("3", "1") + corners + "3 0 1 3\n", "face 1 names corner 3"),
        (head("3", "1") + corners + "2 0 1\n", "face 1 has 2 corners"),
        (head("120000", "1") + corners, "cannot hold 120000 times"),
        (head("3", "50001") + corners, "too many triangles"),
        (head("999999999999", "1") + corners, "too many triangles"),
        (head("3", "1").replace("vertex_indices", "corners") + corners + "3 0 1 2\n", "no list `vertex_indices`"),
        ("ply\nformat ascii 1.0\nelement vertex 3\n".to_owned(), "before its `end_header`"),
        (head("3", "1") + "0 0 0\n\u{fffd} 0 0\n0 1 0\n3 0 1 2\n", "entry 2 of element \"vertex\""),
        ("ply\nrubbish\nend_header\n".to_owned(), "not valid PLY"),
        (head("3", "1") + &" ".repeat((1 << 20) + 1), "the line of entry 1 of element \"vertex\" is longer"),
    ] {
        assert!(said(&text).contains(what), "{what}: {}", said(&text));
    }
    let latin = [head("3", "1").as_bytes(), b"0 0 0\n\xe4 0 0\n0 1 0\n3 0 1 2\n"].concat();
    assert!(matches!(read(&latin, "box.ply"), Err(FileReadError::Invalid { .. })), "no failure of the disk");
    let latin = [b"ply\nformat ascii 1.0\ncomment \xe4\n", &head("3", "1").as_bytes()[21..]].concat();
    assert!(matches!(read(&latin, "box.ply"), Err(FileReadError::Invalid { .. })));
}
