//! Tests of tickets and lists that come after their parts, on real folders.

use super::*;
use crate::{
    ListOutcome, OrderListRules, ScanLimits, SettledEntry, TakeDecision, UnlistedPolicy, claim_part, finish_order_list,
    release_claim, scan_inbox,
    test_inbox::{TestInbox, files},
};

/// The tickets and rows that one scan offers to the farm.
fn offers(farm: &TestInbox) -> Vec<LateTicket> {
    let mut lists = OrderListTracker::default();
    lists.observe_scan(&scan_inbox(&farm.inbox, ScanLimits::default()).unwrap().entries);
    let of_entry = |one| match one {
        SettledEntry::Orphan { ticket, part_name, .. } => {
            LateTicket::from_orphan(&farm.inbox, &ticket, &part_name, false).into_iter().collect()
        }
        SettledEntry::List { list, .. } => LateTicket::from_list(&farm.inbox, &mut lists, &list, false).unwrap(),
        _ => Vec::new(),
    };
    farm.ready().into_iter().flat_map(of_entry).collect()
}

/// Names and copies (or the error) of all parts that may be taken now.
fn take_parts(farm: &TestInbox) -> Vec<(String, Option<u32>)> {
    let parts = farm.ready().into_iter().filter(|ready| matches!(ready, SettledEntry::Part { .. }));
    let take = |ready: SettledEntry| {
        let claim = claim_part(&farm.inbox, &ready).unwrap();
        let given = claim.read_part_spec().unwrap().ticket.copies;
        release_claim(&claim, "").unwrap();
        (claim.display_name(), given)
    };
    parts.map(take).collect()
}

fn end_list(farm: &TestInbox) -> Vec<ListOutcome> {
    let mut lists = OrderListTracker::default();
    lists.observe_scan(&scan_inbox(&farm.inbox, ScanLimits::default()).unwrap().entries);
    let ready = farm.ready().into_iter().filter(|ready| matches!(ready, SettledEntry::List { .. }));
    ready
        .map(|ready| finish_order_list(&farm.inbox, &mut lists, &ready, 1000.0, &farm.archive, &farm.error).unwrap())
        .collect()
}

#[test]
fn a_ticket_after_its_part_is_offered_with_what_it_says_until_it_is_accepted() {
    let farm = TestInbox::new();
    farm.drop_file("order-7/bracket.stl", "solid");
    assert_eq!(take_parts(&farm), [("bracket.stl".to_owned(), None)]);
    farm.drop_file("order-7/Bracket.STL.toml", "copies = 10\n");
    let late = offers(&farm);
    let [one] = &late[..] else { panic!("{late:?}") };
    assert_eq!((one.order(), one.part_name.as_str()), ("order-7", "Bracket.STL"));
    assert_eq!(one.ticket.as_ref().unwrap().copies, Some(10));
    assert_eq!((one.source.source, one.source.text.as_str()), (SpecSource::Sidecar, "copies = 10\n"));
    // A crash before it was finished: it is offered again under the same key.
    assert_eq!(offers(&farm), late);
    let LateTicketEnd::Moved(to) = one.accept_late_ticket(&farm.inbox, &farm.archive).unwrap() else { panic!() };
    assert_eq!(files(&farm.archive), ["late-tickets/order-7/Bracket.STL.toml"]);
    assert_eq!(fs::read_to_string(to).unwrap(), "copies = 10\n");
    assert_eq!(one.accept_late_ticket(&farm.inbox, &farm.archive).unwrap(), LateTicketEnd::Gone);
    assert_eq!(offers(&farm), []);
    // A later part of the name is not meant by it.
    farm.drop_file("order-7/bracket.stl", "solid 2");
    assert_eq!(take_parts(&farm), [("bracket.stl".to_owned(), None)]);
}

#[test]
fn a_ticket_beside_a_file_is_never_offered() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    farm.drop_file("A.toml", "copies = 3\n");
    assert_eq!(offers(&farm), []);
    assert_eq!(take_parts(&farm), [("a.stl".to_owned(), Some(3))]);
    assert_eq!(offers(&farm), []);
}

#[test]
fn a_ticket_that_changed_after_it_was_offered_is_not_finished() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl.toml", "copies = 3\n");
    let late = offers(&farm).remove(0);
    farm.drop_file("a.stl.toml", "copies = 40\n");
    assert_eq!(late.accept_late_ticket(&farm.inbox, &farm.archive).unwrap(), LateTicketEnd::Changed);
    assert_eq!(late.refuse_late_ticket(&farm.inbox, &farm.error, "no").unwrap(), LateTicketEnd::Changed);
    let again = offers(&farm).remove(0);
    assert!(again.key != late.key && again.ticket.as_ref().unwrap().copies == Some(40));
}

#[test]
fn a_broken_late_ticket_is_offered_with_its_fault_and_refused_with_the_farms_reason() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl.toml", "copies = ten\n");
    let late = offers(&farm).remove(0);
    assert!(late.ticket.as_ref().unwrap_err().to_string().contains("a.stl.toml"));
    let reason = "a.stl is in build 4, published 14:02 with 1 copy.";
    let LateTicketEnd::Moved(to) = late.refuse_late_ticket(&farm.inbox, &farm.error, reason).unwrap() else { panic!() };
    assert_eq!(to, farm.error.join("a.stl.toml"));
    assert!(fs::read_to_string(farm.error.join("a.stl.toml.reason.txt")).unwrap().contains(reason));
    assert_eq!(late.refuse_late_ticket(&farm.inbox, &farm.error, reason).unwrap(), LateTicketEnd::Gone);
}

#[test]
fn a_list_after_its_parts_is_offered_row_by_row_and_archived_when_all_are_served() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    assert_eq!(take_parts(&farm), [("a.stl".to_owned(), None)]);
    farm.drop_file("order.csv", "file;copies\na.stl;5\nb.stl;2\nc.stl;none\n");
    farm.drop_file("b.stl", "solid");
    let late = offers(&farm);
    let names: Vec<&str> = late.iter().map(|one| one.part_name.as_str()).collect();
    assert_eq!(names, ["a.stl", "c.stl"], "the row of the file that is there is not offered");
    assert_eq!(late[0].ticket.as_ref().unwrap().copies, Some(5));
    assert_eq!(late[0].source.text, "file;copies\na.stl;5");
    assert!(late[1].ticket.is_err() && late[0].key != late[1].key);
    assert_eq!(late[0].accept_late_ticket(&farm.inbox, &farm.archive).unwrap(), LateTicketEnd::RowServed);
    assert_eq!(late[0].accept_late_ticket(&farm.inbox, &farm.archive).unwrap(), LateTicketEnd::RowServed);
    assert_eq!(take_parts(&farm), [("b.stl".to_owned(), Some(2))]);
    assert_eq!(end_list(&farm), [ListOutcome::Awaited]);
    assert_eq!(offers(&farm).len(), 1);
    late[1].refuse_late_ticket(&farm.inbox, &farm.error, "its copies are no number").unwrap();
    late[1].refuse_late_ticket(&farm.inbox, &farm.error, "its copies are no number").unwrap();
    assert_eq!(files(&farm.error), ["order.csv", "order.csv.reason.txt"]);
    assert_eq!(fs::read_to_string(farm.error.join("order.csv")).unwrap(), "file;copies\nc.stl;none");
    assert_eq!(offers(&farm), []);
    assert!(matches!(end_list(&farm)[..], [ListOutcome::Archived(_)]));
}

#[test]
fn a_row_that_was_used_for_a_part_taken_before_is_not_used_for_a_later_one() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", "file;copies\na.stl;5\nb.stl;2\n");
    let late = offers(&farm);
    late[0].accept_late_ticket(&farm.inbox, &farm.archive).unwrap();
    farm.drop_file("a.stl", "solid 2");
    assert_eq!(take_parts(&farm), []);
    let rules = |unlisted| OrderListRules { incomplete_secs: 50.0, unlisted };
    let waits = farm.judged(OrderListRules { incomplete_secs: 1000.0, unlisted: UnlistedPolicy::Refuse });
    let is_told = |one: &TakeDecision| matches!(one, TakeDecision::Wait(why) if why.contains("taken before"));
    assert!(waits.iter().any(is_told), "{waits:?}");
    let said = |decision: &TakeDecision| match decision {
        TakeDecision::Take(SettledEntry::Part { lookup, .. }) => lookup.clone(),
        _ => None,
    };
    let refused = farm.judged(rules(UnlistedPolicy::Refuse)).iter().find_map(said).unwrap();
    assert!(refused.is_unlisted && refused.problem.unwrap().contains("taken before"));
    let warned = farm.judged(rules(UnlistedPolicy::Warn)).iter().find_map(said).unwrap();
    assert!(warned.row.is_none() && warned.warnings[0].contains("taken before"));
}

#[test]
fn a_part_is_found_as_people_name_it() {
    let names = ["bracket.stl", "lid.stl", "lid.3mf", "Größe.stl"];
    for (said, found) in [
        ("bracket.stl", NamedPart::Only(0)),
        ("BRACKET", NamedPart::Only(0)),
        ("C:\\jobs\\Bracket.STL", NamedPart::Only(0)),
        ("lid.3mf", NamedPart::Only(2)),
        ("lid", NamedPart::Several),
        ("gro\u{308}ße.stl", NamedPart::Only(3)),
        ("hook.stl", NamedPart::Missing),
        ("", NamedPart::Missing),
    ] {
        assert_eq!(find_named_part(said, &names, CodePage::Unicode), found, "{said}");
    }
}

#[test]
fn a_list_may_mean_parts_of_its_sub_folders_and_a_ticket_does_not() {
    let farm = TestInbox::new();
    farm.drop_file("k/order.csv", "file;copies\nparts\\a.stl;5\n");
    farm.drop_file("order.csv", "file;copies\norder-7/b.stl;2\n");
    farm.drop_file("k/c.stl.toml", "copies = 2\n");
    for (late, orders) in offers(&farm).iter().zip([
        [("k", true), ("k/parts", false), ("", false), ("kk", false)],
        [("k", true), ("k/parts", true), ("", false), ("kk", false)],
        [("", true), ("order-7", true), ("k", false), ("order-8", false)],
    ]) {
        for (order, may_mean) in orders {
            assert_eq!(late.may_mean_order(order), may_mean, "{} {order}", late.part_name);
        }
    }
    // The row is served by the file that it names; the others are asked about, since they would be one copy in silence.
    for name in ["k/parts/a.stl", "order-7/B.stl", "order-8/b.stl", "k/parts/a_x3.stl"] {
        farm.drop_file(name, "solid");
    }
    let mut asked = Vec::new();
    for ready in farm.ready() {
        if let SettledEntry::Part { .. } = ready {
            let claim = claim_part(&farm.inbox, &ready).unwrap();
            let given = claim.read_part_spec().unwrap();
            asked.extend(
                given.warnings.iter().any(|one| build_file::is_copies_question(one)).then(|| claim.display_name()),
            );
        }
    }
    assert_eq!(asked, ["B.stl"]);
}

#[test]
fn a_late_row_means_the_part_in_the_folder_that_it_names() {
    let farm = TestInbox::new();
    farm.drop_file("k/order.csv", "file;copies\nR/a.stl;5\nC:\\order\\L\\b.stl;2\nc.stl;3\n");
    let may_mean = |late: &LateTicket| ["k", "k/R", "k/L", "k/x/R"].map(|order| late.may_mean_order(order));
    let all: Vec<[bool; 4]> = offers(&farm).iter().map(may_mean).collect();
    assert_eq!(all, [[true, true, false, true], [true, false, true, false], [true, true, true, true]]);
}

#[test]
fn a_row_of_an_old_list_finds_a_part_whose_name_has_the_same_bytes() {
    let farm = TestInbox::new();
    std::fs::write(farm.inbox.join("order.csv"), b"Datei;St\xfcck\r\nGr\xf6\xdfe.stl;3\r\n").unwrap();
    let late = offers(&farm).remove(0);
    assert_eq!(late.find_part(&["a.stl", "Gr\\xf6\\xdfe.stl"]), NamedPart::Only(1));
    assert_eq!(late.find_part(&["Gr\\xf6\\xdfe.stl", "Größe.stl"]), NamedPart::Several);
    assert_eq!(late.find_part(&["Gr\\xe4\\xdfe.stl"]), NamedPart::Missing);
}
