//! What can be sent to a customer about an order, in plain text.

use jiff::{Timestamp, Zoned};
use language::say;
use ledger::UtcTimestamp;
use settings::FarmZone;

use super::order_fact::{DatedOrder, OrderWord};

/// How an order stands, as its customer wants to know it: `Your order A-17: 40 of 48 parts are printed, the rest is expected Friday 4
/// December.`
pub fn customer_note(dated: &DatedOrder, zone: &FarmZone, now: Timestamp) -> String {
    let (order, copies, fact) = (&dated.order.order, &dated.order.copies, &dated.fact);
    let day =
        |at: UtcTimestamp| day_text(&at.0.to_zoned(zone.time_zone().clone()), &now.to_zoned(zone.time_zone().clone()));
    let (name, printed) = (&order.name, copies.good + copies.printed);
    let refused = (copies.refused > 0).then(|| say!("note-refused", parts = copies.refused));
    let and_refused = |how: String| match &refused {
        Some(refused) => say!("note-and-refused", how = how, refused = refused),
        None => how,
    };
    let of = match (printed, copies.wanted) {
        // Nobody told that.
        (1, 1) if copies.printed > 0 => say!("note-one-should"),
        (printed, parts) if copies.printed > 0 && printed == parts => say!("note-all-should", parts = parts),
        (_, parts) if copies.printed > 0 => say!("note-some-should", printed = printed, parts = parts),
        (0, 1) => say!("note-one-not-printed"),
        (0, parts) => say!("note-none-printed", parts = parts),
        (1, 1) => say!("note-one-printed"),
        (printed, parts) if printed == parts => say!("note-all-printed", parts = parts),
        (_, parts) => {
            say!("note-some-printed", printed = printed, parts = parts)
        }
    };
    match fact.word {
        OrderWord::Done => say!("note-complete", order = name, printed = of),
        OrderWord::Closed => {
            // A print may be told good after all since then.
            let accepted = order.closing.accepted_copies.unwrap_or(0).max(copies.good);
            let all = order.closing.closed_of.unwrap_or(copies.wanted);
            match accepted {
                0 => say!("note-cancelled", order = name),
                _ => say!("note-closed", order = name, accepted = accepted, parts = all),
            }
        }
        OrderWord::Short if copies.under_way() == 0 => say!("note-order", order = name, how = and_refused(of)),
        _ => {
            let expected = match (fact.done_at, printed) {
                _ if printed + copies.refused >= copies.wanted => None,
                (Some(at), 0) if copies.refused == 0 => Some(say!("note-all-expected", day = day(at))),
                (Some(at), _) => Some(say!("note-rest-expected", day = day(at))),
                (None, 0) if copies.waiting == 0 => Some(say!("note-all-made")),
                (None, _) if copies.waiting == 0 => Some(say!("note-rest-made")),
                (None, 0) => Some(say!("note-all-not-known")),
                (None, _) => Some(say!("note-rest-not-known")),
            };
            let how = match expected {
                Some(expected) => say!("note-and-expected", how = of, expected = expected),
                None => of,
            };
            let note = say!("note-order", order = name, how = and_refused(how));
            match fact.missed_at {
                // Later on the day that it was promised for is not late for whoever reads of days.
                Some(due) if fact.done_at.is_some_and(|at| day(at) == day(due)) => note,
                Some(due) if fact.lateness().is_some() || due.0 <= now => {
                    say!("note-then-sorry", note = note, sorry = say!("note-sorry", day = day(due)))
                }
                _ => note,
            }
        }
    }
}

/// `Friday 4 December`, with the year where it is another one.
fn day_text(at: &Zoned, now: &Zoned) -> String {
    let year = (at.year() != now.year()).then_some(at.year());
    language::long_day_text(at.weekday().to_monday_one_offset(), at.day(), at.month(), year)
}
