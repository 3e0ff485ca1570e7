//! Too little memory, told before it is taken.

use std::error::Error;
use std::fmt;

/// A number of bytes, told in the unit that fits, which may round it: `1.5 GiB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Size(pub u64);

/// More memory would be needed than is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shortage {
    /// Bytes that would be needed in all.
    pub predicted: u64,
    /// Bytes that are allowed.
    pub budget: u64,
    /// What needs most of them.
    pub largest: String,
    /// Bytes that this needs.
    pub most: u64,
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 5] = ["KiB", "MiB", "GiB", "TiB", "PiB"];
        if self.0 < 1024 {
            return write!(f, "{} B", self.0);
        }
        let mut value = self.0 as f64 / 1024.0;
        let mut unit = 0;
        // What would be rounded to 1024 of a unit is one of the next.
        while value >= 1023.95 && unit + 1 < UNITS.len() {
            value /= 1024.0;
            unit += 1;
        }
        write!(f, "{value:.1} {}", UNITS[unit])
    }
}

impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [predicted, budget, most] = [self.predicted, self.budget, self.most].map(Size);
        write!(
            f,
            "needs {predicted} of memory, which is more than the {budget} that are allowed (--memory); most of it, {most}, is \
             for {}",
            self.largest
        )
    }
}

impl Error for Shortage {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_the_unit_that_fits() {
        let told = |bytes: u64| Size(bytes).to_string();
        assert_eq!([told(0), told(1023), told(1536)], ["0 B", "1023 B", "1.5 KiB"]);
        assert_eq!([told((1 << 20) - 1), told(u64::MAX)], ["1.0 MiB", "16384.0 PiB"]);
    }
}
