//! How far the breaking out of a build is: what is known of each copy of its pick map, and the bins, one for each order.

use std::{collections::BTreeMap, sync::Arc};

use language::say;
use ledger::{BuildRow, PickMark, PickMarkRow};

use crate::{
    tables::PickedCopy,
    web::{
        base::error::{HandlerError, HandlerResult},
        core::{cached_render::find_build, state::DashboardState},
        figures::pick_map::{CachedPickMap, bin_orders},
        pages::pick_page::cached_map,
    },
};

/// What is known of a copy of the list.
#[derive(Debug, Clone)]
pub(crate) enum CopyState {
    /// It is still in the cake, as far as anybody said.
    Open,
    /// Somebody said something.
    Marked(PickMarkRow),
    /// It was told bad with the outcome of the build, and waits again.
    ToldBad,
}

/// A copy as people name it: `17: bracket.stl, copy 2`.
pub(super) fn copy_title(copy: &PickedCopy) -> String {
    say!("copy-title", number = copy.number, name = &copy.name, copy = copy.copy)
}

/// A build that is being broken out.
pub(crate) struct BreakOutState {
    pub(crate) build: BuildRow,
    pub(crate) map: CachedPickMap,
    /// In the order of the list.
    pub(crate) states: Vec<CopyState>,
    /// Order of each bin; "" = parts without an order.
    pub(super) bins: Vec<String>,
}

impl BreakOutState {
    /// Reads it from the ledger.
    pub(crate) async fn read(web: &Arc<DashboardState>, number: i64) -> HandlerResult<Self> {
        let (build, profile) = find_build(web, number).await?;
        if build.times.published_at.is_none() {
            return Err(HandlerError::NotFound(say!("published-build", build = number.to_string())));
        }
        let map = cached_map(web, &build, &profile).await?;
        let mut marks: BTreeMap<(i64, u32), PickMarkRow> = BTreeMap::new();
        for row in web.ledger.picks_of_build(build.id).await? {
            marks.insert((row.part_id.0, row.copy + 1), row);
        }
        let placed = web.ledger.placements_of_build(build.id).await?;
        let told_bad: Vec<(i64, u32)> =
            placed.iter().filter(|row| row.is_bad).map(|row| (row.part_id.0, row.copy + 1)).collect();
        let state = |copy: &PickedCopy| match marks.remove(&(copy.part, copy.copy)) {
            // What is told is no mark to undo any more.
            _ if told_bad.contains(&(copy.part, copy.copy)) => CopyState::ToldBad,
            Some(row) => CopyState::Marked(row),
            None => CopyState::Open,
        };
        let states = map.list.copies.iter().map(state).collect();
        let bins = bin_orders(map.list.copies.iter().map(|copy| copy.order.as_str()));
        let bins = bins.into_iter().map(str::to_owned).collect();
        Ok(Self { build, map, states, bins })
    }

    /// Address of its page.
    pub(crate) fn address(&self) -> String {
        format!("/builds/{}/break-out", self.build.id)
    }

    /// Address of the page that shows the copy at a position of the list.
    pub(super) fn address_of(&self, at: usize) -> String {
        format!("{}?at={}", self.address(), at + 1)
    }

    /// Positions in the list of the copies that are in the cake.
    pub(super) fn open_positions(&self) -> Vec<usize> {
        (0..self.states.len()).filter(|&at| matches!(self.states[at], CopyState::Open)).collect()
    }

    /// Number of the bin of a copy, from 0.
    pub(super) fn bin_of(&self, copy: &PickedCopy) -> usize {
        self.bins.iter().position(|order| *order == copy.order).unwrap_or(0)
    }

    /// The copies with their states, bin by bin.
    pub(crate) fn counts(&self) -> Vec<BinCount> {
        let mut counts: Vec<BinCount> = self.bins.iter().map(|order| BinCount::new(order)).collect();
        for (copy, state) in self.map.list.copies.iter().zip(&self.states) {
            if let Some(count) = counts.iter_mut().find(|count| count.order == copy.order) {
                count.add(state);
            }
        }
        counts
    }

    /// What this user said last, or anybody if he said nothing, of one copy or of several at once, as far as it still counts.
    pub(super) fn last_press(&self, user: &str) -> Vec<(&PickedCopy, &PickMarkRow)> {
        let mut marked: Vec<_> = (self.map.list.copies.iter().zip(&self.states))
            .filter_map(|(copy, state)| match state {
                CopyState::Marked(row) => Some((copy, row)),
                _ => None,
            })
            .collect();
        let Some(&(_, last)) = marked.iter().max_by_key(|(_, row)| (row.told_by == user, row.id)) else {
            return marked;
        };
        marked.retain(|(_, row)| (&row.told_by, row.told_at, row.mark) == (&last.told_by, last.told_at, last.mark));
        marked
    }
}

/// What became of the copies of an order.
#[derive(Debug, Clone, Default)]
pub(crate) struct BinCount {
    pub(crate) order: String,
    pub(crate) all: u32,
    pub(crate) good: u32,
    pub(crate) bad: u32,
    pub(crate) missing: u32,
}

impl BinCount {
    fn new(order: &str) -> Self {
        Self { order: order.to_owned(), ..Self::default() }
    }

    fn add(&mut self, state: &CopyState) {
        self.all += 1;
        match state {
            CopyState::Open => {}
            CopyState::ToldBad => self.bad += 1,
            CopyState::Marked(row) => match row.mark {
                PickMark::Out => self.good += 1,
                PickMark::Bad => self.bad += 1,
                PickMark::Missing => self.missing += 1,
                PickMark::Open => {}
            },
        }
    }

    /// Copies of which nobody said anything.
    pub(crate) fn open(&self) -> u32 {
        self.all - self.good - self.bad - self.missing
    }

    /// Its name for people.
    pub(crate) fn name(&self) -> String {
        if self.order.is_empty() { say!("bin-no-order") } else { self.order.clone() }
    }
}

/// The sum of all bins.
pub(super) fn sum_of(counts: &[BinCount]) -> BinCount {
    let mut sum = BinCount::default();
    for bin in counts {
        (sum.all, sum.good) = (sum.all + bin.all, sum.good + bin.good);
        (sum.bad, sum.missing) = (sum.bad + bin.bad, sum.missing + bin.missing);
    }
    sum
}
