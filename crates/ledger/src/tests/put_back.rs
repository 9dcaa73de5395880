//! Which copies wait again, and which do not: each of these faults would print a copy too many or too few.

use super::{printers::published_at, *};
use crate::{
    InQueueError, OperatorWord, PrintOutcome, PutBackReport, ReprintTarget, SeenFiles, ToldOutcome, WITHDRAWN_BY_NESTD,
};

fn told(outcome: PrintOutcome) -> ToldOutcome {
    ToldOutcome::new(outcome, "", "a@b")
}

async fn row(ledger: &Ledger, part: PartId) -> PartRow {
    ledger.find_part(part).await.unwrap().unwrap()
}

#[tokio::test]
async fn copies_of_a_cancelled_part_are_not_printed_again() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let build = published(&ledger, &[(part, 0)]).await;
    ledger.cancel_part(part, RefusalCause::Cancelled, "not needed").await.unwrap();
    let report = ledger.record_outcome(build, &told(PrintOutcome::Failed)).await.unwrap();
    assert_eq!((report.put_back_copies(), row(&ledger, part).await.state), (0, PartState::Refused));
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn a_copy_is_bad_only_in_the_build_that_it_is_in() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let build = published(&ledger, &[(part, 0)]).await;
    let mut change = ledger.begin_change().await.unwrap();
    let told = change.mark_bad(build, &[(part, 1)], "a@b", true, &mut PutBackReport::default()).await;
    assert!(matches!(told, Err(LedgerError::NotInBuild { copy: 1, .. })), "{told:?}");
}

#[tokio::test]
async fn a_copy_that_is_good_after_all_takes_the_place_of_one_that_waits_for_it() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let build = published(&ledger, &[(part, 0)]).await;
    ledger.record_outcome(build, &told(PrintOutcome::Failed)).await.unwrap();
    ledger.cancel_copies(part, 1, "a@b").await.unwrap();
    assert_eq!(row(&ledger, part).await.wanted_copies(), 1);
    let corrected = ToldOutcome { is_correction: true, ..told(PrintOutcome::Complete) };
    ledger.record_outcome(build, &corrected).await.unwrap();
    let part = row(&ledger, part).await;
    assert_eq!((part.wanted_copies(), part.state), (1, PartState::Built), "none is printed once more");
}

#[tokio::test]
async fn an_outcome_that_is_told_twice_is_said_to_be_the_same_and_contradicts_nothing() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 3).await;
    let build = published(&ledger, &[(part, 0), (part, 1), (part, 2)]).await;
    let say = async |told: ToldOutcome| {
        let seen = SeenFiles::from([(build, crate::SeenFile::OutOfQueue)]);
        let said = ledger.carry_out(&OperatorWord::Outcome(build, told), "a@b", &seen, true).await;
        said.map(|answer| answer.sentences.join(" ")).map_err(|refused| refused.to_string())
    };
    say(told(PrintOutcome::Printing)).await.unwrap();
    let twice = say(told(PrintOutcome::Printing)).await.unwrap_err();
    assert_eq!(twice, "the outcome of build 1 is recorded as printing already, so nothing was changed");
    let bad = |copies| ToldOutcome { bad: vec![(part, copies)], ..told(PrintOutcome::Complete) };
    say(bad(2)).await.unwrap();
    let twice = say(bad(2)).await.unwrap_err();
    assert!(twice.contains("as complete already, so nothing was changed; if other copies of it are bad"), "{twice}");
    let corrected = |copies, keep| ToldOutcome { is_correction: true, keep, ..bad(copies) };
    assert_eq!(say(corrected(2, false)).await.unwrap(), "Build 1 stays complete, as it was told before.");
    let more = say(corrected(3, false)).await.unwrap();
    assert_eq!(
        more,
        "Build 1 stays complete, as it was told before. 1 copy of 1 part waits again, first in line, with all that was asked."
    );
    let fewer = say(corrected(1, false)).await.unwrap();
    assert!(fewer.ends_with("before. Counted as printed again, and waiting no more: 2 copies of 1 part."), "{fewer}");
    let kept = say(corrected(1, true)).await.unwrap();
    assert!(kept.ends_with("before. Not printed again: 1 copy of 1 part."), "{kept}");
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn the_last_copies_of_a_part_are_printed_again() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let first = published(&ledger, &[(part, 0)]).await;
    tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    let last = published(&ledger, &[(part, 1)]).await;
    for build in [first, last] {
        ledger.record_outcome(build, &told(PrintOutcome::Complete)).await.unwrap();
    }
    ledger.reprint_copies(&ReprintTarget::Part(part, Some(1)), "a@b").await.unwrap();
    let again = [ledger.has_bad_copies(first).await.unwrap(), ledger.has_bad_copies(last).await.unwrap()];
    assert_eq!(again, [false, true]);
}

#[tokio::test]
async fn some_copies_of_a_build_that_lies_in_its_queue_are_not_printed_again_before_its_outcome_is_told() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    let some = OperatorWord::Reprint(ReprintTarget::Part(part, Some(1)));
    let refused = ledger.carry_out(&some, "a@b", &SeenFiles::new(), true).await;
    let is_so = matches!(&refused, Err(LedgerError::InQueue(InQueueError::NotTold { build: of })) if *of == build);
    assert!(is_so, "{refused:?}");
}

#[tokio::test]
async fn copies_of_a_withdrawn_build_do_not_go_before_what_is_more_urgent() {
    let ledger = fresh().await;
    let build = published_at(&ledger, "a", "left").await;
    let word = OperatorWord::Withdraw(build, String::new());
    ledger.carry_out(&word, WITHDRAWN_BY_NESTD, &SeenFiles::new(), false).await.unwrap();
    ledger.finish_noted_word(build, true).await.unwrap();
    let parts = ledger.parts_in_state(PartState::Waiting).await.unwrap();
    assert_eq!((parts.len(), parts[0].owed.put_back_at), (1, None));
}

#[tokio::test]
async fn a_part_that_is_read_in_another_size_keeps_its_row_and_is_asked_about() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 1).await;
    let size = row(&ledger, part).await.size_mm();
    ledger.cancel_part(part, RefusalCause::Cancelled, "later").await.unwrap();
    ledger.retry_part(part).await.unwrap();
    let facts = solid(0, 1);
    let inches = SolidFacts { size_mm: facts.size_mm.map(|mm| 25.4 * mm), ..facts };
    ledger.accept_solids(part, &[inches]).await.unwrap();
    let part = row(&ledger, part).await;
    assert_eq!((part.size_mm(), part.owed.size_differs), (size, true));
    assert!(!part.owed.question.is_empty());
}
