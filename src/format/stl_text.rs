//! ASCII STL, read tolerantly: any white space, any line end, any case, several solids, comments, lines of any length.
//!
//! `stl_io` refuses unnamed, upper-case and CR-only files, stops after the first solid and reads in f32, so that this
//! tokenizer does the whole of ASCII.

use std::io::{self, BufRead};

use glam::DVec3;

use super::{Limits, ReadError, number::decimal};

/// Longer words cannot be numbers or keywords; the cap keeps a word out of memory that never ends.
const MAX_WORD: usize = 256;

/// So much of an unexpected word is told; binary junk would fill a page.
const EXCERPT: usize = 40;

/// What an ASCII file holds: three vertices per facet.
#[derive(Debug, Default)]
pub(super) struct Soup {
    pub(super) corners: Vec<DVec3>,
    /// `solid` headers.
    pub(super) solids: u32,
    /// Whether the last solid is closed by `endsolid`.
    pub(super) ended: bool,
}

/// Reads facets until the end of the file.
pub(super) fn read_text(input: impl BufRead, limits: &Limits) -> Result<Soup, ReadError> {
    let mut words = Words::new(input);
    let mut soup = Soup::default();
    while words.advance()? {
        words.word.make_ascii_lowercase();
        match words.word.as_slice() {
            b"solid" => {
                soup.solids += 1;
                soup.ended = false;
                words.skip_line()?;
            }
            b"endsolid" => {
                soup.ended = true;
                words.skip_line()?;
            }
            b"facet" => {
                if soup.corners.len() as u64 / 3 >= limits.max_triangles {
                    let what = "the number of triangles".to_owned();
                    return Err(ReadError::TooLarge { what, limit: limits.max_triangles });
                }
                facet(&mut words, &mut soup.corners)?;
            }
            _ => return Err(words.unexpected("`facet` or `endsolid`")),
        }
    }
    Ok(soup)
}

/// Everything after the word `facet` up to `endfacet`. The normal is not trusted, so not read.
fn facet<R: BufRead>(words: &mut Words<R>, corners: &mut Vec<DVec3>) -> Result<(), ReadError> {
    let first = corners.len();
    let mut in_loop = false;
    loop {
        if !words.advance()? {
            return Err(ReadError::Truncated(format!("it ends within facet {}", first / 3 + 1)));
        }
        words.word.make_ascii_lowercase();
        match words.word.as_slice() {
            b"vertex" => corners.push(vertex(words)?),
            b"loop" => in_loop = true,
            b"endfacet" => break,
            b"outer" | b"endloop" => {}
            b"facet" | b"endsolid" | b"solid" => return Err(words.unexpected("`endfacet`")),
            _ if in_loop => return Err(words.unexpected("`vertex` or `endloop`")),
            _ => {}
        }
    }
    let found = corners.len() - first;
    if found != 3 {
        return Err(words.invalid(format!("facet {} has {found} vertices instead of 3", first / 3 + 1)));
    }
    Ok(())
}

fn vertex<R: BufRead>(words: &mut Words<R>) -> Result<DVec3, ReadError> {
    let mut numbers = [0.0; 3];
    for number in &mut numbers {
        if !words.advance()? {
            return Err(ReadError::Truncated("it ends within a vertex".to_owned()));
        }
        *number = decimal(&words.word).ok_or_else(|| words.unexpected("a finite decimal number"))?;
    }
    Ok(DVec3::from_array(numbers))
}

fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0x0b
}

/// Splits a stream into words and counts lines.
struct Words<R> {
    input: R,
    word: Vec<u8>,
    line: u64,
    /// The byte before, so that CR, LF and CR LF each count as one line end.
    last: u8,
}

impl<R: BufRead> Words<R> {
    fn new(input: R) -> Self {
        Self { input, word: Vec::new(), line: 1, last: 0 }
    }

    /// Reads the next word into `self.word`; `false` at the end of the file. `#` starts a comment.
    fn advance(&mut self) -> Result<bool, ReadError> {
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
            self.input.consume(length);
            self.last = 0;
            if self.word.len() > MAX_WORD {
                return Err(self.invalid(format!("a word is longer than {MAX_WORD} bytes")));
            }
            if !is_cut {
                break;
            }
        }
        Ok(!self.word.is_empty())
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

    fn unexpected(&self, wanted: &str) -> ReadError {
        let word: String = self.word.escape_ascii().map(char::from).take(EXCERPT).collect();
        let more = if self.word.escape_ascii().count() > EXCERPT { "..." } else { "" };
        self.invalid(format!("expected {wanted}, found `{word}`{more}"))
    }

    fn invalid(&self, reason: String) -> ReadError {
        ReadError::stl(format!("line {}: {reason}", self.line))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Result<Soup, ReadError> {
        read_text(text.as_bytes(), &Limits::for_testing())
    }

    const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    #[test]
    fn odd_white_space_case_and_comments_are_read() {
        let odd = format!("SOLID x # a\n{}endSolid", FACET.replace('\n', "\r").replace(' ', "\t\x0b ").to_uppercase());
        let soup = text(&odd).unwrap();
        assert_eq!((soup.corners.len(), soup.ended), (3, true));
        assert_eq!(soup.corners[1], DVec3::X);
    }

    #[test]
    fn several_solids_are_all_read() {
        let soup =
            text(&format!("solid a\n{FACET}endsolid a\nsolid facet normal vertex\n{FACET}endsolid b\n")).unwrap();
        assert_eq!((soup.corners.len(), soup.solids), (6, 2));
    }

    #[test]
    fn a_missing_end_is_no_error_but_told() {
        assert!(!text(&format!("solid\n{FACET}")).unwrap().ended);
    }

    #[test]
    fn a_facet_cut_off_is_truncated() {
        assert!(matches!(text(&format!("solid\n{}", &FACET[..40])), Err(ReadError::Truncated(_))));
    }

    #[test]
    fn bad_numbers_and_facets_are_refused_with_their_line() {
        for (from, to) in [("1 0 0", "1,0 0 0"), ("1 0 0", "nan 0 0"), ("1 0 0", "1 0"), ("vertex 1 0 0\n", "")] {
            let error = text(&format!("solid\n{}", FACET.replace(from, to))).unwrap_err();
            assert!(error.to_string().contains("line "), "{error}");
        }
    }

    #[test]
    fn of_binary_junk_a_short_excerpt_is_told() {
        let error = read_text(&[b"solid\n".as_slice(), &[7; 200]].concat()[..], &Limits::for_testing()).unwrap_err();
        let told = error.to_string();
        assert!(told.contains(r"found `\x07\x07") && told.ends_with("`...") && told.len() < 130, "{told}");
    }

    #[test]
    fn a_word_without_end_is_refused() {
        assert!(text(&format!("solid\n{}", "x".repeat(1000))).is_err());
    }

    #[test]
    fn more_triangles_than_the_limit_are_refused() {
        let limits = Limits { max_triangles: 2, ..Limits::for_testing() };
        let many = format!("solid\n{}", FACET.repeat(3));
        assert!(matches!(read_text(many.as_bytes(), &limits), Err(ReadError::TooLarge { .. })));
    }
}
