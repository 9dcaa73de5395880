//! Mails: what happened, in the language of the farm, for the people whom it concerns. Events of one kind are gathered into one mail
//! for each recipient.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result};
use jiff::Timestamp;
use language::{Language, join_names, say, say_word, told};
use ledger::{EventKind, EventRow, Ledger, PartRow, ReceiverKind, RefusalCause, UtcTimestamp};
use settings::EmailSettings;

use super::message::{AlertWords, host_name};

/// Most lines of an order that a mail lists.
const MAX_LINES: usize = 40;
/// Most names in a subject.
const MAX_NAMES: usize = 3;

/// A mail.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Mail {
    /// Addresses that get it.
    pub to: Vec<String>,
    pub subject: String,
    pub text: String,
    /// Its unique id, without the domain. It is the same when the same mail is sent again.
    pub id: String,
    /// The events that it tells.
    pub events: Vec<i64>,
}

/// One event of a mail.
#[derive(Clone)]
struct MailItem {
    event: i64,
    at: UtcTimestamp,
    /// Machine or server, "" = not known.
    machine: String,
    /// Order, "" = none.
    order: String,
    subject: String,
    text: String,
    /// Addresses of customers whom it concerns.
    customers: Vec<String>,
}

/// The configured addresses that get the mails of a kind. Those of customers stand in the orders.
pub(super) fn addresses_of(email: &EmailSettings, receiver: ReceiverKind) -> &[String] {
    match receiver {
        ReceiverKind::EmailAlert | ReceiverKind::EmailRefused => &email.technician,
        ReceiverKind::EmailAtRisk => &email.planner,
        _ => &[],
    }
}

/// Writes the mails about these events of one kind. `sent` are events that an address has got already.
pub(super) async fn compose_mails(
    (email, language): (&EmailSettings, Language),
    receiver: ReceiverKind,
    events: &[EventRow],
    ledger: &Ledger,
    sent: &BTreeSet<(i64, String)>,
) -> Result<Vec<Mail>> {
    let mut groups: BTreeMap<Vec<String>, Vec<MailItem>> = BTreeMap::new();
    for event in events.iter().filter(|event| concerns_a_person(event)) {
        let item = read_item(event, ledger, language).await?;
        match receiver {
            ReceiverKind::EmailOrderComplete => {
                for address in item.customers.iter().filter(|address| !sent.contains(&(event.id, (*address).clone()))) {
                    groups.entry(vec![address.clone()]).or_default().push(item.clone());
                }
            }
            _ => groups.entry(addresses_of(email, receiver).to_vec()).or_default().push(item),
        }
    }
    let make = |(to, items): (Vec<String>, Vec<MailItem>)| language.within(|| make_mail(receiver, to, &items));
    let mut mails: Vec<Mail> = groups.into_iter().map(make).collect();
    mails.sort_by_key(|mail| mail.events.first().copied());
    Ok(mails)
}

/// A mail for a test of the addresses.
pub(super) fn trial_mail(email: &EmailSettings, receiver: ReceiverKind) -> Mail {
    let to = addresses_of(email, receiver).to_vec();
    let text = say!("mail-trial", host = host_name());
    let id = format!("nestd.trial.{receiver}.{}", Timestamp::now().as_nanosecond());
    Mail { to, subject: say!("mail-trial-subject"), text: format!("{text}\n"), id, events: Vec::new() }
}

/// Whether somebody must learn of it: not what a person wanted so.
fn concerns_a_person(event: &EventRow) -> bool {
    let intended = [RefusalCause::Cancelled, RefusalCause::Replaced].map(|cause| cause.to_string());
    event.kind != EventKind::Refused || !intended.contains(&event.cause)
}

async fn read_item(event: &EventRow, ledger: &Ledger, language: Language) -> Result<MailItem> {
    let part = match event.part_id {
        Some(id) => Some(ledger.find_part(id).await?.context("an event is of no part")?),
        None => None,
    };
    let order = part.as_ref().map(|part| part.terms.order_name.clone()).unwrap_or_default();
    let (mut customers, mut lines) = (Vec::new(), Vec::new());
    if event.kind == EventKind::OrderComplete && !order.is_empty() {
        customers = ledger.emails_of_order(&order).await?;
        let all = ledger.order_lines(&order).await?;
        lines.extend(all.into_iter().filter(|line| line.copies.good > 0).map(|line| (line.copies.good, line.name)));
    }
    let (subject, text) = language.within(|| match event.kind {
        EventKind::Refused => refused_words(event, part.as_ref(), &order),
        EventKind::AtRisk => at_risk_words(event, &order),
        EventKind::OrderComplete => complete_words(&order, &lines),
        EventKind::Alert => alert_words(event),
        _ => (say!("mail-dropped-subject"), say!("mail-dropped", what = told(&event.detail))),
    });
    let machine = if event.machine.is_empty() { host_name() } else { event.machine.clone() };
    Ok(MailItem { event: event.id, at: event.at, machine, order, subject, text, customers })
}

fn refused_words(event: &EventRow, part: Option<&PartRow>, order: &str) -> (String, String) {
    let (machine, reason) = (&event.machine, told(event.detail.trim_end()));
    let Some(part) = part else {
        let what = say!("mail-refused-nameless", machine = machine);
        return (say!("mail-refused-nameless-subject", machine = machine), format!("{what}\n{}", indented(&reason)));
    };
    let what = match order {
        "" => say!("mail-refused", machine = machine, name = &part.name),
        order => say!("mail-refused-of-order", machine = machine, name = &part.name, order = order),
    };
    let subject = say!("mail-refused-subject", machine = machine, name = &part.name);
    (subject, format!("{what}\n{}", indented(&reason)))
}

fn at_risk_words(event: &EventRow, order: &str) -> (String, String) {
    let subject = match order {
        "" => say!("mail-at-risk-subject", machine = &event.machine),
        order => say!("mail-at-risk-subject-order", order = order, machine = &event.machine),
    };
    let what = say!("mail-at-risk", machine = &event.machine);
    (subject, format!("{what}\n{}", indented(&told(event.detail.trim_end()))))
}

fn complete_words(order: &str, lines: &[(u32, String)]) -> (String, String) {
    let mut text = say!("mail-complete", order = order);
    for (copies, name) in lines.iter().take(MAX_LINES) {
        text += &format!("\n    {}", say!("mail-complete-line", copies = *copies, name = name));
    }
    if lines.len() > MAX_LINES {
        text += &format!("\n    {}", say!("mail-complete-more", count = lines.len() - MAX_LINES));
    }
    (say!("mail-complete-subject", order = order), text)
}

fn alert_words(event: &EventRow) -> (String, String) {
    let words = AlertWords::of_detail(&event.detail);
    // The catalogs have the sentences of each kind; an alert that they do not have stays as it was written.
    let in_language = |which: &str, written: &str| {
        let word = format!("{}-{which}", event.cause);
        let said = say_word("alert", &word);
        if said == word { written.to_owned() } else { said }
    };
    let headline = in_language("headline", words.headline);
    let place = if event.machine.is_empty() { host_name() } else { event.machine.clone() };
    let what = match words.found.trim_end_matches('.') {
        "" => say!("alert-alone", headline = &headline),
        found => say!("alert-quoted", headline = &headline, detail = told(found)),
    };
    let subject = say!("alert-of", machine = &place, what = &headline);
    let text = say!("alert-of", machine = place, what = what);
    (subject, format!("{text}\n{}", indented(&in_language("remedy", words.remedy))))
}

fn make_mail(receiver: ReceiverKind, to: Vec<String>, items: &[MailItem]) -> Mail {
    let subject = match items {
        [one] => one.subject.clone(),
        several => subject_of_several(receiver, several),
    };
    let texts: Vec<&str> = items.iter().map(|item| item.text.as_str()).collect();
    let footer = match receiver {
        ReceiverKind::EmailOrderComplete => say!("mail-footer-customer"),
        _ => say!("mail-footer", host = host_name()),
    };
    let text = format!("{}\n\n-- \n{footer}\n", texts.join("\n\n"));
    let events: Vec<i64> = items.iter().map(|item| item.event).collect();
    let (first, last) = (items.first(), items.last());
    let began = first.map(|item| item.at.0.as_millisecond()).unwrap_or_default();
    let number = |item: Option<&MailItem>| item.map(|item| item.event).unwrap_or_default();
    let whom = blake3::hash(to.join(",").as_bytes()).to_hex();
    let id = format!("nestd.{}-{}.{began}.{}", number(first), number(last), &whom[..12]);
    let subject = subject.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    Mail { to, subject, text, id, events }
}

fn subject_of_several(receiver: ReceiverKind, items: &[MailItem]) -> String {
    let names = |name: fn(&MailItem) -> &String| {
        let all: BTreeSet<&String> = items.iter().map(name).filter(|name| !name.is_empty()).collect();
        let shown: Vec<String> = all.iter().take(MAX_NAMES).map(|name| (*name).clone()).collect();
        join_names(&shown) + if all.len() > MAX_NAMES { " …" } else { "" }
    };
    let machines = names(|item| &item.machine);
    match receiver {
        ReceiverKind::EmailRefused => say!("mail-refused-several", count = items.len(), machines = machines),
        ReceiverKind::EmailAtRisk => say!("mail-at-risk-several", count = items.len(), machines = machines),
        ReceiverKind::EmailOrderComplete => say!("mail-complete-several", orders = names(|item| &item.order)),
        _ => say!("mail-alerts-several", count = items.len(), machines = machines),
    }
}

/// The lines of a text, set in.
fn indented(text: &str) -> String {
    text.lines().map(|line| format!("    {line}")).collect::<Vec<_>>().join("\n")
}
