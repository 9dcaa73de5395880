//! Breaking a build out, with the forms as a browser without JavaScript sends them.

use axum::http::{Request, StatusCode};
use ledger::{BuildId, BuildState, PartId, PartState};

use super::{TestDashboard, TestResponse, with_a_build};

const PAGE: &str = "/builds/1/break-out";

async fn post(dashboard: &TestDashboard, path: &str, form: &str, cookie: &str) -> TestResponse {
    let request = Request::post(path).header("sec-fetch-site", "same-origin").header("cookie", cookie);
    dashboard.send_form(request, form).await
}

async fn say(dashboard: &TestDashboard, copy: u32, mark: &str, cookie: &str) -> TestResponse {
    let card = dashboard.get(&format!("{PAGE}?at={}", place_of(dashboard, copy).await)).await.text;
    say_seeing(dashboard, &card, (copy, mark), cookie).await
}

/// Presses a button of a card that was shown a while ago.
async fn say_seeing(dashboard: &TestDashboard, card: &str, (copy, mark): (u32, &str), cookie: &str) -> TestResponse {
    let seen = card.split("class=\"card step\"").nth(1).and_then(|card| card.split("name=\"seen\" value=\"").nth(1));
    let seen = seen.and_then(|seen| seen.split('"').next()).unwrap_or("0");
    post(dashboard, PAGE, &format!("key=key&part=1&copy={copy}&at={copy}&seen={seen}&mark={mark}"), cookie).await
}

/// The place of a copy in the list.
async fn place_of(dashboard: &TestDashboard, copy: u32) -> u32 {
    for place in 1..=2 {
        let page = dashboard.get(&format!("{PAGE}?at={place}")).await.text;
        if page.split("class=\"card step\"").nth(1).is_some_and(|card| card.contains(&format!("Copy {copy}. "))) {
            return place;
        }
    }
    panic!("no card of copy {copy}")
}

/// The copy that the card asks about.
fn copy_asked(page: &str) -> u32 {
    let card = page.split("class=\"card step\"").nth(1).unwrap();
    card.split("name=\"copy\" value=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
}

#[tokio::test]
async fn two_people_break_a_build_out_and_what_is_bad_waits_again() {
    let dashboard = with_a_build("bracket.stl").await;
    let page = dashboard.get(PAGE).await.text;
    assert!(page.contains("0 of 2 copies") && page.contains("Who works here?"), "{page}");
    let first = copy_asked(&page);
    let named = post(&dashboard, "/name", &format!("key=key&name=Ann&back={PAGE}"), "").await;
    assert_eq!(named.status, StatusCode::SEE_OTHER);
    let before = dashboard.web.change_token().await.ok().unwrap();
    assert_eq!(say(&dashboard, first, "out", "nestd_name=Ann").await.status, StatusCode::SEE_OTHER);
    assert_ne!(dashboard.web.change_token().await.ok().unwrap(), before, "the other's page hears of it");
    let page = dashboard.get(PAGE).await.text;
    assert!(page.contains("1 of 2 copies") && page.contains("by Ann,"), "{page}");
    let second = copy_asked(&page);
    assert_ne!(first, second, "the next copy is asked for");
    let twice = say(&dashboard, first, "out", "nestd_name=Ben").await.text;
    assert!(twice.contains("Said already") && twice.contains("Ann said so before"), "{twice}");
    say(&dashboard, second, "bad", "nestd_name=Ben").await;
    let page = dashboard.get(PAGE).await.text;
    assert!(page.contains("The cake is empty") && page.contains("out and bad"), "{page}");
    let lies = post(&dashboard, &format!("{PAGE}/all"), "key=key", "nestd_name=Ann").await.text;
    assert!(lies.contains("lies untouched") && lies.contains("name=\"anyway\""), "{lies}");
    dashboard.printer_takes_it().await;
    let told = post(&dashboard, &format!("{PAGE}/all"), "key=key", "nestd_name=Ann").await.text;
    assert!(told.contains("Build 1 is broken out.") && told.contains("1 copy of 1 part waits again"), "{told}");
    let build = dashboard.ledger.find_build(BuildId(1)).await.unwrap().unwrap();
    let part = dashboard.ledger.find_part(PartId(1)).await.unwrap().unwrap();
    assert_eq!((build.state, part.state), (BuildState::Complete, PartState::Waiting));
    let placed = dashboard.ledger.placements_of_build(BuildId(1)).await.unwrap();
    let bad: Vec<u32> = placed.iter().filter(|row| row.is_bad).map(|row| row.copy + 1).collect();
    assert_eq!(bad, [second]);
    assert_eq!(dashboard.ledger.outcomes_of_build(BuildId(1)).await.unwrap()[0].told_by, "Ann@dashboard");
    assert!(dashboard.get(PAGE).await.text.contains("told bad"));
}

#[tokio::test]
async fn a_mark_is_undone_and_a_build_is_not_told_before_something_is_said_of_every_copy() {
    let dashboard = with_a_build("bracket.stl").await;
    say(&dashboard, 1, "bad", "").await;
    say(&dashboard, 1, "open", "").await;
    assert!(dashboard.get(PAGE).await.text.contains("0 of 2 copies"));
    let early = post(&dashboard, &format!("{PAGE}/all"), "key=key", "").await.text;
    assert!(early.contains("Nobody said anything yet of 2 copies."), "{early}");
    let rest = post(&dashboard, &format!("{PAGE}/all"), "key=key&mark=missing", "").await;
    assert_eq!(rest.status, StatusCode::SEE_OTHER);
    assert!(dashboard.get(PAGE).await.text.contains("2 not found, 0 in the cake"));
}

#[tokio::test]
async fn forms_without_the_key_or_for_unknown_copies_change_nothing() {
    let dashboard = with_a_build("bracket.stl").await;
    for (path, form) in [
        (PAGE, "key=x&part=1&copy=1&at=1&mark=out"),
        ("/builds/1/break-out/all", "key=x&mark=out"),
        ("/name", "key=x&name=a&back=/"),
    ] {
        assert_eq!(post(&dashboard, path, form, "").await.status, StatusCode::FORBIDDEN, "{path}");
    }
    for form in ["key=key&part=1&copy=9&at=1&mark=out", "key=key&part=7&copy=1&at=1&mark=out"] {
        assert!(post(&dashboard, PAGE, form, "").await.text.contains("Refused"), "{form}");
    }
    assert!(dashboard.get(PAGE).await.text.contains("0 of 2 copies"));
    assert_eq!(dashboard.get("/builds/7/break-out").await.status, StatusCode::NOT_FOUND);
    assert_eq!(dashboard.get("/builds/1/break-out?at=99").await.status, StatusCode::OK);
}

#[tokio::test]
async fn a_card_that_is_stale_overwrites_nothing_and_says_what_the_other_said() {
    let dashboard = with_a_build("bracket.stl").await;
    let stale = dashboard.get(PAGE).await.text;
    let copy = copy_asked(&stale);
    say(&dashboard, copy, "bad", "nestd_name=Ann").await;
    let late = say_seeing(&dashboard, &stale, (copy, "out"), "nestd_name=Ben").await.text;
    assert!(late.contains("Not recorded") && late.contains("Ann said since"), "{late}");
    assert!(late.contains("that this copy is out and bad. That stays."), "{late}");
    assert_eq!(dashboard.ledger.picks_of_build(BuildId(1)).await.unwrap()[0].mark, ledger::PickMark::Bad);
    // Whoever looks again may say otherwise.
    say(&dashboard, copy, "open", "nestd_name=Ben").await;
    assert!(dashboard.ledger.picks_of_build(BuildId(1)).await.unwrap().is_empty());
}

#[tokio::test]
async fn what_is_waiting_with_a_due_date_changes_no_page_by_itself() {
    let dashboard = with_a_build("bracket.stl").await;
    let part = ledger_fixtures::asked(ledger_fixtures::new_part("dated", 3), |terms| {
        terms.due_at = Some("2099-01-01T00:00:00Z".parse().unwrap());
    });
    let part = dashboard.ledger.record_claim(&part).await.unwrap().id;
    dashboard.ledger.accept_solids(part, &[ledger_fixtures::solid(0, 3)]).await.unwrap();
    let before = dashboard.web.change_token().await.ok().unwrap();
    tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    assert_eq!(dashboard.web.change_token().await.ok().unwrap(), before);
}
