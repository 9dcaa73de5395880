//! Parses the cells of an order list as spreadsheets write them: numbers with a decimal comma or followed by a word,
//! dates in the formats of several countries, units by name.

use build_file::LengthUnit;
use jiff::{Timestamp, civil, tz::TimeZone};
use unicode_normalization::{UnicodeNormalization, char::is_combining_mark};

use crate::{DueDate, names::due_date::parse_due};

/// What people write into a cell that says nothing.
const PLACEHOLDERS: [&str; 10] = ["-", "--", "–", "—", "ー", "./.", "n/a", "k.a.", "k. a.", "なし"];

/// Words that may follow a number of copies.
const PIECE_WORDS: &str = "x × pcs pc pce pieces nos ea off copies units times stk stck stück stueck stuck st kopien exemplare mal \
                           ex exemplaires pièces fois unités pz uds ud szt ks шт 個 本 枚 件 コ ヶ ケ 点 台 つ 个 份";

/// Whether a cell says nothing.
pub(super) fn is_placeholder(cell: &str) -> bool {
    cell.is_empty() || PLACEHOLDERS.contains(&normalize_cell(cell).as_str())
}

/// Removes what programs put around the text of a cell: quotes of word processors, the apostrophe that makes text of a
/// number, and `="text"`.
pub(super) fn bare_cell(cell: &str) -> &str {
    let text = cell.trim();
    let text = text.strip_prefix("=\"").and_then(|rest| rest.strip_suffix('"')).unwrap_or(text);
    let is_quote = |c: char| matches!(c, '“' | '”' | '„' | '‟');
    let unquoted = text.strip_prefix(is_quote).and_then(|rest| rest.strip_suffix(is_quote)).unwrap_or(text);
    let is_number = |rest: &&str| rest.starts_with(|c: char| c.is_ascii_digit());
    unquoted.strip_prefix('\'').filter(is_number).unwrap_or(unquoted).trim()
}

/// Normalizes a header word: removes accents, signs and text in brackets behind it, and converts to lower case. `Stück
/// (Stk.)` becomes `stuck`.
pub(super) fn normalize_word(word: &str) -> String {
    let is_closed = word.trim_end().ends_with([')', ']', '）']);
    let head = word.split(['(', '[', '（']).next().filter(|head| is_closed && !head.trim().is_empty()).unwrap_or(word);
    let letters = head.nfkd().filter(|&c| !is_combining_mark(c)).flat_map(char::to_lowercase);
    letters.filter(|c| c.is_alphanumeric()).collect::<String>().replace('ß', "ss")
}

/// Converts a cell to lower case and replaces the full-width digits and signs of East Asian keyboards by the common
/// ones.
fn normalize_cell(cell: &str) -> String {
    cell.nfkc().collect::<String>().trim().to_lowercase()
}

/// Parses a whole number: `10`, `10 Stk.`, `x10`, `10,00`.
pub(super) fn parse_whole_number(word: &str, cell: &str) -> Result<i64, String> {
    let text = normalize_cell(cell);
    let bare = text.trim_end_matches('.').trim_start_matches(['x', '×']).trim();
    let bare = PIECE_WORDS
        .split_whitespace()
        .filter_map(|piece| bare.strip_suffix(piece))
        .min_by_key(|rest| rest.len())
        .unwrap_or(bare)
        .trim();
    // Spreadsheets write 10.0 and 10,00. Three zeros would mean thousands.
    let is_noughts = |tail: &str| (1..=2).contains(&tail.len()) && tail.bytes().all(|b| b == b'0');
    let bare = bare.rsplit_once(['.', ',']).filter(|(_, tail)| is_noughts(tail)).map_or(bare, |(head, _)| head);
    if let Some((head, tail)) = bare.split_once(['.', ',']).filter(|(head, tail)| is_thousands(head, tail)) {
        let decimal = format!("{head}.{tail}");
        let decimal = decimal.trim_end_matches('0').trim_end_matches('.');
        return Err(format!("{word} = {cell:?} may be {decimal} or {head}{tail}; write it without the sign"));
    }
    let whole: String = match bare.split_once([' ', '\'', '’']) {
        Some((head, tail)) if is_thousands(head, tail) => format!("{head}{tail}"),
        _ => bare.to_owned(),
    };
    whole.parse::<i64>().map_err(|_| format!("{word} = {cell:?} is no whole number"))
}

/// Whether these are the digits before and behind a sign for thousands.
fn is_thousands(head: &str, tail: &str) -> bool {
    let is_digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    (1..=3).contains(&head.len()) && !head.starts_with('0') && tail.len() == 3 && is_digits(head) && is_digits(tail)
}

/// Parses a number with a decimal point or comma, optionally followed by mm.
pub(super) fn parse_decimal(word: &str, cell: &str) -> Result<f64, String> {
    let text = normalize_cell(cell);
    let bare = text.strip_suffix("mm").unwrap_or(&text).trim();
    let number = bare.replacen(',', ".", 1).parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("{word} = {cell:?} is no number"))
}

/// Parses the unit of a file. A word for pieces, such as `pcs`, is not a length unit and gives `None`.
pub(super) fn parse_unit(cell: &str) -> Result<Option<LengthUnit>, String> {
    let text = normalize_cell(cell);
    let text = text.trim_end_matches('.');
    if PIECE_WORDS.split_whitespace().any(|piece| piece == text) {
        return Ok(None);
    }
    Ok(Some(match text {
        "µm" | "μm" | "um" | "micron" | "microns" | "micrometer" => LengthUnit::Micron,
        "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" | "millimètre" | "milímetro"
        | "millimetro" | "ミリ" => LengthUnit::Millimeter,
        "cm" | "centimeter" | "centimetre" | "zentimeter" | "centimètre" | "centímetro" | "centimetro" => {
            LengthUnit::Centimeter
        }
        "in" | "inch" | "inches" | "\"" | "zoll" | "pouce" | "pouces" | "pulgada" | "pulgadas" | "pollice"
        | "pollici" | "インチ" => LengthUnit::Inch,
        "ft" | "foot" | "feet" | "fuß" | "fuss" => LengthUnit::Foot,
        "m" | "meter" | "metre" | "mètre" | "metro" => LengthUnit::Meter,
        _ => return Err(format!("unit = {cell:?}; it must be micron, mm, cm, inch, foot or m")),
    }))
}

/// Parses a due date in the format of tickets, or as day, month, year, as most countries write it, optionally with a
/// time.
pub(super) fn parse_due_cell(cell: &str) -> Result<DueDate, String> {
    let text = without_weekday(&normalize_cell(cell)).replace(['年', '月'], "-").replace('日', "");
    if let Some(day) = parse_month_name_date(&text) {
        return parse_due(&day.to_string());
    }
    let text = text.replace(". ", ".");
    let as_ticket = parse_due(&text.to_uppercase());
    if as_ticket.is_ok() {
        return as_ticket;
    }
    let (day, time) = text.split_once([' ', 't']).unwrap_or((&text, ""));
    let day = parse_civil_date(day.trim_end_matches('.')).map_err(|why| format!("due = {cell:?}{why}"))?;
    match time.trim() {
        "" => parse_due(&day.to_string()),
        time => parse_due(&format!("{day}T{time:0>5}")),
    }
    .map_err(|_| format!("due = {cell:?}{NO_DATE}"))
}

/// Parses a due date as people write it, in the time zone of the farm. Returns the instant, and the date as it was given: a
/// day, a local time or an instant.
///
/// # Errors
/// It is no date; the error says how to write one.
pub fn parse_due_text(text: &str, zone: &TimeZone) -> Result<(Timestamp, String), String> {
    let due = parse_due_cell(text)?;
    let at = due.to_timestamp(zone).map_err(|error| format!("due = {text:?}: {error}"))?;
    Ok((at, due.to_string()))
}

const NO_DATE: &str = "; it must be a date such as 2026-11-25 or 25.11.2026, perhaps with a time such as 17:00";

/// Removes a weekday: `Di, `, `Tuesday, `, `(火)`.
fn without_weekday(text: &str) -> String {
    const WEEKDAYS: [&str; 21] = [
        "mo", "di", "mi", "do", "fr", "sa", "so", "tu", "we", "th", "su", "lu", "ma", "me", "je", "ve", "mon", "sam",
        "dim", "sun", "fri",
    ];
    let text = text.split_once('(').map_or(text, |(before, _)| before).trim();
    let (word, rest) = text.split_at(text.find(|c: char| !c.is_alphabetic()).unwrap_or(text.len()));
    let is_weekday = WEEKDAYS.iter().any(|day| word.starts_with(day)) && month_of(word).is_none();
    let rest = rest.trim_start_matches(['.', ',', ' ']);
    if is_weekday && !rest.is_empty() { rest.to_owned() } else { text.to_owned() }
}

/// The month of a name or its abbreviation, in English, German or French.
fn month_of(word: &str) -> Option<i8> {
    const STARTS: [(&str, i8); 20] = [
        ("jan", 1),
        ("jän", 1),
        ("feb", 2),
        ("fév", 2),
        ("mar", 3),
        ("mär", 3),
        ("mrz", 3),
        ("apr", 4),
        ("avr", 4),
        ("may", 5),
        ("mai", 5),
        ("jun", 6),
        ("juin", 6),
        ("jul", 7),
        ("juil", 7),
        ("aug", 8),
        ("aoû", 8),
        ("sep", 9),
        ("oct", 10),
        ("okt", 10),
    ];
    const LATER: [(&str, i8); 4] = [("nov", 11), ("dec", 12), ("dez", 12), ("déc", 12)];
    STARTS.iter().chain(&LATER).find(|(start, _)| word.starts_with(start)).map(|&(_, month)| month)
}

/// Parses a date with the name of its month: `1. Dezember 2026`, `Dec 1, 2026`, `1-Dec-26`, `1er décembre 2026`.
fn parse_month_name_date(text: &str) -> Option<civil::Date> {
    let words: Vec<&str> =
        text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty() && *word != "de").collect();
    let at = words.iter().position(|word| month_of(word).is_some())?;
    let numbers: Vec<&str> = words.iter().enumerate().filter(|(n, _)| *n != at).map(|(_, word)| *word).collect();
    let [day, year] = numbers[..] else { return None };
    let ordinal = ["er", "st", "nd", "rd", "th"].into_iter().find_map(|end| day.strip_suffix(end));
    let year: i16 = match year.len() {
        2 => 2000 + year.parse::<i16>().ok()?,
        4 => year.parse().ok()?,
        _ => return None,
    };
    civil::Date::new(year, month_of(words[at])?, ordinal.unwrap_or(day).parse().ok()?).ok()
}

fn parse_civil_date(text: &str) -> Result<civil::Date, String> {
    let parts: Vec<&str> = text.split(['.', '/', '-']).map(str::trim).collect();
    let numbers: Vec<i16> = parts.iter().filter_map(|part| part.parse().ok()).collect();
    let [first, second, third] = numbers[..] else { return Err(NO_DATE.to_owned()) };
    if parts.len() != 3 {
        return Err(NO_DATE.to_owned());
    }
    let date = |year: i16, month: i16, day: i16| {
        let of = |number: i16| i8::try_from(number).ok();
        of(month).zip(of(day)).and_then(|(month, day)| civil::Date::new(year, month, day).ok())
    };
    let found = if parts[0].len() == 4 {
        date(first, second, third)
    } else {
        let year = if parts[2].len() == 2 { 2000 + third } else { third };
        match text.contains('/') {
            true if first <= 12 && second <= 12 && first != second => {
                return Err(", which may be two dates; write it as 2026-11-25".to_owned());
            }
            true if second > 12 => date(year, first, second),
            _ => date(year, second, first),
        }
    };
    found.ok_or_else(|| NO_DATE.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_spreadsheets_and_people_write_them() {
        for (cell, number) in [("1 000", 1000), ("2'500", 2500), ("1\u{202f}000 pcs", 1000), ("10 ex.", 10)] {
            assert_eq!(parse_whole_number("copies", cell), Ok(number), "{cell}");
        }
        for cell in
            ["10", " 10 ", "10.0", "10,00", "10 Stk.", "10x", "x10", "× 10", "10 pcs", "１０", "10個", "10 Stück"]
        {
            assert_eq!(parse_whole_number("copies", cell), Ok(10), "{cell}");
        }
        assert!(parse_whole_number("copies", "1.000").unwrap_err().contains("1 or 1000"));
        for cell in ["1,5", "ten", "", "10 boxes", "1e1"] {
            assert!(parse_whole_number("copies", cell).unwrap_err().contains("no whole number"), "{cell}");
        }
        assert_eq!(parse_decimal("clearance", "2,5"), Ok(2.5));
        assert_eq!(parse_decimal("clearance", "2.5 mm"), Ok(2.5));
        assert!(parse_decimal("clearance", "wide").is_err());
    }

    #[test]
    fn dates_are_read_in_the_order_of_their_country_and_never_guessed() {
        for cell in [
            "2026-11-25",
            "25.11.2026",
            "25.11.26",
            "25. 11. 2026",
            "25/11/2026",
            "11/25/2026",
            "25-11-2026",
            "2026/11/25",
            "2026年11月25日",
            "2026.11.25.",
        ] {
            assert_eq!(parse_due_cell(cell), parse_due("2026-11-25"), "{cell}");
        }
        assert_eq!(parse_due_cell("25.11.2026 17:00"), parse_due("2026-11-25T17:00"));
        assert_eq!(parse_due_cell("25.11.2026 9:30"), parse_due("2026-11-25T09:30"));
        assert_eq!(parse_due_cell("2026-11-25T17:00:00Z"), parse_due("2026-11-25T17:00:00Z"));
        assert!(parse_due_cell("05/06/2026").unwrap_err().contains("two dates"));
        for cell in ["soon", "32.11.2026", "25.11", "2026-13-01", "25.11.2026.1"] {
            assert!(
                parse_due_cell(cell).unwrap_err().contains("such as 25")
                    || parse_due_cell(cell).unwrap_err().contains("25.11.2026"),
                "{cell}"
            );
        }
    }

    #[test]
    fn units_are_known_by_their_names() {
        assert_eq!(parse_unit("Zoll"), Ok(Some(LengthUnit::Inch)));
        assert_eq!(parse_unit("mm"), Ok(Some(LengthUnit::Millimeter)));
        assert_eq!(parse_unit("Stk."), Ok(None));
        assert!(parse_unit("ell").unwrap_err().contains("ell"));
    }
}
