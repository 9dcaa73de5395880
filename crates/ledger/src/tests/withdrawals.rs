//! Builds that are taken back out of the queue, and how many builds are ahead of a printer.

use super::{printers::published_at, *};
use crate::{
    BuildsAhead, InQueueError, OperatorWord, PrintOutcome, SeenFile, SeenFiles, TakeBackEnd, TakenBackFor, ToldOutcome,
    WITHDRAWN_BY_NESTD, WordAnswer, base::error::Result,
};

async fn place(ledger: &Ledger, build: BuildId) -> PrinterPlace {
    ledger.find_build(build).await.unwrap().unwrap().place
}

async fn withdraw(ledger: &Ledger, build: BuildId, by: &str, why: &str) -> Result<WordAnswer> {
    ledger.carry_out(&OperatorWord::Withdraw(build, why.to_owned()), by, &SeenFiles::new(), false).await
}

async fn to_withdraw(ledger: &Ledger) -> Vec<BuildId> {
    ledger.builds_to_take_back("paper-200").await.unwrap().into_iter().map(|build| build.id).collect()
}

#[tokio::test]
async fn a_withdrawn_build_puts_its_copies_back_once_and_does_not_count_as_printed() {
    let ledger = fresh().await;
    let build = published_at(&ledger, "a", "left").await;
    assert_eq!(withdraw(&ledger, build, "a@b", "a mistake").await.unwrap().noted, [build]);
    let again = withdraw(&ledger, build, "c@d", "").await;
    assert!(matches!(again, Err(LedgerError::InQueue(InQueueError::BeingTakenBack(_)))), "{again:?}");
    assert_eq!(to_withdraw(&ledger).await, [build]);
    assert_eq!(place(&ledger, build).await.withdraw_by.as_deref(), Some("a@b"), "the first word counts");
    // On its way out of the queue, it is neither taken nor moved.
    ledger.record_taken(build, "queue").await.unwrap();
    ledger.begin_move(build, "right").await.unwrap();
    let now = place(&ledger, build).await;
    assert_eq!((now.taken_at, now.move_to), (None, None));
    assert_eq!(ledger.taken_back_for(build).await.unwrap(), Some(TakenBackFor::Withdrawal));
    assert!(ledger.finish_noted_word(build, true).await.unwrap().is_some());
    assert_eq!(ledger.copies_of_withdrawal(build).await.unwrap(), 1);
    assert_eq!(ledger.taken_back_for(build).await.unwrap(), Some(TakenBackFor::Nothing));
    assert!(ledger.finish_noted_word(build, true).await.unwrap().is_none());
    assert_eq!(to_withdraw(&ledger).await, [build], "its file is still to be removed");
    ledger.end_take_back(build, TakeBackEnd::Removed).await.unwrap();
    assert!(to_withdraw(&ledger).await.is_empty());
    assert_no_outcome_is_heard(&ledger, build).await;
    assert_eq!(ledger.outcomes_of_build(build).await.unwrap(), [], "nobody told how it printed");
    let row = ledger.find_build(build).await.unwrap().unwrap();
    assert_eq!((row.state, row.reason.as_str()), (BuildState::Failed, "withdrawn from the queue by a@b: a mistake"));
    assert!(ledger.unseen_failures().await.unwrap().is_empty());
    assert!(ledger.height_summaries(&HistoryQuery::default()).await.unwrap().is_empty());
    let totals = ledger.read_totals().await.unwrap();
    assert_eq!(totals.builds[0].state, "withdrawn");
    assert_eq!(ledger.paused_machines().await.unwrap(), ["paper-200"], "its copies can be changed");
    assert_eq!(ledger.waiting_copies("paper-200").await.unwrap().len(), 0, "its original is fetched first");
    assert_eq!(ledger.parts_to_fetch().await.unwrap().len(), 1);
}

#[tokio::test]
async fn a_build_that_its_printer_took_or_that_moves_is_not_withdrawn() {
    let ledger = fresh().await;
    let [taken, moves, raced] = [
        published_at(&ledger, "a", "left").await,
        published_at(&ledger, "b", "left").await,
        published_at(&ledger, "c", "left").await,
    ];
    ledger.record_taken(taken, "queue").await.unwrap();
    ledger.begin_move(moves, "right").await.unwrap();
    let word = OperatorWord::Withdraw(taken, String::new());
    let refused = ledger.carry_out(&word, "a@b", &SeenFiles::from([(taken, SeenFile::OutOfQueue)]), false).await;
    assert!(matches!(refused, Err(LedgerError::NotInQueue(_))), "{refused:?}");
    let refused = withdraw(&ledger, moves, "a@b", "").await;
    assert!(matches!(refused, Err(LedgerError::InQueue(InQueueError::OnItsWay(_)))), "{refused:?}");
    ledger.end_take_back(moves, TakeBackEnd::Removed).await.unwrap();
    withdraw(&ledger, moves, "a@b", "").await.unwrap();
    // One word at a time.
    let told = OperatorWord::Outcome(moves, ToldOutcome::new(PrintOutcome::Complete, "", "a@b"));
    let refused = ledger.carry_out(&told, "a@b", &SeenFiles::new(), true).await;
    assert!(matches!(refused, Err(LedgerError::InQueue(InQueueError::BeingTakenBack(_)))), "{refused:?}");
    // The printer is first.
    withdraw(&ledger, raced, "a@b", "").await.unwrap();
    ledger.end_take_back(raced, TakeBackEnd::Taken).await.unwrap();
    let now = place(&ledger, raced).await;
    assert!(now.taken_at.is_some() && now.withdraw_by.is_none() && now.withdrawn_at.is_none());
    assert_eq!(build_state(&ledger, raced).await, BuildState::Published);
}

#[tokio::test]
async fn the_open_build_knows_what_nestd_withdrew_for_it_until_it_fires() {
    let ledger = fresh().await;
    let build = published_at(&ledger, "a", "left").await;
    let open = ledger.open_build("paper-200").await.unwrap();
    let learned = async || ledger.published_experience("paper-200", 10).await.unwrap().len();
    assert_eq!(learned().await, 1);
    withdraw(&ledger, build, WITHDRAWN_BY_NESTD, "").await.unwrap();
    assert_eq!(ledger.withdrawn_for_open("paper-200").await.unwrap(), None);
    ledger.finish_noted_word(build, true).await.unwrap();
    assert_eq!(learned().await, 0, "it is no print that failed");
    let history = ledger.read_history(&HistoryQuery::default()).await.unwrap();
    assert_eq!((history[0].state_word().as_str(), history[0].is_published()), ("withdrawn", false));
    let part = ledger.placements_of_build(build).await.unwrap()[0].part_id;
    let line = ledger.line_of_part(part).await.unwrap();
    assert_eq!((line.copies.bad, line.copies.waiting), (0, 1));
    assert!(ledger.placements_of_part(part).await.unwrap().iter().all(|placed| placed.is_withdrawn));
    let views = "SELECT h.state, p.copies_bad FROM v_build_history h JOIN v_part_history p ON p.part = $1";
    let seen: Vec<(String, i64)> =
        crate::base::sql::query_as(views).bind(part).fetch_all(ledger.reader().unwrap()).await.unwrap();
    assert_eq!(seen, [("withdrawn".to_owned(), 0)]);
    assert_eq!(ledger.withdrawn_for_open("paper-200").await.unwrap(), Some(build));
    assert_eq!(ledger.open_build("paper-200").await.unwrap().id, open.id);
    let other = waiting(&ledger, "b", 1).await;
    ledger.begin_nesting(open.id, "withdrawn", &[(other, 0)]).await.unwrap();
    assert_eq!(ledger.withdrawn_for_open("paper-200").await.unwrap(), None);
}

#[tokio::test]
async fn builds_that_are_made_for_a_printer_or_lie_in_its_queue_are_ahead_of_it() {
    let ledger = fresh().await;
    published_at(&ledger, "a", "left").await;
    let taken = published_at(&ledger, "b", "left").await;
    ledger.record_taken(taken, "queue").await.unwrap();
    let moves = published_at(&ledger, "c", "left").await;
    ledger.begin_move(moves, "right").await.unwrap();
    let part = waiting(&ledger, "d", 1).await;
    nesting(&ledger, &[(part, 0)]).await;
    ledger.take_printer_down("middle", "paper-200", "a@b", "").await.unwrap();
    let ahead =
        |printer: &str, builds: u32, is_down: bool| BuildsAhead { printer: printer.to_owned(), builds, is_down };
    let expected = [ahead("", 1, false), ahead("left", 1, false), ahead("middle", 0, true), ahead("right", 1, false)];
    assert_eq!(ledger.builds_ahead("paper-200").await.unwrap(), expected);
    let status = ledger.machine_statuses().await.unwrap().remove(0);
    assert_eq!(status.ahead, expected);
}

/// Nobody can have printed what was taken back untouched, so no word makes its copies count as printed.
async fn assert_no_outcome_is_heard(ledger: &Ledger, build: BuildId) {
    let before = ledger.find_build(build).await.unwrap().unwrap();
    for outcome in [PrintOutcome::Failed, PrintOutcome::Complete, PrintOutcome::Interrupted, PrintOutcome::Printing] {
        for is_correction in [true, false] {
            let told = ToldOutcome { is_correction, ..ToldOutcome::new(outcome, "", "ann") };
            let word = OperatorWord::Outcome(build, told);
            let refused = ledger.carry_out(&word, "ann", &SeenFiles::from([(build, SeenFile::OutOfQueue)]), true).await;
            assert!(matches!(refused, Err(LedgerError::TakenBack(_))), "{outcome} {is_correction}: {refused:?}");
        }
    }
    let broken_out = OperatorWord::BreakOut(build);
    let refused = ledger
        .carry_out(&broken_out, "ann", &SeenFiles::from([(build, SeenFile::OutOfQueue)]), true)
        .await
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("untouched: it does not count as printed") && refused.contains("nestd cancel"),
        "{refused}"
    );
    let again = ledger.carry_out(&OperatorWord::Withdraw(build, String::new()), "ann", &SeenFiles::new(), false).await;
    assert_eq!(again.unwrap_err().to_string(), format!("build {build} is withdrawn, not published"));
    assert_eq!(ledger.find_build(build).await.unwrap().unwrap(), before);
    assert!(ledger.placements_of_build(build).await.unwrap().iter().all(|placed| placed.is_bad));
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn a_build_that_is_issued_or_printed_again_and_was_taken_back_untouched_counts_as_withdrawn() {
    for is_requeue in [true, false] {
        let ledger = fresh().await;
        let build = published_at(&ledger, "a", "left").await;
        let word = if is_requeue {
            OperatorWord::Requeue(build)
        } else {
            OperatorWord::Reprint(crate::ReprintTarget::Build(build))
        };
        ledger.carry_out(&word, "ann", &SeenFiles::new(), true).await.unwrap();
        assert_eq!(build_state(&ledger, build).await, BuildState::Published);
        ledger.finish_noted_word(build, true).await.unwrap().unwrap();
        ledger.end_take_back(build, TakeBackEnd::Removed).await.unwrap();
        let row = ledger.find_build(build).await.unwrap().unwrap();
        assert_eq!((row.state, row.state_word().as_str()), (BuildState::Failed, "withdrawn"));
        assert_no_outcome_is_heard(&ledger, build).await;
        let now = UtcTimestamp(jiff::Timestamp::now());
        let busy = ledger.occupying_builds("paper-200", now).await.unwrap();
        assert!(busy.iter().all(|busy| busy.build != build), "its printer is free of it");
        assert!(ledger.unseen_failures().await.unwrap().is_empty(), "nobody needs to see to it");
    }
}
