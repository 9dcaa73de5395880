//! Tests of the page and the JSON of the plan.

use ledger_fixtures::*;

use super::*;

async fn json_of(dashboard: &TestDashboard, path: &str) -> serde_json::Value {
    serde_json::from_str(&dashboard.get(path).await.text).unwrap()
}

#[tokio::test]
async fn the_plan_lists_the_builds_to_come_and_what_puts_a_date_at_risk() {
    let dashboard = TestDashboard::new(|web| {
        let mut settings = settings::Settings::clone(&web.current_settings());
        let profile = settings::MachineProfile { name: "paper-200".to_owned(), ..settings.profiles["cube"].clone() };
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
    assert_eq!(dashboard.get("/plan").await.location, "/", "the board shows the plans");
    let page = dashboard.get("/").await.text;
    let (_, risks) = page.split_once("id=\"risks\"").unwrap();
    let (risks, board) = risks.split_once("</section>").unwrap();
    assert!(risks.contains("A-7: a.stl") && risks.contains("that date has passed"), "{risks}");
    let bar = board.split("<li ").find(|entry| entry.starts_with("class=\"wrong dashed\"")).unwrap();
    assert!(
        bar.contains("A build to come on cube: later")
            && bar.contains("3 copies")
            && bar.contains("a due date is late"),
        "{bar}"
    );
    let plans = json_of(&dashboard, "/api/v1/plan").await;
    let plan = plans.as_array().unwrap().iter().find(|plan| plan["machine"] == "paper-200").unwrap();
    assert_eq!((&plan["builds"][0]["copies"], &plan["risks"][0]["cause"]), (&3.into(), &"passed".into()), "{plan}");
    assert_eq!(json_of(&dashboard, "/api/v1/plan?machine=cube").await.as_array().unwrap().len(), 1);
    assert_eq!(dashboard.get("/api/v1/plan?machine=none").await.status, StatusCode::NOT_FOUND);
}

/// Asks for a quote.
async fn ask_quote(dashboard: &TestDashboard, kind: &str, body: String) -> (StatusCode, serde_json::Value) {
    let request = Request::post("/api/v1/quote").header("host", "localhost:7878").header("content-type", kind);
    let answer = dashboard.send(request.body(Body::from(body)).unwrap()).await;
    (answer.status, serde_json::from_str(&answer.text).unwrap())
}

/// A form with a document and a file.
fn quote_form(asked: &str, name: &str, content: &str) -> String {
    let field = |head: &str, text: &str| format!("--b\r\ncontent-disposition: form-data; {head}\r\n\r\n{text}\r\n");
    let file = field(&format!("name=\"file\"; filename=\"{name}\""), content);
    field("name=\"quote\"", asked) + &file + "--b--\r\n"
}

#[tokio::test]
async fn a_quote_that_cannot_be_made_says_why_and_one_too_many_is_asked_to_come_again() {
    let dashboard = TestDashboard::new(|_| {}).await;
    let json = "application/json";
    for (asked, why) in [
        ("{\"machine\": \"none\", \"lines\": []}", "there is no machine none"),
        ("{\"machine\": \"cube\", \"lines\": []}", "a quote has 1 to 500 lines"),
        ("{\"machine\": \"cube\", \"lines\": [{\"copies\": 2}]}", "missing field `name`"),
        ("{\"machine\": \"cube\", \"lines\": [{\"name\": \"a.stl\", \"content\": \"x\"}]}", "it must be a BLAKE3"),
        ("{\"machine\": \"cube\", \"lines\": [{\"name\": \"a.stl\"}]}", "line 1 (a.stl): it names no content"),
        ("{\"machine\": \"cube\", \"due\": \"soon\", \"lines\": [{\"name\": \"a.stl\"}]}", "date"),
        ("{\"machine\": \"cube\", \"lines\": [{\"name\": \"a.stl\", \"unit\": \"parsec\"}]}", "parsec"),
        ("{\"machine\": \"cube\", \"lines\": [{\"name\": \"a.stl\", \"prize\": 1}]}", "prize"),
    ] {
        let (status, answer) = ask_quote(&dashboard, json, asked.to_owned()).await;
        assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{asked}: {answer}");
        assert!(answer.to_string().contains(why), "{asked}: {answer}");
    }
    let places: Vec<_> = (0..2).map_while(|_| dashboard.web.quote_slots.clone().try_acquire_owned().ok()).collect();
    let (status, _) = ask_quote(&dashboard, json, "{}".to_owned()).await;
    assert_eq!((places.len(), status), (2, StatusCode::TOO_MANY_REQUESTS));
    drop(places);
    let form = quote_form(
        "{\"machine\": \"cube\", \"lines\": [{\"name\": \"a.stl\"}, {\"name\": \"b.stl\"}]}",
        "a.stl",
        "solid",
    );
    let (status, answer) = ask_quote(&dashboard, "multipart/form-data; boundary=b", form).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{answer}");
    assert!(
        answer.to_string().contains("line 2 (b.stl): it names no content, and no file of that name came"),
        "{answer}"
    );
}
