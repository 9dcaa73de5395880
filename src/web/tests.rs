//! The dashboard over a real ledger, with requests as a browser sends them.

use std::sync::{Arc, RwLock};

use axum::{
    body::{Body, to_bytes},
    http::{Request, StatusCode},
};
use ledger_fixtures::{self as fixtures, TestLedger, ToldWords};
use tokio::sync::{Semaphore, watch};
use tower::ServiceExt;

use super::{
    base::{
        cache::RecentCache,
        client_limits::{ClientLimits, ClientRates},
    },
    core::{
        form_keys::FormKeys,
        state::{DashboardState, PageCaches},
    },
    serve::server::build_router,
};

#[path = "api_tests.rs"]
mod api;
#[path = "asset_tests.rs"]
mod asset_tests;
#[path = "break_out_tests.rs"]
mod break_out_tests;
#[path = "door_limit_tests.rs"]
mod door_limit_tests;
#[path = "door_tests.rs"]
mod door_tests;
#[path = "drop_tests.rs"]
mod drop_tests;
#[path = "edit_tests.rs"]
mod edit_tests;
#[path = "form_tests.rs"]
mod form_tests;
#[path = "guard_tests.rs"]
mod guard;
#[path = "help_tests.rs"]
mod help_tests;
#[path = "order_tests.rs"]
mod order_tests;
#[path = "paper/paper_tests.rs"]
mod paper_tests;
#[path = "people/people_tests.rs"]
mod people_tests;
#[path = "plan_tests.rs"]
mod plan_tests;
#[path = "printer_tests.rs"]
mod printer_tests;
#[path = "serve/spoken_tests.rs"]
mod spoken_tests;

struct TestResponse {
    status: StatusCode,
    text: String,
    policy: String,
    /// Where the browser is led to; "" = nowhere.
    location: String,
}

/// A farm of one machine with a dashboard.
struct TestDashboard {
    ledger: TestLedger,
    web: Arc<DashboardState>,
    _folder: tempfile::TempDir,
}

impl TestDashboard {
    async fn new(change: impl FnOnce(&mut DashboardState)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let profiles = folder.path().join("profiles");
        std::fs::create_dir_all(&profiles).unwrap();
        std::fs::write(folder.path().join("nestd.toml"), "root = \"farm\"\n").unwrap();
        std::fs::write(profiles.join("cube.toml"), "volume_mm = [200, 200, 200]\n").unwrap();
        let settings = settings::load_settings(Some(&folder.path().join("nestd.toml")), Some(folder.path())).unwrap();
        let quote_meshes = farm::QuoteMeshes::of_farm(&settings);
        let ledger = fixtures::fresh().await;
        let mut web = DashboardState {
            ledger: (*ledger).clone(),
            farm: Default::default(),
            judged: Default::default(),
            settings: Arc::new(RwLock::new(Arc::new(settings))),
            is_tcp: true,
            hosts: Vec::new(),
            proxy: None,
            orders: true,
            limits: ClientLimits::new(ClientRates { per_sec: 1e6, burst: 1000, bytes: 1 << 40 }),
            clients: Default::default(),
            attempts: Default::default(),
            uploads: Default::default(),
            door: Default::default(),
            form_keys: FormKeys::of_farm(&ledger).await.unwrap(),
            caches: PageCaches {
                scenes: RecentCache::new(2),
                picks: RecentCache::new(2),
                pictures: RecentCache::new(2),
                parts: RecentCache::new(2),
            },
            metrics: Default::default(),
            render_slot: Arc::new(Semaphore::new(1)),
            upload_slots: Arc::new(Semaphore::new(1)),
            pass_slots: Arc::new(Semaphore::new(1)),
            listen_slots: Arc::new(Semaphore::new(1)),
            quote_slots: Arc::new(Semaphore::new(2)),
            quote_meshes,
            changes: watch::Sender::new(0),
            shown: Default::default(),
            said: Default::default(),
        };
        change(&mut web);
        Self { ledger, web: Arc::new(web), _folder: folder }
    }

    async fn send(&self, request: Request<Body>) -> TestResponse {
        let answer = build_router(self.web.clone()).oneshot(request).await.unwrap();
        let status = answer.status();
        let header = |name| answer.headers().get(name).map_or_else(String::new, |v| v.to_str().unwrap().to_owned());
        let (policy, location) = (header("content-security-policy"), header("location"));
        let bytes = to_bytes(answer.into_body(), usize::MAX).await.unwrap();
        TestResponse { status, text: String::from_utf8_lossy(&bytes).into_owned(), policy, location }
    }

    async fn get(&self, path: &str) -> TestResponse {
        self.send(Request::get(path).header("host", "localhost:7878").body(Body::empty()).unwrap()).await
    }

    async fn post(&self, form: &str, site: &str) -> TestResponse {
        self.send_form(Request::post("/commands").header("sec-fetch-site", site), form).await
    }

    /// A form with the key of a page that is made now, where it says `key=key`.
    fn with_key(&self, form: &str) -> String {
        let key = format!("key={}", self.web.form_keys.make_key());
        form.split('&').map(|field| if field == "key=key" { key.as_str() } else { field }).collect::<Vec<_>>().join("&")
    }

    /// Sends a form; the text is that of the page to which the browser is led.
    async fn send_form(&self, request: axum::http::request::Builder, form: &str) -> TestResponse {
        let request = request.header("host", "localhost").header("content-type", "application/x-www-form-urlencoded");
        let mut answer = self.send(request.body(Body::from(self.with_key(form))).unwrap()).await;
        if answer.location.starts_with("/told/") {
            answer.text = self.get(&answer.location).await.text;
        }
        answer
    }
}

const PAGES: [&str; 20] = [
    "/",
    "/components",
    "/history",
    "/parts",
    "/builds/1",
    "/builds/1/pick",
    "/builds/1/break-out",
    "/parts/1",
    "/parts/1/record",
    "/orders",
    "/orders/bracket.stl",
    "/search?q=bracket",
    "/month",
    "/costs",
    "/costs?build=1",
    "/machines/cube/flush",
    "/machines/cube/drop",
    "/help",
    "/help?q=paused",
    "/sign-in",
];

async fn with_a_build(named: &str) -> TestDashboard {
    with_a_build_due(named, None).await
}

async fn with_a_build_due(named: &str, due_at: Option<jiff::Timestamp>) -> TestDashboard {
    let dashboard = TestDashboard::new(|_| ()).await;
    let part = ledger::NewPartRow {
        name: named.to_owned(),
        machine: "cube".to_owned(),
        ..fixtures::asked(fixtures::new_part("a", 2), |terms| {
            (terms.order_name, terms.note, terms.due_at) = (named.to_owned(), named.to_owned(), due_at);
        })
    };
    let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
    dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 2)]).await.unwrap();
    let build = dashboard.ledger.open_build("cube").await.unwrap().id;
    dashboard.ledger.begin_nesting(build, "flush", &[(id, 0), (id, 1)]).await.unwrap();
    dashboard.ledger.begin_attempt(build).await.unwrap();
    let placed = fixtures::placed(&[(id, 0), (id, 1)]);
    dashboard.ledger.verify_build(build, &fixtures::verified(build, 2), &placed).await.unwrap();
    dashboard.ledger.publish_build(build).await.unwrap();
    dashboard
}

impl TestDashboard {
    /// The printer of build 1 takes its file.
    async fn printer_takes_it(&self) {
        self.ledger.record_taken(ledger::BuildId(1), "queue").await.unwrap();
    }
}

#[tokio::test]
async fn every_page_is_whole_and_forbids_what_it_does_not_need() {
    let dashboard = with_a_build("bracket.stl").await;
    for page in PAGES {
        let asked = dashboard.get(page).await;
        assert_eq!(asked.status, StatusCode::OK, "{page}: {}", asked.text);
        assert!(asked.text.contains("</html>") && asked.text.contains("<main id=\"main\""), "{page}");
        assert!(asked.policy.contains("default-src 'none'") && !asked.policy.contains("unsafe"), "{page}");
        assert!(
            asked.text.len() < 300_000 && !asked.text.contains("http://") && !asked.text.contains("https://"),
            "{page}"
        );
    }
    assert!(dashboard.get("/builds/1").await.text.contains("bracket.stl"));
}

/// What a page says outside its folds and sheets.
fn said_text(page: &str) -> String {
    let mut text = String::new();
    for piece in page
        .split("<details")
        .flat_map(|piece| piece.split_once("</details>").map_or(piece, |(_, rest)| rest).split('<'))
    {
        text += piece.split_once('>').map_or("", |(_, said)| said);
        text.push(' ');
    }
    text
}

#[tokio::test]
async fn no_page_says_a_raw_word_or_an_exact_time_outside_its_details() {
    let dashboard = with_a_build("bracket.stl").await;
    let people = PAGES.iter().filter(|page| !page.contains("help"));
    for page in people {
        let main = dashboard.get(page).await.text;
        let text = said_text(main.split("<main").nth(1).unwrap_or_default());
        for word in text.split(|c: char| c.is_whitespace() || ",;:()".contains(c)) {
            let is_raw = word.contains('_') && !word.contains(".stl") || ["batched", "claimed"].contains(&word);
            let is_exact = word.len() == 8 && word.chars().filter(|c| *c == ':').count() == 2;
            assert!(!is_raw && !is_exact, "{page}: {word}");
        }
    }
}

#[tokio::test]
async fn a_part_whose_file_is_gone_has_a_picture_that_stands_for_it_and_a_build_its_files() {
    let dashboard = with_a_build("bracket.stl").await;
    let picture = dashboard.get("/parts/1/picture?width=80").await;
    assert!(picture.status == StatusCode::OK && picture.text.starts_with("<svg"), "{}", picture.text);
    assert_eq!(dashboard.get("/parts/9/picture").await.status, StatusCode::NOT_FOUND);
    let csv = dashboard.get("/builds/1/pick.csv").await;
    assert!(csv.status == StatusCode::OK && csv.text.starts_with("number,"), "{}", csv.text);
    let report = dashboard.get("/builds/1/report.html").await;
    assert!(report.status == StatusCode::OK && report.text.contains("Build 1 on cube"), "{}", report.status);
    assert_eq!(dashboard.get("/builds/1/file").await.status, StatusCode::NOT_FOUND, "its file is nowhere");
    let page = dashboard.get("/builds/1").await.text;
    assert!(page.contains("href=\"/builds/1/report.html\"") && !page.contains("href=\"/builds/1/file\""), "{page}");
}

#[tokio::test]
async fn a_name_that_is_code_is_shown_as_text() {
    for name in ["<script>alert(1)</script>.stl", "=HYPERLINK(\"x\").stl", "\"onload=\"x.stl", "a'b&amp;.stl"] {
        let dashboard = with_a_build(name).await;
        let order = super::base::query::order_address(name);
        assert_eq!(dashboard.get(&order).await.status, StatusCode::OK, "{order}");
        for page in PAGES.into_iter().chain([order.as_str()]) {
            let text = dashboard.get(page).await.text;
            assert!(!text.contains("<script>alert") && !text.contains("\"onload=\""), "{page} {name}");
        }
        let asked = format!("/parts?{}", serde_urlencoded::to_string([("name", name)]).unwrap());
        assert!(dashboard.get(&asked).await.text.contains("1 part<"), "{name} is found by its name");
    }
}

#[tokio::test]
async fn the_page_the_csv_and_the_json_of_the_history_show_the_same_builds() {
    let dashboard = with_a_build("bracket.stl").await;
    let rows = dashboard.ledger.read_history(&Default::default()).await.unwrap();
    let height = format!("{:.2}", rows[0].measures.height_mm.unwrap());
    assert!(dashboard.get("/history").await.text.contains(&height));
    let settings = dashboard.web.current_settings();
    let now = jiff::Timestamp::now();
    let rows = farm::DatedBuild::of_rows(&dashboard.ledger, settings.profiles.values(), rows, now).await.unwrap();
    let json: serde_json::Value = serde_json::from_str(&dashboard.get("/history.json").await.text).unwrap();
    assert_eq!(json, serde_json::to_value(&rows).unwrap());
    assert_eq!(
        dashboard.get("/history.csv").await.text,
        crate::tables::csv_of(crate::tables::HISTORY_COLUMNS, &rows).unwrap()
    );
    for (asked, builds) in
        [("machine=other", 0), ("part=bracket.stl", 1), ("part=x", 0), ("state=published", 1), ("state=failed", 0)]
    {
        let json = dashboard.get(&format!("/api/v1/builds?{asked}")).await.text;
        assert_eq!(serde_json::from_str::<Vec<serde_json::Value>>(&json).unwrap().len(), builds, "{asked}");
    }
    assert_eq!(dashboard.get("/history?since=yesterday").await.status, StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn a_recorded_outcome_changes_the_change_token_of_the_pages() {
    let dashboard = with_a_build("bracket.stl").await;
    let before = dashboard.web.change_token().await.ok().unwrap();
    assert_eq!(dashboard.web.change_token().await.ok().unwrap(), before);
    let printed = ledger::ToldOutcome::new(ledger::PrintOutcome::Complete, "", "me@here");
    dashboard.ledger.record_outcome(ledger::BuildId(1), &printed).await.unwrap();
    assert_ne!(dashboard.web.change_token().await.ok().unwrap(), before);
}

#[tokio::test]
async fn metrics_have_units_in_their_names_and_count_what_the_ledger_counts() {
    let dashboard = with_a_build("bracket.stl").await;
    let text = dashboard.get("/metrics").await.text;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        assert!(line.starts_with("nestd_"), "{line}");
        assert!(!line.contains("_mm"), "base units only: {line}");
    }
    assert!(text.contains("nestd_files_ingested_total{machine=\"cube\"} 1"), "{text}");
    assert!(text.contains("nestd_build_height_meters_count{machine=\"cube\"} 1"), "{text}");
}

#[tokio::test]
async fn the_farm_is_not_ready_while_no_daemon_beats() {
    let dashboard = TestDashboard::new(|_| ()).await;
    assert_eq!(dashboard.get("/readyz").await.status, StatusCode::SERVICE_UNAVAILABLE);
    assert_eq!(dashboard.get("/builds/7").await.status, StatusCode::NOT_FOUND);
    assert_eq!(dashboard.get("/assets/../Cargo.toml").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn a_machine_that_the_daemon_cannot_use_says_so_on_its_card_and_in_json() {
    let dashboard = with_a_build("bracket.stl").await;
    let seen = |trouble: &str| ledger::ObservedMachine {
        profile: String::new(),
        machine: "cube".to_owned(),
        scanned_at: None,
        is_inbox_there: trouble.is_empty(),
        is_queue_writable: true,
        trouble: Some(trouble.to_owned()),
    };
    let heartbeat = |trouble: &str| ledger::NodeHeartbeat {
        pid: std::process::id(),
        machines: vec![seen(trouble)],
        configured: Vec::new(),
        ..fixtures::heartbeat()
    };
    let machine = async || {
        let json: serde_json::Value = serde_json::from_str(&dashboard.get("/api/v1/farm").await.text).unwrap();
        json["machines"][0].clone()
    };
    assert_eq!(machine().await["available"], serde_json::Value::Null, "nobody has looked yet");
    dashboard.ledger.write_heartbeat(&heartbeat("The share is gone.")).await.unwrap();
    assert_eq!(
        (&machine().await["available"], &machine().await["trouble"]),
        (&false.into(), &"The share is gone.".into())
    );
    let card = dashboard.get("/").await.text;
    assert!(card.contains("Unavailable, since ") && card.contains("The share is gone."), "{card}");
    dashboard.ledger.write_heartbeat(&heartbeat("")).await.unwrap();
    assert_eq!((&machine().await["available"], &machine().await["trouble"]), (&true.into(), &serde_json::Value::Null));
    assert!(!dashboard.get("/").await.text.contains("Unavailable"));
}

#[tokio::test]
async fn the_builds_of_a_machine_that_was_sold_stay_to_be_looked_at() {
    let dashboard = with_a_build("bracket.stl").await;
    let mut settings = (*dashboard.web.current_settings()).clone();
    settings.profiles.clear();
    *dashboard.web.settings.write().unwrap() = Arc::new(settings);
    for path in ["/", "/history", "/builds/1", "/builds/1/pick", "/builds/1/picture", "/builds/1/scene"] {
        assert_eq!(dashboard.get(path).await.status, StatusCode::OK, "{path}");
    }
}

#[tokio::test]
async fn the_page_of_a_build_counts_the_copies_that_stand_in_it_and_has_a_picture_without_javascript() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let part = ledger::NewPartRow { machine: "cube".to_owned(), ..fixtures::new_part("a", 9) };
    let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
    dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 9)]).await.unwrap();
    let build = dashboard.ledger.open_build("cube").await.unwrap().id;
    dashboard.ledger.begin_nesting(build, "flush", &[(id, 4)]).await.unwrap();
    let placed = fixtures::placed(&[(id, 4)]);
    dashboard.ledger.verify_build(build, &fixtures::verified(build, 1), &placed).await.unwrap();
    let page = dashboard.get("/builds/1").await.text;
    let table = page.rsplit("<tbody>").next().unwrap();
    assert!(
        table.contains("data-of=\"Copies here\">1</td><td class=\"n\" data-of=\"Of\">9</td>"),
        "1 copy here of 9: {table}"
    );
    let poster = page.split("class=\"poster\"").nth(1).unwrap();
    assert!(poster.split("<canvas").next().unwrap().contains("src=\"/builds/1/picture\""));
    let map = dashboard.get("/builds/1/pick").await.text;
    assert!(map.contains("1 copy, ") && map.contains("1 part is listed without a place"), "the original is not there");
}
