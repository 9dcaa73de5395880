//! Tests of what the pages show of printers, and of builds that wait for a yes.

use ledger::BuildId;
use ledger_fixtures::*;

use super::*;
use crate::settings::{ApprovalPolicy, PrinterRules, Settings};

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
        ["It waits for a yes", "1 copy, 87.5 of 200 mm high", "On right it could begin", "3 copies wait", "Publish it"]
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

#[tokio::test]
async fn the_farm_page_and_the_json_show_each_printer_of_a_machine_and_why_one_is_down() {
    let dashboard = with_two_printers().await;
    dashboard.ledger.take_printer_down("left", "paper-200", "ann@farm", "its laser").await.unwrap();
    let page = dashboard.get("/").await.text;
    assert!(page.contains("Printer <b>left</b>: down since") && page.contains("by ann@farm: its laser."), "{page}");
    assert!(page.contains("Printer <b>right</b>: 0 builds, free now"), "{page}");
    assert!(!page.contains("Printer <b>cube</b>"), "one printer in use is no news");
    let farm: serde_json::Value = serde_json::from_str(&dashboard.get("/api/v1/farm").await.text).unwrap();
    let printers = |name: &str| {
        let machines = farm["profiles"].as_array().unwrap();
        machines.iter().find(|machine| machine["profile"] == name).unwrap()["printers"].clone()
    };
    assert_eq!(
        (&printers("paper-200")[0]["down"]["reason"], &printers("cube")[0]["printer"]),
        (&"its laser".into(), &"cube".into())
    );
}
