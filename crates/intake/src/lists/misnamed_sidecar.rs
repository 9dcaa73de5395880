//! Tickets that lost their name on the way: browsers, file managers and sync programs number and mark a second file, and people
//! write a ticket's name in their own way. nestd reads none of them as a ticket, and prints no part without what they may say.

use std::{collections::HashSet, ffi::OsStr, path::Path};

use crate::{
    folder::file_role::is_other_text,
    names::{copy_name::read_copy_name, name::is_part_name, name_match::fold_name},
};

/// Extensions of tickets.
const TICKET_ENDINGS: [&str; 2] = ["toml", "json"];
/// Extensions that programs add to such a name.
const ADDED_ENDINGS: [&str; 3] = ["lnk", "url", "webloc"];
/// Words for a ticket or what it says, behind the name of the part.
const TICKET_WORDS: [&str; 14] = [
    "ticket",
    "copies",
    "qty",
    "quantity",
    "order",
    "info",
    "kopien",
    "anzahl",
    "stückzahl",
    "menge",
    "auftrag",
    "quantité",
    "個数",
    "数量",
];
/// No name has more endings and marks.
const MAX_ENDINGS: usize = 6;

/// The part that a file may be meant as a ticket of, by the letters and digits of its name: `plate` for `plate (1).stl.toml`,
/// `plate_stl.toml`, `plate.stl.toml - Copy` and `plate_ticket.txt`. `None` = its name is not like that of a ticket.
pub(crate) fn loose_part_name(sidecar: &Path) -> Option<String> {
    let mut name = fold_name(sidecar.file_name()?.to_str()?);
    let mut is_ticket = false;
    for _ in 0..MAX_ENDINGS {
        name.truncate(name.trim_end().len());
        let Some((stem, ending)) = name.rsplit_once('.') else { break };
        let ending = ending.trim();
        let is_text = TICKET_ENDINGS.contains(&ending) || is_other_text(Path::new(&name));
        is_ticket |= is_text;
        let shorter = match is_text || ADDED_ENDINGS.contains(&ending) {
            true => Some(stem.to_owned()),
            false => without_mark(&name),
        };
        match shorter {
            Some(shorter) => name = shorter,
            None => break,
        }
    }
    if let Some(shorter) = without_mark(&name).filter(|_| is_ticket) {
        name = shorter;
    }
    let bare = without_ticket_word(&name);
    let key = letters_of(if is_part_name(bare.as_ref()) { bare.rsplit_once('.')?.0 } else { bare });
    (is_ticket && !key.is_empty()).then_some(key)
}

/// The letters and digits of a part's name, without and with its extension: what [`loose_part_name`] is compared with.
pub(crate) fn letters_of_part(part: &Path) -> HashSet<String> {
    let name = |name: Option<&OsStr>| name.and_then(OsStr::to_str).map(|name| letters_of(&fold_name(name)));
    [name(part.file_stem()), name(part.file_name())].into_iter().flatten().filter(|key| !key.is_empty()).collect()
}

fn letters_of(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).collect()
}

/// The name without what file managers and sync programs add to that of a second file.
fn without_mark(name: &str) -> Option<String> {
    let (stem, ending) = name.rsplit_once('.').filter(|_| is_part_name(name.as_ref())).unwrap_or((name, ""));
    let original = read_copy_name(&format!("{stem}.stl"))?.original;
    let original = original.strip_suffix(".stl")?;
    Some(if ending.is_empty() { original.to_owned() } else { format!("{original}.{ending}") })
}

fn without_ticket_word(name: &str) -> &str {
    let before = TICKET_WORDS.iter().find_map(|word| name.strip_suffix(word));
    let bare = before.map(|before| before.trim_end_matches([' ', '_', '-', '.']));
    bare.filter(|bare| bare.len() < before.unwrap_or_default().len() && !bare.is_empty()).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ticket_with_a_name_of_its_own_is_known_by_its_letters() {
        for name in [
            "plate.stl (1).toml",
            "plate (1).stl.toml",
            "plate.stl - Copy.toml",
            "plate - Kopie.stl.toml",
            "plate_stl.toml",
            "plate stl.toml",
            "plate .toml",
            "plate.stl .toml",
            "plate.toml.toml",
            "plate.stl.toml.toml",
            "plate.json.json",
            "plate.3mf.toml",
            "plate.stl.sync-conflict-20260101-120000-ABCDEFG.toml",
            "plate.stl.toml (1)",
            "plate.stl.toml - Copy",
            "plate.stl.toml.lnk",
            "plate.tml",
            "plate.stl.json5",
            "plate_ticket.txt",
            "plate copies.txt",
            "Plate.STL.TOML.txt",
        ] {
            let loose = loose_part_name(Path::new(name)).unwrap_or_else(|| panic!("{name} is like no ticket"));
            assert!(letters_of_part(Path::new("plate.stl")).contains(&loose), "{name}: {loose}");
        }
    }

    #[test]
    fn other_names_are_like_no_ticket_of_the_part() {
        for name in [
            "plate.stl",
            "plate (1).stl",
            "plate.pdf",
            "plate.png",
            "plate2.toml",
            "plate left.toml",
            "lid.toml",
            ".toml",
            "plate.lnk",
            "toml",
        ] {
            let loose = loose_part_name(Path::new(name));
            assert!(loose.is_none_or(|loose| !letters_of_part(Path::new("plate.stl")).contains(&loose)), "{name}");
        }
    }
}
