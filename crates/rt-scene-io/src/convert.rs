//! Any file that can be loaded to a scene file to edit.

use std::collections::HashMap;
use std::io;
use std::path::{Component, Path, PathBuf};

use crate::error::ErrorAt;
use crate::files::is_absolute;
use crate::format::{Background, ColorTexture, Material, Node, NodeMaterial, SceneFile};
use crate::load::{extension, load_standalone_model, read_scene_file, resolve_located};
use crate::options::folder_of;
use crate::resolve::written_material;
use crate::{LoadError, LoadErrorKind, LoadOptions, Scene, Warning, resolve_path};

/// Result of [`convert`].
#[derive(Clone, Debug, Default)]
pub struct Converted {
    /// The scene file.
    pub text: String,
    /// Repairs and omissions of the input.
    pub warnings: Vec<Warning>,
    /// Choices that the input leaves open, and materials that stay in the input. One sentence each.
    pub notes: Vec<String>,
}

/// Text of a scene file with the content of `input`. The extension of `output`, `.ron` or `.json`, selects the format.
///
/// A model becomes a scene that refers to it, with camera, lights, film, settings and materials written out. It renders to the
/// same image as the model. A scene is written anew in canonical form; comments are lost. References to files are rewritten for
/// the folder of the output.
///
/// # Errors
/// Every error in the input; an output of another format or in a folder that does not exist.
pub fn convert(input: &Path, output: &Path, options: &LoadOptions) -> Result<Converted, LoadError> {
    let is_json = match extension(output).as_str() {
        "ron" => false,
        "json" => true,
        _ => return Err(LoadErrorKind::UnknownFormat { known: ".ron, .json" }.at(output, "")),
    };
    let options = options.rooted_at(input);
    let (mut file, mut comments, warnings) = match read_scene_file(input, &options)? {
        Some((file, _reservation)) => {
            let warnings = resolve_located(&file, input, &options)?.warnings;
            (file, Vec::new(), warnings)
        }
        None => around_model(input, &options)?,
    };
    let left = move_references(&mut file, input, output, &options)?;
    if left {
        comments.push(
            "Some files are outside of the directory of this scene: render it with --asset-root DIRECTORY, which contains them."
                .to_owned(),
        );
    }
    if is_json {
        return Ok(Converted { text: file.to_json(), warnings, notes: comments });
    }
    let head: String = comments.iter().map(|comment| format!("// {comment}\n")).collect();
    Ok(Converted { text: head + &file.to_ron(), warnings, notes: comments })
}

/// Builds an editable scene file around a model; returns its notes and warnings as well.
fn around_model(input: &Path, options: &LoadOptions) -> Result<(SceneFile, Vec<String>, Vec<Warning>), LoadError> {
    let (mut file, scene) = load_standalone_model(input, options)?;
    file.name = Some(scene.name.clone());
    if let Some(name) = input.file_name() {
        let reference = reference_to(name.as_ref()).at(input, "")?;
        file.nodes.iter_mut().filter_map(|node| node.model.as_mut()).for_each(|model| model.clone_from(&reference));
    }
    let left = write_materials(&mut file, &scene);
    let has_new_default = file.materials().any(|material| !matches!(material, Material::Phong { .. }));
    if has_new_default && file.settings.integrator.is_none() && options.integrator.is_none() {
        // Objects may use none of the materials that are written: the scene would then choose another integrator.
        file.settings.integrator = Some(scene.settings.integrator);
    }
    let mut notes = scene.notes;
    if !left.is_empty() {
        notes.push(format!("{} in the model, because scene files lack some of the properties.", list(&left)));
    }
    Ok((file, notes, scene.warnings))
}

/// Names of materials that stay with a model, the first of them one by one.
fn list(names: &[String]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|name| format!("\"{}\"", name.escape_default())).collect();
    let (shown, more) = (shown.join(", "), names.len().saturating_sub(SHOWN));
    match (names.len(), more) {
        (1, _) => format!("The material {shown} stays"),
        (_, 0) => format!("The materials {shown} stay"),
        _ => format!("The materials {shown} and {more} more stay"),
    }
}

/// Adds the materials of a scene to its file; returns the names of those that stay with the model. Ambiguous names are left
/// out.
fn write_materials(file: &mut SceneFile, scene: &Scene) -> Vec<String> {
    let mut left = Vec::new();
    let mut uses: HashMap<&str, u32> = HashMap::new();
    for material in &scene.appearance.materials {
        *uses.entry(&material.name).or_default() += 1;
    }
    for each in &scene.appearance.materials {
        let name = &each.name;
        if uses[name.as_str()] != 1 || file.materials.contains_key(name) {
            continue;
        }
        match written_material(each) {
            Some(written) => drop(file.materials.insert(name.clone(), written)),
            None => left.push(name.clone()),
        }
    }
    left
}

/// Rewrites references to files from the folder of the input to that of the output. True if one leaves that folder.
fn move_references(
    file: &mut SceneFile,
    input: &Path,
    output: &Path,
    options: &LoadOptions,
) -> Result<bool, LoadError> {
    let absolute =
        |path: &Path| folder_of(path).canonicalize().map_err(|error| LoadErrorKind::from(error).at(path, ""));
    let (from, to) = (absolute(input)?, absolute(output)?);
    if from == to {
        return Ok(false);
    }
    let mut left = false;
    for reference in references(file) {
        let found = resolve_path(reference, input, options)
            .and_then(|path| Ok((in_canonical_folder(&path)?, path.canonicalize()?)));
        let (path, target) = found.at(input, reference.as_str())?;
        let path = relative(&to, &path);
        left |= path.starts_with("..") || !target.starts_with(&to);
        *reference = reference_to(&path).at(input, reference.as_str())?;
    }
    Ok(left)
}

/// Relative path as it is written in scenes.
fn reference_to(path: &Path) -> Result<String, LoadErrorKind> {
    let name = |part: Component<'_>| part.as_os_str().to_str().filter(|name| !name.contains('\\')).map(str::to_owned);
    let Some(names) = path.components().map(name).collect::<Option<Vec<_>>>() else {
        let rule = "contains a backslash or is not UTF-8: rename it";
        return Err(LoadErrorKind::bad_reference(&path.to_string_lossy(), rule));
    };
    let reference = names.join("/");
    // The names `c:d` and `file:d` alone would be an absolute path and a URL.
    let is_refused = is_absolute(&reference) || reference.starts_with("file:");
    Ok(if is_refused { format!("./{reference}") } else { reference })
}

/// Absolute path of a file whose folder has no symbolic links. The file stays a link if it is one: its references are relative
/// to the folder of the link.
fn in_canonical_folder(file: &Path) -> io::Result<PathBuf> {
    match file.file_name() {
        Some(name) => Ok(folder_of(file).canonicalize()?.join(name)),
        None => file.canonicalize(),
    }
}

/// Path from a folder to a file, both absolute.
fn relative(folder: &Path, file: &Path) -> PathBuf {
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    up.chain(file.components().skip(shared)).collect()
}

/// All references to other files.
fn references(file: &mut SceneFile) -> Vec<&mut String> {
    let mut found: Vec<&mut String> = file.materials.values_mut().flat_map(files_of).collect();
    if let Some(Background::Image { file, .. }) = &mut file.background {
        found.push(file);
    }
    let mut open: Vec<&mut Node> = file.groups.values_mut().flatten().chain(&mut file.nodes).collect();
    while let Some(node) = open.pop() {
        found.extend(&mut node.model);
        if let Some(NodeMaterial::Inline(material)) = &mut node.material {
            found.extend(files_of(material));
        }
        open.extend(&mut node.children);
    }
    found
}

fn files_of(material: &mut Material) -> Vec<&mut String> {
    if let Material::Mix(parts) = material {
        return parts.iter_mut().flat_map(|(_, part)| files_of(part)).collect();
    }
    let file = |coefficient| match coefficient {
        &mut ColorTexture::Image { ref mut file, .. } => Some(file),
        _ => None,
    };
    material.coefficients_mut().into_iter().filter_map(file).collect()
}
