//! Decodes text files that people made with a spreadsheet or an editor: UTF-8, UTF-16, or one of the code pages of
//! Windows, DOS, Macs and East Asia. The file itself does not say which code page it uses. The names of the files in
//! the same folder show which decoding is right.

use chardetng::{EncodingDetector, Iso2022JpDetection, Utf8Detection};
use encoding_rs::{
    BIG5, EUC_JP, EUC_KR, Encoding, GB18030, IBM866, ISO_8859_15, MACINTOSH, SHIFT_JIS, UTF_16BE, UTF_16LE,
    WINDOWS_1250, WINDOWS_1251, WINDOWS_1252, WINDOWS_1253, WINDOWS_1254, WINDOWS_1257,
};

/// Code pages that are tried after the most likely one and before those of DOS. That of the Mac is tried last, except for
/// files whose lines end as on old Macs. `encoding_rs` has the encodings of the web, which do not
/// include those of DOS.
const CODE_PAGES: [&Encoding; 13] = [
    WINDOWS_1252,
    ISO_8859_15,
    WINDOWS_1250,
    SHIFT_JIS,
    GB18030,
    BIG5,
    EUC_KR,
    EUC_JP,
    WINDOWS_1251,
    IBM866,
    WINDOWS_1253,
    WINDOWS_1254,
    WINDOWS_1257,
];
/// The characters of bytes 128 to 255 in DOS code pages: Western Europe (850), the United States (437), Central Europe
/// (852).
const DOS_PAGES: [&str; 3] = [
    "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜø£Ø×ƒáíóúñÑªº¿®¬½¼¡«»░▒▓│┤ÁÂÀ©╣║╗╝¢¥┐└┴┬├─┼ãÃ╚╔╩╦╠═╬¤ðÐÊËÈıÍÎÏ┘┌█▄¦Ì▀ÓßÔÒõÕµþÞÚÛÙýÝ¯´\u{ad}±‗¾¶§÷¸°¨·¹³²■\u{a0}",
    "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒáíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐└┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌█▄▌▐▀αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u{a0}",
    "ÇüéâäůćçłëŐőîŹÄĆÉĹĺôöĽľŚśÖÜŤťŁ×čáíóúĄąŽžĘę¬źČş«»░▒▓│┤ÁÂĚŞ╣║╗╝Żż┐└┴┬├─┼Ăă╚╔╩╦╠═╬¤đĐĎËďŇÍÎě┘┌█▄ŢŮ▀ÓßÔŃńňŠšŔÚŕŰýÝţ´\u{ad}˝˛ˇ˘§÷¸°¨˙űŘř■\u{a0}",
];

/// How the bytes of a text are its characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CodePage {
    /// Certain: UTF-8 or UTF-16.
    Unicode,
    /// A code page that the web knows.
    OfWeb(&'static Encoding),
    /// A code page of DOS, by its upper characters.
    OfDos(&'static str),
}

impl CodePage {
    /// Decodes bytes that stand in this code page. `None` if they cannot.
    pub fn decode(self, bytes: &[u8]) -> Option<String> {
        match self {
            Self::Unicode => std::str::from_utf8(bytes).ok().map(str::to_owned),
            Self::OfWeb(page) => Some(page.decode_without_bom_handling_and_without_replacement(bytes)?.into_owned()),
            Self::OfDos(page) => Some(decode_dos(bytes, page)),
        }
    }
}

/// A possible decoding of a file.
#[derive(Debug)]
pub(crate) struct Reading {
    pub text: String,
    pub page: CodePage,
}

/// The possible decodings of a file, the most likely first. Only one where the encoding is certain.
pub(crate) fn decode_candidates(bytes: &[u8]) -> Vec<Reading> {
    let certain = |text: String| vec![Reading { text, page: CodePage::Unicode }];
    if let Some((encoding, mark_bytes)) = Encoding::for_bom(bytes) {
        return certain(encoding.decode_without_bom_handling(&bytes[mark_bytes..]).0.into_owned());
    }
    if let Some(encoding) = detect_utf16(bytes) {
        return certain(encoding.decode_without_bom_handling(bytes).0.into_owned());
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        return certain(text.to_owned());
    }
    let mut detector = EncodingDetector::new(Iso2022JpDetection::Deny);
    detector.feed(bytes, true);
    let likely = detector.guess(None, Utf8Detection::Deny);
    let mut readings: Vec<Reading> = Vec::new();
    let is_of_mac = bytes.contains(&b'\r') && !bytes.contains(&b'\n');
    let (before, after) = if is_of_mac { (Some(MACINTOSH), None) } else { (None, Some(MACINTOSH)) };
    let pages = before.into_iter().chain([likely]).chain(CODE_PAGES.into_iter().filter(|&page| page != likely));
    let pages = pages.map(CodePage::OfWeb).chain(DOS_PAGES.map(CodePage::OfDos)).chain(after.map(CodePage::OfWeb));
    for page in pages {
        let Some(text) = page.decode(bytes).filter(|text| readings.iter().all(|known| known.text != *text)) else {
            continue;
        };
        readings.push(Reading { text, page });
    }
    readings
}

/// The text of a name in the code pages of DOS, which programs for Windows write into archives. `None` = it is UTF-8, or looks more
/// like a text in another code page. What a list in another code page names has these bytes, and is found by them.
pub(crate) fn decode_dos_name(name: &[u8]) -> Option<String> {
    let mut readings = decode_candidates(name);
    let best = (0..readings.len()).rev().max_by_key(|&at| text_plausibility(&readings[at].text))?;
    let best = readings.swap_remove(best);
    matches!(best.page, CodePage::OfDos(_)).then_some(best.text)
}

/// Detects UTF-16 without a byte order mark: most characters in tables are ASCII, so every second byte is 0.
fn detect_utf16(bytes: &[u8]) -> Option<&'static Encoding> {
    let head = &bytes[..bytes.len().min(4096) & !1];
    let zeros = |odd: usize| head.iter().skip(odd).step_by(2).filter(|&&byte| byte == 0).count();
    let most = |zeros: usize| head.len() >= 4 && bytes.len().is_multiple_of(2) && zeros * 4 >= head.len();
    match (zeros(0), zeros(1)) {
        (0, odd) if most(odd) => Some(UTF_16LE),
        (even, 0) if most(even) => Some(UTF_16BE),
        _ => None,
    }
}

fn decode_dos(bytes: &[u8], page: &str) -> String {
    let upper: Vec<char> = page.chars().collect();
    let char_of = |&byte: &u8| match byte {
        0..128 => char::from(byte),
        _ => upper.get(usize::from(byte) - 128).copied().unwrap_or(char::REPLACEMENT_CHARACTER),
    };
    bytes.iter().map(char_of).collect()
}

/// Letters of Western European texts.
const WESTERN: &str = "äöüÄÖÜßéèêëàâçîïôûùÿÉÈÊÀÂÇÎÔÛœŒñÑáíóúìòåÅæÆøØ";

/// How much a decoding looks like text that somebody wrote: letters of Western Europe and kana count for it, signs that
/// only a wrong code page puts into words count against it.
pub(crate) fn text_plausibility(text: &str) -> i64 {
    let is_kana = |c: char| matches!(c, '\u{3040}'..='\u{30ff}' | '\u{3001}'..='\u{301f}' | '\u{ff01}'..='\u{ff5e}');
    let has_kana = text.chars().any(is_kana);
    let chars: Vec<char> = text.chars().collect();
    let rate = |(at, &c): (usize, &char)| {
        let before = at.checked_sub(1).map(|at| chars[at]).filter(|c| c.is_alphabetic());
        let is_followed_by_lower = chars.get(at + 1).is_some_and(|c| c.is_lowercase());
        let is_case_odd =
            c.is_uppercase() && before.is_some_and(|before| before.is_lowercase() || is_followed_by_lower);
        let after = chars.get(at + 1).copied();
        let is_inside = before.is_some() && after.is_some_and(char::is_alphabetic);
        let is_accent = |c: char| !c.is_ascii() && c != 'ß' && WESTERN.contains(c) && c.is_alphabetic();
        match c {
            c if c.is_ascii() => 0,
            // `“` inside a word and two accents in a row are rare, except in créé.
            '–' | '—' | '“' | '”' | '„' | '‘' | '’' | '«' | '»' | '…' | '€' => {
                -i64::from(is_inside && c != '’')
            }
            c if is_accent(c) && before.is_some_and(|before| is_accent(before) && before != c) => -2,
            c if is_case_odd => -3 * i64::from(c < '\u{250}'),
            c if WESTERN.contains(c) || is_kana(c) => 1,
            '\u{4e00}'..='\u{9fff}' => i64::from(has_kana),
            c if c.is_alphanumeric() => 0,
            '\u{80}'..='\u{9f}' | '\u{2500}'..='\u{25ff}' => -3,
            _ => -i64::from(before.is_some()),
        }
    };
    chars.iter().enumerate().map(rate).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "Datei;St\u{fc}ck\r\nGr\u{f6}\u{df}e.stl;3\r\n";

    #[test]
    fn text_with_a_mark_and_plain_utf_8_are_read_one_way() {
        let utf16 = |to_bytes: fn(u16) -> [u8; 2]| TEXT.encode_utf16().flat_map(to_bytes).collect::<Vec<u8>>();
        let (little, big) = (utf16(u16::to_le_bytes), utf16(u16::to_be_bytes));
        let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
        for bytes in [
            TEXT.as_bytes().to_vec(),
            marked(b"\xef\xbb\xbf", TEXT.as_bytes()),
            marked(b"\xff\xfe", &little),
            marked(b"\xfe\xff", &big),
            little,
            big,
        ] {
            let texts: Vec<String> = decode_candidates(&bytes).into_iter().map(|reading| reading.text).collect();
            assert_eq!(texts, [TEXT], "{bytes:?}");
        }
    }

    #[test]
    fn every_code_page_is_among_the_readings() {
        for (bytes, text) in [
            (&b"Gr\xf6\xdfe"[..], "Gr\u{f6}\u{df}e"),
            (b"Gr\x94\xe1e", "Gr\u{f6}\u{df}e"),
            (b"Gr\x9a\xa7e", "Gr\u{f6}\u{df}e"),
            (b"\x95\x94\x95i", "\u{90e8}\u{54c1}"),
            (b"\x8d\xa1", "\u{ec}\u{ed}"),
        ] {
            assert!(
                decode_candidates(bytes).iter().any(|reading| reading.text == text),
                "{text}: {:?}",
                decode_candidates(bytes)
            );
        }
    }

    #[test]
    fn names_of_dos_are_told_from_those_of_other_code_pages() {
        for (name, text) in [
            (&b"Geh\x84use.stl"[..], Some("Gehäuse.stl")),
            (b"Gr\x94\xe1e \x81ber.stl", Some("Größe über.stl")),
            (b"pi\x8ace.stl", Some("pièce.stl")),
            (b"\x99se.stl", Some("Öse.stl")),
            (b"Geh\xe4use.stl", None),
            (b"Gr\xf6\xdfe.stl", None),
            (b"pi\xe8ce.stl", None),
            (b"\x83u\x83\x89\x83P\x83b\x83g.stl", None),
            (b"\x95\x94\x95i.stl", None),
            ("Gehäuse.stl".as_bytes(), None),
            (b"a.stl", None),
        ] {
            assert_eq!(decode_dos_name(name).as_deref(), text, "{}", String::from_utf8_lossy(name));
        }
    }

    #[test]
    fn a_dos_page_has_a_character_for_each_byte() {
        assert!(DOS_PAGES.iter().all(|page| page.chars().count() == 128));
    }
}
