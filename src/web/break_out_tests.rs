//! Breaking a build out, with the forms as a browser without JavaScript sends them.

use axum::http::{Request, StatusCode};
use ledger::{BuildId, BuildState, PartId, PartState};

use super::{TestDashboard, TestResponse, with_a_build};

const PAGE: &str = "/builds/1/break-out";
/// The cookies of three devices.
const DEVICES: [&str; 3] = [
    "nestd_device=00000000000000000000000000000001",
    "nestd_device=00000000000000000000000000000002",
    "nestd_device=00000000000000000000000000000003",
];

/// What a device is shown.
async fn look(dashboard: &TestDashboard, path: &str, device: &str) -> TestResponse {
    let request = Request::get(path).header("host", "localhost").header("cookie", device);
    dashboard.send(request.body(axum::body::Body::empty()).unwrap()).await
}

/// The page as the first device is shown it.
async fn page_of_first(dashboard: &TestDashboard, path: &str) -> String {
    look(dashboard, path, DEVICES[0]).await.text
}

async fn post(dashboard: &TestDashboard, path: &str, form: &str, cookie: &str) -> TestResponse {
    let request = Request::post(path).header("sec-fetch-site", "same-origin").header("cookie", cookie);
    dashboard.send_form(request, form).await
}

async fn say(dashboard: &TestDashboard, copy: u32, mark: &str, cookie: &str) -> TestResponse {
    let card = page_of_first(dashboard, &format!("{PAGE}?at={}", place_of(dashboard, copy).await)).await;
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
        let page = page_of_first(dashboard, &format!("{PAGE}?at={place}")).await;
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
    let page = page_of_first(&dashboard, PAGE).await;
    assert!(page.contains("0 of 2 copies") && page.contains("Who works here?"), "{page}");
    let first = copy_asked(&page);
    let named = post(&dashboard, "/name", &format!("key=key&name=Ann&back={PAGE}"), "").await;
    assert_eq!(named.status, StatusCode::SEE_OTHER);
    let before = dashboard.web.change_token().await.ok().unwrap();
    assert_eq!(say(&dashboard, first, "out", "nestd_name=Ann").await.status, StatusCode::SEE_OTHER);
    assert_ne!(dashboard.web.change_token().await.ok().unwrap(), before, "the other's page hears of it");
    let page = page_of_first(&dashboard, PAGE).await;
    assert!(page.contains("1 of 2 copies") && page.contains("by Ann,"), "{page}");
    let second = copy_asked(&page);
    assert_ne!(first, second, "the next copy is asked for");
    let twice = say(&dashboard, first, "out", "nestd_name=Ben").await.text;
    assert!(twice.contains("Said already") && twice.contains("Ann said so before"), "{twice}");
    say(&dashboard, second, "bad", "nestd_name=Ben").await;
    let page = page_of_first(&dashboard, PAGE).await;
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
    assert!(page_of_first(&dashboard, PAGE).await.contains("told bad"));
}

#[tokio::test]
async fn a_mark_is_undone_and_a_build_is_not_told_before_something_is_said_of_every_copy() {
    let dashboard = with_a_build("bracket.stl").await;
    say(&dashboard, 1, "bad", "").await;
    say(&dashboard, 1, "open", "").await;
    assert!(page_of_first(&dashboard, PAGE).await.contains("0 of 2 copies"));
    let early = post(&dashboard, &format!("{PAGE}/all"), "key=key", "").await.text;
    assert!(early.contains("Nobody said anything yet of 2 copies."), "{early}");
    let rest = post(&dashboard, &format!("{PAGE}/all"), "key=key&mark=missing", "").await;
    assert_eq!(rest.status, StatusCode::SEE_OTHER);
    assert!(page_of_first(&dashboard, PAGE).await.contains("2 not found, 0 in the cake"));
}

#[tokio::test]
async fn forms_without_the_key_or_for_unknown_copies_change_nothing() {
    let dashboard = with_a_build("bracket.stl").await;
    for (path, form) in [
        (PAGE, "key=x&part=1&copy=1&at=1&mark=out"),
        ("/builds/1/break-out/all", "key=x&mark=out"),
        ("/builds/1/break-out/undo", "key=x&first=1&last=1&at=1"),
        ("/name", "key=x&name=a&back=/"),
    ] {
        assert_eq!(post(&dashboard, path, form, "").await.status, StatusCode::FORBIDDEN, "{path}");
    }
    for form in ["key=key&part=1&copy=9&at=1&mark=out", "key=key&part=7&copy=1&at=1&mark=out"] {
        assert!(post(&dashboard, PAGE, form, "").await.text.contains("Refused"), "{form}");
    }
    assert!(page_of_first(&dashboard, PAGE).await.contains("0 of 2 copies"));
    assert_eq!(dashboard.get("/builds/7/break-out").await.status, StatusCode::NOT_FOUND);
    assert_eq!(dashboard.get("/builds/1/break-out?at=99").await.status, StatusCode::OK);
}

#[tokio::test]
async fn a_card_that_is_stale_overwrites_nothing_and_says_what_the_other_said() {
    let dashboard = with_a_build("bracket.stl").await;
    let stale = page_of_first(&dashboard, PAGE).await;
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
async fn each_device_is_shown_another_copy_and_the_last_ones_are_on_one_screen() {
    let dashboard = with_a_build("bracket.stl").await;
    let [first, second] = [DEVICES[0], DEVICES[1]].map(|device| async { look(&dashboard, PAGE, device).await.text });
    let (first, second) = (first.await, second.await);
    assert_ne!(copy_asked(&first), copy_asked(&second));
    let third = look(&dashboard, PAGE, DEVICES[2]).await.text;
    assert!(third.contains("The last 2 copies are on other screens") && !third.contains("name=\"part\""), "{third}");
    let chosen = look(&dashboard, &format!("{PAGE}?at=1"), DEVICES[2]).await.text;
    assert!(chosen.contains("Chosen: number 1,") && chosen.contains("It is on the screen of somebody."), "{chosen}");
    assert!(!chosen.contains("value=\"bad\"") && chosen.contains("I have it in hand"), "{chosen}");
    let before = dashboard.web.change_token().await.ok().unwrap();
    let taken = look(&dashboard, &format!("{PAGE}?take=1"), DEVICES[2]).await;
    assert_eq!((taken.status, taken.location.as_str()), (StatusCode::SEE_OTHER, "/builds/1/break-out?at=1"));
    assert_ne!(dashboard.web.change_token().await.ok().unwrap(), before, "whose it was hears of it");
    assert!(look(&dashboard, &taken.location, DEVICES[2]).await.text.contains("value=\"bad\""));
    let moved = look(&dashboard, PAGE, DEVICES[0]).await.text;
    assert!(moved.contains("The last 2 copies are on other screens"), "{moved}");
}

#[tokio::test]
async fn a_press_shows_the_next_copy_and_a_passed_copy_comes_round_again() {
    let dashboard = with_a_build("bracket.stl").await;
    let first = copy_asked(&page_of_first(&dashboard, PAGE).await);
    let passed = page_of_first(&dashboard, &format!("{PAGE}?after=1")).await;
    assert_ne!(copy_asked(&passed), first);
    let pressed = say_seeing(&dashboard, &passed, (copy_asked(&passed), "missing"), DEVICES[0]).await;
    assert!(pressed.location.contains("?after="), "{}", pressed.location);
    assert_eq!(copy_asked(&page_of_first(&dashboard, &pressed.location).await), first);
}

#[tokio::test]
async fn a_tray_is_told_and_undone_in_one_press_each() {
    let dashboard = with_a_build("bracket.stl").await;
    say(&dashboard, 2, "bad", "nestd_name=Ben").await;
    let all = format!("{PAGE}/all");
    let told = post(&dashboard, &all, "key=key&mark=out&numbers=1-2&after=1", "nestd_name=Ann").await.text;
    assert!(
        told.contains("1 copy is recorded as out.") && told.contains("is out and bad, as Ben said before."),
        "{told}"
    );
    say(&dashboard, 2, "open", "nestd_name=Ben").await;
    say(&dashboard, 1, "open", "nestd_name=Ben").await;
    let told = post(&dashboard, &all, "key=key&mark=out&numbers=1-2&after=1", "nestd_name=Ann").await;
    assert_eq!(told.location, "/builds/1/break-out?after=1");
    let page = look(&dashboard, PAGE, &format!("{}; nestd_name=Ann", DEVICES[0])).await.text;
    assert!(page.contains("Last: 2 copies, out, by Ann") && page.contains("Undo all 2"), "{page}");
    let ids: Vec<i64> = dashboard.ledger.picks_of_build(BuildId(1)).await.unwrap().iter().map(|row| row.id).collect();
    let undo = format!("key=key&first={}&last={}&at=1", ids[0], ids[1]);
    let undone = post(&dashboard, &format!("{PAGE}/undo"), &undo, "nestd_name=Ann").await;
    assert_eq!(undone.location, "/builds/1/break-out?at=1");
    assert!(dashboard.ledger.picks_of_build(BuildId(1)).await.unwrap().is_empty());
    let again = post(&dashboard, &format!("{PAGE}/undo"), &undo, "nestd_name=Ann").await.text;
    assert!(again.contains("Nothing to take back"), "{again}");
    for wrong in ["0-1", "1-3", "x"] {
        let refused = post(&dashboard, &all, &format!("key=key&mark=out&numbers={wrong}"), "").await.text;
        assert!(refused.contains("These are no copies of this build."), "{wrong}: {refused}");
    }
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
