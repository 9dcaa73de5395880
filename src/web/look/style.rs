//! The style sheet: one file for each topic, and the places on the time axis of the board. Styles in the markup are forbidden by our
//! content security policy, so a place is a class.

use std::fmt::Write;

/// Steps of the time axis of the board.
pub(crate) const AXIS_STEPS: u32 = 300;

/// The style sheet without the font, as a report has it.
pub(crate) const STYLE: &str = concat!(
    include_str!("../assets/style/tokens.css"),
    include_str!("../assets/style/frame.css"),
    include_str!("../assets/style/components.css"),
    include_str!("../assets/style/forms.css"),
    include_str!("../assets/style/tables.css"),
    include_str!("../assets/style/view.css"),
    include_str!("../assets/style/break_out.css"),
    include_str!("../assets/style/book.css"),
    include_str!("../assets/style/print.css"),
);

/// The style sheet of the pages. `font` is the address of the font.
pub(crate) fn page_style(font: &str) -> String {
    let mut style = format!(
        "@font-face {{ font-family: Inter; src: url(\"{font}\") format(\"woff2\"); font-weight: 400 700; font-display: swap; }}\n{STYLE}"
    );
    style.push_str(include_str!("../assets/style/board.css"));
    for step in 0..=AXIS_STEPS {
        let _ = write!(style, ".x{step}{{--x:{step}}}.w{step}{{--w:{step}}}");
    }
    style
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_brace_of_the_style_sheet_is_closed_and_none_is_left_over() {
        let mut open = 0_i32;
        for (at, sign) in page_style("font").char_indices() {
            open += i32::from(sign == '{') - i32::from(sign == '}');
            assert!(open >= 0, "a brace is left over before: {}", &page_style("font")[at..][..80]);
        }
        assert_eq!(open, 0);
    }
}
