//! Sizes in file names: threads, diameters, standards and dimensions in the words of customers' trades. A number with a
//! multiplication sign behind a size (`M3 x 20`, `d40 x2`, `40x20 x3`) may be its next dimension, so it is no clear number
//! of copies.

use super::copies_words::{NameWord, is_digits, is_numbering_word};

/// Letters before the number of a size that may go on with another: threads, diameters, modules, standards, wire gauges.
const SIZE_PREFIXES: &str = "m м mf mj d ø φ ⌀ da di de do dia diam diameter durchmesser diamètre diametre diametro diámetro średnica \
                             od id phi pcd dn nps g gf bsp bspp bspt bsw bsf npt unc unf unef un tr tm rd pg kf din iso en ansi asme \
                             jis gost fi nema awg swg sw tx torx ph pz mod modul module modulo módulo gt htd mxl xl at f led vis schraube \
                             直径 外径 内径 径 孔径 螺纹 モジュール ねじ ネジ 模数 丝杠";
/// Bodies whose numbers name things of several sizes.
const STANDARDS: &str = "din iso en ansi asme jis gost";
/// Letters before a length, a width, a height or a thickness. Behind another size they complete it; alone, only a number of
/// two digits is one, because `L2` and `H2` name things.
const LENGTH_PREFIXES: &str = "b l h w t s r lg len length länge laenge longueur lunghezza largo longitud lengte długość dl breite \
                               width largeur larghezza ancho breedte höhe height hauteur altezza alto hoogte thk thick thickness wall \
                               wand wandstärke dicke ep épaisseur epaisseur paroi spessore sp espesor grosor pared dikte grubość gr \
                               radius rayon raggio radio 長さ 幅 高さ 厚さ 厚み 板厚 肉厚 长度 厚度 壁厚 宽度 高度";
/// Units behind the number of a size.
const UNITS: &str = "mm cm dm m µm um μm mm2 qmm in inch inches zoll pouce pouces pollici pulgadas cal ft mil mils thou deg grad ° awg \
                     swg ga gauge unc unf unef bsp bspp bspt npt er ミリ 毫米 ㎜";
/// What of a thing has the size, behind its number and unit: `25OD`, `8mmID`.
const SIDES: [&str; 6] = ["od", "id", "diam", "dia", "da", "di"];
/// Letters of fits, between the number of a diameter and a grade: `12h6`, `10H7`.
const FITS: &str = "efghjkmnprs";
/// Grades and coatings that stand between a thread and its length.
const GRADES: &str = "a2 a4 v2a v4a zn vz inox";
/// Numbers of four and more digits that are sizes: aluminium profiles and cells. Others are numbers of parts or orders.
const SIZE_NUMBERS: &str = "2020 2040 2060 2080 3030 3060 4040 4080 4545 14500 16340 18650 21700 26650";
/// First digits of the four that name a deep-groove ball bearing.
const BEARING_SERIES: [&str; 4] = ["60", "62", "63", "68"];
/// Shields of bearings.
const BEARING_SHIELDS: [&str; 7] = ["zz", "2z", "2rs", "rs", "2rsr", "rsr", "uu"];
/// A number of more digits is one of a part, an order or a year.
const MAX_DIGITS: usize = 3;
/// A plain number of more digits before `x 4` is no dimension.
const MAX_DIGITS_OF_DIMENSION: usize = 4;
/// A size of more dimensions cannot go on.
const MAX_DIMENSIONS: usize = 3;

/// Whether the words before `at` end in a size which the number at `at` may continue. Brackets, a comma or a dash between
/// blanks separate the number from the size.
pub(super) fn continues_size(words: &[NameWord], at: usize) -> bool {
    let is_separated = is_separating(&words[at].gap);
    let is_grade = |word: &NameWord| is_listed(GRADES, &word.text);
    let skipped = at.checked_sub(1).filter(|&before| is_grade(&words[before])).unwrap_or(at);
    skipped.checked_sub(1).is_some_and(|before| !is_separated && is_open_size(words, before))
}

/// Whether any word before `at` holds a number that may be a size, as in `M5 brass x 12`: with blanks around its sign, the number
/// at `at` may be the next dimension. Signs separate them, and versions and numbers of things are no sizes.
pub(super) fn follows_any_size(words: &[NameWord], at: usize) -> bool {
    for before in (0..at).rev() {
        if is_separating(&words[before + 1].gap) {
            return false;
        }
        let is_version = ["v", "ver", "version", "rev"]
            .iter()
            .any(|word| words[before].text.strip_prefix(word).is_some_and(is_digits));
        if words[before].text.contains(|c: char| c.is_ascii_digit())
            && !is_version
            && !is_number_of_thing(words, before)
        {
            return true;
        }
    }
    false
}

/// Whether the word at `at`, behind a leading `6x`, makes a size of it, as in `6x 8mm rod`. A thread (`4x M3x20`) does not.
pub(super) fn completes_size(words: &[NameWord], at: usize) -> bool {
    let word = &words[at];
    let dimensions: Vec<&str> = word.text.split(['x', '×']).collect();
    let is_measure = dimensions.iter().all(|one| split_unit(one).is_some_and(|(number, _)| is_short(number)));
    !is_separating(&word.gap) && dimensions.len() < MAX_DIMENSIONS && is_measure
}

fn is_separating(gap: &str) -> bool {
    gap.contains(['(', '[', '{', '【', '「', ')', ']', '}', '】', '」', ',', '、', ';', '+', '|'])
        || [" - ", " – ", " — "].iter().any(|dash| gap.contains(dash))
}

pub(super) fn is_listed(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|known| known == word)
}

/// Whether a word is the number of a size by itself, such as that of a cell.
pub(super) fn is_size_number(word: &str) -> bool {
    is_listed(SIZE_NUMBERS, word)
}

fn is_number(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit())
        && text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b','))
}

fn is_short(number: &str) -> bool {
    !is_digits(number) || number.len() <= MAX_DIGITS
}

/// Splits `8mm` into its number and its unit, which may be empty, or a fit.
fn split_unit(text: &str) -> Option<(&str, &str)> {
    let (number, unit) =
        text.split_at(text.bytes().take_while(|b| b.is_ascii_digit() || matches!(b, b'.' | b',')).count());
    let bare = SIDES.iter().find_map(|side| unit.strip_suffix(side)).unwrap_or(unit);
    let is_fit = unit.strip_prefix(|c| FITS.contains(c)).is_some_and(is_digits);
    (is_number(number) && (bare.is_empty() || is_listed(UNITS, bare) || is_fit)).then_some((number, unit))
}

/// Whether a plain number is that of a part, an order or a version, which is no dimension: `No 5`, `100234`.
pub(super) fn is_number_of_thing(words: &[NameWord], at: usize) -> bool {
    let is_long = words[at].number().is_some_and(|number| number.len() > MAX_DIGITS_OF_DIMENSION);
    is_long || words[at].number().is_some() && at > 0 && is_numbering_word(&words[at - 1].text)
}

/// Splits `d40` into its prefix and its number. Letters of Japanese and Chinese before a Latin prefix belong to another word.
fn split_prefix(text: &str) -> Option<(&str, &str)> {
    let letters = text.find(|c: char| c.is_ascii_digit())?;
    let (prefix, number) = text.split_at(letters);
    let is_east_asian = |c: char| c >= '\u{2e80}';
    let own = match prefix.rfind(is_east_asian) {
        Some(last) => prefix[last..].trim_start_matches(is_east_asian),
        None => prefix,
    };
    let known = |prefix: &&str| is_listed(SIZE_PREFIXES, prefix) || is_listed(LENGTH_PREFIXES, prefix);
    let by_end = || {
        let starts = prefix.char_indices().map(|(at, _)| &prefix[at..]);
        starts.filter(|end| end.starts_with(is_east_asian)).find(known)
    };
    let own = Some(own).filter(known).or_else(by_end)?;
    let number = split_unit(number).map(|(number, _)| number)?;
    Some((own, number))
}

fn is_open_size(words: &[NameWord], at: usize) -> bool {
    let word = &words[at];
    let earlier = at.checked_sub(1).map(|at| &words[at]);
    let dimensions: Vec<&str> = word.text.split(['x', '×']).collect();
    if let [first, second] = dimensions[..] {
        return is_open_pair(first, second);
    }
    if dimensions.len() > 1 {
        return dimensions.len() < MAX_DIMENSIONS && dimensions.iter().all(|one| is_number(one));
    }
    if let Some((prefix, number)) = split_prefix(&word.text) {
        let is_length = is_listed(LENGTH_PREFIXES, prefix);
        let completes = is_length && earlier.is_some_and(|word| split_prefix(&word.text).is_some());
        return !completes && (!is_length || prefix.chars().count() > 1 || number.len() > 1);
    }
    if is_bearing(&word.text) || is_size_number(&word.text) {
        return true;
    }
    // `ISO 4762`
    if word.number().is_some() && earlier.is_some_and(|word| is_listed(STANDARDS, &word.text)) {
        return true;
    }
    match split_unit(&word.text) {
        // The number of a version or of a file manager's copy.
        Some(_) if earlier.is_some_and(|word| is_numbering_word(&word.text)) => false,
        // `4711-02` is the number of a part.
        Some(_) if word.gap == "-" && earlier.is_some_and(|word| word.number().is_some_and(|n| !is_short(n))) => false,
        // A thickness, a gap or a layer below a unit is not the first of several dimensions.
        Some((number, unit)) => is_short(number) && (unit.is_empty() || !number.starts_with("0")),
        // `40 mm x 3`, `6005-2RS x2`
        None => is_unit_or_shield(&word.text) && earlier.is_some_and(|word| is_number(&word.text)),
    }
}

/// `40x20` and `M8x1.25` may go on; `M8x40` is a thread with its length, `D30xB12` a diameter with its width.
fn is_open_pair(first: &str, second: &str) -> bool {
    let number = |text: &str| text.replace(',', ".").parse::<f64>().unwrap_or(f64::NAN);
    let second_number = split_unit(second).map(|(second, _)| second);
    match (split_unit(first), split_prefix(first), second_number) {
        (Some(_), _, Some(_)) => true,
        (_, Some(("m" | "mf" | "tr", size)), Some(next)) => number(next) < number(size),
        (_, Some(_), next) => next.is_some(),
        _ => false,
    }
}

fn is_unit_or_shield(word: &str) -> bool {
    is_listed(UNITS, word) || BEARING_SHIELDS.contains(&word)
}

/// `608zz`, `6204`, `6204-2rs`
fn is_bearing(word: &str) -> bool {
    let number = BEARING_SHIELDS.iter().find_map(|shield| word.strip_suffix(shield)).unwrap_or(word);
    let is_series = BEARING_SERIES.iter().any(|series| number.starts_with(series));
    is_digits(number) && is_series && (3..=4).contains(&number.len())
}
