//! The parts that a command means: numbers, names of orders and of files, patterns with `*` and `?`; `5=2` = two copies
//! of part 5, `order:1042` = the order 1042, whose name is a number.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use ledger::{Ledger, PartId, PartRow};

use super::values::parse_prefixed_number;
use crate::cli::UsageError;

/// So many orders of one file name are listed, each with the command that means it.
const MOST_ORDERS_LISTED: usize = 12;

/// A part that a command means.
#[derive(Debug, Clone, PartialEq)]
pub struct PartTarget {
    /// Its row.
    pub part: PartRow,
    /// Number of its copies; `None` = all.
    pub copies: Option<u32>,
}

/// Finds the parts that the words mean, each once, in the order of the words. A word that means nothing is an error, and so is the name of
/// a file that stands in several orders: then `command` says for the error what names one of them.
pub async fn find_targets(
    ledger: &Ledger,
    words: &[String],
    command: impl Fn(&str) -> String,
) -> Result<Vec<PartTarget>> {
    let mut found: Vec<PartTarget> = Vec::new();
    for word in words {
        let (what, copies) = split_copies(word);
        let parts = find_parts(ledger, what).await?;
        if parts.is_empty() {
            return Err(UsageError(format!(
                "there is no part, order or file '{what}'; `nestd show {what}` and `nestd orders --find TEXT` help to find it"
            ))
            .into());
        }
        if let Some(text) = several_orders_text(what, &parts, copies, &command) {
            return Err(UsageError(text).into());
        }
        if copies.is_some() && parts.len() > 1 {
            let text =
                format!("'{what}' means {} parts, so {word} is not clear: name one part by its number", parts.len());
            return Err(UsageError(text).into());
        }
        for part in parts {
            if !found.iter().any(|known| known.part.id == part.id) {
                found.push(PartTarget { part, copies });
            }
        }
    }
    Ok(found)
}

/// `5=2` -> `5` and 2.
fn split_copies(word: &str) -> (&str, Option<u32>) {
    let parts = word.rsplit_once('=').and_then(|(what, copies)| Some((what, copies.parse().ok().filter(|n| *n > 0)?)));
    parts.map_or((word, None), |(what, copies)| (what, Some(copies)))
}

/// The parts that one word means: a number, else an order, else a file name; patterns match orders and names of parts
/// that are not built.
async fn find_parts(ledger: &Ledger, word: &str) -> Result<Vec<PartRow>> {
    if let Some(order) = word.strip_prefix("order:") {
        return Ok(ledger.parts_of_order(order).await?);
    }
    if let Some(number) = parse_prefixed_number(word, 'p') {
        return Ok(ledger.find_part(PartId(number)).await?.into_iter().collect());
    }
    if word.contains(['*', '?']) {
        return Ok(ledger.unbuilt_parts_matching(word).await?);
    }
    let of_order = ledger.parts_of_order(word).await?;
    Ok(if of_order.is_empty() { of_open_orders(ledger.parts_named(word).await?) } else { of_order })
}

/// Of parts of one name, those of the orders in which one of them is not built yet; all, if there is none.
fn of_open_orders(mut parts: Vec<PartRow>) -> Vec<PartRow> {
    let live = parts.iter().filter(|part| part.state.is_live());
    let open: BTreeSet<String> = live.map(|part| part.terms.order_name.clone()).collect();
    parts.retain(|part| open.is_empty() || open.contains(&part.terms.order_name));
    parts
}

/// What is said where the parts of one file name stand in several orders; `None` = they do not.
fn several_orders_text(
    name: &str,
    parts: &[PartRow],
    copies: Option<u32>,
    command: &impl Fn(&str) -> String,
) -> Option<String> {
    let mut orders: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for part in parts.iter().filter(|part| part.name == name) {
        let copies = copies.map(|copies| format!("={copies}")).unwrap_or_default();
        orders.entry(&part.terms.order_name).or_default().push(format!("p{}{copies}", part.id));
    }
    if orders.len() < 2 {
        return None;
    }
    let mut text = format!("'{name}' stands in {} orders: say which one is meant", orders.len());
    for (order, parts) in orders.iter().take(MOST_ORDERS_LISTED) {
        let order = if order.is_empty() { "without an order".to_owned() } else { format!("order {order}") };
        text += &format!("\n  {order}: {}", command(&parts.join(" ")));
    }
    let more = orders.len().saturating_sub(MOST_ORDERS_LISTED);
    if more > 0 {
        text += &format!("\n  and {more} more: nestd show '{name}'");
    } else {
        let all: Vec<String> = orders.into_values().flatten().collect();
        text += &format!("\n  all of them: {}", command(&all.join(" ")));
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use ledger_fixtures::*;

    use super::*;

    #[tokio::test]
    async fn a_file_name_of_several_open_orders_is_refused_with_the_command_for_each() {
        let ledger = fresh().await;
        for (claim, order) in [("a", "A-1"), ("b", "A-2"), ("c", "A-2"), ("d", "")] {
            let mut part = asked(new_part(claim, 2), |terms| order.clone_into(&mut terms.order_name));
            "fan.stl".clone_into(&mut part.name);
            let id = ledger.record_claim(&part).await.unwrap().id;
            ledger.accept_solids(id, &[solid(0, 2)]).await.unwrap();
        }
        let find = async |word: &str| {
            let found = find_targets(&ledger, &[word.to_owned()], |parts| format!("nestd cancel {parts}")).await;
            found
                .map(|found| found.iter().map(|target| target.part.id.0).collect::<Vec<_>>())
                .map_err(|e| e.to_string())
        };
        let refused = find("fan.stl").await.unwrap_err();
        for expected in [
            "'fan.stl' stands in 3 orders: say which one is meant\n",
            "  order A-1: nestd cancel p1\n",
            "  order A-2: nestd cancel p2 p3\n",
            "  without an order: nestd cancel p4\n",
            "  all of them: nestd cancel p4 p1 p2 p3",
        ] {
            assert!(refused.contains(expected), "{expected:?} is missing in {refused}");
        }
        assert!(find("fan.stl=1").await.unwrap_err().contains("nestd cancel p1=1\n"));
        assert_eq!((find("A-2").await, find("fan*").await), (Ok(vec![2, 3]), Ok(vec![1, 2, 3, 4])), "as was said");
        // What is built of an earlier order is not meant.
        published(&ledger, &[(PartId(1), 0), (PartId(1), 1), (PartId(4), 0), (PartId(4), 1)]).await;
        assert_eq!(find("fan.stl").await, Ok(vec![2, 3]));
    }

    #[test]
    fn a_number_of_copies_may_follow_a_part() {
        assert_eq!(split_copies("5=2"), ("5", Some(2)));
        assert_eq!(split_copies("p5"), ("p5", None));
        assert_eq!(split_copies("a=b.stl"), ("a=b.stl", None));
        assert_eq!(split_copies("5=0"), ("5=0", None));
    }
}
