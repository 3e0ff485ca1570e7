//! NFF, the Neutral File Format (Eric Haines, version 3.9, 1996) of the Standard Procedural Databases (Haines, "A
//! Proposal for Standard Graphics Environments", IEEE CG&A 7(11), 1987).
//!
//! ```text
//! v b l          view, background, lights   ──> camera, image size, background, classical lights
//! f              fill colour                ──> a Phong material of what follows
//! s c            sphere, cone or cylinder   ──> exact shapes
//! p pp           polygon, patch             ──> polygons or a mesh, a mesh with normals
//! ```
//!
//! Surfaces are seen from both sides, though the format lets programs leave the backs out: no picture of a closed
//! object differs. A light without a colour shines with 1/√n if there are n lights.

mod faces;
mod round;
mod surface;
mod view;
mod words;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use rt_math::{DVec3, Rgb};
use rt_shading::{Falloff, Light, LightKind, LightUnits, Phong};

use self::faces::Faces;
use self::round::Solid;
use self::surface::Fill;
use self::view::View;
use self::words::{Word, Words};
use crate::files::{read_file, refuse_utf16};
use crate::flaw::Flaw;
use crate::forecast::{self, Sample};
use crate::format::{Background, Color};
use crate::mesh_build::build_mesh;
use crate::resolve::Report;
use crate::{
    Content, LoadError, LoadOptions, Material, MaterialId, MeshId, Model, NamedMesh, Node, Place, Problem, Reason,
    Warning,
};

/// The statements of the format.
const KEYWORDS: [&str; 8] = ["v", "b", "l", "f", "c", "s", "p", "pp"];

/// Bytes of memory that loading takes at its peak: solids become nodes, fills materials, and corners of polygons meshes.
fn peak_bytes(sample: &Sample) -> u64 {
    // Statements may share a line.
    let [solids, fills, corners] = sample.over_lines(|line| {
        let words = || line.split(u8::is_ascii_whitespace);
        let count = |keywords: &[&[u8]]| words().filter(|word| keywords.contains(word)).count() as u64;
        let begins_with_number = line.trim_ascii_start().first().is_some_and(|byte| b"-+.0123456789".contains(byte));
        [count(&[b"s", b"c"]), count(&[b"f"]), u64::from(begins_with_number)]
    });
    sample.size + 1050 * solids + 1500 * fills + 72 * corners
}

/// Loads the file at `path`.
pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    forecast::within(path, options, peak_bytes, || {
        load_bytes(&read_file(path, options).map_err(|reason| reason.at(path, ""))?, path)
    })
}

/// Loads the file that `bytes` hold; `path` is for messages.
pub(crate) fn load_bytes(bytes: &[u8], path: &Path) -> Result<Model, LoadError> {
    refuse_utf16(bytes).map_err(|reason| reason.at(path, ""))?;
    // Comments may be in any encoding; elsewhere what is not ASCII is no number and no keyword.
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes));
    // Line ends of old Macintosh systems, from which some of these files come.
    let text = if text.contains('\n') { text } else { text.replace('\r', "\n").into() };
    let mut reader = Reader::new(path);
    let mut words = Words::of(&text);
    while let Some(word) = words.take() {
        if let Err(flaw) = reader.statement(word, &mut words) {
            let line = flaw.line;
            reader.report(flaw);
            while words.peek().is_some_and(|word| !may_begin_statement(word, line)) {
                words.take();
            }
        }
    }
    reader.finish()
}

/// Whether a word may be the first of a statement after something is wrong in a line.
fn may_begin_statement(word: Word<'_>, bad_line: usize) -> bool {
    let is_part = view::PARTS.contains(&word.text) || word.text.parse::<f64>().is_ok();
    KEYWORDS.contains(&word.text) || (word.line > bad_line && !is_part)
}

/// A fill and the faces that have it.
struct Surface {
    fill: Option<Fill>,
    polygons: Faces,
    patches: Faces,
}

/// What has been read so far.
struct Reader<'p> {
    path: &'p Path,
    report: Report,
    model: Model,
    background: Option<Rgb>,
    has_view: bool,
    /// Places of the lights and their colours, where they have one.
    lights: Vec<(DVec3, Option<Rgb>)>,
    /// One for each material of the model.
    surfaces: Vec<Surface>,
    known_fills: HashMap<[u64; 8], MaterialId>,
    /// The material of what follows.
    fill: Option<MaterialId>,
    /// How many solids show only their inside, and the line of the first.
    inside_out: (usize, usize),
}

impl<'p> Reader<'p> {
    fn new(path: &'p Path) -> Self {
        Self {
            path,
            report: Report::new(path),
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

    fn report(&mut self, Flaw { line, reason }: Flaw) {
        let file = self.path.display().to_string();
        self.report.add([Problem { file, place: Place::Line(line), reason, excerpt: None }]);
    }

    fn warn(&mut self, line: usize, message: String) {
        let place = format!("{}:{line}", self.path.display());
        self.model.warnings.push(Warning { place, message });
    }

    /// Reads the statement that begins with a word.
    fn statement(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<(), Flaw> {
        let Word { line, text } = word;
        match text {
            "v" => self.view(words, line)?,
            "b" => {
                let colour = words.colour("a part of the background colour")?.into();
                if self.background.replace(colour).is_some() {
                    return Err(Flaw::new(line, "the background", "is given a second time: keep one"));
                }
            }
            "l" => {
                let place = DVec3::from(words.numbers("a coordinate of the light")?);
                let has_colour = words.peek().is_some_and(|word| word.text.parse::<f64>().is_ok());
                let colour = if has_colour { Some(words.colour("a part of the light's colour")?.into()) } else { None };
                self.lights.push((place, colour));
            }
            "f" => self.fill = Some(Fill::read(words).map(|fill| self.material(fill))?),
            "s" => self.solid(line, round::sphere(words, line)?),
            "c" => self.solid(line, round::cone(words, line)?),
            "p" => self.surface(line).polygons.read(words, line, false)?,
            "pp" => self.surface(line).patches.read(words, line, true)?,
            number if number.parse::<f64>().is_ok() => {
                let rule = "is one number too many for the statement before it: remove it";
                return Err(Flaw::new(line, format_args!("`{number}`"), rule));
            }
            found => {
                let (kind, found) = ("statement", found.to_owned());
                let known = KEYWORDS.map(str::to_owned).to_vec();
                return Err(Flaw { line, reason: Reason::UnknownWord { kind, found, known } });
            }
        }
        Ok(())
    }

    fn view(&mut self, words: &mut Words<'_>, line: usize) -> Result<(), Flaw> {
        let View { camera, size } = View::read(words, line)?;
        if std::mem::replace(&mut self.has_view, true) {
            return Err(Flaw::new(line, "the view", "is given a second time: keep one"));
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
        let id = self.add_material(format!("fill {}", self.surfaces.len() + 1), fill.phong(), Some(fill));
        self.known_fills.insert(fill.key(), id);
        id
    }

    fn add_material(&mut self, name: String, phong: Phong, fill: Option<Fill>) -> MaterialId {
        self.model.materials.push(Material::new(name, phong));
        self.surfaces.push(Surface { fill, polygons: Faces::default(), patches: Faces::default() });
        MaterialId(self.surfaces.len() as u32 - 1)
    }

    /// The material in force; plain grey before the first fill.
    fn current(&mut self, line: usize) -> MaterialId {
        if let Some(id) = self.fill {
            return id;
        }
        self.warn(line, "an object comes before the first fill colour; it becomes plain grey".to_owned());
        let id = self.add_material("no fill".to_owned(), Phong::default(), None);
        self.fill = Some(id);
        id
    }

    fn surface(&mut self, line: usize) -> &mut Surface {
        let MaterialId(id) = self.current(line);
        &mut self.surfaces[id as usize]
    }

    fn solid(&mut self, line: usize, solid: Solid) {
        let material = self.current(line);
        if solid.inside_out {
            let (count, first) = self.inside_out;
            self.inside_out = (count + 1, if count == 0 { line } else { first });
        }
        let node = Node::new(Content::Shape(solid.shape), material);
        let name = format!("line {line}");
        self.model.nodes.push(Node { name, parent_from_local: solid.world_from_local, ..node });
    }

    fn finish(mut self) -> Result<Model, LoadError> {
        self.add_faces();
        self.add_lights();
        self.model.background =
            Some(Background::Constant(Color::from_rgb(self.background.unwrap_or_default().to_array())));
        if let (count @ 1.., line) = self.inside_out {
            let message = "spheres and cones of negative radius are seen from both sides, not from inside alone";
            self.warn(line, format!("{message} ({count} in the file, this is the first)"));
        }
        // A file that is wrong may have no objects only for that.
        self.report.finish()?;
        if self.model.nodes.is_empty() {
            return Err(Reason::Syntax("has no objects: none of `s`, `c`, `p` and `pp`".to_owned()).at(self.path, ""));
        }
        Ok(self.model)
    }

    fn add_faces(&mut self) {
        for (id, mut surface) in std::mem::take(&mut self.surfaces).into_iter().enumerate() {
            let material = MaterialId(id as u32);
            let transparent = surface.fill.is_some_and(|fill| fill.transmittance > 0.0);
            for (line, shape) in surface.polygons.take_shapes(transparent) {
                let node = Node::new(Content::Shape(shape), material);
                self.model.nodes.push(Node { name: format!("line {line}"), ..node });
            }
            for (what, faces) in [("polygons", &surface.polygons), ("patches", &surface.patches)] {
                if !faces.is_empty() {
                    self.add_mesh(what, faces, material);
                }
            }
        }
    }

    fn add_mesh(&mut self, what: &str, faces: &Faces, material: MaterialId) {
        let name = format!("{what} of {}", self.model.materials[material.0 as usize].name);
        let place = format!("{}: {name}", self.path.display());
        let mesh = faces.mesh_data().and_then(|data| build_mesh(data, &place, &mut self.model.warnings));
        if let Some(Some(mesh)) = self.report.check(&name, mesh) {
            let id = MeshId(self.model.meshes.len() as u32);
            self.model.nodes.push(Node { name: name.clone(), ..Node::new(Content::Mesh(id), material) });
            self.model.meshes.push(NamedMesh { name, mesh: Arc::new(mesh) });
        }
    }

    fn add_lights(&mut self) {
        let plain = Rgb::gray(1.0 / (self.lights.len() as f64).sqrt());
        let unsaid = self.lights.iter().filter(|(_, colour)| colour.is_none()).count();
        if unsaid > 0 {
            self.model.notes.push(format!(
                "{unsaid} of {} lights have no colour in the file: each shines with one over the root of their number, {:.3}.",
                self.lights.len(),
                plain.r
            ));
        }
        self.model.lights.extend(self.lights.iter().enumerate().map(|(i, &(position, colour))| Light {
            name: format!("light {}", i + 1),
            kind: LightKind::Point { position, falloff: Falloff::None, lamp_radius: 0.0 },
            intensity: colour.unwrap_or(plain),
            units: LightUnits::Classical,
            casts_shadows: true,
        }));
    }
}

#[cfg(test)]
mod tests;
