//! What the door for programs takes, and what it refuses: long requests, cut ones, forms that contradict themselves, and clients that send
//! too much.

use std::{convert::Infallible, time::Duration};

use access::{Role, add_token};
use axum::body::Bytes;
use serde_json::{Value, json};
use tokio_stream::StreamExt;

use super::{
    door_tests::{ApiAnswer, CUBE, of_lines, of_upload, order, put, send},
    *,
};

/// A form of an order with files, each the cube.
fn order_form(order: &str, names: &[&str]) -> String {
    let mut body = format!("--B\r\nContent-Disposition: form-data; name=\"order\"\r\n\r\n{order}\r\n");
    for name in names {
        body += &format!("--B\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{name}\"\r\n\r\n");
        body += "solid a cube, more or less\r\n";
    }
    body + "--B--\r\n"
}

async fn post_form(dashboard: &TestDashboard, body: String) -> ApiAnswer {
    let request = Request::post("/api/v1/orders").header("content-type", "multipart/form-data; boundary=B");
    let request = request.header("content-length", body.len());
    send(dashboard, request.header("idempotency-key", "f"), body).await
}

/// A body that does not say how long it is.
fn in_chunks(chunks: Vec<&'static [u8]>) -> Body {
    Body::from_stream(tokio_stream::iter(chunks).map(|chunk| Ok::<_, Infallible>(Bytes::from_static(chunk))))
}

#[tokio::test]
async fn the_files_of_a_quote_may_be_as_large_as_those_of_an_order() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let quote = r#"{"machine":"cube","lines":[{"name":"a.stl"},{"name":"missing.stl"}]}"#;
    let mut body = format!("--B\r\nContent-Disposition: form-data; name=\"quote\"\r\n\r\n{quote}\r\n");
    body += "--B\r\nContent-Disposition: form-data; name=\"file\"; filename=\"a.stl\"\r\n\r\n";
    body += &"x".repeat(3 << 20);
    let request = Request::post("/api/v1/quote").header("content-type", "multipart/form-data; boundary=B");
    let answer = send(&dashboard, request, body + "\r\n--B--\r\n").await;
    assert_eq!(answer.status, StatusCode::UNPROCESSABLE_ENTITY, "{}", answer.json);
    assert!(answer.json["detail"].as_str().unwrap().contains("no file of that name came"), "{}", answer.json);
    let long = order(&dashboard, "k", json!({ "machine": "x".repeat(3 << 20) })).await;
    assert_eq!(long.status, StatusCode::PAYLOAD_TOO_LARGE, "JSON alone is short");
}

#[tokio::test]
async fn an_order_is_carried_out_also_when_its_client_does_not_wait_for_the_answer() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let hash = put(&dashboard, CUBE).await;
    let lines = of_lines(json!([{ "name": "a.stl", "content": hash }]));
    let others_are_judged = dashboard.web.door.judging.acquire().await.unwrap();
    let cut = tokio::time::timeout(Duration::from_millis(300), order(&dashboard, "k", lines.clone())).await;
    assert!(cut.is_err());
    assert_eq!(order(&dashboard, "k", lines.clone()).await.status, StatusCode::CONFLICT);
    drop(others_are_judged);
    let recorded = async || dashboard.ledger.arriving_lines("cube", 9).await.unwrap().len();
    for _ in 0..200 {
        if recorded().await > 0 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(recorded().await, 1);
    // It is recorded before its key is free for the same again.
    let mut again = order(&dashboard, "k", lines.clone()).await;
    for _ in 0..200 {
        if again.status != StatusCode::CONFLICT {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
        again = order(&dashboard, "k", lines.clone()).await;
    }
    assert_eq!(
        (again.status, &again.headers["idempotency-replayed"]),
        (StatusCode::ACCEPTED, &"true".parse().unwrap())
    );
}

#[tokio::test]
async fn a_form_that_contradicts_itself_or_is_too_long_is_refused() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let hash = blake3::hash(b"another file").to_hex().to_string();
    let named = |fields: Value| of_lines(json!([fields])).to_string();
    let long = format!("{{\"machine\":\"{}\"", "x".repeat(2 << 20));
    for (form, status, why) in [
        (order_form(&named(json!({ "name": "a.stl" })), &["a.stl", "a.stl"]), 422, "two files are called a.stl"),
        (order_form(&named(json!({ "name": "a.stl", "content": hash })), &["a.stl"]), 422, "another content"),
        (order_form(&long, &[]), 413, "order"),
    ] {
        let refused = post_form(&dashboard, form).await;
        let detail = refused.json["detail"].as_str().unwrap();
        assert!(refused.status == status && detail.contains(why), "{}: {detail}", refused.status);
    }
    let same = named(json!({ "name": "a.stl", "content": blake3::hash(CUBE).to_hex().to_string() }));
    assert_eq!(post_form(&dashboard, order_form(&same, &["a.stl"])).await.status, StatusCode::ACCEPTED);
}

#[tokio::test]
async fn the_limit_of_a_file_holds_for_each_file_of_a_form() {
    let small = TestDashboard::new(|web| {
        let mut settings = (**web.settings.read().unwrap()).clone();
        settings.limits.max_bytes = CUBE.len() as u64;
        web.settings = Arc::new(RwLock::new(Arc::new(settings)));
    })
    .await;
    let lines = of_lines(json!([{ "name": "a.stl" }, { "name": "b.stl" }])).to_string();
    let taken = post_form(&small, order_form(&lines, &["a.stl", "b.stl"])).await;
    assert_eq!(taken.status, StatusCode::ACCEPTED, "{}", taken.json);
}

#[tokio::test]
async fn bytes_that_nobody_announced_count_while_they_come() {
    let dashboard = TestDashboard::new(|web| {
        web.limits = ClientLimits::new(ClientRates { per_sec: 1e6, burst: 1000, bytes: 30 });
    })
    .await;
    let long = send(&dashboard, Request::post("/api/v1/content"), in_chunks(vec![CUBE, CUBE])).await;
    assert_eq!(long.status, StatusCode::TOO_MANY_REQUESTS, "{}", long.json);
    assert!(long.json["detail"].as_str().unwrap().contains("web.client_bytes"), "{}", long.json);
    let short = send(&dashboard, Request::post("/api/v1/content"), in_chunks(vec![CUBE])).await;
    assert_eq!(short.status, StatusCode::CREATED, "what was refused is not under way any more");
}

#[tokio::test]
async fn a_client_holds_two_of_the_places_for_files_at_most_and_others_have_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tokens.toml");
    let tokens = ["one", "other"].map(|name| add_token(&file, name, Role::Order).unwrap());
    let dashboard = TestDashboard::new(|web| {
        web.clients.tokens_file = Some(file.clone());
        web.upload_slots = Arc::new(Semaphore::new(4));
    })
    .await;
    let post = |token: &str, body: Body| {
        let request = Request::post("/api/v1/content").header("authorization", format!("Bearer {token}"));
        let request = request.header("host", "localhost").body(body).unwrap();
        build_router(dashboard.web.clone()).oneshot(request)
    };
    let pending = || Body::from_stream(tokio_stream::pending::<Result<Bytes, Infallible>>());
    let held: Vec<_> = (0..2).map(|_| tokio::spawn(post(&tokens[0], pending()))).collect();
    let places = dashboard.web.upload_slots.clone();
    for _ in 0..200 {
        if places.available_permits() == 2 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let third = post(&tokens[0], Body::from(CUBE)).await.unwrap();
    assert_eq!(
        (third.status(), &third.headers()["retry-after"]),
        (StatusCode::TOO_MANY_REQUESTS, &"1".parse().unwrap())
    );
    assert_eq!(post(&tokens[1], Body::from(CUBE)).await.unwrap().status(), StatusCode::CREATED);
    held.into_iter().for_each(|held| held.abort());
    for _ in 0..200 {
        if places.available_permits() == 4 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert!(post(&tokens[0], Body::from(CUBE)).await.unwrap().status().is_success());
}

#[tokio::test]
async fn a_client_has_a_hundred_unfinished_uploads_at_most() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let begin = async || send(&dashboard, of_upload("POST", "/api/v1/uploads").header("upload-length", 9), "").await;
    for _ in 0..100 {
        assert_eq!(begin().await.status, StatusCode::CREATED);
    }
    let told = begin().await;
    assert_eq!(told.status, StatusCode::TOO_MANY_REQUESTS, "{}", told.json);
    assert!(told.json["detail"].as_str().unwrap().contains("unfinished"), "{}", told.json);
}

#[tokio::test]
async fn who_looks_at_an_upload_does_not_cut_it() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let begin = of_upload("POST", "/api/v1/uploads").header("upload-length", CUBE.len());
    let begun = send(&dashboard, begin, "").await;
    let path = begun.headers["location"].to_str().unwrap().to_owned();
    let (pieces, body) = tokio::sync::mpsc::channel::<Result<Bytes, Infallible>>(4);
    let request = of_upload("PATCH", &path).header("upload-offset", 0).header("host", "localhost");
    let request = request.header("content-type", "application/offset+octet-stream");
    let request = request.body(Body::from_stream(tokio_stream::wrappers::ReceiverStream::new(body))).unwrap();
    let sending = tokio::spawn(build_router(dashboard.web.clone()).oneshot(request));
    pieces.send(Ok(Bytes::from_static(&CUBE[..10]))).await.unwrap();
    let mut seen = Value::Null;
    for _ in 0..100 {
        seen = send(&dashboard, Request::get(&path), "").await.json;
        if seen["offset"] == 10 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(seen, json!({ "offset": 10, "length": CUBE.len(), "content": null }));
    assert!(pieces.send(Ok(Bytes::from_static(&CUBE[10..]))).await.is_ok(), "it still comes");
    drop(pieces);
    assert_eq!(sending.await.unwrap().unwrap().status(), StatusCode::NO_CONTENT);
    let hash = blake3::hash(CUBE).to_hex().to_string();
    assert_eq!(send(&dashboard, Request::get(&path), "").await.json["content"], hash);
}

#[tokio::test]
async fn who_is_to_come_again_is_told_when() {
    let dashboard = TestDashboard::new(|web| {
        web.quote_slots = Arc::new(Semaphore::new(0));
        web.upload_slots = Arc::new(Semaphore::new(0));
    })
    .await;
    let quote = Request::post("/api/v1/quote").header("content-type", "application/json");
    let quote = send(&dashboard, quote, "{}").await;
    assert_eq!((quote.status, &quote.headers["retry-after"]), (StatusCode::TOO_MANY_REQUESTS, &"1".parse().unwrap()));
    let form = Request::post("/machines/cube/files").header("content-type", "multipart/form-data; boundary=B");
    let form = form.header("host", "localhost").body(Body::from("--B--\r\n")).unwrap();
    let form = build_router(dashboard.web.clone()).oneshot(form).await.unwrap();
    assert_eq!((form.status(), &form.headers()["retry-after"]), (StatusCode::TOO_MANY_REQUESTS, &"1".parse().unwrap()));
}
