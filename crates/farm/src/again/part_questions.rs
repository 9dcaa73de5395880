//! Open questions of waiting parts: what a person must say or do, and how. `STATUS.txt`, `status.json`, `nestd show` and the
//! page of a part show them.

use language::say;
use ledger::{PartRow, QuestionKind, QuestionedPart};
use serde::Serialize;
use serde_json::json;

use crate::facts::material_fact::MaterialReading;

/// Maximum number of questions of a kind in `STATUS.txt`.
const MAX_LINES: usize = 3;

/// An open question of a part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
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
    pub fn of_part(part: &PartRow, materials: &MaterialReading) -> Vec<Self> {
        let kinds = QuestionKind::of_part(part);
        kinds.into_iter().map(|kind| Self::about(part, kind, materials)).collect()
    }

    /// A question of this kind about a part.
    fn about(part: &PartRow, kind: QuestionKind, materials: &MaterialReading) -> Self {
        let id = part.id;
        let (text, remedy) = match kind {
            QuestionKind::Confirmation => (
                say!("question-yes", question = language::told(part.owed.question.trim_end_matches('.'))),
                say!("question-yes-remedy", part = id.to_string()),
            ),
            QuestionKind::Original => {
                (say!("question-original"), say!("question-original-remedy", name = &part.name, part = id.to_string()))
            }
            QuestionKind::Copies => (
                say!("question-copies"),
                say!("question-copies-remedy", command = copies_command(part), part = id.to_string()),
            ),
            QuestionKind::Material => materials.why_waiting(part),
        };
        Self { kind, text, remedy }
    }
}

/// The command that says how many copies are wanted.
fn copies_command(part: &PartRow) -> String {
    format!("nestd edit {} --copies N", part.id)
}

/// The lines of `STATUS.txt` for the parts of a machine whose number of copies is asked for. (Parts that wait for a yes or for
/// their file are in an alert.)
pub(crate) fn questions_text(machine: &str, asked: &[QuestionedPart]) -> String {
    let own: Vec<&QuestionedPart> =
        asked.iter().filter(|row| row.part.machine == machine && row.kind == QuestionKind::Copies).collect();
    let mut lines: Vec<String> = own
        .iter()
        .take(MAX_LINES)
        .map(|QuestionedPart { part, .. }| {
            let (id, command) = (part.id.to_string(), copies_command(part));
            say!("status-question", part = id, name = &part.name, command = command) + "\n"
        })
        .collect();
    let more = own.first().map_or(0, |row| row.total.saturating_sub(lines.len() as u32));
    if more > 0 {
        lines.push(say!("status-questions-more", parts = more) + "\n");
    }
    lines.concat()
}

/// The open questions of a machine for `status.json`.
pub(crate) fn questions_json(
    machine: &str,
    asked: &[QuestionedPart],
    materials: &MaterialReading,
) -> serde_json::Value {
    let of_part = |part: &PartRow| {
        let (id, name) = (part.id, part.full_name());
        let as_json = move |question: PartQuestion| {
            json!({
                "part": id, "name": name, "kind": question.kind, "question": question.text, "remedy": question.remedy,
            })
        };
        PartQuestion::of_part(part, materials).into_iter().map(as_json)
    };
    // A part with two questions has a row for each kind.
    let mut parts: Vec<&PartRow> = asked.iter().map(|row| &row.part).filter(|part| part.machine == machine).collect();
    parts.sort_by_key(|part| part.id);
    parts.dedup_by_key(|part| part.id);
    parts.into_iter().flat_map(of_part).collect()
}

#[cfg(test)]
mod tests {
    use build_file::COPIES_QUESTION;
    use ledger::{NewPartRow, SolidFacts};
    use ledger_fixtures::{fresh, new_part, solid};

    use super::*;

    #[tokio::test]
    async fn each_open_question_of_a_part_comes_with_what_answers_it() {
        let ledger = fresh().await;
        let unclear = format!("{} Taken as 1 copy, because its name is not clear.", COPIES_QUESTION);
        let mut ids = Vec::new();
        for (claim, warnings, question) in [
            ("plain", Vec::new(), ""),
            ("unclear", vec![unclear.clone()], ""),
            ("speck", vec![unclear], "it is 0.4 mm long"),
        ] {
            let id = ledger.record_claim(&NewPartRow { warnings, ..new_part(claim, 1) }).await.unwrap().id;
            let facts = SolidFacts { question: question.to_owned(), ..solid(0, 1) };
            ledger.accept_solids(id, &[facts]).await.unwrap();
            ids.push(id);
        }
        let asked = ledger.parts_with_questions(9).await.unwrap();
        assert_eq!(asked.iter().map(|row| row.part.id).collect::<Vec<_>>(), ids[1..]);
        let mut rows = Vec::new();
        for id in &ids {
            rows.push(ledger.find_part(*id).await.unwrap().unwrap());
        }
        let none = MaterialReading::default();
        let kinds = |part: &PartRow| {
            PartQuestion::of_part(part, &none).iter().map(|question| question.kind).collect::<Vec<_>>()
        };
        assert_eq!(kinds(&rows[0]), []);
        assert_eq!(kinds(&rows[1]), [QuestionKind::Copies]);
        assert_eq!(kinds(&rows[2]), [QuestionKind::Confirmation, QuestionKind::Copies]);
        for row in &asked {
            assert_eq!(kinds(&row.part).first(), Some(&row.kind), "SQL and Rust ask the same first");
        }
        rows[0].times.damaged_at = Some(rows[0].times.claimed_at);
        assert_eq!(kinds(&rows[0]), [QuestionKind::Original]);
        let json = questions_json("paper-200", &asked, &none);
        assert_eq!(json.as_array().unwrap().len(), 3, "{json:#}");
        assert_eq!(json[1]["question"], "It waits for a yes: it is 0.4 mm long.");
        assert_eq!(json[1]["remedy"], "`nestd confirm 3` prints it as it is, `nestd cancel 3` refuses it.");
        assert_eq!(questions_json("other", &asked, &none), json!([]));
        assert_eq!(questions_text("paper-200", &asked).matches("Question: How many copies? part 2").count(), 1);
    }
}
