//! Mails to the people of a farm and to its customers, and events that programs ask for: nothing is lost or doubled over restarts.

use std::{fs, thread, time::Duration};

use ledger::PartState;
use serde_json::Value;

use crate::support::{
    QUICK, TestFarm, block,
    http::send_request,
    smtp::{CERTIFICATE, Speech, TestMailServer},
    wait_until_or,
};

fn farm(server: &TestMailServer) -> TestFarm {
    let farm = TestFarm::new(QUICK);
    let config = fs::read_to_string(farm.config()).unwrap();
    let mails = server.settings("technician = [\"tech@example.org\"]\ngather_secs = 0");
    let web = format!("[web]\nlisten = \"unix:{}\"\n", farm.root().join("web.sock").display());
    fs::write(farm.config(), format!("language = \"de\"\n{config}{web}{mails}")).unwrap();
    farm
}

fn wait_for_receivers(farm: &TestFarm) {
    let are_known = || farm.query_ledger(async |ledger| ledger.list_receivers().await.unwrap().len() == 3);
    wait_until_or("the receivers have their places", 20.0, || farm.log(), are_known);
}

/// Asks for all events, two at a time.
fn poll(farm: &TestFarm, after: &mut String, known: &mut Vec<Value>) {
    loop {
        let words = format!("GET /api/v1/events?limit=2&after={after}");
        let answer = send_request(&farm.root().join("web.sock"), &words, b"").unwrap();
        let page: Value = serde_json::from_str(&answer.body).unwrap_or_else(|_| panic!("{}", answer.body));
        *after = page["last"].as_str().unwrap().to_owned();
        let events = page["events"].as_array().unwrap();
        known.extend(events.iter().cloned());
        if events.len() < 2 {
            return;
        }
    }
}

#[test]
fn a_refused_file_mails_the_technician_and_a_complete_order_its_customer_once_over_a_crash() {
    let server = TestMailServer::with_answers(&[], &[]);
    let mut farm = farm(&server);
    farm.start();
    wait_for_receivers(&farm);
    fs::create_dir(farm.folder("inbox").join("K-7")).unwrap();
    farm.drop_bytes("K-7/good.stl.toml", b"copies = 2\nemail = \"ann@brandt.example\"\n");
    farm.drop_part("K-7/good.stl", &block(20.0, 20.0, 20.0));
    farm.drop_bytes("torn.stl", b"solid no");
    let refused = server.wait_for(1).remove(0);
    assert_eq!(refused.to, ["tech@example.org"]);
    assert_eq!(refused.header("subject"), "test: torn.stl wurde abgelehnt");
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    let (mut after, mut known) = (String::new(), Vec::new());
    poll(&farm, &mut after, &mut known);
    // The daemon ends while the outcome is told, and again after the mail is sent.
    farm.kill();
    farm.nestd_ok(&["outcome", "1", "complete"]);
    farm.start();
    let mails = server.wait_for(2);
    assert_eq!(mails[1].to, ["ann@brandt.example"]);
    assert_eq!(mails[1].header("subject"), "Ihr Auftrag K-7 ist fertig");
    assert!(mails[1].text.contains("    2 × good.stl"), "{}", mails[1].text);
    assert!(!mails[1].text.contains("torn"), "{}", mails[1].text);
    let is_recorded = || farm.nestd_ok(&["notify"]).contains("mail to customers: 0 messages wait, 0 were dropped");
    wait_until_or("the ledger knows that it is sent", 20.0, || farm.nestd_ok(&["notify"]), is_recorded);
    farm.kill();
    farm.start();
    wait_for_receivers(&farm);
    thread::sleep(Duration::from_millis(2500));
    let told: Vec<String> = server.taken().iter().map(|mail| mail.header("subject").to_owned()).collect();
    assert_eq!(told.iter().filter(|subject| subject.contains("K-7")).count(), 1, "{told:#?}");
    assert_eq!(told.iter().filter(|subject| subject.contains("torn")).count(), 1, "{told:#?}");
    wait_until_or("the dashboard answers", 20.0, || farm.log(), || farm.root().join("web.sock").exists());
    poll(&farm, &mut after, &mut known);
    let numbers: Vec<i64> =
        known.iter().map(|event| event["id"].as_str().unwrap().split('@').next().unwrap().parse().unwrap()).collect();
    assert!(numbers.is_sorted_by(|a, b| a < b), "each event once, in order: {numbers:?}");
    let kinds: Vec<&str> = known.iter().map(|event| event["kind"].as_str().unwrap()).collect();
    for kind in ["refused", "published", "order-complete"] {
        assert_eq!(kinds.iter().filter(|one| **one == kind).count(), 1, "{kinds:?}");
    }
    assert!(farm.nestd_ok(&["notify", "--test"]).contains("has taken a mail of alerts to tech@example.org"));
    assert!(farm.nestd_ok(&["check"]).contains("mail server of [notify]"));
}

#[test]
fn what_needs_a_person_is_mailed_once_though_the_daemon_begins_anew() {
    let server = TestMailServer::with_answers(&[], &[]);
    let mut farm = farm(&server);
    farm.start();
    wait_for_receivers(&farm);
    let is_available =
        || farm.query_ledger(async |ledger| ledger.list_machines().await.unwrap().iter().any(|s| s.is_queue_writable));
    wait_until_or("the machine is known to be available", 30.0, || farm.log(), is_available);
    fs::rename(farm.folder("queue"), farm.root().join("away")).unwrap();
    fs::write(farm.folder("queue"), "").unwrap();
    let mail = server.wait_for(1).remove(0);
    assert!(mail.header("subject").starts_with("test: "), "{mail:?}");
    // What was sent and is not recorded yet would be sent again, as to a webhook.
    let is_recorded = || farm.nestd_ok(&["notify"]).contains("mail of alerts: 0 messages wait");
    wait_until_or("the ledger knows that it is sent", 20.0, || farm.nestd_ok(&["notify"]), is_recorded);
    farm.kill();
    farm.start();
    thread::sleep(Duration::from_secs(3));
    let subjects: Vec<String> = server.taken().iter().map(|mail| mail.header("subject").to_owned()).collect();
    assert_eq!(subjects.iter().filter(|subject| *subject == mail.header("subject")).count(), 1, "{subjects:#?}");
}

#[test]
fn a_mail_server_on_the_network_is_spoken_to_encrypted_or_not_at_all() {
    for (speech, word) in [(Speech::Starttls, "starttls"), (Speech::Tls, "tls")] {
        let server = TestMailServer::speaking(speech, &[], &[]);
        let farm = farm(&server);
        let certificate = farm.root().join("certificate.pem");
        fs::write(&certificate, CERTIFICATE).unwrap();
        let config = fs::read_to_string(farm.config()).unwrap();
        let config = config.replace("encryption = \"none\"", &format!("encryption = \"{word}\""));
        fs::write(farm.config(), config.replace("127.0.0.1:", "localhost:")).unwrap();
        let refused = farm.nestd(&["notify", "--test"]);
        let why = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(1) && why.contains("certificate"), "{word}: {why}");
        assert_eq!(server.taken().len(), 0, "{word}");
        let done = farm.command(&["notify", "--test"]).env("SSL_CERT_FILE", &certificate).output().unwrap();
        assert!(done.status.success(), "{word}: {done:?}");
        let mail = server.wait_for(1).remove(0);
        assert_eq!((mail.to, mail.text.contains("nestd")), (vec!["tech@example.org".to_owned()], true), "{word}");
    }
}
