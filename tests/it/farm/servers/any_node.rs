//! Three nodes behind a load balancer that leads each connection to the next of them: whichever node answers, what is asked of any machine
//! is done, once.

use std::{
    fs::{self, Permissions},
    os::unix::fs::PermissionsExt,
    process::Command,
    thread,
    time::{Duration, Instant},
};

use ledger::PartState;
use ledger_fixtures::postgres_cluster::PostgresCluster;
use rustix::process::Signal;
use serde_json::{Value, json};
use ureq::http::{Request, request::Builder};

use super::test_node::{TestNode, new_database};
use crate::support::{balancer::balance, block, farm_files::assert_each_copy_once, signal, stl, wait_until_or};

/// The token of all nodes.
const TOKEN: &str = "of-all-three-nodes-0123456789";

/// Asks the nodes in turn.
struct Asker {
    address: String,
}

impl Asker {
    fn of(nodes: &[TestNode]) -> Self {
        let nodes: Vec<String> = nodes.iter().map(|node| node.address.clone()).collect();
        Self { address: balance(&nodes) }
    }

    /// Status, header `location` and body of an answer. Each request comes by a connection of its own.
    fn send(&self, request: Builder, path: &str, body: &[u8]) -> (u16, String, String) {
        let config = ureq::Agent::config_builder().http_status_as_error(false).max_redirects(0);
        let request = request.uri(format!("{}{path}", self.address)).header("connection", "close");
        let request = request.header("authorization", format!("Bearer {TOKEN}"));
        let mut answer = config.build().new_agent().run(request.body(body).unwrap()).unwrap();
        let header = |name: &str| answer.headers().get(name).map_or("", |value| value.to_str().unwrap()).to_owned();
        let (place, offset) = (header("location"), header("upload-offset"));
        let text = answer.body_mut().read_to_string().unwrap();
        (answer.status().as_u16(), format!("{place}{offset}"), text)
    }

    fn get(&self, path: &str) -> String {
        let (status, _, text) = self.send(Request::get("/"), path, b"");
        assert_eq!(status, 200, "{path}: {text}");
        text
    }

    fn json(&self, path: &str) -> Value {
        serde_json::from_str(&self.get(path)).unwrap()
    }

    fn api(&self, method: &str, path: &str, key: &str, body: &Value) -> (u16, Value) {
        let request = Request::builder().method(method).header("content-type", "application/json");
        let (status, _, text) = self.send(request.header("idempotency-key", key), path, body.to_string().as_bytes());
        (status, serde_json::from_str(&text).unwrap_or(Value::String(text)))
    }

    /// Sends a form of a page with files; the text of the page to which the browser is led.
    fn drop_file(&self, machine: &str, name: &str, bytes: &[u8]) -> String {
        let page = self.get(&format!("/machines/{machine}/drop"));
        let key = page.split("name=\"key\" value=\"").nth(1).unwrap().split('"').next().unwrap();
        let body = [
            format!("--edge\r\nContent-Disposition: form-data; name=\"key\"\r\n\r\n{key}\r\n--edge\r\n").as_bytes(),
            b"Content-Disposition: form-data; name=\"copies\"\r\n\r\n2\r\n--edge\r\n",
            format!("Content-Disposition: form-data; name=\"file\"; filename=\"{name}\"\r\n\r\n").as_bytes(),
            bytes,
            b"\r\n--edge--\r\n",
        ]
        .concat();
        let form = || Request::post("/").header("content-type", "multipart/form-data; boundary=edge");
        let path = format!("/machines/{machine}/files");
        let (status, told, text) = self.send(form(), &path, &body);
        assert!(status == 303 && told.starts_with("/told/"), "{status} {text}");
        // The same form once more, at the next node: it is done once.
        assert_eq!(self.send(form(), &path, &body).0, 303);
        self.get(&told)
    }
}

fn three_nodes(server: &PostgresCluster) -> Vec<TestNode> {
    let url = new_database(server);
    let mut nodes: Vec<TestNode> = (1..=3).map(|number| TestNode::new(number, &url)).collect();
    for node in &mut nodes {
        let config = fs::read_to_string(node.farm.config()).unwrap();
        let token = node.farm.root().join("token");
        fs::write(&token, TOKEN).unwrap();
        fs::set_permissions(&token, Permissions::from_mode(0o600)).unwrap();
        let more = format!("orders = true\ntoken_file = {token:?}\n");
        fs::write(node.farm.config(), config + &more).unwrap();
        node.start();
    }
    nodes
}

fn wait_for(nodes: &[TestNode], what: &str, is_so: impl Fn() -> bool) {
    wait_until_or(what, 60.0, || nodes.iter().map(|node| node.farm.log()).collect(), is_so);
}

/// Uploads a file piece by piece, each at the next node; its content, as an order names it.
fn upload_in_pieces(asker: &Asker, bytes: &[u8]) -> Value {
    let tus = |request: Builder| request.header("tus-resumable", "1.0.0");
    let begun = tus(Request::post("/")).header("upload-length", bytes.len().to_string());
    let (status, place, text) = asker.send(begun, "/api/v1/uploads", b"");
    assert_eq!(status, 201, "{text}");
    let place = place.strip_suffix('0').unwrap().to_owned();
    for (number, piece) in bytes.chunks(bytes.len().div_ceil(5)).enumerate() {
        let offset = number * bytes.len().div_ceil(5);
        assert_eq!(asker.send(tus(Request::head("/")), &place, b"").1, offset.to_string());
        let more = tus(Request::patch("/")).header("upload-offset", offset.to_string());
        let more = more.header("content-type", "application/offset+octet-stream");
        let (status, _, text) = asker.send(more, &place, piece);
        assert_eq!(status, 204, "{text}");
    }
    // What the node of the upload refuses is told in its words.
    for _ in 0..3 {
        let wrong = tus(Request::patch("/")).header("upload-offset", "7");
        let wrong = wrong.header("content-type", "application/offset+octet-stream");
        let (status, _, text) = asker.send(wrong, &place, b"x");
        assert!(status == 409 && text.contains("bytes of it have arrived"), "{status} {text}");
    }
    asker.json(&place)["content"].clone()
}

/// Asks the first node for builds of all, also as no browser does, and while the last one stands still.
fn hold_up(nodes: &[TestNode], numbers: &[i64]) {
    // A page that is asked for with a body, which no page has.
    let curl = |node: &TestNode, path: &str, more: &[&str]| {
        let mut curl = Command::new("curl");
        curl.args(["-s", "-o", "/dev/null", "-w", "%{http_code}", "-H", &format!("authorization: Bearer {TOKEN}")]);
        curl.args(more).arg(format!("{}{path}", node.address));
        curl
    };
    for number in numbers {
        let told = curl(&nodes[0], &format!("/builds/{number}/break-out"), &["-m", "20", "-X", "GET", "--data", "x"]);
        assert_eq!(String::from_utf8_lossy(&{ told }.output().unwrap().stdout), "200");
    }
    // A node that stands still holds up nobody who asks another one for something else.
    signal(nodes[2].farm.pid(), Signal::STOP);
    let waiting: Vec<_> = numbers
        .iter()
        .cycle()
        .take(60)
        .map(|number| curl(&nodes[0], &format!("/builds/{number}/break-out"), &["-m", "60"]).spawn().unwrap())
        .collect();
    let began = Instant::now();
    for _ in 0..5 {
        assert_eq!(String::from_utf8_lossy(&curl(&nodes[0], "/", &["-m", "20"]).output().unwrap().stdout), "200");
        let told = curl(&nodes[0], "/api/v1/content", &["-m", "20", "--data-binary", "some bytes"]).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&told.stdout), "201");
    }
    assert!(began.elapsed() < Duration::from_secs(15), "{:?}", began.elapsed());
    signal(nodes[2].farm.pid(), Signal::CONT);
    waiting.into_iter().for_each(|mut one| assert!(one.wait().unwrap().code().is_some()));
}

#[test]
fn files_uploads_and_words_reach_the_node_that_they_are_for() {
    let server = PostgresCluster::start();
    let nodes = three_nodes(&server);
    let asker = Asker::of(&nodes);
    wait_for(&nodes, "all nodes know all machines", || {
        let knows = |_| {
            asker.json("/api/v1/farm")["machines"]
                .as_array()
                .is_some_and(|all| all.len() == 3 && all.iter().all(|machine| machine["available"] == true))
        };
        (0..3).all(knows)
    });
    // Files of pages, from each node to each machine.
    for at in 0..3 {
        for machine in 1..=3 {
            let name = format!("part {at}{machine}.stl");
            let bytes = stl(&block(20.0, 15.0, 10.0 + at as f64));
            let told = asker.drop_file(&format!("machine-{machine}"), &name, &bytes);
            assert!(told.contains(&name), "{told}");
        }
    }
    nodes[0].farm.wait_for_parts(PartState::Waiting, 9);
    // An upload in pieces, each at another node, and an order of it.
    let content = upload_in_pieces(&asker, &stl(&block(24.0, 15.0, 10.0)));
    let order = json!({ "machine": "machine-3", "order": "K-1", "lines": [{ "name": "u.stl", "content": content, "copies": 2 }] });
    for _ in 0..6 {
        assert_eq!(asker.api("POST", "/api/v1/orders", "k", &order).0, 202);
    }
    nodes[0].farm.wait_for_parts(PartState::Waiting, 10);
    for machine in 1..=3 {
        let path = format!("/api/v1/machines/machine-{machine}/flush");
        assert_eq!(asker.api("POST", &path, "", &json!({})).0, 200);
    }
    let queued: Vec<_> = nodes.iter().flat_map(|node| node.farm.wait_for_queued(1)).collect();
    assert_each_copy_once(&queued, 20);
    // Whether a file still lies in its queue, the node says that serves it, whichever is told the outcome.
    let builds = asker.json("/api/v1/builds");
    let numbers: Vec<i64> = builds.as_array().unwrap().iter().map(|row| row["build"].as_i64().unwrap()).collect();
    assert_eq!(numbers.len(), 3, "{builds}");
    let tell = |number: i64| {
        let told = json!({ "outcome": "failed" });
        asker.api("POST", &format!("/api/v1/builds/{number}/outcome"), "", &told)
    };
    for &number in &numbers {
        for _ in 0..3 {
            let (status, told) = tell(number);
            assert!(status == 409 && told.to_string().contains("lies untouched in the queue"), "{status} {told}");
        }
    }
    hold_up(&nodes, &numbers);
    queued.iter().for_each(|file| fs::remove_file(file).unwrap());
    for &number in &numbers {
        let (status, told) = tell(number);
        assert_eq!(status, 200, "{told}");
    }
}

#[test]
fn each_order_is_one_and_each_press_once_whichever_nodes_get_them() {
    let server = PostgresCluster::start();
    let nodes = three_nodes(&server);
    let asker = Asker::of(&nodes);
    wait_for(&nodes, "all nodes know all machines", || {
        (0..3).all(|_| asker.json("/api/v1/farm")["machines"].as_array().is_some_and(|all| all.len() == 3))
    });
    let bytes = stl(&block(20.0, 15.0, 10.0));
    let (status, _, text) = asker.send(Request::post("/"), "/api/v1/content", &bytes);
    assert_eq!(status, 201, "{text}");
    let content = serde_json::from_str::<Value>(&text).unwrap()["content"].clone();
    // 200 requests with 20 keys from two clients at once.
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                for number in 0..100 {
                    let key = number % 20;
                    let machine = format!("machine-{}", key % 3 + 1);
                    let lines = json!([{ "name": format!("p{key}.stl"), "content": content, "copies": 1 }]);
                    let order = json!({ "machine": machine, "order": format!("K-{key}"), "lines": lines });
                    loop {
                        let (status, told) = asker.api("POST", "/api/v1/orders", &format!("key {key}"), &order);
                        // The same key is being carried out for the other client.
                        if status != 409 && status != 429 {
                            assert_eq!(status, 202, "{told}");
                            break;
                        }
                    }
                }
            });
        }
    });
    nodes[0].farm.wait_for_parts(PartState::Waiting, 20);
    // One press of a button that arrives at three nodes at once: every form of the part's page is taken once.
    let part = asker.json("/api/v1/orders/K-0")["lines"][0]["part"].as_i64().unwrap();
    let page = asker.get(&format!("/parts/{part}"));
    let key = page.split("name=\"key\" value=\"").nth(1).unwrap().split('"').next().unwrap();
    let form = format!("key={key}&kind=cancel&part={part}");
    thread::scope(|scope| {
        let presses: Vec<_> = (0..9)
            .map(|_| {
                scope.spawn(|| {
                    let request = Request::post("/").header("content-type", "application/x-www-form-urlencoded");
                    asker.send(request, "/commands", form.as_bytes())
                })
            })
            .collect();
        for press in presses {
            let (status, to, text) = press.join().unwrap();
            assert_eq!(status, 303, "{text}");
            assert!(!to.contains("refused"), "{to}");
        }
    });
    let asked = nodes[0].farm.query_ledger(async |ledger| ledger.events_of_part(ledger::PartId(part)).await.unwrap());
    let cancelled = asked.iter().filter(|event| event.detail.contains("cancelled")).count();
    assert_eq!(cancelled, 1, "{asked:?}");
}
