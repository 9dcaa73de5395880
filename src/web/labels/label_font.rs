//! The font of labels: Inter with the letters of European languages, and the Japanese signs that labels say; how wide a text is in it.

use anyhow::{Context, Result};
use ttf_parser::{Face, GlyphId};

/// The file, which is embedded in each PDF.
pub(super) const FONT_FILE: &[u8] = include_bytes!("../assets/labels.ttf");

/// The font.
pub(super) struct LabelFont(Face<'static>);

impl LabelFont {
    /// Reads it.
    ///
    /// # Errors
    /// When the file in the program is none.
    pub(super) fn read() -> Result<Self> {
        Ok(Self(Face::parse(FONT_FILE, 0).context("reading the font of labels")?))
    }

    /// The glyph of a character; `None` where the font lacks it.
    pub(super) fn glyph(&self, letter: char) -> Option<u16> {
        self.0.glyph_index(letter).map(|glyph| glyph.0)
    }

    /// Number of its glyphs.
    pub(super) fn glyph_count(&self) -> u16 {
        self.0.number_of_glyphs()
    }

    /// Width of a glyph in thousandths of the size.
    pub(super) fn width_of(&self, glyph: u16) -> f64 {
        let units = f64::from(self.0.glyph_hor_advance(GlyphId(glyph)).unwrap_or_default());
        1000.0 * units / f64::from(self.0.units_per_em())
    }

    /// Width of a text of size 1. What the font lacks is drawn as a box.
    pub(super) fn text_width(&self, text: &str) -> f64 {
        text.chars().map(|letter| self.width_of(self.glyph(letter).unwrap_or(0))).sum::<f64>() / 1000.0
    }

    /// Its box, ascent and descent in thousandths of the size.
    pub(super) fn metrics(&self) -> ([f32; 4], f32, f32) {
        let scale = 1000.0 / f32::from(self.0.units_per_em());
        let bounds = self.0.global_bounding_box();
        let corners = [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max].map(|value| scale * f32::from(value));
        (corners, scale * f32::from(self.0.ascender()), scale * f32::from(self.0.descender()))
    }

    /// Breaks a text into lines of a width, in sizes. A line ends after a blank or a mark of names, else after any letter.
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
        lines.retain(|line| !line.is_empty());
        lines
    }
}

#[cfg(test)]
mod tests {
    use language::{Language, say};

    use super::*;

    #[test]
    fn a_text_is_broken_at_marks_and_else_anywhere_and_no_line_is_too_wide() {
        let font = LabelFont::read().unwrap();
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
        let font = LabelFont::read().unwrap();
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
