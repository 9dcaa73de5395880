//! Changes and cancellations of programs: of lines that arrive, of parts that are read, and those that are done in part.

use ledger::{CommandKind, Ledger, NewPartRow, PartId, PartState, RefusalCause};
use serde_json::{Value, json};

use super::{
    door_tests::{ApiAnswer, CUBE, assert_described, of_lines, order, put, send},
    *,
};

async fn patch(dashboard: &TestDashboard, path: &str, change: Value) -> ApiAnswer {
    let request = Request::patch(path).header("content-type", "application/json");
    send(dashboard, request, change.to_string()).await
}

async fn delete(dashboard: &TestDashboard, path: &str) -> ApiAnswer {
    send(dashboard, Request::delete(path), "").await
}

fn part_of_order(claim: &str) -> NewPartRow {
    let part = fixtures::asked(fixtures::new_part(claim, 2), |terms| "K-1".clone_into(&mut terms.order_name));
    NewPartRow { machine: "cube".to_owned(), ..part }
}

/// A part of order K-1 with so many solids; 0 = it is not read yet.
async fn claim(dashboard: &TestDashboard, claim: &str, solids: u32) -> PartId {
    let id = dashboard.ledger.record_claim(&part_of_order(claim)).await.unwrap().id;
    let solids: Vec<_> = (0..solids).map(|index| fixtures::solid(index, 2)).collect();
    if !solids.is_empty() {
        dashboard.ledger.accept_solids(id, &solids).await.unwrap();
    }
    id
}

/// Answers the commands that come, as a daemon does that refuses what concerns this part. Returns what was asked.
fn answer_commands(ledger: &Ledger, refused: Option<PartId>) -> tokio::task::JoinHandle<Vec<(CommandKind, PartId)>> {
    let ledger = ledger.clone();
    tokio::spawn(async move {
        let mut seen = Vec::new();
        for _ in 0..100 {
            for command in ledger.pending_commands().await.unwrap() {
                let part = command.part_id.unwrap();
                if command.kind == CommandKind::Cancel && refused != Some(part) {
                    ledger.cancel_part(part, RefusalCause::Cancelled, "not wanted").await.unwrap();
                }
                seen.push((command.kind, part));
                ledger.answer_command(command.id, refused != Some(part), &format!("part {part}")).await.unwrap();
            }
            tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        }
        seen
    })
}

#[tokio::test]
async fn lines_that_arrive_are_cancelled_and_their_claims_become_no_parts_that_wait() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let hash = put(&dashboard, CUBE).await;
    let lines = ["a.stl", "b.stl", "c.stl"].map(|name| json!({ "name": name, "content": hash }));
    let taken = order(&dashboard, "k", of_lines(json!(lines))).await;
    let claim_of = |at: usize| taken.json["lines"][at]["line"].as_str().unwrap().to_owned();
    let address = format!("/api/v1/orders/K-1/lines/{}", claim_of(0));
    assert_eq!(patch(&dashboard, &address, json!({ "priority": 90 })).await.headers["retry-after"], "1");
    assert_eq!(patch(&dashboard, "/api/v1/orders/K-1", json!({ "priority": 90 })).await.headers["retry-after"], "1");
    let one = delete(&dashboard, &address).await;
    assert_eq!((one.status, &one.json["done"]), (StatusCode::OK, &json!(true)), "{}", one.json);
    assert_described("/api/v1/orders/{order}/lines/{line}", "delete", &one);
    assert_eq!(dashboard.ledger.arriving_lines("cube", 9).await.unwrap().len(), 2);
    let asked = send(&dashboard, Request::get(&address), "").await;
    assert_eq!((&asked.json["arriving"], &asked.json["cancelled"]), (&json!(false), &json!(true)), "{}", asked.json);
    assert_described("/api/v1/orders/{order}/lines/{line}", "get", &asked);
    assert_eq!(delete(&dashboard, &address).await.status, StatusCode::CONFLICT);
    // Its claim was made at the same time.
    dashboard.ledger.record_claim(&part_of_order(&claim_of(0))).await.unwrap();
    let part = dashboard.ledger.parts_of_claim(&claim_of(0)).await.unwrap().remove(0);
    assert_eq!((part.state, part.refused.refusal), (PartState::Refused, Some(RefusalCause::Cancelled)));
    let all = delete(&dashboard, "/api/v1/orders/K-1").await;
    assert_eq!((all.status, all.json["answers"].as_array().unwrap().len()), (StatusCode::OK, 2), "{}", all.json);
    assert!(dashboard.ledger.arriving_lines("cube", 9).await.unwrap().is_empty());
    assert_eq!(delete(&dashboard, "/api/v1/orders/K-1").await.status, StatusCode::CONFLICT);
    assert_eq!(delete(&dashboard, "/api/v1/orders/other").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn what_is_being_read_is_cancelled_with_its_order_and_changed_once_it_is_read() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let (read, unread) = (claim(&dashboard, "a", 1).await, claim(&dashboard, "b", 0).await);
    for path in ["/api/v1/orders/K-1".to_owned(), format!("/api/v1/orders/K-1/lines/{unread}")] {
        let early = patch(&dashboard, &path, json!({ "priority": 90 })).await;
        assert_eq!(early.status, StatusCode::TOO_MANY_REQUESTS, "{path}");
    }
    assert!(dashboard.ledger.pending_commands().await.unwrap().is_empty(), "nothing was changed of the others");
    let daemon = answer_commands(&dashboard.ledger, None);
    let done = delete(&dashboard, "/api/v1/orders/K-1").await;
    assert_eq!((done.status, &done.json["done"]), (StatusCode::OK, &json!(true)), "{}", done.json);
    daemon.abort();
    for part in [read, unread] {
        assert_eq!(dashboard.ledger.find_part(part).await.unwrap().unwrap().state, PartState::Refused);
    }
}

#[tokio::test]
async fn copies_are_changed_part_by_part() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let (package, single) = (claim(&dashboard, "package", 3).await, claim(&dashboard, "single", 1).await);
    for (path, change) in [
        ("/api/v1/orders/K-1", json!({ "copies": 5 })),
        ("/api/v1/orders/K-1", json!({ "unit": "inch", "priority": 3 })),
        ("/api/v1/orders/K-1", json!({ "orientation": "free" })),
        ("/api/v1/orders/K-1/lines/package", json!({ "copies": 2 })),
    ] {
        let refused = patch(&dashboard, path, change.clone()).await;
        let detail = refused.json["detail"].as_str().unwrap();
        assert_eq!(refused.status, StatusCode::UNPROCESSABLE_ENTITY, "{change}: {detail}");
        assert!(detail.contains(&format!("/api/v1/orders/K-1/lines/{package}")), "{detail}");
    }
    assert!(dashboard.ledger.pending_commands().await.unwrap().is_empty());
    let daemon = answer_commands(&dashboard.ledger, None);
    for part in [package, single] {
        let path = format!("/api/v1/orders/K-1/lines/{part}");
        assert_eq!(patch(&dashboard, &path, json!({ "copies": 2 })).await.status, StatusCode::OK);
    }
    assert_eq!(daemon.await.unwrap(), [(CommandKind::Edit, package), (CommandKind::Edit, single)]);
}

#[tokio::test]
async fn what_is_done_in_part_says_what_was_done_and_what_was_refused() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let (first, second) = (claim(&dashboard, "a", 1).await, claim(&dashboard, "b", 1).await);
    let daemon = answer_commands(&dashboard.ledger, Some(second));
    let told = patch(&dashboard, "/api/v1/orders/K-1", json!({ "priority": 90 })).await;
    daemon.abort();
    assert_eq!(told.status, StatusCode::CONFLICT);
    let (done, refused) = (format!("part {first}."), format!("part {second}."));
    assert_eq!((&told.json["done"], &told.json["refused"]), (&json!([done]), &json!([refused])), "{}", told.json);
    let detail = told.json["detail"].as_str().unwrap();
    assert!(detail.contains(&done) && detail.contains(&refused), "{detail}");
}

#[tokio::test]
async fn what_was_done_is_answered_in_words_also_while_the_daemon_still_writes_them() {
    let dashboard = TestDashboard::new(|_| ()).await;
    claim(&dashboard, "a", 1).await;
    let ledger = (*dashboard.ledger).clone();
    let daemon = tokio::spawn(async move {
        let command = loop {
            match ledger.pending_commands().await.unwrap().pop() {
                Some(command) => break command,
                None => tokio::time::sleep(std::time::Duration::from_millis(5)).await,
            }
        };
        // As the farm does: the change first, with its command done, and then the words.
        let edit = command.read_argument().unwrap().edit.unwrap();
        let part = command.part_id.unwrap();
        let edited = ledger.for_command(command.id).edit_part(part, &edit, &command.asked_by).await.unwrap();
        tokio::time::sleep(std::time::Duration::from_millis(300)).await;
        ledger.answer_command(command.id, true, &format!("part {part}: {}", edited.changes.join(", "))).await.unwrap();
    });
    let answer = patch(&dashboard, "/api/v1/orders/K-1/lines/1", json!({ "copies": 5 })).await;
    daemon.await.unwrap();
    assert_eq!((answer.status, &answer.json["done"]), (StatusCode::OK, &json!(true)), "{}", answer.json);
    let words = answer.json["answers"][0].as_str().unwrap();
    assert!(words.starts_with("part 1: ") && words.contains('5') && words.ends_with('.'), "{words}");
}
