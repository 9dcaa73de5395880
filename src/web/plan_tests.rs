//! Tests of the page and the JSON of the plan.

use super::*;
use crate::ledger::fixtures::*;

async fn json_of(dashboard: &TestDashboard, path: &str) -> serde_json::Value {
    serde_json::from_str(&dashboard.get(path).await.text).unwrap()
}

#[tokio::test]
async fn the_plan_lists_the_builds_to_come_and_what_puts_a_date_at_risk() {
    let dashboard = TestDashboard::new(|web| {
        let mut settings = crate::settings::Settings::clone(&web.current_settings());
        let profile =
            crate::settings::MachineProfile { name: "paper-200".to_owned(), ..settings.profiles["cube"].clone() };
        settings.profiles.insert(profile.name.clone(), profile);
        web.settings = Arc::new(RwLock::new(Arc::new(settings)));
    })
    .await;
    let part = asked(new_part("a", 3), |terms| {
        terms.due_at = Some("2026-01-01T00:00:00Z".parse().unwrap());
        "A-7".clone_into(&mut terms.order_name);
    });
    let part = dashboard.ledger.record_claim(&part).await.unwrap().id;
    dashboard.ledger.accept_solids(part, &[solid(0, 3)]).await.unwrap();
    let page = dashboard.get("/plan").await.text;
    assert!(page.contains("aria-current=\"page\">Plan") && page.contains("Due dates at risk"), "{page}");
    assert!(page.contains("A-7: a.stl") && page.contains("that date has passed"), "{page}");
    let plans = json_of(&dashboard, "/api/v1/plan").await;
    let plan = plans.as_array().unwrap().iter().find(|plan| plan["profile"] == "paper-200").unwrap();
    assert_eq!((&plan["builds"][0]["copies"], &plan["risks"][0]["cause"]), (&3.into(), &"passed".into()), "{plan}");
    assert_eq!(json_of(&dashboard, "/api/v1/plan?machine=cube").await.as_array().unwrap().len(), 1);
    assert_eq!(dashboard.get("/api/v1/plan?machine=none").await.status, StatusCode::NOT_FOUND);
}
