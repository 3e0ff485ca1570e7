//! Files of `--aov`: layers of first hits, and maps of standard errors and sample counts.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use rt_image::ImageFormat;
use rt_render::FirstHitLayer;

use super::values::unknown_word;

/// Map: a quantity that needs the sums of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Aov {
    /// Standard error of each channel.
    #[value(alias = "variance")]
    Stderr,
    Samples,
}

impl AovContent {
    /// True if it needs the sums of all passes: standard errors or numbers of samples.
    pub(crate) const fn needs_maps(&self) -> bool {
        match self {
            Self::Map(_) => true,
            Self::Layers(list) => list.samples || list.stderr,
        }
    }
}

/// Layers of an OpenEXR file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct LayerList {
    pub(crate) first_hit: Vec<FirstHitLayer>,
    pub(crate) samples: bool,
    /// Standard errors, which a render of one pass does not have.
    pub(crate) stderr: bool,
    /// True if the standard errors are not listed, but written if available.
    pub(crate) is_all: bool,
}

/// Content of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum AovContent {
    /// One quantity in an image of its own.
    Map(Aov),
    Layers(LayerList),
}

/// `LIST=FILE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct AovArg {
    pub(crate) content: AovContent,
    pub(crate) file: PathBuf,
}

pub(super) const AOV_HELP: &str = "\
Write layers: depth,normal,albedo=FILE.exr, or one of stderr=FILE and samples=FILE in any format

Layers of the first surfaces that camera rays hit: depth, position, normal, geometric_normal, albedo, roughness, emission, uv, \
object_id, material_id, instance_id, coverage. `all` selects these, `samples` and, with two passes or more, `stderr`. The .exr file also holds the \
image. Its channels are 32-bit floats with names such as depth.Z and normal.X.

`stderr` is the standard error of each channel in units of radiance: the square root of the variance of the mean over all passes. It \
needs at least two passes. `samples` is the number of samples, in all channels. Either may be written alone to any image format: .exr, \
.hdr and .pfm hold the numbers; .png and .jpg show them from black (0) to white (maximum of the image). May be given more than once.";

pub(super) const MAP_HELP: &str = "\
Write an additional image: stderr=FILE (standard error) or samples=FILE (sample count)

`stderr` is the standard error of each channel in units of radiance: the square root of the variance of the mean over all passes. It \
needs at least two passes. `samples` is the number of samples, in all channels. The formats .exr, .hdr and .pfm hold the numbers; .png \
and .jpg show them from black (0) to white (maximum of the image). May be given more than once.";

/// Parser of `LIST=FILE`.
pub(super) fn aov(text: &str) -> Result<AovArg, String> {
    let parts = text.split_once('=').filter(|(names, file)| !names.is_empty() && !file.is_empty());
    let (names, file) = parts.ok_or("expected LIST=FILE, such as depth,normal=layers.exr or stderr=FILE")?;
    if let Ok(map) = Aov::from_str(names, false) {
        return Ok(AovArg { content: AovContent::Map(map), file: file.into() });
    }
    let mut list = LayerList::default();
    for name in names.split(',') {
        match (name, Aov::from_str(name, false), FirstHitLayer::ALL.iter().find(|layer| layer.name() == name)) {
            ("all", ..) => {
                list = LayerList { first_hit: FirstHitLayer::ALL.to_vec(), samples: true, is_all: true, ..list };
            }
            (_, Ok(Aov::Samples), _) => list.samples = true,
            (_, Ok(Aov::Stderr), _) => list.stderr = true,
            (_, _, Some(layer)) if !list.first_hit.contains(layer) => list.first_hit.push(*layer),
            (_, _, Some(_)) => {}
            _ => {
                let known = FirstHitLayer::ALL.iter().map(|layer| layer.name()).chain(["samples", "stderr", "all"]);
                return Err(unknown_word("layer", name, known.map(str::to_owned).collect()));
            }
        }
    }
    if ImageFormat::from_path(Path::new(file)).ok() != Some(ImageFormat::Exr) {
        return Err(format!("layers need a file that ends in .exr, not `{file}`"));
    }
    Ok(AovArg { content: AovContent::Layers(list), file: file.into() })
}

/// Parser of `NAME=FILE`, for quantities that shards of an image hold.
pub(super) fn aov_of_shards(text: &str) -> Result<AovArg, String> {
    match aov(text)? {
        AovArg { content: AovContent::Layers(_), .. } => {
            Err("expected stderr=FILE or samples=FILE; only `render` writes other layers".to_owned())
        }
        map => Ok(map),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aovs_have_a_name_and_a_file() {
        for (name, kind) in [("samples", Aov::Samples), ("stderr", Aov::Stderr), ("variance", Aov::Stderr)] {
            let expected = AovArg { content: AovContent::Map(kind), file: "a=b.exr".into() };
            assert_eq!(aov(&format!("{name}=a=b.exr")), Ok(expected.clone()));
            assert_eq!(aov_of_shards(&format!("{name}=a=b.exr")), Ok(expected));
        }
        for bad in ["", "samples", "samples=", "=a.exr", "variance a.exr", "depth=a.png", "depth,=a.exr", "deep=a.exr"]
        {
            assert!(aov(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn layers_are_a_list_of_names() {
        use FirstHitLayer::{Depth, Normal};
        let layers = |text: &str| match aov(text) {
            Ok(AovArg { content: AovContent::Layers(list), .. }) => list,
            other => panic!("{other:?}"),
        };
        let expected = LayerList { first_hit: vec![Normal, Depth], samples: true, ..LayerList::default() };
        assert_eq!(layers("normal,depth,samples,depth=a.exr"), expected);
        let all = layers("all,stderr=a.exr");
        assert_eq!((&all.first_hit[..], all.samples, all.stderr), (FirstHitLayer::ALL, true, true));
        assert!(aov("depht=a.exr").unwrap_err().starts_with("unknown layer `depht`; did you mean `depth`?"));
        assert!(aov_of_shards("depth=a.exr").is_err());
    }
}
