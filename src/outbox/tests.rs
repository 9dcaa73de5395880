//! Delivery to a real web server and to real programs.

use std::{
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, RwLock},
    time::{Duration, Instant},
};

use jiff::{SignedDuration, Timestamp};
use ledger::{EventKind, Ledger, NewPartRow, ReceiverKind, RefusalCause};
use ledger_fixtures as fixtures;
use settings::{Settings, SharedSettings};
use tokio::task::JoinHandle;

use super::*;

#[path = "../../tests/support/webhook.rs"]
mod hook;
use hook::TestWebhook;

const SECRET: &str = "a-key-of-32-letters-or-so-it-is-ok";

/// The reports on receivers, in order.
pub(super) type ReceiverReports = Vec<(ReceiverKind, Option<String>)>;

/// A farm with receivers, and its ledger.
pub(super) struct OutboxFixture {
    pub(super) ledger: fixtures::TestLedger,
    pub(super) folder: tempfile::TempDir,
    pub(super) settings: SharedSettings,
    pub(super) failures: Arc<Mutex<ReceiverReports>>,
}

impl OutboxFixture {
    pub(super) async fn new(notify: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let secret = folder.path().join("secret");
        fs::write(&secret, format!("{SECRET}\n")).unwrap();
        fs::set_permissions(&secret, fs::Permissions::from_mode(0o640)).unwrap();
        let ledger = fixtures::fresh().await;
        let settings = Arc::new(RwLock::new(Arc::new(read(folder.path(), ledger.file().unwrap(), notify))));
        Self { ledger, folder, settings, failures: Arc::default() }
    }

    async fn of(hook: &TestWebhook, more: &str) -> Self {
        Self::new(&format!("webhook = \"{}\"\nsecret_file = \"SECRET\"\n{more}\n", hook.url)).await
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Starts the delivery and waits until the receivers have their positions.
    pub(super) async fn tell(&self, receivers: usize) -> JoinHandle<()> {
        let failures = self.failures.clone();
        let ledger = ledger::LedgerOnDemand::for_user(ledger::LedgerUser::Monitoring);
        let telling = deliver_events(self.settings.clone(), ledger, move |receiver, why| {
            failures.lock().unwrap().push((receiver, why))
        });
        let task = tokio::spawn(telling);
        while self.ledger.list_receivers().await.unwrap().len() < receivers {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        task
    }

    pub(super) async fn refuse(&self, ledger: &Ledger, name: &str) {
        let claim = format!("{name}{}", ledger.last_event_id().await.unwrap());
        let part = NewPartRow { name: name.to_owned(), machine: "cube".to_owned(), ..fixtures::new_part(&claim, 2) };
        let id = ledger.record_claim(&part).await.unwrap().id;
        ledger.refuse_claim(id, RefusalCause::NotClosed, "The mesh is not closed.\nMend it.").await.unwrap();
    }

    async fn wait(&self, hook: &TestWebhook, count: usize) -> Vec<serde_json::Value> {
        let hook = hook.clone();
        tokio::task::spawn_blocking(move || hook.wait_for_delivered(count)).await.unwrap()
    }
}

pub(super) fn read(folder: &Path, ledger: &Path, notify: &str) -> Settings {
    fs::create_dir_all(folder.join("profiles")).unwrap();
    fs::write(folder.join("profiles/cube.toml"), "volume_mm = [200, 200, 200]\n").unwrap();
    let notify = notify.replace("SECRET", &folder.join("secret").display().to_string());
    fs::write(folder.join("nestd.toml"), format!("[notify]\n{notify}\n")).unwrap();
    let settings = settings::load_settings(Some(&folder.join("nestd.toml")), Some(folder)).unwrap();
    Settings { ledger: ledger.into(), ..settings }
}

/// A program that runs the script; FOLDER is replaced by a path.
fn program(folder: &Path, script: &str) -> String {
    let file = folder.join("tell");
    let script = script.replace("FOLDER", &folder.display().to_string());
    fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    file.display().to_string()
}

fn texts(delivered: &[serde_json::Value], key: &str) -> Vec<String> {
    delivered.iter().map(|message| message[key].as_str().unwrap_or_default().to_owned()).collect()
}

#[test]
fn the_signature_is_hmac_sha256_of_time_and_body() {
    // The result of Python's hmac.new(key, b'1795150140.{"id":"1"}', "sha256").hexdigest().
    let is = "t=1795150140,v1=3bded4376f6960ea175556c98fce8ea8e7f60ad8fae745a9161254ac19bd78cb";
    assert_eq!(sign_body(SECRET, 1_795_150_140, "{\"id\":\"1\"}"), is);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_event_is_sent_until_the_receiver_has_it_once_and_in_order() {
    let hook = TestWebhook::with_answers(&[500, 503]);
    let farm = OutboxFixture::of(&hook, "").await;
    farm.refuse(&farm.ledger, "before.stl").await;
    let task = farm.tell(1).await;
    for name in ["a.stl", "<script>alert(1)</script>.stl", "new\nline \"quoted\".stl"] {
        farm.refuse(&farm.ledger, name).await;
    }
    farm.ledger
        .write_event(EventKind::Unavailable, "cube", None, None, "cube: The hot folder is unavailable.")
        .await
        .unwrap();
    let delivered = farm.wait(&hook, 4).await;
    tokio::time::sleep(Duration::from_millis(1200)).await;
    task.abort();
    let (received, names) = (hook.received(), delivered.iter().map(|m| m["part"]["name"].as_str().unwrap_or("")));
    assert_eq!(received.iter().map(|h| h.answered).collect::<Vec<_>>(), [500, 503, 200, 200, 200, 200]);
    let wanted = ["a.stl", "<script>alert(1)</script>.stl", "new\nline \"quoted\".stl", ""];
    assert_eq!(names.collect::<Vec<_>>(), wanted, "what was before the receiver came is not told");
    assert_eq!(texts(&delivered, "kind"), ["refused", "refused", "refused", "unavailable"]);
    assert_eq!(texts(&delivered, "reason"), ["not-closed", "not-closed", "not-closed", ""]);
    assert_eq!(delivered[0]["text"], "Part 2 (a.stl) of cube was refused: The mesh is not closed.");
    let ids = |of: &[hook::ReceivedRequest]| of.iter().map(|h| h.header("nestd-id").to_owned()).collect::<Vec<_>>();
    assert!(ids(&received[..3]).windows(2).all(|pair| pair[0] == pair[1]), "a repeat has the id of the first");
    assert_eq!(ids(&received[2..]).iter().collect::<std::collections::BTreeSet<_>>().len(), 4);
    for one in &received {
        let at = one.header("nestd-signature").strip_prefix("t=").unwrap().split(',').next().unwrap().parse().unwrap();
        assert_eq!(one.header("nestd-signature"), sign_body(SECRET, at, &one.body));
        assert!((Timestamp::now().as_second() - at).abs() < 60);
        assert_eq!(one.header("nestd-event"), one.json()["kind"]);
        assert_eq!(one.header("nestd-id"), one.json()["id"]);
        assert_eq!(one.header("content-type"), "application/json");
    }
    let row = farm.ledger.find_or_add_receiver(ReceiverKind::Webhook).await.unwrap();
    assert_eq!((row.failing_at, row.failure.as_str(), row.dropped), (None, "", 0));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nothing_is_lost_over_a_restart_and_a_receiver_that_was_taken_out_begins_anew() {
    let hook = TestWebhook::with_answers(&[]);
    let farm = OutboxFixture::of(&hook, "events = [\"refused\"]").await;
    let task = farm.tell(1).await;
    farm.refuse(&farm.ledger, "a.stl").await;
    farm.wait(&hook, 1).await;
    // What was delivered and is not recorded yet would be delivered again.
    let told = async || farm.ledger.list_receivers().await.unwrap()[0].delivered_id;
    while told().await < farm.ledger.last_event_id().await.unwrap() {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    task.abort();
    let _ = task.await;
    farm.refuse(&farm.ledger, "b.stl").await;
    farm.ledger.write_event(EventKind::Unavailable, "cube", None, None, "nobody wants to hear this").await.unwrap();
    farm.refuse(&farm.ledger, "c.stl").await;
    let task = farm.tell(1).await;
    let delivered = farm.wait(&hook, 3).await;
    assert_eq!(delivered.iter().map(|m| m["part"]["name"].clone()).collect::<Vec<_>>(), ["a.stl", "b.stl", "c.stl"]);
    // Removed from the configuration and added again.
    let with = farm.settings.read().unwrap().clone();
    *farm.settings.write().unwrap() = Arc::new(read(farm.folder.path(), farm.ledger.file().unwrap(), ""));
    while !farm.ledger.list_receivers().await.unwrap().is_empty() {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    farm.refuse(&farm.ledger, "meanwhile.stl").await;
    *farm.settings.write().unwrap() = with;
    while farm.ledger.list_receivers().await.unwrap().is_empty() {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    farm.refuse(&farm.ledger, "again.stl").await;
    let delivered = farm.wait(&hook, 4).await;
    assert_eq!(delivered[3]["part"]["name"], "again.stl");
    task.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_receiver_that_hangs_holds_up_neither_the_other_one_nor_the_stop() {
    let hook = TestWebhook::with_answers(&[0, 0, 0, 0]);
    let farm = OutboxFixture::of(&hook, "").await;
    let command = program(farm.folder.path(), "cat >> FOLDER/heard; echo >> FOLDER/heard");
    let notify =
        format!("webhook = \"{}\"\nsecret_file = \"SECRET\"\ntimeout_secs = 1\ncommand = [\"{command}\"]\n", hook.url);
    *farm.settings.write().unwrap() = Arc::new(read(farm.folder.path(), farm.ledger.file().unwrap(), &notify));
    let task = farm.tell(2).await;
    for name in ["a.stl", "b.stl", "c.stl"] {
        farm.refuse(&farm.ledger, name).await;
    }
    let began = Instant::now();
    while fs::read_to_string(farm.path("heard")).unwrap_or_default().lines().count() < 3 {
        assert!(began.elapsed() < Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    while farm.ledger.find_or_add_receiver(ReceiverKind::Webhook).await.unwrap().failing_at.is_none() {
        assert!(began.elapsed() < Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let stop = Instant::now();
    task.abort();
    let _ = task.await;
    assert!(stop.elapsed() < Duration::from_millis(500), "{:?}", stop.elapsed());
    let received = fs::read_to_string(farm.path("heard")).unwrap();
    let names: Vec<_> = received.lines().map(|l| serde_json::from_str::<serde_json::Value>(l).unwrap()).collect();
    assert_eq!(names.iter().map(|m| m["part"]["name"].clone()).collect::<Vec<_>>(), ["a.stl", "b.stl", "c.stl"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_too_old_is_dropped_and_that_is_reported() {
    let hook = TestWebhook::with_answers(&[500; 1]);
    let farm = OutboxFixture::of(&hook, "keep_secs = \"1h\"").await;
    let task = farm.tell(1).await;
    let old = Timestamp::now().checked_sub(SignedDuration::from_hours(2)).unwrap();
    let then = (*farm.ledger).clone().with_clock(move || old);
    farm.refuse(&then, "old.stl").await;
    farm.refuse(&then, "older.stl").await;
    farm.refuse(&farm.ledger, "new.stl").await;
    let delivered = farm.wait(&hook, 2).await;
    assert_eq!(texts(&delivered, "kind"), ["refused", "dropped"]);
    assert_eq!(delivered[0]["part"]["name"], "new.stl");
    assert!(delivered[1]["text"].as_str().unwrap().contains("2 to the webhook"), "{}", delivered[1]);
    assert_eq!(farm.ledger.find_or_add_receiver(ReceiverKind::Webhook).await.unwrap().dropped, 2);
    task.abort();
}

#[tokio::test]
async fn a_receiver_that_fails_for_long_needs_a_person_until_it_receives_again() {
    let hook = TestWebhook::with_answers(&[500]);
    let farm = OutboxFixture::of(&hook, "").await;
    farm.ledger.find_or_add_receiver(ReceiverKind::Webhook).await.unwrap();
    let long_ago = Timestamp::now().checked_sub(SignedDuration::from_mins(10)).unwrap();
    (*farm.ledger)
        .clone()
        .with_clock(move || long_ago)
        .record_delivery_failure(ReceiverKind::Webhook, "away")
        .await
        .unwrap();
    let task = farm.tell(1).await;
    farm.refuse(&farm.ledger, "a.stl").await;
    farm.wait(&hook, 1).await;
    tokio::time::sleep(Duration::from_millis(200)).await;
    task.abort();
    let failures = farm.failures.lock().unwrap().clone();
    let failure = failures.iter().find_map(|(_, why)| why.as_ref());
    assert!(failure.is_some_and(|why| why.contains("answers 500")), "{failures:?}");
    assert_eq!(failures.last().unwrap().1, None);
}

#[tokio::test]
async fn a_command_is_given_the_message_and_no_shell_sees_a_name() {
    let farm = OutboxFixture::new("").await;
    let command = program(
        farm.folder.path(),
        "cat > FOLDER/stdin; printf '%s|%s|%s|%s|%s' \"$1\" \"$NESTD_EVENT\" \"$NESTD_PART\" \"$NESTD_TEXT\" \"$NOTIFY_SOCKET\" > FOLDER/env",
    );
    farm.refuse(&farm.ledger, "$(touch FOLDER/evil) `x`; rm *.stl").await;
    let kinds = event_kinds(&farm.settings.read().unwrap().interfaces.notify.events);
    let event = farm.ledger.next_event(0, &kinds).await.unwrap().unwrap();
    let message = EventMessage::from_event(&event, &farm.ledger).await.unwrap();
    let notify = format!("command = [\"{command}\", \"one two\"]\n");
    let notify = read(farm.folder.path(), farm.ledger.file().unwrap(), &notify).interfaces.notify;
    send_message(&notify, ReceiverKind::Command, &message).unwrap();
    assert_eq!(fs::read_to_string(farm.path("stdin")).unwrap(), message.body);
    let env = fs::read_to_string(farm.path("env")).unwrap();
    assert_eq!(env, format!("one two|refused|1|{}|", message.text));
    assert!(message.text.contains("$(touch FOLDER/evil) `x`; rm *.stl"));
    let body: serde_json::Value = serde_json::from_str(&message.body).unwrap();
    assert_eq!(body["part"]["name"], "$(touch FOLDER/evil) `x`; rm *.stl");
}

#[tokio::test]
async fn a_command_that_fails_or_hangs_has_received_nothing_and_leaves_nothing_running() {
    let farm = OutboxFixture::new("").await;
    let failing = program(farm.folder.path(), "echo no such printer >&2; exit 3");
    let read = |words: &str| read(farm.folder.path(), farm.ledger.file().unwrap(), words).interfaces.notify;
    let failed = send_message(
        &read(&format!("command = [\"{failing}\"]\n")),
        ReceiverKind::Command,
        &EventMessage::trial_message(),
    );
    let failed = failed.unwrap_err().to_string();
    assert!(failed.ends_with("ended with exit code 3: no such printer"), "{failed}");
    let hanging = program(farm.folder.path(), "sleep 300 & echo $! > FOLDER/pid; wait");
    let began = Instant::now();
    let notify = read(&format!("command = [\"{hanging}\"]\ntimeout_secs = 0.5\n"));
    let failed = send_message(&notify, ReceiverKind::Command, &EventMessage::trial_message()).unwrap_err().to_string();
    assert!(failed.contains("took longer than 500ms and was killed"), "{failed}");
    assert!(began.elapsed() < Duration::from_secs(10));
    let pid = fs::read_to_string(farm.path("pid")).unwrap();
    let status = || fs::read_to_string(format!("/proc/{}/status", pid.trim())).unwrap_or_default();
    // A killed process may remain as a zombie until its parent notices.
    while !(status().is_empty() || status().contains("Z (zombie)")) {
        assert!(began.elapsed() < Duration::from_secs(10), "what it started is still there");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let missing =
        send_message(&read("command = [\"/nowhere/at/all\"]\n"), ReceiverKind::Command, &EventMessage::trial_message());
    assert!(missing.unwrap_err().to_string().contains("starting /nowhere/at/all"));
}

#[test]
fn receivers_that_make_no_sense_are_objected_to() {
    let folder = tempfile::tempdir().unwrap();
    for (wrong, why) in [
        ("webhook = \"farm.example.org/hook\"\nsecret_file = \"/x\"", "is no address of a web server"),
        ("webhook = \"https://\"\nsecret_file = \"/x\"", "is no address of a web server"),
        ("webhook = \"https://farm.example.org/hook\"", "no notify.secret_file"),
        ("command = [\"tell\"]", "is no whole path"),
        ("timeout_secs = 0", "notify.timeout_secs = 0 makes no sense"),
        ("keep_secs = \"1s\"", "notify.keep_secs = 1 makes no sense"),
        ("events = [\"everything\"]", "everything"),
    ] {
        fs::create_dir_all(folder.path().join("profiles")).unwrap();
        fs::write(folder.path().join("profiles/cube.toml"), "volume_mm = [200, 200, 200]\n").unwrap();
        fs::write(folder.path().join("nestd.toml"), format!("[notify]\n{wrong}\n")).unwrap();
        let refused = settings::load_settings(Some(&folder.path().join("nestd.toml")), None).unwrap_err().to_string();
        assert!(refused.contains(why), "{wrong}: {refused}");
    }
}

#[tokio::test]
async fn a_due_date_at_risk_is_reported_once_for_all_parts_of_an_order() {
    let ledger = fixtures::fresh().await;
    let due = Timestamp::now();
    let mut ids = Vec::new();
    for claim in ["a", "b"] {
        let part = fixtures::asked(fixtures::new_part(claim, 1), |terms| {
            (terms.due_at, terms.order_name) = (Some(due), "1042".to_owned());
        });
        let id = ledger.record_claim(&part).await.unwrap().id;
        ledger.accept_solids(id, &[fixtures::solid(0, 1)]).await.unwrap();
        ids.push(id);
    }
    assert_eq!(ledger.unwarned_due_parts().await.unwrap().iter().map(|p| p.id).collect::<Vec<_>>(), ids);
    ledger.record_at_risk("paper-200", &ids, "a.stl, b.stl of 1042 are due now: that date has passed.").await.unwrap();
    assert!(ledger.unwarned_due_parts().await.unwrap().is_empty());
    let event = ledger.next_event(0, &[EventKind::AtRisk]).await.unwrap().unwrap();
    let message = EventMessage::from_event(&event, &ledger).await.unwrap();
    assert_eq!((message.kind.word(), message.part), ("at-risk", Some(ids[0].0)));
    assert!(message.text.contains("are due now"), "{}", message.text);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_is_put_out_or_finds_no_room_is_told_where_that_is_asked_for() {
    let hook = TestWebhook::with_answers(&[]);
    let farm = OutboxFixture::of(&hook, "events = [\"put-out\", \"no-room\"]").await;
    let part = fixtures::waiting(&farm.ledger, "a", 2).await;
    let task = farm.tell(1).await;
    for (kind, text) in [(EventKind::PutOut, "1 copy of a.stl left"), (EventKind::NoRoom, "1 copy of a.stl cannot")] {
        farm.ledger.write_event(kind, "cube", Some(part), None, text).await.unwrap();
    }
    let delivered = farm.wait(&hook, 2).await;
    task.abort();
    assert_eq!(texts(&delivered, "kind"), ["put-out", "no-room"]);
    assert_eq!(texts(&delivered, "text"), ["cube: 1 copy of a.stl left", "cube: 1 copy of a.stl cannot"]);
    assert_eq!(delivered[0]["part"]["name"], "a.stl");
}
