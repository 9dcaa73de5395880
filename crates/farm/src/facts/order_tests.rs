use ledger::{LineCopies, OrderRow, OrderState, OrderSummary, PartId};

use super::{
    customer_note::customer_note,
    fact_tests::at,
    order_fact::{DatedOrder, OrderFact, OrderWord, delay_text, order_fact},
};
use crate::planning::{DateRisk, DatesKept, MachinePlan, PlanStage, PlannedBuild, PlannedPart, RiskCause};

/// A plan of builds, each with copies of the order A-7 and the hour of its end.
fn plan(builds: &[(u32, Option<f64>)], risks: Vec<DateRisk>) -> MachinePlan {
    let build = |&(copies, ends): &(u32, Option<f64>)| PlannedBuild {
        build: None,
        stage: PlanStage::Later,
        printer: None,
        copies: copies + 1,
        height_mm: 10.0,
        is_nested: false,
        fires_at: None,
        fires_by: None,
        begins_at: None,
        printed_at: None,
        dates: DatesKept::NoDate,
        ends_at: ends.map(|hour| at(hour).into()),
        awaits_release: false,
        parts: [("A-7", copies), ("B-1", 1)]
            .map(|(order, copies)| PlannedPart {
                part: PartId(1),
                name: "a.stl".to_owned(),
                order: order.to_owned(),
                copies,
                due_at: None,
            })
            .to_vec(),
    };
    MachinePlan {
        machine: "m".to_owned(),
        planned_at: at(0.0).into(),
        hindered: None,
        builds: builds.iter().map(build).collect(),
        risks,
        unplanned_parts: 0,
        heights_learned_from: 0,
    }
}

#[test]
fn an_order_is_done_when_the_last_of_its_copies_is_and_late_where_the_plan_says_so() {
    let copies = LineCopies { wanted: 6, waiting: 3, in_builds: 1, queued: 1, good: 1, ..LineCopies::default() };
    let order = OrderSummary {
        order: OrderRow::arriving("A-7"),
        lines: 1,
        lines_without_number: 0,
        due_at: Some(at(20.0).into()),
        due_text: String::new(),
        copies,
    };
    let done = |plans: &[MachinePlan]| order_fact(&order, plans, at(1.0)).done_at;
    assert_eq!(done(&[plan(&[(2, Some(10.0))], vec![]), plan(&[(3, Some(30.0))], vec![])]), Some(at(30.0).into()));
    assert_eq!(done(&[plan(&[(4, Some(10.0))], vec![])]), None, "one copy is in no plan");
    assert_eq!(done(&[plan(&[(4, Some(10.0)), (1, None)], vec![])]), None, "the end of one is not known");
    let risk = |order: &str, is_late: bool| DateRisk {
        machine: "m".to_owned(),
        order: order.to_owned(),
        parts: vec!["a.stl".to_owned()],
        numbers: vec![PartId(1)],
        due_at: at(20.0).into(),
        due_text: String::new(),
        done_at: Some(at(30.0).into()),
        is_late,
        cause: RiskCause::TooLong,
        until: None,
        reason: "its print takes too long for that".to_owned(),
    };
    let fact = |risks: Vec<DateRisk>| order_fact(&order, &[plan(&[(5, Some(30.0))], risks)], at(1.0));
    assert_eq!(fact(vec![risk("B-1", true)]).word, OrderWord::OnTime, "that is another one");
    assert_eq!(fact(vec![risk("A-7", false)]).word, OrderWord::Tight);
    let late = fact(vec![risk("A-7", false), risk("A-7", true)]);
    let expected = OrderFact {
        word: OrderWord::Late,
        done_at: Some(at(30.0).into()),
        is_estimated: true,
        is_late: true,
        is_at_risk: true,
        missed_at: Some(at(20.0).into()),
        risk_reason: "its print takes too long for that".to_owned(),
        risk_cause: Some(RiskCause::TooLong),
    };
    assert_eq!((late.lateness().map(delay_text).as_deref(), &late), (Some("10 h"), &expected));
    let overdue = order_fact(&order, &[plan(&[(5, Some(30.0))], vec![])], at(21.0));
    assert_eq!((overdue.word, overdue.missed_at, overdue.is_late), (OrderWord::Overdue, Some(at(20.0).into()), true));
    let zone = jiff::tz::TimeZone::UTC.into();
    assert_eq!(
        risk("A-7", true).in_words(&zone, at(0.0)),
        "due 2026-11-25 20:00 UTC, late, done about tomorrow 06:00: its print takes too long for that"
    );
}

/// An order of these copies that is due at 20:00, as it stands at 01:00.
fn dated(state: OrderState, copies: LineCopies, plans: &[MachinePlan]) -> DatedOrder {
    let order = OrderRow { state, state_at: at(0.0).into(), ..OrderRow::arriving("A-7") };
    let due_text = String::new();
    DatedOrder::of_plans(
        OrderSummary { order, lines: 1, lines_without_number: 0, due_at: Some(at(20.0).into()), due_text, copies },
        plans,
        at(1.0),
    )
}

#[test]
fn an_order_that_is_in_time_and_cannot_be_whole_asks_for_a_person() {
    let copies = LineCopies { wanted: 3, waiting: 2, refused: 1, ..LineCopies::default() };
    assert_eq!(dated(OrderState::Open, copies, &[]).fact.word, OrderWord::Short);
    let whole = LineCopies { waiting: 3, refused: 0, ..copies };
    let known = [plan(&[(3, Some(19.0))], vec![])];
    assert_eq!(dated(OrderState::Open, whole, &known).fact.word, OrderWord::OnTime);
    assert_eq!(dated(OrderState::Open, whole, &[]).fact.word, OrderWord::UnderWay, "nobody knows when it is done");
}

#[test]
fn copies_lie_in_a_queue_are_printed_or_are_over_as_the_plan_says_and_else_as_the_ledger_saw() {
    let known = LineCopies { wanted: 12, queued: 5, printing: 6, good: 1, ..LineCopies::default() };
    let staged = |stages: &[(u32, PlanStage)]| {
        let builds: Vec<_> = stages.iter().map(|(copies, _)| (*copies, Some(9.0))).collect();
        let mut plan = plan(&builds, vec![]);
        plan.builds.iter_mut().zip(stages).for_each(|(build, (_, stage))| build.stage = *stage);
        dated(OrderState::Open, known, &[plan]).order.copies
    };
    let counts = |copies: LineCopies| (copies.queued, copies.printing, copies.printed, copies.good, copies.wanted);
    assert_eq!(counts(staged(&[])), (5, 6, 0, 1, 12), "a machine without a plan");
    let all = staged(&[
        (2, PlanStage::Ended),
        (1, PlanStage::Cooling),
        (2, PlanStage::Printing),
        (1, PlanStage::Taken),
        (5, PlanStage::Queued),
    ]);
    assert_eq!(counts(all), (5, 3, 3, 1, 12));
    // The ledger changed between the two: no copy is counted twice, and none is lost.
    let torn = staged(&[(9, PlanStage::Ended), (9, PlanStage::Queued)]);
    assert_eq!(counts(torn), (2, 0, 9, 1, 12));
    assert_eq!(counts(staged(&[(4, PlanStage::Queued)])), (5, 6, 0, 1, 12), "one more of a machine without a plan");
}

#[test]
fn a_customer_is_told_how_much_is_printed_and_when_the_rest_is_expected() {
    let note = |state: OrderState, copies: LineCopies, ends: Option<f64>| {
        let under_way = copies.under_way();
        let plans = [plan(&ends.map(|ends| (under_way, Some(ends))).into_iter().collect::<Vec<_>>(), vec![])];
        customer_note(&dated(state, copies, &plans), &jiff::tz::TimeZone::UTC.into(), at(1.0))
    };
    let some = LineCopies { wanted: 48, good: 40, waiting: 8, ..LineCopies::default() };
    assert_eq!(
        note(OrderState::Open, some, Some(19.0)),
        "Your order A-7: 40 of 48 parts are printed, the rest is expected Wednesday 25 November."
    );
    assert_eq!(
        note(OrderState::Open, some, None),
        "Your order A-7: 40 of 48 parts are printed, a date for the rest is not known yet."
    );
    let made = LineCopies { waiting: 0, in_builds: 8, ..some };
    assert_eq!(
        note(OrderState::Open, made, None),
        "Your order A-7: 40 of 48 parts are printed, the rest is in production."
    );
    let none = LineCopies { wanted: 3, waiting: 2, refused: 1, ..LineCopies::default() };
    assert_eq!(
        note(OrderState::Open, none, Some(60.0)),
        "Your order A-7: none of the 3 parts is printed yet, the rest is expected Friday 27 November; 1 part is not made."
    );
    let untold = LineCopies { printed: 4, waiting: 4, ..some };
    assert_eq!(
        note(OrderState::Open, untold, Some(60.0)),
        "Your order A-7: 44 of 48 parts should be printed by now, the rest is expected Friday 27 November."
    );
    let all = LineCopies { wanted: 2, good: 2, ..LineCopies::default() };
    assert_eq!(note(OrderState::Complete, all, None), "Your order A-7 is complete: all 2 parts are printed.");
    let short = LineCopies { wanted: 2, good: 1, refused: 1, ..LineCopies::default() };
    assert_eq!(note(OrderState::Short, short, None), "Your order A-7: 1 of 2 parts is printed; 1 part is not made.");
    let mut closed = dated(OrderState::Complete, all, &[]);
    closed.order.order.closing.accepted_copies = Some(2);
    closed.order.order.closing.closed_of = Some(5);
    closed.fact.word = OrderWord::Closed;
    assert_eq!(
        customer_note(&closed, &jiff::tz::TimeZone::UTC.into(), at(1.0)),
        "Your order A-7 is complete with 2 of 5 parts."
    );
    closed.order.order.closing.accepted_copies = Some(0);
    assert!(
        customer_note(&closed, &jiff::tz::TimeZone::UTC.into(), at(1.0)).contains("with 2 of 5"),
        "told good since"
    );
    closed.order.copies = LineCopies::default();
    assert_eq!(customer_note(&closed, &jiff::tz::TimeZone::UTC.into(), at(1.0)), "Your order A-7 was cancelled.");
    let mut late = dated(OrderState::Open, some, &[plan(&[(8, Some(60.0))], vec![])]);
    late.fact.missed_at = Some(at(20.0).into());
    assert_eq!(
        customer_note(&late, &jiff::tz::TimeZone::UTC.into(), at(1.0)),
        "Your order A-7: 40 of 48 parts are printed, the rest is expected Friday 27 November. We are sorry: it was due Wednesday 25 November."
    );
}
