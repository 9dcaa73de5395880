//! Open questions of waiting parts: what a person must say or do, and how. `STATUS.txt`, `status.json`, `nestd show` and the
//! page of a part show them.

use build_file::format_count;
use serde_json::json;

use crate::{
    intake,
    ledger::{PartRow, PartState, QuestionKind, QuestionedPart},
};

/// Maximum number of questions of a kind in `STATUS.txt`.
const MAX_LINES: usize = 3;

/// An open question of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartQuestion {
    /// What it is about.
    pub kind: QuestionKind,
    /// The question, a sentence.
    pub text: String,
    /// What answers it, a sentence with commands in backticks.
    pub remedy: String,
}

impl PartQuestion {
    /// The open questions of a part.
    pub fn of_part(part: &PartRow) -> Vec<Self> {
        let mut questions = Vec::new();
        let mut ask = |kind, text: String, remedy: String| questions.push(Self { kind, text, remedy });
        let id = part.id;
        if part.state == PartState::Waiting && !part.owed.question.is_empty() {
            let remedy = format!("`nestd confirm {id}` prints it as it is, `nestd cancel {id}` refuses it.");
            ask(QuestionKind::Confirmation, format!("It waits for a yes: {}", part.owed.question), remedy);
        }
        if part.times.damaged_at.is_some() && part.state.is_live() {
            let remedy = format!("Drop {} once more, or take it back with `nestd cancel {id}`.", part.name);
            ask(QuestionKind::Original, "Its original is missing or damaged, so it is not printed.".to_owned(), remedy);
        }
        if part.state == PartState::Waiting && part.wanted_copies() == 1 && has_copies_question(part) {
            let remedy = format!("`nestd edit {id} --copies N` answers it.");
            ask(QuestionKind::Copies, format!("{} It is taken as 1.", intake::COPIES_QUESTION), remedy);
        }
        questions
    }
}

fn has_copies_question(part: &PartRow) -> bool {
    part.warnings.lines().any(intake::is_copies_question)
}

/// The lines of `STATUS.txt` for the parts of a profile whose number of copies is asked for. (Parts that wait for a yes or for
/// their file are in an alert.)
pub(super) fn questions_text(profile: &str, asked: &[QuestionedPart]) -> String {
    let own: Vec<&QuestionedPart> =
        asked.iter().filter(|row| row.part.profile == profile && row.kind == QuestionKind::Copies).collect();
    let mut lines: Vec<String> = own
        .iter()
        .take(MAX_LINES)
        .map(|QuestionedPart { part, .. }| {
            format!(
                "Question: {} part {} ({}) is taken as 1; answer with `nestd edit {} --copies N`.\n",
                intake::COPIES_QUESTION,
                part.id,
                part.name,
                part.id
            )
        })
        .collect();
    let more = own.first().map_or(0, |row| row.total.saturating_sub(lines.len() as u32));
    if more > 0 {
        lines.push(format!("The same is asked of {}.\n", format_count(more, "more part", "more parts")));
    }
    lines.concat()
}

/// The open questions of a profile for `status.json`.
pub(super) fn questions_json(profile: &str, asked: &[QuestionedPart]) -> serde_json::Value {
    let of_part = |part: &PartRow| {
        let (id, name) = (part.id, part.full_name());
        let as_json = move |question: PartQuestion| {
            json!({
                "part": id, "name": name, "kind": question.kind, "question": question.text, "remedy": question.remedy,
            })
        };
        PartQuestion::of_part(part).into_iter().map(as_json)
    };
    // A part with two questions has a row for each kind.
    let mut parts: Vec<&PartRow> = asked.iter().map(|row| &row.part).filter(|part| part.profile == profile).collect();
    parts.sort_by_key(|part| part.id);
    parts.dedup_by_key(|part| part.id);
    parts.into_iter().flat_map(of_part).collect()
}
