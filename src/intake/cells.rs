//! The cells of an order list, as spreadsheets write them: numbers with a decimal comma or a word behind them, dates of
//! several countries, units by name.

use build_file::Unit;
use jiff::civil;
use unicode_normalization::UnicodeNormalization;

use super::ticket::due;
use crate::intake::Due;

/// Words behind a number of copies.
const PIECES: [&str; 22] = [
    "x", "×", "pcs", "pc", "pce", "pieces", "ea", "off", "stk", "stck", "stück", "st", "pz", "uds", "ud", "szt", "ks",
    "шт", "個", "本", "枚", "件",
];

/// Full-width figures and signs of East Asian keyboards are those of everybody.
fn plain(cell: &str) -> String {
    cell.nfkc().collect::<String>().trim().to_lowercase()
}

/// A whole number: `10`, `10 Stk.`, `x10`, `10,00`.
pub(super) fn whole(word: &str, cell: &str) -> Result<i64, String> {
    let text = plain(cell);
    let bare = text.trim_end_matches('.').trim_start_matches(['x', '×']).trim();
    let bare = PIECES.iter().filter_map(|piece| bare.strip_suffix(piece)).min_by_key(|rest| rest.len()).unwrap_or(bare);
    // Spreadsheets write 10.0 and 10,00; three noughts would be thousands.
    let is_noughts = |tail: &str| (1..=2).contains(&tail.len()) && tail.bytes().all(|b| b == b'0');
    let bare = bare.trim();
    let bare = bare.rsplit_once(['.', ',']).filter(|(_, tail)| is_noughts(tail)).map_or(bare, |(head, _)| head);
    bare.parse::<i64>().map_err(|_| format!("{word} = {cell:?} is no whole number"))
}

/// A number with a decimal point or comma, perhaps with mm behind it.
pub(super) fn decimal(word: &str, cell: &str) -> Result<f64, String> {
    let text = plain(cell);
    let bare = text.strip_suffix("mm").unwrap_or(&text).trim();
    let number = bare.replacen(',', ".", 1).parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("{word} = {cell:?} is no number"))
}

/// The unit of a file; what pieces are sold in says nothing about it.
pub(super) fn unit(cell: &str) -> Result<Option<Unit>, String> {
    let text = plain(cell);
    let text = text.trim_end_matches('.');
    if PIECES.contains(&text) {
        return Ok(None);
    }
    Ok(Some(match text {
        "µm" | "μm" | "um" | "micron" | "microns" | "micrometer" => Unit::Micron,
        "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" | "millimètre" | "milímetro"
        | "millimetro" | "ミリ" => Unit::Millimeter,
        "cm" | "centimeter" | "centimetre" | "zentimeter" | "centimètre" | "centímetro" | "centimetro" => {
            Unit::Centimeter
        }
        "in" | "inch" | "inches" | "\"" | "zoll" | "pouce" | "pouces" | "pulgada" | "pulgadas" | "pollice"
        | "pollici" | "インチ" => Unit::Inch,
        "ft" | "foot" | "feet" | "fuß" | "fuss" => Unit::Foot,
        "m" | "meter" | "metre" | "mètre" | "metro" => Unit::Meter,
        _ => return Err(format!("unit = {cell:?}; it must be micron, mm, cm, inch, foot or m")),
    }))
}

/// A due date as tickets say it, or day before month before year as most of the world writes it, perhaps with a time.
pub(super) fn due_date(cell: &str) -> Result<Due, String> {
    let text = plain(cell).replace(['年', '月'], "-").replace('日', "").replace(". ", ".");
    let as_ticket = due(&text.to_uppercase());
    if as_ticket.is_ok() {
        return as_ticket;
    }
    let (day, time) = text.split_once([' ', 't']).unwrap_or((&text, ""));
    let day = civil_date(day.trim_end_matches('.')).map_err(|why| format!("due = {cell:?}{why}"))?;
    match time.trim() {
        "" => due(&day.to_string()),
        time => due(&format!("{day}T{time:0>5}")),
    }
    .map_err(|_| format!("due = {cell:?}{NO_DATE}"))
}

const NO_DATE: &str = "; it must be a date such as 2026-11-25 or 25.11.2026, perhaps with a time such as 17:00";

fn civil_date(text: &str) -> Result<civil::Date, String> {
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
        for cell in
            ["10", " 10 ", "10.0", "10,00", "10 Stk.", "10x", "x10", "× 10", "10 pcs", "１０", "10個", "10 Stück"]
        {
            assert_eq!(whole("copies", cell), Ok(10), "{cell}");
        }
        for cell in ["1.000", "1,5", "ten", "", "10 boxes", "1e1"] {
            assert!(whole("copies", cell).unwrap_err().contains("no whole number"), "{cell}");
        }
        assert_eq!(decimal("clearance", "2,5"), Ok(2.5));
        assert_eq!(decimal("clearance", "2.5 mm"), Ok(2.5));
        assert!(decimal("clearance", "wide").is_err());
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
            assert_eq!(due_date(cell), due("2026-11-25"), "{cell}");
        }
        assert_eq!(due_date("25.11.2026 17:00"), due("2026-11-25T17:00"));
        assert_eq!(due_date("25.11.2026 9:30"), due("2026-11-25T09:30"));
        assert_eq!(due_date("2026-11-25T17:00:00Z"), due("2026-11-25T17:00:00Z"));
        assert!(due_date("05/06/2026").unwrap_err().contains("two dates"));
        for cell in ["soon", "32.11.2026", "25.11", "2026-13-01", "25.11.2026.1"] {
            assert!(
                due_date(cell).unwrap_err().contains("such as 25")
                    || due_date(cell).unwrap_err().contains("25.11.2026"),
                "{cell}"
            );
        }
    }

    #[test]
    fn units_are_known_by_their_names() {
        assert_eq!(unit("Zoll"), Ok(Some(Unit::Inch)));
        assert_eq!(unit("mm"), Ok(Some(Unit::Millimeter)));
        assert_eq!(unit("Stk."), Ok(None));
        assert!(unit("ell").unwrap_err().contains("ell"));
    }
}
