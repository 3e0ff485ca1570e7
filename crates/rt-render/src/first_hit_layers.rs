//! Layers: attributes of the surfaces that camera rays hit first.
//!
//! A render with a fixed number of samples computes them from the hits of its camera rays. For tiles of a checkpoint, and with
//! light tracing, the same camera rays are traced again after the image (`layer_pass.rs`). A render with a stop rule traces
//! other camera rays. None of this changes the image. For the same samples and passes, layers are the same with every
//! integrator, number of threads and accelerator.

use rt_geometry::InteractionFlags;

use crate::{
    Crop,
    tile::{tile_count, tile_number},
};

/// Maximum samples per pixel of layers. Further samples change the means by less than most images show.
pub const MAX_LAYER_SAMPLES: u32 = 16;

/// Depth of misses, as in Blender.
pub const FAR_DEPTH: f32 = 1e10;

/// Declares the layers with their names and channels.
macro_rules! layers {
    ($($(#[$doc:meta])* $layer:ident = $name:literal, [$($channel:literal),+];)+) => {
        /// Attribute of the surfaces that the camera rays of a pixel hit first.
        ///
        /// Numbers are means over those of the first [`MAX_LAYER_SAMPLES`] samples of the image that hit a surface, or zero
        /// without any. Samples have no filter weights. Wide filters spread them beyond the pixel.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum FirstHitLayer {
            $($(#[$doc])* $layer,)+
        }

        impl FirstHitLayer {
            /// All layers.
            pub const ALL: &[Self] = &[$(Self::$layer),+];

            /// Name in lower case.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$layer => $name,)+
                }
            }

            /// Names of the channels.
            pub const fn channels(self) -> &'static [&'static str] {
                match self {
                    $(Self::$layer => &[$($channel),+],)+
                }
            }
        }
    };
}

layers! {
    /// Depth along the view axis in world units; [`FAR_DEPTH`] for a miss.
    Depth = "depth", ["Z"];
    /// Hit point in world space.
    Position = "position", ["X", "Y", "Z"];
    /// Unit shading normal in world space, with interpolated normals and normal maps, of the side that is seen.
    Normal = "normal", ["X", "Y", "Z"];
    /// Unit geometric normal in world space, of the side that is seen.
    GeometricNormal = "geometric_normal", ["X", "Y", "Z"];
    /// [`Material::albedo`](rt_shading::Material::albedo).
    Albedo = "albedo", ["R", "G", "B"];
    /// [`Material::roughness`](rt_shading::Material::roughness), 0 to 1.
    Roughness = "roughness", ["V"];
    /// Emitted radiance, below a clearcoat.
    Emission = "emission", ["R", "G", "B"];
    /// Texture coordinates of surfaces with textures. Those of others are zero, as plans leave them out. The third channel is that of
    /// [`Coverage`](Self::Coverage): Blender reads three.
    Uv = "uv", ["U", "V", "A"];
    /// Number of the shape or mesh of a node, from 1; 0 for none. All instances of a group have those of its nodes. All numbers
    /// are those of the first sample that hits a surface.
    ObjectId = "object_id", ["V"];
    /// Index of the material in the scene, plus 1; 0 for none.
    MaterialId = "material_id", ["V"];
    /// Number of the placed shape, mesh or whole group, from 1; 0 for none.
    InstanceId = "instance_id", ["V"];
    /// Share of the samples that hit a surface.
    Coverage = "coverage", ["V"];
}

/// Values of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerValues {
    /// The attribute.
    pub layer: FirstHitLayer,
    /// Value per pixel of the crop, row by row, for each of the [channels](FirstHitLayer::channels).
    pub channels: Vec<Vec<f32>>,
}

impl FirstHitLayer {
    /// Surface data that layers need.
    pub(crate) fn needs(layers: &[Self]) -> InteractionFlags {
        let is_of_hit = |layer: &Self| matches!(layer, Self::Depth | Self::Coverage | Self::Position);
        if layers.iter().all(is_of_hit) { InteractionFlags::NONE } else { InteractionFlags::ALL }
    }
}

/// Layers of the whole image, filled tile by tile.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmLayers {
    crop: Crop,
    /// True if pixels have the samples of the plan, and not those of a stop rule.
    is_fixed: bool,
    values: Vec<LayerValues>,
    /// Flags of the tiles that have values or are left out.
    filled: Vec<bool>,
}

impl FilmLayers {
    /// Layers without values.
    pub(crate) fn new(crop: Crop, layers: &[FirstHitLayer], is_fixed: bool) -> Self {
        let area = crop.width as usize * crop.height as usize;
        // Memory that is zero at first; copies would be written twice.
        let plane = |_: &&str| vec![0.0; area];
        let empty =
            |&layer: &FirstHitLayer| LayerValues { layer, channels: layer.channels().iter().map(plane).collect() };
        Self { crop, is_fixed, values: layers.iter().map(empty).collect(), filled: vec![false; tile_count(crop)] }
    }

    /// Layers in the order of the request. Those of a render are complete after
    /// [`complete_layers`](crate::RenderPlan::complete_layers).
    pub fn values(&self) -> &[LayerValues] {
        &self.values
    }

    pub(crate) fn into_values(self) -> Vec<LayerValues> {
        self.values
    }

    pub(crate) const fn is_fixed(&self) -> bool {
        self.is_fixed
    }

    pub(crate) fn layers(&self) -> Vec<FirstHitLayer> {
        self.values.iter().map(|values| values.layer).collect()
    }

    /// Leaves out tiles by index: their values stay zero.
    pub(crate) fn leave_out(&mut self, is_left_out: impl Fn(usize) -> bool) {
        for (number, filled) in self.filled.iter_mut().enumerate() {
            *filled |= is_left_out(number);
        }
    }

    /// Indices of the tiles without values that are not left out.
    pub(crate) fn missing_tiles(&self) -> Vec<usize> {
        (0..self.filled.len()).filter(|&number| !self.filled[number]).collect()
    }

    /// Copies the channels of a tile, each with a value per pixel, row by row.
    pub(crate) fn insert(&mut self, tile: Crop, channels: &[Vec<f32>]) {
        let planes = self.values.iter_mut().flat_map(|values| &mut values.channels);
        for (plane, channel) in planes.zip(channels) {
            for (row, y) in channel.chunks_exact(tile.width as usize).zip(tile.y..) {
                let start = self.crop.pixel_index([tile.x, y]);
                plane[start..start + row.len()].copy_from_slice(row);
            }
        }
        self.filled[tile_number(self.crop, tile)] = true;
    }
}
