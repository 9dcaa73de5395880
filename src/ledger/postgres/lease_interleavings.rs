//! The rules of the lease under all interleavings of two and of three nodes: requests and their answers are delayed and lost, nodes are
//! restarted, time passes. At no moment two nodes may act, and no change of an earlier owner follows one of a later.

use std::{
    collections::{HashSet, VecDeque},
    time::Duration,
};

use super::lease_watch::LeaseWatch;

/// Length of a lease, and the last moment that is tried.
const LEASE: Duration = Duration::from_secs(2);
const END: Duration = Duration::from_secs(6);
const STEP: Duration = Duration::from_secs(1);
/// Numbers of nodes, each with the number of steps after which a sequence ends.
const TWO_NODES: (usize, usize) = (2, 13);
const THREE_NODES: (usize, usize) = (3, 8);

/// The row of the database, as the statements of `lease.rs` change it.
#[derive(Clone, Default, PartialEq, Eq, Hash)]
struct LeaseRow {
    owner: Option<usize>,
    epoch: i64,
    until: Duration,
}

impl LeaseRow {
    fn grant(&mut self, node: usize, now: Duration) -> Option<i64> {
        let is_free = self.owner.is_none() || self.until <= now || self.owner == Some(node);
        is_free.then(|| {
            *self = Self { owner: Some(node), epoch: self.epoch + 1, until: now + LEASE };
            self.epoch
        })
    }

    fn renew(&mut self, epoch: i64, now: Duration) -> bool {
        let is_same = self.epoch == epoch;
        if is_same {
            self.until = now + LEASE;
        }
        is_same
    }
}

/// A request that a node has sent, and its answer once the database has given it.
#[derive(Clone, PartialEq, Eq, Hash)]
struct SentRequest {
    sent_at: Duration,
    /// The epoch to renew; `None` = the lease is asked for.
    renews: Option<i64>,
    /// The epoch that is held now; `None` inside = refused.
    answer: Option<Option<i64>>,
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
    nodes: Vec<NodeState>,
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
}

/// What goes wrong.
#[derive(Debug, PartialEq)]
enum LeaseFault {
    TwoMayAct,
    EarlierOwnerChanged,
}

#[derive(Clone, Copy)]
enum NodeStep {
    Send,
    Handle,
    Receive,
    LoseAnswer,
    Change,
    Restart,
}

impl FarmState {
    /// The state after a step of a node; `None` = the step is not possible.
    fn take(&self, node: usize, step: NodeStep, rules: LeaseRules) -> Option<Result<Self, LeaseFault>> {
        let mut next = self.clone();
        let now = self.now;
        let own = &mut next.nodes[node];
        match step {
            NodeStep::Send => {
                let renews = own.watch.filter(|watch| !watch.is_lost()).map(LeaseWatch::epoch);
                if own.request.is_some() {
                    return None;
                }
                own.request = Some(SentRequest { sent_at: now, renews, answer: None });
            }
            NodeStep::Handle => {
                let request = own.request.as_mut().filter(|request| request.answer.is_none())?;
                request.answer = Some(match request.renews {
                    None => next.row.grant(node, now),
                    Some(_) if rules == LeaseRules::RenewsAnyEpoch => {
                        next.row.until = now + LEASE;
                        request.renews
                    }
                    Some(epoch) => next.row.renew(epoch, now).then_some(epoch),
                });
            }
            NodeStep::Receive => {
                let request = own.request.take_if(|request| request.answer.is_some())?;
                let counts_from = if rules == LeaseRules::CountsFromAnswer { now } else { request.sent_at };
                match (request.renews, request.answer.flatten(), own.watch.as_mut()) {
                    (None, Some(epoch), _) => own.watch = Some(LeaseWatch::granted(epoch, counts_from, LEASE)),
                    (Some(_), Some(_), Some(watch)) => watch.renew(counts_from, LEASE),
                    (Some(_), None, Some(watch)) => watch.lose(),
                    _ => {}
                }
            }
            NodeStep::LoseAnswer => {
                own.request.take()?;
            }
            NodeStep::Change => {
                // A change may be sent long before the database handles it, so that the watch does not keep it back.
                let epoch = own.watch?.epoch();
                if rules == LeaseRules::ChangesUnfenced || epoch == next.row.epoch {
                    if epoch < next.changed_by {
                        return Some(Err(LeaseFault::EarlierOwnerChanged));
                    }
                    next.changed_by = epoch;
                }
            }
            NodeStep::Restart => {
                own.watch.take()?;
                own.request = None;
            }
        }
        Some(next.check())
    }

    fn check(self) -> Result<Self, LeaseFault> {
        let acting = self.nodes.iter().filter(|node| node.watch.is_some_and(|watch| watch.may_act(self.now)));
        if acting.count() > 1 { Err(LeaseFault::TwoMayAct) } else { Ok(self) }
    }

    fn following(&self, rules: LeaseRules) -> Vec<Result<Self, LeaseFault>> {
        use NodeStep::{Change, Handle, LoseAnswer, Receive, Restart, Send};
        let mut all: Vec<_> = (0..self.nodes.len())
            .flat_map(|node| {
                [Send, Handle, Receive, LoseAnswer, Change, Restart].map(|step| self.take(node, step, rules))
            })
            .flatten()
            .collect();
        if self.now < END {
            all.push(Self { now: self.now + STEP, ..self.clone() }.check());
        }
        all
    }
}

/// Tries every sequence of steps. Returns the number of different states.
fn try_all(rules: LeaseRules, (nodes, depth_limit): (usize, usize)) -> Result<usize, LeaseFault> {
    let start = FarmState { nodes: vec![NodeState::default(); nodes], ..FarmState::default() };
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
fn each_mistake_with_the_rules_is_found_on_postgres() {
    assert_eq!(try_all(LeaseRules::CountsFromAnswer, TWO_NODES), Err(LeaseFault::TwoMayAct));
    assert_eq!(try_all(LeaseRules::CountsFromAnswer, THREE_NODES), Err(LeaseFault::TwoMayAct));
    assert_eq!(try_all(LeaseRules::ChangesUnfenced, TWO_NODES), Err(LeaseFault::EarlierOwnerChanged));
    assert_eq!(try_all(LeaseRules::RenewsAnyEpoch, TWO_NODES), Err(LeaseFault::TwoMayAct));
}
