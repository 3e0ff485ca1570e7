//! Words that graphics programmers do not use for the thing, and the terms that they do use.
//!
//! Text in backticks and string literals may hold any word: file formats have spellings of their own.

/// Uses of a word that are checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scope {
    Prose,
    Names,
    Everywhere,
}

/// A word or a sequence of words, in lower case; the term to use; and the uses that are checked.
pub(super) type Banned = (&'static str, &'static str, Scope);

pub(super) const BANNED: [Banned; 72] = [
    // Data is not a person.
    ("nobody", "no caller, nothing", Scope::Everywhere),
    ("somebody", "a caller", Scope::Everywhere),
    ("asked", "tested, traced, queried", Scope::Everywhere),
    ("asks", "tests, traces, queries", Scope::Everywhere),
    ("told", "reported, computed, returned", Scope::Everywhere),
    ("tells", "reports, computes, returns", Scope::Everywhere),
    ("decided about", "intersected exactly", Scope::Prose),
    ("decides about", "intersects exactly", Scope::Prose),
    ("offered", "tested, queried", Scope::Everywhere),
    ("judge", "classify, test", Scope::Everywhere),
    ("judges", "classifies, tests", Scope::Everywhere),
    ("settled", "certain, resolved", Scope::Everywhere),
    ("settles", "resolves", Scope::Everywhere),
    ("sees to it", "ensures", Scope::Prose),
    ("spared", "skipped", Scope::Everywhere),
    ("spares", "skips", Scope::Everywhere),
    ("knows nothing", "does not depend on", Scope::Prose),
    ("so to speak", "(nothing)", Scope::Prose),
    ("of the house", "of the project", Scope::Prose),
    // Light and shading.
    ("lamp", "light source, emitter", Scope::Everywhere),
    ("lamps", "light sources, emitters", Scope::Everywhere),
    ("shines", "emits", Scope::Everywhere),
    ("shining", "emissive, emitting", Scope::Everywhere),
    ("light with extent", "area light", Scope::Prose),
    ("lights with extent", "area lights", Scope::Prose),
    ("light without extent", "delta light", Scope::Prose),
    ("lights without extent", "delta lights", Scope::Prose),
    ("draws a light", "samples a light", Scope::Prose),
    ("drawn from", "sampled from", Scope::Prose),
    ("single direction", "delta, specular", Scope::Everywhere),
    ("single directions", "delta, specular", Scope::Everywhere),
    ("transparent body", "dielectric", Scope::Everywhere),
    ("transparent bodies", "dielectrics", Scope::Everywhere),
    ("pane", "thin dielectric", Scope::Names),
    ("squeezed", "scaled by eta²", Scope::Everywhere),
    ("relief", "normal map", Scope::Everywhere),
    ("fibres", "sheen", Scope::Names),
    // Acceleration structures.
    ("own box", "padded bounds", Scope::Everywhere),
    ("own boxes", "padded bounds", Scope::Everywhere),
    ("put off", "deferred, pushed", Scope::Everywhere),
    ("unsure", "uncertain", Scope::Everywhere),
    ("maybes", "possible hits", Scope::Everywhere),
    ("handful", "small set", Scope::Everywhere),
    ("knob", "option", Scope::Everywhere),
    // Shapes.
    ("ball", "sphere", Scope::Names),
    ("balls", "spheres", Scope::Names),
    ("tube", "cylinder", Scope::Names),
    ("tubes", "cylinders", Scope::Names),
    // Everything else.
    ("moment", "time", Scope::Names),
    ("moments", "times", Scope::Names),
    ("by its bits", "bit-identical", Scope::Prose),
    ("with the bits of", "bit-identical to", Scope::Prose),
    ("to the bit", "bit-identical", Scope::Prose),
    ("picture", "image", Scope::Names),
    ("pictures", "images", Scope::Names),
    ("ending", "extension", Scope::Names),
    ("endings", "extensions", Scope::Names),
    ("beside", "compared with, next to", Scope::Everywhere),
    ("mend", "fix", Scope::Everywhere),
    ("mends", "fixes", Scope::Everywhere),
    ("load-warning", "fixed", Scope::Everywhere),
    ("flaw", "error", Scope::Everywhere),
    ("flaws", "errors", Scope::Everywhere),
    ("complaint", "error, warning", Scope::Everywhere),
    ("complaints", "errors, warnings", Scope::Everywhere),
    ("complain", "report", Scope::Names),
    ("trouble", "error, problem", Scope::Everywhere),
    ("shortage", "memory limit", Scope::Everywhere),
    ("least", "min", Scope::Names),
    ("greatest", "max", Scope::Names),
    ("room", "scratch, capacity", Scope::Names),
    ("yardstick", "reference", Scope::Everywhere),
];

/// Identifiers of more words read as sentences, as names of tests do; words banned in names alone are left to them.
pub(super) const MAX_WORDS_OF_NAME: usize = 4;

/// Sequences of words in names that are established in spite of a banned word.
pub(super) const ESTABLISHED: [&str; 2] = ["at least", "tube radius"];
