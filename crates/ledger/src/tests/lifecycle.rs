//! Tests of the lives of parts and builds, step by step.

use super::*;
use crate::base::sql;

#[tokio::test]
async fn a_claim_recorded_twice_is_one_part_with_one_ticket() {
    let ledger = fresh().await;
    let ticket =
        NewTicketRow { source: TicketSource::Sidecar, file_name: "a.stl.toml".into(), text: "copies = 3".into() };
    let part = NewPartRow { ticket: Some(ticket), warnings: vec!["odd\nname".into()], ..new_part("a", 3) };
    let first = ledger.record_claim(&part).await.unwrap();
    let again = ledger.record_claim(&part).await.unwrap();
    assert_eq!((first.is_new(), again.is_new()), (true, false));
    assert_eq!(first.id, again.id);
    let tickets: i64 =
        sql::query_scalar("SELECT count(*) FROM ticket").fetch_one(ledger.reader().unwrap()).await.unwrap();
    assert_eq!(tickets, 1);
    let row = ledger.find_part(first.id).await.unwrap().unwrap();
    assert_eq!((row.owed.copies, row.state, row.warnings.as_str()), (3, PartState::Claimed, "odd name"));
    assert_eq!(ledger.events_of_part(first.id).await.unwrap().len(), 1);
}

#[tokio::test]
async fn every_field_of_a_claim_comes_back_as_it_went_in() {
    let ledger = fresh().await;
    let terms = NewTerms {
        order_name: "kit 7".into(),
        customer: "Brandt".into(),
        email: "ann@brandt.example".to_owned(),
        material: "PA12".into(),
        finish: "dye black, smooth".to_owned(),
        priority: 100,
        due_at: Some(at("2026-12-01T12:00:00Z")),
        due_text: "2026-12-01".into(),
        orientation: OrientationRule::Upright,
        tilts: RequiredTilts(vec![TiltLimit::new(glam::DVec3::new(1.0, 2.0, 3.0), 12.5).unwrap()]),
        clearance_mm: Some(4.5),
        unit: Some(build_file::LengthUnit::Inch),
        read_unit: None,
        note: "handle with care".into(),
        mend_allowed_by: "ann@farm".to_owned(),
    };
    let part = NewPartRow { terms, ..new_part("full", 2) };
    let id = ledger.record_claim(&part).await.unwrap().id;
    let row = ledger.find_part(id).await.unwrap().unwrap();
    assert_eq!(
        (row.terms.order_name.as_str(), row.terms.customer.as_str(), row.terms.priority, row.file.bytes),
        ("kit 7", "Brandt", 100, 684)
    );
    assert_eq!((row.terms.email.as_str(), row.terms.finish.as_str()), ("ann@brandt.example", "dye black, smooth"));
    assert_eq!(row.mending.mend_allowed_by, "ann@farm");
    assert_eq!(row.terms.due_at.map(|t| t.0), part.terms.due_at);
    assert_eq!(
        (row.terms.orientation, &row.terms.tilts, row.terms.unit),
        (part.terms.orientation, &part.terms.tilts, part.terms.unit)
    );
    assert_eq!((row.terms.clearance_mm, row.terms.note.as_str()), (Some(4.5), "handle with care"));
    assert_eq!((row.size_mm(), row.measures.triangles), (None, None), "not read yet");
    assert_eq!(ledger.parts_of_order("kit 7").await.unwrap().len(), 1);
    assert!(ledger.parts_of_order("").await.unwrap().is_empty(), "no order is no name of an order");
}

#[tokio::test]
async fn further_solids_of_a_file_become_parts_of_their_own() {
    let ledger = fresh().await;
    let claim = asked(new_part("kit", 5), |terms| terms.due_at = Some(at("2026-12-01T12:00:00Z")));
    let id = ledger.record_claim(&claim).await.unwrap().id;
    let second = SolidFacts { object_name: "lid".into(), warnings: vec!["thin".into()], ..solid(1, 10) };
    let parts = ledger.accept_solids(id, &[solid(0, 5), second]).await.unwrap();
    assert_eq!((parts.len(), parts[0]), (2, id));
    let lid = ledger.find_part(parts[1]).await.unwrap().unwrap();
    assert_eq!((lid.owed.copies, lid.solid.object_name.as_str(), lid.warnings.as_str()), (10, "lid", "thin"));
    assert_eq!((lid.terms.due_at.map(|t| t.0), lid.state), (claim.terms.due_at, PartState::Waiting));
    assert_eq!(lid.size_mm(), Some([10.0, 20.0, 30.0]));
    assert_eq!(ledger.parts_of_claim("kit").await.unwrap().len(), 2);
}

#[tokio::test]
async fn a_part_that_is_taken_back_is_not_multiplied_and_leaves_its_siblings_alone() {
    let ledger = fresh().await;
    let id = ledger.record_claim(&new_part("kit", 5)).await.unwrap().id;
    let solids = [solid(0, 5), solid(1, 10)];
    let parts = ledger.accept_solids(id, &solids).await.unwrap();
    ledger.cancel_part(parts[1], RefusalCause::Cancelled, "not needed").await.unwrap();
    ledger.retry_part(parts[1]).await.unwrap();
    assert_eq!(ledger.find_part(parts[1]).await.unwrap().unwrap().refused.reason, "");
    let again = ledger.accept_solids(parts[1], &[solid(0, 25), solid(1, 100)]).await.unwrap();
    assert_eq!(again, [parts[1]]);
    assert_eq!(ledger.find_part(parts[1]).await.unwrap().unwrap().owed.copies, 10);
    assert_eq!(ledger.find_part(parts[0]).await.unwrap().unwrap().owed.copies, 5);
}

#[tokio::test]
async fn a_claim_that_cannot_be_read_is_refused_with_its_reason() {
    let ledger = fresh().await;
    let id = ledger.record_claim(&new_part("bad", 1)).await.unwrap().id;
    ledger.refuse_claim(id, RefusalCause::Format, "the file is empty").await.unwrap();
    let row = ledger.find_part(id).await.unwrap().unwrap();
    assert_eq!((row.state, row.refused.reason.as_str()), (PartState::Refused, "the file is empty"));
    assert!(!ledger.is_hash_in_use(&row.file.content_hash, jiff::Timestamp::MAX).await.unwrap());
    assert!(matches!(ledger.refuse_claim(id, RefusalCause::Format, "again").await, Err(LedgerError::IllegalMove(_))));
    assert!(matches!(ledger.accept_solids(id, &[solid(0, 1)]).await, Err(LedgerError::IllegalMove(_))));
    let other = ledger.record_claim(&new_part("empty", 1)).await.unwrap().id;
    assert!(matches!(ledger.accept_solids(other, &[]).await, Err(LedgerError::NoSolid(_))));
}

#[tokio::test]
async fn a_waiting_part_is_refused_by_cancel_only() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 1).await;
    assert!(matches!(ledger.refuse_claim(id, RefusalCause::Format, "no").await, Err(LedgerError::IllegalMove(_))));
    ledger.cancel_part(id, RefusalCause::Cancelled, "").await.unwrap();
    assert_eq!(ledger.find_part(id).await.unwrap().unwrap().refused.reason, "no reason was given");
    let again = ledger.cancel_part(id, RefusalCause::Cancelled, "").await.unwrap_err().to_string();
    assert_eq!(again, "part 1 is refused or cancelled already; `nestd show p1` says why");
    ledger.retry_part(id).await.unwrap();
    let again = ledger.retry_part(id).await.unwrap_err().to_string();
    assert_eq!(again, "part 1 is claimed; only a part that is refused or cancelled can be retried");
}

#[tokio::test]
async fn each_refusal_and_each_taking_back_of_a_claim_is_counted() {
    let ledger = fresh().await;
    let id = ledger.record_claim(&new_part("kit", 1)).await.unwrap().id;
    let parts = ledger.accept_solids(id, &[solid(0, 1), solid(1, 1)]).await.unwrap();
    assert_eq!(ledger.decision_count("kit").await.unwrap(), 0);
    ledger.cancel_part(parts[1], RefusalCause::Cancelled, "").await.unwrap();
    ledger.retry_part(parts[1]).await.unwrap();
    ledger.refuse_claim(parts[1], RefusalCause::Format, "").await.unwrap();
    ledger.give_up_claims(&["kit".to_owned()], "").await.unwrap();
    ledger.retry_part(parts[0]).await.unwrap();
    assert_eq!(ledger.decision_count("kit").await.unwrap(), 5);
}

#[tokio::test]
async fn a_ledger_that_knows_fewer_decisions_than_were_noted_says_so_until_it_counts_them() {
    let ledger = fresh().await;
    for claim in ["a", "b", "c"] {
        let id = waiting(&ledger, claim, 1).await;
        ledger.cancel_part(id, RefusalCause::Cancelled, "").await.unwrap();
    }
    let noted = |claims: &[(&str, u32)]| claims.iter().map(|(claim, count)| ((*claim).to_owned(), *count)).collect();
    assert_eq!(ledger.claims_with_more_decisions(&noted(&[])).await.unwrap(), []);
    assert_eq!(ledger.claims_with_more_decisions(&noted(&[("a", 1), ("b", 0), ("unknown", 7)])).await.unwrap(), []);
    let since = ledger.claims_with_more_decisions(&noted(&[("a", 1), ("b", 2), ("c", 12)])).await.unwrap();
    let since: Vec<_> = since.iter().map(|claim| (claim.claim.as_str(), claim.decisions)).collect();
    assert_eq!(since, [("b", 2), ("c", 12)]);
    for (least, now) in [(12, 12), (3, 12)] {
        ledger.raise_decision_count("c", least).await.unwrap();
        assert_eq!(ledger.decision_count("c").await.unwrap(), now);
    }
    ledger.raise_decision_count("unknown", 3).await.unwrap();
    assert_eq!(ledger.claims_with_more_decisions(&noted(&[("a", 1), ("c", 12)])).await.unwrap(), []);
}

#[tokio::test]
async fn a_part_is_built_when_its_last_copy_is_published() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 3).await;
    let first = published(&ledger, &[(id, 0), (id, 1)]).await;
    assert_eq!(part_state(&ledger, id).await, PartState::Waiting, "a copy waits still");
    assert_eq!(ledger.waiting_copies("paper-200").await.unwrap()[0].copies, [2]);
    let second = nesting(&ledger, &[(id, 2)]).await;
    assert_eq!(part_state(&ledger, id).await, PartState::Batched);
    ledger.verify_build(second, &verified(second, 1), &placed(&[(id, 2)])).await.unwrap();
    ledger.publish_build(second).await.unwrap();
    assert_eq!(part_state(&ledger, id).await, PartState::Built);
    assert_eq!(ledger.copies_of_build(first).await.unwrap(), [(id, 0), (id, 1)]);
    let builds: Vec<BuildId> = ledger.placements_of_part(id).await.unwrap().iter().map(|p| p.build_id).collect();
    assert_eq!(builds, [first, first, second]);
}

#[tokio::test]
async fn a_copy_is_in_one_build_only() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 2).await;
    let first = nesting(&ledger, &[(id, 0)]).await;
    let second = ledger.open_build("paper-200").await.unwrap().id;
    let taken = ledger.begin_nesting(second, "flush", &[(id, 1), (id, 0)]).await;
    assert!(matches!(taken, Err(LedgerError::CopyTaken { copy: 0, build, .. }) if build == first));
    assert_eq!(build_state(&ledger, second).await, BuildState::Open, "nothing of the failed change is kept");
    assert!(ledger.copies_of_build(second).await.unwrap().is_empty());
    let missing = ledger.begin_nesting(second, "flush", &[(id, 2)]).await;
    assert!(matches!(missing, Err(LedgerError::NoSuchCopy { copy: 2, .. })));
    let nothing = ledger.begin_nesting(second, "flush", &[]).await;
    assert!(matches!(nothing, Err(LedgerError::NothingToNest(_))));
    let other = ledger.open_build("fuse-1").await.unwrap().id;
    let mixed = ledger.begin_nesting(other, "flush", &[(id, 1)]).await;
    assert!(matches!(mixed, Err(LedgerError::WrongMachine { .. })));
    ledger.begin_nesting(second, "flush", &[(id, 1)]).await.unwrap();
    assert_eq!(part_state(&ledger, id).await, PartState::Batched);
}

#[tokio::test]
async fn copies_that_find_no_place_wait_again() {
    let ledger = fresh().await;
    let (a, b) = (waiting(&ledger, "a", 1).await, waiting(&ledger, "b", 2).await);
    let build = nesting(&ledger, &[(a, 0), (b, 0), (b, 1)]).await;
    ledger.release_copies(build, &[(b, 1)], "found no place").await.unwrap();
    assert_eq!(part_state(&ledger, b).await, PartState::Waiting);
    assert_eq!(part_state(&ledger, a).await, PartState::Batched);
    let twice = ledger.release_copies(build, &[(b, 1)], "found no place").await;
    assert!(matches!(twice, Err(LedgerError::NotInBuild { copy: 1, .. })));
    assert_eq!(ledger.begin_attempt(build).await.unwrap(), 2);
    let wrong = ledger.verify_build(build, &verified(build, 3), &placed(&[(a, 0), (b, 0), (b, 1)])).await;
    assert!(matches!(wrong, Err(LedgerError::PlacementsDiffer { taken: 2, placed: 3, .. })));
    let doubled = ledger.verify_build(build, &verified(build, 2), &placed(&[(a, 0), (a, 0)])).await;
    assert!(matches!(doubled, Err(LedgerError::PlacementsDiffer { .. })));
    ledger.verify_build(build, &verified(build, 2), &placed(&[(b, 0), (a, 0)])).await.unwrap();
    assert_eq!(build_state(&ledger, build).await, BuildState::Verified);
    let row = &ledger.placements_of_build(build).await.unwrap()[0];
    assert_eq!((row.part_id, row.pose_columns.qw, row.pose_columns.tz_mm), (a, Some(1.0), Some(3.0)));
}

#[tokio::test]
async fn a_proved_build_whose_staged_file_was_spoilt_is_nested_again_with_its_copies_and_poses() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 2).await;
    let build = nesting(&ledger, &[(id, 0), (id, 1)]).await;
    let fired = ledger.find_build(build).await.unwrap().unwrap().times.nesting_at;
    ledger.verify_build(build, &verified(build, 2), &placed(&[(id, 0), (id, 1)])).await.unwrap();
    assert_eq!(ledger.find_build(build).await.unwrap().unwrap().sidecar_hashes().len(), 1);
    ledger.begin_publishing(build).await.unwrap();
    assert!(ledger.find_build(build).await.unwrap().unwrap().staged.publishing_at.is_some());
    ledger.reopen_verified_build(build, "it was removed").await.unwrap();
    let row = ledger.find_build(build).await.unwrap().unwrap();
    assert_eq!((row.state, row.times.nesting_at, row.times.verified_at), (BuildState::Nesting, fired, None));
    assert_eq!(
        (row.sidecar_hashes().is_empty(), row.staged.publishing_at, row.staged.file_name, row.staged.file_hash),
        (true, None, None, None)
    );
    assert!(ledger.placements_of_build(build).await.unwrap().iter().all(|row| row.pose().is_some()));
    ledger.verify_build(build, &verified(build, 2), &placed(&[(id, 0), (id, 1)])).await.unwrap();
    ledger.publish_build(build).await.unwrap();
    assert!(ledger.reopen_verified_build(build, "no").await.is_err(), "what was published is never written again");
    assert!(ledger.begin_publishing(build).await.is_err());
    assert_eq!(part_state(&ledger, id).await, PartState::Built);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), [""; 0]);
}

#[tokio::test]
async fn a_failed_build_lets_all_its_copies_go_and_says_why() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 2).await;
    let build = nesting(&ledger, &[(id, 0), (id, 1)]).await;
    ledger.fail_build(build, "the proof failed three times").await.unwrap();
    let row = ledger.find_build(build).await.unwrap().unwrap();
    assert_eq!((row.state, row.reason.as_str()), (BuildState::Failed, "the proof failed three times"));
    assert_eq!((row.measures.copies, row.measures.height_mm), (Some(0), None));
    assert_eq!(ledger.waiting_copies("paper-200").await.unwrap()[0].copies, [0, 1]);
    let kinds: Vec<String> =
        ledger.events_of_build(build).await.unwrap().into_iter().map(|e| e.kind.to_string()).collect();
    assert_eq!(kinds, ["nesting", "batched", "waiting", "failed"]);
}

#[tokio::test]
async fn a_part_cannot_be_cancelled_while_a_copy_is_being_nested() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 2).await;
    let build = nesting(&ledger, &[(id, 0)]).await;
    assert!(matches!(ledger.cancel_part(id, RefusalCause::Cancelled, "no").await, Err(LedgerError::BeingBuilt { .. })));
    ledger.verify_build(build, &verified(build, 1), &placed(&[(id, 0)])).await.unwrap();
    assert!(matches!(ledger.cancel_part(id, RefusalCause::Cancelled, "no").await, Err(LedgerError::BeingBuilt { .. })));
    ledger.publish_build(build).await.unwrap();
    ledger.cancel_part(id, RefusalCause::Cancelled, "one is enough").await.unwrap();
    ledger.retry_part(id).await.unwrap();
    ledger.accept_solids(id, &[solid(0, 2)]).await.unwrap();
    let line = ledger.waiting_copies("paper-200").await.unwrap();
    assert_eq!(line[0].copies, [1], "the published copy is not built twice");
}

#[tokio::test]
async fn an_outcome_of_a_published_build_passes_through_printing() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 1).await;
    let build = published(&ledger, &[(id, 0)]).await;
    ledger.record_outcome(build, &ToldOutcome::new(PrintOutcome::Complete, "fine", "ann@farm")).await.unwrap();
    let row = ledger.find_build(build).await.unwrap().unwrap();
    assert_eq!((row.state, row.reason.as_str()), (BuildState::Complete, "fine"));
    let kinds: Vec<String> =
        ledger.events_of_build(build).await.unwrap().into_iter().map(|e| e.kind.to_string()).collect();
    assert_eq!(kinds, ["nesting", "batched", "verified", "published", "built", "printing", "complete"]);
    let recorded = ledger.outcomes_of_build(build).await.unwrap();
    assert_eq!(
        (recorded.len(), recorded[0].outcome, recorded[0].told_by.as_str()),
        (1, PrintOutcome::Complete, "ann@farm")
    );
    let again = ledger.record_outcome(build, &ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm")).await;
    assert!(matches!(again, Err(LedgerError::AlreadyTold { .. })));
    assert_eq!(part_state(&ledger, id).await, PartState::Built);
}

#[tokio::test]
async fn an_outcome_cannot_be_recorded_for_a_build_that_is_not_in_the_queue() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 1).await;
    let build = nesting(&ledger, &[(id, 0)]).await;
    let recorded = ledger.record_outcome(build, &ToldOutcome::new(PrintOutcome::Failed, "", "ann")).await;
    assert!(matches!(recorded, Err(LedgerError::WrongState { .. })));
    let unknown = ledger.record_outcome(BuildId(99), &ToldOutcome::new(PrintOutcome::Failed, "", "ann")).await;
    assert!(matches!(unknown, Err(LedgerError::UnknownBuild(BuildId(99)))));
}

#[tokio::test]
async fn the_open_build_is_one_and_keeps_its_layout_until_it_is_verified() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 1).await;
    let build = ledger.open_build("paper-200").await.unwrap().id;
    assert_eq!(ledger.open_build("paper-200").await.unwrap().id, build);
    let layout = OpenLayout { layout: "{}".into(), height_mm: 30.0, density: 0.1, copies: 1, part_volume_mm3: 1000.0 };
    ledger.save_layout(build, &layout).await.unwrap();
    ledger.add_cpu_secs(build, 1.5).await.unwrap();
    ledger.begin_nesting(build, "fill", &[(id, 0)]).await.unwrap();
    assert_eq!(ledger.find_build(build).await.unwrap().unwrap().kept.layout.as_deref(), Some("{}"));
    assert_ne!(ledger.open_build("paper-200").await.unwrap().id, build);
    ledger.verify_build(build, &verified(build, 1), &placed(&[(id, 0)])).await.unwrap();
    let row = ledger.find_build(build).await.unwrap().unwrap();
    assert_eq!((row.kept.layout, row.search.cpu_secs, row.search.seed), (None, Some(12.0), Some(7)));
    assert_eq!((row.fired_by.as_str(), row.attempts, row.search.evaluations), ("fill", 1, Some(12_345)));
    assert!(matches!(ledger.save_layout(build, &layout).await, Err(LedgerError::WrongState { .. })));
    assert!(matches!(ledger.add_cpu_secs(build, 1.0).await, Err(LedgerError::WrongState { .. })));
}

#[tokio::test]
async fn the_open_build_of_a_removed_machine_can_be_dropped() {
    let ledger = fresh().await;
    let build = ledger.open_build("gone").await.unwrap().id;
    ledger.write_event(EventKind::Unknown("improved".to_owned()), "gone", None, Some(build), "").await.unwrap();
    ledger.delete_open_build("gone").await.unwrap();
    assert_eq!(ledger.find_build(build).await.unwrap(), None);
    assert!(ledger.builds_in_state(BuildState::Open).await.unwrap().is_empty());
    ledger.delete_open_build("gone").await.unwrap();
}

#[tokio::test]
async fn waiting_copies_and_the_parts_of_a_build_come_in_order_of_precedence() {
    let ledger = fresh().await;
    let mut ids = Vec::new();
    for (claim, priority) in [("a", 10), ("b", 90), ("c", 50)] {
        let part = asked(new_part(claim, 1), |terms| terms.priority = priority);
        let id = ledger.record_claim(&part).await.unwrap().id;
        ledger.accept_solids(id, &[solid(0, 1)]).await.unwrap();
        ids.push(id);
    }
    let expected = [ids[1], ids[2], ids[0]];
    let waiting = ledger.waiting_copies("paper-200").await.unwrap();
    assert_eq!(waiting.iter().map(|waiting| waiting.part.id).collect::<Vec<_>>(), expected);
    let copies: Vec<_> = ids.iter().map(|&id| (id, 0)).collect();
    let build = nesting(&ledger, &copies).await;
    let parts = ledger.parts_of_build(build).await.unwrap();
    assert_eq!(parts.iter().map(|part| part.id).collect::<Vec<_>>(), expected);
}

#[tokio::test]
async fn a_layout_that_lacks_copies_of_a_build_tells_nothing_of_its_height() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 3).await;
    let build = ledger.open_build("paper-200").await.unwrap().id;
    let layout = |copies: u32| OpenLayout {
        layout: "[]".to_owned(),
        height_mm: 72.0,
        density: 0.1,
        copies,
        part_volume_mm3: 1000.0,
    };
    let height = async || ledger.find_build(build).await.unwrap().unwrap().measures.height_mm;
    ledger.save_layout(build, &layout(1)).await.unwrap();
    assert_eq!(height().await, Some(72.0), "of what stands in the open build");
    ledger.begin_nesting(build, "flush", &[(part, 0), (part, 1), (part, 2)]).await.unwrap();
    assert_eq!(height().await, None, "two copies more are in it");
    ledger.save_layout(build, &layout(2)).await.unwrap();
    assert_eq!(height().await, None);
    ledger.save_layout(build, &layout(3)).await.unwrap();
    assert_eq!(height().await, Some(72.0));
    assert!(ledger.volume_of_build(build).await.unwrap() > 0.0);
}
