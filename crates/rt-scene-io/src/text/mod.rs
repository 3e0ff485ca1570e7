//! Readers of text formats without a nested grammar: tokens with their lines, and logical lines.

#[cfg(feature = "obj")]
pub(crate) mod lines;
#[cfg(any(feature = "nff", feature = "pbrt"))]
pub(crate) mod tokenizer;
