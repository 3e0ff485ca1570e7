//! Layers: attributes of the surfaces that camera rays hit first.
//!
//! A render with a fixed number of samples computes them from the hits of its camera rays. For tiles of a checkpoint, and with
//! light tracing, the same camera rays are traced again after the image (`layer_pass.rs`). A render with a stop rule traces
//! other camera rays. None of this changes the image. For the same samples and passes, layers are the same with every
//! integrator, number of threads and accelerator.

use rt_geometry::InteractionFlags;

use crate::{
    Crop,
    tile::{tile, tile_count, tile_number},
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

/// Values of a channel in a tile.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TileChannel {
    /// The same in all pixels.
    Constant(f32),
    /// Row by row.
    Pixels(Vec<f32>),
}

impl TileChannel {
    /// Channel with a value per pixel.
    pub(crate) fn new(values: Vec<f32>) -> Self {
        match values.first() {
            Some(first) if values.iter().all(|value| value.to_bits() == first.to_bits()) => Self::Constant(*first),
            _ => Self::Pixels(values),
        }
    }
}

/// Layers of the whole image, filled tile by tile.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmLayers {
    crop: Crop,
    /// True if pixels have the samples of the plan, and not those of a stop rule.
    is_fixed: bool,
    layers: Vec<FirstHitLayer>,
    /// Channels of all layers by tile; none for a tile that has no values.
    tiles: Vec<Vec<TileChannel>>,
    /// Flags of the tiles that have values or are left out.
    filled: Vec<bool>,
}

impl FilmLayers {
    /// Layers without values.
    pub(crate) fn new(crop: Crop, layers: &[FirstHitLayer], is_fixed: bool) -> Self {
        let count = tile_count(crop);
        Self { crop, is_fixed, layers: layers.to_vec(), tiles: vec![Vec::new(); count], filled: vec![false; count] }
    }

    /// The layers, in the order of the request.
    pub fn layers(&self) -> &[FirstHitLayer] {
        &self.layers
    }

    /// Values of all layers, in the order of the request. Those of a render are complete after
    /// [`complete_layers`](crate::RenderPlan::complete_layers).
    pub fn values(&self) -> Vec<LayerValues> {
        let [width, height] = [self.crop.width as usize, self.crop.height as usize];
        let plane = |layer: FirstHitLayer, channel: usize| {
            let mut plane = vec![0.0; width * height];
            plane.chunks_exact_mut(width.max(1)).zip(0..).for_each(|(row, y)| self.read_row(layer, channel, y, row));
            plane
        };
        let of_layer = |&layer: &FirstHitLayer| LayerValues {
            layer,
            channels: (0..layer.channels().len()).map(|channel| plane(layer, channel)).collect(),
        };
        self.layers.iter().map(of_layer).collect()
    }

    /// Reads a row of pixels of a channel of a layer, counted from the top of the crop. Numbers are zero where there are no values, beyond the
    /// crop, and for a channel that the layer has not.
    pub fn read_row(&self, layer: FirstHitLayer, channel: usize, y: u32, row: &mut [f32]) {
        row.fill(0.0);
        if y >= self.crop.height || channel >= layer.channels().len() {
            return;
        }
        let before = self.layers.iter().take_while(|of_film| **of_film != layer);
        let channel = before.map(|layer| layer.channels().len()).sum::<usize>() + channel;
        let mut number = tile_number(self.crop, Crop { y: self.crop.y + y, ..self.crop });
        let mut rest = match row.split_at_mut_checked(self.crop.width as usize) {
            Some((within, _)) => within,
            None => row,
        };
        while let Some(channels) = self.tiles.get(number).filter(|_| !rest.is_empty()) {
            let Crop { y: top, width, .. } = tile(self.crop, number);
            let width = width as usize;
            let (part, behind) = rest.split_at_mut(width.min(rest.len()));
            match channels.get(channel) {
                None => {}
                Some(TileChannel::Constant(value)) => part.fill(*value),
                Some(TileChannel::Pixels(values)) => {
                    let start = (self.crop.y + y - top) as usize * width;
                    part.copy_from_slice(&values[start..start + part.len()]);
                }
            }
            rest = behind;
            number += 1;
        }
    }

    pub(crate) const fn is_fixed(&self) -> bool {
        self.is_fixed
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

    /// Sets the channels of a tile.
    pub(crate) fn insert(&mut self, tile: Crop, channels: Vec<TileChannel>) {
        let number = tile_number(self.crop, tile);
        self.tiles[number] = channels;
        self.filled[number] = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_of_tiles_and_zero_elsewhere() {
        let crop = Crop { x: 3, y: 5, width: 20, height: 17 };
        let mut film = FilmLayers::new(crop, &[FirstHitLayer::Uv, FirstHitLayer::Depth], true);
        // Tiles of 16 and 4 columns; the lower left one stays empty.
        let by_pixel = |tile: Crop| TileChannel::new(tile.pixels().map(|[x, y]| (100 * y + x) as f32).collect());
        for number in [0, 1, 3] {
            let tile = tile(crop, number);
            let three = [0.0, 1.0, 2.0].map(TileChannel::Constant);
            film.insert(tile, three.into_iter().chain([by_pixel(tile)]).collect());
        }
        let row = |layer, channel, y, length| {
            let mut row = vec![-1.0; length];
            film.read_row(layer, channel, y, &mut row);
            row
        };
        let depths = |y: usize, columns: core::ops::Range<usize>| columns.map(move |x| (100 * (y + 5) + x + 3) as f32);
        for y in [0, 15] {
            assert_eq!(row(FirstHitLayer::Depth, 0, y as u32, 20), depths(y, 0..20).collect::<Vec<_>>());
        }
        let mut last = vec![0.0; 16];
        last.extend(depths(16, 16..20));
        assert_eq!(row(FirstHitLayer::Depth, 0, 16, 20), last);
        assert_eq!(row(FirstHitLayer::Uv, 2, 15, 20), [2.0; 20]);
        // Short and long rows.
        assert_eq!(row(FirstHitLayer::Depth, 0, 2, 3), depths(2, 0..3).collect::<Vec<_>>());
        let long: Vec<f32> = depths(2, 0..20).chain([0.0; 30]).collect();
        assert_eq!(row(FirstHitLayer::Depth, 0, 2, 50), long);
        for (layer, channel, y) in [
            (FirstHitLayer::Depth, 0, 17),
            (FirstHitLayer::Depth, 0, u32::MAX),
            (FirstHitLayer::Depth, 1, 0),
            (FirstHitLayer::Normal, 0, 0),
        ] {
            assert_eq!(row(layer, channel, y, 20), [0.0; 20], "{layer:?} {channel} {y}");
        }
    }

    #[test]
    fn channels_of_one_value_are_constant() {
        assert_eq!(TileChannel::new(vec![2.5; 7]), TileChannel::Constant(2.5));
        assert!(matches!(TileChannel::new(vec![0.0, -0.0]), TileChannel::Pixels(_)), "other bits");
        assert!(matches!(TileChannel::new(vec![f32::NAN; 3]), TileChannel::Constant(_)));
    }
}
