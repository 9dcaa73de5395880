//! Breaking a build out: what people say of its copies, what is told of the build in the end, and what is done with the parts afterwards.

use super::*;

const ANN: &str = "ann@dashboard";
const BEN: &str = "ben@dashboard";

/// A published build of three copies of one part.
async fn printed(ledger: &Ledger) -> (BuildId, PartId) {
    let part = waiting(ledger, "a", 3).await;
    (published(ledger, &[(part, 0), (part, 1), (part, 2)]).await, part)
}

async fn marks(ledger: &Ledger, build: BuildId) -> Vec<(u32, PickMark, String)> {
    let rows = ledger.picks_of_build(build).await.unwrap();
    rows.into_iter().map(|row| (row.copy, row.mark, row.told_by)).collect()
}

#[tokio::test]
async fn of_two_people_who_say_the_same_of_a_copy_the_second_hears_who_was_first() {
    let ledger = fresh().await;
    let (build, part) = printed(&ledger).await;
    assert_eq!(ledger.mark_pick(build, (part, 1), PickMark::Out, 0, ANN).await.unwrap(), None);
    assert_eq!(ledger.mark_pick(build, (part, 1), PickMark::Out, 0, ANN).await.unwrap(), None, "pressed twice");
    let first = ledger.mark_pick(build, (part, 1), PickMark::Out, 0, BEN).await.unwrap().unwrap();
    assert_eq!((first.told_by.as_str(), first.copy), (ANN, 1));
    ledger.mark_pick(build, (part, 0), PickMark::Bad, 0, BEN).await.unwrap();
    let both = vec![(1, PickMark::Out, ANN.to_owned()), (0, PickMark::Bad, BEN.to_owned())];
    assert_eq!(marks(&ledger, build).await, both);
    ledger.mark_pick(build, (part, 1), PickMark::Open, first.id, BEN).await.unwrap();
    assert_eq!(marks(&ledger, build).await, [(0, PickMark::Bad, BEN.to_owned())], "taken back");
    let latest = ledger.last_pick_id().await.unwrap();
    ledger.mark_pick(build, (part, 2), PickMark::Open, 0, ANN).await.unwrap();
    assert_eq!(ledger.last_pick_id().await.unwrap(), latest, "nothing was there to take back");
}

#[tokio::test]
async fn the_outcome_is_told_once_something_is_said_of_every_copy_and_exactly_the_lost_ones_wait_again() {
    let ledger = fresh().await;
    let (build, part) = printed(&ledger).await;
    ledger.mark_pick(build, (part, 0), PickMark::Bad, 0, ANN).await.unwrap();
    ledger.mark_pick(build, (part, 2), PickMark::Out, 0, ANN).await.unwrap();
    assert_eq!(ledger.finish_break_out(build, ANN).await.unwrap(), BreakOutAnswer::Open(1));
    assert_eq!(build_state(&ledger, build).await, BuildState::Published);
    ledger.mark_pick(build, (part, 1), PickMark::Missing, 0, BEN).await.unwrap();
    let BreakOutAnswer::Told(report) = ledger.finish_break_out(build, ANN).await.unwrap() else { panic!("not told") };
    assert_eq!(report.put_back_copies(), 2);
    assert_eq!(build_state(&ledger, build).await, BuildState::Complete);
    assert_eq!(part_state(&ledger, part).await, PartState::Waiting);
    let placed = ledger.placements_of_part(part).await.unwrap();
    let bad: Vec<_> = placed.iter().map(|row| (row.copy, row.is_bad)).collect();
    assert_eq!(bad, [(0, true), (1, true), (2, false)]);
    assert_eq!(ledger.outcomes_of_build(build).await.unwrap().len(), 1);
    let again = ledger.finish_break_out(build, BEN).await.unwrap();
    assert_eq!(again, BreakOutAnswer::Told(PutBackReport::default()), "told twice, nothing more happens");
    assert_eq!(ledger.outcomes_of_build(build).await.unwrap().len(), 1);
}

#[tokio::test]
async fn a_build_that_was_told_complete_before_keeps_what_was_told_and_adds_what_is_found() {
    let ledger = fresh().await;
    let (build, part) = printed(&ledger).await;
    let told = ToldOutcome { bad: vec![(part, 1)], ..ToldOutcome::new(PrintOutcome::Complete, "", "op@host") };
    ledger.record_outcome(build, &told).await.unwrap();
    assert!(
        ledger.mark_pick(build, (part, 2), PickMark::Bad, 0, ANN).await.is_err(),
        "told bad before: it counts no more"
    );
    ledger.mark_pick(build, (part, 0), PickMark::Out, 0, ANN).await.unwrap();
    ledger.mark_pick(build, (part, 1), PickMark::Bad, 0, ANN).await.unwrap();
    let BreakOutAnswer::Told(report) = ledger.finish_break_out(build, ANN).await.unwrap() else { panic!("not told") };
    assert_eq!((report.put_back_copies(), report.returned.len()), (1, 0));
    let bad = ledger.placements_of_part(part).await.unwrap().iter().filter(|row| row.is_bad).count();
    assert_eq!((bad, build_state(&ledger, build).await), (2, BuildState::Complete));
    assert!(ledger.outcomes_of_build(build).await.unwrap()[1].is_correction);
}

#[tokio::test]
async fn nothing_is_said_of_a_build_that_is_not_published_or_of_a_copy_that_is_not_in_it() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let build = nesting(&ledger, &[(part, 0), (part, 1)]).await;
    assert!(ledger.mark_pick(build, (part, 0), PickMark::Out, 0, ANN).await.is_err());
    assert_eq!(ledger.finish_break_out(build, ANN).await.unwrap(), BreakOutAnswer::Open(2));
    let (other, mine) = {
        let part = waiting(&ledger, "b", 1).await;
        (published(&ledger, &[(part, 0)]).await, part)
    };
    assert!(ledger.mark_pick(other, (part, 0), PickMark::Out, 0, ANN).await.is_err());
    assert!(ledger.mark_pick(other, (mine, 7), PickMark::Out, 0, ANN).await.is_err());
}

#[tokio::test]
async fn who_did_not_see_what_another_said_overwrites_nothing() {
    let ledger = fresh().await;
    let (build, part) = printed(&ledger).await;
    assert_eq!(ledger.mark_pick(build, (part, 0), PickMark::Bad, 0, ANN).await.unwrap(), None);
    let stale = ledger.mark_pick(build, (part, 0), PickMark::Out, 0, BEN).await.unwrap().unwrap();
    assert_eq!((stale.mark, stale.told_by.as_str()), (PickMark::Bad, ANN));
    let undo = ledger.mark_pick(build, (part, 0), PickMark::Open, stale.id + 1, BEN).await.unwrap().unwrap();
    assert_eq!(undo, stale, "nor is it taken back unseen");
    let known = ledger.mark_picks(build, &[(part, 0), (part, 1)], PickMark::Out, BEN).await.unwrap();
    assert_eq!(known, std::slice::from_ref(&stale), "of that copy something was said before");
    let said = vec![(0, PickMark::Bad, ANN.to_owned()), (1, PickMark::Out, BEN.to_owned())];
    assert_eq!(marks(&ledger, build).await, said, "what is said of the rest is not said of it");
    assert_eq!(ledger.mark_pick(build, (part, 0), PickMark::Out, stale.id, BEN).await.unwrap(), None, "it was shown");
    assert!(marks(&ledger, build).await.contains(&(0, PickMark::Out, BEN.to_owned())));
}

#[tokio::test]
async fn what_was_said_of_several_copies_at_once_is_taken_back_at_once_but_for_what_was_said_since() {
    let ledger = fresh().await;
    let (build, part) = printed(&ledger).await;
    let tray = [(part, 0), (part, 1), (part, 2)];
    ledger.mark_picks(build, &tray, PickMark::Out, ANN).await.unwrap();
    let rows = ledger.picks_of_build(build).await.unwrap();
    let ids = rows[0].id..=rows[2].id;
    ledger.mark_pick(build, (part, 1), PickMark::Bad, rows[1].id, BEN).await.unwrap();
    assert_eq!(ledger.undo_picks(build, ids.clone(), ANN).await.unwrap(), 2);
    assert_eq!(marks(&ledger, build).await, [(1, PickMark::Bad, BEN.to_owned())]);
    assert_eq!(ledger.undo_picks(build, ids, ANN).await.unwrap(), 0, "pressed twice");
}

#[tokio::test]
async fn a_mark_of_a_copy_that_was_told_bad_is_not_taken_back() {
    let ledger = fresh().await;
    let (build, part) = printed(&ledger).await;
    ledger.mark_picks(build, &[(part, 0), (part, 1), (part, 2)], PickMark::Missing, ANN).await.unwrap();
    let rows = ledger.picks_of_build(build).await.unwrap();
    ledger.finish_break_out(build, ANN).await.unwrap();
    assert_eq!(ledger.undo_picks(build, rows[0].id..=rows[2].id, ANN).await.unwrap(), 0);
}

async fn finished(ledger: &Ledger, part: PartId) -> Vec<(String, Option<String>)> {
    let part = ledger.find_part(part).await.unwrap().unwrap();
    let steps = ledger.finishing_of_part(&part).await.unwrap().steps;
    steps.into_iter().map(|step| (step.step, step.done_by)).collect()
}

#[tokio::test]
async fn a_step_is_told_done_once_printed_taken_back_and_stays_with_who_said_it_first() {
    let ledger = fresh().await;
    let asked = asked(new_part("a", 1), |terms| {
        (terms.order_name, terms.finish) = ("K-1".to_owned(), "dye black, smooth".to_owned())
    });
    let part = ledger.record_claim(&asked).await.unwrap().id;
    ledger.accept_solids(part, &[solid(0, 1)]).await.unwrap();
    let early = ledger.tell_finished(part, "smooth", true, "ann@farm").await.unwrap_err();
    assert!(early.to_string().contains("no copy of part 1 is printed"), "{early}");
    let build = published(&ledger, &[(part, 0)]).await;
    assert!(ledger.tell_finished(part, "smooth", true, "ann@farm").await.is_err(), "its file lies in the queue");
    ledger.record_outcome(build, &ToldOutcome::new(PrintOutcome::Complete, "", ANN)).await.unwrap();
    assert!(ledger.tell_finished(part, "smooth", true, "ann@farm").await.unwrap());
    assert!(!ledger.tell_finished(part, "smooth", true, "bob@farm").await.unwrap(), "it was said");
    let wrong = ledger.tell_finished(part, "polish", true, "bob@farm").await.unwrap_err();
    assert!(wrong.to_string().contains("no finishing step 'polish', only dye black, smooth"), "{wrong}");
    let steps = [("dye black".to_owned(), None), ("smooth".to_owned(), Some("ann@farm".to_owned()))];
    assert_eq!(finished(&ledger, part).await, steps);
    assert_eq!(ledger.finishing_of_order("K-1").await.unwrap().len(), 1);
    assert!(ledger.tell_finished(part, "smooth", false, "bob@farm").await.unwrap());
    assert!(finished(&ledger, part).await.iter().all(|(_, by)| by.is_none()));
    let edit = PartEdit { finish: Some("polish; none".to_owned()), ..PartEdit::default() };
    let edited = ledger.edit_part(part, &edit, "ann@farm").await.unwrap();
    assert_eq!(edited.changes, ["finish polish instead of dye black, smooth"]);
    assert_eq!(finished(&ledger, part).await, [("polish".to_owned(), None)]);
    ledger.tell_finished(part, "polish", true, "ann@farm").await.unwrap();
    let other = PartEdit { finish: Some("dye".to_owned()), ..PartEdit::default() };
    ledger.edit_part(part, &other, "ann@farm").await.unwrap();
    ledger.edit_part(part, &edit, "ann@farm").await.unwrap();
    assert_eq!(finished(&ledger, part).await, [("polish".to_owned(), None)], "it was asked for anew");
    ledger.tell_finished(part, "polish", true, "ann@farm").await.unwrap();
    ledger.edit_part(part, &PartEdit { copies: Some(3), ..PartEdit::default() }, "ann@farm").await.unwrap();
    assert_eq!(finished(&ledger, part).await, [("polish".to_owned(), None)], "two copies more are not polished");
    let events = ledger.events_of_part(part).await.unwrap();
    let told: Vec<&str> =
        events.iter().filter(|event| event.kind == EventKind::Finishing).map(|event| event.detail.as_str()).collect();
    assert_eq!(told[..2], ["ann@farm: smooth is done", "bob@farm: smooth is not done"]);
    assert_eq!(told.last(), Some(&"more copies are made: its finishing steps are open again"));
}

#[test]
fn steps_are_read_as_people_write_them() {
    for (text, steps) in [
        ("dye black;Smooth , dye Black", "dye black, Smooth"),
        ("染色、研磨", "染色, 研磨"),
        ("roh", ""),
        (" - ", ""),
        ("Strahlen Ra 3,2; sans", "Strahlen Ra 3,2"),
        ("", ""),
    ] {
        assert_eq!(build_file::check_finish(text).unwrap(), steps, "{text}");
    }
    let many: Vec<String> = (0..13).map(|step| format!("step {step}")).collect();
    assert!(build_file::check_finish(&many.join(",")).unwrap_err().contains("at most 12"));
}
