//! The font of labels: Inter with the letters of European languages, and the Japanese signs that labels say; fonts of the system for other
//! letters; how wide a text is.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use ttf_parser::{Face, GlyphId};

use super::system_fonts::SystemFont;

/// The file, which is embedded in each PDF.
pub(super) const FONT_FILE: &[u8] = include_bytes!("../assets/labels.ttf");

/// The font, and those of the system that have what it lacks.
pub(super) struct LabelFont<'f> {
    own: Face<'static>,
    others: Vec<Face<'f>>,
}

/// How a letter is drawn.
pub(super) enum LetterShape<'a, 'f> {
    /// With a glyph of the embedded font; 0 = a box.
    Embedded(u16),
    /// As the outline of a glyph of a font of the system.
    Outline(&'a Face<'f>, GlyphId),
}

impl<'f> LabelFont<'f> {
    /// Reads it.
    ///
    /// # Errors
    /// When the file in the program is none.
    pub(super) fn read(others: &'f [SystemFont]) -> Result<Self> {
        let own = Face::parse(FONT_FILE, 0).context("reading the font of labels")?;
        Ok(Self { own, others: others.iter().filter_map(SystemFont::face).collect() })
    }

    /// The glyph of a character in the embedded font; `None` where it lacks it.
    pub(super) fn glyph(&self, letter: char) -> Option<u16> {
        self.own.glyph_index(letter).map(|glyph| glyph.0)
    }

    /// How a letter is drawn.
    pub(super) fn shape(&self, letter: char) -> LetterShape<'_, 'f> {
        if let Some(glyph) = self.glyph(letter) {
            return LetterShape::Embedded(glyph);
        }
        let outline = |face| Face::glyph_index(face, letter).map(|glyph| LetterShape::Outline(face, glyph));
        self.others.iter().find_map(outline).unwrap_or(LetterShape::Embedded(0))
    }

    /// The letters of texts that no font has, each once.
    pub(super) fn lacks<'t>(&self, texts: impl Iterator<Item = &'t str>) -> Vec<char> {
        let is_box = |letter: &char| matches!(self.shape(*letter), LetterShape::Embedded(0));
        let letters: BTreeSet<char> = texts.flat_map(str::chars).filter(|letter| !letter.is_control()).collect();
        letters.into_iter().filter(is_box).collect()
    }

    /// Number of its glyphs.
    pub(super) fn glyph_count(&self) -> u16 {
        self.own.number_of_glyphs()
    }

    /// Width of a glyph of the embedded font in thousandths of the size.
    pub(super) fn width_of(&self, glyph: u16) -> f64 {
        1000.0 * advance(&self.own, GlyphId(glyph))
    }

    /// Width of a letter of size 1. What all fonts lack is drawn as a box.
    pub(super) fn letter_width(&self, letter: char) -> f64 {
        match self.shape(letter) {
            LetterShape::Embedded(glyph) => advance(&self.own, GlyphId(glyph)),
            LetterShape::Outline(face, glyph) => advance(face, glyph),
        }
    }

    /// Width of a text of size 1.
    pub(super) fn text_width(&self, text: &str) -> f64 {
        text.chars().map(|letter| self.letter_width(letter)).sum()
    }

    /// Its box, ascent and descent in thousandths of the size.
    pub(super) fn metrics(&self) -> ([f32; 4], f32, f32) {
        let scale = 1000.0 / f32::from(self.own.units_per_em());
        let bounds = self.own.global_bounding_box();
        let corners = [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max].map(|value| scale * f32::from(value));
        (corners, scale * f32::from(self.own.ascender()), scale * f32::from(self.own.descender()))
    }

    /// Breaks a text into lines of a width, in sizes; an empty one is one line. A line ends after a blank or a mark of names, else after any letter.
    pub(super) fn wrapped(&self, text: &str, width: f64) -> Vec<String> {
        let mut lines = Vec::new();
        let mut line = String::new();
        for letter in text.chars() {
            line.push(letter);
            if line.chars().count() > 1 && self.text_width(line.trim_end()) > width {
                let is_break = |(at, mark): &(usize, char)| [' ', '_', '-', '/', '.', ','].contains(mark) && *at > 0;
                let last = line.char_indices().rev().skip(1).find(is_break);
                let begin = line.len() - letter.len_utf8();
                let cut = last.map_or(begin, |(at, mark)| at + mark.len_utf8());
                let rest = line.split_off(cut);
                lines.push(line.trim_end().to_owned());
                line = rest;
            }
        }
        lines.push(line.trim_end().to_owned());
        lines.retain(|line| !line.is_empty() || text.is_empty());
        lines
    }
}

/// Width of a glyph of size 1.
fn advance(face: &Face<'_>, glyph: GlyphId) -> f64 {
    f64::from(face.glyph_hor_advance(glyph).unwrap_or_default()) / f64::from(face.units_per_em())
}

#[cfg(test)]
mod tests {
    use language::{Language, say};

    use super::*;

    #[test]
    fn a_text_is_broken_at_marks_and_else_anywhere_and_no_line_is_too_wide() {
        let font = LabelFont::read(&[]).unwrap();
        for text in
            ["a hinge, left side_rev 12.stl", &"W".repeat(60), "", "Zażółć gęślą jaźń für Müller & Söhne Ελλάς Щука"]
        {
            for width in [2.0, 8.0, 30.0] {
                let lines = font.wrapped(text, width);
                assert!(lines.iter().all(|line| font.text_width(line) <= width), "{lines:?}");
                let squeezed = |text: &str| text.replace(' ', "");
                assert_eq!(squeezed(&lines.concat()), squeezed(text));
            }
        }
        assert_eq!(font.wrapped("hinge_left.stl", 6.0), ["hinge_left.", "stl"]);
        assert!("Zażółć gęślą für Söhne Ελλάς Щука €".chars().all(|letter| font.glyph(letter).is_some()));
    }

    #[test]
    fn the_font_has_every_letter_that_labels_say_in_every_language() {
        let font = LabelFont::read(&[]).unwrap();
        for language in Language::ALL {
            let said = language.within(|| {
                let counts = [say!("count-copies", count = 12), say!("count-parts", count = 3), say!("no-order")];
                let [copies, parts, no_order] = counts;
                let places = say!("copies-of-build", copies = 7, build = "4");
                [say!("bin-with", number = 1, content = copies), parts, no_order, places].concat()
            });
            let lacks: String = said.chars().filter(|letter| font.glyph(*letter).is_none()).collect();
            assert_eq!(lacks, "", "{}: {said}", language.name());
        }
    }
}
