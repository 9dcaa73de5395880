//! Decimal numbers as STL and 3MF files write them.

/// A finite decimal number: digits, sign, point and exponent only, so neither `nan`, `inf` and `0x10` nor `1,5`.
pub(super) fn decimal(text: &[u8]) -> Option<f64> {
    let plain = |&c: &u8| c.is_ascii_digit() || matches!(c, b'+' | b'-' | b'.' | b'e' | b'E');
    if !text.iter().all(plain) {
        return None;
    }
    let number: f64 = std::str::from_utf8(text).ok()?.parse().ok()?;
    number.is_finite().then_some(number)
}

#[cfg(test)]
mod tests {
    use super::decimal;

    #[test]
    fn plain_decimals_are_read() {
        assert_eq!(decimal(b"-1.5e+2"), Some(-150.0));
        assert_eq!(decimal(b"+.5"), Some(0.5));
        assert_eq!(decimal(b"2."), Some(2.0));
    }

    #[test]
    fn everything_else_is_refused() {
        for text in ["", "nan", "inf", "-Infinity", "1,5", "0x10", "1e999", "1 2", "--1", "e5", "1e", "1_000"] {
            assert_eq!(decimal(text.as_bytes()), None, "{text}");
        }
    }
}
