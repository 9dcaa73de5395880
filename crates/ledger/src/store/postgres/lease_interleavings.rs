//! The rules of the lease under all interleavings of two and of three nodes: requests and their answers are delayed and lost, nodes are
//! restarted, time passes. At no moment two nodes may act, and no change of an earlier owner follows one of a later. And, where a standby
//! takes the place of the database without the last changes: no node changes a ledger that lacks what it knows to be committed.

use std::{
    collections::{HashSet, VecDeque},
    time::Duration,
};

use super::lease_watch::{LeaseRecord, LeaseWatch};

/// Length of a lease, and the last moment that is tried.
const LEASE: Duration = Duration::from_secs(2);
const END: Duration = Duration::from_secs(6);
const STEP: Duration = Duration::from_secs(1);
/// Numbers of nodes, each with the number of steps after which a sequence ends.
const TWO_NODES: (usize, usize) = (2, 13);
const THREE_NODES: (usize, usize) = (3, 8);
const TWO_NODES_AND_A_STANDBY: (usize, usize) = (2, 9);

/// The row of the database, as the statements of `lease.rs` change it.
#[derive(Clone, Default, PartialEq, Eq, Hash)]
struct LeaseRow {
    owner: Option<usize>,
    epoch: i64,
    until: Duration,
    /// Changes that its owners have committed.
    changes: i64,
}

impl LeaseRow {
    fn grant(&mut self, node: usize, now: Duration) -> Option<LeaseRecord> {
        let is_free = self.owner.is_none() || self.until <= now || self.owner == Some(node);
        is_free.then(|| {
            *self = Self { owner: Some(node), epoch: self.epoch + 1, until: now + LEASE, ..*self };
            self.record()
        })
    }

    fn renew(&mut self, epoch: i64, now: Duration) {
        if self.epoch == epoch {
            self.until = now + LEASE;
        }
    }

    fn record(&self) -> LeaseRecord {
        LeaseRecord { epoch: self.epoch, changes: self.changes }
    }
}

/// A request that a node has sent, and its answer once the database has given it.
#[derive(Clone, PartialEq, Eq, Hash)]
struct SentRequest {
    sent_at: Duration,
    /// The lease to renew, as it was known then; `None` = the lease is asked for.
    renews: Option<LeaseWatch>,
    /// What the database has; `None` inside = refused.
    answer: Option<Option<LeaseRecord>>,
}

#[derive(Clone, Default, PartialEq, Eq, Hash)]
struct NodeState {
    watch: Option<LeaseWatch>,
    request: Option<SentRequest>,
}

#[derive(Clone, Default, PartialEq, Eq, Hash)]
struct FarmState {
    now: Duration,
    row: LeaseRow,
    /// The highest epoch that has changed the ledger.
    changed_by: i64,
    standby: Standby,
    nodes: Vec<NodeState>,
}

/// A second database, which once copies the first, and once takes its place.
#[derive(Clone, Default, PartialEq, Eq, Hash)]
enum Standby {
    /// There is none, and changes are not counted, which keeps the number of states small.
    #[default]
    Absent,
    Empty,
    /// The row and `changed_by` at the moment of the copy.
    Copied(LeaseRow, i64),
    Promoted,
}

/// The rules, or one of the mistakes that one can make with them.
#[derive(Clone, Copy, PartialEq)]
enum LeaseRules {
    Ours,
    /// The lease counts from when the answer came.
    CountsFromAnswer,
    /// Changes do not compare the epoch.
    ChangesUnfenced,
    /// A renewal does not compare the epoch.
    RenewsAnyEpoch,
    /// Nobody compares the number of changes.
    ChangesUncounted,
}

/// What goes wrong.
#[derive(Debug, PartialEq)]
enum LeaseFault {
    TwoMayAct,
    EarlierOwnerChanged,
    LostChangeUnnoticed,
}

#[derive(Clone, Copy)]
enum NodeStep {
    Send,
    Handle,
    Receive,
    LoseAnswer,
    Change,
    /// A change whose answer is lost.
    ChangeUnheard,
    Restart,
}

impl LeaseRules {
    /// What a node takes for committed when it compares.
    fn known_changes(self, watch: LeaseWatch) -> i64 {
        if self == Self::ChangesUncounted { 0 } else { watch.committed() }
    }
}

impl FarmState {
    /// The state after a step of a node; `None` = the step is not possible.
    fn take(&self, node: usize, step: NodeStep, rules: LeaseRules) -> Option<Result<Self, LeaseFault>> {
        let mut next = self.clone();
        let now = self.now;
        let own = &mut next.nodes[node];
        match step {
            NodeStep::Send => {
                let renews = own.watch.filter(|watch| !watch.is_lost());
                if own.request.is_some() {
                    return None;
                }
                own.request = Some(SentRequest { sent_at: now, renews, answer: None });
            }
            NodeStep::Handle => {
                let request = own.request.as_mut().filter(|request| request.answer.is_none())?;
                request.answer = Some(match request.renews {
                    None => next.row.grant(node, now),
                    Some(watch) if rules == LeaseRules::RenewsAnyEpoch => {
                        next.row.until = now + LEASE;
                        Some(LeaseRecord { epoch: watch.epoch(), changes: watch.committed() })
                    }
                    Some(watch) => {
                        next.row.renew(watch.epoch(), now);
                        Some(next.row.record())
                    }
                });
            }
            NodeStep::Receive => {
                let request = own.request.take_if(|request| request.answer.is_some())?;
                let counts_from = if rules == LeaseRules::CountsFromAnswer { now } else { request.sent_at };
                match (request.renews, request.answer.flatten(), own.watch.as_mut()) {
                    (None, Some(granted), _) => own.watch = Some(LeaseWatch::granted(granted, counts_from, LEASE)),
                    (Some(asked), found @ Some(_), Some(watch)) => {
                        // One that is lost stays lost.
                        watch.compare(found, rules.known_changes(asked));
                        watch.renew(counts_from, LEASE);
                    }
                    _ => {}
                }
            }
            NodeStep::LoseAnswer => {
                own.request.take()?;
            }
            NodeStep::Change | NodeStep::ChangeUnheard => {
                let is_heard = matches!(step, NodeStep::Change);
                if let Err(fault) = next.change(node, is_heard, rules)? {
                    return Some(Err(fault));
                }
            }
            NodeStep::Restart => {
                own.watch.take()?;
                own.request = None;
            }
        }
        Some(next.check())
    }

    /// A node changes the ledger, and hears of it or not; `None` = it has no lease. A change may be sent long before the database handles
    /// it, so that the watch does not keep it back.
    fn change(&mut self, node: usize, is_heard: bool, rules: LeaseRules) -> Option<Result<(), LeaseFault>> {
        let mut watch = self.nodes[node].watch?;
        let (epoch, committed) = (watch.epoch(), watch.committed());
        let is_ours = watch.compare(Some(self.row.record()), rules.known_changes(watch));
        if rules == LeaseRules::ChangesUnfenced || is_ours {
            if epoch < self.changed_by {
                return Some(Err(LeaseFault::EarlierOwnerChanged));
            }
            if self.row.changes < committed {
                return Some(Err(LeaseFault::LostChangeUnnoticed));
            }
            self.changed_by = epoch;
            if self.standby != Standby::Absent {
                self.row.changes += 1;
            }
            if is_heard {
                watch.confirm_change(self.row.changes);
            }
        }
        if self.standby != Standby::Absent {
            self.nodes[node].watch = Some(watch);
        }
        Some(Ok(()))
    }

    fn check(self) -> Result<Self, LeaseFault> {
        // Where the grant was lost with the last changes, its owner sees it at its next change.
        if self.standby == Standby::Promoted {
            return Ok(self);
        }
        let acting = self.nodes.iter().filter(|node| node.watch.is_some_and(|watch| watch.may_act(self.now)));
        if acting.count() > 1 { Err(LeaseFault::TwoMayAct) } else { Ok(self) }
    }

    fn following(&self, rules: LeaseRules) -> Vec<Result<Self, LeaseFault>> {
        use NodeStep::{Change, ChangeUnheard, Handle, LoseAnswer, Receive, Restart, Send};
        let mut all: Vec<_> = (0..self.nodes.len())
            .flat_map(|node| {
                [Send, Handle, Receive, LoseAnswer, Change, ChangeUnheard, Restart]
                    .map(|step| self.take(node, step, rules))
            })
            .flatten()
            .collect();
        if self.now < END {
            all.push(Self { now: self.now + STEP, ..self.clone() }.check());
        }
        match &self.standby {
            Standby::Empty => {
                let standby = Standby::Copied(self.row.clone(), self.changed_by);
                all.push(Self { standby, ..self.clone() }.check());
            }
            Standby::Copied(row, changed_by) => {
                let (row, changed_by) = (row.clone(), *changed_by);
                all.push(Self { row, changed_by, standby: Standby::Promoted, ..self.clone() }.check());
            }
            Standby::Absent | Standby::Promoted => {}
        }
        all
    }
}

/// Tries every sequence of steps. Returns the number of different states.
fn try_all(rules: LeaseRules, extent: (usize, usize)) -> Result<usize, LeaseFault> {
    try_with(rules, extent, Standby::Absent)
}

fn try_with(rules: LeaseRules, (nodes, depth_limit): (usize, usize), standby: Standby) -> Result<usize, LeaseFault> {
    let start = FarmState { nodes: vec![NodeState::default(); nodes], standby, ..FarmState::default() };
    let (mut seen, mut queue) = (HashSet::from([start.clone()]), VecDeque::from([(start, 0)]));
    while let Some((state, depth)) = queue.pop_front() {
        if depth == depth_limit {
            continue;
        }
        for next in state.following(rules) {
            let next = next?;
            if seen.insert(next.clone()) {
                queue.push_back((next, depth + 1));
            }
        }
    }
    Ok(seen.len())
}

#[test]
fn at_no_moment_two_nodes_may_act_on_postgres() {
    for extent in [TWO_NODES, THREE_NODES] {
        let states = try_all(LeaseRules::Ours, extent).unwrap();
        assert!(states > 10_000, "{states} states of {} nodes", extent.0);
    }
}

#[test]
fn no_node_changes_a_ledger_that_lost_its_changes_on_postgres() {
    let states = try_with(LeaseRules::Ours, TWO_NODES_AND_A_STANDBY, Standby::Empty).unwrap();
    assert!(states > 10_000, "{states} states");
    let uncounted = try_with(LeaseRules::ChangesUncounted, TWO_NODES_AND_A_STANDBY, Standby::Empty);
    assert_eq!(uncounted, Err(LeaseFault::LostChangeUnnoticed));
}

#[test]
fn each_mistake_with_the_rules_is_found_on_postgres() {
    assert_eq!(try_all(LeaseRules::CountsFromAnswer, TWO_NODES), Err(LeaseFault::TwoMayAct));
    assert_eq!(try_all(LeaseRules::CountsFromAnswer, THREE_NODES), Err(LeaseFault::TwoMayAct));
    assert_eq!(try_all(LeaseRules::ChangesUnfenced, TWO_NODES), Err(LeaseFault::EarlierOwnerChanged));
    assert_eq!(try_all(LeaseRules::RenewsAnyEpoch, TWO_NODES), Err(LeaseFault::TwoMayAct));
}
