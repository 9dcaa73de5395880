//! Decodes text files that people made with a spreadsheet or an editor: UTF-8, UTF-16, or one of the code pages of
//! Windows, DOS, Macs and East Asia. The file itself does not say which code page it uses. The names of the files in
//! the same folder show which decoding is right.

use chardetng::{EncodingDetector, Iso2022JpDetection, Utf8Detection};
use encoding_rs::{
    BIG5, EUC_JP, EUC_KR, Encoding, GB18030, IBM866, MACINTOSH, SHIFT_JIS, UTF_16BE, UTF_16LE, WINDOWS_1250,
    WINDOWS_1251, WINDOWS_1252, WINDOWS_1253, WINDOWS_1254, WINDOWS_1257,
};

/// Code pages that are tried after the most likely one. `encoding_rs` has the encodings of the web, which do not
/// include those of DOS.
const CODE_PAGES: [&Encoding; 13] = [
    WINDOWS_1252,
    WINDOWS_1250,
    SHIFT_JIS,
    GB18030,
    BIG5,
    EUC_KR,
    EUC_JP,
    WINDOWS_1251,
    IBM866,
    MACINTOSH,
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

/// The possible decodings of a file, the most likely first. Only one where the encoding is certain.
pub(super) fn decode_candidates(bytes: &[u8]) -> Vec<String> {
    if let Some((encoding, mark_bytes)) = Encoding::for_bom(bytes) {
        return vec![encoding.decode_without_bom_handling(&bytes[mark_bytes..]).0.into_owned()];
    }
    if let Some(encoding) = detect_utf16(bytes) {
        return vec![encoding.decode_without_bom_handling(bytes).0.into_owned()];
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        return vec![text.to_owned()];
    }
    let mut detector = EncodingDetector::new(Iso2022JpDetection::Deny);
    detector.feed(bytes, true);
    let likely = detector.guess(None, Utf8Detection::Deny);
    let mut readings: Vec<String> = Vec::new();
    let pages = [likely].into_iter().chain(CODE_PAGES.into_iter().filter(|&page| page != likely));
    let read =
        |page: &'static Encoding| Some(page.decode_without_bom_handling_and_without_replacement(bytes)?.into_owned());
    let dos = DOS_PAGES.iter().map(|page| decode_dos(bytes, page));
    for reading in pages.filter_map(read).chain(dos) {
        if !readings.contains(&reading) {
            readings.push(reading);
        }
    }
    readings
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
            assert_eq!(decode_candidates(&bytes), [TEXT], "{bytes:?}");
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
                decode_candidates(bytes).iter().any(|reading| reading == text),
                "{text}: {:?}",
                decode_candidates(bytes)
            );
        }
    }

    #[test]
    fn a_dos_page_has_a_character_for_each_byte() {
        assert!(DOS_PAGES.iter().all(|page| page.chars().count() == 128));
    }
}
