//! People and their sessions: who is known, what ends a session, and that nothing secret leaves.

use std::sync::{
    Arc,
    atomic::{AtomicI64, Ordering},
};

use access::{PasswordHash, Role};

use super::*;

const BY: &str = "op@host";

fn hash(text: &str) -> PasswordHash {
    // The ledger does not look into it.
    PasswordHash::from_stored(format!("$argon2id${text}"))
}

/// A ledger with anna, who operates, and bert, who looks.
async fn with_two() -> TestLedger {
    let ledger = fresh().await;
    ledger.add_person("Anna", Role::Operate, &hash("anna"), BY).await.unwrap();
    ledger.add_person("bert", Role::Read, &PasswordHash::default(), BY).await.unwrap();
    ledger
}

async fn person_of(ledger: &Ledger, token: &str) -> Option<(String, Role)> {
    let session = ledger.find_session(token).await.unwrap()?;
    session.person.zip(session.role)
}

#[tokio::test]
async fn a_name_is_known_in_any_case_once_and_what_changes_for_it_is_an_event_that_says_who_did_it() {
    let ledger = fresh().await;
    assert!(!ledger.has_people().await.unwrap());
    ledger.add_person("Änne", Role::Admin, &hash("1"), BY).await.unwrap();
    assert!(ledger.has_people().await.unwrap());
    let twice = ledger.add_person("änne", Role::Read, &hash("2"), BY).await.unwrap_err();
    assert!(matches!(&twice, LedgerError::PersonKnown(name) if name == "Änne"), "{twice}");
    let found = ledger.find_person(" ÄNNE ").await.unwrap().unwrap();
    assert_eq!(
        (found.name.as_str(), found.role, found.has_password, found.has_pin),
        ("Änne", Role::Admin, true, false)
    );
    assert!(ledger.find_person("anne").await.unwrap().is_none());
    assert_eq!(ledger.find_secrets("änne").await.unwrap().unwrap().password, hash("1"));
    for change in [
        PersonChange::Role(Role::Order),
        PersonChange::Password(hash("3")),
        PersonChange::Pin(hash("4")),
        PersonChange::SignedOut,
        PersonChange::Removed,
    ] {
        assert_eq!(ledger.change_person("änne", &change, "bert@dashboard").await.unwrap(), "Änne");
    }
    let gone = ledger.change_person("Änne", &PersonChange::SignedOut, BY).await.unwrap_err();
    assert!(gone.to_string().contains("there is no person named Änne; `nestd people list`"), "{gone}");
    let last = ledger.last_event_id().await.unwrap();
    let mut told = Vec::new();
    for id in 1..=last {
        let event = ledger.find_event(id).await.unwrap().unwrap();
        assert_eq!(event.kind, EventKind::Person);
        told.push(event.detail);
    }
    let expected = [
        "Änne was added with the role admin, by op@host",
        "Änne was given the role order, by bert@dashboard",
        "Änne was given a new password, by bert@dashboard",
        "Änne was given a new PIN, by bert@dashboard",
        "Änne was signed out everywhere, by bert@dashboard",
        "Änne was removed, by bert@dashboard",
    ];
    assert_eq!(told, expected);
}

#[tokio::test]
async fn what_is_printed_of_people_has_nothing_secret_in_it() {
    let ledger = with_two().await;
    ledger.change_person("anna", &PersonChange::Pin(hash("pin")), BY).await.unwrap();
    let (people, secrets) = (ledger.list_people().await.unwrap(), ledger.find_secrets("anna").await.unwrap().unwrap());
    for text in [serde_json::to_string(&people).unwrap(), format!("{people:?}"), format!("{secrets:?}")] {
        assert!(text.contains("Anna") && !text.contains("argon2"), "{text}");
    }
    assert_eq!(people.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["Anna", "bert"]);
}

#[tokio::test]
async fn a_session_ends_by_sign_out_by_a_new_password_by_removal_and_after_a_time() {
    let clock = Arc::new(AtomicI64::new(1_800_000_000));
    let hand = clock.clone();
    let ledger = with_two().await;
    let turned = ledger.ledger.clone().with_clock(move || Timestamp::from_second(hand.load(Ordering::SeqCst)).unwrap());
    let open = async |token: &str, former: &str| turned.open_session(token, "Anna", false, former).await.unwrap();
    open("t1", "").await;
    assert_eq!(person_of(&turned, "t1").await, Some(("Anna".to_owned(), Role::Operate)));
    assert!(turned.find_person("anna").await.unwrap().unwrap().signed_in_at.is_some());
    open("t2", "t1").await;
    assert!(person_of(&turned, "t1").await.is_none(), "the browser has a new token");
    turned.change_person("Anna", &PersonChange::Role(Role::Read), BY).await.unwrap();
    assert_eq!(person_of(&turned, "t2").await, Some(("Anna".to_owned(), Role::Read)), "from the next request on");
    turned.end_session("t2").await.unwrap();
    assert!(person_of(&turned, "t2").await.is_none());
    for change in [PersonChange::Password(hash("new")), PersonChange::SignedOut] {
        open("t3", "").await;
        open("t4", "").await;
        turned.change_person("anna", &change, BY).await.unwrap();
        assert!(person_of(&turned, "t3").await.is_none() && person_of(&turned, "t4").await.is_none(), "{change:?}");
    }
    // Idle for a week; used, for thirty days.
    open("t5", "").await;
    clock.fetch_add(7 * 86_400 - 1, Ordering::SeqCst);
    assert!(person_of(&turned, "t5").await.is_some());
    clock.fetch_add(1, Ordering::SeqCst);
    assert!(person_of(&turned, "t5").await.is_none());
    open("t6", "").await;
    for day in 1..30 {
        clock.fetch_add(86_400, Ordering::SeqCst);
        assert!(person_of(&turned, "t6").await.is_some(), "{day}");
        turned.note_session_seen("t6").await.unwrap();
    }
    clock.fetch_add(86_400, Ordering::SeqCst);
    assert!(person_of(&turned, "t6").await.is_none());
    open("t7", "").await;
    turned.end_all_sessions().await.unwrap();
    assert!(person_of(&turned, "t7").await.is_none());
    open("t8", "").await;
    turned.change_person("anna", &PersonChange::Removed, BY).await.unwrap();
    assert!(person_of(&turned, "t8").await.is_none() && turned.find_person("anna").await.unwrap().is_none());
}

#[tokio::test]
async fn at_a_shared_device_people_go_on_with_a_pin_until_it_was_wrong_too_often() {
    let clock = Arc::new(AtomicI64::new(1_800_000_000));
    let hand = clock.clone();
    let ledger = with_two().await;
    let turned = ledger.ledger.clone().with_clock(move || Timestamp::from_second(hand.load(Ordering::SeqCst)).unwrap());
    turned.open_session("own", "Anna", false, "").await.unwrap();
    assert!(!turned.hand_session_on("own", "x", Some("bert")).await.unwrap(), "it is nobody else's");
    turned.open_session("t1", "Anna", true, "own").await.unwrap();
    assert!(turned.hand_session_on("t1", "t2", Some("bert")).await.unwrap());
    assert!(!turned.hand_session_on("t1", "t3", Some("bert")).await.unwrap(), "the former token is worth nothing");
    let session = turned.find_session("t2").await.unwrap().unwrap();
    assert!(session.with_pin && session.is_shared && session.person.as_deref() == Some("bert"));
    // Who does nothing for a while has left.
    clock.fetch_add(15 * 60, Ordering::SeqCst);
    let left = turned.find_session("t2").await.unwrap().unwrap();
    assert!(left.person.is_none() && left.role.is_none() && left.is_shared);
    assert!(turned.hand_session_on("t2", "t4", Some("bert")).await.unwrap());
    assert!(person_of(&turned, "t4").await.is_some());
    turned.change_person("bert", &PersonChange::Pin(hash("new")), BY).await.unwrap();
    assert!(turned.find_session("t4").await.unwrap().unwrap().person.is_none(), "the PIN is another one");
    for wrong in 1..=MAX_WRONG_PINS {
        assert_eq!(turned.count_wrong_pin("t4").await.unwrap(), wrong == MAX_WRONG_PINS);
    }
    assert!(turned.find_session("t4").await.unwrap().is_none());
    // The device is as trustworthy as the password that was given there.
    turned.open_session("t5", "Anna", true, "").await.unwrap();
    assert!(turned.hand_session_on("t5", "t6", Some("bert")).await.unwrap());
    turned.change_person("anna", &PersonChange::SignedOut, BY).await.unwrap();
    assert!(turned.find_session("t6").await.unwrap().is_none());
}
