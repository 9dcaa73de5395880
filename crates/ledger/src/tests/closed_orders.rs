//! Who orders are for, in which order they are listed, and how a person closes one as it is.

use super::*;

async fn drop_line(ledger: &Ledger, claim: &str, copies: u32, ask: impl FnOnce(&mut NewTerms)) -> PartId {
    let part = asked(new_part(claim, copies), ask);
    let id = ledger.record_claim(&part).await.unwrap().id;
    ledger.accept_solids(id, &[solid(0, copies)]).await.unwrap();
    id
}

async fn drop_in(ledger: &Ledger, claim: &str, copies: u32, order: &str) -> PartId {
    drop_line(ledger, claim, copies, |terms| terms.order_name = order.to_owned()).await
}

async fn print(ledger: &Ledger, copies: &[(PartId, u32)]) {
    let build = published(ledger, copies).await;
    let told = ToldOutcome::new(PrintOutcome::Complete, "", "ann@farm");
    ledger.record_outcome(build, &told).await.unwrap();
}

async fn order(ledger: &Ledger, name: &str) -> OrderRow {
    ledger.find_order(name).await.unwrap().unwrap()
}

async fn close(ledger: &Ledger, name: &str) -> Result<Vec<String>, LedgerError> {
    let word = OperatorWord::CloseOrder(name.to_owned());
    Ok(ledger.carry_out(&word, "ann@farm", &SeenFiles::new(), false).await?.sentences)
}

#[tokio::test]
async fn an_order_is_for_the_customers_of_its_lines_and_that_can_always_be_changed() {
    let ledger = fresh().await;
    let ask = |customer: &'static str| {
        move |terms: &mut NewTerms| (terms.order_name, terms.customer) = ("K-1".to_owned(), customer.to_owned())
    };
    let first = drop_line(&ledger, "a", 1, ask("Müller & Söhne")).await;
    let other = drop_line(&ledger, "b", 1, ask("")).await;
    assert_eq!(order(&ledger, "K-1").await.customer, "Müller & Söhne");
    print(&ledger, &[(first, 0)]).await;
    let edit = PartEdit { customer: Some("Brandt".to_owned()), ..PartEdit::default() };
    for part in [first, other] {
        let edited = ledger.edit_part(part, &edit, "ann@farm").await.unwrap();
        assert!(edited.changes[0].starts_with("customer Brandt instead of"), "{edited:?}");
    }
    assert_eq!(order(&ledger, "K-1").await.customer, "Brandt");
    let late = PartEdit { priority: Some(1), ..edit.clone() };
    assert!(ledger.edit_part(first, &late, "ann@farm").await.is_err(), "it is built");
    assert_eq!(late.possible_in(PartState::Built), edit);
    drop_line(&ledger, "c", 1, ask("ÄRZTE")).await;
    let of = async |customer: &str| {
        let query = OrderQuery { customer: Some(customer.to_owned()), limit: 9, ..OrderQuery::default() };
        ledger.list_orders(&query).await.unwrap().len()
    };
    assert_eq!((of("ärz").await, of("BRAND").await, of("müller").await, of("%").await), (1, 1, 0, 0));
    // A revision without a word of it is for the same one.
    let again = NewPartRow { name: "b.stl".to_owned(), ..asked(new_part("d", 1), ask("")) };
    let new = ledger.record_drops(&[(&again, true)]).await.unwrap()[0].id;
    assert_eq!(ledger.find_part(new).await.unwrap().unwrap().terms.customer, "Brandt");
}

#[tokio::test]
async fn orders_are_listed_by_due_date_and_those_that_are_over_come_last() {
    let ledger = fresh().await;
    let due = |order: &'static str, at: Option<&'static str>| {
        move |terms: &mut NewTerms| {
            terms.order_name = order.to_owned();
            terms.due_at = at.map(super::at);
        }
    };
    let done = drop_line(&ledger, "a", 1, due("done", Some("2026-11-01T00:00:00Z"))).await;
    drop_line(&ledger, "b", 1, due("later", Some("2026-12-02T00:00:00Z"))).await;
    drop_line(&ledger, "c", 1, due("undated", None)).await;
    drop_line(&ledger, "d", 1, due("overdue", Some("2026-11-02T00:00:00Z"))).await;
    let short = drop_line(&ledger, "e", 1, due("short", Some("2026-12-01T00:00:00Z"))).await;
    let given_up = drop_line(&ledger, "f", 1, due("given up", Some("2026-12-01T00:00:00Z"))).await;
    print(&ledger, &[(done, 0)]).await;
    ledger.cancel_part(short, RefusalCause::TooLarge, "too large").await.unwrap();
    ledger.cancel_part(given_up, RefusalCause::TooLarge, "too large").await.unwrap();
    close(&ledger, "given up").await.unwrap();
    let list = async |query: OrderQuery| -> Vec<String> {
        ledger.list_orders(&query).await.unwrap().into_iter().map(|order| order.name).collect()
    };
    let all = OrderQuery { limit: 9, ..OrderQuery::default() };
    let listed = list(all.clone()).await;
    assert_eq!(listed[..4], ["overdue", "short", "later", "undated"]);
    assert_eq!(listed.len(), 6);
    assert_eq!(list(OrderQuery { is_asking: true, limit: 3, ..all }).await, ["overdue", "short", "later"]);
}

#[tokio::test]
async fn an_order_is_closed_as_it_is_and_the_record_says_who_did_it_and_with_how_many() {
    let ledger = fresh().await;
    let hinge = drop_in(&ledger, "hinge", 6, "A-17").await;
    let lid = drop_in(&ledger, "lid", 3, "A-17").await;
    print(&ledger, &[(hinge, 0), (hinge, 1)]).await;
    let queued = published(&ledger, &[(hinge, 2), (hinge, 3)]).await;
    ledger.cancel_part(lid, RefusalCause::TooLarge, "too large").await.unwrap();
    assert_eq!(ledger.line_of_part(lid).await.unwrap().copies.refused, 3);
    let told = close(&ledger, "A-17").await.unwrap();
    assert_eq!(
        told,
        [
            "Order A-17 is closed with 4 of 9 copies.",
            "2 copies that wait are cancelled.",
            "3 copies that were refused are not asked for any more.",
            "2 copies are still in a build: the order is over when its print is told.",
        ]
    );
    let row = order(&ledger, "A-17").await;
    assert_eq!(
        (row.closing.closed_by.as_deref(), row.closing.accepted_copies, row.closing.closed_of),
        (Some("ann@farm"), Some(4), Some(9))
    );
    assert_eq!((row.state, row.is_over()), (OrderState::Open, false), "two of its copies are in the queue");
    let status = ledger.machine_statuses().await.unwrap();
    assert_eq!(status[0].refused_parts, 0, "nobody is asked for the lid");
    // The daemon gives the file of what waits back, and cancels it.
    let commands = ledger.pending_commands().await.unwrap();
    let [cancel] = &commands[..] else { panic!("{commands:?}") };
    assert_eq!(
        (cancel.kind, cancel.part_id, cancel.read_argument().unwrap().copies),
        (CommandKind::Cancel, Some(hinge), Some(2))
    );
    ledger.cancel_copies(hinge, 2, "ann@farm").await.unwrap();
    let good = ToldOutcome::new(PrintOutcome::Complete, "", "ann@farm");
    ledger.record_outcome(queued, &good).await.unwrap();
    let row = order(&ledger, "A-17").await;
    assert_eq!((row.state, row.is_over()), (OrderState::Complete, true));
    let events = ledger.events_of_part(lid).await.unwrap();
    assert!(events.iter().any(|event| event.detail == "ann@farm: order A-17 closed with 4 of 9 copies"), "{events:#?}");
    assert!(matches!(close(&ledger, "A-17").await, Err(LedgerError::NotClosed(CloseOrderError::NothingToClose(_)))));
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
    // Who takes the refused part back wants its copies: the order is not closed any more.
    ledger.retry_part(lid).await.unwrap();
    assert_eq!(ledger.line_of_part(lid).await.unwrap().copies.wanted, 3);
    ledger.refuse_claim(lid, RefusalCause::TooLarge, "too large").await.unwrap();
    let row = order(&ledger, "A-17").await;
    assert_eq!((row.state, row.closing.closed_at, row.is_over()), (OrderState::Short, None, false));
}

#[tokio::test]
async fn an_order_of_which_nothing_asks_and_one_that_is_being_read_are_not_closed() {
    let ledger = fresh().await;
    assert!(matches!(close(&ledger, "A-17").await, Err(LedgerError::NotClosed(CloseOrderError::Unknown(_)))));
    let claimed = asked(new_part("a", 1), |terms| terms.order_name = "A-17".to_owned());
    let part = ledger.record_claim(&claimed).await.unwrap().id;
    assert!(matches!(close(&ledger, "A-17").await, Err(LedgerError::NotClosed(CloseOrderError::BeingRead(_)))));
    ledger.accept_solids(part, &[solid(0, 1)]).await.unwrap();
    let build = published(&ledger, &[(part, 0)]).await;
    assert!(matches!(close(&ledger, "A-17").await, Err(LedgerError::NotClosed(CloseOrderError::NothingToClose(_)))));
    let failed = ToldOutcome { keep: true, ..ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm") };
    ledger.record_outcome(build, &failed).await.unwrap();
    assert_eq!(order(&ledger, "A-17").await.state, OrderState::Short);
    assert_eq!(close(&ledger, "A-17").await.unwrap(), ["Order A-17 is closed with 0 of 1 copy."]);
    assert!(order(&ledger, "A-17").await.is_over());
    // More of it arrives.
    drop_in(&ledger, "b", 1, "A-17").await;
    let row = order(&ledger, "A-17").await;
    assert_eq!((row.state, row.closing), (OrderState::Open, OrderClosing::default()));
}

#[tokio::test]
async fn what_waits_of_an_order_that_is_closed_is_not_wanted_any_more_once_it_is_cancelled() {
    let ledger = fresh().await;
    let part = drop_in(&ledger, "a", 3, "A-17").await;
    close(&ledger, "A-17").await.unwrap();
    let commands = ledger.pending_commands().await.unwrap();
    assert_eq!(
        (commands[0].part_id, commands[0].read_argument().unwrap().copies),
        (Some(part), None),
        "the whole part"
    );
    ledger.cancel_part(part, RefusalCause::Cancelled, "Cancelled by ann@farm.").await.unwrap();
    let copies = ledger.line_of_part(part).await.unwrap().copies;
    assert_eq!(copies, LineCopies { cancelled: 3, ..LineCopies::default() });
    let row = order(&ledger, "A-17").await;
    assert!(row.is_over() && row.closing.closed_of == Some(3), "{row:?}");
    // Who wants it all the same takes it back with its copies.
    ledger.retry_part(part).await.unwrap();
    assert_eq!(ledger.line_of_part(part).await.unwrap().copies.wanted, 3);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn what_is_being_cancelled_is_not_nested_meanwhile() {
    let ledger = fresh().await;
    let part = drop_in(&ledger, "a", 4, "A-17").await;
    let first = published(&ledger, &[(part, 0)]).await;
    close(&ledger, "A-17").await.unwrap();
    let build = ledger.open_build("paper-200").await.unwrap().id;
    let nested = ledger.begin_nesting(build, "flush", &[(part, 1)]).await;
    assert!(matches!(nested, Err(LedgerError::AskedBack(of)) if of == part), "{nested:?}");
    let cancel = ledger.pending_commands().await.unwrap().remove(0);
    ledger.for_command(cancel.id).cancel_copies(part, 3, "ann@farm").await.unwrap();
    assert_eq!(ledger.find_part(part).await.unwrap().unwrap().state, PartState::Built);
    let again = ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm");
    ledger.record_outcome(first, &again).await.unwrap();
    ledger.begin_nesting(build, "flush", &[(part, 0)]).await.unwrap();
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn copies_whose_file_is_asked_for_again_can_be_cancelled() {
    let ledger = fresh().await;
    let part = drop_in(&ledger, "a", 4, "A-17").await;
    published(&ledger, &[(part, 0)]).await;
    let unit = PartEdit { unit: Some(build_file::LengthUnit::Inch), ..PartEdit::default() };
    ledger.edit_part(part, &unit, "ann@farm").await.unwrap();
    let row = ledger.find_part(part).await.unwrap().unwrap();
    ledger.mark_damaged(&row.file.content_hash, "it was damaged").await.unwrap();
    assert_eq!((row.state, ledger.damaged_parts().await.unwrap().len()), (PartState::Claimed, 1));
    close(&ledger, "A-17").await.unwrap();
    let cancel = ledger.pending_commands().await.unwrap().remove(0);
    assert_eq!(ledger.waiting_copies_of(part).await.unwrap(), 3);
    let copies = cancel.read_argument().unwrap().copies.unwrap();
    ledger.for_command(cancel.id).cancel_copies(part, copies, "ann@farm").await.unwrap();
    assert_eq!(ledger.find_part(part).await.unwrap().unwrap().state, PartState::Built);
    assert_eq!(ledger.damaged_parts().await.unwrap().len(), 0, "nobody is asked for its file");
    assert_eq!(ledger.line_of_part(part).await.unwrap().copies.waiting, 0);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn each_address_of_the_lines_of_an_order_gets_mail_once_and_can_always_be_changed() {
    let ledger = fresh().await;
    let ask = |email: &'static str| {
        move |terms: &mut NewTerms| (terms.order_name, terms.email) = ("K-1".to_owned(), email.to_owned())
    };
    let first = drop_line(&ledger, "a", 1, ask("ann@example.org")).await;
    drop_line(&ledger, "b", 1, ask("ann@example.org")).await;
    drop_line(&ledger, "c", 1, ask("")).await;
    drop_line(&ledger, "d", 1, |terms| terms.email = "nobody@example.org".to_owned()).await;
    assert_eq!(ledger.emails_of_order("K-1").await.unwrap(), ["ann@example.org"]);
    assert!(ledger.emails_of_order("").await.unwrap().is_empty());
    print(&ledger, &[(first, 0)]).await;
    let edit = |email: &str| PartEdit { email: Some(email.to_owned()), ..PartEdit::default() };
    let edited = ledger.edit_part(first, &edit("bo@example.org"), "ann@farm").await.unwrap();
    assert_eq!(edited.changes, ["email bo@example.org instead of ann@example.org"]);
    assert_eq!(ledger.emails_of_order("K-1").await.unwrap(), ["ann@example.org", "bo@example.org"]);
    for (wrong, is_right) in [("bo", false), ("a b@example.org", false), ("bo@example", false), ("", true)] {
        assert_eq!(edit(wrong).checked().is_ok(), is_right, "{wrong}");
    }
}

#[tokio::test]
async fn a_print_that_was_good_after_all_counts_although_its_order_was_closed_without_it() {
    let ledger = fresh().await;
    let part = drop_in(&ledger, "a", 2, "K-9").await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    let told = |outcome, is_correction| ToldOutcome { is_correction, ..ToldOutcome::new(outcome, "", "ann@farm") };
    ledger.record_outcome(build, &told(PrintOutcome::Failed, false)).await.unwrap();
    close(&ledger, "K-9").await.unwrap();
    ledger.cancel_part(part, RefusalCause::Cancelled, "Cancelled by ann@farm.").await.unwrap();
    ledger.record_outcome(build, &told(PrintOutcome::Complete, true)).await.unwrap();
    let line = ledger.line_of_part(part).await.unwrap().copies;
    assert_eq!((line.wanted, line.good, line.refused, line.cancelled), (2, 2, 0, 0));
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), Vec::<String>::new());
    ledger.record_outcome(build, &told(PrintOutcome::Failed, true)).await.unwrap();
    let line = ledger.line_of_part(part).await.unwrap().copies;
    assert_eq!((line.wanted, line.good, line.refused), (2, 0, 2), "and bad again");
}

#[tokio::test]
async fn what_a_person_cancelled_is_not_wanted_and_does_not_make_its_order_short() {
    let ledger = fresh().await;
    let hinge = drop_in(&ledger, "hinge", 2, "A-17").await;
    let lid = drop_in(&ledger, "lid", 3, "A-17").await;
    ledger.cancel_part(lid, RefusalCause::Cancelled, "Cancelled by ann@farm.").await.unwrap();
    let copies = ledger.line_of_part(lid).await.unwrap().copies;
    assert_eq!((copies.wanted, copies.refused, copies.cancelled), (0, 0, 3));
    print(&ledger, &[(hinge, 0), (hinge, 1)]).await;
    assert_eq!(order(&ledger, "A-17").await.state, OrderState::Complete);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
    ledger.retry_part(lid).await.unwrap();
    assert_eq!(ledger.line_of_part(lid).await.unwrap().copies.wanted, 3, "who takes it back wants it again");
    assert_eq!(order(&ledger, "A-17").await.state, OrderState::Open);
}
