//! Programs order over HTTP from the real daemon: what they put is printed once, refusals say why, and uploads go on after cuts and
//! restarts.

use std::{
    fs,
    io::Write,
    path::PathBuf,
    time::{Duration, Instant},
};

use ledger::PartState;
use serde_json::{Value, json};

use crate::support::{
    MACHINE, QUICK, TestFarm, block,
    http::{HttpAnswer, open_request, read_answer, send_request},
    samples::with_a_hole,
    stl, wait_until_or,
};

/// Bytes of the upload that is cut, and how often. `NESTD_DOOR_MIB=2048` makes it as long as the longest files.
const UPLOAD_MIB: usize = 24;
const CUTS: usize = 20;

/// A farm with a door, whose tokens are in a file.
pub struct OpenFarm {
    pub farm: TestFarm,
    token: Option<String>,
}

impl OpenFarm {
    pub fn start(web: &str) -> Self {
        let farm = TestFarm::new(QUICK);
        let config = fs::read_to_string(farm.config()).unwrap();
        let socket = farm.root().join("web.sock");
        fs::write(farm.config(), format!("{config}[web]\nlisten = \"unix:{}\"\n{web}", socket.display())).unwrap();
        let mut open = Self { farm, token: None };
        open.restart();
        open
    }

    fn socket(&self) -> PathBuf {
        self.farm.root().join("web.sock")
    }

    pub fn restart(&mut self) {
        self.farm.kill();
        self.farm.start();
        let answers = || send_request(&self.socket(), "GET /healthz", b"").is_some();
        wait_until_or("the dashboard answers", 30.0, || self.farm.log(), answers);
    }

    pub fn send(&self, words: &str, body: &[u8]) -> HttpAnswer {
        let token = self.token.as_ref().map(|token| format!("\nauthorization: Bearer {token}")).unwrap_or_default();
        send_request(&self.socket(), &format!("{words}{token}"), body).unwrap_or_else(|| panic!("{}", self.farm.log()))
    }

    pub fn put(&self, bytes: &[u8]) -> String {
        let hash = blake3::hash(bytes).to_hex().to_string();
        let answer = self.send(&format!("PUT /api/v1/content/{hash}"), bytes);
        assert_eq!(answer.status, 201, "{answer:?}");
        hash
    }

    pub fn order(&self, key: &str, lines: Value) -> HttpAnswer {
        let order = json!({ "machine": MACHINE, "order": "K-1", "lines": lines }).to_string();
        let words = format!("POST /api/v1/orders\ncontent-type: application/json\nidempotency-key: {key}");
        self.send(&words, order.as_bytes())
    }
}

#[test]
fn what_a_program_orders_is_printed_once_and_it_learns_what_became_of_it() {
    let mut open = OpenFarm::start("");
    let hash = open.put(&stl(&block(20.0, 15.0, 10.0)));
    let lines = json!([{ "name": "hinge.stl", "content": hash, "copies": 3, "priority": 70, "note": "left" }]);
    let taken = open.order("k1", lines.clone());
    assert_eq!(taken.status, 202, "{taken:?}");
    open.restart();
    assert_eq!(open.order("k1", lines).body, taken.body);
    let part = open.farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!((part.terms.order_name.as_str(), part.owed.copies, part.terms.priority), ("K-1", 3, 70));
    let line = format!("/api/v1/orders/K-1/lines/{}", taken.json()["lines"][0]["line"].as_str().unwrap());
    let words = format!("PATCH {line}\ncontent-type: application/json");
    let edited = open.send(&words, json!({ "copies": 4, "due": "2027-01-05" }).to_string().as_bytes());
    assert_eq!((edited.status, &edited.json()["done"]), (200, &json!(true)), "{edited:?}");
    assert_eq!(open.send(&format!("POST /api/v1/machines/{MACHINE}/flush"), b"").status, 200);
    let build = open.farm.wait_for_queued(1).remove(0);
    assert_eq!(build_file::read_build(&build, &Default::default()).unwrap().len(), 4);
    open.farm.wait_for_parts(PartState::Built, 1);
    let told = open.send("POST /api/v1/builds/1/outcome\ncontent-type: application/json", br#"{"outcome":"complete"}"#);
    assert_eq!(told.status, 200, "{told:?}");
    let order = open.send("GET /api/v1/orders/K-1", b"").json();
    assert_eq!((&order["state"], &order["good"], &order["arriving"]), (&json!("complete"), &json!(4), &json!([])));
    open.farm.assert_nothing_lost_or_doubled();
    assert!(open.farm.broken_invariants(&Default::default()).is_empty());
}

#[test]
fn a_program_has_a_broken_mesh_mended_answers_a_question_and_pauses_the_machine() {
    let open = OpenFarm::start("");
    let say =
        |what: &str, body: &str| open.send(&format!("POST {what}\ncontent-type: application/json"), body.as_bytes());
    open.farm.drop_bytes("holed.stl", &with_a_hole(stl(&block(20.0, 15.0, 10.0))));
    open.farm.wait_for_parts(PartState::Refused, 1);
    let paused = say(&format!("/api/v1/machines/{MACHINE}/pause"), "");
    assert_eq!(paused.status, 200, "{paused:?}");
    let unmended = say("/api/v1/parts/1/retry", "{}");
    assert_eq!(unmended.status, 200, "{unmended:?}");
    open.farm.wait_for_parts(PartState::Refused, 1);
    let mended = say("/api/v1/parts/1/retry", r#"{"mend": true}"#);
    assert_eq!((mended.status, &mended.json()["done"]), (200, &json!(true)), "{mended:?}");
    open.farm.wait_for_parts(PartState::Waiting, 1);
    open.farm.drop_bytes("lid DO_NOT_PRINT.stl", &stl(&block(12.0, 9.0, 6.0)));
    let question = |count| open.farm.wait_for_parts(PartState::Waiting, count).pop().unwrap().owed.question;
    assert_ne!(question(2), "");
    let confirmed = say("/api/v1/parts/2/confirm", "");
    assert_eq!((confirmed.status, question(2).as_str()), (200, ""), "{confirmed:?}");
    let state = || open.send("GET /api/v1/farm", b"").json()["machines"][0]["state"].clone();
    assert_eq!(state(), "paused");
    assert_eq!(say(&format!("/api/v1/machines/{MACHINE}/resume"), "").status, 200);
    assert_eq!(state(), "collecting");
}

#[test]
fn what_cannot_be_printed_is_refused_at_once_with_the_reason_of_its_file() {
    let open = OpenFarm::start("");
    let (large, broken) = (stl(&block(20.0, 15.0, 500.0)), b"solid nonsense\nendsolid\n".to_vec());
    for (name, bytes) in [("large.stl", &large), ("broken.stl", &broken)] {
        open.farm.drop_bytes(name, bytes);
        let reason_file = open.farm.folder("error");
        let reason = || {
            let files = intake::files_below(&reason_file).unwrap_or_default();
            let file =
                files.into_iter().find(|file| file.to_string_lossy().ends_with(&format!("{name}.reason.txt")))?;
            fs::read_to_string(file).ok().filter(|text| !text.is_empty())
        };
        wait_until_or("it is refused", 30.0, || open.farm.log(), || reason().is_some());
        let refused = open.order("k", json!([{ "name": name, "content": open.put(bytes) }]));
        let detail = refused.json()["detail"].as_str().unwrap().to_owned();
        assert!(refused.status == 422 && refused.head.contains("application/problem+json"), "{refused:?}");
        let first = detail.split(". ").next().unwrap();
        assert!(reason().unwrap().replace('\n', " ").contains(first), "{detail}\n{}", reason().unwrap());
    }
    assert!(open.farm.query_ledger(async |ledger| ledger.arriving_lines(MACHINE, 9).await.unwrap()).is_empty());
}

#[test]
fn the_document_of_an_order_is_quoted_without_anything_being_taken_or_kept() {
    let open = OpenFarm::start("");
    // As a form, with what a ticket may say.
    let text = stl(&block(1.0, 2.0, 3.0));
    let document = r#"{"machine":"test","due":"2035-01-01","lines":[{"name":"small.stl","copies":4,"unit":"cm","orientation":"fixed"}]}"#;
    let mut form = format!("--B\r\ncontent-disposition: form-data; name=\"quote\"\r\n\r\n{document}\r\n").into_bytes();
    form.extend(b"--B\r\ncontent-disposition: form-data; name=\"file\"; filename=\"small.stl\"\r\n\r\n");
    form.extend(&text);
    form.extend(b"\r\n--B--\r\n");
    let words = "POST /api/v1/quote\ncontent-type: multipart/form-data; boundary=B";
    let quote = open.send(words, &form);
    assert_eq!(quote.status, 200, "{quote:?}");
    let quote = quote.json();
    assert_eq!((&quote["copies"], &quote["answer"]), (&json!(4), &json!("kept")), "{quote}");
    assert!(quote["height_mm"].as_f64().unwrap() > 29.9, "the unit of the line counts: {quote}");
    let hash = open.put(&text);
    let line = json!({ "name": "small.stl", "content": hash, "copies": 4, "unit": "cm", "orientation": "fixed" });
    let body = json!({ "machine": "test", "due": "2035-01-01", "lines": [line] }).to_string();
    let again = open.send("POST /api/v1/quote\ncontent-type: application/json", body.as_bytes());
    assert_eq!(again.status, 200, "{again:?}");
    // The two searches had as long as the machine gave them.
    let heights = [&quote, &again.json()].map(|quote| quote["height_mm"].as_f64().unwrap());
    assert!((heights[0] - heights[1]).abs() < 1e-3, "{heights:?}");
    let put: Vec<_> = std::fs::read_dir(open.farm.root().join("state/put")).unwrap().flatten().collect();
    assert_eq!(put.len(), 1, "only what was put: {put:?}");
    assert!(open.farm.parts(PartState::Waiting).is_empty());
}

#[test]
fn a_lost_claim_is_made_again_and_content_that_is_gone_is_asked_for() {
    let mut open = OpenFarm::start("");
    let bytes = stl(&block(20.0, 15.0, 10.0));
    let hash = open.put(&bytes);
    open.farm.kill();
    open.farm.start();
    wait_until_or(
        "it answers",
        30.0,
        || open.farm.log(),
        || send_request(&open.socket(), "GET /healthz", b"").is_some(),
    );
    // The hot folder is away: the order waits in the ledger.
    let (inbox, aside) = (open.farm.folder("inbox"), open.farm.root().join("aside"));
    fs::rename(&inbox, &aside).unwrap();
    assert_eq!(open.order("k", json!([{ "name": "a.stl", "content": hash }])).status, 202);
    fs::remove_file(open.farm.root().join("state/put").join(&hash)).unwrap();
    fs::rename(&aside, &inbox).unwrap();
    wait_until_or(
        "it says what is missing",
        30.0,
        || open.farm.log(),
        || open.farm.log().contains("a.stl of order K-1"),
    );
    assert!(open.farm.parts(PartState::Waiting).is_empty());
    open.put(&bytes);
    open.farm.wait_for_parts(PartState::Waiting, 1);
    assert!(open.farm.broken_invariants(&Default::default()).is_empty());
}

#[test]
fn content_that_was_damaged_is_put_again() {
    let open = OpenFarm::start("");
    let bytes = stl(&block(20.0, 15.0, 10.0));
    let hash = open.put(&bytes);
    let (inbox, aside) = (open.farm.folder("inbox"), open.farm.root().join("aside"));
    fs::rename(&inbox, &aside).unwrap();
    assert_eq!(open.order("k", json!([{ "name": "a.stl", "content": hash }])).status, 202);
    fs::write(open.farm.root().join("state/put").join(&hash), &bytes[..bytes.len() - 1]).unwrap();
    fs::rename(&aside, &inbox).unwrap();
    let damaged = open.farm.root().join("state/damaged").join(&hash);
    wait_until_or("it is set aside", 30.0, || open.farm.log(), || damaged.exists());
    assert_eq!(open.send(&format!("HEAD /api/v1/content/{hash}"), b"").status, 404);
    open.put(&bytes);
    open.farm.wait_for_parts(PartState::Waiting, 1);
    assert!(open.farm.broken_invariants(&Default::default()).is_empty());
}

#[test]
fn a_line_of_a_machine_that_is_gone_is_told_and_can_be_cancelled() {
    let open = OpenFarm::start("");
    let hash = open.put(&stl(&block(20.0, 15.0, 10.0)));
    fs::rename(open.farm.folder("inbox"), open.farm.root().join("aside")).unwrap();
    assert_eq!(open.order("k", json!([{ "name": "a.stl", "content": hash }])).status, 202);
    open.farm.write_profile("other", QUICK);
    fs::remove_file(open.farm.root().join(format!("config/profiles/{MACHINE}.toml"))).unwrap();
    open.farm.reload();
    let told = || String::from_utf8_lossy(&open.farm.nestd(&["status"]).stdout).into_owned();
    let is_told = || told().contains("1 line ordered by request");
    wait_until_or("it is told", 40.0, told, is_told);
    let cancelled = open.send("DELETE /api/v1/orders/K-1", b"");
    assert_eq!((cancelled.status, &cancelled.json()["done"]), (200, &json!(true)), "{cancelled:?}");
    wait_until_or("it is over", 40.0, told, || !is_told());
}

#[test]
fn an_order_that_is_cancelled_at_once_is_not_printed_at_any_step_of_its_lines() {
    const LINES: usize = 150;
    let open = OpenFarm::start("");
    let hash = open.put(&stl(&block(20.0, 15.0, 10.0)));
    for (round, wait_ms) in [0, 150, 400, 1200].into_iter().enumerate() {
        let lines: Vec<Value> =
            (0..LINES).map(|at| json!({ "name": format!("{round}-{at}.stl"), "content": hash })).collect();
        assert_eq!(open.order(&format!("k{round}"), json!(lines)).status, 202);
        std::thread::sleep(Duration::from_millis(wait_ms));
        wait_until_or(
            "it is cancelled",
            60.0,
            || open.farm.log(),
            || {
                let told = open.send("DELETE /api/v1/orders/K-1", b"");
                assert!([200, 202, 409, 429].contains(&told.status), "{told:?}");
                told.status == 409 && told.json().get("refused").is_none()
            },
        );
    }
    std::thread::sleep(Duration::from_secs(1));
    for state in [PartState::Claimed, PartState::Waiting, PartState::Batched, PartState::Built] {
        assert!(open.farm.parts(state).is_empty(), "{state}");
    }
    assert!(open.farm.query_ledger(async |ledger| ledger.arriving_lines(MACHINE, 9).await.unwrap()).is_empty());
    assert!(open.farm.queued().is_empty());
    assert_eq!(open.farm.broken_invariants(&Default::default()), Vec::<String>::new());
}

#[test]
fn an_upload_that_is_cut_again_and_again_arrives_as_it_was_sent() {
    let mut open = OpenFarm::start("");
    let mib = std::env::var("NESTD_DOOR_MIB").map_or(UPLOAD_MIB, |text| text.parse().unwrap());
    let piece: Vec<u8> = (0..1u32 << 20).map(|at| (at.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let length = mib << 20;
    let mut hasher = blake3::Hasher::new();
    for _ in 0..mib {
        hasher.update(&piece);
    }
    let words = format!("POST /api/v1/uploads\ntus-resumable: 1.0.0\nupload-length: {length}");
    let begun = open.send(&words, b"");
    assert_eq!(begun.status, 201, "{begun:?}");
    let path = begun.header("location").unwrap().to_owned();
    let offset = |open: &OpenFarm| -> usize {
        let head = open.send(&format!("HEAD {path}\ntus-resumable: 1.0.0"), b"");
        head.header("upload-offset").unwrap_or_else(|| panic!("{head:?}")).parse().unwrap()
    };
    let send_from = |open: &OpenFarm, from: usize, until: usize| {
        let words = format!(
            "PATCH {path}\ntus-resumable: 1.0.0\nupload-offset: {from}\ncontent-type: application/offset+octet-stream"
        );
        let mut stream = open_request(&open.socket(), &words, length - from).unwrap();
        let mut at = from;
        while at < until {
            let begin = at % piece.len();
            let end = piece.len().min(begin + (until - at));
            if stream.write_all(&piece[begin..end]).is_err() {
                break;
            }
            at += end - begin;
        }
        stream
    };
    let mut last = 0;
    for cut in 1..=CUTS {
        let from = offset(&open);
        assert!(from >= last && (cut == 1 || from > 0), "what arrived stays: {from} after {last}");
        last = from;
        let stream = send_from(&open, from, (length / (CUTS + 1) * cut).max(from));
        match cut % 5 {
            0 => open.restart(),
            _ => std::thread::sleep(Duration::from_millis(30)),
        }
        drop(stream);
    }
    let stream = send_from(&open, offset(&open), length);
    let whole = read_answer(stream).unwrap();
    let hash = hasher.finalize().to_hex().to_string();
    assert_eq!((whole.status, whole.header("nestd-content")), (204, Some(hash.as_str())), "{whole:?}");
    assert_eq!(open.send(&format!("GET /api/v1/content/{hash}"), b"").json()["bytes"], length);
}

#[test]
fn a_client_that_floods_waits_while_the_farm_and_the_others_go_on() {
    let mut open = OpenFarm::start("tokens_file = \"tokens.toml\"\nclient_requests_per_sec = 10\nclient_burst = 10\n");
    let token = |name: &str, role: &str| {
        let told = open.farm.nestd_ok(&["token", "new", name, "--role", role]);
        told.split_whitespace().find(|word| word.starts_with("nestd_")).unwrap().to_owned()
    };
    let (flood, calm) = (token("flood", "read"), token("calm", "operate"));
    assert_eq!(send_request(&open.socket(), "GET /api/v1/farm", b"").unwrap().status, 401);
    let (socket, until) = (open.socket(), Instant::now() + Duration::from_secs(4));
    let flooding = std::thread::spawn(move || {
        let mut answers = Vec::new();
        while Instant::now() < until {
            let words = format!("GET /api/v1/month\nauthorization: Bearer {flood}");
            let answer = send_request(&socket, &words, b"").unwrap();
            assert!(answer.status == 200 || answer.header("retry-after").is_some(), "{answer:?}");
            answers.push(answer.status);
        }
        answers
    });
    open.token = Some(calm);
    let hash = open.put(&stl(&block(20.0, 15.0, 10.0)));
    assert_eq!(open.order("k", json!([{ "name": "a.stl", "content": hash }])).status, 202);
    let part = open.farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    let events = open.farm.query_ledger(async |ledger| ledger.events_of_part(part.id).await.unwrap());
    assert!(events.iter().any(|event| event.detail == "a.stl, ordered by calm"), "{events:?}");
    let answers = flooding.join().unwrap();
    let (through, told) = (answers.iter().filter(|status| **status == 200).count(), answers.contains(&429));
    assert!(told && through <= 10 + 5 * 10, "{through} of {}", answers.len());
    open.farm.nestd_ok(&["token", "revoke", "calm"]);
    assert_eq!(open.send("GET /api/v1/farm", b"").status, 401);
}
