//! What stands on the labels of a build and of an order.

use axum::http::HeaderMap;
use language::say;
use ledger::{OrderLine, PartRow};

use super::label_layout::Label;
use crate::web::{base::query::order_address, figures::pick_map::bin_orders};

/// Where links on paper lead: the address by which the browser came here.
#[derive(Debug, Clone)]
pub(crate) struct LinkRoot(String);

impl LinkRoot {
    /// The address of a request. A reverse proxy with TLS says so in `x-forwarded-proto`.
    pub(super) fn of_request(headers: &HeaderMap) -> Self {
        let text = |name: &str| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
        let scheme = if text("x-forwarded-proto") == "https" { "https" } else { "http" };
        Self(format!("{scheme}://{}", text("host")))
    }

    /// The address of an order's page; "" = no order.
    fn of_order(&self, order: &str) -> String {
        if order.is_empty() { String::new() } else { self.of_page(&order_address(order)) }
    }

    /// The address of a page.
    pub(super) fn of_page(&self, path: &str) -> String {
        format!("{}{path}", self.0)
    }
}

/// A bag of copies of a part.
pub(super) struct Bag {
    order: String,
    customer: String,
    part: String,
    /// Finishing steps, "" = none.
    finish: String,
    /// `None` = nobody said how many are wanted.
    copies: Option<u32>,
}

impl Bag {
    /// The copies of a part that are in a build.
    pub(super) fn of_part(part: &PartRow, copies: u32) -> Self {
        let (order, customer) = (part.terms.order_name.clone(), part.terms.customer.clone());
        Self { order, customer, part: part.full_name(), finish: part.terms.finish.clone(), copies: Some(copies) }
    }

    /// The copies of a line of an order.
    pub(super) fn of_line(order: &str, line: &OrderLine) -> Self {
        let (customer, part, finish) = (line.customer.clone(), line.full_name(), line.finish.clone());
        let copies = line.is_number_known.then_some(line.copies.wanted);
        Self { order: order.to_owned(), customer, part, finish, copies }
    }

    fn order_words(&self) -> String {
        if self.order.is_empty() { say!("no-order") } else { self.order.clone() }
    }
}

/// A label for each bag.
pub(super) fn bag_labels(bags: &[Bag], build: Option<i64>, root: &LinkRoot) -> Vec<Label> {
    let label = |bag: &Bag| Label {
        title: bag.order_words(),
        lines: lines_of([
            bag.customer.clone(),
            bag.part.clone(),
            bag.finish.clone(),
            copies_of_build(bag.copies, build),
        ]),
        address: root.of_order(&bag.order),
    };
    bags.iter().map(label).collect()
}

/// A label for each bin: the copies of one order in a build. Their numbers are those of the break-out.
pub(super) fn bin_labels(bags: &[Bag], build: i64, root: &LinkRoot) -> Vec<Label> {
    let label = |(number, order): (usize, &str)| {
        let bags: Vec<&Bag> = bags.iter().filter(|bag| bag.order == order).collect();
        let customer = bags.iter().map(|bag| bag.customer.as_str()).find(|customer| !customer.is_empty());
        let parts = match bags[..] {
            [only] => only.part.clone(),
            _ => say!("count-parts", count = bags.len()),
        };
        let copies = copies_of_build(bags.iter().map(|bag| bag.copies).sum(), Some(build));
        Label {
            title: bags[0].order_words(),
            lines: lines_of([
                customer.unwrap_or_default().to_owned(),
                parts,
                say!("bin-with", number = number + 1, content = copies),
            ]),
            address: root.of_order(order),
        }
    };
    bin_orders(bags.iter().map(|bag| bag.order.as_str())).into_iter().enumerate().map(label).collect()
}

fn copies_of_build(copies: Option<u32>, build: Option<i64>) -> String {
    match (copies, build) {
        (Some(copies), Some(build)) => say!("copies-of-build", copies = copies, build = build.to_string()),
        (Some(copies), None) => say!("count-copies", count = copies),
        (None, _) => say!("copies-number-not-known"),
    }
}

fn lines_of<const N: usize>(lines: [String; N]) -> Vec<String> {
    lines.into_iter().filter(|line| !line.is_empty()).collect()
}
