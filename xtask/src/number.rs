//! Numbers as tables show them.

/// A number with at least three digits that count, unless it is 0; digits in groups of three.
pub(crate) fn three_digits(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    if (999.5..1e15).contains(&number) {
        return grouped(number.round() as u64);
    }
    let mut decimals = 0;
    let mut scaled = number;
    // What rounds to 100 has its three digits.
    while scaled < 99.95 && decimals < 9 {
        scaled *= 10.0;
        decimals += 1;
    }
    format!("{number:.decimals$}")
}

/// Digits in groups of three.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.char_indices() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_keep_their_digits() {
        assert_eq!([123.4, 1.234, 0.0001234].map(three_digits), ["123", "1.23", "0.000123"]);
        assert_eq!(
            [0.0, f64::NAN, 999.4, 999.5, 1_234_567.8].map(three_digits),
            ["0", "NaN", "999", "1,000", "1,234,568"]
        );
    }

    #[test]
    fn digits_are_grouped() {
        assert_eq!([0, 999, 1000, 14_745_600].map(grouped), ["0", "999", "1,000", "14,745,600"]);
    }
}
