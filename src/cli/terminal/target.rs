//! The parts that a command means: numbers, names of orders and of files, patterns with `*` and `?`; `5=2` = two copies
//! of part 5, `order:1042` = the order 1042, whose name is a number.

use anyhow::Result;
use ledger::{Ledger, PartId, PartRow};

use super::values::parse_prefixed_number;
use crate::cli::UsageError;

/// A part that a command means.
#[derive(Debug, Clone, PartialEq)]
pub struct PartTarget {
    /// Its row.
    pub part: PartRow,
    /// Number of its copies; `None` = all.
    pub copies: Option<u32>,
}

/// Finds the parts that the words mean, each once, in the order of the words. A word that means nothing is an error.
pub async fn find_targets(ledger: &Ledger, words: &[String]) -> Result<Vec<PartTarget>> {
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
    Ok(if of_order.is_empty() { ledger.parts_named(word).await? } else { of_order })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_copies_may_follow_a_part() {
        assert_eq!(split_copies("5=2"), ("5", Some(2)));
        assert_eq!(split_copies("p5"), ("p5", None));
        assert_eq!(split_copies("a=b.stl"), ("a=b.stl", None));
        assert_eq!(split_copies("5=0"), ("5=0", None));
    }
}
