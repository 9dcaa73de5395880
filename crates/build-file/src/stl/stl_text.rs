//! A tolerant reader for ASCII STL: any white space, line end and case, several solids, comments, lines of any length.
//!
//! `stl_io` refuses unnamed, upper-case and CR-only files, stops after the first solid and reads in f32. So this
//! tokenizer reads all ASCII files.

use std::io::{self, BufRead};

use glam::DVec3;

use crate::{
    FileReadError, ReadLimits,
    common::{decimal::parse_decimal, unfinished::unfinished_copy},
};

/// Longer words cannot be numbers or keywords. The limit keeps an endless word out of memory.
const MAX_WORD: usize = 256;

/// Length of an unexpected word in an error message; binary data would fill a page.
const MAX_EXCERPT: usize = 40;

/// What an ASCII STL file holds beside its facets.
#[derive(Debug, Default)]
pub(crate) struct TextStlContents {
    /// Number of facets.
    pub(crate) facets: u64,
    /// Number of `solid` headers.
    pub(crate) solids: u32,
    /// Whether the last solid is closed by `endsolid`.
    pub(super) ended: bool,
}

/// Reads facets until the end of the file and hands on the corners of each.
pub(super) fn read_text_stl(
    input: impl BufRead,
    limits: &ReadLimits,
    hand_on: &mut dyn FnMut([DVec3; 3]),
) -> Result<TextStlContents, FileReadError> {
    let mut words = StlTokenizer::new(input);
    let mut soup = TextStlContents::default();
    let mut add_facet = |words: &mut StlTokenizer<_>, facets: &mut u64, in_loop: bool| {
        if *facets >= limits.max_triangles {
            return Err(FileReadError::too_many_triangles(limits));
        }
        *facets += 1;
        hand_on(read_facet(words, *facets, in_loop)?);
        words.next_token()
    };
    let mut next = words.next_token()?;
    loop {
        next = match (next, words.word.as_slice()) {
            (NextToken::End, _) => return Ok(soup),
            (NextToken::Loop, _) => {
                // A name line that continues with facets: another solid, if the previous one was closed.
                soup.solids += u32::from(soup.ended);
                soup.ended = false;
                add_facet(&mut words, &mut soup.facets, true)?
            }
            (NextToken::Word, b"solid") => {
                soup.solids += 1;
                soup.ended = false;
                words.skip_name()?
            }
            (NextToken::Word, b"endsolid") => {
                soup.ended = true;
                words.skip_name()?
            }
            (NextToken::Word, b"facet") => add_facet(&mut words, &mut soup.facets, false)?,
            (NextToken::Word, _) => return Err(words.unexpected_word("`facet` or `endsolid`")),
        };
    }
}

/// The next token of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NextToken {
    /// A word, in lower case.
    Word,
    /// The vertices of a facet; the words up to `outer loop` are already read.
    Loop,
    /// The end of the file.
    End,
}

/// Keywords that may follow a solid's name on the same line; they are never numbers of a normal.
const KEYWORDS: [&[u8]; 8] = [b"solid", b"endsolid", b"facet", b"endfacet", b"outer", b"loop", b"endloop", b"vertex"];

/// Reads everything after the word `facet` up to `endfacet`. The normal is not trusted, so it is not read.
fn read_facet<R: BufRead>(
    words: &mut StlTokenizer<R>,
    number: u64,
    mut in_loop: bool,
) -> Result<[DVec3; 3], FileReadError> {
    let (mut corners, mut found) = ([DVec3::ZERO; 3], 0);
    loop {
        if !words.advance_word()? {
            return Err(FileReadError::Truncated(format!("it ends within facet {number}")));
        }
        match words.word.as_slice() {
            b"vertex" => {
                let corner = read_vertex(words)?;
                if let Some(place) = corners.get_mut(found) {
                    *place = corner;
                }
                found += 1;
            }
            b"loop" => in_loop = true,
            b"endfacet" => break,
            b"outer" | b"endloop" => {}
            b"facet" | b"endsolid" | b"solid" => return Err(words.unexpected_word("`endfacet`")),
            _ if in_loop => return Err(words.unexpected_word("`vertex` or `endloop`")),
            _ => {}
        }
    }
    if found != 3 {
        return Err(words.invalid_line(format!("facet {number} has {found} vertices instead of 3")));
    }
    Ok(corners)
}

fn read_vertex<R: BufRead>(words: &mut StlTokenizer<R>) -> Result<DVec3, FileReadError> {
    let mut numbers = [0.0; 3];
    for number in &mut numbers {
        if !words.advance_word()? {
            return Err(FileReadError::Truncated("it ends within a vertex".to_owned()));
        }
        *number = parse_decimal(&words.word).ok_or_else(|| words.unexpected_word("a finite decimal number"))?;
    }
    Ok(DVec3::from_array(numbers))
}

fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0x0b
}

/// Splits a stream into words and counts lines.
struct StlTokenizer<R> {
    input: R,
    word: Vec<u8>,
    line: u64,
    /// The line of the present word.
    word_line: u64,
    /// Whether a name is being read: its words may have any length, but are truncated.
    in_name: bool,
    /// The previous byte, so that CR, LF and CR LF each count as one line end.
    last: u8,
}

impl<R: BufRead> StlTokenizer<R> {
    fn new(input: R) -> Self {
        Self { input, word: Vec::new(), line: 1, word_line: 1, in_name: false, last: 0 }
    }

    /// Reads the next word into `self.word`, in lower case; `false` at the end of the file. `#` starts a comment.
    fn advance_word(&mut self) -> Result<bool, FileReadError> {
        self.word.clear();
        loop {
            let bytes = self.input.fill_buf()?;
            let Some(&first) = bytes.first() else { break };
            if self.word.is_empty() && is_blank(first) {
                self.consume(first);
                continue;
            }
            if self.word.is_empty() && first == b'#' {
                self.skip_line()?;
                continue;
            }
            let length = bytes.iter().position(|&b| is_blank(b)).unwrap_or(bytes.len());
            let is_cut = length == bytes.len();
            self.word.extend_from_slice(&bytes[..length.min(MAX_WORD + 1)]);
            self.word_line = self.line;
            self.input.consume(length);
            self.last = 0;
            if self.word.len() > MAX_WORD && self.word.ends_with(&[0; MAX_WORD / 2]) {
                return Err(unfinished_copy(&format!("with zeros in line {}", self.line)));
            }
            if self.word.len() > MAX_WORD && self.in_name {
                self.word.truncate(MAX_WORD);
            } else if self.word.len() > MAX_WORD {
                return Err(self.invalid_line(format!("a word is longer than {MAX_WORD} bytes")));
            }
            if !is_cut {
                break;
            }
        }
        self.word.make_ascii_lowercase();
        Ok(!self.word.is_empty())
    }

    fn next_token(&mut self) -> Result<NextToken, FileReadError> {
        Ok(if self.advance_word()? { NextToken::Word } else { NextToken::End })
    }

    /// Skips the name of a solid. It ends with its line, or where the words of a facet follow it: some programs write a
    /// whole file in one line.
    fn skip_name(&mut self) -> Result<NextToken, FileReadError> {
        let line = self.line;
        // Number of words of `facet [normal x y z] outer loop` seen so far.
        let mut seen = 0;
        loop {
            self.in_name = true;
            let next = self.next_token();
            self.in_name = false;
            if next? == NextToken::End {
                return Ok(NextToken::End);
            }
            let word = self.word.as_slice();
            seen = match (seen, word) {
                (1, b"normal") => 2,
                (1 | 5, b"outer") => 6,
                (6, b"loop") => return Ok(NextToken::Loop),
                (2..5, number) if !KEYWORDS.contains(&number) => seen + 1,
                _ if self.word_line != line => return Ok(NextToken::Word),
                (_, b"facet") => 1,
                _ => 0,
            };
        }
    }

    fn skip_line(&mut self) -> io::Result<()> {
        while let Some(byte) = self.peek()? {
            if byte == b'\n' || byte == b'\r' {
                break;
            }
            self.consume(byte);
        }
        Ok(())
    }

    fn peek(&mut self) -> io::Result<Option<u8>> {
        Ok(self.input.fill_buf()?.first().copied())
    }

    fn consume(&mut self, byte: u8) {
        self.input.consume(1);
        if byte == b'\r' || (byte == b'\n' && self.last != b'\r') {
            self.line += 1;
        }
        self.last = byte;
    }

    /// The error for an unexpected word. The last word of a file may be only half of the expected one.
    fn unexpected_word(&mut self, wanted: &str) -> FileReadError {
        let is_word = self.word.iter().all(u8::is_ascii_graphic);
        match self.peek() {
            Ok(None) if is_word => {
                return FileReadError::Truncated(format!("it ends in line {}, before {wanted}", self.line));
            }
            Ok(_) => {}
            Err(error) => return error.into(),
        }
        let word: String = self.word.escape_ascii().map(char::from).take(MAX_EXCERPT).collect();
        let more = if self.word.escape_ascii().count() > MAX_EXCERPT { "..." } else { "" };
        self.invalid_line(format!("expected {wanted}, found `{word}`{more}"))
    }

    fn invalid_line(&self, reason: String) -> FileReadError {
        FileReadError::invalid_stl(format!("line {}: {reason}", self.line))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(text: &str) -> Result<(TextStlContents, Vec<DVec3>), FileReadError> {
        let mut corners = Vec::new();
        let read = read_text_stl(text.as_bytes(), &ReadLimits::for_testing(), &mut |facet| corners.extend(facet))?;
        assert_eq!(read.facets as usize, corners.len() / 3);
        Ok((read, corners))
    }

    fn text(text: &str) -> Result<TextStlContents, FileReadError> {
        Ok(corners(text)?.0)
    }

    const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    #[test]
    fn odd_white_space_case_and_comments_are_read() {
        let odd = format!("SOLID x # a\n{}endSolid", FACET.replace('\n', "\r").replace(' ', "\t\x0b ").to_uppercase());
        let (read, corners) = corners(&odd).unwrap();
        assert_eq!((read.facets, read.ended), (1, true));
        assert_eq!(corners[1], DVec3::X);
    }

    #[test]
    fn several_solids_are_all_read() {
        let soup =
            text(&format!("solid a\n{FACET}endsolid a\nsolid facet normal vertex\n{FACET}endsolid b\n")).unwrap();
        assert_eq!((soup.facets, soup.solids), (2, 2));
    }

    #[test]
    fn a_file_in_one_line_is_read() {
        let two = format!("solid a part {FACET}{FACET}endsolid a part solid b {FACET}endsolid b\n").replace('\n', " ");
        let soup = text(&two).unwrap();
        assert_eq!((soup.facets, soup.solids, soup.ended), (3, 2, true));
        assert_eq!(text(&two.replace("normal 0 0 1", "")).unwrap().facets, 3);
        assert_eq!(text(&format!("solid my facet\n{FACET}endsolid my facet normal\n")).unwrap().facets, 1);
        assert_eq!(text(&format!("solid {}\n{FACET}endsolid", "x".repeat(3000))).unwrap().facets, 1);
        let broken = format!("solid a facet normal 0 0\n1 {}", &FACET[19..]);
        assert_eq!(text(&broken).unwrap().facets, 1);
    }

    #[test]
    fn a_missing_end_is_no_error_but_reported() {
        assert!(!text(&format!("solid\n{FACET}")).unwrap().ended);
    }

    #[test]
    fn a_facet_cut_off_is_truncated() {
        assert!(matches!(text(&format!("solid\n{}", &FACET[..40])), Err(FileReadError::Truncated(_))));
    }

    #[test]
    fn a_file_cut_off_anywhere_in_its_facets_is_truncated() {
        let whole = format!("solid a\n{FACET}{FACET}");
        let (from, to) = ("solid a\n".len() + FACET.len(), whole.len() - "endfacet\n".len());
        for cut in (from + "facet".len()..to).filter(|&cut| !whole[..cut].ends_with(['0', '1'])) {
            assert!(matches!(text(&whole[..cut]), Err(FileReadError::Truncated(_))), "{}", &whole[from..cut]);
        }
    }

    #[test]
    fn bad_numbers_and_facets_are_refused_with_their_line() {
        for (from, to) in [("1 0 0", "1,0 0 0"), ("1 0 0", "nan 0 0"), ("1 0 0", "1 0"), ("vertex 1 0 0\n", "")] {
            let error = text(&format!("solid\n{}", FACET.replace(from, to))).unwrap_err();
            assert!(error.to_string().contains("line "), "{error}");
        }
    }

    #[test]
    fn of_binary_junk_a_short_excerpt_is_reported() {
        let junk = [b"solid\n".as_slice(), &[7; 200]].concat();
        let error = read_text_stl(&junk[..], &ReadLimits::for_testing(), &mut |_| {}).unwrap_err();
        let message = error.to_string();
        assert!(message.contains(r"found `\x07\x07") && message.ends_with("`...") && message.len() < 130, "{message}");
    }

    #[test]
    fn a_word_without_end_is_refused() {
        assert!(text(&format!("solid\n{}", "x".repeat(1000))).is_err());
    }

    #[test]
    fn more_triangles_than_the_limit_are_refused() {
        let limits = ReadLimits { max_triangles: 2, ..ReadLimits::for_testing() };
        let many = format!("solid\n{}", FACET.repeat(3));
        assert!(matches!(read_text_stl(many.as_bytes(), &limits, &mut |_| {}), Err(FileReadError::TooLarge { .. })));
    }
}
