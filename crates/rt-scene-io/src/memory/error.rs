//! Error of a memory budget that is too small.

use std::error::Error;
use std::fmt;

use bytesize::ByteSize;

/// More memory would be needed than is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemoryError {
    /// Bytes that would be needed in all.
    pub predicted: u64,
    /// Bytes that are allowed.
    pub budget: u64,
    /// Name of the largest part.
    pub largest: String,
    /// Bytes of [`largest`](Self::largest).
    pub most: u64,
}

impl fmt::Display for MemoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [predicted, budget, most] = [self.predicted, self.budget, self.most].map(ByteSize);
        write!(
            f,
            "needs {predicted} of memory, more than the limit of {budget} (raise --memory); most of it, {most}, is for {}",
            self.largest
        )
    }
}

impl Error for MemoryError {}
