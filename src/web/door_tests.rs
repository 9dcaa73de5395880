//! The door for programs: content, orders, keys, roles, and how they are refused.

use access::{Role, add_token};
use ledger::EventKind;
use serde_json::{Value, json};

use super::*;

pub(super) const CUBE: &[u8] = b"solid a cube, more or less";

pub(super) struct ApiAnswer {
    pub(super) status: StatusCode,
    pub(super) headers: axum::http::HeaderMap,
    pub(super) json: Value,
}

/// Sends a request as a program does.
pub(super) async fn send(
    dashboard: &TestDashboard,
    request: axum::http::request::Builder,
    body: impl Into<Body>,
) -> ApiAnswer {
    let request = request.header("host", "localhost").body(body.into()).unwrap();
    let answer = build_router(dashboard.web.clone()).oneshot(request).await.unwrap();
    let (status, headers) = (answer.status(), answer.headers().clone());
    let bytes = to_bytes(answer.into_body(), usize::MAX).await.unwrap();
    let json = serde_json::from_slice(&bytes).unwrap_or(Value::Null);
    if status.is_client_error() {
        assert_eq!(headers["content-type"], "application/problem+json", "{status} {json}");
        let is_bare = bytes.is_empty();
        assert!(is_bare || json["status"] == status.as_u16() && json["detail"].is_string(), "{json}");
    }
    ApiAnswer { status, headers, json }
}

/// Asserts that an answer is as `openapi.json` describes it.
pub(super) fn assert_described(path: &str, method: &str, answer: &ApiAnswer) {
    let all = crate::web::doors::openapi::described();
    let content = &all["paths"][path][method]["responses"][answer.status.as_str()]["content"];
    let mut faults = Vec::new();
    api::unlike(&content["application/json"]["schema"], &answer.json, &all, path, &mut faults);
    assert!(faults.is_empty(), "{method} {path}: {faults:#?}");
}

pub(super) async fn put(dashboard: &TestDashboard, bytes: &'static [u8]) -> String {
    let hash = blake3::hash(bytes).to_hex().to_string();
    let answer = send(dashboard, Request::put(format!("/api/v1/content/{hash}")), bytes).await;
    assert!(answer.status.is_success() && answer.json["bytes"] == bytes.len(), "{}", answer.json);
    hash
}

pub(super) async fn order(dashboard: &TestDashboard, key: &str, order: Value) -> ApiAnswer {
    let request = Request::post("/api/v1/orders").header("content-type", "application/json");
    send(dashboard, request.header("idempotency-key", key), order.to_string()).await
}

pub(super) fn of_lines(lines: Value) -> Value {
    json!({ "machine": "cube", "order": "K-1", "lines": lines })
}

#[tokio::test]
async fn content_is_put_once_and_only_what_its_address_says() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let hash = blake3::hash(CUBE).to_hex().to_string();
    let address = format!("/api/v1/content/{hash}");
    assert_eq!(send(&dashboard, Request::get(&address), "").await.status, StatusCode::NOT_FOUND);
    let other = send(&dashboard, Request::put(&address), "other bytes").await;
    assert_eq!(other.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(other.json["detail"].as_str().unwrap().contains("these bytes have the BLAKE3"), "{}", other.json);
    assert_eq!(send(&dashboard, Request::put(&address), CUBE).await.status, StatusCode::CREATED);
    assert_eq!(send(&dashboard, Request::put(&address), CUBE).await.status, StatusCode::OK);
    assert_eq!(
        send(&dashboard, Request::get(&address), "").await.json,
        json!({ "content": hash, "bytes": CUBE.len() })
    );
    assert_eq!(send(&dashboard, Request::put("/api/v1/content/xyz"), CUBE).await.status, StatusCode::BAD_REQUEST);
    let small = TestDashboard::new(|web| {
        let mut settings = (**web.settings.read().unwrap()).clone();
        settings.limits.max_bytes = 5;
        web.settings = Arc::new(RwLock::new(Arc::new(settings)));
    })
    .await;
    let large = send(&small, Request::put(&address), CUBE).await;
    assert_eq!(large.status, StatusCode::PAYLOAD_TOO_LARGE);
    assert!(large.json["detail"].as_str().unwrap().contains("limits.max_bytes"), "{}", large.json);
}

#[tokio::test]
async fn a_key_is_one_order_and_refused_for_another() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let hash = put(&dashboard, CUBE).await;
    let lines = json!([{ "name": "a_x4.stl", "content": hash, "due": "2026-12-24" }]);
    let first = order(&dashboard, "k1", of_lines(lines.clone())).await;
    assert_eq!(first.status, StatusCode::ACCEPTED, "{}", first.json);
    assert_described("/api/v1/orders", "post", &first);
    assert_eq!((&first.json["order"], &first.json["lines"][0]["copies"]), (&json!("K-1"), &json!(4)));
    let again = order(&dashboard, "k1", of_lines(lines.clone())).await;
    assert_eq!((again.status, &again.json), (StatusCode::ACCEPTED, &first.json));
    assert_eq!(again.headers["idempotency-replayed"], "true");
    let other = order(&dashboard, "k1", of_lines(json!([{ "name": "a.stl", "content": hash }]))).await;
    assert_eq!(other.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert_eq!(dashboard.ledger.arriving_lines("cube", 9).await.unwrap().len(), 1);
    let second = order(&dashboard, "k2", of_lines(lines.clone())).await;
    assert_ne!(second.json["lines"][0]["line"], first.json["lines"][0]["line"]);
    assert_eq!(dashboard.ledger.arriving_lines("cube", 9).await.unwrap().len(), 2);
    let seen = send(&dashboard, Request::get("/api/v1/orders/K-1"), "").await;
    assert_described("/api/v1/orders/{order}", "get", &seen);
    assert_eq!((seen.status, seen.json["arriving"].as_array().unwrap().len()), (StatusCode::OK, 2), "{}", seen.json);
    let line = format!("/api/v1/orders/K-1/lines/{}", first.json["lines"][0]["line"].as_str().unwrap());
    assert_eq!(send(&dashboard, Request::get(&line), "").await.json["arriving"], true);
    let keyless = Request::post("/api/v1/orders").header("content-type", "application/json");
    assert_eq!(send(&dashboard, keyless, of_lines(lines).to_string()).await.status, StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn what_can_be_judged_is_refused_at_once_and_the_key_stays_free() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let hash = put(&dashboard, CUBE).await;
    let with = |fields: Value| {
        let mut line = json!({ "name": "a.stl", "content": hash });
        line.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        of_lines(json!([line]))
    };
    for (asked, said) in [
        (with(json!({ "priority": 101 })), "line 1 (a.stl): priority = 101; it must be 0 to 100"),
        (with(json!({ "content": "00".repeat(32) })), "put it first"),
        (json!({ "machine": "none", "order": "K", "lines": [] }), "there is no machine none; there are cube"),
        (of_lines(json!([])), "1 to 500 lines"),
    ] {
        let refused = order(&dashboard, "k", asked).await;
        let detail = refused.json["detail"].as_str().unwrap();
        assert!(refused.status == StatusCode::UNPROCESSABLE_ENTITY && detail.contains(said), "{detail}");
    }
    let wrong = order(&dashboard, "k", json!({ "machin": "cube" })).await;
    assert_eq!(wrong.status, StatusCode::BAD_REQUEST);
    assert!(wrong.json["detail"].as_str().unwrap().contains("machin"), "{}", wrong.json);
    assert!(dashboard.ledger.arriving_lines("cube", 9).await.unwrap().is_empty());
    assert_eq!(order(&dashboard, "k", with(json!({}))).await.status, StatusCode::ACCEPTED);
    let closed = TestDashboard::new(|web| web.orders = false).await;
    assert_eq!(order(&closed, "k", with(json!({}))).await.status, StatusCode::FORBIDDEN);
}

#[tokio::test]
async fn a_form_brings_an_order_with_its_files() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let post = async |order: Value, names: &[&str]| {
        let mut body = format!("--B\r\nContent-Disposition: form-data; name=\"order\"\r\n\r\n{order}\r\n");
        for name in names {
            body += &format!("--B\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{name}\"\r\n\r\n");
            body += "solid a cube, more or less\r\n";
        }
        let request = Request::post("/api/v1/orders").header("content-type", "multipart/form-data; boundary=B");
        send(&dashboard, request.header("idempotency-key", "f"), body + "--B--\r\n").await
    };
    let lines = of_lines(json!([{ "name": "a.stl", "copies": 2 }]));
    let unlisted = post(lines.clone(), &["a.stl", "b.stl"]).await;
    assert!(unlisted.json["detail"].as_str().unwrap().contains("no line orders copies of b.stl"), "{}", unlisted.json);
    let missing = post(lines.clone(), &[]).await;
    assert!(missing.json["detail"].as_str().unwrap().contains("no file of that name came"), "{}", missing.json);
    let taken = post(lines.clone(), &["a.stl"]).await;
    assert_eq!(taken.status, StatusCode::ACCEPTED, "{}", taken.json);
    assert_eq!(taken.json["lines"][0]["content"], blake3::hash(CUBE).to_hex().to_string());
    let by_content =
        of_lines(json!([{ "name": "a.stl", "copies": 2, "content": blake3::hash(CUBE).to_hex().to_string() }]));
    assert_eq!(order(&dashboard, "f", by_content).await.json, taken.json, "the same request, put in another way");
}

#[tokio::test]
async fn a_token_may_what_its_role_says_and_is_named_in_events() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tokens.toml");
    let tokens = [Role::Read, Role::Order, Role::Operate]
        .map(|role| add_token(&file, &format!("{}-er", role.as_str()), role).unwrap());
    let dashboard = TestDashboard::new(|web| web.clients.tokens_file = Some(file.clone())).await;
    let ask = async |token: &str, method: &str, path: &str| {
        let request = Request::builder().method(method).uri(path).header("authorization", format!("Bearer {token}"));
        let request = request.header("content-type", "application/json").header("idempotency-key", "k");
        send(&dashboard, request, "{}").await.status
    };
    let content = format!("/api/v1/content/{}", blake3::hash(b"{}").to_hex());
    for (method, path, least, allowed) in [
        ("GET", "/api/v1/farm", 0, StatusCode::OK),
        ("PUT", &content, 1, StatusCode::CREATED),
        ("POST", "/api/v1/orders", 1, StatusCode::BAD_REQUEST),
        ("DELETE", "/api/v1/orders/K", 1, StatusCode::NOT_FOUND),
        ("POST", "/api/v1/builds/9/release", 2, StatusCode::NOT_FOUND),
        ("POST", "/api/v1/parts/9/retry", 2, StatusCode::NOT_FOUND),
        ("POST", "/api/v1/parts/9/confirm", 2, StatusCode::NOT_FOUND),
        ("POST", "/api/v1/machines/none/flush", 2, StatusCode::NOT_FOUND),
        ("POST", "/api/v1/machines/none/pause", 2, StatusCode::NOT_FOUND),
    ] {
        for (at, token) in tokens.iter().enumerate() {
            let status = ask(token, method, path).await;
            let wanted = if at < least { StatusCode::FORBIDDEN } else { allowed };
            let is_there = path == content && status == StatusCode::OK;
            assert!(status == wanted || is_there, "{method} {path} by {at}: {status}");
        }
        assert_eq!(ask("nestd_00", method, path).await, StatusCode::UNAUTHORIZED);
    }
    let request = Request::post("/api/v1/orders").header("authorization", format!("Bearer {}", tokens[1]));
    let request = request.header("content-type", "application/json").header("idempotency-key", "k");
    let hash = blake3::hash(b"{}").to_hex().to_string();
    let taken = send(&dashboard, request, of_lines(json!([{ "name": "a.stl", "content": hash }])).to_string()).await;
    assert_eq!(taken.status, StatusCode::ACCEPTED, "{}", taken.json);
    assert_eq!(dashboard.ledger.arriving_lines("cube", 9).await.unwrap()[0].client, "order-er");
    let nameless = Request::get("/api/v1/farm");
    assert_eq!(send(&dashboard, nameless, "").await.status, StatusCode::UNAUTHORIZED);
    let half_open = TestDashboard::new(|web| {
        (web.clients.tokens_file, web.clients.without_token) = (Some(file.clone()), Some(Role::Read));
    })
    .await;
    assert_eq!(send(&half_open, Request::get("/api/v1/farm"), "").await.status, StatusCode::OK);
    assert_eq!(send(&half_open, Request::put(&content), "{}").await.status, StatusCode::FORBIDDEN);
}

#[tokio::test]
async fn programs_tell_of_builds_as_people_do_and_are_told_why_not() {
    let dashboard = with_a_build("bracket.stl").await;
    let tell = async |path: &str, body: Value| {
        let request = Request::post(path).header("content-type", "application/json");
        send(&dashboard, request, body.to_string()).await
    };
    let early = tell("/api/v1/builds/1/release", json!({})).await;
    let bare = send(&dashboard, Request::post("/api/v1/builds/1/release"), "").await;
    assert_eq!((bare.status, &bare.json), (early.status, &early.json), "nothing at all is an empty object");
    let untyped = send(&dashboard, Request::post("/api/v1/builds/1/release"), "file_hash=1").await;
    assert_eq!(untyped.status, StatusCode::UNSUPPORTED_MEDIA_TYPE);
    let short = send(&dashboard, Request::post("/api/v1/builds/1/outcome"), "").await;
    assert_eq!(short.status, StatusCode::UNPROCESSABLE_ENTITY, "{}", short.json);
    assert!(early.status == StatusCode::CONFLICT && early.json["detail"].as_str().unwrap().contains("published"));
    assert_eq!(tell("/api/v1/builds/9/outcome", json!({ "outcome": "failed" })).await.status, StatusCode::NOT_FOUND);
    assert_eq!(
        tell("/api/v1/builds/1/outcome", json!({ "outcome": "lost" })).await.status,
        StatusCode::UNPROCESSABLE_ENTITY
    );
    let body = json!({ "outcome": "complete", "bad": { "1": 1 } });
    let lies = tell("/api/v1/builds/1/outcome", body.clone()).await;
    assert!(lies.status == StatusCode::CONFLICT && lies.json["detail"].as_str().unwrap().contains("lies untouched"));
    dashboard.printer_takes_it().await;
    let told = tell("/api/v1/builds/1/outcome", body).await;
    assert!(
        told.status == StatusCode::OK
            && told.json["answers"][1].as_str().unwrap().starts_with("1 copy of 1 part waits again"),
        "{}",
        told.json
    );
    assert_eq!(tell("/api/v1/builds/1/outcome", json!({ "outcome": "complete" })).await.status, StatusCode::CONFLICT);
    let outcomes = dashboard.ledger.outcomes_of_build(ledger::BuildId(1)).await.unwrap();
    assert_eq!(outcomes.len(), 1);
    assert_described("/api/v1/builds/{build}/outcome", "post", &told);
    let edit = Request::patch("/api/v1/orders/bracket.stl/lines/1").header("content-type", "application/json");
    let wrong = send(&dashboard, edit, json!({ "copies": 0 }).to_string()).await;
    assert_eq!(wrong.status, StatusCode::UNPROCESSABLE_ENTITY);
    let line = send(&dashboard, Request::get("/api/v1/orders/bracket.stl/lines/1"), "").await;
    assert_eq!((&line.json["arriving"], &line.json["parts"][0]["part"]), (&json!(false), &json!(1)));
    assert_eq!(send(&dashboard, Request::get("/api/v1/orders/other/lines/1"), "").await.status, StatusCode::NOT_FOUND);
}

pub(super) fn of_upload(method: &str, path: &str) -> axum::http::request::Builder {
    Request::builder().method(method).uri(path).header("tus-resumable", "1.0.0")
}

#[tokio::test]
async fn an_upload_goes_on_where_it_was_cut_and_yields_its_content() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let options = send(&dashboard, Request::options("/api/v1/uploads"), "").await;
    assert_eq!(
        (options.status, &options.headers["tus-extension"]),
        (StatusCode::NO_CONTENT, &"creation,expiration,termination".parse().unwrap())
    );
    let begun = send(&dashboard, of_upload("POST", "/api/v1/uploads").header("upload-length", CUBE.len()), "").await;
    assert_eq!((begun.status, &begun.headers["upload-offset"]), (StatusCode::CREATED, &"0".parse().unwrap()));
    let path = begun.headers["location"].to_str().unwrap().to_owned();
    let patch = async |offset: usize, bytes: &'static [u8]| {
        let request = of_upload("PATCH", &path).header("upload-offset", offset);
        send(&dashboard, request.header("content-type", "application/offset+octet-stream"), bytes).await
    };
    assert_eq!(patch(0, &CUBE[..10]).await.headers["upload-offset"], "10");
    let wrong = patch(5, &CUBE[5..]).await;
    assert_eq!((wrong.status, &wrong.headers["tus-resumable"]), (StatusCode::CONFLICT, &"1.0.0".parse().unwrap()));
    let head = send(&dashboard, of_upload("HEAD", &path), "").await;
    assert_eq!(
        (&head.headers["upload-offset"], &head.headers["cache-control"]),
        (&"10".parse().unwrap(), &"no-store".parse().unwrap())
    );
    assert!(head.headers["upload-expires"].to_str().unwrap().ends_with(" GMT"));
    let whole = patch(10, &CUBE[10..]).await;
    let hash = blake3::hash(CUBE).to_hex().to_string();
    assert_eq!(
        (whole.status, whole.headers["nestd-content"].to_str().unwrap()),
        (StatusCode::NO_CONTENT, hash.as_str())
    );
    let asked = send(&dashboard, Request::get(&path), "").await;
    assert_eq!(asked.json, json!({ "offset": CUBE.len(), "length": CUBE.len(), "content": hash }));
    assert_described("/api/v1/uploads/{upload}", "get", &asked);
    let taken = order(&dashboard, "k", of_lines(json!([{ "name": "a.stl", "content": hash }]))).await;
    assert_eq!(taken.status, StatusCode::ACCEPTED, "{}", taken.json);
    assert_eq!(send(&dashboard, of_upload("DELETE", &path), "").await.status, StatusCode::NO_CONTENT);
    assert_eq!(send(&dashboard, of_upload("HEAD", &path), "").await.status, StatusCode::NOT_FOUND);
    let old = Request::post("/api/v1/uploads").header("tus-resumable", "0.2.2").header("upload-length", 3);
    assert_eq!(send(&dashboard, old, "").await.status, StatusCode::PRECONDITION_FAILED);
    let large = of_upload("POST", "/api/v1/uploads").header("upload-length", u64::MAX / 2);
    assert!(send(&dashboard, large, "").await.status.is_client_error());
}

#[tokio::test]
async fn an_upload_takes_no_more_than_it_said_and_nothing_but_what_it_said() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let expected = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, "0".repeat(64));
    let begin = of_upload("POST", "/api/v1/uploads").header("upload-length", 5);
    let begun = send(&dashboard, begin.header("upload-metadata", format!("filename YQ==,blake3 {expected}")), "").await;
    let path = begun.headers["location"].to_str().unwrap().to_owned();
    let patch = async |bytes: &'static [u8]| {
        let request = of_upload("PATCH", &path).header("upload-offset", 0);
        send(&dashboard, request.header("content-type", "application/offset+octet-stream"), bytes).await.status
    };
    assert_eq!(patch(b"123456").await, StatusCode::PAYLOAD_TOO_LARGE);
    assert_eq!(patch(b"12345").await, StatusCode::UNPROCESSABLE_ENTITY);
    assert_eq!(send(&dashboard, of_upload("HEAD", &path), "").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn who_floods_is_told_when_to_ask_again_and_others_do_not_notice() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tokens.toml");
    let tokens = ["flood", "calm"].map(|name| add_token(&file, name, Role::Order).unwrap());
    let dashboard = TestDashboard::new(|web| {
        web.clients.tokens_file = Some(file.clone());
        web.limits = ClientLimits::new(ClientRates { per_sec: 0.5, burst: 5, bytes: 40 });
    })
    .await;
    let ask = async |token: &str| {
        send(&dashboard, Request::get("/api/v1/month").header("authorization", format!("Bearer {token}")), "").await
    };
    for _ in 0..5 {
        assert_eq!(ask(&tokens[0]).await.status, StatusCode::OK);
    }
    let told = ask(&tokens[0]).await;
    let wait: u64 = told.headers["retry-after"].to_str().unwrap().parse().unwrap();
    assert!(told.status == StatusCode::TOO_MANY_REQUESTS && (1..=2).contains(&wait), "{wait}");
    assert_eq!(ask(&tokens[1]).await.status, StatusCode::OK);
    let begin = async |bytes: u64| {
        let request = of_upload("POST", "/api/v1/uploads").header("authorization", format!("Bearer {}", tokens[1]));
        send(&dashboard, request.header("upload-length", bytes), "").await.status
    };
    assert_eq!((begin(30).await, begin(30).await), (StatusCode::CREATED, StatusCode::TOO_MANY_REQUESTS));
}

#[tokio::test]
async fn a_program_that_remembers_the_last_event_misses_none_and_sees_none_twice() {
    let dashboard = with_a_build("bracket.stl").await;
    let ask = async |query: &str| -> serde_json::Value {
        let answer = dashboard.get(&format!("/api/v1/events{query}")).await;
        serde_json::from_str(&answer.text).unwrap()
    };
    let first = ask("").await;
    assert_eq!(first["events"][0]["kind"], "published");
    assert_eq!(first["events"][0]["build"]["number"], 1);
    let write = async |kind: EventKind, text: &str| {
        dashboard.ledger.write_event(kind, "cube", None, None, text).await.unwrap();
    };
    // Kinds that no message has are passed over.
    for text in ["one", "two", "three"] {
        write(EventKind::NoRoom, text).await;
        write(EventKind::Seen, "nobody is told").await;
    }
    let (mut last, mut details) = (first["last"].as_str().unwrap().to_owned(), Vec::new());
    for wanted in [2, 1, 0, 0] {
        let page = ask(&format!("?limit=2&after={last}")).await;
        let events = page["events"].as_array().unwrap();
        assert_eq!(events.len(), wanted, "{page}");
        details.extend(events.iter().map(|event| event["detail"].as_str().unwrap().to_owned()));
        last = page["last"].as_str().unwrap().to_owned();
    }
    assert_eq!(details, ["one", "two", "three"]);
    assert_eq!(ask(&format!("?after={}", last.split('@').next().unwrap())).await["events"], serde_json::json!([]));
    // Somebody waits, and is answered when something happens.
    let waits = ask(&format!("?wait=1&after={last}")).await;
    assert_eq!(waits["events"], serde_json::json!([]));
    for (query, status, why) in [
        ("?after=9999", StatusCode::CONFLICT, "put back to an earlier time"),
        ("?after=1@2020-01-01T00:00:00.000Z", StatusCode::CONFLICT, "put back to an earlier time"),
        ("?after=yesterday", StatusCode::BAD_REQUEST, "id of an event"),
        ("?limit=0", StatusCode::BAD_REQUEST, "1 to 500"),
        ("?wait=60", StatusCode::BAD_REQUEST, "at most 8"),
    ] {
        let answer = dashboard.get(&format!("/api/v1/events{query}")).await;
        assert_eq!(answer.status, status, "{query}");
        assert!(answer.text.contains(why), "{query}: {}", answer.text);
    }
}
