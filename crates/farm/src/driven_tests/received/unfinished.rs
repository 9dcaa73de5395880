//! Files that were taken before they were whole, and projects with more in them than parts.

use std::{fs, io::Write};

use ledger::{CommandKind, CommandState, PartState};

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, QUICK},
};

/// A farm that waits a minute for the rest of a file.
fn patient_farm() -> HandDrivenFarm {
    HandDrivenFarm::open(&QUICK.replace("unfinished_secs = 2", "unfinished_secs = 60"))
}

/// A body of an ASCII STL: a tetrahedron, moved along x.
fn body(x: f64) -> String {
    let corners = [[x, 0.0, 0.0], [x + 9.0, 0.0, 0.0], [x, 9.0, 0.0], [x, 0.0, 9.0]];
    let facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|facet: [usize; 3]| {
        let vertices = facet.map(|corner| {
            let [x, y, z] = corners[corner];
            format!("vertex {x} {y} {z}\n")
        });
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", vertices.concat())
    });
    format!("solid body\n{}endsolid body\n", facets.concat())
}

#[test]
fn what_is_written_after_a_file_was_taken_replaces_the_part_in_an_order_and_without_one() {
    ["brandt", ""].iter().for_each(|order| write_late(order));
}

fn write_late(order: &str) {
    let mut farm = patient_farm();
    let folder = farm.folder("inbox").join(order);
    fs::create_dir_all(&folder).unwrap();
    let mut writer = fs::File::create(folder.join("bodies.stl")).unwrap();
    writer.write_all(body(0.0).as_bytes()).unwrap();
    let first = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(first.measures.triangles, Some(4));
    farm.pass_until("its original is removed", |farm| {
        intake::files_below(&farm.folder("inbox").join(".claimed")).unwrap().is_empty()
    });
    writer.write_all(body(20.0).as_bytes()).unwrap();
    farm.wait_for_parts(PartState::Refused, 1);
    let whole = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(whole.measures.triangles, Some(8));
    assert!(whole.warnings.contains("More was written into this file"), "{}", whole.warnings);
    assert_eq!(farm.parts(PartState::Refused)[0].owed.replaced_by, Some(whole.id));
    drop(writer);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_binary_stl_that_ends_in_zeros_waits_and_is_refused_by_that_word() {
    let mut farm = patient_farm();
    let mut bytes = crate::driven_tests::stl(&crate::driven_tests::block(10.0, 12.0, 14.0));
    let facets = bytes[84..].to_vec();
    bytes.extend(vec![0; facets.len()]);
    bytes[80..84].copy_from_slice(&24_u32.to_le_bytes());
    farm.drop_bytes("half.stl", &bytes);
    farm.pass_secs(30.0);
    assert!(farm.parts(PartState::Waiting).is_empty() && farm.parts(PartState::Refused).is_empty(), "it waits");
    let refused = farm.wait_for_parts(PartState::Refused, 1).remove(0);
    assert!(refused.refused.reason.contains("unfinished copy"), "{}", refused.refused.reason);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn items_in_one_place_wait_for_a_yes() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("nuts.3mf", &stacked_project(3));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert!(part.owed.question.contains("3 of its 3 build items lie in one place"), "{}", part.owed.question);
    farm.pass_until("it is asked", |farm| farm.has_alert(AlertKind::Question));
    farm.pass_secs(600.0);
    assert!(farm.queued().is_empty(), "nothing is printed unasked");
    assert_eq!(farm.order_and_wait(CommandKind::Confirm, Some(part.id)).state, CommandState::Done);
    farm.pass_until("nobody is asked any more", |farm| !farm.has_alert(AlertKind::Question));
    farm.assert_nothing_lost_or_doubled();
}

/// A package with so many build items of one object in one place.
fn stacked_project(items: usize) -> Vec<u8> {
    let model = format!(
        r#"<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" name="nut"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="9" y="0" z="0"/><vertex x="0" y="9" z="0"/><vertex x="0" y="0" z="9"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh></object></resources><build>{}</build></model>"#,
        r#"<item objectid="1"/>"#.repeat(items)
    );
    let relationships = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, text) in [("_rels/.rels", relationships), ("3D/3dmodel.model", model.as_str())] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}
