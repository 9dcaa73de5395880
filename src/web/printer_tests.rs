//! Tests of what the pages show of printers, and of builds that wait for a yes.

use ledger::{BuildId, OperatorWord};
use ledger_fixtures::*;
use settings::{ApprovalPolicy, MachineProfile, PrinterRules, Settings};

use super::*;

/// A dashboard with the machine of the ledger's fixtures: two printers, and every build waits for a yes.
async fn with_two_printers() -> TestDashboard {
    TestDashboard::new(|web| {
        let mut settings = Settings::clone(&web.current_settings());
        let mut profile = settings.profiles["cube"].clone();
        profile.name = "paper-200".to_owned();
        profile.printing.approve = ApprovalPolicy::Always;
        let printer = |name: &str| PrinterRules { name: name.to_owned(), ..profile.printers[0].clone() };
        profile.printers = vec![printer("left"), printer("right")];
        settings.profiles.insert(profile.name.clone(), profile);
        web.settings = Arc::new(RwLock::new(Arc::new(settings)));
    })
    .await
}

#[tokio::test]
async fn the_page_of_a_build_that_waits_for_a_yes_says_what_that_means_and_has_it_published() {
    let dashboard = with_two_printers().await;
    let ledger = &dashboard.ledger;
    let part = waiting(ledger, "a", 1).await;
    let build = nesting(ledger, &[(part, 0)]).await;
    ledger.assign_printer(build, "right").await.unwrap();
    ledger.verify_build(build, &verified(build, 1), &placed(&[(part, 0)])).await.unwrap();
    waiting(ledger, "b", 3).await;
    let page = dashboard.get("/builds/1").await.text;
    for words in
        ["It waits for a yes", "1 copy, 87.5 of 200 mm high", "On right it could begin", "3 copies wait", "Release it"]
    {
        assert!(page.contains(words), "{words}: {page}");
    }
    let request = Request::post("/builds/1/told").header("sec-fetch-site", "same-origin");
    let answer = dashboard.send_form(request, "key=key&act=release").await.text;
    assert!(answer.contains("Build 1 is released and goes to the queue."), "{answer}");
    let page = dashboard.get("/builds/1").await.text;
    assert!(!page.contains("Publish it") && page.contains("Released") && page.contains("right"), "{page}");
    let row = ledger.find_build(BuildId(1)).await.unwrap().unwrap();
    assert_eq!(row.place.released_by.as_deref(), Some("dashboard"));
}

/// Says a word as the command line does.
async fn say(dashboard: &TestDashboard, word: OperatorWord) {
    farm::operate(&dashboard.ledger, &dashboard.web.current_settings(), &word, "ann@farm", false).await.unwrap();
}

/// What a page and a program are told of the same word.
async fn told_by_page_and_program(dashboard: &TestDashboard) -> (String, serde_json::Value) {
    let page = Request::post("/builds/1/told").header("sec-fetch-site", "same-origin");
    let page = dashboard.send_form(page, "key=key&act=release").await.text;
    let program = Request::post("/api/v1/builds/1/release").header("content-type", "application/json");
    (page, door_tests::send(dashboard, program, "{}").await.json)
}

#[tokio::test]
async fn a_page_and_a_program_that_release_a_build_are_told_the_same() {
    let dashboard = with_two_printers().await;
    let ledger = &dashboard.ledger;
    let part = waiting(ledger, "a", 1).await;
    let build = nesting(ledger, &[(part, 0)]).await;
    ledger.verify_build(build, &verified(build, 1), &placed(&[(part, 0)])).await.unwrap();
    say(&dashboard, OperatorWord::Release { build, seen: None }).await;
    let (page, program) = told_by_page_and_program(&dashboard).await;
    assert!(page.contains("Build 1 was released before."), "{page}");
    assert_eq!(program["answers"], serde_json::json!(["Build 1 was released before."]));
}

#[tokio::test]
async fn nobody_releases_a_build_that_is_made_again_and_a_page_and_a_program_are_told_why() {
    let dashboard = with_two_printers().await;
    let ledger = &dashboard.ledger;
    let part = waiting(ledger, "a", 1).await;
    let build = nesting(ledger, &[(part, 0)]).await;
    let mut made = verified(build, 1);
    // The machine asks for more clearance now.
    let mut was = MachineProfile::clone(&dashboard.web.current_settings().profiles["paper-200"]);
    was.space.clearance_mm /= 2.0;
    made.profile_snapshot = serde_json::to_string(&was).unwrap();
    ledger.verify_build(build, &made, &placed(&[(part, 0)])).await.unwrap();
    let (page, program) = told_by_page_and_program(&dashboard).await;
    let told = "build 1 is not released: it is made again, for";
    assert!(page.contains(told), "{page}");
    assert!(program["detail"].as_str().unwrap().starts_with(told), "{program}");
    assert_eq!(ledger.find_build(build).await.unwrap().unwrap().place.released_at, None);
}

#[tokio::test]
async fn the_farm_page_and_the_json_show_each_printer_of_a_machine_and_why_one_is_down() {
    let dashboard = with_two_printers().await;
    let (machine_name, printer, reason) = ("paper-200".to_owned(), "left".to_owned(), "its laser".to_owned());
    say(&dashboard, OperatorWord::PrinterDown { machine: machine_name, printer, reason }).await;
    let page = dashboard.get("/").await.text;
    let lane = |printer: &str, doing: &str| {
        let (_, lane) = page.split_once(&format!("<b>{printer}</b>")).unwrap();
        assert!(lane.split("</p>").next().unwrap().contains(doing), "{printer} {doing}: {page}");
    };
    lane("left", "down since today ");
    lane("left", "by ann@farm: its laser.");
    lane("right", "free");
    assert!(page.contains("<h2>cube <span class=\"chip idle\"><i></i>free</span></h2>"), "{page}");
    assert!(!page.contains("<b>cube</b>"), "a printer alone has the name of its machine");
    let farm: serde_json::Value = serde_json::from_str(&dashboard.get("/api/v1/farm").await.text).unwrap();
    let printers = |name: &str| {
        let machines = farm["machines"].as_array().unwrap();
        machines.iter().find(|machine| machine["machine"] == name).unwrap()["printers"].clone()
    };
    assert_eq!(
        (&printers("paper-200")[0]["down"]["reason"], &printers("cube")[0]["printer"]),
        (&"its laser".into(), &"cube".into())
    );
}

#[tokio::test]
async fn a_printer_is_put_down_and_up_again_on_the_board() {
    let dashboard = with_two_printers().await;
    let down = async || dashboard.ledger.down_printers().await.unwrap();
    let form = "action=\"/machines/paper-200/printer\"";
    let board = dashboard.get("/").await.text;
    assert!(board.contains(form) && board.contains("<option>left</option><option>right</option>"), "{board}");
    let post = async |key: &str, fields: &[(&str, &str)]| {
        dashboard.post_to("/machines/paper-200/printer", &[&[("key", key)], fields].concat()).await
    };
    let told = post("key", &[("printer", "left"), ("state", "down"), ("reason", " its laser ")]).await.text;
    assert!(told.contains("The printer left is down") && told.contains("Undo"), "{told}");
    assert_eq!((down().await[0].printer.as_str(), down().await[0].reason.as_str()), ("left", "its laser"));
    let board = dashboard.get("/").await.text;
    assert!(board.contains("Put it into use again") && !board.contains("<option>left"), "{board}");
    let told = post("key", &[("printer", "left"), ("state", "up")]).await.text;
    assert!(told.contains("takes builds again"), "{told}");
    assert_eq!(down().await, []);
    let nobody = post("key", &[("printer", "middle"), ("state", "down")]).await.status;
    assert_eq!(nobody, axum::http::StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn what_is_loaded_is_said_on_the_board_and_by_programs_and_a_part_says_why_it_waits() {
    let dashboard = with_two_printers().await;
    let ledger = &dashboard.ledger;
    let part = asked(new_part("a", 1), |terms| terms.material = "PA12".to_owned());
    let id = ledger.record_claim(&part).await.unwrap().id;
    ledger.accept_solids(id, &[solid(0, 1)]).await.unwrap();
    ledger.open_build("cube").await.unwrap();
    let told = dashboard.post_to("/machines/cube/load", &[("key", "key"), ("material", "pa 12")]).await.text;
    assert!(told.contains("pa 12 is loaded on cube now"), "{told}");
    let page = dashboard.get(&format!("/parts/{id}")).await.text;
    assert!(page.contains("nothing is loaded on paper-200") && page.contains("PA12 is loaded on cube."), "{page}");
    let board = dashboard.get("/").await.text;
    assert!(board.contains("pa 12 is loaded") && board.contains("1 copy waits for PA12"), "{board}");
    let program = Request::post("/api/v1/machines/paper-200/load").header("content-type", "application/json");
    let told = door_tests::send(&dashboard, program, r#"{"material": "PA 12"}"#).await.json;
    assert_eq!(told["answers"][0], "PA 12 is loaded on paper-200 now: its next build is made of that.");
    let json =
        async |path: &str| -> serde_json::Value { serde_json::from_str(&dashboard.get(path).await.text).unwrap() };
    let farm = json("/api/v1/farm").await;
    let machines = farm["machines"].as_array().unwrap();
    let paper = machines.iter().find(|machine| machine["machine"] == "paper-200").unwrap();
    assert_eq!((&paper["material"], &paper["awaiting"]), (&"PA 12".into(), &serde_json::json!([])));
    assert_eq!(json(&format!("/api/v1/parts/{id}")).await["part"]["awaits_material"], false);
    let nobody = dashboard.post_to("/machines/none/load", &[("key", "key"), ("material", "x")]).await.status;
    assert_eq!(nobody, axum::http::StatusCode::NOT_FOUND);
}
