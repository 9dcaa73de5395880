//! The sheets that labels are printed on.

use language::say;
use serde::{Deserialize, Serialize};

/// A kind of sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(crate) enum LabelSheet {
    /// A4 with 3 x 8 labels of 70 x 37 mm.
    #[default]
    #[serde(rename = "a4-70x37")]
    A4Small,
    /// A4 with 2 x 7 labels of 99.1 x 38.1 mm.
    #[serde(rename = "a4-99x38")]
    A4Wide,
    /// US Letter with 3 x 10 labels of 2 5/8 x 1 inches (Avery 5160).
    #[serde(rename = "letter-5160")]
    Letter,
    /// An endless roll of 62 mm: a label is a page 29 mm long.
    #[serde(rename = "roll-62")]
    Roll,
}

/// All of them.
pub(super) const SHEETS: [LabelSheet; 4] =
    [LabelSheet::A4Small, LabelSheet::A4Wide, LabelSheet::Letter, LabelSheet::Roll];

/// Where the labels of a sheet are, mm, from its left upper corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SheetShape {
    /// Width and height of the page.
    pub(super) page_mm: [f64; 2],
    /// Width and height of a label.
    pub(super) label_mm: [f64; 2],
    /// Corner of the first label.
    pub(super) first_mm: [f64; 2],
    /// From a label to the next.
    pub(super) pitch_mm: [f64; 2],
    /// Columns and rows.
    pub(super) counts: [usize; 2],
}

impl SheetShape {
    /// A page of A4 with a rim: one text fills it.
    pub(super) const PAGE: Self = Self {
        page_mm: [210.0, 297.0],
        label_mm: [180.0, 267.0],
        first_mm: [15.0, 15.0],
        pitch_mm: [180.0, 267.0],
        counts: [1, 1],
    };

    /// Whether it is that page.
    pub(super) fn is_page(&self) -> bool {
        *self == Self::PAGE
    }

    /// Labels of a page.
    pub(super) fn per_page(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// The left upper corner of a label of a page, mm.
    pub(super) fn corner_mm(&self, number: usize) -> [f64; 2] {
        let place = [number % self.counts[0], number / self.counts[0]];
        std::array::from_fn(|axis| self.first_mm[axis] + place[axis] as f64 * self.pitch_mm[axis])
    }
}

impl LabelSheet {
    /// Its measures.
    pub(super) fn shape(self) -> SheetShape {
        let (page_mm, label_mm, first_mm, pitch_mm, counts) = match self {
            Self::A4Small => ([210.0, 297.0], [70.0, 37.0], [0.0, 0.5], [70.0, 37.0], [3, 8]),
            Self::A4Wide => ([210.0, 297.0], [99.1, 38.1], [4.65, 15.15], [101.6, 38.1], [2, 7]),
            Self::Letter => ([215.9, 279.4], [66.675, 25.4], [4.7625, 12.7], [69.85, 25.4], [3, 10]),
            Self::Roll => ([62.0, 29.0], [62.0, 29.0], [0.0, 0.0], [62.0, 29.0], [1, 1]),
        };
        SheetShape { page_mm, label_mm, first_mm, pitch_mm, counts }
    }

    /// What people call it.
    pub(super) fn words(self) -> String {
        match self {
            Self::A4Small => "A4, 3 \u{d7} 8, 70 \u{d7} 37 mm".to_owned(),
            Self::A4Wide => language::decimal("A4, 2 \u{d7} 7, 99.1 \u{d7} 38.1 mm".to_owned()),
            Self::Letter => "US Letter, 3 \u{d7} 10, Avery 5160".to_owned(),
            Self::Roll => say!("sheet-roll"),
        }
    }

    /// Its word in addresses.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::A4Small => "a4-70x37",
            Self::A4Wide => "a4-99x38",
            Self::Letter => "letter-5160",
            Self::Roll => "roll-62",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_labels_of_a_sheet_lie_on_it_side_by_side() {
        for sheet in SHEETS {
            let shape = sheet.shape();
            let last = shape.corner_mm(shape.per_page() - 1);
            for (((last, label), page), pitch) in
                last.into_iter().zip(shape.label_mm).zip(shape.page_mm).zip(shape.pitch_mm)
            {
                assert!(last + label <= page + 1e-6 && pitch >= label, "{sheet:?}");
            }
            assert_eq!(serde_json::to_value(sheet).unwrap(), sheet.word());
        }
    }
}
