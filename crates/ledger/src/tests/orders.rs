//! Orders: copies that were printed badly are owed again with all that was asked, corrections, edits, and the state of
//! an order.

use super::*;

/// A waiting part of an order.
async fn line(ledger: &Ledger, claim: &str, copies: u32, order: &str) -> PartId {
    let part = asked(new_part(claim, copies), |terms| {
        terms.order_name = order.to_owned();
        terms.unit = Some(build_file::LengthUnit::Inch);
        terms.orientation = nester::OrientationRule::Upright;
        terms.priority = 70;
    });
    let id = ledger.record_claim(&part).await.unwrap().id;
    ledger.accept_solids(id, &[solid(0, copies)]).await.unwrap();
    id
}

fn told(outcome: PrintOutcome) -> ToldOutcome {
    ToldOutcome::new(outcome, "", "ann@farm")
}

async fn copies(ledger: &Ledger, part: PartId) -> LineCopies {
    ledger.line_of_part(part).await.unwrap().copies
}

#[tokio::test]
async fn a_failed_build_puts_every_copy_back_with_all_that_was_asked_and_first_in_line() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 3, "brandt").await;
    let build = published(&ledger, &[(part, 0), (part, 1), (part, 2)]).await;
    let urgent = ledger.record_claim(&asked(new_part("u", 1), |terms| terms.priority = 100)).await.unwrap().id;
    ledger.accept_solids(urgent, &[solid(0, 1)]).await.unwrap();
    let before = ledger.find_part(part).await.unwrap().unwrap();
    let report = ledger.record_outcome(build, &told(PrintOutcome::Failed)).await.unwrap();
    assert_eq!((report.put_back_copies(), report.put_back.len()), (3, 1));
    assert!(ledger.waiting_copies("paper-200").await.unwrap().iter().all(|w| w.part.id != part), "no original yet");
    assert_eq!(ledger.parts_to_fetch().await.unwrap().len(), 1);
    ledger.mark_fetched(&before.file.content_hash).await.unwrap();
    let queue = ledger.waiting_copies("paper-200").await.unwrap();
    assert_eq!((queue[0].part.id, &queue[0].copies[..]), (part, &[0, 1, 2][..]), "first in line");
    assert_eq!(queue[0].part.terms, before.terms);
    assert_eq!(copies(&ledger, part).await, LineCopies { wanted: 3, waiting: 3, bad: 3, ..Default::default() });
    // The failed build still shows what was in it.
    assert_eq!(ledger.placements_of_build(build).await.unwrap().len(), 3);
    assert_eq!(ledger.unseen_failures().await.unwrap().len(), 1);
    ledger.mark_seen(build, "ann").await.unwrap();
    assert!(ledger.unseen_failures().await.unwrap().is_empty());
    let again = published(&ledger, &[(part, 0), (part, 1), (part, 2)]).await;
    ledger.record_outcome(again, &told(PrintOutcome::Complete)).await.unwrap();
    assert_eq!(copies(&ledger, part).await, LineCopies { wanted: 3, good: 3, bad: 3, ..Default::default() });
    assert_eq!(ledger.find_order("brandt").await.unwrap().unwrap().state, OrderState::Complete);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn a_failed_print_whose_copies_are_printed_again_needs_nobody() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "brandt").await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    let hash = ledger.find_part(part).await.unwrap().unwrap().file.content_hash;
    ledger.record_outcome(build, &told(PrintOutcome::Failed)).await.unwrap();
    ledger.mark_fetched(&hash).await.unwrap();
    let one = published(&ledger, &[(part, 0)]).await;
    ledger.record_outcome(one, &told(PrintOutcome::Complete)).await.unwrap();
    assert_eq!(ledger.unseen_failures().await.unwrap().len(), 1, "the other copy is printed nowhere");
    let other = published(&ledger, &[(part, 1)]).await;
    assert_eq!(ledger.unseen_failures().await.unwrap().len(), 1, "it lies in a queue");
    ledger.record_outcome(other, &told(PrintOutcome::Printing)).await.unwrap();
    assert!(ledger.unseen_failures().await.unwrap().is_empty());
}

#[tokio::test]
async fn lines_and_orders_carry_the_due_date_as_it_was_given() {
    let ledger = fresh().await;
    let due = |claim: &str, at: &str, text: &str| {
        asked(new_part(claim, 1), |terms| {
            (terms.due_at, terms.due_text) = (Some(at.parse().unwrap()), text.to_owned());
            terms.order_name = "brandt".to_owned();
        })
    };
    ledger.record_claim(&due("a", "2026-12-24T22:59:59Z", "2026-12-24")).await.unwrap();
    ledger.record_claim(&due("b", "2026-12-23T16:00:00Z", "2026-12-23 17:00")).await.unwrap();
    let lines = ledger.order_lines("brandt").await.unwrap();
    assert_eq!(lines.iter().map(|line| line.due_text.as_str()).collect::<Vec<_>>(), ["2026-12-24", "2026-12-23 17:00"]);
    let orders = ledger.order_summaries(&OrderQuery { limit: 9, ..Default::default() }).await.unwrap();
    assert_eq!(orders[0].due_text, "2026-12-23 17:00");
    assert_eq!(orders[0].due_at, lines[1].due_at);
}

#[tokio::test]
async fn single_bad_copies_are_put_back_and_not_more_than_were_printed() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 3, "brandt").await;
    let build = published(&ledger, &[(part, 0), (part, 1), (part, 2)]).await;
    let bad = ToldOutcome { bad: vec![(part, 4)], ..told(PrintOutcome::Complete) };
    let refused = ledger.record_outcome(build, &bad).await.unwrap_err().to_string();
    assert!(refused.contains("3 copies of part"), "{refused}");
    let bad = ToldOutcome { bad: vec![(part, 1)], ..told(PrintOutcome::Complete) };
    assert_eq!(ledger.record_outcome(build, &bad).await.unwrap().put_back_copies(), 1);
    let expected = LineCopies { wanted: 3, waiting: 1, good: 2, bad: 1, ..Default::default() };
    assert_eq!(copies(&ledger, part).await, expected);
    assert_eq!(ledger.find_order("brandt").await.unwrap().unwrap().state, OrderState::Open);
    // More turn out to be bad later.
    let report = ledger.reprint_copies(&ReprintTarget::Part(part, Some(1)), "ann").await.unwrap();
    assert_eq!(report.put_back_copies(), 1);
    assert_eq!(copies(&ledger, part).await.waiting, 2);
    assert!(ledger.reprint_copies(&ReprintTarget::Part(part, Some(2)), "ann").await.is_err());
    assert_eq!(
        ledger.reprint_copies(&ReprintTarget::Order("brandt".into()), "ann").await.unwrap().put_back_copies(),
        1
    );
    assert_eq!(copies(&ledger, part).await.waiting, 3);
}

#[tokio::test]
async fn a_wrong_outcome_is_corrected_and_nothing_is_taken_out_of_another_build() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "").await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    ledger.record_outcome(build, &told(PrintOutcome::Failed)).await.unwrap();
    ledger.mark_fetched(&ledger.find_part(part).await.unwrap().unwrap().file.content_hash).await.unwrap();
    let next = nesting(&ledger, &[(part, 0)]).await;
    let refused = ledger.record_outcome(build, &told(PrintOutcome::Complete)).await.unwrap_err().to_string();
    assert!(refused.contains("--correct"), "{refused}");
    let correction = ToldOutcome { is_correction: true, ..told(PrintOutcome::Complete) };
    let report = ledger.record_outcome(build, &correction).await.unwrap();
    assert_eq!((report.returned[0].copies, report.elsewhere[0].1), (1, next));
    let expected = LineCopies { wanted: 2, in_builds: 1, good: 1, bad: 1, ..Default::default() };
    assert_eq!(copies(&ledger, part).await, expected);
    assert_eq!(ledger.outcomes_of_build(build).await.unwrap().len(), 2, "history keeps both");
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn an_outcome_is_corrected_while_the_part_is_read_again_on_another_machine() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "").await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    ledger.record_outcome(build, &told(PrintOutcome::Failed)).await.unwrap();
    ledger.move_to_machine(part, "other", false, "ann@farm").await.unwrap();
    assert_eq!(part_state(&ledger, part).await, PartState::Claimed);
    let correction = ToldOutcome { is_correction: true, ..told(PrintOutcome::Complete) };
    ledger.record_outcome(build, &correction).await.unwrap();
    assert_eq!(copies(&ledger, part).await, LineCopies { wanted: 2, good: 2, ..Default::default() });
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn a_corrected_outcome_takes_the_place_of_a_copy_that_was_asked_for_again() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "").await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    let keep = ToldOutcome { keep: true, ..told(PrintOutcome::Failed) };
    ledger.record_outcome(build, &keep).await.unwrap();
    let again = PartEdit { copies: Some(1), ..PartEdit::default() };
    ledger.edit_part(part, &again, "ann@farm").await.unwrap();
    let correction = ToldOutcome { is_correction: true, ..told(PrintOutcome::Complete) };
    ledger.record_outcome(build, &correction).await.unwrap();
    assert_eq!(copies(&ledger, part).await, LineCopies { wanted: 2, good: 2, ..Default::default() });
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn a_failed_print_that_is_not_wanted_again_ends_its_order_short() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "brandt").await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    let keep = ToldOutcome { keep: true, ..told(PrintOutcome::Failed) };
    let report = ledger.record_outcome(build, &keep).await.unwrap();
    assert_eq!((report.put_back_copies(), report.unwanted[0].copies), (0, 2));
    assert_eq!(copies(&ledger, part).await, LineCopies { bad: 2, cancelled: 2, ..Default::default() });
    assert_eq!(ledger.find_order("brandt").await.unwrap().unwrap().state, OrderState::Short);
    let events = ledger.events_of_part(part).await.unwrap();
    assert!(events.iter().any(|event| event.detail.contains("ann@farm") && event.detail.contains("not wanted again")));
}

#[tokio::test]
async fn the_same_build_is_issued_once_more_with_the_same_poses() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "").await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    let new = ledger.requeue_build(build, "ann").await.unwrap();
    let (old_rows, new_rows) =
        (ledger.placements_of_build(build).await.unwrap(), ledger.placements_of_build(new).await.unwrap());
    assert!(old_rows.iter().all(|row| row.is_bad) && new_rows.iter().all(|row| !row.is_bad));
    for (old, new) in old_rows.iter().zip(&new_rows) {
        assert_eq!((old.copy, old.pose()), (new.copy, new.pose()));
    }
    assert_eq!(part_state(&ledger, part).await, PartState::Batched);
    let refused = ledger.requeue_build(build, "ann").await.unwrap_err().to_string();
    assert!(refused.contains("by now"), "{refused}");
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn what_was_asked_changes_until_the_final_nesting_and_each_change_names_who_made_it() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "brandt").await;
    let edit = PartEdit {
        copies: Some(5),
        priority: Some(100),
        order_name: Some("meyer".into()),
        clearance_mm: Some(Some(2.5)),
        due: Some(Some((at("2026-11-22T23:00:00Z"), "2026-11-22".to_owned()))),
        ..PartEdit::default()
    };
    let edited = ledger.edit_part(part, &edit, "ann@farm").await.unwrap();
    assert_eq!(edited.changes[0], "5 copies instead of 2");
    assert!(edited.changes.contains(&"due 2026-11-22 instead of none".to_owned()), "{:?}", edited.changes);
    assert_eq!(ledger.edit_part(part, &edit, "ann@farm").await.unwrap().changes, [""; 0], "twice is once");
    let row = ledger.find_part(part).await.unwrap().unwrap();
    assert_eq!((row.wanted_copies(), row.terms.priority, row.terms.order_name.as_str()), (5, 100, "meyer"));
    assert!(ledger.order_lines("brandt").await.unwrap().is_empty());
    let events = ledger.events_of_part(part).await.unwrap();
    assert!(
        events.iter().any(|e| e.kind == EventKind::Edited && e.detail.starts_with("ann@farm: 5 copies instead of 2"))
    );
    ledger.cancel_copies(part, 3, "ann@farm").await.unwrap();
    assert_eq!(copies(&ledger, part).await, LineCopies { wanted: 2, waiting: 2, cancelled: 3, ..Default::default() });
    let build = nesting(&ledger, &[(part, 0)]).await;
    let far = PartEdit { clearance_mm: Some(Some(1000.0)), ..Default::default() };
    let beyond = ledger.edit_part(part, &far, "ann").await.unwrap_err();
    assert_eq!(beyond.to_string(), "clearance_mm = 1000; it must be 0 to 100");
    let refused = ledger.edit_part(part, &PartEdit { priority: Some(1), ..Default::default() }, "ann").await;
    assert!(matches!(refused, Err(LedgerError::BeingBuilt { .. })));
    assert!(
        ledger.cancel_copies(part, 2, "ann").await.unwrap_err().to_string().contains("1 copy of part"),
        "one is in a build"
    );
    ledger.cancel_copies(part, 1, "ann").await.unwrap();
    assert_eq!(part_state(&ledger, part).await, PartState::Batched);
    ledger.verify_build(build, &verified(build, 1), &placed(&[(part, 0)])).await.unwrap();
    ledger.publish_build(build).await.unwrap();
    // More of what is built: the rest of the order waits.
    ledger.edit_part(part, &PartEdit { copies: Some(3), ..Default::default() }, "ann").await.unwrap();
    assert_eq!(copies(&ledger, part).await.waiting, 2);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn a_part_moves_to_another_machine_where_it_is_read_again() {
    let ledger = fresh().await;
    let part = line(&ledger, "a", 2, "").await;
    assert_eq!(ledger.move_to_machine(part, "paper-300", false, "ann").await.unwrap(), [part]);
    let row = ledger.find_part(part).await.unwrap().unwrap();
    assert_eq!((row.machine.as_str(), row.state), ("paper-300", PartState::Claimed));
    ledger.accept_solids(part, &[solid(0, 2)]).await.unwrap();
    assert_eq!(ledger.waiting_copies("paper-300").await.unwrap()[0].copies, [0, 1]);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

/// Records the drop of a hinge for an order.
async fn drop_hinge(ledger: &Ledger, claim: &str, order: &str, has_ticket: bool) -> PartId {
    let mut part = asked(new_part(claim, 1), |terms| terms.order_name = order.to_owned());
    part.name = "hinge.stl".to_owned();
    let ticket = || NewTicketRow { source: TicketSource::Sidecar, file_name: String::new(), text: String::new() };
    part.ticket = has_ticket.then(ticket);
    ledger.record_drops(&[(&part, true)]).await.unwrap()[0].id
}

#[tokio::test]
async fn a_revision_is_the_same_name_in_the_same_order_while_the_first_waits() {
    let ledger = fresh().await;
    let old = drop_hinge(&ledger, "a", "brandt", false).await;
    let other = drop_hinge(&ledger, "c", "meyer", false).await;
    let loose = drop_hinge(&ledger, "d", "", false).await;
    let again = drop_hinge(&ledger, "e", "", false).await;
    let new = drop_hinge(&ledger, "b", "brandt", false).await;
    let mut replaced = Vec::new();
    for part in [old, other, loose, again, new] {
        replaced.push(ledger.find_part(part).await.unwrap().unwrap().owed.replaced_by);
    }
    assert_eq!(replaced, [Some(new), None, None, None, None], "without an order both are made");
}

/// Each solid begins with what was asked with the file, and not with what the file asks for the first one.
#[tokio::test]
async fn what_a_file_asks_for_one_of_its_solids_holds_for_that_one_alone() {
    let ledger = fresh().await;
    let file = ledger.record_claim(&asked(new_part("a", 1), |terms| terms.priority = 40)).await.unwrap().id;
    let asks = |reference: &str, priority: Option<u8>, orientation: Option<OrientationRule>| {
        Some(RequestedTerms {
            reference: reference.to_owned(),
            material: None,
            priority,
            clearance_mm: None,
            orientation,
            tilts: RequiredTilts::default(),
        })
    };
    let first = SolidFacts { request: asks("a", Some(100), Some(OrientationRule::Fixed)), ..solid(0, 1) };
    let second = SolidFacts { request: asks("b", None, None), ..solid(1, 1) };
    let parts = ledger.accept_solids(file, &[first, second]).await.unwrap();
    let mut terms = Vec::new();
    for part in parts {
        let part = ledger.find_part(part).await.unwrap().unwrap();
        terms.push((part.terms.reference, part.terms.priority, part.terms.orientation));
    }
    let expected = [("a".to_owned(), 100, OrientationRule::Fixed), ("b".to_owned(), 40, OrientationRule::Free)];
    assert_eq!(terms, expected);
}

/// A file holds five of its part, its revision eight. What was asked with the file is asked with the revision; what the file
/// itself asks for comes from the revision alone.
#[tokio::test]
async fn a_revision_takes_over_how_often_its_file_was_wanted() {
    let ledger = fresh().await;
    let cases = [
        (false, true, None, 8),
        (false, true, Some(10), 16),
        // It cannot be told how often: so many in all.
        (false, true, Some(7), 7),
        (false, false, None, 8),
        (true, true, Some(10), 8),
    ];
    for (at, (has_ticket, is_read, edited, wanted)) in cases.into_iter().enumerate() {
        let claim = async |name: &str, has_ticket: bool| {
            drop_hinge(&ledger, &format!("{name}{at}"), &format!("order {at}"), has_ticket).await
        };
        let file = |held: u32, asked: u32| SolidFacts { file_copies: held, ..solid(0, held * asked) };
        let old = claim("old", false).await;
        if is_read {
            ledger.accept_solids(old, &[file(5, 1)]).await.unwrap();
        }
        if edited.is_some() {
            ledger.edit_part(old, &PartEdit { copies: edited, ..PartEdit::default() }, "a@b").await.unwrap();
        }
        let new = claim("new", has_ticket).await;
        let asked = ledger.find_part(new).await.unwrap().unwrap().owed.copies;
        ledger.accept_solids(new, &[file(8, asked)]).await.unwrap();
        let part = ledger.find_part(new).await.unwrap().unwrap();
        assert_eq!(part.owed.copies, wanted, "{has_ticket} {is_read} {edited:?}");
    }
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn an_order_whose_part_was_replaced_is_complete_with_the_copies_of_the_newer_revision() {
    let ledger = fresh().await;
    let old = drop_hinge(&ledger, "a", "brandt", true).await;
    ledger.accept_solids(old, &[solid(0, 3)]).await.unwrap();
    let new = drop_hinge(&ledger, "b", "brandt", true).await;
    ledger.accept_solids(new, &[solid(0, 3)]).await.unwrap();
    ledger.cancel_part(old, RefusalCause::Replaced, "a newer one came").await.unwrap();
    assert_eq!(copies(&ledger, old).await, LineCopies { cancelled: 3, ..Default::default() });
    let build = published(&ledger, &[(new, 0), (new, 1), (new, 2)]).await;
    ledger.record_outcome(build, &told(PrintOutcome::Complete)).await.unwrap();
    assert_eq!(ledger.find_order("brandt").await.unwrap().unwrap().state, OrderState::Complete);
    // Where both are wanted, the earlier one is taken back with its copies.
    ledger.retry_part(old).await.unwrap();
    assert_eq!(copies(&ledger, old).await.wanted, 3);
    assert_eq!(ledger.find_order("brandt").await.unwrap().unwrap().state, OrderState::Open);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn an_order_whose_refused_part_was_dropped_again_is_complete_with_its_copies() {
    let ledger = fresh().await;
    let named = |claim: &str, name: &str, copies: u32| {
        let part = asked(new_part(claim, copies), |terms| terms.order_name = "brandt".to_owned());
        NewPartRow { name: name.to_owned(), ..part }
    };
    let refused = ledger.record_claim(&named("a", "lid.stl", 3)).await.unwrap().id;
    let other = ledger.record_claim(&named("b", "ring.stl", 1)).await.unwrap().id;
    for part in [refused, other] {
        ledger.refuse_claim(part, RefusalCause::Ticket, "broken").await.unwrap();
    }
    let new = ledger.record_drops(&[(&named("c", "lid.stl", 3), true)]).await.unwrap()[0].id;
    ledger.accept_solids(new, &[solid(0, 3)]).await.unwrap();
    assert_eq!(copies(&ledger, refused).await, LineCopies { cancelled: 3, ..Default::default() });
    assert_eq!(copies(&ledger, other).await.refused, 1, "another part is still to come");
    let build = published(&ledger, &[(new, 0), (new, 1), (new, 2)]).await;
    ledger.record_outcome(build, &told(PrintOutcome::Complete)).await.unwrap();
    assert_eq!(ledger.find_order("brandt").await.unwrap().unwrap().state, OrderState::Short);
    let again = ledger.record_drops(&[(&named("d", "ring.stl", 1), true)]).await.unwrap()[0].id;
    ledger.accept_solids(again, &[solid(0, 1)]).await.unwrap();
    let build = published(&ledger, &[(again, 0)]).await;
    ledger.record_outcome(build, &told(PrintOutcome::Complete)).await.unwrap();
    assert_eq!(ledger.find_order("brandt").await.unwrap().unwrap().state, OrderState::Complete);
    // Where both are wanted, the refused one is taken back with its copies.
    ledger.retry_part(refused).await.unwrap();
    assert_eq!(copies(&ledger, refused).await.wanted, 3);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn orders_are_found_by_any_part_of_their_name_in_any_case() {
    let ledger = fresh().await;
    for (claim, order) in [("a", "Brandt 1182"), ("b", "MÜLLER-7"), ("c", "meyer")] {
        line(&ledger, claim, 1, order).await;
    }
    let find = async |name: &str| -> Vec<String> {
        let query = OrderQuery { name: Some(name.to_owned()), limit: 10, ..Default::default() };
        ledger.list_orders(&query).await.unwrap().into_iter().map(|order| order.name).collect()
    };
    assert_eq!(find("1182").await, ["Brandt 1182"]);
    assert_eq!(find("müller").await, ["MÜLLER-7"]);
    assert_eq!(find("x").await, [""; 0]);
}
