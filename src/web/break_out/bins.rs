//! The bins of a cake that is broken out, one for each order: each has a number, a colour and a shape of its own.

use build_file::kind_colour_code;
use language::{comma, say};
use maud::{Markup, PreEscaped, html};

use super::break_out_state::BinCount;
use crate::tables::fields;

/// The colours of bins, as kinds of parts in pictures and in the 3D view (`web/view/palette.js`): those that everybody can tell apart, also the
/// colour-blind (CIE76 distance of 15 at least, also as deutan and protan eyes see them).
pub(super) const BIN_KINDS: [usize; 10] = [0, 2, 6, 17, 4, 19, 5, 14, 9, 13];

/// Shapes in a square of 24 x 24: a disc, a square, a diamond. Their number and that of the colours have no common divisor, so 30 bins
/// differ.
const SHAPES: [&str; 3] = [
    "<circle cx=\"12\" cy=\"12\" r=\"11.5\"/>",
    "<rect x=\"1.5\" y=\"1.5\" width=\"21\" height=\"21\"/>",
    "<path d=\"M12-1 25 12 12 25-1 12z\"/>",
];

/// Least brightness of a colour on which a black number is read best.
const BRIGHT: f64 = 0.18;

/// The kind of a bin, which says its colour.
pub(super) fn bin_kind(bin: usize) -> usize {
    BIN_KINDS[bin % BIN_KINDS.len()]
}

/// The number of a bin in its colour and shape.
pub(super) fn bin_badge(bin: usize) -> Markup {
    let colour = kind_colour_code(bin_kind(bin));
    let ink = if luminance(&colour) > BRIGHT { "#000" } else { "#fff" };
    html! {
        svg.badge viewBox="-1 -1 26 26" aria-hidden="true" {
            g fill=(colour) { (PreEscaped(SHAPES[bin % SHAPES.len()])) }
            text x="12" y="16.5" fill=(ink) { (bin + 1) }
        }
    }
}

/// Relative luminance of a colour such as `#0072b2`, as WCAG 2.2 defines it.
fn luminance(code: &str) -> f64 {
    let part = |at: usize| u8::from_str_radix(code.get(at..at + 2).unwrap_or("0"), 16).unwrap_or(0);
    let linear = |value: u8| match f64::from(value) / 255.0 {
        c if c <= 0.04045 => c / 12.92,
        c => ((c + 0.055) / 1.055).powf(2.4),
    };
    0.2126 * linear(part(1)) + 0.7152 * linear(part(3)) + 0.0722 * linear(part(5))
}

/// What is counted of a bin, with its label.
fn counts_of(counted: &BinCount) -> [(String, String); 5] {
    let open = counted.open();
    let open_text = if open == 0 { "0 \u{2713}".to_owned() } else { open.to_string() };
    [
        (fields::COPIES.said(), counted.all.to_string()),
        (fields::COPIES_GOOD.said(), counted.good.to_string()),
        (fields::COPIES_BAD.said(), counted.bad.to_string()),
        (say!("bin-not-found"), counted.missing.to_string()),
        (say!("bin-in-cake"), open_text),
    ]
}

/// The bins with their counts.
pub(super) fn bins_table(counts: &[BinCount]) -> Markup {
    html! {
        h2 { (say!("bins")) }
        div.wide.listed tabindex="0" role="region" aria-label=(say!("bins")) { table.bins {
            thead { tr { th scope="col" { (say!("bin")) } @for (label, _) in counts_of(&BinCount::default()) { th.n scope="col" { (label) } } } }
            tbody { @for (bin, counted) in counts.iter().enumerate() { tr {
                td.title { (bin_badge(bin)) " " span.unseen { (bin + 1) (comma()) } (counted.name()) }
                @for (label, number) in counts_of(counted) { td.n data-of=(label) { (number) } }
            } } }
        } }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn no_two_of_ten_bins_have_one_colour_none_has_orange_and_no_two_of_thirty_look_alike() {
        let colours: BTreeSet<String> = (0..10).map(|bin| kind_colour_code(bin_kind(bin))).collect();
        assert_eq!(colours.len(), 10);
        assert!(!colours.contains("#e69f00"));
        let plain = |bin: usize| bin_badge(bin).into_string().split("<text").next().unwrap().to_owned();
        assert_eq!((0..30).map(plain).collect::<BTreeSet<_>>().len(), 30);
    }

    #[test]
    fn the_number_of_a_bin_is_read_on_its_colour() {
        for bin in 0..10 {
            let (badge, paint) = (bin_badge(bin).into_string(), luminance(&kind_colour_code(bin_kind(bin))));
            let ink = if badge.contains("fill=\"#fff\"") { 1.0 } else { 0.0 };
            let contrast = (f64::max(ink, paint) + 0.05) / (f64::min(ink, paint) + 0.05);
            assert!(contrast >= 4.5, "bin {bin}: {contrast:.1}");
        }
    }

    #[test]
    fn the_3d_view_has_the_colours_of_the_bins() {
        let palette = include_str!("../view/palette.js");
        assert!(palette.contains(&format!("const BINS = {BIN_KINDS:?};")), "{palette}");
    }
}
