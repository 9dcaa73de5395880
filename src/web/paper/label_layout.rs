//! Where the text and the code of a label stand on it, and how a long text becomes labels that fill a page each.

use anyhow::Result;

use super::{label_font::LabelFont, label_sheet::SheetShape, system_fonts::SystemFont};

/// Points in a millimetre.
pub(super) const POINTS_PER_MM: f64 = 72.0 / 25.4;
/// Free rim of a label, mm.
pub(super) const RIM_MM: f64 = 2.5;
/// Greatest side of a code, and its greatest share of the width of a label.
const CODE_MM: f64 = 24.0;
const CODE_SHARE: f64 = 0.36;
/// Sizes of the first line and of the others, points.
const TITLE_SIZE: f64 = 13.0;
const LINE_SIZE: f64 = 9.5;
/// Height of a line, in sizes, and how much smaller each attempt to fit is.
pub(super) const LINE_HEIGHT: f64 = 1.15;
const SMALLER: f64 = 0.94;
/// Smallest scale of the sizes.
const SMALLEST: f64 = 0.3;

/// A label.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Label {
    /// In large letters: the order.
    pub(crate) title: String,
    /// Below it.
    pub(crate) lines: Vec<String>,
    /// Where its code leads; "" = no code.
    pub(crate) address: String,
}

impl Label {
    pub(super) fn texts(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&self.title).chain(&self.lines).map(String::as_str)
    }
}

/// A label whose lines do not fit, as several with the same title.
pub(super) fn split_into_pages(label: &Label, shape: SheetShape, fonts: &[SystemFont]) -> Result<Vec<Label>> {
    let font = LabelFont::read(fonts)?;
    let [width, height] = text_size(label, &shape);
    let high_of = |text: &str, size: f64| LINE_HEIGHT * size * font.wrapped(text, width / size).len() as f64;
    let room = height - high_of(&label.title, TITLE_SIZE);
    let (mut pages, mut left) = (Vec::<Label>::new(), 0.0);
    for line in &label.lines {
        let high = high_of(line, LINE_SIZE);
        if high > left || pages.is_empty() {
            pages.push(Label { lines: Vec::new(), ..label.clone() });
            left = room;
        }
        left -= high;
        pages.last_mut().expect("one was begun").lines.push(line.clone());
    }
    Ok(pages)
}

/// Width and height of a label without its rim, points.
pub(super) fn inner_size(shape: &SheetShape) -> [f64; 2] {
    shape.label_mm.map(|mm| (mm - 2.0 * RIM_MM) * POINTS_PER_MM)
}

/// The side of the code of a label, and how far its text stands aside for it, points.
pub(super) fn code_size(label: &Label, shape: &SheetShape) -> (f64, f64) {
    let [width, height] = inner_size(shape);
    let side = height.min(CODE_SHARE * width).min(CODE_MM * POINTS_PER_MM);
    if label.address.is_empty() { (0.0, 0.0) } else { (side, side + RIM_MM * POINTS_PER_MM) }
}

/// Width and height of the text of a label, points.
pub(super) fn text_size(label: &Label, shape: &SheetShape) -> [f64; 2] {
    let [width, height] = inner_size(shape);
    [width - code_size(label, shape).1, height]
}

/// The lines of a label with their sizes, as large as they fit.
pub(super) fn fitted(font: &LabelFont<'_>, label: &Label, [width, height]: [f64; 2]) -> Vec<(f64, String)> {
    let mut scale = 1.0;
    loop {
        let wrapped = |text: &str, size: f64| -> Vec<(f64, String)> {
            font.wrapped(text, width / size).into_iter().map(|line| (size, line)).collect()
        };
        let mut lines = wrapped(&label.title, scale * TITLE_SIZE);
        lines.extend(label.lines.iter().flat_map(|line| wrapped(line, scale * LINE_SIZE)));
        let high: f64 = lines.iter().map(|(size, _)| LINE_HEIGHT * size).sum();
        if high <= height || scale < SMALLEST {
            return lines;
        }
        scale *= SMALLER;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::web::paper::label_sheet::SHEETS;

    /// A text of 60 letters.
    fn long(first: char) -> String {
        std::iter::once(first).chain(('a'..='z').cycle()).take(60).collect()
    }

    #[test]
    fn three_names_of_sixty_letters_fit_on_every_label() {
        let font = LabelFont::read(&[]).unwrap();
        let label = Label {
            title: long('O'),
            lines: vec![long('C'), long('P'), "12 copies, build 1234".to_owned()],
            address: "https://farm.example.org:7878/orders/K-2026-1182".to_owned(),
        };
        for sheet in SHEETS {
            let [width, height] = text_size(&label, &sheet.shape());
            let lines = fitted(&font, &label, [width, height]);
            let high: f64 = lines.iter().map(|(size, _)| LINE_HEIGHT * size).sum();
            assert!(high <= height, "{sheet:?}: {high} of {height}");
            let smallest = lines.iter().map(|(size, _)| *size).fold(f64::MAX, f64::min);
            assert!(smallest >= 5.0, "{sheet:?}: {smallest} points cannot be read");
        }
    }

    #[test]
    fn a_text_of_several_pages_keeps_its_lines_and_the_size_of_its_letters() {
        let address = "https://farm.example.org:7878/parts/12/record".to_owned();
        let lines: Vec<String> =
            (0..200).map(|line| if line % 3 == 0 { long('L') + " " + &long('M') } else { format!("{line}") }).collect();
        let text = Label { title: long('R'), lines, address };
        let (font, shape) = (LabelFont::read(&[]).unwrap(), SheetShape::PAGE);
        let pages = split_into_pages(&text, shape, &[]).unwrap();
        assert!((4..=6).contains(&pages.len()), "{} pages", pages.len());
        assert_eq!(pages.iter().flat_map(|page| page.lines.clone()).collect::<Vec<_>>(), text.lines);
        for page in &pages {
            let lines = fitted(&font, page, text_size(page, &shape));
            assert_eq!((lines[0].0, lines.last().unwrap().0), (TITLE_SIZE, LINE_SIZE));
        }
    }
}
