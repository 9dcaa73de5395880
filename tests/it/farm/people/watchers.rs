//! External monitoring: a webhook, a metrics file, and the commands that test them.

use std::{fs, os::unix::fs::PermissionsExt, time::Duration};

use crate::support::{QUICK, TestFarm, block, wait_until_or, webhook::TestWebhook};

/// A farm that sends messages to a webhook and writes its metrics to a file.
fn farm(hook: &TestWebhook, more: &str) -> TestFarm {
    let farm = TestFarm::new(QUICK);
    let secret = farm.root().join("secret");
    fs::write(&secret, "a-key-of-some-length-for-tests\n").unwrap();
    fs::set_permissions(&secret, fs::Permissions::from_mode(0o600)).unwrap();
    let config = fs::read_to_string(farm.config()).unwrap();
    let file = farm.root().join("nestd.prom");
    let more = format!(
        "{config}[metrics]\ntextfile = \"{}\"\nevery_secs = 1\n[notify]\nwebhook = \"{}\"\nsecret_file = \"{}\"\n{more}\n",
        file.display(),
        hook.url,
        secret.display()
    );
    fs::write(farm.config(), more).unwrap();
    farm
}

/// The number of threads of the farm's daemon whose names begin with `name`.
fn threads(farm: &TestFarm, name: &str) -> usize {
    let threads = fs::read_dir(format!("/proc/{}/task", farm.pid())).unwrap().flatten();
    threads.filter(|thread| fs::read_to_string(thread.path().join("comm")).is_ok_and(|is| is.starts_with(name))).count()
}

#[test]
fn a_farm_that_nobody_watches_has_no_threads_for_it_and_begins_when_the_settings_say_so() {
    let mut farm = TestFarm::new(QUICK);
    farm.start();
    farm.drop_part("block.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(ledger::PartState::Waiting, 1);
    assert_eq!(threads(&farm, "nestd-watch"), 0);
    let file = farm.root().join("nestd.prom");
    let config = fs::read_to_string(farm.config()).unwrap();
    let more = format!(
        "{config}[metrics]\ntextfile = \"{}\"\nevery_secs = 1\n[web]\nlisten = \"unix:{}\"\n",
        file.display(),
        farm.root().join("web.sock").display()
    );
    fs::write(farm.config(), more).unwrap();
    farm.reload();
    wait_until_or("the metrics are written", 20.0, || farm.log(), || file.is_file());
    assert!(threads(&farm, "nestd-watch") > 0);
    assert!(farm.log().contains("The new values in [web] take effect at the next start"), "{}", farm.log());
    farm.stop();
}

#[test]
fn a_farm_tells_what_is_published_and_refused_and_writes_its_metrics() {
    let hook = TestWebhook::with_answers(&[500]);
    let mut farm = farm(&hook, "");
    farm.start();
    let knows_receiver = || farm.query_ledger(async |ledger| !ledger.list_receivers().await.unwrap().is_empty());
    wait_until_or("the webhook has its place", 20.0, || farm.log(), knows_receiver);
    farm.drop_bytes("<b>torn.stl", b"solid no");
    let refused = hook.wait_for_delivered(1);
    assert_eq!((refused[0]["kind"].as_str(), refused[0]["machine"].as_str()), (Some("refused"), Some("test")));
    assert_eq!(refused[0]["part"]["name"], "<b>torn.stl");
    farm.drop_part("block_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(ledger::PartState::Waiting, 1);
    farm.flush();
    let delivered = hook.wait_for_delivered(2);
    assert_eq!(delivered[1]["kind"], "published", "{delivered:#?}");
    assert_eq!(delivered[1]["build"]["copies"], 2);
    let name = delivered[1]["build"]["file"].as_str().unwrap().to_owned();
    assert!(farm.folder("queue").join(name).is_file());
    let file = farm.root().join("nestd.prom");
    let is_written = || {
        let text = fs::read_to_string(&file).unwrap_or_default();
        ["nestd_daemon_up 1.0", "nestd_queue_writable{machine=\"test\"} 1.0", "nestd_available{machine=\"test\"} 1.0"]
            .iter()
            .all(|line| text.contains(line))
    };
    wait_until_or("the metrics are written", 30.0, || fs::read_to_string(&file).unwrap_or_default(), is_written);
    assert!(farm.nestd_ok(&["metrics"]).contains("nestd_files_ingested_total{machine=\"test\"} 2"));
    let is_delivered = || farm.nestd_ok(&["notify"]).contains("webhook: 0 messages wait, 0 were dropped");
    wait_until_or("the ledger knows that all is delivered", 10.0, || farm.nestd_ok(&["notify"]), is_delivered);
    assert!(farm.nestd_ok(&["notify", "--test"]).contains("The webhook has the message trial@"));
    assert_eq!(hook.delivered().last().unwrap()["kind"], "test");
    assert!(farm.nestd_ok(&["check"]).contains("webhook of [notify]"));
    farm.stop();
    // Every event was delivered once; the trial message is no event.
    let mut ids: Vec<String> = hook.delivered().iter().map(|m| m["id"].as_str().unwrap().to_owned()).collect();
    ids.sort();
    let count = ids.len();
    ids.dedup();
    assert_eq!((ids.len(), count), (3, 3));
}

#[test]
fn a_receiver_that_hangs_holds_up_neither_a_build_nor_the_stop() {
    let hook = TestWebhook::with_answers(&[0; 50]);
    let mut farm = farm(&hook, "timeout_secs = 30");
    farm.start();
    let knows_receiver = || farm.query_ledger(async |ledger| !ledger.list_receivers().await.unwrap().is_empty());
    wait_until_or("the webhook has its place", 20.0, || farm.log(), knows_receiver);
    farm.drop_bytes("torn.stl", b"solid no");
    wait_until_or("the webhook hangs", 30.0, || farm.log(), || !hook.received().is_empty());
    farm.drop_part("block.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(ledger::PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_queued(1);
    farm.stop();
    // After the restart it receives both messages; the first perhaps twice, with the same id.
    hook.set_answers(&[]);
    farm.start();
    let delivered = hook.wait_for_delivered(2);
    let kinds: Vec<&str> = delivered.iter().filter_map(|m| m["kind"].as_str()).collect();
    assert!(kinds.contains(&"refused") && kinds.contains(&"published"), "{kinds:?}");
    std::thread::sleep(Duration::from_millis(200));
    farm.stop();
}

#[test]
fn a_machine_whose_queue_is_away_and_a_due_date_that_is_over_are_reported_once() {
    let hook = TestWebhook::with_answers(&[]);
    let mut farm = farm(&hook, "events = [\"unavailable\", \"at-risk\"]");
    farm.start();
    let knows_receiver = || farm.query_ledger(async |ledger| !ledger.list_receivers().await.unwrap().is_empty());
    wait_until_or("the webhook has its place", 20.0, || farm.log(), knows_receiver);
    let is_available =
        || farm.query_ledger(async |ledger| ledger.list_machines().await.unwrap().iter().any(|s| s.is_queue_writable));
    wait_until_or("the machine is known to be available", 30.0, || farm.log(), is_available);
    let (queue, away) = (farm.folder("queue"), farm.root().join("away"));
    fs::rename(&queue, &away).unwrap();
    farm.drop_bytes("block.stl.toml", b"due = \"2020-01-01\"\n");
    farm.drop_part("block.stl", &block(20.0, 20.0, 20.0));
    let delivered = hook.wait_for_delivered(2);
    let of = |kind: &str| {
        delivered.iter().find(|m| m["kind"] == kind).unwrap_or_else(|| panic!("no {kind} in {delivered:#?}"))
    };
    assert!(of("at-risk")["text"].as_str().unwrap().contains("block.stl is due 2020-01-0"), "{delivered:#?}");
    assert!(of("unavailable")["text"].as_str().unwrap().starts_with("test: "), "{delivered:#?}");
    fs::remove_dir_all(&queue).ok();
    fs::rename(&away, &queue).unwrap();
    let delivered = hook.wait_for_delivered(3);
    assert_eq!(delivered[2]["kind"], "available", "{delivered:#?}");
    assert_eq!(delivered[2]["text"], "test is available again.");
    farm.stop();
    assert_eq!(hook.delivered().len(), 3);
}
