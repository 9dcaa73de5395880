//! The order of a pick map, and what it shows when the order is unknown.

use glam::{DQuat, DVec3};
use nester::RemovedCopy;
use solids::Pose;

use super::*;
use crate::web::figures::search_report::ReportExcerpt;

/// A cake of two parts: two copies of one, and one copy of the other, whose original may be missing.
fn cake(is_kept: bool) -> CakeContents {
    let at =
        |copy: u32, z: f64| CakeCopy { copy, pose: Pose::new(DQuat::IDENTITY, DVec3::new(50.0, 50.0, z)), drawn: None };
    let part = |number: i64, name: &str, mesh, copies| CakePart {
        reference: String::new(),
        finish: String::new(),
        part: number,
        name: name.to_owned(),
        order: String::new(),
        due: String::new(),
        note: String::new(),
        mesh,
        copies,
    };
    let ring = std::sync::Arc::new(sample_parts::ring(40.0, 28.0, 8.0));
    let other = is_kept.then(|| ring.clone());
    let parts = vec![
        part(1, "low.3mf (ring)", Some(ring), vec![at(1, 10.0), at(2, 30.0)]),
        part(2, "h<i>gh.stl", other, vec![at(1, 60.0)]),
    ];
    CakeContents { volume_mm: DVec3::new(100.0, 100.0, 100.0), parts }
}

fn removed_copy(part: &str, copy: u32, direction: [f64; 3]) -> RemovedCopy {
    RemovedCopy { part: part.to_owned(), copy, direction }
}

/// The map of a cake with the removal order of a report.
fn map_with(mut cake: CakeContents, order: &[RemovedCopy]) -> String {
    ReportExcerpt { order: order.to_vec(), ..ReportExcerpt::default() }.mark_removal_order(&mut cake);
    let (picks, is_proved) = picks_in_order(&cake);
    map_sheets(&cake, (&picks, is_proved), true).into_string()
}

/// The position of each text in a page.
fn places<const N: usize>(page: &str, texts: [&str; N]) -> [usize; N] {
    texts.map(|text| page.find(text).unwrap_or_else(|| panic!("{text} is not in {page}")))
}

#[test]
fn copies_come_in_the_proved_order_where_it_names_them_all_and_else_by_height() {
    let rows = ["/parts/2\"", "/parts/1\""];
    let by_height = map_with(cake(true), &[]);
    assert!(by_height.contains("By height") && places(&by_height, rows)[0] < places(&by_height, rows)[1]);
    let directions = [[0.0, 0.0, 1.0], [0.9, 0.0, 0.4], [0.0, -1.0, 0.0]];
    let order = [
        removed_copy("low.3mf", 1, directions[0]),
        removed_copy("low.3mf", 0, directions[1]),
        removed_copy("h_i_gh.stl", 0, directions[2]),
    ];
    let proved = map_with(cake(true), &order);
    assert!(proved.contains("proved on the triangles") && places(&proved, rows)[1] < places(&proved, rows)[0]);
    let [up, right, front] = places(&proved, [">up</td>", ">up, right</td>", ">front</td>"]);
    assert!(up < right && right < front, "{proved}");
    for wrong in [&order[..2], &[order[0].clone(), order[0].clone(), order[2].clone()]] {
        assert!(map_with(cake(true), wrong).contains("By height"));
    }
}

#[test]
fn due_dates_and_notes_are_shown_as_text_where_a_copy_has_any() {
    let plain = map_with(cake(true), &[]);
    assert!(!plain.contains(">Due<") && !plain.contains(">Note<"), "{plain}");
    let mut cake = cake(true);
    (cake.parts[0].due, cake.parts[0].note) = ("2026-12-24".to_owned(), "nicht <b>strahlen</b>".to_owned());
    let map = map_with(cake.clone(), &[]);
    assert!(map.contains(">Due<") && map.contains(">2026-12-24</td>"), "{map}");
    assert!(map.contains(">Note<") && map.contains(">nicht &lt;b&gt;strahlen&lt;/b&gt;</td>"), "{map}");
    let list = CachedPickMap::from_cake(&cake, 7).list;
    let json = serde_json::to_value(&*list).unwrap();
    assert_eq!(
        (&json["copies"][2]["due"], &json["copies"][2]["note"]),
        (&"2026-12-24".into(), &"nicht <b>strahlen</b>".into())
    );
}

#[test]
fn a_map_with_ways_down_says_that_the_cake_is_lifted_first() {
    let map_to = |z: f64| {
        let direction = |z: f64| [(1.0 - z * z).sqrt(), 0.0, z];
        let order = [
            removed_copy("low.3mf", 1, direction(1.0)),
            removed_copy("low.3mf", 0, direction(z)),
            removed_copy("h_i_gh.stl", 0, direction(0.0)),
        ];
        map_with(cake(true), &order)
    };
    assert_eq!(map_to(-0.6).matches("come out when the cake is lifted or turned").count(), 1);
    assert!([0.6, 0.0, -0.1].iter().all(|&z| !map_to(z).contains("lifted")));
}

#[test]
fn a_copy_whose_original_is_gone_has_dashes_and_no_place() {
    let page = map_with(cake(false), &[]);
    assert!(page.contains("1 part is listed without a place") && page.contains("Originals no longer kept"));
    let gone = page.rsplit("<tr>").next().unwrap();
    assert!(gone.contains("h&lt;i&gt;gh.stl") && gone.matches('\u{2013}').count() >= 4, "{gone}");
}

/// Copies of all sample parts, each turned in its own way, on a machine of 380 x 284 mm.
fn large_cake(copies: u32) -> CakeContents {
    let samples = sample_parts::all_samples();
    let turned = |number: u32| {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, f64::from(number) * 0.7, f64::from(number) * 1.3, 0.4);
        let place = DVec3::new(f64::from(number * 37 % 300), f64::from(number * 53 % 220), f64::from(number));
        CakeCopy { copy: 1 + number, pose: Pose::new(turn, 40.0 + place), drawn: None }
    };
    let part = |(at, sample): (usize, &sample_parts::SamplePart)| CakePart {
        reference: String::new(),
        finish: String::new(),
        part: 1000 + at as i64,
        name: format!("{}_left_rev{at}.stl", sample.name),
        order: format!("K-2026-{:04}", 1180 + at / 2),
        due: "2026-12-24".to_owned(),
        note: String::new(),
        mesh: Some(std::sync::Arc::new(sample.mesh.clone())),
        copies: (0..copies).filter(|number| *number as usize % samples.len() == at).map(turned).collect(),
    };
    CakeContents { volume_mm: DVec3::new(380.0, 284.0, 380.0), parts: samples.iter().enumerate().map(part).collect() }
}

#[test]
fn the_map_of_527_copies_takes_60_kilobytes_on_the_wire_at_most_and_24_sheets() {
    let mut cake = large_cake(527);
    for (position, copy) in (1..).zip(cake.parts.iter_mut().flat_map(|part| &mut part.copies)) {
        copy.drawn = Some(RemovalStep { position, direction: [0.0, 0.6, 0.8] });
    }
    let map = CachedPickMap::from_cake(&cake, 7);
    let page = crate::web::base::page::html_page("Pick map of build 7", "", None, &map.sheets).into_string();
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut encoder, page.as_bytes()).unwrap();
    let bytes = encoder.finish().unwrap().len();
    assert!(bytes <= 60_000, "{bytes} bytes of {}", page.len());
    assert!(page.matches("<section class=\"band").count() <= 24);
}
