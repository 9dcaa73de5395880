//! What can be sent to a customer about an order, in plain text.

use build_file::format_count;
use jiff::{Timestamp, Zoned};
use ledger::UtcTimestamp;

use super::order_fact::{DatedOrder, OrderWord};
use crate::settings::FarmZone;

/// How an order stands, as its customer wants to know it: `Your order A-17: 40 of 48 parts are printed, the rest is expected Friday 4
/// December.`
pub fn customer_note(dated: &DatedOrder, zone: &FarmZone, now: Timestamp) -> String {
    let (order, copies, fact) = (&dated.order.order, &dated.order.copies, &dated.fact);
    let day =
        |at: UtcTimestamp| day_text(&at.0.to_zoned(zone.time_zone().clone()), &now.to_zoned(zone.time_zone().clone()));
    let your = format!("Your order {}", order.name);
    let (printed, parts) = (copies.good + copies.printed, format_count(copies.wanted, "part", "parts"));
    let refused = match copies.refused {
        0 => String::new(),
        1 => "; 1 part is not made".to_owned(),
        several => format!("; {several} parts are not made"),
    };
    let of = match (printed, copies.wanted) {
        (0, 1) => "it is not printed yet".to_owned(),
        (0, _) => format!("none of the {parts} is printed yet"),
        (1, 1) => "it is printed".to_owned(),
        (printed, wanted) if printed == wanted => format!("all {parts} are printed"),
        (1, _) => format!("1 of {parts} is printed"),
        _ => format!("{printed} of {parts} are printed"),
    };
    match fact.word {
        OrderWord::Done => format!("{your} is complete: {of}."),
        OrderWord::Closed => {
            let accepted = order.closing.accepted_copies.unwrap_or(copies.good);
            let of = order.closing.closed_of.unwrap_or(copies.wanted);
            format!("{your} is complete with {accepted} of {}.", format_count(of, "part", "parts"))
        }
        OrderWord::Short if copies.under_way() == 0 => format!("{your}: {of}{refused}."),
        _ => {
            let rest = if printed == 0 { "all of it" } else { "the rest" };
            let expected = match fact.done_at {
                _ if printed + copies.refused >= copies.wanted => String::new(),
                Some(at) => format!(", {rest} is expected {}", day(at)),
                None => format!(", {rest} is in production"),
            };
            let sorry = match fact.missed_at {
                Some(due) if fact.lateness().is_some() || due.0 <= now => {
                    format!(" We are sorry: it was due {}.", day(due))
                }
                _ => String::new(),
            };
            format!("{your}: {of}{expected}{refused}.{sorry}")
        }
    }
}

/// `Friday 4 December`, with the year where it is another one.
fn day_text(at: &Zoned, now: &Zoned) -> String {
    let format = if at.year() == now.year() { "%A %-d %B" } else { "%A %-d %B %Y" };
    at.strftime(format).to_string()
}
