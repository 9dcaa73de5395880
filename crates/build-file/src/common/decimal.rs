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

/// Appends the shortest digits that read back as the same number, without an exponent, as `{}` prints them.
pub(crate) fn push_decimal(text: &mut Vec<u8>, number: f64) {
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format(number);
    let places = digits.split_once('.').map_or(0, |(_, places)| places.len());
    match digits.strip_suffix(".0") {
        Some(whole) => text.extend_from_slice(whole.as_bytes()),
        None if digits.contains('e') || is_tie(number, places) => text.extend_from_slice(number.to_string().as_bytes()),
        None => text.extend_from_slice(digits.as_bytes()),
    }
}

/// Whether a number lies in the middle between two with so many decimal places: the standard library takes the greater one, others the
/// even one. `number` is not nearer to 0 than 1e-300.
fn is_tie(number: f64, places: usize) -> bool {
    // An odd integer times a power of two; times a power of ten it is half of an odd integer.
    let (bits, hidden) = (number.to_bits(), 1 << 52);
    let exponent = (bits >> 52 & 0x7ff) as i32 - 1075;
    exponent + ((bits | hidden) & (2 * hidden - 1)).trailing_zeros() as i32 + places as i32 == -1
}

/// Appends the digits of a number.
pub(crate) fn push_index(text: &mut Vec<u8>, mut number: u32) {
    let start = text.len();
    loop {
        text.push(b'0' + (number % 10) as u8);
        number /= 10;
        if number == 0 {
            break;
        }
    }
    text[start..].reverse();
}

/// The distance of a coordinate to the next 32-bit number.
pub(crate) fn step_of(coordinate: f64) -> f64 {
    let nearest = coordinate.abs() as f32;
    f64::from(nearest.next_up()) - f64::from(nearest)
}

#[cfg(test)]
mod tests {
    use super::{parse_decimal, push_decimal, push_index};

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

    #[test]
    fn numbers_are_written_as_the_standard_library_prints_them() {
        let decimal = |number: f64| {
            let mut text = Vec::new();
            push_decimal(&mut text, number);
            assert_eq!(String::from_utf8(text).unwrap(), number.to_string());
        };
        for number in [0.0, -0.0, 1.0, -2.5, 1e-7, 123_456.75, 1e15, 1e16, 1e17, 1e300, 5e-324, f64::MAX, 0.1 + 0.2] {
            decimal(number);
        }
        let mut bits = 0x2545_f491_4f6c_dd1d_u64;
        for _ in 0..200_000 {
            bits = bits.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29) ^ 0x94d0_49bb_1331_11eb;
            let any = f64::from_bits(bits);
            decimal(if any.is_finite() { any } else { 0.0 });
            let coordinate = (bits >> 11) as f64 * 2e-13 - 900.0;
            decimal(coordinate);
            decimal(f64::from(coordinate as f32));
        }
    }

    #[test]
    fn indices_are_written_in_full() {
        for number in [0, 7, 10, 99, 100, 4_294_967_295] {
            let mut text = Vec::new();
            push_index(&mut text, number);
            assert_eq!(String::from_utf8(text).unwrap(), number.to_string());
        }
    }
}
