//! Who goes first, rule by rule.

use crate::{UtcTimestamp, compare_precedence, tests::*};
use std::cmp::Ordering;

/// A waiting copy, and whether it stands in the open build.
type StandingCopy = (PartRow, bool);

/// A rule, what it says of the copy that goes first, and of the other one.
type Rule = (&'static str, fn(&mut StandingCopy), fn(&mut StandingCopy));

fn second(second: i64) -> UtcTimestamp {
    UtcTimestamp(Timestamp::from_second(second).unwrap())
}

/// The rules, the strongest first.
const RULES: [Rule; 8] = [
    (
        "copies that are printed again",
        |copy| copy.0.owed.put_back_at = Some(second(9)),
        |copy| copy.0.owed.put_back_at = None,
    ),
    (
        "of those the earliest put back",
        |copy| copy.0.owed.put_back_at = Some(second(8)),
        |copy| copy.0.owed.put_back_at = Some(second(9)),
    ),
    ("the higher priority", |copy| copy.0.terms.priority = 51, |copy| copy.0.terms.priority = 50),
    ("a part with a due date", |copy| copy.0.terms.due_at = Some(second(9)), |copy| copy.0.terms.due_at = None),
    (
        "the earlier due date",
        |copy| copy.0.terms.due_at = Some(second(8)),
        |copy| copy.0.terms.due_at = Some(second(9)),
    ),
    ("a copy that stands in the open build", |copy| copy.1 = true, |copy| copy.1 = false),
    ("the older part", |copy| copy.0.times.claimed_at = second(1), |copy| copy.0.times.claimed_at = second(2)),
    ("the lower number", |copy| copy.0.id = PartId(1), |copy| copy.0.id = PartId(2)),
];

/// Each rule decides against all weaker ones, whichever copy is asked first.
#[tokio::test]
async fn each_rule_of_precedence_outweighs_all_that_come_after_it() {
    let ledger = fresh().await;
    ledger.record_claim(&new_part("a", 1)).await.unwrap();
    let row = ledger.parts_in_state(PartState::Claimed).await.unwrap().remove(0);
    for (at, (what, first, other)) in RULES.iter().enumerate() {
        let (mut winner, mut loser) = ((row.clone(), false), (row.clone(), false));
        for (_, favoured, disfavoured) in RULES[at + 1..].iter().rev() {
            favoured(&mut loser);
            disfavoured(&mut winner);
        }
        first(&mut winner);
        other(&mut loser);
        let compare = |one: &StandingCopy, two: &StandingCopy| compare_precedence((&one.0, one.1), (&two.0, two.1));
        assert_eq!(compare(&winner, &loser), Ordering::Less, "{what} goes first");
        assert_eq!(compare(&loser, &winner), Ordering::Greater, "{what} goes first");
    }
}
