//! A report is self-contained, loads nothing from other hosts, and shows names as text.

use std::sync::Arc;

use farm::{CakeCopy, CakePart};
use glam::{DQuat, DVec3};
use solids::Pose;

use super::*;

const NAMES: [&str; 4] =
    ["<script>alert(1)</script>.stl", "</script><img src=x onerror=alert(1)>.stl", "\"onload=\"x.stl", "a'b&amp;.stl"];

fn cake(name: &str) -> CakeContents {
    let mesh = Arc::new(sample_parts::ring(40.0, 28.0, 8.0));
    let standing = |copy| CakeCopy {
        copy,
        pose: Pose::new(DQuat::IDENTITY, DVec3::new(50.0, 50.0, 20.0 * copy as f64)),
        drawn: None,
    };
    let part = CakePart {
        reference: String::new(),
        finish: String::new(),
        part: 7,
        name: name.to_owned(),
        order: name.to_owned(),
        due: name.to_owned(),
        note: name.to_owned(),
        mesh: Some(mesh),
        copies: vec![standing(1), standing(2)],
    };
    CakeContents { volume_mm: DVec3::new(100.0, 100.0, 200.0), parts: vec![part] }
}

fn report(name: &str) -> String {
    let mut info = BuildMetadata::default();
    (info.heading.title, info.heading.machine) = (Some(name.to_owned()), Some(name.to_owned()));
    let cake = cake(name);
    HtmlReport { cake: &cake, source: ReportSource::File(Path::new("/nowhere/x.build.3mf"), &info) }.to_html().unwrap()
}

/// The text between two marks.
fn between<'t>(text: &'t str, before: &str, after: &str) -> &'t str {
    text.split_once(before).unwrap().1.split_once(after).unwrap().0
}

#[test]
fn it_carries_everything_and_asks_no_host() {
    let html = report("bracket.stl");
    let without_script = html.replace(SCRIPT, "");
    for asks in ["http:", "https:", "src=\"/", "href=", "url(", "@import", "<link", "<iframe"] {
        assert!(!without_script.contains(asks), "{asks}");
    }
    let policy = between(&html, "Content-Security-Policy\" content=\"", "\"");
    assert!(policy.starts_with("default-src 'none'") && !policy.contains("unsafe") && !policy.contains("connect-src"));
    let fetches: Vec<&str> = SCRIPT.split("http").skip(1).filter(|rest| !rest.starts_with("://www.w3.org/")).collect();
    assert!(fetches.is_empty(), "the view names another host: {:?}", fetches[0].get(..60));
    assert!(html.contains("bracket.stl") && html.contains("48.0"));
}

#[test]
fn its_scene_is_the_one_that_the_view_reads() {
    let html = report("bracket.stl");
    let scene = STANDARD.decode(between(&html, "id=\"scene\" type=\"text/plain\">", "</script>")).unwrap();
    let length = u32::from_le_bytes(scene[..4].try_into().unwrap()) as usize;
    let text: serde_json::Value = serde_json::from_slice(&scene[4..4 + length]).unwrap();
    assert_eq!(text["meshes"][0]["copies"].as_array().unwrap().len(), 2);
    assert_eq!((&text["volume_mm"][2], &text["height_mm"]), (&200.0.into(), &48.0.into()));
    let mesh = |what: &str| text["meshes"][0][what].as_u64().unwrap() as usize;
    assert_eq!(scene.len(), 4 + length + 6 * (mesh("vertices") + mesh("triangles")));
}

#[test]
fn a_name_that_is_code_is_text() {
    for name in NAMES {
        let html = report(name);
        let without_ours = html.replace(SCRIPT, "");
        assert_eq!(without_ours.matches("<script").count(), 3, "{name}: only the texts, the scene and the view");
        assert_eq!(without_ours.matches("</script").count(), 3, "{name}");
        assert!(!without_ours.contains("<img src=x") && !without_ours.contains("\"onload=\""), "{name}");
    }
}

#[test]
fn what_is_put_in_whole_ends_no_element() {
    assert!(!SCRIPT.contains("</script") && !SCRIPT.contains("<!--") && !STYLE.contains("</style"));
}

#[test]
fn parts_whose_originals_are_gone_are_reported() {
    let mut cake = cake("gone.stl");
    cake.parts[0].mesh = None;
    let info = BuildMetadata::default();
    let html = HtmlReport { cake: &cake, source: ReportSource::File(Path::new("x.3mf"), &info) }.to_html().unwrap();
    assert!(html.contains("1 part is not shown"));
}
