//! Printers: which are down, where the file of a build is while it moves, and what told prints teach.

use super::*;
use crate::{FoundPlace, PrintOutcome, TakeBackEnd, ToldOutcome};

/// A published build that was made for a printer.
pub(super) async fn published_at(ledger: &Ledger, claim: &str, printer: &str) -> BuildId {
    let part = waiting(ledger, claim, 1).await;
    let build = nesting(ledger, &[(part, 0)]).await;
    ledger.assign_printer(build, printer).await.unwrap();
    ledger.verify_build(build, &verified(build, 1), &placed(&[(part, 0)])).await.unwrap();
    ledger.publish_build(build).await.unwrap();
    build
}

async fn place(ledger: &Ledger, build: BuildId) -> PrinterPlace {
    ledger.find_build(build).await.unwrap().unwrap().place
}

async fn to_move(ledger: &Ledger) -> Vec<BuildId> {
    ledger.builds_to_take_back("paper-200").await.unwrap().into_iter().map(|build| build.id).collect()
}

#[tokio::test]
async fn a_printer_is_down_until_somebody_says_that_it_is_up() {
    let ledger = fresh().await;
    assert!(!ledger.bring_printer_up("left", "paper-200", "a@b").await.unwrap());
    ledger.take_printer_down("left", "paper-200", "a@b", "").await.unwrap();
    let first = ledger.down_printers().await.unwrap().remove(0);
    ledger.take_printer_down("left", "paper-200", "c@d", "laser").await.unwrap();
    let down = ledger.down_printers().await.unwrap();
    assert_eq!((down.len(), down[0].reason.as_str(), down[0].down_at), (1, "laser", first.down_at));
    assert!(ledger.bring_printer_up("left", "paper-200", "a@b").await.unwrap());
    assert!(ledger.down_printers().await.unwrap().is_empty());
}

#[tokio::test]
async fn what_lies_at_a_printer_that_is_down_is_to_be_moved_unless_it_was_taken_or_told() {
    let ledger = fresh().await;
    let [lies, taken, told] = [
        published_at(&ledger, "a", "left").await,
        published_at(&ledger, "b", "left").await,
        published_at(&ledger, "c", "left").await,
    ];
    published_at(&ledger, "d", "right").await;
    ledger.record_taken(taken, "queue").await.unwrap();
    ledger.record_outcome(told, &ToldOutcome::new(PrintOutcome::Complete, "", "a@b")).await.unwrap();
    ledger.record_taken(lies, "another").await.unwrap();
    assert!(to_move(&ledger).await.is_empty());
    let queued: Vec<_> =
        ledger.newest_queued("paper-200", 50).await.unwrap().iter().map(|queued| queued.build).collect();
    assert_eq!(queued, [BuildId(lies.0 + 3), lies], "the newest first");
    let counts = ledger.queued_counts("paper-200").await.unwrap();
    assert_eq!(counts, [("left".to_owned(), 1), ("right".to_owned(), 1)]);
    ledger.take_printer_down("left", "paper-200", "a@b", "").await.unwrap();
    assert_eq!(to_move(&ledger).await, [lies]);
}

#[tokio::test]
async fn a_move_is_recorded_step_by_step_and_the_other_printer_is_fixed_once_the_file_is_there() {
    let ledger = fresh().await;
    let build = published_at(&ledger, "a", "left").await;
    ledger.begin_move(build, "right").await.unwrap();
    ledger.begin_move(build, "middle").await.unwrap();
    assert_eq!(place(&ledger, build).await.move_to.as_deref(), Some("middle"));
    ledger.record_taken(build, "queue").await.unwrap();
    assert_eq!(place(&ledger, build).await.taken_at, None, "a file on its way is in no queue folder");
    assert!(!ledger.finish_move(build).await.unwrap());
    assert_eq!(place(&ledger, build).await.printer.as_deref(), Some("left"), "it is not there yet");
    ledger.record_move(build, "middle", "marker").await.unwrap();
    ledger.begin_move(build, "right").await.unwrap();
    assert_eq!(to_move(&ledger).await, [build]);
    assert!(ledger.finish_move(build).await.unwrap());
    let row = ledger.find_build(build).await.unwrap().unwrap();
    let expected = PrinterPlace { printer: Some("middle".to_owned()), ..PrinterPlace::default() };
    assert_eq!((row.place, row.staged.queue_id.as_deref()), (expected, Some("marker")));
    assert!(to_move(&ledger).await.is_empty());
    assert_eq!(build_state(&ledger, build).await, BuildState::Published);
}

#[tokio::test]
async fn a_move_ends_where_the_printer_took_the_file_and_none_begins_after_an_outcome() {
    let ledger = fresh().await;
    let build = published_at(&ledger, "a", "left").await;
    ledger.begin_move(build, "right").await.unwrap();
    ledger.end_take_back(build, TakeBackEnd::Taken).await.unwrap();
    let now = place(&ledger, build).await;
    assert!(now.taken_at.is_some() && now.move_to.is_none() && now.printer.as_deref() == Some("left"));
    ledger.begin_move(build, "right").await.unwrap();
    assert_eq!(place(&ledger, build).await.move_to, None, "it was taken");
    let told = published_at(&ledger, "b", "left").await;
    ledger.begin_move(told, "right").await.unwrap();
    ledger.record_outcome(told, &ToldOutcome::new(PrintOutcome::Failed, "", "a@b")).await.unwrap();
    assert!(matches!(ledger.record_move(told, "right", "marker").await, Err(LedgerError::WrongState { .. })));
    assert!(matches!(ledger.begin_move(told, "right").await, Err(LedgerError::WrongState { .. })));
    ledger.end_take_back(told, TakeBackEnd::Removed).await.unwrap();
    let now = place(&ledger, told).await;
    assert_eq!((now.taken_at, now.move_to), (None, None), "no printer took it");
}

#[tokio::test]
async fn a_move_is_not_finished_once_the_outcome_was_told() {
    let ledger = fresh().await;
    let build = published_at(&ledger, "a", "left").await;
    ledger.begin_move(build, "right").await.unwrap();
    ledger.record_move(build, "right", "marker").await.unwrap();
    ledger.record_outcome(build, &ToldOutcome::new(PrintOutcome::Failed, "", "a@b")).await.unwrap();
    assert!(!ledger.finish_move(build).await.unwrap());
    assert_eq!(
        place(&ledger, build).await.move_queue_id.as_deref(),
        Some("marker"),
        "it is still to be taken out there"
    );
    ledger.end_take_back(build, TakeBackEnd::TakenThere).await.unwrap();
    let now = place(&ledger, build).await;
    assert!(now.printer.as_deref() == Some("right") && now.taken_at.is_some() && now.move_to.is_none(), "{now:?}");
}

#[tokio::test]
async fn a_file_that_was_found_elsewhere_is_recorded_unless_it_moves_or_has_moved() {
    let ledger = fresh().await;
    let build = published_at(&ledger, "a", "left").await;
    let found = |instead_of: &str, is_taken_back| FoundPlace {
        printer: "right".to_owned(),
        queue_id: "marker".to_owned(),
        instead_of: Some(instead_of.to_owned()),
        is_taken_back,
    };
    ledger.correct_place(build, &found("another", false)).await.unwrap();
    assert_eq!(place(&ledger, build).await.printer.as_deref(), Some("left"));
    ledger.correct_place(build, &found("queue", false)).await.unwrap();
    assert_eq!(place(&ledger, build).await.printer.as_deref(), Some("right"));
    ledger.correct_place(build, &found("marker", true)).await.unwrap();
    assert_eq!(place(&ledger, build).await.move_to.as_deref(), Some("right"), "it is brought to a printer");
    assert_eq!(to_move(&ledger).await, [build]);
    ledger.name_printer("paper-200", "mjf-right", "marker", &[]).await.unwrap();
    assert_eq!(place(&ledger, build).await.printer.as_deref(), Some("mjf-right"), "the printer got another name");
}

#[tokio::test]
async fn told_prints_teach_from_when_their_files_were_taken() {
    let ledger = fresh().await;
    let [known, unknown] = [published_at(&ledger, "a", "left").await, published_at(&ledger, "b", "right").await];
    ledger.record_taken(known, "queue").await.unwrap();
    let now = Timestamp::now().into();
    let occupying = ledger.occupying_builds("paper-200", now).await.unwrap();
    let seen: Vec<_> = occupying.iter().map(|build| (build.build, build.begun_at.is_some())).collect();
    assert_eq!(seen, [(known, true), (unknown, false)]);
    let later = ledger.clone().with_clock(|| Timestamp::now() + jiff::SignedDuration::from_hours(9));
    for build in [known, unknown] {
        later.record_outcome(build, &ToldOutcome::new(PrintOutcome::Complete, "", "a@b")).await.unwrap();
    }
    assert!(ledger.occupying_builds("paper-200", now).await.unwrap().is_empty());
    let told = ledger.told_prints("paper-200").await.unwrap();
    assert_eq!((told.len(), told[0].printer.as_deref(), told[0].height_mm), (1, Some("left"), 87.5));
    assert_eq!(told[0].told_at.0.duration_since(told[0].begun_at.0).as_hours(), 9);
}

#[tokio::test]
async fn only_a_proved_build_is_released_and_only_once() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 1).await;
    let build = nesting(&ledger, &[(part, 0)]).await;
    assert!(matches!(ledger.release_build(build, None, "a@b").await, Err(LedgerError::WrongState { .. })));
    ledger.verify_build(build, &verified(build, 1), &placed(&[(part, 0)])).await.unwrap();
    let refused = ledger.release_build(build, Some("of another file"), "a@b").await;
    assert!(matches!(refused, Err(LedgerError::ProvedAnew(_))), "{refused:?}");
    let seen = ledger.find_build(build).await.unwrap().unwrap().staged.file_hash;
    assert!(ledger.release_build(build, seen.as_deref(), "a@b").await.unwrap());
    assert!(!ledger.release_build(build, None, "c@d").await.unwrap());
    assert_eq!(place(&ledger, build).await.released_by.as_deref(), Some("a@b"));
    ledger.publish_build(build).await.unwrap();
    assert!(matches!(ledger.release_build(build, None, "a@b").await, Err(LedgerError::WrongState { .. })));
}

#[tokio::test]
async fn a_build_that_is_made_again_waits_for_another_yes() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 1).await;
    let build = nesting(&ledger, &[(part, 0)]).await;
    ledger.verify_build(build, &verified(build, 1), &placed(&[(part, 0)])).await.unwrap();
    assert!(ledger.release_build(build, None, "a@b").await.unwrap());
    ledger.reopen_verified_build(build, "made again").await.unwrap();
    let now = place(&ledger, build).await;
    assert_eq!((now.released_at, now.released_by), (None, None), "nobody has seen what comes now");
}

#[tokio::test]
async fn builds_of_an_earlier_nestd_get_the_name_of_the_printer_where_their_files_lie() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 1).await;
    let build = nesting(&ledger, &[(part, 0)]).await;
    ledger.verify_build(build, &verified(build, 1), &placed(&[(part, 0)])).await.unwrap();
    ledger.publish_build(build).await.unwrap();
    let row = ledger.find_build(build).await.unwrap().unwrap();
    ledger.name_printer("paper-200", "left", "queue", &[]).await.unwrap();
    assert_eq!(place(&ledger, build).await.printer, None, "it was taken long ago");
    ledger.name_printer("paper-200", "left", "another", &[row.staged.file_name.clone().unwrap()]).await.unwrap();
    assert_eq!(place(&ledger, build).await.printer, None);
    ledger.name_printer("paper-200", "left", "queue", &[row.staged.file_name.unwrap()]).await.unwrap();
    assert_eq!(place(&ledger, build).await.printer.as_deref(), Some("left"));
}
