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
    let mut next = words.next()?;
    loop {
        next = match (next, words.word.as_slice()) {
            (Next::End, _) => return Ok(soup),
            (Next::Loop, _) => {
                // A name's line that goes on with facets: another solid, if the one before was closed.
                soup.solids += u32::from(soup.ended);
                soup.ended = false;
                facet(&mut words, &mut soup.corners, true, limits)?
            }
            (Next::Word, b"solid") => {
                soup.solids += 1;
                soup.ended = false;
                words.pass_name()?
            }
            (Next::Word, b"endsolid") => {
                soup.ended = true;
                words.pass_name()?
            }
            (Next::Word, b"facet") => facet(&mut words, &mut soup.corners, false, limits)?,
            (Next::Word, _) => return Err(words.unexpected("`facet` or `endsolid`")),
        };
    }
}

/// What follows in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// A word, in lower case.
    Word,
    /// The vertices of a facet: its words up to `outer loop` are read.
    Loop,
    /// Nothing.
    End,
}

/// Words that a name's line may be followed by, never the numbers of a normal.
const KEYWORDS: [&[u8]; 8] = [b"solid", b"endsolid", b"facet", b"endfacet", b"outer", b"loop", b"endloop", b"vertex"];

/// Everything after the word `facet` up to `endfacet`, and the word after it. The normal is not trusted, so not read.
fn facet<R: BufRead>(
    words: &mut Words<R>,
    corners: &mut Vec<DVec3>,
    mut in_loop: bool,
    limits: &Limits,
) -> Result<Next, ReadError> {
    if corners.len() as u64 / 3 >= limits.max_triangles {
        let what = "it has too many triangles".to_owned();
        return Err(ReadError::TooLarge { what, limit: limits.max_triangles, key: "max_triangles" });
    }
    let first = corners.len();
    loop {
        if !words.advance()? {
            return Err(ReadError::Truncated(format!("it ends within facet {}", first / 3 + 1)));
        }
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
    words.next()
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
    /// The line that the word stands in.
    word_line: u64,
    /// Names may have words of any length; no more of one is kept than of others.
    in_name: bool,
    /// The byte before, so that CR, LF and CR LF each count as one line end.
    last: u8,
}

impl<R: BufRead> Words<R> {
    fn new(input: R) -> Self {
        Self { input, word: Vec::new(), line: 1, word_line: 1, in_name: false, last: 0 }
    }

    /// Reads the next word into `self.word`, in lower case; `false` at the end of the file. `#` starts a comment.
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
            self.word_line = self.line;
            self.input.consume(length);
            self.last = 0;
            if self.word.len() > MAX_WORD && self.in_name {
                self.word.truncate(MAX_WORD);
            } else if self.word.len() > MAX_WORD {
                return Err(self.invalid(format!("a word is longer than {MAX_WORD} bytes")));
            }
            if !is_cut {
                break;
            }
        }
        self.word.make_ascii_lowercase();
        Ok(!self.word.is_empty())
    }

    fn next(&mut self) -> Result<Next, ReadError> {
        Ok(if self.advance()? { Next::Word } else { Next::End })
    }

    /// Passes over the name of a solid, which ends with its line, or where the words of a facet follow it: some programs
    /// write a whole file in one line.
    fn pass_name(&mut self) -> Result<Next, ReadError> {
        let line = self.line;
        // How many of the words of `facet [normal x y z] outer loop` were seen.
        let mut seen = 0;
        loop {
            self.in_name = true;
            let next = self.next();
            self.in_name = false;
            if next? == Next::End {
                return Ok(Next::End);
            }
            let word = self.word.as_slice();
            seen = match (seen, word) {
                (1, b"normal") => 2,
                (1 | 5, b"outer") => 6,
                (6, b"loop") => return Ok(Next::Loop),
                (2..5, number) if !KEYWORDS.contains(&number) => seen + 1,
                _ if self.word_line != line => return Ok(Next::Word),
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

    /// What stands here instead; the last word of a file may be half of what was wanted.
    fn unexpected(&mut self, wanted: &str) -> ReadError {
        let is_word = self.word.iter().all(u8::is_ascii_graphic);
        match self.peek() {
            Ok(None) if is_word => {
                return ReadError::Truncated(format!("it ends in line {}, before {wanted}", self.line));
            }
            Ok(_) => {}
            Err(error) => return error.into(),
        }
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
    fn a_file_in_one_line_is_read() {
        let two = format!("solid a part {FACET}{FACET}endsolid a part solid b {FACET}endsolid b\n").replace('\n', " ");
        let soup = text(&two).unwrap();
        assert_eq!((soup.corners.len(), soup.solids, soup.ended), (9, 2, true));
        assert_eq!(text(&two.replace("normal 0 0 1", "")).unwrap().corners.len(), 9);
        assert_eq!(text(&format!("solid my facet\n{FACET}endsolid my facet normal\n")).unwrap().corners.len(), 3);
        assert_eq!(text(&format!("solid {}\n{FACET}endsolid", "x".repeat(3000))).unwrap().corners.len(), 3);
        let broken = format!("solid a facet normal 0 0\n1 {}", &FACET[19..]);
        assert_eq!(text(&broken).unwrap().corners.len(), 3);
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
    fn a_file_cut_off_anywhere_in_its_facets_is_truncated() {
        let whole = format!("solid a\n{FACET}{FACET}");
        let (from, to) = ("solid a\n".len() + FACET.len(), whole.len() - "endfacet\n".len());
        for cut in (from + "facet".len()..to).filter(|&cut| !whole[..cut].ends_with(['0', '1'])) {
            assert!(matches!(text(&whole[..cut]), Err(ReadError::Truncated(_))), "{}", &whole[from..cut]);
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
