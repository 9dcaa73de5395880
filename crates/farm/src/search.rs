//! Finds orders, parts, customers, builds and machines by part of a name, or by number, for people.

use std::collections::{BTreeMap, BTreeSet};

use intake::fold_name;
use language::{Language, say};
use ledger::{BuildId, Ledger, LedgerError, NamePattern, NamedBuildRow, NamedPartRow, OrderRow, PartId};

/// Rows of a kind that are counted; beyond them a search only says that there are more.
pub const MAX_COUNTED: usize = 1000;
/// Longest text that is searched for, characters.
const MAX_TEXT: usize = 200;

/// The first rows of a kind, and how many there are.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundRows<T> {
    /// The first rows.
    pub rows: Vec<T>,
    /// How many there are, up to `MAX_COUNTED`.
    pub total: usize,
}

/// A customer of parts that were found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundCustomer {
    /// The name, as a list gave it.
    pub name: String,
    /// The orders of these parts; parts without one do not count.
    pub orders: BTreeSet<String>,
    /// Number of these parts.
    pub parts: usize,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundNames {
    /// Machines of the configuration.
    pub machines: FoundRows<String>,
    /// Orders, open ones first, newest first.
    pub orders: FoundRows<OrderRow>,
    /// Customers, by name.
    pub customers: FoundRows<FoundCustomer>,
    /// Builds, newest first; the one with that number comes first.
    pub builds: FoundRows<NamedBuildRow>,
    /// Parts, newest first; the one with that number comes first.
    pub parts: FoundRows<NamedPartRow>,
}

impl<T> FoundRows<T> {
    fn new() -> Self {
        Self { rows: Vec::new(), total: 0 }
    }

    /// Counts a row, and keeps it if it is one of the first `most`. Returns whether more are counted.
    fn count_row(&mut self, row: T, most: usize) -> bool {
        self.total += 1;
        if self.rows.len() < most {
            self.rows.push(row);
        }
        self.total < MAX_COUNTED
    }

    /// Whether there may be more rows than are counted.
    pub fn is_cut(&self) -> bool {
        self.total >= MAX_COUNTED
    }
}

impl FoundNames {
    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        let totals =
            [self.machines.total, self.orders.total, self.customers.total, self.builds.total, self.parts.total];
        totals.iter().all(|total| *total == 0)
    }
}

/// What a person searches for: words that a name must contain, all of them, without regard to case.
#[derive(Debug, Clone, PartialEq, Eq)]
struct SearchWords(Vec<String>);

impl SearchWords {
    fn of_text(text: &str) -> Self {
        let text: String = text.chars().filter(|letter| *letter != '\0').take(MAX_TEXT).collect();
        Self(fold_name(&text).split_whitespace().map(str::to_owned).collect())
    }

    /// The words without the one that names the kind of what is searched: 'build 1182', 'Auftrag Acme', 'ビルド3'. `kinds` says such words
    /// in the language that is current; those of all languages are known.
    fn without_kind(&self, kinds: fn() -> String) -> Self {
        let kinds: BTreeSet<String> = (Language::ALL.into_iter())
            .flat_map(|language| {
                fold_name(&language.within(kinds)).split_whitespace().map(str::to_owned).collect::<Vec<_>>()
            })
            .collect();
        let number = |word: &String| {
            // Japanese has no blank between them.
            let numbers =
                kinds.iter().filter(|kind| !kind.is_ascii()).filter_map(|kind| word.strip_prefix(kind.as_str()));
            numbers.map(str::to_owned).find(|rest| !rest.is_empty() && rest.bytes().all(|digit| digit.is_ascii_digit()))
        };
        match self.0.split_first() {
            Some((first, [])) => number(first).map_or_else(|| self.clone(), |number| Self(vec![number])),
            Some((first, rest)) if kinds.contains(first.trim_end_matches([':', '：'])) => Self(rest.to_vec()),
            _ => self.clone(),
        }
    }

    fn are_in(&self, text: &str) -> bool {
        let folded = fold_name(text);
        self.0.iter().all(|word| folded.contains(word.as_str()))
    }

    /// What the ledger looks for: the longest word.
    fn pattern(&self) -> NamePattern {
        NamePattern::containing(self.0.iter().max_by_key(|word| word.len()).map_or("", String::as_str))
    }

    /// The number of a build or part: `1182`, `#1182`, and with the letter of its kind `b1182` or `B-1182`.
    fn number(&self, letter: char) -> Option<i64> {
        let [word] = self.0.as_slice() else { return None };
        let word = word.strip_prefix('#').unwrap_or(word);
        let digits = match word.strip_prefix(letter) {
            Some(rest) => rest.strip_prefix('-').unwrap_or(rest),
            None => word,
        };
        digits.bytes().all(|digit| digit.is_ascii_digit()).then(|| digits.parse().ok())?
    }
}

/// Searches the ledger and the names of the configured machines. Keeps the first `most` rows of each kind. Nothing is found for a
/// text without a letter.
///
/// # Errors
/// When the ledger cannot be read.
pub async fn search_names(
    ledger: &Ledger,
    machines: &[&String],
    text: &str,
    most: usize,
) -> Result<FoundNames, LedgerError> {
    let words = SearchWords::of_text(text);
    let mut found = FoundNames {
        machines: FoundRows::new(),
        orders: FoundRows::new(),
        customers: FoundRows::new(),
        builds: FoundRows::new(),
        parts: FoundRows::new(),
    };
    if words.0.is_empty() {
        return Ok(found);
    }
    let of_machines = words.without_kind(|| say!("search-words-machine"));
    for name in machines.iter().filter(|name| of_machines.are_in(name)) {
        found.machines.count_row((*name).clone(), most);
    }
    let of_orders = words.without_kind(|| say!("search-words-order"));
    let take = |order: OrderRow| !of_orders.are_in(&order.name) || found.orders.count_row(order, most);
    ledger.orders_resembling(&of_orders.pattern(), take).await?;
    let of_builds = words.without_kind(|| say!("search-words-build"));
    find_builds(ledger, &of_builds, most, &mut found.builds).await?;
    find_parts(ledger, &words.without_kind(|| say!("search-words-part")), most, &mut found.parts).await?;
    found.customers = find_customers(ledger, &words.without_kind(|| say!("search-words-customer")), most).await?;
    Ok(found)
}

async fn find_builds(
    ledger: &Ledger,
    words: &SearchWords,
    most: usize,
    builds: &mut FoundRows<NamedBuildRow>,
) -> Result<(), LedgerError> {
    let numbered = match words.number('b') {
        Some(number) => ledger.named_build(BuildId(number)).await?,
        None => None,
    };
    let first = numbered.as_ref().map(|build| build.id);
    numbered.into_iter().for_each(|build| _ = builds.count_row(build, most));
    let is_named = |build: &NamedBuildRow| build.file_name.as_deref().is_some_and(|name| words.are_in(name));
    let take = |build: NamedBuildRow| Some(build.id) == first || !is_named(&build) || builds.count_row(build, most);
    ledger.builds_resembling(&words.pattern(), take).await
}

async fn find_parts(
    ledger: &Ledger,
    words: &SearchWords,
    most: usize,
    parts: &mut FoundRows<NamedPartRow>,
) -> Result<(), LedgerError> {
    let numbered = match words.number('p') {
        Some(number) => ledger.named_part(PartId(number)).await?,
        None => None,
    };
    let first = numbered.as_ref().map(|part| part.id);
    numbered.into_iter().for_each(|part| _ = parts.count_row(part, most));
    let is_named = |part: &NamedPartRow| {
        words.are_in(
            &[&part.name, &part.object_name, &part.order_name, &part.customer, &part.material, &part.note]
                .map(String::as_str)
                .join("\n"),
        )
    };
    let take = |part: NamedPartRow| Some(part.id) == first || !is_named(&part) || parts.count_row(part, most);
    ledger.parts_resembling(&words.pattern(), take).await
}

/// The customers of parts, by name.
async fn find_customers(
    ledger: &Ledger,
    words: &SearchWords,
    most: usize,
) -> Result<FoundRows<FoundCustomer>, LedgerError> {
    let (mut customers, mut seen) = (BTreeMap::<String, FoundCustomer>::new(), 0);
    let take = |part: NamedPartRow| {
        if part.customer.is_empty() || !words.are_in(&part.customer) {
            return true;
        }
        let empty = || FoundCustomer { name: part.customer.clone(), orders: BTreeSet::new(), parts: 0 };
        let customer = customers.entry(fold_name(&part.customer)).or_insert_with(empty);
        customer.parts += 1;
        if !part.order_name.is_empty() {
            customer.orders.insert(part.order_name);
        }
        seen += 1;
        seen < MAX_COUNTED
    };
    ledger.parts_resembling(&words.pattern(), take).await?;
    let mut found = FoundRows::new();
    customers.into_values().for_each(|customer| _ = found.count_row(customer, most));
    Ok(found)
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
