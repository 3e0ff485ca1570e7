//! The parameters of a directive: `"type name" value` or `"type name" [ values ]`, in any number and order.

use std::cell::Cell;
use std::fmt::Display;
use std::rc::Rc;

use rt_math::DVec3;

use crate::LoadErrorKind;
use crate::error::{ErrorInLine, LineError};
use crate::limits;
use crate::text::tokenizer::{TokenKind, Tokenizer, number, shown};

/// The types that the format has, and how many numbers make one value; 0 for those of words.
const TYPES: [(&str, usize); 16] = [
    ("integer", 1),
    ("float", 1),
    ("point2", 2),
    ("vector2", 2),
    ("point3", 3),
    ("point", 3),
    ("vector3", 3),
    ("vector", 3),
    ("normal3", 3),
    ("normal", 3),
    ("rgb", 3),
    ("blackbody", 1),
    ("spectrum", 0),
    ("string", 0),
    ("texture", 0),
    ("bool", 0),
];

/// The values of a parameter. Each scope has a copy of the attributes that hold in it, which share their values.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Numbers(Rc<[f64]>),
    Words(Rc<[String]>),
}

/// Parameter, with a flag for its use.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub(super) line: usize,
    pub(super) kind: &'static str,
    pub(super) name: String,
    pub(super) values: Values,
    /// Shared by the copies of an attribute: it is enough that one of them is of use.
    used: Rc<Cell<bool>>,
    /// True if it comes from the attributes of a scope.
    is_attribute: bool,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Parameters {
    pub(super) line: usize,
    list: Vec<Parameter>,
}

impl Parameter {
    /// True if it or a copy of it has been read.
    pub(super) fn is_used(&self) -> bool {
        self.used.get()
    }

    fn read(tokens: &mut Tokenizer<'_>) -> Result<Self, LineError> {
        let line = tokens.line();
        let declared = tokens.text("the type and name of a parameter")?;
        let mut words = declared.split_whitespace();
        let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
            let rule = "is not a parameter: give its type and its name, such as \"float radius\"";
            return Err(LineError::new(line, format_args!("`\"{declared}\"`"), rule));
        };
        let Some((kind, size)) = TYPES.iter().copied().find(|(known, _)| *known == kind) else {
            return Err(unknown("type of a parameter", kind, line, TYPES.map(|(known, _)| known)));
        };
        let values = Self::values(tokens, name)?;
        let fits = match &values {
            Values::Numbers(numbers) if size > 0 => numbers.len().is_multiple_of(size),
            // A spectrum is a name, or pairs of wavelength and value.
            Values::Numbers(numbers) => kind == "spectrum" && numbers.len().is_multiple_of(2),
            Values::Words(_) => size == 0,
        };
        if !fits {
            let rule = match size {
                0 if kind == "spectrum" => "of type spectrum needs a name, or pairs of wavelength and value".to_owned(),
                0 => format!("of type {kind} needs strings or booleans, not numbers"),
                1 => format!("of type {kind} needs numbers"),
                _ => format!("of type {kind} needs {size} numbers for each value"),
            };
            return Err(LineError::new(line, format_args!("the parameter \"{name}\""), rule));
        }
        Ok(Self { line, kind, name: name.to_owned(), values, used: Rc::default(), is_attribute: false })
    }

    /// Reads the value of a parameter, or its values in brackets.
    pub(super) fn values(tokens: &mut Tokenizer<'_>, name: &str) -> Result<Values, LineError> {
        let what = format!("a value of \"{name}\"");
        let (mut numbers, mut words) = (Vec::new(), Vec::new());
        let mut add = |line: usize, kind: TokenKind<'_>| {
            match kind {
                TokenKind::Text(text) => words.push(text),
                TokenKind::Word(word @ ("true" | "false")) => words.push(word.to_owned()),
                other => numbers.push(number(line, &other, &what)?),
            }
            if numbers.is_empty() || words.is_empty() {
                Ok(())
            } else {
                Err(LineError::new(line, format_args!("the parameter \"{name}\""), "mixes numbers and words"))
            }
        };
        match tokens.next_kind(&what)? {
            (_, TokenKind::Open) => loop {
                match tokens.peek() {
                    // A directive here means that the bracket was never closed.
                    Some(TokenKind::Word(word)) if word.starts_with(|c: char| c.is_ascii_uppercase()) => {
                        let rule = format!("is not a value; expected {what} or `]`");
                        return Err(LineError::new(tokens.line(), format_args!("`{word}`"), rule));
                    }
                    _ => {}
                }
                match tokens.next_kind(&what)? {
                    (_, TokenKind::Close) => break,
                    (line, kind) => add(line, kind)?,
                }
            },
            (line, kind @ TokenKind::Close) => {
                return Err(LineError::new(line, shown(&kind), format!("is not a value; expected {what}")));
            }
            (line, kind) => add(line, kind)?,
        }
        Ok(if words.is_empty() { Values::Numbers(numbers.into()) } else { Values::Words(words.into()) })
    }

    /// Error about its value.
    pub(super) fn error(&self, value: impl Display, rule: impl Into<String>) -> LineError {
        LineError::new(self.line, format_args!("\"{}\": {value}", self.name), rule)
    }
}

impl Parameters {
    /// Reads all parameters of the directive in `line`.
    pub(super) fn read(tokens: &mut Tokenizer<'_>, line: usize) -> Result<Self, LineError> {
        let mut list: Vec<Parameter> = Vec::new();
        while let Some(TokenKind::Text(_)) = tokens.peek() {
            let parameter = Parameter::read(tokens)?;
            if list.iter().any(|before| before.name == parameter.name && before.kind == parameter.kind) {
                let rule = "is given twice: keep one";
                return Err(LineError::new(parameter.line, format_args!("the parameter \"{}\"", parameter.name), rule));
            }
            list.push(parameter);
            check_count(line, list.len())?;
        }
        Ok(Self { line, list })
    }

    /// Adds parameters of `defaults` that are missing here.
    pub(super) fn or(mut self, defaults: &Self) -> Self {
        for default in &defaults.list {
            if self.list.iter().all(|given| given.name != default.name) {
                self.list.push(default.clone());
            }
        }
        self
    }

    /// Puts others over these.
    pub(super) fn replace_by(&mut self, others: Self) -> Result<(), LineError> {
        let before = std::mem::replace(self, others);
        *self = std::mem::take(self).or(&before);
        check_count(self.line, self.list.len())
    }

    /// The parameter of this name, which counts as used from now on.
    pub(super) fn get(&self, name: &str) -> Option<&Parameter> {
        let found = self.list.iter().find(|parameter| parameter.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// Marks parameters as used that have no effect here.
    pub(super) fn pass_over(&self, names: &[&str]) {
        for name in names {
            let _ = self.get(name);
        }
    }

    /// Lines and names of unused parameters. Attributes are excluded: not every shape uses them.
    pub(super) fn unused(&self) -> Vec<(usize, &str)> {
        let unused = self.list.iter().filter(|p| !p.used.get() && !p.is_attribute);
        unused.map(|p| (p.line, p.name.as_str())).collect()
    }

    /// These parameters as attributes; each records whether it was used.
    pub(super) fn into_attributes(mut self) -> (Self, Vec<Parameter>) {
        for parameter in &mut self.list {
            parameter.is_attribute = true;
        }
        let list = self.list.clone();
        (self, list)
    }

    /// All numbers of a parameter of one of the types; empty if it is missing.
    pub(super) fn numbers(&self, name: &str, types: &[&str]) -> Result<&[f64], LineError> {
        let Some(parameter) = self.get(name) else { return Ok(&[]) };
        match &parameter.values {
            Values::Numbers(numbers) if types.contains(&parameter.kind) => Ok(numbers),
            _ => Err(parameter.error(parameter.kind, format!("has the wrong type: give {}", types[0]))),
        }
    }

    fn one<const N: usize>(&self, name: &str, types: &[&str]) -> Result<Option<[f64; N]>, LineError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        let numbers = self.numbers(name, types)?;
        let one = numbers.try_into();
        one.map(Some).map_err(|_| parameter.error(format_args!("{} numbers,", numbers.len()), format!("expected {N}")))
    }

    pub(super) fn float(&self, name: &str, default: f64) -> Result<f64, LineError> {
        Ok(self.one(name, &["float", "integer"])?.map_or(default, |[number]| number))
    }

    /// A number above 0.
    pub(super) fn positive(&self, name: &str, default: f64) -> Result<f64, LineError> {
        let number = self.float(name, default)?;
        match self.get(name) {
            Some(parameter) if number <= 0.0 => Err(parameter.error(number, "must be above 0")),
            _ => Ok(number),
        }
    }

    /// A number from 0 up.
    pub(super) fn not_negative(&self, name: &str, default: f64) -> Result<f64, LineError> {
        let number = self.float(name, default)?;
        match self.get(name) {
            Some(parameter) if number < 0.0 => Err(parameter.error(number, "must not be negative")),
            _ => Ok(number),
        }
    }

    pub(super) fn point(&self, name: &str, default: DVec3) -> Result<DVec3, LineError> {
        Ok(self.one(name, &["point3", "point"])?.map_or(default, |p: [f64; 3]| p.into()))
    }

    pub(super) fn word(&self, name: &str, kind: &str) -> Result<Option<&str>, LineError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        match &parameter.values {
            Values::Words(words) if parameter.kind == kind && words.len() == 1 => Ok(words.first().map(String::as_str)),
            _ => Err(parameter.error(parameter.kind, format!("must be one {kind}"))),
        }
    }

    /// `true` or `false`.
    pub(super) fn flag(&self, name: &str) -> Result<bool, LineError> {
        match self.word(name, "bool")? {
            Some("true") => Ok(true),
            None | Some("false") => Ok(false),
            Some(other) => Err(LineError::new(
                self.line,
                format_args!("`{other}`"),
                format!("is neither true nor false, as \"{name}\" must be"),
            )),
        }
    }

    /// Points, vectors or normals of three numbers.
    pub(super) fn triples(&self, name: &str, types: &[&str]) -> Result<Vec<[f64; 3]>, LineError> {
        Ok(self.numbers(name, types)?.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect())
    }

    /// Whole numbers from 0 up to the last of `count`.
    pub(super) fn indices(&self, name: &str, count: usize) -> Result<Vec<u32>, LineError> {
        let Some(parameter) = self.get(name) else { return Ok(Vec::new()) };
        let index = |&number: &f64| {
            if number >= 0.0 && number < count as f64 && number.fract() == 0.0 {
                Ok(number as u32)
            } else {
                Err(parameter.error(number, format!("is not a vertex: there are {count}, counted from 0")))
            }
        };
        self.numbers(name, &["integer"])?.iter().map(index).collect()
    }
}

/// Limits the number of parameters, so that finding one takes a short time.
fn check_count(line: usize, count: usize) -> Result<(), LineError> {
    let limit = limits::PARAMETERS as u64;
    LoadErrorKind::check_limit("the number of parameters", count as u64, limit).in_line(line)
}

/// A name that no directive has defined. The reader adds the defined names if the error is listed.
pub(super) fn undefined(kind: &'static str, name: &str, line: usize) -> LineError {
    LineError { line, kind: LoadErrorKind::unknown(kind, name, Vec::new()) }
}

/// A word that is not among those that are known.
pub(super) fn unknown<'a>(
    kind: &'static str,
    found: &str,
    line: usize,
    known: impl IntoIterator<Item = &'a str>,
) -> LineError {
    let known = known.into_iter().filter(|word| !word.is_empty()).map(str::to_owned).collect();
    LineError { line, kind: LoadErrorKind::unknown(kind, found, known) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Parameters, String> {
        Parameters::read(&mut Tokenizer::new(text), 1).map_err(|error| format!("{}: {}", error.line, error.kind))
    }

    #[test]
    fn values_have_the_type_that_they_say() {
        let p = read(
            "\"float r\" 2 \"point3 P\" [1 2 3 4 5 6]\n\"bool on\" true \"string s\" [\"a b\"] \"integer i\" [0 1]",
        )
        .unwrap();
        assert_eq!((p.float("r", 1.0).unwrap(), p.float("q", 1.0).unwrap()), (2.0, 1.0));
        assert_eq!(p.triples("P", &["point3"]).unwrap(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert!(p.flag("on").unwrap() && !p.flag("off").unwrap());
        assert_eq!(p.unused(), [(2, "s"), (2, "i")]);
        assert_eq!(p.word("s", "string").unwrap(), Some("a b"));
        assert_eq!(p.indices("i", 2).unwrap(), [0, 1]);
        let message = p.indices("i", 1).unwrap_err().kind.to_string();
        assert_eq!(message, "\"i\": 1 is not a vertex: there are 1, counted from 0");
        assert!(p.float("P", 0.0).is_err() && p.word("r", "string").is_err() && p.point("P", DVec3::ZERO).is_err());
    }

    #[test]
    fn every_bad_parameter_is_named() {
        for (text, message) in [
            ("\"radius\" 1", "1: `\"radius\"` is not a parameter"),
            ("\n\"flaot r\" 1", "2: unknown type of a parameter `flaot`; did you mean `float`?"),
            ("\"rgb c\" [1 2]", "1: the parameter \"c\" of type rgb needs 3 numbers for each value"),
            ("\"float r\" \"a\"", "1: the parameter \"r\" of type float needs numbers"),
            ("\"string s\" 1", "1: the parameter \"s\" of type string needs strings"),
            ("\"float r\" [1 \"a\"]", "1: the parameter \"r\" mixes numbers and words"),
            ("\"float r\" [1\nShape", "2: `Shape` is not a value; expected a value of \"r\" or `]`"),
            ("\"float r\" x", "1: `x` is not a number; expected a value of \"r\""),
            ("\"float r\"", "1: the end of the file comes before a value of \"r\""),
            ("\"float r\" 1 \"float r\" 2", "1: the parameter \"r\" is given twice"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(message), "{text}: {error}");
        }
    }

    #[test]
    fn defaults_hold_where_nothing_is_said() {
        let mut all = read("\"float a\" 1 \"float b\" 1").unwrap();
        all.replace_by(read("\"float b\" 2").unwrap()).unwrap();
        let own = read("\"float a\" 3").unwrap().or(&all);
        assert_eq!((own.float("a", 0.0).unwrap(), own.float("b", 0.0).unwrap()), (3.0, 2.0));
    }

    #[test]
    fn parameters_are_counted() {
        let text: String = (0..300).map(|i| format!("\"float p{i}\" 1 ")).collect();
        assert_eq!(read(&text).unwrap_err(), "1: the number of parameters is 257, above the limit of 256");
    }
}
