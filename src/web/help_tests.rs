//! The book as a browser asks for it.

use axum::http::StatusCode;

use super::TestDashboard;

#[tokio::test]
async fn the_contents_lead_to_every_chapter_and_each_is_a_whole_page() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let contents = dashboard.get("/help").await.text;
    let links = contents.split("href=\"/help/").skip(1).filter_map(|rest| rest.split(['"', '#']).next());
    let chapters: std::collections::BTreeSet<&str> = links.collect();
    assert!(chapters.len() > 10, "{chapters:?}");
    for chapter in chapters {
        let page = dashboard.get(&format!("/help/{chapter}")).await;
        assert_eq!(page.status, StatusCode::OK, "{chapter}");
        assert!(page.text.contains("</html>") && page.policy.contains("default-src 'none'"), "{chapter}");
        assert_eq!(page.text.matches("<h1").count(), 1, "{chapter}");
        assert!(page.text.contains("aria-current=\"page\">Help</a>"), "{chapter}");
        assert!(page.text.len() < 300_000, "{chapter}: {} bytes", page.text.len());
    }
    assert_eq!(dashboard.get("/help/none").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn a_search_in_the_book_shows_marked_pieces_and_links_and_a_question_is_text() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let found = dashboard.get("/help?q=paused+withdraw").await.text;
    assert!(found.contains("href=\"/help/symptoms#status-says-paused\""), "{found}");
    assert!(found.contains("<mark>") && found.contains("value=\"paused withdraw\""), "{found}");
    let none = dashboard.get("/help?q=%3Cscript%3Ezyzzyva").await.text;
    assert!(none.contains("No section of the book") && !none.contains("<script>zy"), "{none}");
}
