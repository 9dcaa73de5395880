//! Files in forms, as browsers send them and as they break off.

use std::{fs, path::Path};

use axum::{
    body::{Body, Bytes},
    http::Request,
};
use settings::Settings;
use tokio_stream::wrappers::ReceiverStream;

use super::{TestDashboard, TestResponse};

const LINE: &str = "----line";

fn field(name: &str, text: &str) -> String {
    format!("--{LINE}\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n{text}\r\n")
}

fn file(name: &str, text: &str) -> String {
    format!(
        "--{LINE}\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{name}\"\r\nContent-Type: model/stl\r\n\r\n{text}\r\n"
    )
}

fn request(body: Body) -> Request<Body> {
    Request::post("/machines/cube/files")
        .header("host", "localhost")
        .header("sec-fetch-site", "same-origin")
        .header("content-type", format!("multipart/form-data; boundary={LINE}"))
        .body(body)
        .unwrap()
}

async fn sent(dashboard: &TestDashboard, parts: &[String]) -> TestResponse {
    sent_with(dashboard, &dashboard.web.form_keys.make_key(), parts).await
}

/// Sends a form with this key where it says `key`; the text is that of the page to which the browser is led.
async fn sent_with(dashboard: &TestDashboard, key: &str, parts: &[String]) -> TestResponse {
    let parts = parts.concat().replace(&field("key", "key"), &field("key", key));
    let mut answer = dashboard.send(request(Body::from(format!("{parts}--{LINE}--\r\n")))).await;
    if answer.location.starts_with("/told/") {
        answer.text = dashboard.get(&answer.location).await.text;
    }
    answer
}

/// A farm whose hot folder is there, and that folder.
async fn with_inbox(change: impl FnOnce(&mut Settings)) -> (TestDashboard, std::path::PathBuf) {
    let dashboard = TestDashboard::new(|_| ()).await;
    let mut settings = (*dashboard.web.current_settings()).clone();
    change(&mut settings);
    let inbox = settings.profiles["cube"].folders.inbox.clone();
    *dashboard.web.settings.write().unwrap() = std::sync::Arc::new(settings);
    fs::create_dir_all(&inbox).unwrap();
    (dashboard, inbox)
}

fn names(inbox: &Path) -> Vec<String> {
    let mut all: Vec<String> =
        fs::read_dir(inbox).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    all.sort();
    all
}

#[tokio::test(flavor = "multi_thread")]
async fn files_of_a_form_lie_in_the_hot_folder_each_with_its_ticket() {
    let (dashboard, inbox) = with_inbox(|_| ()).await;
    let large = "x".repeat(3 << 20);
    let parts = [
        field("key", "key"),
        field("order", "1182"),
        field("copies", "12"),
        field("due", "2026-11-27"),
        file("hinge.stl", &large),
        file("C:\\Größe.stl", "solid"),
        file("", ""),
    ];
    let answer = sent(&dashboard, &parts).await;
    assert!(answer.status == 303 && answer.text.contains("hinge.stl is in the hot folder of cube"), "{}", answer.text);
    assert_eq!(names(&inbox), ["Größe.stl", "Größe.stl.toml", "hinge.stl", "hinge.stl.toml"]);
    assert_eq!(fs::read_to_string(inbox.join("hinge.stl")).unwrap(), large);
    let ticket = fs::read_to_string(inbox.join("hinge.stl.toml")).unwrap();
    let read = intake::Ticket::from_toml(&ticket, "t").unwrap();
    assert_eq!((read.copies, read.order.as_deref()), (Some(12), Some("1182")));
    let again = sent(&dashboard, &[field("key", "key"), file("hinge.stl", "other")]).await;
    assert!(again.text.contains("hinge (2).stl is in the hot folder"), "{}", again.text);
    assert_eq!(fs::read_to_string(inbox.join("hinge.stl")).unwrap(), large, "nothing is overwritten");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_form_with_files_that_is_sent_twice_orders_once() {
    let (dashboard, inbox) = with_inbox(|_| ()).await;
    let page = dashboard.get("/machines/cube/drop").await.text;
    let key = page.split("name=\"key\" value=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
    let parts = [field("key", "key"), field("copies", "3"), file("hinge.stl", "solid")];
    for _ in 0..2 {
        let answer = sent_with(&dashboard, &key, &parts).await;
        assert!(answer.text.contains("hinge.stl is in the hot folder of cube"), "{}", answer.text);
        assert_eq!((answer.status.as_u16(), answer.location.starts_with("/told/")), (303, true));
        assert_eq!(names(&inbox), ["hinge.stl", "hinge.stl.toml"]);
    }
    for other in [file("hinge.stl", "other"), file("cover.stl", "solid")] {
        let answer = sent_with(&dashboard, &key, &[field("key", "key"), field("copies", "3"), other]).await;
        assert!(answer.status == 422 && answer.text.contains("load its page again"), "{}", answer.text);
        assert_eq!(names(&inbox).len(), 2, "it is told, not silently left out");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_refused_leaves_nothing_behind() {
    let (dashboard, inbox) = with_inbox(|settings| settings.limits.max_bytes = 10).await;
    let key = || field("key", "key");
    let refused = [
        (403, vec![field("key", "guessed"), file("a.stl", "solid")]),
        (403, vec![file("a.stl", "solid"), key()]),
        (403, vec![field("order", "7")]),
        (400, vec![key(), field("due", "soon"), file("a.stl", "solid")]),
        (400, vec![key(), file("a.stl", "solid"), file("FLUSH", "")]),
        (400, vec![key(), file("order.csv", "a;1")]),
        (400, vec![key()]),
        (413, vec![key(), file("a.stl", "solid"), file("b.stl", "solid solid solid")]),
        (413, vec![key(), field("note", &"x".repeat(2000))]),
    ];
    for (status, parts) in refused {
        let answer = sent(&dashboard, &parts).await;
        assert_eq!(answer.status, status, "{parts:?}: {}", answer.text);
        assert!(answer.text.contains("id=\"problem\""), "{}", answer.text);
        assert!(names(&inbox).is_empty(), "{parts:?}: {:?}", names(&inbox));
    }
    let taken = dashboard.web.upload_slots.clone().try_acquire_owned().unwrap();
    assert_eq!(sent(&dashboard, &[key(), file("a.stl", "solid")]).await.status, 429);
    drop(taken);
    fs::remove_dir(&inbox).unwrap();
    assert_eq!(sent(&dashboard, &[key(), file("a.stl", "solid")]).await.status, 507, "the folder is away");
}

#[tokio::test(flavor = "multi_thread")]
async fn an_upload_that_breaks_off_leaves_nothing_behind() {
    let (dashboard, inbox) = with_inbox(|_| ()).await;
    let (send, receive) = tokio::sync::mpsc::channel::<Result<Bytes, std::io::Error>>(4);
    let body = Body::from_stream(ReceiverStream::new(receive));
    let whole =
        [field("key", &dashboard.web.form_keys.make_key()), file("a.stl", "solid"), file("b.stl", "solid")].concat();
    send.send(Ok(Bytes::from(whole[..whole.len() - 8].to_owned()))).await.unwrap();
    let answering = dashboard.send(request(body));
    let breaking = async {
        while !names(&inbox).iter().any(|name| name.starts_with(".nestd-upload-")) {
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
        assert!(!names(&inbox).iter().any(|name| name.ends_with(".stl")), "nothing is seen before all is there");
        send.send(Err(std::io::ErrorKind::ConnectionReset.into())).await.unwrap();
    };
    let (answer, ()) = tokio::join!(answering, breaking);
    assert!(answer.status.is_client_error() || answer.status.is_server_error(), "{}", answer.text);
    assert!(names(&inbox).is_empty(), "{:?}", names(&inbox));
}

#[tokio::test]
async fn a_farm_that_takes_no_orders_takes_no_files() {
    let dashboard = TestDashboard::new(|web| web.orders = false).await;
    assert_eq!(sent(&dashboard, &[field("key", "key"), file("a.stl", "solid")]).await.status, 403);
    assert!(!dashboard.get("/machines/cube/drop").await.text.contains("<form class=\"tell"));
}
