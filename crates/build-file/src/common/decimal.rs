//! Decimal numbers in the syntax of STL and 3MF files.

/// Parses a finite decimal number made of digits, sign, point and exponent only: not `nan`, `inf`, `0x10` or `1,5`.
pub(crate) fn parse_decimal(text: &[u8]) -> Option<f64> {
    let plain = |&c: &u8| c.is_ascii_digit() || matches!(c, b'+' | b'-' | b'.' | b'e' | b'E');
    if !text.iter().all(plain) {
        return None;
    }
    let number: f64 = std::str::from_utf8(text).ok()?.parse().ok()?;
    number.is_finite().then_some(number)
}

/// The distance of a coordinate to the next 32-bit number.
pub(crate) fn step_of(coordinate: f64) -> f64 {
    let nearest = coordinate.abs() as f32;
    f64::from(nearest.next_up()) - f64::from(nearest)
}

#[cfg(test)]
mod tests {
    use super::parse_decimal;

    #[test]
    fn plain_decimals_are_read() {
        assert_eq!(parse_decimal(b"-1.5e+2"), Some(-150.0));
        assert_eq!(parse_decimal(b"+.5"), Some(0.5));
        assert_eq!(parse_decimal(b"2."), Some(2.0));
    }

    #[test]
    fn everything_else_is_refused() {
        for text in ["", "nan", "inf", "-Infinity", "1,5", "0x10", "1e999", "1 2", "--1", "e5", "1e", "1_000"] {
            assert_eq!(parse_decimal(text.as_bytes()), None, "{text}");
        }
    }
}
