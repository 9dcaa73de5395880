//! Build items that belong together, or were stacked in one place, are asked about.

use super::test_package::{boxes, model, read_package};

/// A box: name, size, places.
type PlacedBox<'a> = (&'a str, [f64; 3], &'a [[f64; 3]]);

/// The questions of the solids of a package with boxes.
fn questions(parts: &[PlacedBox]) -> Vec<Option<String>> {
    let (mut resources, mut build) = (String::new(), String::new());
    for (at, (name, size, places)) in parts.iter().enumerate() {
        let id = at + 1;
        resources += &format!(r#"<object id="{id}" name="{name}">{}</object>"#, boxes(&[*size]));
        for [x, y, z] in *places {
            build += &format!(r#"<item objectid="{id}" transform="1 0 0 0 1 0 0 0 1 {x} {y} {z}"/>"#);
        }
    }
    let contents = read_package(&[("3D/3dmodel.model", &model(&resources, &build))]).unwrap();
    contents.solids.into_iter().map(|solid| solid.question).collect()
}

const CUBE: [f64; 3] = [10.0; 3];

#[test]
fn items_apart_are_parts_without_a_question() {
    let arranged = questions(&[
        ("a", CUBE, &[[0.0; 3], [11.0, 0.0, 0.0], [0.0, 11.0, 0.0]]),
        ("b", [100.0, 1.0, 1.0], &[[0.0, -5.0, 0.0]]),
    ]);
    assert_eq!(arranged, [None, None]);
    assert_eq!(questions(&[("a", CUBE, &[[5.0; 3]])]), [None]);
}

#[test]
fn items_that_touch_or_pass_through_each_other_are_asked_about() {
    for place in [[10.0, 0.0, 0.0], [5.0, 5.0, 5.0], [10.2, 3.0, 0.0]] {
        let asked = questions(&[("housing", CUBE, &[[0.0; 3]]), ("lid", CUBE, &[place]), ("far", CUBE, &[[50.0; 3]])]);
        let [Some(housing), Some(lid), None] = &asked[..] else { panic!("{place:?}: {asked:?}") };
        assert!(housing.contains("touches or passes through \"lid\"") && lid.contains("\"housing\""), "{asked:?}");
    }
    let copies = questions(&[("a", CUBE, &[[0.0; 3], [0.0, 0.0, 10.0]])]);
    assert!(copies[0].as_ref().unwrap().contains("another copy of itself"), "{copies:?}");
}

#[test]
fn an_item_inside_another_is_asked_about() {
    let asked = questions(&[("shell", CUBE, &[[0.0; 3]]), ("core", [2.0; 3], &[[4.0; 3]])]);
    assert!(asked.iter().all(Option::is_some), "{asked:?}");
}

#[test]
fn copies_stacked_in_one_place_are_asked_about() {
    let stacked = [[0.0; 3]; 150];
    let asked = questions(&[("nut", CUBE, &stacked), ("washer", CUBE, &[[40.0; 3]])]);
    let [Some(nut), None] = &asked[..] else { panic!("{asked:?}") };
    assert!(nut.contains("150 of its 150 build items lie in one place"), "{nut}");
}

#[test]
fn the_boxes_alone_are_no_contact() {
    // An L of two bars as one object, and a cube in the corner of the L.
    let bars = r#"<object id="1" name="bar">BAR</object><object id="2" name="post">POST</object><object id="3" name="L"><components><component objectid="1"/><component objectid="2"/></components></object><object id="4" name="cube">CUBE</object>"#;
    let bars = bars
        .replace("BAR", &boxes(&[[50.0, 5.0, 5.0]]))
        .replace("POST", &boxes(&[[5.0, 50.0, 5.0]]))
        .replace("CUBE", &boxes(&[CUBE]));
    let build = r#"<item objectid="3"/><item objectid="4" transform="1 0 0 0 1 0 0 0 1 20 20 0"/>"#;
    let contents = read_package(&[("3D/3dmodel.model", &model(&bars, build))]).unwrap();
    assert!(contents.solids.iter().all(|solid| solid.question.is_none()), "{contents:?}");
}
