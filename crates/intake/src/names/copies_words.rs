//! Splits a file name into the words that may say a number of copies, and knows these words in the languages of
//! customers.

use unicode_normalization::UnicodeNormalization;

/// Words for pieces that may stand behind a number in any place: `4pcs`, `4 Stk`. Counters do so, too.
const PIECES: &str = "pcs nos no's pce pces pieces pièces pieces stk stck stück stueck kopien copies exemplare exemplaires szt sztuk sztuki pezzi piezas unidades uds \
                      stuks peças copias cópias kopii шт \
                      штук штуки штука экз adet tane darab бр броя τεμ τμχ τεμάχια styck gab vnt kusy kusov kusů unid unids pçs pç \
                      bucăți bucati יח יחידות قطع قطعة عدد नग ชิ้น exemplar exemplaren stücke stuecke egz cái buah biji";
/// Words that mean pieces behind a number only at the start or the end of a name: `4 off`, but not `4 off axis`.
const PIECES_AT_EDGES: &str = "off ea each ex exempl mal fois times volte veces keer razy units unités unità pz pza pzas ud und un \
                               ks kpl stuk kom kos buc tk ad je copie";
/// Words for pieces that mean a factor beside a word for a scale: `2 times bigger`.
pub(super) const TIMES: [&str; 7] = ["times", "mal", "fois", "veces", "volte", "keer", "razy"];
/// Words before which a word for pieces has another meaning: `10 off axis`, `5 ex libris`.
pub(super) const PHRASE_ENDS: [&str; 5] = ["axis", "road", "grid", "libris", "plus"];
/// Words before a number of pieces that something is made for.
pub(super) const HOLDS: [&str; 12] =
    ["for", "für", "fuer", "pour", "para", "per", "voor", "dla", "för", "для", "holds", "fasst"];
/// Suffixes that mean pieces only where they are attached to the number: `4pc`, but not `4 PC` (polycarbonate).
const ATTACHED_PIECES: &str = "pc st";
/// Words for a number of pieces that stand before it: `qty 4`.
const BEFORE_NUMBER: &str = "qty qté qte quantity quantité quantite anzahl anz menge stückzahl stueckzahl stk stck stück stueck \
                             pcs pieces pièces copies kopien exemplaires nb nbr nbre nombre qtd qtde quantità quantita qta cantidad cant quantidade aantal antal ilość ilosc szt pezzi pz piezas uds stuks 数量 件数 個数 部数 枚数 数 n \
                             кол количество число adet darab 수량 개수";
/// Those of them that say a number of copies even if no number is beside them.
const WANTS_NUMBER: &str = "qty qté qte quantity quantité quantite anzahl anz stückzahl stueckzahl quantità quantita cantidad aantal ilość ilosc 数量 個数 部数 枚数 件数 количество 수량";
/// Words that behind a number may mean copies or something else: `4-fach` may be a socket for four plugs.
const MAYBE_PIECES: &str = "ピース 部 套 stuck fach fold set sets pk pack packs pair pairs paar paare paire paires prints count teile parts pc st drucken imprimer required req req'd reqd needed benötigt nötig セット 組 \
                             db 세트 комплект комплекта dozen dozens dutzend dtzd dz douzaine douzaines docena docenas dozzina dozzine dúzia dúzias \
                            tucet дюжина дюжины sätze saetze satz jeu jeux juego juegos";
/// Words before which a number may be meant as copies: `please print 4`.
const ASKS: &str = "need needs please print make count amount brauche benötige bitte drucke drucken imprimer";
const GROUPS: &str = "set lot pack satz jeu";
const OF: &str = "of de von à";
/// Numbers in words, which are not read but recognised before a word for pieces.
const NUMBER_WORDS: &str = "two three four five six seven eight nine ten twelve zwei drei vier fünf fuenf sechs sieben acht neun \
                            zehn zwölf deux trois quatre cinq sept huit neuf dix douze";
const REPEATS: &str =
    "twice zweimal dreimal viermal fünfmal fuenfmal zehnmal doppelt zweifach dreifach vierfach fünffach zehnfach";
/// Words beside which `2x` is a factor: scales, optics, buses; and names of products that have an x and a number of their own.
const SCALES: &str = "scale scaled scaling scal skaliert skalierung massstab maßstab échelle echelle zoom mag magnification \
                      magnifier lupe loupe faktor factor facteur objective objektiv objectif barlow teleconverter telekonverter \
                      eyepiece ocular okular oculaire microscope mikroskop pci pcie riser nvme insta360 gopro bmw thinkpad fuji \
                      fujifilm poco sidewinder bambu bigger smaller larger größer groesser kleiner vergrößert verkleinert agrandi réduit";
/// Words that may follow `x4`: version, material, colour, state of the file.
const TAILS: &str = "v ver version rev revision final finale neu new nouveau kopie copy copie コピー のコピー date stl 3mf export \
                     print druck drucken imprimer fixed repaired repariert corrigé mm pa pa6 pa11 pa12 pa12gf tpu tpa pp abs pla petg asa pc \
                     nylon polyamid gf cf gb raw dyed bead blasted mat matt matte glossy natural natur black white grey gray red blue green yellow orange schwarz \
                     weiß weiss grau rot blau grün gruen gelb noir blanc gris rouge bleu vert jaune 黒 白 赤 青 灰 黄 緑";
/// Words before the number of a version or of a file manager's copy.
const NUMBERED: &str = "v ver version rev revision kopie copy copie コピー のコピー";
/// Words that end in x and may be followed by their own number: `matrix3`.
const ENDINGS_IN_X: [&str; 24] = [
    "box", "matrix", "flex", "helix", "hex", "index", "max", "mix", "fix", "vertex", "apex", "linux", "unix", "fax",
    "fox", "wax", "syntax", "plex", "latex", "gtx", "rtx", "vortex", "convex", "relax",
];
/// Characters that behind digits count pieces in Japanese, Chinese and Korean.
const COUNTERS: &str = "個枚本コヶケ点台つ件个份只片块颗粒개매장";
const CJK_NUMBERS: &str = "一二三四五六七八九十百";

/// Kind of a word list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WordKind {
    Pieces,
    PiecesAtEdge,
    AttachedPieces,
    WantsNumber,
    MaybePieces,
    Ask,
    Group,
    Of,
    NumberWord,
    Repeat,
    Scale,
}

/// Whether a word in lower case is of this kind.
pub(super) fn is_word_of(kind: WordKind, word: &str) -> bool {
    let words = match kind {
        WordKind::Pieces => PIECES,
        WordKind::PiecesAtEdge => PIECES_AT_EDGES,
        WordKind::AttachedPieces => ATTACHED_PIECES,
        WordKind::WantsNumber => WANTS_NUMBER,
        WordKind::MaybePieces => MAYBE_PIECES,
        WordKind::Ask => ASKS,
        WordKind::Group => GROUPS,
        WordKind::Of => OF,
        WordKind::NumberWord => NUMBER_WORDS,
        WordKind::Repeat => REPEATS,
        WordKind::Scale => SCALES,
    };
    let is_counter_word = || kind == WordKind::Pieces && word.chars().all(is_counter) && word.chars().count() == 1;
    words.split_whitespace().any(|known| known == word) || is_counter_word()
}

/// Whether a word in lower case means pieces behind a number.
pub(crate) fn is_word_for_pieces(word: &str) -> bool {
    [WordKind::Pieces, WordKind::AttachedPieces].into_iter().any(|kind| is_word_of(kind, word))
}

/// The word for a number of pieces at the end of these letters: all of them, or what Chinese and Japanese write behind a name
/// without a blank (支架数量).
pub(super) fn word_before_number(letters: &str) -> Option<&'static str> {
    let is_at_end = |known: &&str| {
        known.starts_with(|c: char| c >= '\u{2e80}') && letters.ends_with(*known) && known.chars().count() > 1
    };
    BEFORE_NUMBER.split_whitespace().find(|known| *known == letters || is_at_end(known))
}

/// A word of a name, in lower case, with the text between it and the word before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct NameWord {
    pub text: String,
    pub gap: String,
}

impl NameWord {
    /// The digits, if the word is a plain number.
    pub fn number(&self) -> Option<&str> {
        is_digits(&self.text).then_some(self.text.as_str())
    }
}

pub(crate) fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

/// The digits 0 of scripts that have their own; the other nine follow each. (Those of full width fold to ASCII.)
const ZEROS: [char; 17] = [
    '\u{660}', '\u{6f0}', '\u{966}', '\u{9e6}', '\u{a66}', '\u{ae6}', '\u{b66}', '\u{be6}', '\u{c66}', '\u{ce6}',
    '\u{d66}', '\u{e50}', '\u{ed0}', '\u{f20}', '\u{1040}', '\u{17e0}', '\u{1810}',
];

/// A digit of any script in ASCII, and what is written for a multiplication sign as that; other characters as they are.
fn plain_sign(c: char) -> char {
    let digit = |zero: char| (c as u32).checked_sub(zero as u32).and_then(|digit| char::from_digit(digit, 10));
    match c {
        '*' | '✕' | '✖' | '✗' | '⨯' | '∗' => '×',
        c => ZEROS.into_iter().find_map(digit).unwrap_or(c),
    }
}

/// Splits a name (without its extension) into words. Decimal numbers and sizes such as `10x20` stay in one word; a
/// multiplication sign and an East Asian counter begin a word of their own.
pub(super) fn split_name_words(stem: &str) -> Vec<NameWord> {
    let text: String = stem.nfkc().flat_map(char::to_lowercase).map(plain_sign).collect();
    let chars: Vec<char> = latin_times(&replace_dates(&text))
        .replace("кол-во", "кол")
        .replace("q.ty", "qty")
        .replace("q'ty", "qty")
        .replace("q’ty", "qty")
        .replace("q.tà", "qta")
        .chars()
        .collect();
    let mut words: Vec<NameWord> = Vec::new();
    let mut gap = String::new();
    let mut is_open = false;
    for (at, &c) in chars.iter().enumerate() {
        let before = at.checked_sub(1).map(|at| chars[at]);
        let after = chars.get(at + 1).copied();
        let is_decimal = matches!(c, '.' | ',') && is_digit(before) && is_digit(after);
        if !(c.is_alphanumeric() || c == '×' || c == '\'' || is_decimal || is_mark(c)) {
            gap.push(c);
            is_open = false;
            continue;
        }
        match words.last_mut().filter(|_| is_open && !begins_word(before, &chars[at..])) {
            Some(word) => word.text.push(c),
            None => words.push(NameWord { text: c.to_string(), gap: std::mem::take(&mut gap) }),
        }
        is_open = true;
    }
    words
}

/// The Cyrillic х or Greek χ that stands for a multiplication sign, as in `х4`, `4х` and ` х 4`, becomes the Latin x of other names.
fn latin_times(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let near = |at: Option<usize>| at.and_then(|at| chars.get(at).copied());
    let stands_for_times = |at: usize| {
        let (before, after) = (near(at.checked_sub(1)), near(Some(at + 1)));
        let is_letter = |c: Option<char>| c.is_some_and(char::is_alphabetic);
        is_digit(after) && !is_letter(before)
            || is_digit(before) && !is_letter(after)
            || !is_letter(before) && !is_letter(after)
    };
    chars
        .iter()
        .enumerate()
        .map(|(at, &c)| if matches!(c, 'х' | 'χ') && stands_for_times(at) { 'x' } else { c })
        .collect()
}

fn is_digit(c: Option<char>) -> bool {
    c.is_some_and(|c| c.is_ascii_digit())
}

/// Combining marks and the long-vowel sign belong to their word.
fn is_mark(c: char) -> bool {
    matches!(c, '\u{300}'..='\u{36f}' | '\u{3099}' | '\u{309a}' | 'ー' | '々')
}

/// Whether a new word begins here although no sign separates it from the one before.
fn begins_word(before: Option<char>, rest: &[char]) -> bool {
    let Some(before) = before else { return false };
    let is_east_asian = |c: char| c >= '\u{3000}' && (c.is_alphabetic() || is_mark(c));
    let digits = |from: usize| rest[from.min(rest.len())..].iter().take_while(|c| c.is_ascii_digit()).count();
    match rest[0] {
        '×' => !before.is_ascii_digit(),
        'x' => is_east_asian(before) && digits(1) > 0,
        c if c.is_ascii_digit() => {
            is_east_asian(before)
                && rest.get(digits(0)).is_some_and(|&c| is_counter(c) || c == '×' || c.is_ascii_alphabetic())
        }
        c => before == '×' && c.is_alphabetic(),
    }
}

pub(crate) fn is_counter(c: char) -> bool {
    COUNTERS.contains(c)
}

/// Whether a word is an East Asian number with a counter, such as 三個.
pub(super) fn is_east_asian_count(word: &str) -> bool {
    let mut chars = word.chars().rev();
    chars.next().is_some_and(is_counter) && chars.next().is_some_and(|c| CJK_NUMBERS.contains(c))
}

/// Replaces dates by a word, so that their numbers do not count anything.
fn replace_dates(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    while at < chars.len() {
        let starts = at == 0 || !chars[at - 1].is_ascii_digit();
        match [[4, 2, 2], [2, 2, 4]].iter().find_map(|widths| date_length(&chars[at..], *widths)).filter(|_| starts) {
            Some(length) => {
                out.push_str("date");
                at += length;
            }
            None => {
                out.push(chars[at]);
                at += 1;
            }
        }
    }
    out
}

/// Length of a date at the start of a text, made of three numbers of these widths.
fn date_length(chars: &[char], widths: [usize; 3]) -> Option<usize> {
    let mut at = 0;
    for (n, width) in widths.into_iter().enumerate() {
        if n > 0 {
            chars.get(at).filter(|c| matches!(c, '-' | '_' | '.'))?;
            at += 1;
        }
        if chars.len() < at + width || !chars[at..at + width].iter().all(char::is_ascii_digit) {
            return None;
        }
        at += width;
    }
    (!is_digit(chars.get(at).copied())).then_some(at)
}

/// Whether a word may follow the number of copies without giving it another meaning.
pub(super) fn is_tail_word(words: &[NameWord], at: usize) -> bool {
    let word = words[at].text.as_str();
    let is_numbered = |prefix: &str| {
        let rest = word.strip_prefix(prefix);
        rest.is_some_and(|rest| rest.chars().all(|c| c.is_ascii_digit() || c == '.') && !rest.is_empty())
    };
    let is_listed = |list: &str, word: &str| list.split_whitespace().any(|known| known == word);
    let is_version = ["v", "ver", "version", "rev", "r", "kopie", "copy"].into_iter().any(is_numbered)
        || word.strip_prefix("rev").is_some_and(|rest| rest.len() == 1);
    let is_size = ["mm", "cm", "µm", "um"].into_iter().filter_map(|unit| word.strip_suffix(unit)).any(|size| {
        size.starts_with(|c: char| c.is_ascii_digit())
            && size.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b','))
    });
    is_version
        || is_size
        || is_listed(TAILS, word)
        // A long number is a date or the number of an order.
        || (words[at].number().is_some()
            && (word.len() >= 4 || at.checked_sub(1).is_some_and(|at| is_listed(NUMBERED, &words[at].text))))
}

/// Whether the number behind this word is that of a version, a copy of a file, a part or an order.
pub(super) fn is_numbering_word(word: &str) -> bool {
    NUMBERED
        .split_whitespace()
        .chain(["nr", "no", "pos", "part", "teil", "pièce", "piece", "order", "auftrag", "commande"])
        .any(|known| known == word)
}

/// Whether these letters are a word of their own that ends in x.
pub(super) fn ends_in_own_x(letters: &str) -> bool {
    ENDINGS_IN_X.iter().any(|ending| letters.ends_with(ending))
}

/// This many words from one on, as they stand in the name.
pub(super) fn shown_words(words: &[NameWord], at: usize, length: usize) -> String {
    let mut text = words[at].text.clone();
    for word in &words[at + 1..at + length] {
        text.push_str(&word.gap);
        text.push_str(&word.text);
    }
    text
}
