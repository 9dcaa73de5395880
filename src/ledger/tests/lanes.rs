//! Lanes: each is taken by one node at a time, and what an earlier taker finds is not accepted.

use super::*;

/// A build, and the number of the search for it.
async fn searched(ledger: &Ledger, lanes: usize) -> (BuildId, i64) {
    let part = waiting(ledger, "a", 2).await;
    let build = nesting(ledger, &[(part, 0), (part, 1)]).await;
    (build, begin_search(ledger, build, lanes).await)
}

async fn begin_search(ledger: &Ledger, build: BuildId, lanes: usize) -> i64 {
    let tasks: Vec<String> = (0..lanes).map(|lane| format!("task {lane}")).collect();
    ledger.begin_lane_search(build, "the problem", "the plan", &tasks).await.unwrap()
}

async fn take(ledger: &Ledger, node: &str, searched: &[LaneId]) -> Option<TakenLane> {
    ledger.take_lane(node, searched, &[]).await.unwrap()
}

#[tokio::test]
async fn lanes_are_taken_in_order_and_their_results_found_by_round() {
    let ledger = fresh().await;
    let (build, search) = searched(&ledger, 2).await;
    let first = take(&ledger, "a", &[]).await.unwrap();
    assert_eq!((first.id, first.epoch), (LaneId { build, search, round: 0, lane: 0 }, 1));
    assert_eq!((first.problem.as_str(), first.task.as_str()), ("the problem", "task 0"));
    let second = take(&ledger, "a", &[first.id]).await.unwrap();
    assert_eq!((second.id.lane, second.task.as_str()), (1, "task 1"));
    assert_eq!(take(&ledger, "a", &[first.id, second.id]).await, None);
    assert!(ledger.end_lane(first.id, first.epoch, "found 0").await.unwrap());
    assert_eq!(ledger.lane_progress(search).await.unwrap(), Some(LaneProgress { round: 0, ended: 1, open: 1 }));
    assert!(ledger.end_lane(second.id, second.epoch, "found 1").await.unwrap());
    ledger.add_lane_round(search, 1, &["next".to_owned()]).await.unwrap();
    ledger.add_lane_round(search, 1, &["another".to_owned()]).await.unwrap();
    assert_eq!(ledger.lane_progress(search).await.unwrap(), Some(LaneProgress { round: 1, ended: 2, open: 1 }));
    let lanes = ledger.list_lanes(search).await.unwrap();
    let told: Vec<_> =
        lanes.iter().map(|row| (row.round, row.lane, row.task.as_str(), row.result.as_deref())).collect();
    assert_eq!(told, [(0, 0, "task 0", Some("found 0")), (0, 1, "task 1", Some("found 1")), (1, 0, "next", None)]);
}

#[tokio::test]
async fn a_lane_of_a_node_that_is_gone_is_taken_by_another_and_only_its_result_counts() {
    let ledger = fresh().await;
    let (_, search) = searched(&ledger, 1).await;
    let lost = take(&ledger, "gone", &[]).await.unwrap();
    let again = take(&ledger, "b", &[]).await.unwrap();
    assert_eq!((again.id, again.epoch), (lost.id, 2));
    assert!(!ledger.end_lane(lost.id, lost.epoch, "late").await.unwrap());
    assert!(ledger.end_lane(again.id, again.epoch, "found").await.unwrap());
    assert!(!ledger.end_lane(again.id, again.epoch, "found again").await.unwrap());
    assert_eq!(ledger.list_lanes(search).await.unwrap()[0].result.as_deref(), Some("found"));
}

#[tokio::test]
async fn a_node_that_was_started_again_takes_its_lane_again_and_one_given_back_is_free() {
    let ledger = fresh().await;
    searched(&ledger, 1).await;
    let before = take(&ledger, "a", &[]).await.unwrap();
    let after = take(&ledger, "a", &[]).await.unwrap();
    assert_eq!((after.id, after.epoch), (before.id, 2));
    ledger.give_lane_back(before.id, before.epoch).await.unwrap();
    assert_eq!(ledger.list_lanes(before.id.search).await.unwrap()[0].node, "a", "an earlier taker gives nothing back");
    ledger.give_lane_back(after.id, after.epoch).await.unwrap();
    assert_eq!(ledger.list_lanes(before.id.search).await.unwrap()[0].node, "");
}

#[tokio::test]
async fn a_lane_that_ends_every_node_is_not_taken_for_ever() {
    let ledger = fresh().await;
    searched(&ledger, 1).await;
    let taken = async |node: &'static str| take(&ledger, node, &[]).await.map(|lane| lane.epoch);
    assert_eq!(
        [taken("a").await, taken("b").await, taken("a").await, taken("b").await, taken("a").await],
        [Some(1), Some(2), Some(3), Some(4), None]
    );
}

#[tokio::test]
async fn a_node_that_cannot_search_for_a_build_takes_no_lane_of_it() {
    let ledger = fresh().await;
    let (_, search) = searched(&ledger, 1).await;
    assert_eq!(ledger.take_lane("a", &[], &[search]).await.unwrap(), None);
    assert_eq!(ledger.list_lanes(search).await.unwrap()[0].node, "");
}

#[tokio::test]
async fn a_search_goes_when_it_ends_or_its_build_is_not_nested_any_more() {
    let ledger = fresh().await;
    let (build, search) = searched(&ledger, 1).await;
    let taken = take(&ledger, "a", &[]).await.unwrap();
    assert_eq!(ledger.searches_in_lanes().await.unwrap(), [search]);
    ledger.end_lane_search(build).await.unwrap();
    assert_eq!(
        (ledger.find_lane_search(build).await.unwrap(), ledger.list_lanes(search).await.unwrap()),
        (None, vec![])
    );
    assert!(!ledger.end_lane(taken.id, taken.epoch, "late").await.unwrap());
    begin_search(&ledger, build, 1).await;
    ledger.fail_build(build, "it cannot be").await.unwrap();
    assert!(ledger.searches_in_lanes().await.unwrap().is_empty());
}

#[tokio::test]
async fn what_was_found_for_a_search_is_not_taken_for_another_one_of_the_same_build() {
    let ledger = fresh().await;
    let (build, _) = searched(&ledger, 1).await;
    let of_old = take(&ledger, "a", &[]).await.unwrap();
    let search = begin_search(&ledger, build, 1).await;
    let of_new = take(&ledger, "a", &[of_old.id]).await.unwrap();
    assert_eq!((of_new.id.search, of_new.epoch), (search, of_old.epoch));
    assert!(!ledger.end_lane(of_old.id, of_old.epoch, "old").await.unwrap());
    assert!(ledger.end_lane(of_new.id, of_new.epoch, "new").await.unwrap());
}
