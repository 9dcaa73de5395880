//! Copies that stopped while their blocks were allocated already are unfinished, never a part; and what follows the end of a
//! file is not lost silently.

use std::fs::File;

use super::test_package::{boxes, model, package, read_bytes};
use crate::*;

/// A binary STL of cubes of 10 mm, 20 mm apart, 12 triangles each.
fn binary(cubes: usize) -> Vec<u8> {
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut bytes = vec![b'x'; 80];
    bytes.extend((12 * cubes as u32).to_le_bytes());
    for cube in 0..cubes {
        for [a, b, c, d] in quads {
            for triangle in [[a, b, c], [a, c, d]] {
                bytes.extend([0; 12]);
                for corner in triangle {
                    let at = |axis: usize| if corner >> axis & 1 == 1 { 10.0_f32 } else { 0.0 };
                    let place = [at(0) + 20.0 * cube as f32, at(1), at(2)];
                    bytes.extend(place.iter().flat_map(|number| number.to_le_bytes()));
                }
                bytes.extend([0; 2]);
            }
        }
    }
    bytes
}

fn text(cubes: usize) -> String {
    let bytes = binary(cubes);
    let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    (0..cubes).fold(String::new(), |mut text, cube| {
        text += &format!("solid cube {cube}\n");
        for facet in (12 * cube..12 * cube + 12).map(|facet| 84 + 50 * facet) {
            text += "facet normal 0 0 0\nouter loop\n";
            for corner in [12, 24, 36] {
                let at = facet + corner;
                text += &format!("vertex {} {} {}\n", number(at), number(at + 4), number(at + 8));
            }
            text += "endloop\nendfacet\n";
        }
        text + &format!("endsolid cube {cube}\n")
    })
}

fn zeroed(mut bytes: Vec<u8>, zeros: std::ops::Range<usize>) -> Vec<u8> {
    bytes[zeros].fill(0);
    bytes
}

fn refusal(bytes: &[u8], name: &str) -> String {
    match read_bytes(bytes, name) {
        Ok(contents) => panic!("{name} was read: {:?}", contents.warnings),
        Err(error) => format!("{error}: {}", error.remedy()),
    }
}

fn ends(bytes: &[u8], name: &str) -> bool {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    has_end(&mut File::open(file.path()).unwrap(), name).unwrap()
}

#[test]
fn a_binary_stl_that_ends_in_zero_facets_is_an_unfinished_copy() {
    let whole = binary(3);
    assert!(ends(&whole, "a.stl") && read_bytes(&whole, "a.stl").is_ok());
    // After one body, after two, within one, and in the last triangles.
    for written in [84, 84 + 600, 84 + 1200, 84 + 730, whole.len() - 50, whole.len() - 170] {
        let copy = zeroed(whole.clone(), written..whole.len());
        assert!(!ends(&copy, "a.stl"), "{written}");
        let refusal = refusal(&copy, "a.stl");
        assert!(refusal.contains("unfinished copy") && refusal.contains("Copy the whole file"), "{written}: {refusal}");
    }
}

#[test]
fn a_few_triangles_without_a_place_behind_a_closed_surface_miss_nothing() {
    let mut bytes = binary(1);
    bytes.extend([0; 3 * 50]);
    bytes[80..84].copy_from_slice(&15_u32.to_le_bytes());
    let contents = read_bytes(&bytes, "a.stl").unwrap();
    assert_eq!(contents.solids[0].mesh.triangles().len(), 12);
    assert!(contents.solids[0].warnings.join("\n").contains("3 triangles without an area"), "{contents:?}");
}

#[test]
fn a_block_of_zeros_within_a_binary_stl_is_an_unfinished_copy() {
    let whole = binary(40);
    // Whole bodies are in the block, so the surface stays closed.
    let holed = zeroed(whole.clone(), 84 + 600..84 + 600 * 9);
    assert!(refusal(&holed, "a.stl").contains("unfinished copy"));
    // Triangles without a place in a smaller number are only without an area.
    let few = zeroed(whole, 84 + 600..84 + 600 * 4);
    assert_eq!(read_bytes(&few, "a.stl").unwrap().solids[0].mesh.triangles().len(), 37 * 12);
}

#[test]
fn text_with_zero_bytes_is_an_unfinished_copy() {
    let (whole, first) = (text(3), text(1));
    assert!(ends(whole.as_bytes(), "a.stl") && read_bytes(whole.as_bytes(), "a.stl").is_ok());
    for written in [first.len(), first.len() - 1, first.len() + 200, whole.len() - 12, whole.len() - 1] {
        let copy = zeroed(whole.clone().into_bytes(), written..whole.len());
        assert!(!ends(&copy, "a.stl"), "{written}");
        assert!(refusal(&copy, "a.stl").contains("unfinished copy"), "{written}: {}", refusal(&copy, "a.stl"));
    }
    // Blocks within it: where facets are expected, and behind the name of a solid.
    let long = text(40);
    let second = long.find("solid cube 1").unwrap();
    for from in [second - 1, second + 40] {
        let copy = zeroed(long.clone().into_bytes(), from..from + 12_288);
        assert!(refusal(&copy, "a.stl").contains("unfinished copy"), "{from}: {}", refusal(&copy, "a.stl"));
    }
}

#[test]
fn a_package_with_a_block_of_zeros_is_an_unfinished_copy() {
    let mut long = String::new();
    for at in 0..40_000_u32 {
        long += &format!("{:x}", blake3::hash(&at.to_le_bytes()).as_bytes()[0]);
    }
    let start =
        model(&format!(r#"<object id="1">{}</object><!-- {long} -->"#, boxes(&[[9.0; 3]])), r#"<item objectid="1"/>"#);
    let whole = package(&[("3D/3dmodel.model", &start)]);
    assert!(read_bytes(&whole, "a.3mf").is_ok() && whole.len() > 20_000, "{}", whole.len());
    assert!(refusal(&zeroed(whole.clone(), 4096..12_288), "a.3mf").contains("unfinished copy"));
    let copy = zeroed(whole.clone(), 12_288..whole.len());
    assert!(
        !ends(&copy, "a.3mf") && refusal(&copy, "a.3mf").contains("unfinished copy"),
        "{}",
        refusal(&copy, "a.3mf")
    );
}

#[test]
fn a_second_stl_behind_the_first_is_refused() {
    let one = binary(1);
    let both = [one.clone(), binary(2)].concat();
    assert!(refusal(&both, "a.stl").contains("a second STL"), "{}", refusal(&both, "a.stl"));
    let cut = &both[..both.len() - 500];
    assert!(refusal(cut, "a.stl").contains("a second STL"), "{}", refusal(cut, "a.stl"));
    let with_text = [one.clone(), text(1).into_bytes()].concat();
    assert!(refusal(&with_text, "a.stl").contains("ASCII"), "{}", refusal(&with_text, "a.stl"));
    for harmless in [&b"\r\n"[..], &[0; 3000], &b"made by a program, with many words about its maker ".repeat(9)] {
        let contents = read_bytes(&[one.clone(), harmless.to_vec()].concat(), "a.stl").unwrap();
        assert!(contents.warnings.join("\n").contains("after the last triangle"), "{:?}", contents.warnings);
    }
}

#[test]
fn coordinates_far_from_the_origin_are_told_and_refused_beyond_a_kilometre() {
    let moved = |offset: f32| {
        let mut bytes = binary(1);
        for corner in (84..bytes.len()).step_by(50).flat_map(|facet| [12, 24, 36].map(|at| facet + at)) {
            let x = f32::from_le_bytes(bytes[corner..corner + 4].try_into().unwrap()) + offset;
            bytes[corner..corner + 4].copy_from_slice(&x.to_le_bytes());
        }
        read_bytes(&bytes, "a.stl")
    };
    assert!(moved(500.0).unwrap().solids[0].coordinate_step_mm < 1e-4);
    assert_eq!(moved(800_000.0).unwrap().solids[0].coordinate_step_mm, 0.0625);
    assert_eq!(moved(1_000_000.0).unwrap().solids[0].coordinate_step_mm, 0.0625);
    assert!(moved(1_048_570.0).unwrap_err().to_string().contains("farther than 1.05 km"));
    // The places of build items and components in a 3MF are no coordinates of its mesh.
    let far = model(
        &format!(r#"<object id="1">{}</object>"#, boxes(&[[9.0; 3]])),
        r#"<item objectid="1" transform="1 0 0 0 1 0 0 0 1 900000 0 0"/>"#,
    );
    let contents = read_bytes(&package(&[("3D/3dmodel.model", &far)]), "a.3mf").unwrap();
    assert!(contents.solids[0].coordinate_step_mm < 1e-5);
}
