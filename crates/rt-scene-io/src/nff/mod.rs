//! NFF, the Neutral File Format (Eric Haines, version 3.9, 1996) of the Standard Procedural Databases.
//!
//! Source of these: Haines, "A Proposal for Standard Graphics Environments", IEEE CG&A 7(11), 1987.
//!
//! ```text
//! v b l          view, background, lights   ──> camera, image size, background, classical lights
//! f              fill colour                ──> a Phong material of the objects that follow
//! s c            sphere, cone or cylinder   ──> exact shapes
//! p pp           polygon, patch             ──> polygons or a mesh, a mesh with normals
//! ```
//!
//! Surfaces are two-sided, though the format allows backface culling; images of closed objects are the same. A light without a
//! colour has the intensity 1/√n, where n is the number of lights.

mod faces;
mod fill;
mod quadrics;
mod view;

use std::collections::HashMap;
use std::path::Path;

use rt_math::{DVec3, Rgb};
use rt_shading::{DeltaLight, DeltaLightKind, Falloff, LightUnits, Phong};

use self::faces::FaceList;
use self::fill::Fill;
use self::quadrics::PlacedShape;
use self::view::NffView;
use crate::build_mesh::build_mesh;
use crate::diagnostics::Diagnostics;
use crate::error::{ErrorAt, LineError, times};
use crate::files::refuse_utf16;
use crate::format::{Background, Color};
use crate::memory::{FileSample, load_within_budget};
use crate::text::tokenizer::{Tokenizer, Word};
use crate::{Content, LoadError, LoadErrorKind, LoadOptions, Material, MaterialId, Model, SceneNode};

/// The statements of the format.
const KEYWORDS: [&str; 8] = ["v", "b", "l", "f", "c", "s", "p", "pp"];

/// Bytes of memory that loading takes at its peak: solids become nodes, fills materials, and corners of polygons meshes.
fn peak_bytes(sample: &FileSample) -> u64 {
    // Statements may share a line.
    let [solids, fills, corners] = sample.over_lines(|line| {
        let tokens = || line.split(u8::is_ascii_whitespace);
        let count = |keywords: &[&[u8]]| tokens().filter(|word| keywords.contains(word)).count() as u64;
        let begins_with_number = line.trim_ascii_start().first().is_some_and(|byte| b"-+.0123456789".contains(byte));
        [count(&[b"s", b"c"]), count(&[b"f"]), u64::from(begins_with_number)]
    });
    sample.size + 1050 * solids + 1500 * fills + 72 * corners
}

pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    load_within_budget(path, options, peak_bytes, |bytes| load_bytes(&bytes, path))
}

/// Loads the file that `bytes` hold; `path` is for messages.
pub(crate) fn load_bytes(bytes: &[u8], path: &Path) -> Result<Model, LoadError> {
    refuse_utf16(bytes).at(path, "")?;
    // Comments may be in any encoding; elsewhere what is not ASCII is no number and no keyword.
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes));
    // Line ends of old Macintosh systems, from which some of these files come.
    let text = if text.contains('\n') { text } else { text.replace('\r', "\n").into() };
    let mut reader = NffReader::new(path);
    let mut tokens = Tokenizer::words(&text);
    while let Some(word) = tokens.take_word() {
        if let Err(error) = reader.statement(word, &mut tokens) {
            let line = error.line;
            reader.report(error);
            while tokens.peek_word().is_some_and(|word| !may_begin_statement(word, line)) {
                tokens.take_word();
            }
        }
    }
    reader.finish()
}

/// True if a word may begin a statement after an error in a line.
fn may_begin_statement(word: Word<'_>, bad_line: usize) -> bool {
    let is_part = view::PARTS.contains(&word.text) || word.text.parse::<f64>().is_ok();
    KEYWORDS.contains(&word.text) || (word.line > bad_line && !is_part)
}

struct FillFaces {
    fill: Option<Fill>,
    polygons: FaceList,
    patches: FaceList,
}

struct NffReader<'p> {
    path: &'p Path,
    report: Diagnostics,
    model: Model,
    background: Option<Rgb>,
    has_view: bool,
    /// Positions of the lights, and their colours if specified.
    lights: Vec<(DVec3, Option<Rgb>)>,
    /// One for each material of the model.
    surfaces: Vec<FillFaces>,
    known_fills: HashMap<[u64; 8], MaterialId>,
    /// Material of the objects that follow.
    fill: Option<MaterialId>,
    /// Number of solids that show their inside only, and the line of the first.
    inside_out: (usize, usize),
}

impl<'p> NffReader<'p> {
    fn new(path: &'p Path) -> Self {
        Self {
            path,
            report: Diagnostics::new(path),
            model: Model::default(),
            background: None,
            has_view: false,
            lights: Vec::new(),
            surfaces: Vec::new(),
            known_fills: HashMap::new(),
            fill: None,
            inside_out: (0, 0),
        }
    }

    fn report(&mut self, error: LineError) {
        self.report.add([error.in_file(self.path)]);
    }

    fn warn(&mut self, line: usize, message: String) {
        self.model.warn(format_args!("{}:{line}", self.path.display()), message);
    }

    /// Reads the statement that begins with a word.
    fn statement(&mut self, word: Word<'_>, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        let Word { line, text } = word;
        match text {
            "v" => self.view(tokens, line)?,
            "b" => {
                let colour = tokens.color("a part of the background colour")?.into();
                if self.background.replace(colour).is_some() {
                    return Err(LineError::new(line, "the background", "is given twice: keep one"));
                }
            }
            "l" => {
                let place = DVec3::from(tokens.numbers("a coordinate of the light")?);
                let has_colour = tokens.peek_word().is_some_and(|word| word.text.parse::<f64>().is_ok());
                let colour = if has_colour { Some(tokens.color("a part of the light's colour")?.into()) } else { None };
                self.lights.push((place, colour));
            }
            "f" => self.fill = Some(Fill::read(tokens).map(|fill| self.material(fill))?),
            "s" => self.solid(line, quadrics::sphere(tokens, line)?),
            "c" => self.solid(line, quadrics::cone(tokens, line)?),
            "p" => self.surface(line).polygons.read(tokens, line, false)?,
            "pp" => self.surface(line).patches.read(tokens, line, true)?,
            number if number.parse::<f64>().is_ok() => {
                let rule = "is one number too many for the statement before it: remove it";
                return Err(LineError::new(line, format_args!("`{number}`"), rule));
            }
            found => {
                let known = KEYWORDS.map(str::to_owned).to_vec();
                return Err(LineError { line, kind: LoadErrorKind::unknown("statement", found, known) });
            }
        }
        Ok(())
    }

    fn view(&mut self, tokens: &mut Tokenizer<'_>, line: usize) -> Result<(), LineError> {
        let NffView { camera, size } = NffView::read(tokens, line)?;
        if std::mem::replace(&mut self.has_view, true) {
            return Err(LineError::new(line, "the view", "is given twice: keep one"));
        }
        self.model.cameras.push(camera);
        self.model.image_size = Some(size);
        Ok(())
    }

    /// The material of a fill: equal ones share it.
    fn material(&mut self, fill: Fill) -> MaterialId {
        if let Some(id) = self.known_fills.get(&fill.key()) {
            return *id;
        }
        let id = self.add_material(fill.material(format!("fill {}", self.surfaces.len() + 1)), Some(fill));
        self.known_fills.insert(fill.key(), id);
        id
    }

    fn add_material(&mut self, material: Material, fill: Option<Fill>) -> MaterialId {
        self.surfaces.push(FillFaces { fill, polygons: FaceList::default(), patches: FaceList::default() });
        self.model.add_material(material)
    }

    /// The material in force; plain grey before the first fill.
    fn current(&mut self, line: usize) -> MaterialId {
        if let Some(id) = self.fill {
            return id;
        }
        self.warn(line, "an object comes before the first fill colour; plain grey is used".to_owned());
        let id = self.add_material(Material::new("no fill".to_owned(), Phong::default()), None);
        self.fill = Some(id);
        id
    }

    fn surface(&mut self, line: usize) -> &mut FillFaces {
        let MaterialId(id) = self.current(line);
        &mut self.surfaces[id as usize]
    }

    fn solid(&mut self, line: usize, solid: PlacedShape) {
        let material = self.current(line);
        if solid.inside_out {
            let (count, first) = self.inside_out;
            self.inside_out = (count + 1, if count == 0 { line } else { first });
        }
        let node = SceneNode::new(Content::Shape(solid.shape), material);
        let name = format!("line {line}");
        self.model.nodes.push(SceneNode { name, parent_from_local: solid.world_from_local, ..node });
    }

    fn finish(mut self) -> Result<Model, LoadError> {
        self.add_faces();
        self.add_lights();
        self.model.background =
            Some(Background::Constant(Color::from_rgb(self.background.unwrap_or_default().to_array())));
        if let (count @ 1.., line) = self.inside_out {
            let message = "spheres and cones of negative radius are visible from both sides, not only from inside";
            self.warn(line, format!("{message}{}", times(count)));
        }
        // A file that is wrong may have no objects only for that.
        self.report.finish()?;
        if self.model.nodes.is_empty() {
            return Err(
                LoadErrorKind::Syntax("has no objects: none of `s`, `c`, `p` and `pp`".to_owned()).at(self.path, "")
            );
        }
        Ok(self.model)
    }

    fn add_faces(&mut self) {
        for (id, mut surface) in std::mem::take(&mut self.surfaces).into_iter().enumerate() {
            let material = MaterialId(id as u32);
            let transparent = surface.fill.is_some_and(|fill| fill.transmittance > 0.0);
            for (line, shape) in surface.polygons.take_shapes(transparent) {
                let node = SceneNode::new(Content::Shape(shape), material);
                self.model.nodes.push(SceneNode { name: format!("line {line}"), ..node });
            }
            for (what, faces) in [("polygons", &surface.polygons), ("patches", &surface.patches)] {
                if !faces.is_empty() {
                    self.add_mesh(what, faces, material);
                }
            }
        }
    }

    fn add_mesh(&mut self, what: &str, faces: &FaceList, material: MaterialId) {
        let name = format!("{what} of {}", self.model.materials[material.0 as usize].name);
        let place = format!("{}: {name}", self.path.display());
        let mesh = faces.mesh_data().and_then(|data| build_mesh(data, &place, &mut self.model.warnings));
        if let Some(Some(mesh)) = self.report.check(&name, mesh) {
            let id = self.model.add_mesh(name.clone(), mesh);
            self.model.nodes.push(SceneNode { name, ..SceneNode::new(Content::Mesh(id), material) });
        }
    }

    fn add_lights(&mut self) {
        let plain = Rgb::gray(1.0 / (self.lights.len() as f64).sqrt());
        let unspecified = self.lights.iter().filter(|(_, colour)| colour.is_none()).count();
        if unspecified > 0 {
            self.model.notes.push(format!(
                "{unspecified} of {} lights have no colour in the file: each has the intensity 1/sqrt(number of lights) = {:.3}.",
                self.lights.len(),
                plain.r
            ));
        }
        self.model.lights.extend(self.lights.iter().enumerate().map(|(i, &(position, colour))| DeltaLight {
            name: format!("light {}", i + 1),
            kind: DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 },
            intensity: colour.unwrap_or(plain),
            units: LightUnits::Classical,
            casts_shadows: true,
        }));
    }
}

#[cfg(test)]
mod tests;
