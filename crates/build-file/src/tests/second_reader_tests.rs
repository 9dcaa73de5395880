//! Tests that lists of vertices and triangles are read in whatever form they are, and that the second reader of a build notices what the first
//! one might read wrongly.

use std::{
    io::{Cursor, Read, Write},
    sync::Arc,
};

use glam::DVec3;
use solids::{Mesh, Pose};
use zip::{ZipArchive, ZipWriter, write::SimpleFileOptions};

use super::build_tests::{CHOICES, bytes, sample, with_file};
use crate::*;

/// The package with another text of its model.
fn with_model(package: &[u8], change: impl Fn(&str) -> String) -> Vec<u8> {
    let mut package = ZipArchive::new(Cursor::new(package)).unwrap();
    let mut changed = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..package.len() {
        let mut entry = package.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        if entry.name().ends_with(".model") {
            bytes = change(&String::from_utf8(bytes).unwrap()).into_bytes();
        }
        changed.start_file(entry.name().to_owned(), SimpleFileOptions::default()).unwrap();
        changed.write_all(&bytes).unwrap();
    }
    changed.finish().unwrap().into_inner()
}

/// A build of one part of many triangles.
fn boulder_build() -> BuildFile {
    let mut build = BuildFile::new(DVec3::splat(200.0), 1.0);
    let boulder = build.add_object("boulder", Arc::new(sample_parts::boulder(100.0, 40)));
    build.add_item(boulder, 0, Pose::new(glam::DQuat::IDENTITY, DVec3::splat(60.0)));
    build
}

#[test]
fn long_lists_in_mixed_forms_are_read_whole() {
    let limits = ReadLimits::for_testing();
    let written = bytes(&boulder_build());
    let placed = with_file(&written, |file| read_build(file, &limits)).unwrap();
    assert!(placed[0].mesh.triangles().len() > 10_000);
    let in_form = |(number, line): (usize, &str)| match (
        number % 11,
        line.strip_suffix("/>").filter(|_| line.contains(" v1=") || line.contains(" x=")),
    ) {
        (3, Some(start)) if line.starts_with("<vertex ") => format!("{start}></vertex>"),
        (4, Some(_)) => format!("<!-- <vertex x=\"1\" y=\"1\" z=\"1\"/> -->{line}\n"),
        (5, Some(_)) => line.replace('"', "'"),
        (6, Some(_)) => format!("{line} text <?nothing?>"),
        (7, Some(start)) => format!("{start} a=\"0\"/>"),
        (8, Some(_)) => format!("&amp;{line}&amp;"),
        (9, Some(_)) => format!("   {line}\r\n"),
        _ => format!("{line}\n"),
    };
    let mixed = with_model(&written, |text| text.lines().enumerate().map(in_form).collect());
    let read = with_file(&mixed, |file| read_build(file, &limits)).unwrap();
    assert_eq!(read[0].mesh.vertices(), placed[0].mesh.vertices());
    assert_eq!(read[0].mesh.triangles(), placed[0].mesh.triangles());
}

#[test]
fn a_fault_deep_in_a_long_list_is_an_error() {
    let limits = ReadLimits::for_testing();
    let written = bytes(&boulder_build());
    let change_last = |element: &str, from: &str, to: &str| {
        with_model(&written, |text| {
            let (before, last) = text.split_at(text.rfind(element).unwrap());
            format!("{before}{}", last.replacen(from, to, 1))
        })
    };
    for (element, from, to) in [
        ("<vertex ", "x=\"", "x=\"1,"),
        ("<vertex ", " z=", " w="),
        ("<vertex ", "/>", ">"),
        ("<triangle ", "v2=\"", "v2=\"-"),
        ("<triangle ", "v2=\"", "v2=\"1.5"),
        ("<triangle ", "v2=\"", "v2=\"9999"),
        ("<triangle ", "v3=", "v2="),
        ("<triangle ", "/>", ""),
    ] {
        let read = with_file(&change_last(element, from, to), |file| read_build(file, &limits));
        assert!(matches!(read, Err(FileReadError::Invalid { .. })), "{element} {to}: {read:?}");
    }
    let few = ReadLimits { max_triangles: placed_triangles(&written) - 1, ..ReadLimits::for_testing() };
    assert!(matches!(with_file(&written, |file| read_build(file, &few)), Err(FileReadError::TooLarge { .. })));
}

fn placed_triangles(written: &[u8]) -> u64 {
    with_file(written, |file| read_build(file, &ReadLimits::for_testing())).unwrap()[0].mesh.triangles().len() as u64
}

#[test]
fn one_wrong_corner_of_one_triangle_is_noticed() {
    let limits = ReadLimits::for_testing();
    for (delivery, arrangement) in CHOICES {
        with_file(&bytes(&sample(delivery, arrangement)), |file| {
            let placed = read_build(file, &limits).unwrap();
            let mesh = &placed[1].mesh;
            for (triangle, at) in (0..mesh.triangles().len()).flat_map(|triangle| [(triangle, 0), (triangle, 2)]) {
                let mut wrong = placed.clone();
                let mut triangles = mesh.triangles().to_vec();
                let corners = triangles[triangle];
                triangles[triangle][at] = (0..8).find(|corner| !corners.contains(corner)).unwrap();
                wrong[1].mesh = Arc::new(Mesh::new(mesh.vertices().to_vec(), triangles).unwrap());
                assert!(cross_check(file, &wrong, &limits).is_err(), "{delivery:?} {triangle} {at}");
            }
        });
    }
}

#[test]
fn a_change_of_the_file_after_it_was_read_is_noticed() {
    let limits = ReadLimits::for_testing();
    for (delivery, arrangement) in CHOICES {
        let written = bytes(&sample(delivery, arrangement));
        let placed = with_file(&written, |file| read_build(file, &limits)).unwrap();
        for (from, to) in [
            ("y=\"20\"", "y=\"21\""),
            ("y=\"0\" z=\"0\"/>\n</vertices>", "y=\"0\" z=\"0.00001\"/>\n</vertices>"),
            ("v3=\"3\"", "v3=\"5\""),
            ("v3=\"3\"", "v3=\"9\""),
            ("v1=\"0\"", "v1=\"4294967295\""),
        ] {
            let changed = with_model(&written, |text| text.replacen(from, to, 1));
            let differs = changed != with_model(&written, str::to_owned);
            let agrees = with_file(&changed, |file| cross_check(file, &placed, &limits).is_ok());
            assert_eq!(agrees, !differs, "{delivery:?}: {to}");
        }
    }
}

#[test]
fn lists_in_another_form_are_compared_too() {
    let limits = ReadLimits::for_testing();
    let forms: [fn(&str) -> String; 4] = [
        |text| text.replace("\"/>", "\" />"),
        |text| text.replace("\n<triangle ", " <triangle "),
        |text| text.replacen("<vertices>", "<vertices>\r", 1),
        |text| text.replace("<triangle v1", "<triangle p1=\"0\" v1"),
    ];
    for (number, form) in forms.into_iter().enumerate() {
        with_file(&with_model(&bytes(&sample(DeliveryKind::Shared, Arrangement::Items)), form), |file| {
            let placed = read_build(file, &limits).unwrap();
            cross_check(file, &placed, &limits).unwrap();
            let mut moved = placed.clone();
            moved[2].pose.translation += DVec3::X;
            assert!(cross_check(file, &moved, &limits).is_err(), "form {number}");
        });
    }
}

#[test]
fn a_mesh_that_was_mended_while_it_was_read_is_the_same_one() {
    let limits = ReadLimits::for_testing();
    let turned = |line: &str| match line.split('"').collect::<Vec<_>>().as_slice() {
        ["<triangle v1=", a, " v2=", b, " v3=", c, end] => {
            format!("<triangle v1=\"{b}\" v2=\"{a}\" v3=\"{c}\"{end}\n")
        }
        _ => format!("{line}\n"),
    };
    let written = bytes(&sample(DeliveryKind::Shared, Arrangement::Items));
    with_file(&with_model(&written, |text| text.lines().map(turned).collect()), |file| {
        let placed = read_build(file, &limits).unwrap();
        assert!(placed[0].mesh.defects().inverted);
        cross_check(file, &placed, &limits).unwrap();
    });
}
