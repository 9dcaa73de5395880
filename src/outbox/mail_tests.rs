//! Mails to a real SMTP server, as people get them.

use std::{collections::BTreeSet, fs, os::unix::fs::PermissionsExt, sync::Arc, time::Duration};

use jiff::{SignedDuration, Timestamp};
use ledger::{EventKind, Ledger, PartId, ReceiverKind, RefusalCause};
use ledger_fixtures as fixtures;

use super::{
    mail::compose_mails,
    send_trial,
    tests::{OutboxFixture, read},
};

#[path = "../../tests/support/smtp.rs"]
mod smtp;
use smtp::{ReceivedMail, TestMailServer};

const PEOPLE: &str = "technician = [\"tech@example.org\"]\nplanner = [\"plan@example.org\"]\ngather_secs = 0";

async fn wait(server: &TestMailServer, count: usize) -> Vec<ReceivedMail> {
    let server = server.clone();
    tokio::task::spawn_blocking(move || server.wait_for(count)).await.unwrap()
}

/// A part of an order of which a customer gets a mail, and the event that the order is complete.
async fn complete(ledger: &Ledger, order: &str, email: &str) -> PartId {
    let part = fixtures::asked(fixtures::new_part(&format!("{order}{email}"), 2), |terms| {
        (terms.order_name, terms.email) = (order.to_owned(), email.to_owned());
    });
    let id = ledger.record_claim(&part).await.unwrap().id;
    let detail = format!("order {order}: 2 good of 2 wanted");
    ledger.write_event(EventKind::OrderComplete, "cube", Some(id), None, &detail).await.unwrap();
    id
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_refused_file_is_told_to_the_technician_as_soon_as_the_server_takes_it() {
    let server = TestMailServer::with_answers(&[451], &[]);
    let farm = OutboxFixture::new(&server.settings(PEOPLE)).await;
    let task = farm.tell(4).await;
    farm.refuse(&farm.ledger, "Bügel\r\nBcc: all@example.org.stl").await;
    let mail = wait(&server, 1).await.remove(0);
    assert_eq!(server.refusals(), 1, "it was refused once, and sent again");
    assert_eq!((mail.from.as_str(), mail.to.as_slice()), ("farm@example.org", &["tech@example.org".to_owned()][..]));
    assert_eq!(mail.header("from"), "\"Print farm\" <farm@example.org>");
    assert_eq!(mail.header("to"), "tech@example.org");
    assert_eq!(mail.header("bcc"), "", "{mail:?}");
    assert_eq!(mail.header("subject"), "cube: Bügel  Bcc: all@example.org.stl was refused");
    assert_eq!(mail.header("auto-submitted"), "auto-generated");
    assert!(mail.header("content-type").starts_with("text/plain; charset=utf-8"), "{mail:?}");
    assert!(mail.header("message-id").starts_with("<nestd.") && mail.header("message-id").ends_with("@example.org>"));
    let date = jiff::fmt::rfc2822::parse(mail.header("date")).unwrap().timestamp();
    assert!(Timestamp::now().duration_since(date).abs() < SignedDuration::from_mins(2));
    assert!(mail.text.contains("    The mesh is not closed.\n    Mend it.\n"), "{}", mail.text);
    task.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_burst_is_one_mail_and_the_next_one_waits_over_a_restart() {
    let server = TestMailServer::with_answers(&[], &[]);
    let people = PEOPLE.replace("gather_secs = 0", "gather_secs = 3");
    let farm = OutboxFixture::new(&server.settings(&people)).await;
    let task = farm.tell(4).await;
    farm.refuse(&farm.ledger, "first.stl").await;
    wait(&server, 1).await;
    let sent = std::time::Instant::now();
    // Where the ledger does not know yet that it was sent, it would be sent again.
    while farm.ledger.find_or_add_receiver(ReceiverKind::EmailRefused).await.unwrap().told_at.is_none() {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    for name in ["a.stl", "b.stl"] {
        farm.refuse(&farm.ledger, name).await;
    }
    let cancelled = fixtures::waiting(&farm.ledger, "cancelled", 1).await;
    farm.ledger.refuse_claim(cancelled, RefusalCause::Cancelled, "ann@desk cancelled it").await.ok();
    task.abort();
    let _ = task.await;
    let task = farm.tell(4).await;
    let mails = wait(&server, 2).await;
    assert!(sent.elapsed() > Duration::from_secs(2), "{:?}", sent.elapsed());
    assert_eq!(mails[1].header("subject"), "cube: 2 files were refused");
    assert!(mails[1].text.contains("a.stl") && mails[1].text.contains("b.stl"), "{}", mails[1].text);
    tokio::time::sleep(Duration::from_millis(1500)).await;
    assert_eq!(server.taken().len(), 2, "what is told is not told again");
    task.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_customer_gets_one_mail_about_the_own_orders_and_an_unknown_address_holds_up_nobody() {
    let server = TestMailServer::with_answers(&[], &["gone@example.org"]);
    let farm = OutboxFixture::new(&server.settings("gather_secs = 0")).await;
    let task = farm.tell(1).await;
    task.abort();
    let _ = task.await;
    complete(&farm.ledger, "K-1", "gone@example.org").await;
    complete(&farm.ledger, "K-2", "ann@example.org").await;
    complete(&farm.ledger, "K-3", "").await;
    complete(&farm.ledger, "K-4", "ann@example.org").await;
    let task = farm.tell(1).await;
    let mails = wait(&server, 1).await;
    assert_eq!(mails[0].to, ["ann@example.org"]);
    assert!(mails[0].header("subject").starts_with("Your orders K-2"), "{}", mails[0].header("subject"));
    assert!(mails[0].text.contains("Your order K-4 is complete"), "{}", mails[0].text);
    assert!(!mails[0].text.contains("K-1") && !mails[0].text.contains("K-3"), "{}", mails[0].text);
    let dropped = farm.ledger.next_event(0, &[EventKind::MessagesDropped]).await.unwrap().unwrap();
    assert!(dropped.detail.contains("gone@example.org") && dropped.detail.contains("550"), "{}", dropped.detail);
    tokio::time::sleep(Duration::from_millis(1500)).await;
    assert_eq!(server.taken().len(), 1);
    let row = farm.ledger.find_or_add_receiver(ReceiverKind::EmailOrderComplete).await.unwrap();
    assert_eq!((row.dropped, row.failing_at), (1, None));
    task.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_technician_whom_the_server_refuses_for_ever_is_an_alert_as_a_webhook_is() {
    let server = TestMailServer::with_answers(&[], &["tech@example.org"]);
    let farm = OutboxFixture::new(&server.settings(PEOPLE)).await;
    farm.ledger.find_or_add_receiver(ReceiverKind::EmailRefused).await.unwrap();
    let long_ago = Timestamp::now().checked_sub(SignedDuration::from_mins(10)).unwrap();
    let then = (*farm.ledger).clone().with_clock(move || long_ago);
    then.record_delivery_failure(ReceiverKind::EmailRefused, "away").await.unwrap();
    let task = farm.tell(4).await;
    farm.refuse(&farm.ledger, "a.stl").await;
    let why = || {
        let failures = farm.failures.lock().unwrap();
        failures.iter().find_map(|(receiver, why)| why.clone().filter(|_| *receiver == ReceiverKind::EmailRefused))
    };
    let began = std::time::Instant::now();
    while why().is_none() {
        assert!(began.elapsed() < Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    task.abort();
    let why = why().unwrap();
    assert!(why.starts_with("the mail of refused files: 127.0.0.1:"), "{why}");
    assert!(why.contains("does not accept the recipient tech@example.org") && why.contains("550"), "{why}");
    assert_eq!(server.taken().len(), 0);
}

#[tokio::test]
async fn alerts_and_dates_are_told_in_the_language_of_the_farm() {
    let server = TestMailServer::with_answers(&[], &[]);
    let farm = OutboxFixture::new(&server.settings(PEOPLE)).await;
    let detail = "The queue folder is unavailable\nnot mounted\nMount it.";
    farm.ledger.record_alert("cube", "queue-away", detail).await.unwrap();
    let events = farm.ledger.events_after(0, &[EventKind::Alert], 10).await.unwrap();
    let email = farm.settings.read().unwrap().interfaces.notify.email.clone().unwrap();
    let (mut said, none) = (Vec::new(), BTreeSet::new());
    for language in language::Language::ALL {
        let mails = compose_mails((&email, language), ReceiverKind::EmailAlert, &events, &farm.ledger, &none);
        let mail = mails.await.unwrap().remove(0);
        assert!(mail.subject.contains("cube") && mail.text.contains("not mounted"), "{mail:?}");
        assert!(!said.contains(&mail.subject), "{mail:?}");
        said.push(mail.subject);
    }
    assert_eq!(said[0], "cube: The queue folder is unavailable");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_trial_signs_in_with_the_password_of_its_file_and_says_what_is_wrong() {
    let server = TestMailServer::with_answers(&[], &[]);
    let login = format!("{PEOPLE}\nuser = \"farm\"\npassword_file = \"SECRET\"");
    let farm = OutboxFixture::new(&server.settings(&login)).await;
    let settings = Arc::clone(&farm.settings.read().unwrap());
    let failed = send_trial(&settings, ReceiverKind::EmailAlert).unwrap_err().to_string();
    assert!(failed.contains("does not accept the user or the password") && failed.contains("535"), "{failed}");
    let secret = farm.path("secret");
    assert!(!failed.contains(fs::read_to_string(&secret).unwrap().trim()), "{failed}");
    fs::write(&secret, "open sesame\n").unwrap();
    let done = send_trial(&settings, ReceiverKind::EmailAtRisk).unwrap();
    assert!(done.contains("plan@example.org"), "{done}");
    let mail = server.wait_for(1).remove(0);
    assert_eq!(mail.login, Some(("farm".to_owned(), "open sesame".to_owned())));
    assert_eq!(mail.header("subject"), "A test mail of the print farm");
    assert!(send_trial(&settings, ReceiverKind::EmailOrderComplete).unwrap().contains("none was sent"));
    assert_eq!(server.taken().len(), 1, "customers get no trial");
    fs::set_permissions(&secret, fs::Permissions::from_mode(0o644)).unwrap();
    let failed = send_trial(&settings, ReceiverKind::EmailAlert).unwrap_err().to_string();
    assert!(failed.contains("everybody may read"), "{failed}");
    // A server that does not encrypt gets nothing.
    let secret_only = server.settings(PEOPLE).replace("encryption = \"none\"", "encryption = \"starttls\"");
    let settings = read(farm.folder.path(), farm.ledger.file().unwrap(), &secret_only);
    let failed = send_trial(&settings, ReceiverKind::EmailAlert).unwrap_err().to_string();
    assert!(failed.contains("does not offer STARTTLS"), "{failed}");
    assert_eq!(server.taken().len(), 1);
}

#[test]
fn settings_of_mail_that_make_no_sense_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("profiles")).unwrap();
    fs::write(folder.path().join("profiles/cube.toml"), "volume_mm = [200, 200, 200]\n").unwrap();
    let from = "from = \"farm@example.org\"\ntechnician = [\"a@example.org\"]\n";
    for (wrong, why, remedy) in [
        (format!("server = \"mail.example.org/x\"\n{from}"), "is no name of a mail server", "mail.example.org:587"),
        (format!("server = \"mail.example.org\"\nencryption = \"none\"\n{from}"), "for everybody to read", "starttls"),
        ("server = \"mail.example.org\"".to_owned(), "no notify.email.from", "Print farm <farm@example.org>"),
        ("server = \"mail.example.org\"\nfrom = \"the farm\"".to_owned(), "is no address", "farm@example.org"),
        (format!("server = \"m.example.org\"\nuser = \"me\"\n{from}"), "no notify.email.password_file", "chmod 640"),
        (format!("server = \"m.example.org\"\npassword_file = \"/x\"\n{from}"), "no notify.email.user", "signs in"),
        ("planner = [\"Ann\"]".to_owned(), "\"Ann\" is no address", "name@example.org"),
        ("gather_secs = \"2d\"".to_owned(), "gather_secs = 172800 makes no sense", "86400"),
        (
            "server = \"m.example.org\"\nfrom = \"farm@example.org\"\ncustomers = false".to_owned(),
            "nobody gets a mail",
            "notify.email.technician",
        ),
        ("password = \"secret\"".to_owned(), "password", "password_file"),
    ] {
        fs::write(folder.path().join("nestd.toml"), format!("[notify.email]\n{wrong}\n")).unwrap();
        let refused = settings::load_settings(Some(&folder.path().join("nestd.toml")), None).unwrap_err().to_string();
        assert!(refused.contains(why) && refused.contains(remedy), "{wrong}: {refused}");
    }
}
