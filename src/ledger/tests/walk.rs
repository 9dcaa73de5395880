//! Random walks over everything that can happen to parts and builds: whatever happens in whatever order, no copy is
//! lost, none is in two builds, and states agree with placements.

use std::{
    cell::RefCell,
    collections::{BTreeMap, BTreeSet},
};

use proptest::{
    prelude::*,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};

use super::*;

/// A step; the numbers choose a part, a build or copies among those that are there.
#[derive(Debug, Clone)]
enum Step {
    Claim(u32),
    Accept(usize),
    Reject(usize),
    Cancel(usize),
    Retry(usize),
    /// Fires with the first copies in line.
    Fire(usize),
    /// Fires with a copy that may be taken already.
    FireOne(usize, u32),
    Release(usize, usize),
    Fail(usize),
    Verify(usize),
    Publish(usize),
    Tell(usize, Outcome),
}

fn step() -> impl Strategy<Value = Step> {
    let any = 0..64usize;
    let outcome =
        prop::sample::select(vec![Outcome::Printing, Outcome::Complete, Outcome::Interrupted, Outcome::Failed]);
    prop_oneof![
        3 => (1..5u32).prop_map(Step::Claim),
        6 => any.clone().prop_map(Step::Accept),
        1 => any.clone().prop_map(Step::Reject),
        1 => any.clone().prop_map(Step::Cancel),
        2 => any.clone().prop_map(Step::Retry),
        4 => (1..8usize).prop_map(Step::Fire),
        2 => (any.clone(), 0..3u32).prop_map(|(part, copy)| Step::FireOne(part, copy)),
        3 => (any.clone(), any.clone()).prop_map(|(build, copy)| Step::Release(build, copy)),
        1 => any.clone().prop_map(Step::Fail),
        5 => any.clone().prop_map(Step::Verify),
        5 => any.clone().prop_map(Step::Publish),
        1 => (any, outcome).prop_map(|(build, outcome)| Step::Tell(build, outcome)),
    ]
}

/// The walker knows what it has made, nothing of states.
#[derive(Default)]
struct Walk {
    parts: Vec<(PartId, u32)>,
    builds: Vec<BuildId>,
}

impl Walk {
    /// One of the parts with its copies; before there is one, a number that no part has.
    fn part(&self, number: usize) -> (PartId, u32) {
        self.parts.get(number % self.parts.len().max(1)).copied().unwrap_or((PartId(0), 1))
    }

    /// One of the last few builds: those before have ended and refuse everything.
    fn build(&self, number: usize) -> BuildId {
        self.builds.iter().rev().nth(number % self.builds.len().clamp(1, 5)).copied().unwrap_or(BuildId(0))
    }

    async fn take(&mut self, ledger: &Ledger, step: Step) -> Result<(), LedgerError> {
        match step {
            Step::Claim(copies) => {
                let claim = format!("claim-{}", self.parts.len());
                let id = ledger.record_claim(&new_part(&claim, copies)).await?.id;
                self.parts.push((id, copies));
                Ok(())
            }
            Step::Accept(part) => {
                let (id, copies) = self.part(part);
                ledger.accept(id, &[solid(0, copies)]).await.map(drop)
            }
            Step::Reject(part) => ledger.reject(self.part(part).0, Refusal::Format, "unreadable").await,
            Step::Cancel(part) => ledger.cancel(self.part(part).0, Refusal::Cancelled, "not needed").await,
            Step::Retry(part) => ledger.retry(self.part(part).0).await,
            Step::Fire(count) => {
                let line = ledger.waiting_copies("paper-200").await?;
                let copies = line.iter().flat_map(|w| w.copies.iter().map(|&copy| (w.part.id, copy)));
                self.fire(ledger, &copies.take(count).collect::<Vec<_>>()).await
            }
            Step::FireOne(part, copy) => self.fire(ledger, &[(self.part(part).0, copy)]).await,
            Step::Release(build, copy) => {
                let build = self.build(build);
                let copies = ledger.copies_of_build(build).await?;
                let chosen: Vec<(PartId, u32)> = copies.into_iter().skip(copy % 3).step_by(2).collect();
                ledger.release_copies(build, &chosen).await
            }
            Step::Fail(build) => ledger.fail_build(self.build(build), "no layout").await,
            Step::Verify(build) => {
                let build = self.build(build);
                let copies = ledger.copies_of_build(build).await?;
                ledger.verify_build(build, &verified(build, copies.len() as u32), &placed(&copies)).await
            }
            Step::Publish(build) => ledger.publish_build(self.build(build)).await,
            Step::Tell(build, outcome) => ledger.record_outcome(self.build(build), outcome, "seen", "walker").await,
        }
    }

    async fn fire(&mut self, ledger: &Ledger, copies: &[(PartId, u32)]) -> Result<(), LedgerError> {
        let build = ledger.open_build("paper-200").await?.id;
        ledger.begin_nesting(build, "flush", copies).await?;
        self.builds.push(build);
        Ok(())
    }

    /// Every copy of every part is in exactly one place: in line, or in one build, or its part is out of the farm.
    async fn account(&self, ledger: &Ledger) {
        let mut seen = BTreeSet::new();
        for waiting in ledger.waiting_copies("paper-200").await.unwrap() {
            assert!(!waiting.copies.is_empty(), "part {} waits with nothing", waiting.part.id);
            seen.extend(waiting.copies.iter().map(|&copy| (waiting.part.id, copy)));
        }
        for &build in &self.builds {
            for copy in ledger.copies_of_build(build).await.unwrap() {
                assert!(seen.insert(copy), "{copy:?} is in two places");
            }
        }
        for &(id, copies) in &self.parts {
            let state = part_state(ledger, id).await;
            let found = (0..copies).filter(|&copy| seen.contains(&(id, copy))).count() as u32;
            match state {
                PartState::Claimed | PartState::Rejected => assert!(found < copies, "part {id}: {found}"),
                _ => assert_eq!(found, copies, "part {id} that is {state} has lost a copy"),
            }
        }
    }
}

fn is_refusal(error: &LedgerError) -> bool {
    !matches!(error, LedgerError::Sql(_) | LedgerError::Open { .. } | LedgerError::Migrate { .. })
}

/// Walks the steps; returns the names of those that were not refused.
async fn walk(steps: Vec<Step>) -> Vec<String> {
    let ledger = fresh().await;
    let (mut walk, mut done) = (Walk::default(), Vec::new());
    for step in steps {
        match walk.take(&ledger, step.clone()).await {
            Ok(()) => done.push(format!("{step:?}").split('(').next().unwrap().to_owned()),
            Err(error) => assert!(is_refusal(&error), "{step:?}: {error:?}"),
        }
        walk.account(&ledger).await;
    }
    assert_eq!(ledger.faults().await.unwrap(), Vec::<String>::new());
    ledger.close().await;
    done
}

#[test]
fn whatever_happens_no_copy_is_lost_or_in_two_builds() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let done: RefCell<BTreeMap<String, u32>> = RefCell::default();
    let mut runner = TestRunner::new_with_rng(
        Config { cases: 16, failure_persistence: None, ..Config::default() },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    );
    let walked = runner.run(&prop::collection::vec(step(), 120), |steps| {
        for name in runtime.block_on(walk(steps)) {
            *done.borrow_mut().entry(name).or_default() += 1;
        }
        Ok(())
    });
    walked.unwrap();
    let done = done.into_inner();
    assert_eq!(done.len(), 12, "the walks must reach every step: {done:?}");
    assert!(done.values().all(|&count| count >= 5), "the walks reach some steps hardly ever: {done:?}");
}
