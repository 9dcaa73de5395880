//! Orders that come by request: once for each key, and a part for each line.

use super::*;

fn line(claim: &str) -> OrderedLine {
    OrderedLine {
        claim: claim.to_owned(),
        client: "mes".to_owned(),
        machine: "paper-200".to_owned(),
        order_name: "K-1".to_owned(),
        name: "a.stl".to_owned(),
        content_hash: "ab".repeat(32),
        copies: 2,
        ticket: "{}".to_owned(),
        read_unit: None,
    }
}

fn order(client: &str, key: &str, fingerprint: &str, claims: &[&str]) -> NewOrderRequest {
    let answered = AnsweredRequest { fingerprint: fingerprint.to_owned(), answer: format!("{{\"{key}\":1}}") };
    let lines = claims.iter().map(|claim| line(claim)).collect();
    NewOrderRequest { client: client.to_owned(), key: key.to_owned(), answered, lines }
}

#[tokio::test]
async fn a_key_is_one_order_of_its_client_and_a_line_arrives_until_it_has_a_part() {
    let ledger = fresh().await;
    let first = order("mes", "k", "f", &["order-1", "order-2"]);
    assert_eq!(ledger.record_order_request(&first).await.unwrap(), RecordedRequest::New);
    let known = RecordedRequest::Known(first.answered.clone());
    assert_eq!(ledger.record_order_request(&first).await.unwrap(), known);
    assert_eq!(ledger.record_order_request(&order("mes", "k", "other", &["order-3"])).await.unwrap(), known);
    assert_eq!(ledger.find_answered_request("mes", "k").await.unwrap(), Some(first.answered));
    assert_eq!(ledger.find_answered_request("shop", "k").await.unwrap(), None);
    let arriving = async || -> Vec<String> {
        let lines = ledger.arriving_lines("paper-200", 100).await.unwrap();
        assert_eq!(lines, ledger.arriving_lines_of_order("K-1").await.unwrap());
        lines.into_iter().map(|line| line.claim).collect()
    };
    assert_eq!(arriving().await, ["order-1", "order-2"]);
    assert_eq!(ledger.newest_arriving_line("paper-200").await.unwrap().as_deref(), Some("order-2"));
    assert_eq!(ledger.arriving_lines("paper-200", 1).await.unwrap().len(), 1);
    assert!(ledger.arriving_lines("other", 100).await.unwrap().is_empty());
    for _ in 0..2 {
        let part = ledger.record_claim(&new_part("order-2", 2)).await.unwrap().id;
        let events = ledger.events_of_part(part).await.unwrap();
        assert!(events.len() == 1 && events[0].detail.ends_with(", ordered by mes"), "{events:?}");
    }
    assert_eq!(arriving().await, ["order-1"]);
    assert_eq!(ledger.contents_of_arriving_lines().await.unwrap(), ["ab".repeat(32)]);
}

#[tokio::test]
async fn a_request_that_comes_again_after_a_ledger_was_put_back_finds_its_parts() {
    let ledger = fresh().await;
    // What a reconciliation takes in from the note of the claim.
    ledger.record_claim(&new_part("order-1", 2)).await.unwrap();
    ledger.record_order_request(&order("mes", "k", "f", &["order-1", "order-2"])).await.unwrap();
    let lines = ledger.arriving_lines("paper-200", 100).await.unwrap();
    assert_eq!(lines.iter().map(|line| line.claim.as_str()).collect::<Vec<_>>(), ["order-2"]);
}

#[tokio::test]
async fn keys_are_forgotten_after_their_time_and_lines_once_they_are_parts() {
    let ledger = fresh().await;
    ledger.record_order_request(&order("mes", "k", "f", &["order-1", "order-2"])).await.unwrap();
    ledger.record_claim(&new_part("order-2", 2)).await.unwrap();
    let now = Timestamp::now();
    ledger.forget_order_requests(UtcTimestamp(now - jiff::SignedDuration::from_secs(60))).await.unwrap();
    assert!(ledger.find_answered_request("mes", "k").await.unwrap().is_some());
    ledger.forget_order_requests(UtcTimestamp(now + jiff::SignedDuration::from_secs(60))).await.unwrap();
    assert_eq!(ledger.find_answered_request("mes", "k").await.unwrap(), None);
    assert_eq!(ledger.arriving_lines("paper-200", 100).await.unwrap().len(), 1, "it is still owed");
    let again = order("mes", "k", "f", &["order-1", "order-2"]);
    assert_eq!(ledger.record_order_request(&again).await.unwrap(), RecordedRequest::NewAgain);
    assert_eq!(ledger.arriving_lines("paper-200", 100).await.unwrap().len(), 1, "and is not owed twice");
}

#[tokio::test]
async fn a_line_that_is_cancelled_before_it_is_a_part_never_waits_also_when_its_claim_was_made_meanwhile() {
    let ledger = fresh().await;
    ledger.record_order_request(&order("mes", "k", "f", &["order-1", "order-2", "order-3"])).await.unwrap();
    assert_eq!(ledger.count_arriving_lines().await.unwrap(), [("paper-200".to_owned(), 3)]);
    assert_eq!(ledger.is_cancelled_line("K-1", "order-1").await.unwrap(), Some(false));
    ledger.record_claim(&new_part("order-3", 2)).await.unwrap();
    assert!(!ledger.cancel_arriving_line(&line("order-3"), "by ann").await.unwrap(), "it is a part");
    assert!(!ledger.has_cancelled_lines("K-1").await.unwrap());
    let events = ledger.last_event_id().await.unwrap();
    for is_first in [true, false] {
        assert_eq!(ledger.cancel_arriving_line(&line("order-1"), "by ann").await.unwrap(), is_first);
    }
    assert_eq!(ledger.last_event_id().await.unwrap(), events + 1);
    assert!(ledger.has_cancelled_lines("K-1").await.unwrap());
    assert_eq!(ledger.is_cancelled_line("K-1", "order-1").await.unwrap(), Some(true));
    assert_eq!(ledger.is_cancelled_line("K-2", "order-1").await.unwrap(), None);
    assert_eq!(ledger.arriving_lines_of_order("K-1").await.unwrap(), [line("order-2")]);
    for claim in ["order-1", "order-2"] {
        let part = asked(new_part(claim, 2), |terms| "K-1".clone_into(&mut terms.order_name));
        let recorded = ledger.record_claim(&part).await.unwrap();
        let part = ledger.find_part(recorded.id).await.unwrap().unwrap();
        let state = if claim == "order-1" { PartState::Refused } else { PartState::Claimed };
        assert_eq!((recorded.is_new(), part.state), (true, state));
    }
    assert!(!ledger.has_cancelled_lines("K-1").await.unwrap(), "it is a refused part");
    assert_eq!(ledger.order_lines("K-1").await.unwrap()[0].copies.cancelled, 2);
}

#[tokio::test]
async fn a_part_has_the_unit_in_which_its_line_was_judged() {
    let ledger = fresh().await;
    let mut asked = order("mes", "k", "f", &["order-a"]);
    asked.lines[0].read_unit = Some(build_file::LengthUnit::Inch);
    ledger.record_order_request(&asked).await.unwrap();
    let mut claim = new_part("order-a", 1);
    claim.terms.read_unit = Some(build_file::LengthUnit::Millimeter);
    let part = ledger.record_claim(&claim).await.unwrap().id;
    let row = ledger.find_part(part).await.unwrap().unwrap();
    assert_eq!(row.measures.read_unit, Some(build_file::LengthUnit::Inch));
    let other = ledger.record_claim(&NewPartRow { claim: "b".to_owned(), ..claim }).await.unwrap().id;
    let row = ledger.find_part(other).await.unwrap().unwrap();
    assert_eq!(row.measures.read_unit, Some(build_file::LengthUnit::Millimeter), "a dropped one that of its machine");
}

#[tokio::test]
async fn of_two_nodes_that_begin_with_one_form_one_has_it_and_all_share_a_secret() {
    let ledger = fresh().await;
    let [begun, done] =
        ["begun", "done"].map(|answer| AnsweredRequest { fingerprint: "f".into(), answer: answer.into() });
    let record = async |new: &AnsweredRequest, known: Option<&AnsweredRequest>| {
        ledger.record_answered_request("ann", "k", new, known).await.unwrap()
    };
    assert!(record(&begun, None).await);
    assert!(!record(&begun, None).await, "another node has begun");
    assert!(record(&done, Some(&begun)).await);
    assert!(!record(&begun, Some(&begun)).await, "it is done");
    assert_eq!(ledger.find_answered_request("ann", "k").await.unwrap(), Some(done));
    let secret = ledger.farm_secret("form keys", "first").await.unwrap();
    assert_eq!(
        (secret.as_str(), ledger.farm_secret("form keys", "second").await.unwrap().as_str()),
        ("first", "first")
    );
}
