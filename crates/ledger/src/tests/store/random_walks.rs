//! Random sequences of everything that can happen to parts and builds. Whatever the order, no copy is lost, none is in
//! two builds, and states agree with placements.

use std::{
    cell::RefCell,
    collections::{BTreeMap, BTreeSet},
};

use proptest::{
    prelude::*,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};

use crate::tests::*;

/// A step. The numbers select a part, a build or copies among the existing ones.
#[derive(Debug, Clone)]
pub(crate) enum WalkStep {
    Claim(u32),
    Accept(usize),
    Refuse(usize),
    Cancel(usize),
    Retry(usize),
    /// Starts a build with the first waiting copies.
    Fire(usize),
    /// Starts a build with a copy that may be taken already.
    FireOne(usize, u32),
    Release(usize, usize),
    Fail(usize),
    Verify(usize),
    Publish(usize),
    /// Build, outcome, bad copies of its first part, whether they are kept, whether it is a correction.
    Tell(usize, PrintOutcome, u32, bool, bool),
    Reprint(usize, u32),
    ReprintBuild(usize),
    Requeue(usize),
    EditCopies(usize, u32),
    EditMaterial(usize, usize),
    Load(usize),
    CancelCopies(usize, u32),
}

pub(crate) fn step() -> impl Strategy<Value = WalkStep> {
    let any = 0..64usize;
    let outcome = prop::sample::select(vec![
        PrintOutcome::Printing,
        PrintOutcome::Complete,
        PrintOutcome::Interrupted,
        PrintOutcome::Failed,
    ]);
    prop_oneof![
        3 => (1..5u32).prop_map(WalkStep::Claim),
        6 => any.clone().prop_map(WalkStep::Accept),
        1 => any.clone().prop_map(WalkStep::Refuse),
        1 => any.clone().prop_map(WalkStep::Cancel),
        2 => any.clone().prop_map(WalkStep::Retry),
        4 => (1..8usize).prop_map(WalkStep::Fire),
        2 => (any.clone(), 0..3u32).prop_map(|(part, copy)| WalkStep::FireOne(part, copy)),
        3 => (any.clone(), any.clone()).prop_map(|(build, copy)| WalkStep::Release(build, copy)),
        1 => any.clone().prop_map(WalkStep::Fail),
        5 => any.clone().prop_map(WalkStep::Verify),
        5 => any.clone().prop_map(WalkStep::Publish),
        4 => (any.clone(), outcome, 0..3u32, prop::bool::ANY, prop::bool::ANY)
            .prop_map(|(build, outcome, bad, keep, correct)| WalkStep::Tell(build, outcome, bad, keep, correct)),
        3 => (any.clone(), 1..3u32).prop_map(|(part, copies)| WalkStep::Reprint(part, copies)),
        1 => any.clone().prop_map(WalkStep::ReprintBuild),
        2 => any.clone().prop_map(WalkStep::Requeue),
        2 => (any.clone(), 1..7u32).prop_map(|(part, copies)| WalkStep::EditCopies(part, copies)),
        1 => (any.clone(), any.clone()).prop_map(|(part, material)| WalkStep::EditMaterial(part, material)),
        1 => any.clone().prop_map(WalkStep::Load),
        2 => (any, 1..4u32).prop_map(|(part, copies)| WalkStep::CancelCopies(part, copies)),
    ]
}

/// The materials of parts and machines, "" = any, or none.
const MATERIALS: [&str; 3] = ["", "PA12", "PA11"];
const OF_PARTS: [&str; 8] = ["", "PA12", "", "", "", "PA11", "", ""];

/// The test driver knows what it created, but no states.
#[derive(Default)]
pub(crate) struct RandomWalk {
    parts: Vec<(PartId, u32)>,
    builds: Vec<BuildId>,
}

impl RandomWalk {
    /// One of the parts with its number of copies. If there is none yet, a number that no part has.
    fn part(&self, number: usize) -> (PartId, u32) {
        self.parts.get(number % self.parts.len().max(1)).copied().unwrap_or((PartId(0), 1))
    }

    /// One of the last few builds. Earlier builds have ended and refuse everything.
    fn build(&self, number: usize) -> BuildId {
        self.builds.iter().rev().nth(number % self.builds.len().clamp(1, 5)).copied().unwrap_or(BuildId(0))
    }

    pub(crate) async fn take(&mut self, ledger: &Ledger, step: WalkStep) -> Result<(), LedgerError> {
        match step {
            WalkStep::Claim(copies) => {
                let claim = format!("claim-{}", self.parts.len());
                let at = self.parts.len();
                let orders = |terms: &mut NewTerms| {
                    (terms.order_name, terms.material) =
                        (format!("order-{}", at / 3), OF_PARTS[at % OF_PARTS.len()].to_owned());
                };
                let id = ledger.record_claim(&asked(new_part(&claim, copies), orders)).await?.id;
                self.parts.push((id, copies));
                Ok(())
            }
            WalkStep::Accept(part) => {
                let (id, copies) = self.part(part);
                ledger.accept_solids(id, &[solid(0, copies)]).await.map(drop)
            }
            WalkStep::Refuse(part) => ledger.refuse_claim(self.part(part).0, RefusalCause::Format, "unreadable").await,
            WalkStep::Cancel(part) => {
                ledger.cancel_part(self.part(part).0, RefusalCause::Cancelled, "not needed").await
            }
            WalkStep::Retry(part) => ledger.retry_part(self.part(part).0).await,
            WalkStep::Fire(count) => {
                let line = ledger.waiting_copies("paper-200").await?;
                let copies = line.iter().flat_map(|w| w.copies.iter().map(|&copy| (w.part.id, copy)));
                self.fire(ledger, &copies.take(count).collect::<Vec<_>>()).await
            }
            WalkStep::FireOne(part, copy) => self.fire(ledger, &[(self.part(part).0, copy)]).await,
            WalkStep::Release(build, copy) => {
                let build = self.build(build);
                let copies = ledger.copies_of_build(build).await?;
                let chosen: Vec<(PartId, u32)> = copies.into_iter().skip(copy % 3).step_by(2).collect();
                ledger.release_copies(build, &chosen, "found no place").await
            }
            WalkStep::Fail(build) => ledger.fail_build(self.build(build), "no layout").await,
            WalkStep::Verify(build) => {
                let build = self.build(build);
                let copies = ledger.copies_of_build(build).await?;
                ledger.verify_build(build, &verified(build, copies.len() as u32), &placed(&copies)).await
            }
            WalkStep::Publish(build) => ledger.publish_build(self.build(build)).await,
            WalkStep::Tell(build, outcome, bad, keep, is_correction) => {
                let build = self.build(build);
                let first = ledger.copies_of_build(build).await?.first().map(|&(part, _)| (part, bad));
                let bad = first.into_iter().filter(|_| bad > 0).collect();
                let told = ToldOutcome { bad, keep, is_correction, ..ToldOutcome::new(outcome, "seen", "walker") };
                ledger.record_outcome(build, &told).await.map(drop)
            }
            WalkStep::Reprint(part, copies) => {
                let target = ReprintTarget::Part(self.part(part).0, Some(copies));
                ledger.reprint_copies(&target, "walker").await.map(drop)
            }
            WalkStep::ReprintBuild(build) => {
                ledger.reprint_copies(&ReprintTarget::Build(self.build(build)), "walker").await.map(drop)
            }
            WalkStep::Requeue(build) => {
                let new = ledger.requeue_build(self.build(build), "walker").await?;
                self.builds.push(new);
                Ok(())
            }
            WalkStep::EditCopies(part, copies) => {
                let edit = PartEdit { copies: Some(copies), ..PartEdit::default() };
                ledger.edit_part(self.part(part).0, &edit, "walker").await.map(drop)
            }
            WalkStep::EditMaterial(part, material) => {
                let edit = PartEdit { material: Some(MATERIALS[material % 3].to_owned()), ..PartEdit::default() };
                ledger.edit_part(self.part(part).0, &edit, "walker").await.map(drop)
            }
            WalkStep::Load(material) => {
                ledger.load_material("paper-200", (MATERIALS[material % 3], ""), "walker").await.map(drop)
            }
            WalkStep::CancelCopies(part, copies) => ledger.cancel_copies(self.part(part).0, copies, "walker").await,
        }
    }

    async fn fire(&mut self, ledger: &Ledger, copies: &[(PartId, u32)]) -> Result<(), LedgerError> {
        let build = ledger.open_build("paper-200").await?.id;
        ledger.begin_nesting(build, "flush", copies).await?;
        self.builds.push(build);
        Ok(())
    }

    /// Checks that every wanted copy of every part is in exactly one place: it is waiting, or in one build that counts, or
    /// its part was refused.
    pub(crate) async fn account(&self, ledger: &Ledger) {
        for part in ledger.parts_to_fetch().await.unwrap() {
            ledger.mark_fetched(&part.file.content_hash).await.unwrap();
        }
        let mut seen = BTreeSet::new();
        // A part waits with each material that is loaded, or with its own.
        let loaded = ledger.loaded_material("paper-200").await.unwrap();
        for material in MATERIALS.into_iter().chain([loaded.as_str()]) {
            ledger.load_material("paper-200", (material, ""), "walker").await.unwrap();
            for waiting in ledger.waiting_copies("paper-200").await.unwrap() {
                assert!(!waiting.copies.is_empty(), "part {} waits with nothing", waiting.part.id);
                seen.extend(waiting.copies.iter().map(|&copy| (waiting.part.id, copy)));
            }
        }
        for &build in &self.builds {
            for row in ledger.placements_of_build(build).await.unwrap().iter().filter(|row| !row.is_bad) {
                assert!(seen.insert((row.part_id, row.copy)), "{row:?} is in two places");
            }
        }
        for &(id, _) in &self.parts {
            let part = ledger.find_part(id).await.unwrap().unwrap();
            let found = seen.iter().filter(|(of, _)| *of == id).count() as u32;
            let line = ledger.line_of_part(id).await.unwrap().copies;
            let sum = line.under_way() + line.good + line.refused;
            assert_eq!(line.wanted, sum, "part {id}: {line:?}");
            match part.state {
                PartState::Claimed | PartState::Refused => {
                    assert!(found <= part.wanted_copies(), "part {id}: {found}")
                }
                state => assert_eq!(found, part.wanted_copies(), "part {id} that is {state} has lost a copy"),
            }
        }
    }
}

pub(crate) fn is_refusal(error: &LedgerError) -> bool {
    !matches!(error, LedgerError::Sql(_) | LedgerError::Open { .. } | LedgerError::Migrate { .. })
}

/// Runs the steps. Returns the names of those that were not refused.
async fn walk(steps: Vec<WalkStep>) -> Vec<String> {
    let ledger = fresh().await;
    let (mut walk, mut done) = (RandomWalk::default(), Vec::new());
    for step in steps {
        match walk.take(&ledger, step.clone()).await {
            Ok(()) => done.push(format!("{step:?}").split('(').next().unwrap().to_owned()),
            Err(error) => assert!(is_refusal(&error), "{step:?}: {error:?}"),
        }
        walk.account(&ledger).await;
    }
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), Vec::<String>::new());
    ledger.close().await;
    done
}

#[test]
fn whatever_happens_no_copy_is_lost_or_in_two_builds() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let done: RefCell<BTreeMap<String, u32>> = RefCell::default();
    let mut runner = TestRunner::new_with_rng(
        Config { cases: 28, failure_persistence: None, ..Config::default() },
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
    assert_eq!(done.len(), 19, "the walks must reach every step: {done:?}");
    assert!(done.values().all(|&count| count >= 5), "the walks reach some steps hardly ever: {done:?}");
}
