//! Labels of a build and of an order, as a browser asks for them.

use axum::http::StatusCode;

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
