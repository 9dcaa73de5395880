//! How far a part is: once it is built, as far as the copy of it that is least far; before that, as the ledger has it. And what people call
//! the states of the ledger.

use std::collections::BTreeMap;

use anyhow::Result;
use ledger::{Ledger, LineCopies, PartId, PartState};

use super::copy_fact::{CopyWord, copy_counts, counted_words};
use crate::planning::MachinePlan;

/// The word of a state of the ledger as people say it; that of a fact is what people say.
pub fn said_state(word: &str) -> &str {
    match word {
        "claimed" => "being read",
        "batched" => "being made",
        "built" => "in a build",
        "verified" => "proved",
        "published" => "in the queue",
        word => word,
    }
}

/// How far a part is in this state with these copies.
pub fn part_fact(state: PartState, copies: &LineCopies) -> String {
    let is_wanted = |word: &CopyWord| *word <= CopyWord::InBuild;
    let least = counted_words(copies).map(|(_, word)| word).filter(is_wanted).last();
    match least.filter(|_| state == PartState::Built) {
        Some(word) => word.word().to_owned(),
        None => said_state(&state.to_string()).to_owned(),
    }
}

/// How far parts are according to the plans of the machines.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_part_facts(
    ledger: &Ledger,
    parts: &[(PartId, PartState)],
    plans: &[MachinePlan],
) -> Result<BTreeMap<PartId, String>> {
    let mut facts = BTreeMap::new();
    for &(id, state) in parts {
        // Of what is not built, its copies say no more.
        let known = match state {
            PartState::Built => ledger.line_of_part(id).await?.copies,
            _ => LineCopies::default(),
        };
        let copies = copy_counts(&known, plans, |planned| planned.part == id);
        facts.insert(id, part_fact(state, &copies));
    }
    Ok(facts)
}
