//! Numbers in reports.

/// Number with this many significant digits, without trailing zeros; with an exponent outside of 10⁻⁴ to 10⁶.
pub fn short_number(value: f64, digits: i32) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || !magnitude.is_finite() {
        return value.to_string();
    }
    if !(1e-4..1e6).contains(&magnitude) {
        return format!("{value:.*e}", digits.unsigned_abs() as usize - 1);
    }
    let places = (digits - 1 - magnitude.log10().floor() as i32).max(0);
    let text = format!("{value:.*}", places.unsigned_abs() as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (9.8, "9.8"),
            (0.245_219, "0.2452"),
            (0.0, "0"),
            (1234.0, "1234"),
            (123_456.0, "123456"),
            (2.5e-7, "2.500e-7"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short_number(value, 4), text);
        }
    }
}
