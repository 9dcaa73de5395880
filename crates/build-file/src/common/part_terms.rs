//! What may be asked of a part, the same for tickets, order lists, packages, edits and orders of programs: limits, and the sentences that
//! refuse what is beyond them.

use crate::{escape_invisible, escape_invisible_lines};

/// Most copies of a part.
pub const MAX_COPIES: u32 = 10_000;
/// The highest priority. A part that has it must be in the next build.
pub const MAX_PRIORITY: u8 = 100;
/// Greatest distance to all other parts, mm. A larger one is taken for a wrong unit.
pub const MAX_CLEARANCE_MM: f64 = 100.0;
/// Maximum length of a name of an order or a customer, and of a note, bytes.
pub const MAX_TEXT_BYTES: usize = 4096;

/// Maximum length of an address for e-mail, bytes: what SMTP carries (RFC 5321, 4.5.3.1.3).
const MAX_EMAIL_BYTES: usize = 254;

/// Maximum number of finishing steps of a part.
const MAX_FINISH_STEPS: usize = 12;
/// Maximum length of a finishing step: it is part of a key of the ledger.
const MAX_STEP_BYTES: usize = 200;
/// Between the finishing steps of a part.
const BETWEEN_STEPS: &str = ", ";
/// Words of people for a part that is as it comes out of the cake.
const NO_FINISH: &str = "- – n/a none no raw natural roh natur unbehandelt keine nein ohne brut naturel sans aucun aucune ninguno ninguna \
                         nessuno nessuna geen ingen brak なし 無し 无 無 없음";

/// A number of copies.
pub fn check_copies(copies: i64) -> Result<u32, String> {
    match u32::try_from(copies) {
        Ok(copies @ 1..=MAX_COPIES) => Ok(copies),
        _ => Err(format!("copies = {copies}; it must be 1 to {MAX_COPIES}")),
    }
}

/// A priority.
pub fn check_priority(priority: i64) -> Result<u8, String> {
    match u8::try_from(priority) {
        Ok(priority @ 0..=MAX_PRIORITY) => Ok(priority),
        _ => Err(format!("priority = {priority}; it must be 0 to {MAX_PRIORITY}")),
    }
}

/// A part's own clearance, mm.
pub fn check_clearance(clearance_mm: f64) -> Result<f64, String> {
    match (0.0..=MAX_CLEARANCE_MM).contains(&clearance_mm) {
        true => Ok(clearance_mm),
        false => Err(format!("clearance_mm = {clearance_mm}; it must be 0 to {MAX_CLEARANCE_MM}")),
    }
}

/// The name of an order or of a customer, without what cannot be seen; `word` is what it is called in the sentence.
pub fn check_name(word: &str, name: &str) -> Result<String, String> {
    check_text(word, escape_invisible(name.trim()))
}

/// An address for e-mail, "" = none.
pub fn check_email(email: &str) -> Result<String, String> {
    let email = email.trim();
    let (user, host) = email.rsplit_once('@').unwrap_or_default();
    let is_plain = |c: char| !c.is_whitespace() && !c.is_control() && !"@<>()[],;:\\\"".contains(c);
    let is_host = host.contains('.') && host.split('.').all(|label| !label.is_empty());
    match email.is_empty()
        || email.len() <= MAX_EMAIL_BYTES
            && !user.is_empty()
            && is_host
            && email.replacen('@', "", 1).chars().all(is_plain)
    {
        true => Ok(email.to_owned()),
        false => Err(format!(
            "email = {:?}; write one address such as name@example.org, or leave it out",
            escape_invisible(email)
        )),
    }
}

/// Finishing steps after the print in their order, as people write them in one line: `dye black; smooth`. Joined as [`finish_steps`] reads
/// them; "" = none.
pub fn check_finish(finish: &str) -> Result<String, String> {
    let mut steps: Vec<String> = Vec::new();
    for step in split_steps(finish) {
        let step = check_name("finish", step)?;
        let lower = step.to_lowercase();
        let is_none = NO_FINISH.split_whitespace().any(|word| word == lower);
        if step.len() > MAX_STEP_BYTES {
            return Err(format!("a step of finish has {} bytes; at most {MAX_STEP_BYTES} are taken", step.len()));
        }
        if !step.is_empty() && !is_none && !steps.iter().any(|known| known.to_lowercase() == lower) {
            steps.push(step);
        }
    }
    match steps.len() <= MAX_FINISH_STEPS {
        true => Ok(steps.join(BETWEEN_STEPS)),
        false => Err(format!("finish has {} steps; at most {MAX_FINISH_STEPS} are taken", steps.len())),
    }
}

/// The steps as people separate them. A comma between two digits is one of a number.
fn split_steps(finish: &str) -> Vec<&str> {
    let (mut steps, mut begin) = (Vec::new(), 0);
    for (at, letter) in finish.char_indices().filter(|(_, letter)| ",;+\n、，；".contains(*letter)) {
        let end = at + letter.len_utf8();
        let is_digit = |beside: Option<char>| beside.is_some_and(|letter| letter.is_ascii_digit());
        let in_number = is_digit(finish[..at].chars().next_back()) && is_digit(finish[end..].chars().next());
        if letter != ',' || !in_number {
            steps.push(&finish[begin..at]);
            begin = end;
        }
    }
    steps.push(&finish[begin..]);
    steps
}

/// The steps of a finish as [`check_finish`] joined them.
pub fn finish_steps(finish: &str) -> impl Iterator<Item = &str> {
    finish.split(BETWEEN_STEPS).filter(|step| !step.is_empty())
}

/// A note, of one line or several.
pub fn check_note(note: &str) -> Result<String, String> {
    check_text("note", escape_invisible_lines(note))
}

fn check_text(word: &str, text: String) -> Result<String, String> {
    match text.len() <= MAX_TEXT_BYTES {
        true => Ok(text),
        false => Err(format!("{word} is {} bytes long; at most {MAX_TEXT_BYTES} are taken", text.len())),
    }
}
