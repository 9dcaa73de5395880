//! Labels of a build and of an order, and the record of a part, as a browser asks for them.

use axum::http::StatusCode;
use ledger::{BuildId, PartEdit, PartId, PickMark, PrintOutcome, ToldOutcome};
use ledger_fixtures::ToldWords;
use serde_json::Value;

use super::with_a_build;

#[tokio::test]
async fn labels_of_a_build_and_of_an_order_are_pdfs_that_their_pages_lead_to() {
    let dashboard = with_a_build("bracket.stl").await;
    for path in [
        "/builds/1/labels.pdf",
        "/builds/1/labels.pdf?of=bags&sheet=roll-62",
        "/orders/bracket.stl/labels.pdf?sheet=letter-5160&used=3",
    ] {
        let answer = dashboard.get(path).await;
        assert_eq!(answer.status, StatusCode::OK, "{path}: {}", answer.text);
        assert!(answer.text.starts_with("%PDF-") && answer.text.trim_end().ends_with("%%EOF"), "{path}");
    }
    for page in ["/builds/1", "/builds/1/break-out"] {
        assert!(dashboard.get(page).await.text.contains("action=\"/builds/1/labels.pdf\""), "{page}");
    }
    assert!(dashboard.get("/orders/bracket.stl").await.text.contains("action=\"/orders/bracket.stl/labels.pdf\""));
    for (path, status) in [
        ("/builds/9/labels.pdf", StatusCode::NOT_FOUND),
        ("/orders/none/labels.pdf", StatusCode::NOT_FOUND),
        ("/builds/1/labels.pdf?sheet=a3", StatusCode::BAD_REQUEST),
    ] {
        assert_eq!(dashboard.get(path).await.status, status, "{path}");
    }
}

#[tokio::test]
async fn letters_that_no_font_has_are_named_instead_of_boxes_that_nobody_asked_for() {
    // Garay, of Unicode 16: fonts of servers do not have it, also where all of Noto is installed.
    let dashboard = with_a_build("\u{10d70}\u{10d71}.stl").await;
    let answer = dashboard.get("/builds/1/labels.pdf").await;
    assert!(answer.status == StatusCode::OK && answer.text.starts_with("<!DOCTYPE html>"), "{}", answer.text);
    assert!(answer.text.contains("\u{10d70}\u{10d71}") && answer.text.contains("fonts-noto-cjk"), "{}", answer.text);
    let anyway =
        answer.text.split("href=\"/builds/1/labels.pdf?").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let boxes = dashboard.get(&format!("/builds/1/labels.pdf?{}", anyway.replace("&amp;", "&"))).await;
    assert!(boxes.status == StatusCode::OK && boxes.text.starts_with("%PDF-"), "{}", boxes.text);
}

#[tokio::test]
async fn the_record_of_a_part_tells_how_each_copy_was_made_and_who_took_it_out() {
    let dashboard = with_a_build("bracket.stl").await;
    let (build, part) = (BuildId(1), PartId(1));
    dashboard.ledger.mark_pick(build, (part, 0), PickMark::Out, 0, "ann@farm").await.unwrap();
    let printed = ToldOutcome::new(PrintOutcome::Complete, "", "bob@farm");
    dashboard.ledger.record_outcome(build, &printed).await.unwrap();
    let record: serde_json::Value = serde_json::from_str(&dashboard.get("/api/v1/parts/1/record").await.text).unwrap();
    let row = dashboard.ledger.find_build(build).await.unwrap().unwrap();
    let made = &record["builds"][0];
    assert_eq!(record["part"]["part"], 1);
    assert_eq!(made["file_blake3"], row.staged.file_hash.unwrap());
    assert_eq!(made["told"]["told_by"], "bob@farm");
    let copy = &made["copies"][0];
    let said = [&copy["copy"], &copy["copy_state"], &copy["mark"], &copy["marked_by"]];
    assert_eq!(said.map(ToString::to_string), ["1", "\"good\"", "\"out\"", "\"ann@farm\""]);
    assert!(copy["translation_mm"].is_array() && copy["rotation_xyzw"].is_array(), "{copy}");
    let steps = PartEdit { finish: Some("dye black; smooth".to_owned()), ..PartEdit::default() };
    dashboard.ledger.edit_part(part, &steps, "ann@farm").await.unwrap();
    dashboard.ledger.tell_finished(part, "smooth", true, "cleo@farm").await.unwrap();
    let finishing = &serde_json::from_str::<serde_json::Value>(&dashboard.get("/api/v1/parts/1/record").await.text)
        .unwrap()["finishing"];
    assert_eq!(
        (&finishing[0]["done_by"], &finishing[1]["step"], &finishing[1]["done_by"]),
        (&Value::Null, &"smooth".into(), &"cleo@farm".into())
    );
    for path in ["/parts/1", "/orders/bracket.stl"] {
        let page = dashboard.get(path).await.text;
        assert!(page.contains("Done: 1 of 2") && page.contains("action=\"/parts/1/finish\""), "{path}");
    }
    let page = dashboard.get("/parts/1/record").await;
    for said in [
        "Record of part 1, bracket.stl",
        "ann@farm",
        "bob@farm",
        "as in the file",
        "/parts/1/record.pdf",
        "cleo@farm",
        "not done yet",
    ] {
        assert!(page.text.contains(said), "{said}: {}", page.text);
    }
    assert!(dashboard.get("/parts/1").await.text.contains("href=\"/parts/1/record\""));
    let pdf = dashboard.get("/parts/1/record.pdf").await;
    assert!(pdf.status == StatusCode::OK && pdf.text.starts_with("%PDF-"), "{}", pdf.text);
    for nothing in ["/parts/9/record", "/parts/9/record.pdf", "/api/v1/parts/9/record"] {
        assert_eq!(dashboard.get(nothing).await.status, StatusCode::NOT_FOUND, "{nothing}");
    }
}
