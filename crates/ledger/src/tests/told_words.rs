//! What words do whose builds lie in no queue, with all that they report; people say them through `carry_out`.

use std::collections::BTreeMap;

use crate::{
    BreakOutAnswer, BuildId, Ledger, PutBackReport, ReprintTarget, ToldOutcome,
    base::error::Result,
    words::{outcome::tell_outcome, pick::end_break_out, put_back::printed_copies, requeue::issue_again},
};

impl Ledger {
    /// Tells the outcome of a build.
    pub async fn record_outcome(&self, build: BuildId, told: &ToldOutcome) -> Result<PutBackReport> {
        let mut change = self.begin_change().await?;
        let report = tell_outcome(&mut change, build, told).await?;
        change.commit().await?;
        Ok(report)
    }

    /// Has copies printed again.
    pub async fn reprint_copies(&self, target: &ReprintTarget, told_by: &str) -> Result<PutBackReport> {
        let mut change = self.begin_change().await?;
        let (mut report, mut chosen) = (PutBackReport::default(), BTreeMap::<_, Vec<_>>::new());
        for (build, part, copy) in printed_copies(&mut change, target).await? {
            chosen.entry(build).or_default().push((part, copy));
        }
        for (build, copies) in chosen {
            change.mark_bad(build, &copies, told_by, true, &mut report).await?;
        }
        change.commit().await?;
        Ok(report)
    }

    /// Issues a build once more.
    pub async fn requeue_build(&self, build: BuildId, asked_by: &str) -> Result<BuildId> {
        let mut change = self.begin_change().await?;
        let new = issue_again(&mut change, build, asked_by).await?;
        change.commit().await?;
        Ok(new)
    }

    /// Ends the breaking out of a build.
    pub async fn finish_break_out(&self, build: BuildId, told_by: &str) -> Result<BreakOutAnswer> {
        let mut change = self.begin_change().await?;
        let answer = end_break_out(&mut change, build, told_by).await?;
        change.commit().await?;
        Ok(answer)
    }
}
