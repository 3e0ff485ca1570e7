//! Values with a short spelling: `0.5` for `gray(0.5)`.
//!
//! JSON values describe their type. RON does so for plain values only: from `gray(0.5)` it would keep the number and lose the
//! name. RON values are therefore read as raw text, and parsed by their first character.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::ron_options::ron_options;

/// Name that makes `ron` return the raw text of a value.
const RAW: &str = "$ron::private::RawValue";

/// Error of a value that has none of its spellings. It never leaves the parser, which finds better words.
pub(super) const NO_SPELLING: &str = "none of the spellings";

/// A type with short spellings.
pub(super) trait Spelled: Sized {
    /// Reads the spelling of the type itself, a choice such as `rgb(1, 0, 0)`.
    fn choice<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error>;

    /// Value of a number, if the type accepts one.
    fn from_number(_number: f64) -> Option<Self> {
        None
    }

    /// Value of three numbers, if the type accepts them.
    fn from_numbers(_numbers: [f64; 3]) -> Option<Self> {
        None
    }

    /// Value of a string.
    fn from_text(text: &str) -> Option<Self>;
}

/// Reads a value in any of its spellings.
pub(super) fn read<'de, T: Spelled, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    match from.deserialize_newtype_struct(RAW, TextOrValue(PhantomData))? {
        Reading::Value(value) => Ok(value),
        Reading::Text(text) => from_ron(&text).ok_or_else(|| D::Error::custom(NO_SPELLING)),
    }
}

/// A value that is spelled as a choice.
pub(super) struct Choice<T>(T);

impl<'de, T: Spelled> Deserialize<'de> for Choice<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        T::choice(from).map(Self)
    }
}

fn from_ron<T: Spelled>(text: &str) -> Option<T> {
    let options = ron_options();
    let first = super::cursor::next(text, 0)?;
    match text.as_bytes()[first] {
        b'"' => T::from_text(&options.from_str::<String>(text).ok()?),
        b'(' => T::from_numbers(options.from_str::<(f64, f64, f64)>(text).ok()?.into()),
        b'[' => T::from_numbers(options.from_str::<Vec<f64>>(text).ok()?.try_into().ok()?),
        _ => {
            if let Ok(number) = options.from_str::<f64>(text) {
                return T::from_number(number);
            }
            // The arguments of a choice: `ambient(1, 0.5, 0)`.
            if let Ok(numbers) = options.from_str::<(f64, f64, f64)>(&format!("({text})")) {
                return T::from_numbers(numbers.into());
            }
            options.from_str::<Choice<T>>(text).ok().map(|Choice(value)| value)
        }
    }
}

enum Reading<T> {
    /// The text of a value in RON.
    Text(String),
    Value(T),
}

/// Takes the text of a value from `ron`, and the value from others.
struct TextOrValue<T>(PhantomData<T>);

impl<'de, T: Spelled> Visitor<'de> for TextOrValue<T> {
    type Value = Reading<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(NO_SPELLING)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        Ok(Reading::Text(text.to_owned()))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, from: D) -> Result<Self::Value, D::Error> {
        from.deserialize_any(AnySpelling(PhantomData)).map(Reading::Value)
    }
}

/// Takes a value of whatever type it is.
struct AnySpelling<T>(PhantomData<T>);

fn some<T, E: Error>(value: Option<T>) -> Result<T, E> {
    value.ok_or_else(|| E::custom(NO_SPELLING))
}

impl<'de, T: Spelled> Visitor<'de> for AnySpelling<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(NO_SPELLING)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<T, E> {
        some(T::from_number(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<T, E> {
        some(T::from_number(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<T, E> {
        some(T::from_number(number as f64))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
        some(T::from_text(text))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<T, A::Error> {
        let mut numbers = [0.0; 3];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = elements.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        if elements.next_element::<IgnoredAny>()?.is_some() {
            return Err(A::Error::invalid_length(numbers.len() + 1, &self));
        }
        some(T::from_numbers(numbers))
    }

    fn visit_map<A: MapAccess<'de>>(self, entries: A) -> Result<T, A::Error> {
        T::choice(MapAccessDeserializer::new(entries))
    }
}
