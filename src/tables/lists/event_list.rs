//! Events as a person reads them: what happened to several parts at one moment is one row.

use language::say;
use ledger::EventRow;

/// Events of one kind so near to each other happened at one moment, s.
const ONE_MOMENT_SECS: i64 = 60;
/// Details that a row of several events says.
const MAX_DETAILS: usize = 3;

/// Events, in the order of time or against it, without those that only repeat the one before of the same part, and with those of one kind
/// and build at one moment as one row: its detail names some of them, and how many more there are.
pub fn gathered_events(events: Vec<EventRow>) -> Vec<EventRow> {
    let mut groups: Vec<Vec<EventRow>> = Vec::new();
    for event in events {
        match groups.last_mut() {
            Some(group) if group.iter().any(|other| repeats(other, &event)) => {}
            Some(group) if group.last().is_some_and(|last| is_one_moment(last, &event)) => group.push(event),
            _ => groups.push(vec![event]),
        }
    }
    groups.into_iter().filter_map(one_row).collect()
}

/// Whether two events tell the same of a part: a word, and the state that it led to.
fn repeats(one: &EventRow, other: &EventRow) -> bool {
    one.part_id == other.part_id
        && one.build_id == other.build_id
        && !one.detail.is_empty()
        && one.detail == other.detail
}

fn is_one_moment(one: &EventRow, other: &EventRow) -> bool {
    let apart = one.at.0.as_second().abs_diff(other.at.0.as_second());
    one.kind == other.kind && one.build_id == other.build_id && apart <= ONE_MOMENT_SECS as u64
}

fn one_row(mut group: Vec<EventRow>) -> Option<EventRow> {
    if group.len() < 2 {
        return group.pop();
    }
    let mut details: Vec<&str> = Vec::new();
    for event in &group {
        if !event.detail.is_empty() && !details.contains(&event.detail.as_str()) {
            details.push(&event.detail);
        }
    }
    let more = details.len().saturating_sub(MAX_DETAILS);
    let named = details.iter().take(MAX_DETAILS).map(|detail| language::told(detail));
    let detail = language::join_sentences(named.chain((more > 0).then(|| say!("and-more", count = more))));
    let first = group.swap_remove(0);
    let part_id = group.iter().all(|event| event.part_id == first.part_id).then_some(first.part_id).flatten();
    Some(EventRow { part_id, detail, ..first })
}

#[cfg(test)]
mod tests {
    use ledger::{BuildId, EventKind, PartId};

    use super::*;

    fn event(second: i64, kind: EventKind, (part, build): (i64, Option<i64>), detail: &str) -> EventRow {
        EventRow {
            id: second,
            at: jiff::Timestamp::from_second(1_000_000 + second).unwrap().into(),
            kind,
            machine: String::new(),
            part_id: Some(PartId(part)),
            build_id: build.map(BuildId),
            detail: detail.to_owned(),
            cause: String::new(),
        }
    }

    #[test]
    fn what_happened_to_several_parts_at_one_moment_is_one_row() {
        let claimed = (1..=5).map(|part| event(part, EventKind::Claimed, (part, None), &format!("p{part}.stl")));
        let built = [event(10, EventKind::Built, (1, Some(7)), ""), event(400, EventKind::Built, (2, Some(7)), "")];
        let rows = gathered_events(claimed.chain(built).collect());
        let told: Vec<_> = rows.iter().map(|row| (row.part_id.map(|part| part.0), row.detail.as_str())).collect();
        assert_eq!(told, [(None, "p1.stl; p2.stl; p3.stl; and 2 more"), (Some(1), ""), (Some(2), "")]);
    }

    #[test]
    fn a_state_that_repeats_a_word_is_not_told_again() {
        let word = "4 copies put back from build 2 by ann@vm";
        let events =
            vec![event(1, EventKind::Waiting, (1, Some(2)), word), event(1, EventKind::PutBack, (1, Some(2)), word)];
        assert_eq!(gathered_events(events).len(), 1);
    }
}
