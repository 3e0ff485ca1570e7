//! Memory limits.

use bytesize::ByteSize;
use clap::Args;

use crate::memory;

#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct MemoryArgs {
    /// Refuse work whose predicted memory exceeds this, such as 512M, 4GiB or 75%
    ///
    /// A percentage is of the memory of the machine, of its control group, or of `ulimit -v`, whichever is least. If none is known, there is
    /// no limit. K, M, G and T are powers of 1000; Ki, Mi, Gi and Ti are powers of 1024.
    #[arg(long, value_name = "BYTES", value_parser = amount, allow_hyphen_values = true, default_value = "75%", help_heading = "Limits")]
    memory: Amount,
}

impl MemoryArgs {
    /// Limit in bytes, if there is one.
    pub(crate) fn limit(self) -> Option<u64> {
        self.memory.of(memory::available_bytes())
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Amount {
    Bytes(u64),
    /// Share of the available memory.
    Share(f64),
}

impl Default for Amount {
    /// Leaves a quarter for the system and for errors of the prediction.
    fn default() -> Self {
        Self::Share(0.75)
    }
}

impl Amount {
    /// Bytes; `None` for a share of an unknown amount.
    pub(crate) fn of(self, available: Option<u64>) -> Option<u64> {
        match self {
            Self::Bytes(bytes) => Some(bytes),
            Self::Share(share) => available.map(|bytes| (bytes as f64 * share) as u64),
        }
    }
}

/// `512M`, `4GiB`, `75%`.
pub(super) fn amount(text: &str) -> Result<Amount, String> {
    match text.strip_suffix('%') {
        Some(percent) => {
            let percent =
                percent.trim_end().parse().ok().filter(|percent| (0.0..=100.0).contains(percent) && *percent > 0.0);
            percent
                .map(|percent: f64| Amount::Share(percent / 100.0))
                .ok_or_else(|| "expected a percentage greater than 0 and at most 100, such as 75%".to_owned())
        }
        None => bytes(text).map(Amount::Bytes).map_err(|error| error + ", or a percentage such as 75%"),
    }
}

/// `123456`, `512M`, `1.5GiB`.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    // What is too large for the type is read as its greatest value.
    match text.parse() {
        Ok(ByteSize(bytes)) if bytes > 0 && bytes < u64::MAX => Ok(bytes),
        _ => Err("expected a size greater than 0, such as 512M, 1.5GiB or 65536 (bytes)".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_have_units() {
        for (text, expected) in [
            ("65536", 65_536),
            ("1B", 1),
            ("512M", 512_000_000),
            ("512MB", 512_000_000),
            ("4GiB", 4 << 30),
            ("1.5 gib", 3 << 29),
            ("2Ki", 2048),
            ("1T", 1_000_000_000_000),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
            assert_eq!(amount(text), Ok(Amount::Bytes(expected)), "{text}");
        }
        for bad in ["", "0", "-1M", "1X", "1i", "1iB", "M", "1e3", "nan", "inf", "1 2", "1..5M", "99999999999T", "0.5"]
        {
            assert!(bytes(bad).is_err() && amount(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn shares_are_of_what_there_is() {
        let of = |text: &str, available| amount(text).expect(text).of(available);
        assert_eq!(
            (of("50%", Some(1000)), of("12.5 %", Some(1000)), of("100%", Some(7))),
            (Some(500), Some(125), Some(7))
        );
        assert_eq!((of("50%", None), of("1K", None)), (None, Some(1000)));
        assert_eq!(Amount::default().of(Some(1000)), Some(750));
        for bad in ["0%", "101%", "-1%", "nan%", "%", "1%%"] {
            assert!(amount(bad).is_err(), "{bad}");
        }
    }
}
