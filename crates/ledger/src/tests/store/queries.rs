//! Tests of the queries of users and the farm: waiting parts, duplicates, commands, status, history, views.

use crate::{base::sql, tests::*};
use std::{
    collections::BTreeSet,
    sync::{
        Arc,
        atomic::{AtomicI64, Ordering},
    },
};

/// The words in the first `CHECK (<column> IN (...))` of a table.
async fn checked_words(ledger: &Ledger, table: &str, column: &str) -> BTreeSet<String> {
    let sql: String = sql::query_scalar("SELECT sql FROM sqlite_schema WHERE name = ?")
        .bind(table)
        .fetch_one(ledger.reader().unwrap())
        .await
        .unwrap();
    let list = sql.split(&format!("CHECK ({column} IN (")).nth(1).unwrap().split(')').next().unwrap().to_owned();
    list.split(',').map(|word| word.trim().trim_matches('\'').to_owned()).collect()
}

#[tokio::test]
async fn the_schema_and_the_state_machines_know_the_same_words() {
    let ledger = fresh().await;
    let parts: BTreeSet<String> = PartState::ALL.iter().map(|s| s.to_string()).collect();
    assert_eq!(checked_words(&ledger, "part", "state").await, parts);
    let builds: BTreeSet<String> = BuildState::ALL.iter().map(|s| s.to_string()).collect();
    assert_eq!(checked_words(&ledger, "build", "state").await, builds);
    for word in checked_words(&ledger, "outcome", "outcome").await {
        assert_eq!(crate::base::text_column::parse_word::<PrintOutcome>(&word).unwrap().to_string(), word);
    }
    for word in checked_words(&ledger, "command", "kind").await {
        assert_eq!(crate::base::text_column::parse_word::<CommandKind>(&word).unwrap().to_string(), word);
    }
    for word in checked_words(&ledger, "part", "orientation").await {
        assert_eq!(
            crate::base::text_column::to_word(&crate::base::text_column::parse_word::<OrientationRule>(&word).unwrap()),
            word
        );
    }
    for word in checked_words(&ledger, "ticket", "source").await {
        assert_eq!(crate::base::text_column::parse_word::<TicketSource>(&word).unwrap().to_string(), word);
    }
}

#[test]
fn a_state_machine_allows_its_own_moves_and_no_other() {
    let legal: usize =
        (PartState::ALL.iter()).flat_map(|from| PartState::ALL.iter().filter(|to| from.move_to(**to).is_ok())).count();
    assert_eq!(legal, 9);
    let legal: usize = (BuildState::ALL.iter())
        .flat_map(|from| BuildState::ALL.iter().filter(|to| from.move_to(**to).is_ok()))
        .count();
    assert_eq!(legal, 16);
    let back = BuildState::Nesting.move_to(BuildState::Open).unwrap_err();
    assert_eq!(back.to_string(), "a build that is nesting cannot become open");
    assert!(PartState::Built.move_to(PartState::Batched).is_err(), "what is built waits before it is built again");
}

#[tokio::test]
async fn copies_stand_in_line_by_priority_then_due_date_then_age() {
    let clock = Arc::new(AtomicI64::new(1_800_000_000));
    let hand = clock.clone();
    let ledger = fresh().await;
    let turned = ledger.ledger.clone().with_clock(move || Timestamp::from_second(hand.load(Ordering::SeqCst)).unwrap());
    let mut claims = Vec::new();
    for (claim, priority, due) in [
        ("late", 50, None),
        ("due-2", 50, Some("2026-12-02T00:00:00Z")),
        ("due-1", 50, Some("2026-12-01T00:00:00Z")),
        ("urgent", 100, None),
        ("younger", 50, None),
    ] {
        let part = asked(new_part(claim, 1), |terms| (terms.priority, terms.due_at) = (priority, due.map(at)));
        claims.push(turned.record_claim(&part).await.unwrap().id);
        clock.fetch_add(60, Ordering::SeqCst);
    }
    for id in claims.into_iter().rev() {
        turned.accept_solids(id, &[solid(0, 1)]).await.unwrap();
    }
    let line = turned.waiting_copies("paper-200").await.unwrap();
    let names: Vec<&str> = line.iter().map(|w| w.part.file.claim.as_str()).collect();
    assert_eq!(names, ["urgent", "due-1", "due-2", "late", "younger"]);
    assert_eq!(line[0].part.times.claimed_at.to_string(), "2027-01-15T08:03:00.000Z");
    let oldest: Vec<String> =
        turned.parts_in_state(PartState::Waiting).await.unwrap().into_iter().map(|p| p.file.claim).collect();
    assert_eq!(oldest, ["late", "due-2", "due-1", "urgent", "younger"]);
}

#[tokio::test]
async fn an_identical_file_of_another_claim_is_found() {
    let ledger = fresh().await;
    let same = |claim: &str| NewPartRow { content_hash: "f".repeat(64), ..new_part(claim, 1) };
    let first = ledger.record_claim(&same("a")).await.unwrap().id;
    let second = ledger.record_claim(&same("b")).await.unwrap().id;
    let hash = "f".repeat(64);
    assert_eq!(ledger.find_earlier_part("paper-200", &hash, second).await.unwrap(), Some(first));
    assert_eq!(ledger.find_earlier_part("paper-200", &hash, first).await.unwrap(), None);
    assert_eq!(ledger.find_earlier_part("fuse-1", &hash, second).await.unwrap(), None);
    assert!(ledger.is_hash_in_use(&hash, jiff::Timestamp::MAX).await.unwrap());
    ledger.refuse_claim(first, RefusalCause::Format, "no").await.unwrap();
    assert_eq!(ledger.find_earlier_part("paper-200", &hash, second).await.unwrap(), None);
}

#[tokio::test]
async fn a_change_that_a_command_asked_for_is_committed_together_with_the_command() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 5).await;
    let cancel = NewCommand {
        kind: CommandKind::Cancel,
        machine: String::new(),
        part: Some(part),
        argument: CommandArgument { copies: Some(2), edit: None, ..CommandArgument::default() },
        asked_by: "ann@farm".into(),
    };
    let id = ledger.submit_command(&cancel).await.unwrap();
    let refused = ledger.for_command(id).cancel_copies(part, 9, "ann@farm").await;
    assert!(refused.is_err() && ledger.pending_commands().await.unwrap().len() == 1, "nothing was done");
    ledger.for_command(id).cancel_copies(part, 2, "ann@farm").await.unwrap();
    // A daemon that is killed here finds nothing to carry out again.
    assert!(ledger.pending_commands().await.unwrap().is_empty());
    assert!(ledger.answer_command(id, false, "").await.is_err(), "it is done");
    ledger.answer_command(id, true, "2 copies of part 1 cancelled").await.unwrap();
    let row = ledger.find_command(id).await.unwrap().unwrap();
    assert_eq!((row.state, row.answer.as_str()), (CommandState::Done, "2 copies of part 1 cancelled"));
    assert!(ledger.answer_command(id, true, "again").await.is_err(), "it is answered");
}

#[tokio::test]
async fn a_command_is_asked_once_and_answered_once() {
    let ledger = fresh().await;
    let flush = NewCommand {
        kind: CommandKind::Flush,
        machine: "paper-200".into(),
        part: None,
        argument: CommandArgument::default(),
        asked_by: "ann@farm".into(),
    };
    let id = ledger.submit_command(&flush).await.unwrap();
    assert_eq!(ledger.pending_commands().await.unwrap()[0].id, id);
    ledger.answer_command(id, false, "nothing waits").await.unwrap();
    let row = ledger.find_command(id).await.unwrap().unwrap();
    assert_eq!((row.state, row.answer.as_str()), (CommandState::Refused, "nothing waits"));
    assert!(row.answered_at.is_some() && ledger.pending_commands().await.unwrap().is_empty());
    assert!(matches!(ledger.answer_command(id, true, "").await, Err(LedgerError::UnknownCommand(_))));
    let retry = NewCommand { kind: CommandKind::Retry, part: Some(PartId(9)), ..flush };
    assert!(matches!(ledger.submit_command(&retry).await, Err(LedgerError::UnknownPart(PartId(9)))));
}

#[tokio::test]
async fn a_machine_is_paused_until_it_is_resumed() {
    let ledger = fresh().await;
    assert!(ledger.pause_machine("fuse-1", "ann@farm", PauseCause::Person).await.unwrap());
    assert!(!ledger.pause_machine("fuse-1", "bob@farm", PauseCause::BuildFailed).await.unwrap());
    assert_eq!(ledger.paused_machines().await.unwrap(), ["fuse-1"]);
    let status = ledger.machine_statuses().await.unwrap();
    assert_eq!(status[0].paused.as_ref().unwrap().paused_by, "ann@farm");
    assert_eq!(status[0].paused.as_ref().unwrap().cause, PauseCause::Person);
    assert!(ledger.resume_machine("fuse-1", "ann@farm").await.unwrap());
    assert!(!ledger.resume_machine("fuse-1", "ann@farm").await.unwrap());
    assert!(ledger.paused_machines().await.unwrap().is_empty());
}

#[tokio::test]
async fn status_does_not_count_what_is_asked_about_among_what_is_collected() {
    let ledger = fresh().await;
    let (_, lacks) = (waiting(&ledger, "a", 3).await, waiting(&ledger, "b", 5).await);
    let asked = ledger.record_claim(&new_part("c", 2)).await.unwrap().id;
    let question = "its name says that it is not to be printed".to_owned();
    ledger.accept_solids(asked, &[SolidFacts { question, ..solid(0, 2) }]).await.unwrap();
    let hash = ledger.find_part(lacks).await.unwrap().unwrap().file.content_hash;
    ledger.mark_damaged(&hash, "its file is gone").await.unwrap();
    let counts = async || {
        let status = ledger.machine_statuses().await.unwrap().remove(0);
        (status.waiting_copies, status.collecting_copies, status.asked_copies)
    };
    assert_eq!(counts().await, (10, 3, 7));
    ledger.confirm_part(asked, "ann@farm").await.unwrap();
    assert_eq!(counts().await, (10, 5, 5));
}

#[tokio::test]
async fn status_counts_what_waits_and_shows_what_is_nested_and_published() {
    let ledger = fresh().await;
    let (a, b) = (waiting(&ledger, "a", 3).await, waiting(&ledger, "b", 2).await);
    ledger.record_claim(&NewPartRow { machine: "fuse-1".into(), ..new_part("c", 1) }).await.unwrap();
    let first = published(&ledger, &[(a, 0)]).await;
    let second = nesting(&ledger, &[(b, 0), (b, 1)]).await;
    let open = ledger.open_build("paper-200").await.unwrap().id;
    let status = ledger.machine_statuses().await.unwrap();
    let names: Vec<&str> = status.iter().map(|s| s.machine.as_str()).collect();
    assert_eq!(names, ["fuse-1", "paper-200"]);
    assert_eq!((status[0].claimed_parts, status[0].waiting_parts), (1, 0));
    let paper = &status[1];
    assert_eq!((paper.waiting_parts, paper.waiting_copies, paper.collecting_copies), (1, 2, 2));
    assert_eq!(paper.oldest_at, Some(ledger.find_part(a).await.unwrap().unwrap().times.claimed_at));
    assert_eq!(paper.open.as_ref().unwrap().build, open);
    assert_eq!((paper.nesting.len(), paper.nesting[0].build, paper.nesting[0].copies), (1, second, 2));
    let last = paper.last_published.as_ref().unwrap();
    assert_eq!((last.build, last.height_mm, last.copies), (first, Some(87.5), Some(1)));
}

#[tokio::test]
async fn history_lists_builds_newest_first_within_its_limits() {
    let ledger = fresh().await;
    let days = ["2026-11-01T10:00:00Z", "2026-11-02T10:00:00Z", "2026-11-03T10:00:00Z"];
    let mut builds = Vec::new();
    for day in days {
        let then = ledger.ledger.clone().with_clock(move || at(day));
        let id = waiting(&then, day, 1).await;
        builds.push(published(&then, &[(id, 0)]).await);
    }
    let id = waiting(&ledger, "d", 1).await;
    nesting(&ledger, &[(id, 0)]).await;
    let list = async |query: HistoryQuery| {
        let rows = ledger.read_history(&query).await.unwrap();
        rows.into_iter().map(|row| row.build).collect::<Vec<_>>()
    };
    assert_eq!(list(HistoryQuery::default()).await, [builds[2], builds[1], builds[0]]);
    assert_eq!(list(HistoryQuery { limit: Some(1), ..Default::default() }).await, [builds[2]]);
    let one = HistoryQuery { since: Some(at(days[1])), until: Some(at(days[2])), ..Default::default() };
    assert_eq!(list(one).await, [builds[1]]);
    assert!(list(HistoryQuery { machine: Some("fuse-1".into()), ..Default::default() }).await.is_empty());
    let row = &ledger.read_history(&HistoryQuery::default()).await.unwrap()[2];
    assert_eq!((row.at.to_string().as_str(), row.parts, row.measures.copies), ("2026-11-01T10:00:00.000Z", 1, Some(1)));
}

#[tokio::test]
async fn history_is_sorted_filtered_and_turned_page_by_page_without_losing_a_build() {
    let ledger = fresh().await;
    let mut builds = Vec::new();
    for n in 0..23_u32 {
        let then = ledger.ledger.clone().with_clock(move || at(&format!("2026-11-{:02}T10:00:00Z", 1 + n / 2)));
        let id = waiting(&then, &format!("part-{n}"), 1).await;
        let build = nesting(&then, &[(id, 0)]).await;
        let mut of = verified(build, 1);
        (of.measures.height_mm, of.measures.density) = (f64::from(n * 7 % 5), f64::from(n * 3 % 4) / 10.0);
        of.profile_snapshot = "{\"volume_mm\":[200.0,200.0,250.0]}".to_owned();
        if n % 4 == 0 {
            then.fail_build(build, "no room").await.unwrap();
        } else {
            then.verify_build(build, &of, &placed(&[(id, 0)])).await.unwrap();
            then.publish_build(build).await.unwrap();
        }
        builds.push(build);
    }
    for sort in
        [HistorySort::Newest, HistorySort::Height, HistorySort::Density, HistorySort::Copies, HistorySort::Machine]
    {
        for (state, count) in [(None, 23), (Some(BuildState::Failed), 6), (Some(BuildState::Published), 17)] {
            let asked = HistoryQuery { sort, state, ..Default::default() };
            let whole = ledger.read_history(&asked).await.unwrap();
            assert_eq!(whole.len(), count, "{sort:?} {state:?}");
            let mut paged = Vec::new();
            loop {
                let after = paged.last().map(|row: &HistoryRow| row.build);
                let page = ledger.read_history(&HistoryQuery { after, limit: Some(4), ..asked.clone() }).await.unwrap();
                if page.is_empty() {
                    break;
                }
                paged.extend(page);
            }
            assert_eq!(paged, whole, "{sort:?} {state:?}");
        }
    }
    let lowest = ledger.read_history(&HistoryQuery { sort: HistorySort::Height, ..Default::default() }).await.unwrap();
    assert!(lowest[..17].windows(2).all(|two| two[0].measures.height_mm <= two[1].measures.height_mm));
    assert!(lowest[17..].iter().all(|row| row.measures.height_mm.is_none()), "what has no height comes last");
    let high = lowest[16].clone();
    assert_eq!((high.volume_z_mm, high.height_share()), (Some(250.0), Some(4.0 / 250.0)));
    let of_part = HistoryQuery { part: Some("part-5.stl".into()), ..Default::default() };
    let name = ledger.find_part(PartId(6)).await.unwrap().unwrap().name;
    let found = ledger.read_history(&HistoryQuery { part: Some(name), ..of_part }).await.unwrap();
    assert_eq!(found.iter().map(|row| row.build).collect::<Vec<_>>(), [builds[5]]);
    let both = HistoryQuery { since: Some(at("2026-11-05T00:00:00Z")), after: Some(builds[20]), ..Default::default() };
    let rows = ledger.read_history(&both).await.unwrap();
    assert_eq!(rows.iter().map(|row| row.build.0).collect::<Vec<_>>(), (9..=20).rev().collect::<Vec<_>>());
}

#[tokio::test]
async fn the_views_answer_an_operator_with_sqlite3() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 2).await;
    let build = published(&ledger, &[(id, 0)]).await;
    let builds: Vec<(i64, String, f64, i64, String)> =
        sql::query_as("SELECT build, state, height_mm, copies, file_name FROM v_build_history")
            .fetch_all(ledger.reader().unwrap())
            .await
            .unwrap();
    let name = verified(build, 1).file.file_name;
    assert_eq!(builds, [(build.0, "published".into(), 87.5, 1, name)]);
    let parts: Vec<(i64, i64, i64, String)> =
        sql::query_as("SELECT part, copies, copies_built, builds FROM v_part_history")
            .fetch_all(ledger.reader().unwrap())
            .await
            .unwrap();
    assert_eq!(parts, [(id.0, 2, 1, build.to_string())]);
    let days: Vec<(i64, i64, f64, f64)> =
        sql::query_as("SELECT builds, copies, height_mm, mean_density FROM v_height_by_day")
            .fetch_all(ledger.reader().unwrap())
            .await
            .unwrap();
    assert_eq!(days, [(1, 1, 87.5, 0.21)]);
}

#[tokio::test]
async fn heights_are_summed_by_machine_as_the_view_sums_them_and_filtered_as_the_history_is() {
    let ledger = fresh().await;
    let (a, b) = (waiting(&ledger, "a", 3).await, waiting(&ledger, "b", 1).await);
    published(&ledger, &[(a, 0), (a, 1)]).await;
    published(&ledger, &[(a, 2), (b, 0)]).await;
    let failed = waiting(&ledger, "c", 1).await;
    let failed = nesting(&ledger, &[(failed, 0)]).await;
    ledger.fail_build(failed, "no").await.unwrap();
    let view: (String, u32, u32, f64, f64) =
        sql::query_as("SELECT machine, builds, copies, height_mm, mean_density FROM v_height_by_day")
            .fetch_one(ledger.reader().unwrap())
            .await
            .unwrap();
    let sums = ledger.height_summaries(&HistoryQuery { limit: Some(1), ..Default::default() }).await.unwrap();
    let as_view_row =
        |sum: &HeightSummary| (sum.machine.clone(), sum.builds, sum.copies, sum.height_mm, sum.mean_density.unwrap());
    assert_eq!(sums.iter().map(as_view_row).collect::<Vec<_>>(), [view]);
    for (part, builds) in [("b.stl", 1), ("a.stl", 2)] {
        let query =
            HistoryQuery { part: Some(part.to_owned()), state: Some(BuildState::Published), ..Default::default() };
        assert_eq!(ledger.height_summaries(&query).await.unwrap()[0].builds, builds, "{part}");
    }
    let none = HistoryQuery { machine: Some("other".to_owned()), ..Default::default() };
    assert!(ledger.height_summaries(&none).await.unwrap().is_empty());
    let two = HeightSummary { machine: "fuse-1".to_owned(), builds: 6, mean_density: Some(0.05), ..sums[0].clone() };
    let all = HeightSummary::with_total(vec![sums[0].clone(), two]).pop().unwrap();
    assert_eq!((all.builds, all.height_mm, (all.mean_density.unwrap() * 1e4).round()), (8, 350.0, 900.0));
}

#[tokio::test]
async fn what_was_cancelled_or_refused_long_ago_does_not_count_as_refused() {
    let ledger = fresh().await;
    let cancelled = waiting(&ledger, "a", 1).await;
    ledger.cancel_part(cancelled, RefusalCause::Cancelled, "Cancelled by me@here.").await.unwrap();
    let refused = ledger.record_claim(&new_part("b", 1)).await.unwrap().id;
    ledger.refuse_claim(refused, RefusalCause::Format, "torn").await.unwrap();
    let counts = async |ledger: &Ledger| {
        let listed = ledger.list_parts(&PartQuery { limit: 10, ..Default::default() }).await.unwrap().len();
        (ledger.machine_statuses().await.unwrap().first().map_or(0, |status| status.refused_parts), listed)
    };
    assert_eq!(counts(&ledger).await, (1, 2));
    let later = Timestamp::now() + RETRY_PERIOD + jiff::SignedDuration::from_hours(1);
    assert_eq!(counts(&(*ledger).clone().with_clock(move || later)).await, (0, 0));
}

#[tokio::test]
async fn the_truth_teller_sees_a_part_whose_state_was_changed_behind_its_back() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 1).await;
    assert!(ledger.find_inconsistencies().await.unwrap().is_empty());
    let writer = sqlx::SqlitePool::connect(&format!("sqlite://{}", ledger.file().unwrap().display())).await.unwrap();
    sqlx::query("UPDATE part SET state = 'built' WHERE id = ?").bind(id.0).execute(&writer).await.unwrap();
    let faults = ledger.find_inconsistencies().await.unwrap();
    assert!(faults.iter().any(|f| f == "1: a batched or built part has a copy in no build"), "{faults:?}");
    sqlx::query("UPDATE part SET state = 'waiting', copies = 3 WHERE id = ?")
        .bind(id.0)
        .execute(&writer)
        .await
        .unwrap();
    assert_eq!(ledger.find_inconsistencies_of(RuleScope::Places).await.unwrap(), [""; 0]);
    let faults = ledger.find_inconsistencies_of(RuleScope::OrderSums).await.unwrap();
    assert_eq!(faults, ["1: the copies wanted of a part are not those that its events tell"]);
}

#[tokio::test]
async fn what_entered_a_state_between_two_times_is_found_newest_first() {
    let ledger = fresh().await;
    for (name, time) in [("a", "2026-11-01T00:00:00Z"), ("b", "2026-11-02T00:00:00Z"), ("c", "2026-11-03T00:00:00Z")] {
        let at = at(time);
        waiting(&ledger.ledger.clone().with_clock(move || at), name, 1).await;
    }
    let names = async |since: &str, until: &str, most| -> Vec<String> {
        let parts = ledger.parts_in_state_between(PartState::Waiting, at(since), at(until), most).await.unwrap();
        parts.into_iter().map(|part| part.file.claim).collect()
    };
    assert_eq!(names("2026-11-01T12:00:00Z", "2026-11-30T00:00:00Z", 9).await, ["c", "b"]);
    assert_eq!(names("2026-11-01T00:00:00Z", "2026-11-02T00:00:00Z", 9).await, ["b", "a"]);
    assert_eq!(names("2026-01-01T00:00:00Z", "2026-12-01T00:00:00Z", 1).await, ["c"]);
    assert!(
        ledger.parts_in_state_between(PartState::Built, Timestamp::MIN, Timestamp::MAX, 9).await.unwrap().is_empty()
    );
}
