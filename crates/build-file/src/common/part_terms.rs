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
/// Between the finishing steps of a part.
const BETWEEN_STEPS: &str = ", ";
/// Words of people for a part that is as it comes out of the cake.
const NO_FINISH: &str = "- none no raw natural roh natur unbehandelt keine nein brut aucune なし 無し";

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
    for step in finish.split([',', ';', '+', '\n', '、', '，', '；']) {
        let step = check_name("finish", step)?;
        let is_none = NO_FINISH.split_whitespace().any(|word| word == step.to_lowercase());
        if !step.is_empty() && !is_none && !steps.iter().any(|known| known.to_lowercase() == step.to_lowercase()) {
            steps.push(step);
        }
    }
    match steps.len() <= MAX_FINISH_STEPS {
        true => Ok(steps.join(BETWEEN_STEPS)),
        false => Err(format!("finish has {} steps; at most {MAX_FINISH_STEPS} are taken", steps.len())),
    }
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
