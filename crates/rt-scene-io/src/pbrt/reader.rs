//! The directives of a scene, one after the other.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Display;
use std::path::{Path, PathBuf};

use rt_math::{Rgb, Transform};
use rt_shading::TextureId;

use super::file_scope::FileScope;
use super::material::OptionalMaterial;
use super::parameters::{Parameter, Parameters, undefined, unknown};
use super::shape::DirectiveError;
use super::state::{GraphicsState, TRANSFORMS};
use super::texture::PbrtTextures;
use super::view::PbrtCamera;
use super::{material, state, view};
use crate::diagnostics::Diagnostics;
use crate::error::{ErrorInLine, LineError, times};
use crate::format::{Background, Color};
use crate::limits::{INCLUDE_DEPTH, INCLUDES, PBRT_ERRORS, SCOPES};
use crate::text::tokenizer::{Token, TokenKind, Tokenizer, shown};
use crate::{LoadError, LoadErrorKind, MaterialId, Model, SceneNode, Warning, read_text, resolve_path};

/// Directives before the world that choose an algorithm.
const CHOICES: [&str; 4] = ["Integrator", "Sampler", "PixelFilter", "Accelerator"];

/// Directives of the world.
const WORLD: [&str; 22] = [
    "Camera",
    "Film",
    "Option",
    "WorldBegin",
    "AttributeBegin",
    "AttributeEnd",
    "Attribute",
    "CoordinateSystem",
    "CoordSysTransform",
    "ReverseOrientation",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Include",
    "Import",
    "Texture",
    "Material",
    "MakeNamedMaterial",
    "NamedMaterial",
    "LightSource",
    "AreaLightSource",
    "Shape",
];

/// Directives that are read and left out.
const LEFT_OUT: [&str; 5] = ["ColorSpace", "MakeNamedMedium", "MediumInterface", "ActiveTransform", "TransformTimes"];

/// Targets of attributes.
const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// Key of a surface: its index, the bits of its emission and emission sides, and its alpha.
type MaterialKey = (usize, Option<([u64; 3], bool)>, (u64, Option<TextureId>));

pub(super) struct PbrtReader<'f> {
    pub(super) files: FileScope<'f>,
    /// The file that is read, for messages.
    pub(super) path: PathBuf,
    /// The files that are open, canonical.
    pub(super) open: Vec<PathBuf>,
    pub(super) includes: usize,
    pub(super) report: Diagnostics,
    pub(super) error_count: usize,
    /// Kinds and names of definitions that were not found.
    missing: Vec<(&'static str, String)>,
    pub(super) model: Model,
    /// Index of each message in the warnings, and the number of its occurrences.
    pub(super) warned: HashMap<String, (usize, usize)>,
    pub(super) state: GraphicsState,
    /// States saved by `AttributeBegin` and `ObjectBegin`, and their lines.
    pub(super) saved: Vec<(GraphicsState, usize, bool)>,
    /// All attributes: the file, their target, and the parameter.
    pub(super) attributes: Vec<(PathBuf, String, Parameter)>,
    pub(super) in_world: bool,
    pub(super) view: Option<PbrtCamera>,
    pub(super) size: [u32; 2],
    pub(super) systems: BTreeMap<String, Transform>,
    pub(super) textures: PbrtTextures,
    pub(super) surfaces: Vec<OptionalMaterial>,
    pub(super) named: BTreeMap<String, usize>,
    pub(super) materials: HashMap<MaterialKey, MaterialId>,
    pub(super) object: Option<(String, Vec<SceneNode>)>,
    pub(super) objects: BTreeMap<String, Vec<SceneNode>>,
    pub(super) nodes: Vec<SceneNode>,
    /// Number of nodes, instances unfolded.
    pub(super) unfolded: usize,
    pub(super) sky: Option<Rgb>,
    pub(super) emits: bool,
}

impl<'f> PbrtReader<'f> {
    pub(super) fn new(files: FileScope<'f>) -> Self {
        let textures = PbrtTextures::default();
        let default = Parameters::default();
        // The default material has no parameters, and is always valid.
        let grey = material::read("diffuse", &default, &textures, |_| Ok(None), &mut Vec::new()).ok().flatten();
        let grey = grey.map(|grey| crate::Material { name: "default".to_owned(), ..grey });
        Self {
            files,
            path: files.root_file.to_path_buf(),
            open: files.root_file.canonicalize().into_iter().collect(),
            includes: 0,
            report: Diagnostics::new(files.root_file),
            error_count: 0,
            missing: Vec::new(),
            model: Model::default(),
            warned: HashMap::new(),
            state: GraphicsState::default(),
            saved: Vec::new(),
            attributes: Vec::new(),
            in_world: false,
            view: None,
            size: [1280, 720],
            systems: BTreeMap::new(),
            textures,
            surfaces: vec![grey],
            named: BTreeMap::new(),
            materials: HashMap::new(),
            object: None,
            objects: BTreeMap::new(),
            nodes: Vec::new(),
            unfolded: 0,
            sky: None,
            emits: false,
        }
    }

    /// True if a name that was not found is defined further down.
    pub(super) fn has_forward_references(&self) -> bool {
        self.missing.iter().any(|(kind, name)| match *kind {
            "material" => self.named.contains_key(name),
            kind => self.textures.is_defined(kind, name),
        })
    }

    /// A reader of the same file that begins with the textures and materials of this one.
    pub(super) fn with_definitions(self) -> Self {
        let Self { files, textures, surfaces, named, .. } = self;
        Self { textures, surfaces, named, ..Self::new(files) }
    }

    /// Reads all directives of a text, and reports errors.
    pub(super) fn read(&mut self, text: &str) {
        let mut tokens = Tokenizer::new(text);
        while self.error_count < PBRT_ERRORS {
            let read = match tokens.take() {
                Ok(None) => return,
                Ok(Some(Token { line, kind: TokenKind::Word(word) })) => self.directive(word, line, &mut tokens),
                Ok(Some(Token { line, kind })) => {
                    Err(LineError::new(line, shown(&kind), "is not a directive: remove it").into())
                }
                Err(error) => Err(error.into()),
            };
            match read {
                Ok(()) => {}
                Err(DirectiveError::Line(mut error)) => {
                    if let LoadErrorKind::UnknownWord { kind, found, known } = &mut error.kind {
                        self.missing.push((kind, found.clone()));
                        if known.is_empty() {
                            *known = self.defined_names(kind);
                        }
                    }
                    self.report(error);
                    tokens.skip_to_directive();
                }
                Err(DirectiveError::File(error)) => {
                    self.error_count += 1;
                    self.report.add(error.into_diagnostics());
                }
            }
        }
    }

    /// Names for an error about an undefined name of this kind.
    fn defined_names(&self, kind: &str) -> Vec<String> {
        let mut names = match kind {
            "material" => self.report.names(self.named.keys()),
            "object" => self.report.names(self.objects.keys()),
            "coordinate system" => self.report.names(self.systems.keys()),
            kind => self.report.names(self.textures.names(kind)),
        };
        names.retain(|name| !name.is_empty());
        names
    }

    pub(super) fn report(&mut self, error: LineError) {
        self.error_count += 1;
        self.report.add([error.in_file(&self.path)]);
    }

    /// Adds a warning, or counts a repeated one.
    pub(super) fn warn(&mut self, line: usize, message: String) {
        if let Some((_, count)) = self.warned.get_mut(&message) {
            *count += 1;
            return;
        }
        self.warned.insert(message.clone(), (self.model.warnings.len(), 1));
        self.model.warnings.push(Warning { place: format!("{}:{line}", self.path.display()), message });
    }

    pub(super) fn warn_all(&mut self, directive: &str, parameters: &Parameters, warnings: Vec<String>) {
        for warning in warnings {
            self.warn(parameters.line, warning);
        }
        for (line, name) in parameters.unused() {
            self.warn(line, unsupported(name, directive));
        }
    }

    fn directive(&mut self, word: &str, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), DirectiveError> {
        match word {
            "Camera" | "Film" if self.in_world => {
                return Err(LineError::new(
                    line,
                    format_args!("`{word}`"),
                    "comes after the world has begun: put it before",
                )
                .into());
            }
            "Shape" | "LightSource" | "AreaLightSource" | "ObjectBegin" | "ObjectInstance" if !self.in_world => {
                return Err(
                    LineError::new(line, format_args!("`{word}`"), "comes before `WorldBegin`: move it after").into()
                );
            }
            _ if TRANSFORMS.contains(&word) => {
                let changed = state::transformed(&self.state.matrix, word, line, tokens)?;
                if self.state.at_end_time {
                    self.warn(line, "motion is not supported: objects keep their transform at the start".to_owned());
                } else {
                    self.state.matrix = changed;
                }
            }
            "CoordinateSystem" | "CoordSysTransform" | "ReverseOrientation" | "ActiveTransform" | "TransformTimes" => {
                self.space(word, line, tokens)?;
            }
            "Camera" | "Film" | "Option" | "WorldBegin" => self.option(word, line, tokens)?,
            _ if CHOICES.contains(&word) => {
                let name = tokens.text("the name of a choice")?;
                Parameters::read(tokens, line)?;
                self.model.notes.push(format!("{word} \"{name}\" is ignored: this program chooses its own."));
            }
            "ColorSpace" => {
                let name = tokens.text("the name of a colour space")?;
                if !name.eq_ignore_ascii_case("srgb") {
                    self.warn(line, format!("the colour space \"{name}\" is not supported: colours are read as sRGB"));
                }
            }
            "AttributeBegin" | "TransformBegin" => self.open_scope(line, false)?,
            "AttributeEnd" | "TransformEnd" => self.close_scope(line, word)?,
            "ObjectBegin" | "ObjectEnd" | "ObjectInstance" => self.object(word, line, tokens)?,
            "Include" | "Import" => self.include(word == "Import", line, tokens)?,
            "Attribute" => {
                let target = tokens.text("what attributes are for")?;
                if !TARGETS.contains(&target.as_str()) {
                    let known = "give shape, light, material, medium or texture";
                    self.warn(line, format!("`Attribute \"{target}\"` has an unknown target: {known}"));
                    Parameters::read(tokens, line)?;
                    return Ok(());
                }
                let (parameters, list) = Parameters::read(tokens, line)?.into_attributes();
                let path = &self.path;
                self.attributes.extend(list.into_iter().map(|parameter| (path.clone(), target.clone(), parameter)));
                self.state.attributes.entry(target).or_default().replace_by(parameters)?;
            }
            "Texture" | "Material" | "MakeNamedMaterial" | "NamedMaterial" => self.appearance(word, line, tokens)?,
            "MakeNamedMedium" | "MediumInterface" => self.medium(word, line, tokens)?,
            "LightSource" | "AreaLightSource" => self.light(word, line, tokens)?,
            "Shape" => self.shape(line, tokens)?,
            // Ended the file in version 3.
            "WorldEnd" => {}
            found => {
                let known = TRANSFORMS.into_iter().chain(CHOICES).chain(WORLD).chain(LEFT_OUT);
                return Err(unknown("directive", found, line, known).into());
            }
        }
        Ok(())
    }

    fn medium(&mut self, word: &str, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        tokens.text("the name of a medium")?;
        if word == "MakeNamedMedium" {
            Parameters::read(tokens, line)?;
        } else if let Some(TokenKind::Text(_)) = tokens.peek() {
            // The medium outside; by default that inside.
            tokens.take()?;
        }
        self.warn(line, format!("`{word}` is left out: media are not supported"));
        Ok(())
    }

    fn space(&mut self, word: &str, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        match word {
            "CoordinateSystem" => {
                let name = tokens.text("the name of a coordinate system")?;
                self.systems.insert(name, self.state.matrix);
            }
            "CoordSysTransform" => {
                let name = tokens.text("the name of a coordinate system")?;
                let Some(system) = self.systems.get(&name).copied() else {
                    return Err(undefined("coordinate system", &name, line));
                };
                // A coordinate system has the transforms of both times, whichever is active.
                self.state.matrix = system;
            }
            "ReverseOrientation" => self.state.reversed = !self.state.reversed,
            "ActiveTransform" => match tokens.next_kind("`StartTime`, `EndTime` or `All`")? {
                (_, TokenKind::Word("StartTime" | "All")) => self.state.at_end_time = false,
                (_, TokenKind::Word("EndTime")) => self.state.at_end_time = true,
                (line, other) => {
                    return Err(LineError::new(line, shown(&other), "is not one of `StartTime`, `EndTime` and `All`"));
                }
            },
            _ => {
                tokens.numbers::<2>("a time")?;
            }
        }
        Ok(())
    }

    fn option(&mut self, word: &str, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        match word {
            "Camera" => {
                let kind = tokens.text("the kind of the camera")?;
                let parameters = Parameters::read(tokens, line)?;
                self.view = PbrtCamera::read(&kind, &parameters, self.state.matrix)?;
                self.systems.insert("camera".to_owned(), self.state.matrix.inverse());
                if self.view.is_none() {
                    self.warn(
                        line,
                        format!(
                            "the camera \"{kind}\" is not supported: a camera that shows the whole scene replaces it"
                        ),
                    );
                    return Ok(());
                }
                self.warn_all(word, &parameters, Vec::new());
            }
            "Film" => {
                tokens.text("the kind of the film")?;
                let parameters = Parameters::read(tokens, line)?;
                self.size = view::film(&parameters)?;
                // These parameters do not change the scene.
                parameters.pass_over(&["filename", "diagonal", "savefp16"]);
                if let Some(sensor) = parameters.word("sensor", "string")?.filter(|sensor| *sensor != "cie1931") {
                    self.warn(
                        line,
                        format!("the sensor \"{sensor}\" is not supported: colours are those of \"cie1931\""),
                    );
                }
                self.warn_all(word, &parameters, Vec::new());
            }
            "Option" => {
                // pbrt-v4 gives the name without a type.
                if let Some(TokenKind::Text(name)) = tokens.peek()
                    && !name.contains(char::is_whitespace)
                {
                    let name = tokens.text("the name of an option")?;
                    Parameter::values(tokens, &name)?;
                    self.warn(line, unsupported(&name, word));
                } else {
                    let parameters = Parameters::read(tokens, line)?;
                    self.warn_all(word, &parameters, Vec::new());
                }
            }
            _ => {
                if std::mem::replace(&mut self.in_world, true) {
                    return Err(LineError::new(line, "`WorldBegin`", "is given twice: keep one"));
                }
                self.state.matrix = Transform::IDENTITY;
                self.state.at_end_time = false;
                self.systems.insert("world".to_owned(), Transform::IDENTITY);
            }
        }
        Ok(())
    }

    pub(super) fn open_scope(&mut self, line: usize, is_object: bool) -> Result<(), LineError> {
        let depth = self.saved.len() as u64 + 1;
        LoadErrorKind::check_limit("the depth of scopes", depth, SCOPES as u64).in_line(line)?;
        self.saved.push((self.state.clone(), line, is_object));
        Ok(())
    }

    pub(super) fn close_scope(&mut self, line: usize, word: &str) -> Result<(), LineError> {
        let is_object = word == "ObjectEnd";
        if self.saved.last().is_none_or(|(_, _, of_object)| *of_object != is_object) {
            return Err(LineError::new(line, format_args!("`{word}`"), "has no matching begin: remove it"));
        }
        if let Some((state, ..)) = self.saved.pop() {
            self.state = state;
        }
        Ok(())
    }

    fn include(&mut self, is_import: bool, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        let reference = tokens.text("the name of a file")?;
        let bad = |rule: &dyn Display| LineError { line, kind: LoadErrorKind::bad_reference(&reference, rule) };
        let path = resolve_path(&reference, self.files.root_file, self.files.options).in_line(line)?;
        let canonical = path.canonicalize().in_line(line)?;
        if self.open.contains(&canonical) {
            return Err(bad(&"includes itself: remove one of the directives"));
        }
        self.includes += 1;
        if self.open.len() > INCLUDE_DEPTH || self.includes > INCLUDES {
            let rule = format!("is one file too many: {INCLUDE_DEPTH} within each other and {INCLUDES} in all may be");
            return Err(bad(&rule));
        }
        let text = read_text(&path, self.files.options).map_err(|reason| bad(&reason))?;
        let memory = self.files.options.memory.keep(format_args!("the file {}", path.display()), 3 * text.len() as u64);
        memory.map_err(|reason| bad(&reason))?;
        let (outer, state) = (std::mem::replace(&mut self.path, path), is_import.then(|| self.state.clone()));
        self.open.push(canonical);
        self.read(&text);
        self.open.pop();
        self.path = outer;
        if let Some(state) = state {
            self.state = state;
        }
        Ok(())
    }

    /// Returns the model, or all errors.
    pub(super) fn finish(mut self) -> Result<Model, LoadError> {
        if let Some((_, line, _)) = self.saved.pop() {
            self.report(LineError::new(
                line,
                "the block that begins here",
                "has no end: add `AttributeEnd` or `ObjectEnd`",
            ));
        } else if !self.in_world {
            let reason = LoadErrorKind::Syntax("has no `WorldBegin`: add it before the first shape".to_owned());
            self.report.add(reason.at(self.files.root_file, "").into_diagnostics());
        }
        let path: &Path = self.files.root_file;
        self.report.finish()?;
        for (path, target, attribute) in self.attributes.iter().filter(|(.., attribute)| !attribute.is_used()) {
            let place = format!("{}:{}", path.display(), attribute.line);
            let message = format!("the attribute \"{}\" for \"{target}\" is not used", attribute.name);
            self.model.warn(place, message);
        }
        if self.nodes.is_empty() {
            return Err(self.model.empty("has no visible shapes", path));
        }
        let mut model = self.model;
        for (index, count) in self.warned.into_values() {
            model.warnings[index].message += &times(count);
        }
        model.textures = self.textures.list;
        if self.emits || self.sky.is_some() || !model.lights.is_empty() {
            model.background = Some(Background::Constant(Color::from_rgb(self.sky.unwrap_or_default().to_array())));
        }
        model.image_size = Some(self.size);
        let size = self.files.options.size.unwrap_or(self.size);
        model.cameras.extend(self.view.as_ref().map(|view| view.camera(size)));
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let world = PbrtCamera::ours_from_world(self.view.as_ref());
        let is_left_handed = world.flips_handedness();
        model.nodes = vec![SceneNode { children: self.nodes, is_left_handed, ..SceneNode::empty(stem, world) }];
        Ok(model)
    }
}

/// Warning about a parameter without effect here.
fn unsupported(name: &str, directive: &str) -> String {
    format!("the parameter \"{name}\" of {directive} is not supported")
}
