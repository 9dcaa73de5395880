//! Chips: a state as a colour, a shape and its word. Which tone a word has is decided here, for all pages.

use farm::said_state;
use maud::{Markup, html};

/// What a state means for whoever looks: each tone has a colour and a shape of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tone {
    /// It is done and well: a tick.
    Good,
    /// Something works on it: an arrow.
    Busy,
    /// It comes next: a square.
    Next,
    /// Nothing happens, or it is over: a ring.
    Idle,
    /// It should be looked at: a triangle.
    Tight,
    /// It went wrong: a cross.
    Wrong,
}

impl Tone {
    /// All of them.
    pub(crate) const ALL: [Self; 6] = [Self::Good, Self::Busy, Self::Next, Self::Idle, Self::Tight, Self::Wrong];

    /// Its name in the style sheet.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Busy => "busy",
            Self::Next => "next",
            Self::Idle => "idle",
            Self::Tight => "tight",
            Self::Wrong => "wrong",
        }
    }

    /// The words of states that have it: those of the facts and of the ledger. Any other word is idle.
    pub(crate) fn words(self) -> &'static [&'static str] {
        match self {
            Self::Good => &["complete", "good", "kept", "on time", "done", "runs"],
            Self::Busy => &[
                "printing",
                "at the printer",
                "should be printed",
                "cooling",
                "nesting",
                "being made",
                "being read",
                "reading",
                "claimed",
                "batched",
                "under way",
            ],
            Self::Next => &[
                "open",
                "waiting",
                "collecting",
                "queued",
                "in the queue",
                "verified",
                "proved",
                "published",
                "built",
                "expecting",
                "in a build",
                "later",
            ],
            Self::Idle => &["free", "closed now", "withdrawn", "cancelled", "closed", "stopped", "no date"],
            Self::Tight => &[
                "tight",
                "ended",
                "should be done",
                "waits for a yes",
                "paused",
                "interrupted",
                "short",
                "missing",
                "is to be repaired",
                "on its way to another printer",
                "being taken back",
            ],
            Self::Wrong => &["overdue", "late", "failed", "refused", "bad", "down", "unavailable", "does not answer"],
        }
    }

    /// That of a state with this word.
    pub(crate) fn of_word(word: &str) -> Self {
        Self::ALL.into_iter().find(|tone| tone.words().contains(&word)).unwrap_or(Self::Idle)
    }
}

/// A state in words, in the language that is current.
pub(crate) fn state_text(word: &str) -> String {
    language::say_word("state", said_state(word))
}

/// A state as people see it.
pub(crate) fn chip(word: &str) -> Markup {
    chip_of(Tone::of_word(word), &state_text(word))
}

/// A text in a tone.
pub(crate) fn chip_of(tone: Tone, text: &str) -> Markup {
    html! { span class=(format!("chip {}", tone.class())) { i {} (text) } }
}

#[cfg(test)]
mod tests {
    use ledger::{BuildState, OrderState, PartState, PrintOutcome};

    use super::*;
    use farm::{CopyWord, MachineWord, OrderWord, PlanStage, PrinterWord};

    #[test]
    fn every_word_of_a_state_is_in_the_catalogs() {
        for word in Tone::ALL.iter().flat_map(|tone| tone.words()) {
            let marked = language::Language::Marked.within(|| state_text(word));
            assert_eq!(marked, format!("⟦{}⟧", said_state(word)));
        }
    }

    #[test]
    fn every_word_of_a_state_has_one_tone_that_was_chosen_for_it() {
        let stages = [
            PlanStage::Ended,
            PlanStage::Cooling,
            PlanStage::Printing,
            PlanStage::Taken,
            PlanStage::Queued,
            PlanStage::Made,
            PlanStage::Open,
            PlanStage::Later,
        ];
        let words = (MachineWord::ALL.map(|word| word.word().to_owned()).into_iter())
            .chain(OrderWord::ALL.map(|word| word.word().to_owned()))
            .chain(CopyWord::ALL.map(|word| word.word().to_owned()))
            .chain(PrinterWord::ALL.map(|word| word.word().to_owned()))
            .chain(BuildState::ALL.map(|state| state.to_string()))
            .chain(PartState::ALL.map(|state| state.to_string()))
            .chain([OrderState::Open, OrderState::Complete, OrderState::Short].map(|state| state.to_string()))
            .chain([PrintOutcome::Complete, PrintOutcome::Interrupted, PrintOutcome::Failed].map(|o| o.to_string()))
            .chain(stages.into_iter().flat_map(|stage| [true, false].map(|yes| stage.word(yes).to_owned())));
        for word in words {
            let tones = Tone::ALL.iter().filter(|tone| tone.words().contains(&word.as_str())).count();
            assert_eq!(tones, 1, "{word}");
        }
    }
}
