//! Reads the elements of long lists as nearly all programs write them: without prefix, with the attributes of the specification in its
//! order and nothing else. They are nearly all of a model, and a parser of any XML takes several times as long for them. Whatever is in
//! another form is left to it.

use glam::DVec3;

use crate::common::decimal::parse_decimal;

/// Finds an element at the beginning of a text: what it says, and what follows it.
pub(super) type PlainElement<T> = fn(&[u8]) -> Option<(T, &[u8])>;

/// The corner of a `<vertex>` at the beginning of a text, and what follows. `None` = another form, no finite numbers, or the text ends.
pub(super) fn plain_vertex(text: &[u8]) -> Option<(DVec3, &[u8])> {
    let (x, rest) = quoted_decimal(opened(text, b"<vertex x=")?)?;
    let (y, rest) = quoted_decimal(rest.strip_prefix(b" y=")?)?;
    let (z, rest) = quoted_decimal(rest.strip_prefix(b" z=")?)?;
    Some((DVec3::new(x, y, z), closed(rest)?))
}

/// The indices of a `<triangle>`, likewise.
pub(super) fn plain_triangle(text: &[u8]) -> Option<([u32; 3], &[u8])> {
    let (a, rest) = quoted_index(opened(text, b"<triangle v1=")?)?;
    let (b, rest) = quoted_index(rest.strip_prefix(b" v2=")?)?;
    let (c, rest) = quoted_index(rest.strip_prefix(b" v3=")?)?;
    Some(([a, b, c], closed(rest)?))
}

/// What follows a beginning and the white space before it.
fn opened<'a>(text: &'a [u8], beginning: &[u8]) -> Option<&'a [u8]> {
    without_space(text).strip_prefix(beginning)
}

/// What follows the end of an empty element.
fn closed(text: &[u8]) -> Option<&[u8]> {
    without_space(text).strip_prefix(b"/>")
}

fn without_space(text: &[u8]) -> &[u8] {
    let length = text.iter().take_while(|byte| matches!(byte, b' ' | b'\n' | b'\r' | b'\t')).count();
    &text[length..]
}

fn quoted_decimal(text: &[u8]) -> Option<(f64, &[u8])> {
    let (digits, rest) = quoted(text)?;
    Some((parse_decimal(digits)?, rest))
}

fn quoted_index(text: &[u8]) -> Option<(u32, &[u8])> {
    let (digits, rest) = quoted(text)?;
    // Up to nine digits, so that they fit.
    let is_index = (1..10).contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit);
    is_index.then(|| (digits.iter().fold(0, |number, digit| 10 * number + u32::from(digit - b'0')), rest))
}

/// The characters between quotation marks, and what follows.
fn quoted(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let text = text.strip_prefix(b"\"")?;
    let end = text.iter().position(|&byte| byte == b'"')?;
    Some((&text[..end], &text[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_elements_are_read_with_what_follows_them() {
        let (corner, rest) = plain_vertex(b"\r\n\t <vertex x=\"-1.5\" y=\"2e3\" z=\"+.5\" />\n<").unwrap();
        assert_eq!((corner, rest), (DVec3::new(-1.5, 2000.0, 0.5), b"\n<".as_slice()));
        let (corners, rest) = plain_triangle(b"<triangle v1=\"0\" v2=\"999999999\" v3=\"07\"/>").unwrap();
        assert_eq!((corners, rest), ([0, 999_999_999, 7], b"".as_slice()));
    }

    #[test]
    fn whatever_is_in_another_form_is_left_alone() {
        let vertex = "<vertex x=\"1\" y=\"2\" z=\"3\"/>";
        for (from, to) in [
            ("<", "x<"),
            ("<", "<p:"),
            ("x=", "a=\"0\" x="),
            ("x=\"1\"", "y=\"1\""),
            ("\"1\"", "'1'"),
            ("\"1\"", "\"1,5\""),
            ("\"1\"", "\"nan\""),
            ("\"1\"", "\" 1\""),
            ("\"1\"", "\"\""),
            ("\"3\"", "\"3\" w=\"4\""),
            ("/>", "></vertex>"),
            ("/>", "/"),
        ] {
            let other = vertex.replacen(from, to, 1);
            assert!(plain_vertex(vertex.as_bytes()).is_some() && plain_vertex(other.as_bytes()).is_none(), "{other}");
        }
        for index in ["-1", "1.0", "", "4294967296", "0000000001", "+1", "&#49;"] {
            let triangle = format!("<triangle v1=\"{index}\" v2=\"0\" v3=\"0\"/>");
            assert!(plain_triangle(triangle.as_bytes()).is_none(), "{triangle}");
        }
    }
}
