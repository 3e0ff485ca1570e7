//! Errors of scenes and models, with their locations.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use rt_camera::CameraError;
use rt_geometry::{MeshError, PolygonError, ShapeError};
use rt_math::TransformError;

use crate::MemoryError;
use crate::excerpt::{Excerpt, Position};
use crate::format::positions_of;
use crate::sanitize::{SingleLine, shortened_reference};
use crate::texture_error::TextureError;

/// All errors of a scene or model: at least one [`Diagnostic`]. Each is printed on a line of its own, followed by the line of
/// the file where it is known.
#[derive(Debug)]
pub struct LoadError {
    diagnostics: Vec<Diagnostic>,
}

/// One error and its location.
#[derive(Debug, thiserror::Error)]
#[error("{}{}", SingleLine(format_args!("{file}{location}: {kind}")), excerpt.as_ref().map_or_else(String::new, |excerpt| format!("\n{excerpt}")))]
pub struct Diagnostic {
    /// The file, as the user named it.
    pub file: String,
    /// Location in the file.
    pub location: Location,
    /// Error, with the value and the remedy.
    #[source]
    pub kind: LoadErrorKind,
    /// The line of the file, if its text is at hand.
    pub excerpt: Option<Excerpt>,
}

/// Location in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Location {
    /// The file as a whole.
    #[default]
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A line and a column, both counted from 1.
    Position(usize, usize),
    /// A path in the document such as `nodes[2].material`, or the name of an object.
    Path(String),
    /// A path in a scene file, and the line and column at which it begins, both counted from 1.
    PathAt(String, usize, usize),
}

/// Kind of an error. Each message holds the offending value, the rule, and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadErrorKind {
    /// The operating system refuses.
    #[error("{}", unreadable(.0))]
    Io(#[from] io::Error),
    /// A directory.
    #[error("is a directory; give the path of a file")]
    Directory,
    /// A pipe or a device.
    #[error("is not a regular file; give the path of a file")]
    NotAFile,
    /// A file without content.
    #[error("is empty (0 bytes)")]
    Empty,
    /// More than a limit allows.
    #[error("{} is {value}, above the limit of {limit}{}", name_and_option(what).0, raise_option(what))]
    TooLarge {
        /// Name of the quantity with its unit, and the option that sets the limit in parentheses, if there is one.
        what: &'static str,
        /// Its value.
        value: u64,
        /// Its maximum.
        limit: u64,
    },
    /// More memory than the budget allows; predicted before it is taken.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// Text in another encoding, recognised by its byte order mark.
    #[error("is text in {0}: save it as UTF-8")]
    OtherEncoding(&'static str),
    /// Bytes that are not text.
    #[error("is not UTF-8 text: the byte at offset {0} is invalid; save it as UTF-8")]
    NotUtf8(usize),
    /// Unknown file extension, or a format that is not compiled in.
    #[error("has no known extension (known are {known}); rename it, or convert it with another program")]
    UnknownFormat {
        /// Supported extensions.
        known: &'static str,
    },
    /// A reference to a file elsewhere.
    #[error("`{}` {rule}", shortened_reference(reference))]
    BadReference {
        /// The reference as written.
        reference: String,
        /// Reason for the refusal.
        rule: String,
    },
    /// A reference to a missing file.
    #[error("`{}` does not exist (looked for {})", shortened_reference(reference), shortened_reference(&looked_for.to_string_lossy()))]
    MissingReference {
        /// The reference as written.
        reference: String,
        /// The file that it means.
        looked_for: PathBuf,
    },
    /// The text does not follow the format. The message comes from its parser.
    #[error("{0}")]
    Syntax(String),
    /// A field or variant that does not exist.
    #[error("unknown {kind} `{found}`{}", if known.is_empty() { format!("; no {kind}s are defined") } else { suggestion(nearest(found, known), known) })]
    UnknownWord {
        /// "field", "material", ...
        kind: &'static str,
        /// The word as written.
        found: String,
        /// The words that exist.
        known: Vec<String>,
    },
    /// Two entries of the same name.
    #[error("there are two {kind}s named `{name}`; rename one of them")]
    Duplicate {
        /// "material", "camera", ...
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A value that breaks a rule.
    #[error("{value} {rule}")]
    Invalid {
        /// The value as written.
        value: String,
        /// The rule that it breaks.
        rule: String,
    },
    /// Groups that contain each other.
    #[error("groups contain each other: {}; remove one of the instances", chain(.0))]
    Cycle(Vec<String>),
    /// Errors beyond the number that is shown.
    #[error("{0} more errors are not listed; fix these first")]
    More(usize),
    /// Something valid that this program does not do.
    #[error("{0} is not supported")]
    Unsupported(String),
    /// A bad shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A bad polygon.
    #[error(transparent)]
    Polygon(#[from] PolygonError),
    /// A bad mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A bad camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A bad transform.
    #[error(transparent)]
    Transform(#[from] TransformError),
    /// A bad image.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

/// Names of a cycle. Of a long one, the first and last names, and the number between.
fn chain(names: &[String]) -> String {
    const SHOWN: usize = 4;
    let shown = |names: &[String]| names.join(" -> ");
    match names.len().checked_sub(2 * SHOWN) {
        None | Some(0..=1) => shown(names),
        Some(hidden) => {
            let (first, last) = (&names[..SHOWN], &names[SHOWN + hidden..]);
            format!("{} -> ({hidden} more) -> {}", shown(first), shown(last))
        }
    }
}

impl LoadErrorKind {
    /// A value that breaks a rule; the message reads "value rule".
    pub fn invalid(value: impl fmt::Display, rule: impl Into<String>) -> Self {
        Self::Invalid { value: value.to_string(), rule: rule.into() }
    }

    /// Refuses a quantity beyond one of the [`limits`](crate::limits).
    pub(crate) const fn check_limit(what: &'static str, value: u64, limit: u64) -> Result<(), Self> {
        if value > limit { Err(Self::TooLarge { what, value, limit }) } else { Ok(()) }
    }

    /// A reference that cannot be used; the message reads "`reference` rule".
    pub(crate) fn bad_reference(reference: &str, rule: impl fmt::Display) -> Self {
        Self::BadReference { reference: reference.to_owned(), rule: rule.to_string() }
    }

    /// A word that is not among the known ones.
    pub(crate) fn unknown(kind: &'static str, found: &str, known: Vec<String>) -> Self {
        Self::UnknownWord { kind, found: found.to_owned(), known }
    }

    /// This error at a location of a file.
    pub fn at(self, file: &Path, location: impl Into<Location>) -> LoadError {
        let (file, location) = (file.display().to_string(), location.into());
        LoadError { diagnostics: vec![Diagnostic { file, location, kind: self, excerpt: None }] }
    }
}

impl LoadError {
    /// All diagnostics as one error; `None` for an empty list.
    pub fn from_diagnostics(diagnostics: Vec<Diagnostic>) -> Option<Self> {
        (!diagnostics.is_empty()).then_some(Self { diagnostics })
    }

    /// Diagnostics in the order of their detection; at least one.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// Adds lines and columns to paths in a scene file, which has this text. Errors with them come first, in the order of the text.
    pub(crate) fn with_positions(mut self, file: &Path, text: &str) -> Self {
        let file = file.display().to_string();
        let located = |diagnostic: &&mut Diagnostic| diagnostic.file == file;
        let mut diagnostics: Vec<_> = self.diagnostics.iter_mut().filter(located).collect();
        let paths: Vec<_> = diagnostics.iter().map(|diagnostic| diagnostic.location.path().to_owned()).collect();
        let positions = positions_of(text, &paths.iter().map(String::as_str).collect::<Vec<_>>());
        for ((diagnostic, path), byte) in diagnostics.iter_mut().zip(paths).zip(positions) {
            if let Some(byte) = byte {
                let Position { line, column } = Position::of(text, byte);
                diagnostic.location = Location::PathAt(path, line, column);
                diagnostic.excerpt = Some(Excerpt::of(text, byte));
            }
        }
        self.diagnostics.sort_by_key(|diagnostic| match diagnostic.location {
            Location::PathAt(_, line, column) => (line, column),
            _ => (usize::MAX, 0),
        });
        self
    }

    /// The diagnostics, to add to others.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        self.diagnostics
    }
}

impl From<Diagnostic> for LoadError {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { diagnostics: vec![diagnostic] }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.diagnostics.iter().enumerate() {
            let line_break = if i == 0 { "" } else { "\n" };
            write!(f, "{line_break}{diagnostic}")?;
        }
        Ok(())
    }
}

impl std::error::Error for LoadError {}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Position(line, column) => write!(f, ":{line}:{column}"),
            Self::Path(path) => write!(f, ": {path}"),
            Self::PathAt(path, line, column) => write!(f, ":{line}:{column}: {path}"),
        }
    }
}

impl Location {
    /// Path in the document; empty for other locations.
    fn path(&self) -> &str {
        match self {
            Self::Path(path) | Self::PathAt(path, ..) => path,
            _ => "",
        }
    }
}

impl From<String> for Location {
    fn from(path: String) -> Self {
        if path.is_empty() { Self::File } else { Self::Path(path) }
    }
}

impl From<&str> for Location {
    fn from(path: &str) -> Self {
        path.to_owned().into()
    }
}

/// Adds the location to an error.
pub(crate) trait ErrorAt<T> {
    fn at(self, file: &Path, location: impl Into<Location>) -> Result<T, LoadError>;
}

impl<T, E: Into<LoadErrorKind>> ErrorAt<T> for Result<T, E> {
    fn at(self, file: &Path, location: impl Into<Location>) -> Result<T, LoadError> {
        self.map_err(|error| error.into().at(file, location))
    }
}

/// An error in a line of a text whose file name is not known yet.
#[cfg(any(feature = "nff", feature = "obj", feature = "pbrt"))]
#[derive(Debug)]
pub(crate) struct LineError {
    /// Counted from 1.
    pub(crate) line: usize,
    pub(crate) kind: LoadErrorKind,
}

#[cfg(any(feature = "nff", feature = "obj", feature = "pbrt"))]
impl LineError {
    /// A value that breaks a rule.
    pub(crate) fn new(line: usize, value: impl fmt::Display, rule: impl Into<String>) -> Self {
        Self { line, kind: LoadErrorKind::invalid(value, rule) }
    }

    /// This error in a file.
    pub(crate) fn in_file(self, file: &Path) -> Diagnostic {
        let Self { line, kind } = self;
        Diagnostic { file: file.display().to_string(), location: Location::Line(line), kind, excerpt: None }
    }
}

/// Adds the line to an error.
#[cfg(any(feature = "nff", feature = "pbrt"))]
pub(crate) trait ErrorInLine<T> {
    fn in_line(self, line: usize) -> Result<T, LineError>;
}

#[cfg(any(feature = "nff", feature = "pbrt"))]
impl<T, E: Into<LoadErrorKind>> ErrorInLine<T> for Result<T, E> {
    fn in_line(self, line: usize) -> Result<T, LineError> {
        self.map_err(|error| LineError { line, kind: error.into() })
    }
}

/// Name of a quantity, and the option that sets its limit.
fn name_and_option(what: &str) -> (&str, Option<&str>) {
    match what.strip_suffix(')').and_then(|what| what.rsplit_once(" (--")) {
        Some((name, option)) => (name, Some(option)),
        None => (what, None),
    }
}

/// Advice for a limit that an option sets.
fn raise_option(what: &str) -> String {
    name_and_option(what).1.map_or_else(String::new, |option| format!("; raise --{option}"))
}

/// Message of a file that cannot be opened or read.
pub fn unreadable(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "does not exist".to_owned(),
        _ => format!("cannot be read: {error}"),
    }
}

/// Suffix of a warning at the first of some equal findings.
pub(crate) fn times(count: usize) -> String {
    if count > 1 { format!(" ({count} times, this is the first)") } else { String::new() }
}

/// Longest list of known words that a message prints in full.
const MAX_LISTED: usize = 24;

/// "; did you mean ...?" with the word that is probably meant, and the list of all.
pub(crate) fn suggestion(meant: Option<&str>, known: &[String]) -> String {
    if known.is_empty() {
        return "; there are none".to_owned();
    }
    let mut listed = known.iter().take(MAX_LISTED).map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ");
    if known.len() > MAX_LISTED {
        listed.push_str(", ...");
    }
    match meant {
        Some(meant) => format!("; did you mean `{meant}`? Known are {listed}"),
        None => format!("; known are {listed}"),
    }
}

/// Most similar known word without regard to case, if the similarity is sufficient.
pub(crate) fn nearest<'k>(found: &str, known: &'k [String]) -> Option<&'k str> {
    let found = found.to_lowercase();
    // One wrong, missing or exchanged letter weighs much in a short word.
    let is_slip = |word: &str| found.len() > 2 && strsim::osa_distance(&found, word) == 1;
    let similarity = |word: &&String| {
        let word = word.to_lowercase();
        strsim::jaro_winkler(&found, &word).max(if is_slip(&word) { 0.9 } else { 0.0 })
    };
    let alike = known.iter().filter(|word| similarity(word) > 0.75);
    alike.max_by(|a, b| similarity(a).total_cmp(&similarity(b))).map(String::as_str)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_names_file_place_value_and_rule() {
        let error = LoadErrorKind::invalid(-1.0, "is not a positive radius").at(Path::new("a/b.ron"), "nodes[2].shape");
        assert_eq!(error.to_string(), "a/b.ron: nodes[2].shape: -1 is not a positive radius");
        let error = LoadErrorKind::Syntax("expected `)`".to_owned()).at(Path::new("b.ron"), Location::Position(3, 7));
        assert_eq!(error.to_string(), "b.ron:3:7: expected `)`");
        assert_eq!(LoadErrorKind::Empty.at(Path::new("b.ron"), "").to_string(), "b.ron: is empty (0 bytes)");
    }

    #[test]
    fn the_nearest_word_is_suggested() {
        let known = || ["radius", "center"].map(str::to_owned).to_vec();
        let unknown = |found: &str, known| LoadErrorKind::unknown("field", found, known);
        assert_eq!(
            unknown("raduis", known()).to_string(),
            "unknown field `raduis`; did you mean `radius`? Known are `radius`, `center`"
        );
        for (found, word) in [("PATH", "path"), ("KD", "kd"), ("sRGB", "srgb"), ("rde", "red")] {
            let known = ["whitted", "path", "kd", "srgb", "red"].map(str::to_owned);
            assert_eq!(nearest(found, &known), Some(word));
        }
        assert_eq!(unknown("xyz", known()).to_string(), "unknown field `xyz`; known are `radius`, `center`");
        assert_eq!(unknown("xyz", Vec::new()).to_string(), "unknown field `xyz`; no fields are defined");
    }
}
