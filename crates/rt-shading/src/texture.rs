//! Textures: colours that vary over a surface.

use rt_geometry::{SurfaceInteraction, VertexAttributes};
use rt_math::Rgb;
use std::sync::Arc;

/// Index of a texture in [`Appearance::textures`](crate::Appearance::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// Rule for coordinates outside of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image repeats.
    Repeat,
    /// The image repeats, mirrored every other time.
    Mirror,
    /// Coordinates are clamped to the edge.
    Clamp,
}

/// Linear pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// Linear colour of each pixel; `width · height` of them.
    pub pixels: Vec<[f32; 3]>,
    /// Alpha of each pixel, or empty if all are opaque.
    pub alpha: Vec<f32>,
}

/// Point of a surface at which a texture is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturePoint {
    /// Texture coordinates.
    pub uv: [f64; 2],
    /// Second texture coordinates, and vertex colours.
    pub detail: VertexAttributes,
}

impl TexturePoint {
    /// A point with texture coordinates only.
    pub fn at(uv: [f64; 2]) -> Self {
        Self { uv, detail: VertexAttributes::default() }
    }
}

impl From<&SurfaceInteraction> for TexturePoint {
    fn from(surface: &SurfaceInteraction) -> Self {
        Self { uv: surface.uv, detail: surface.detail }
    }
}

/// Affine map of texture coordinates: u′ = m₀₀ u + m₀₁ v + m₀₂, and v′ by the second row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvMap {
    /// True if the second set of coordinates is mapped.
    pub is_second: bool,
    /// Rows of the matrix.
    pub rows: [[f64; 3]; 2],
}

impl UvMap {
    /// The first set, unchanged.
    pub const IDENTITY: Self = Self { is_second: false, rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };

    fn map(&self, point: &TexturePoint) -> [f64; 2] {
        let [u, v] = if self.is_second { point.detail.second_uv.map(f64::from) } else { point.uv };
        self.rows.map(|[a, b, c]| a * u + b * v + c)
    }
}

/// A colour as a function of texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// A checkerboard with squares of side `size` in texture space; the square at the origin is `even`.
    Checker {
        /// Colour of the squares with an even sum of coordinates.
        even: Rgb,
        /// Colour of the others.
        odd: Rgb,
        /// Side of a square.
        size: f64,
    },
    /// An image; (0, 0) is its lower left corner, (1, 1) its upper right.
    Image {
        /// Pixels, which several textures may share.
        bitmap: Arc<Bitmap>,
        /// Rules outside of the image, along u and v.
        wrap: [Wrap; 2],
        /// True to interpolate between pixels, false for the nearest.
        smooth: bool,
    },
    /// A texture with mapped coordinates.
    Mapped {
        /// The texture.
        texture: Arc<Texture>,
        /// Map to its coordinates.
        map: UvMap,
    },
    /// Vertex colours, times a texture if there is one.
    VertexColor(Option<Arc<Texture>>),
}

impl Wrap {
    /// Index of the pixel for index `i`, possibly outside, in a row of `length`.
    fn index(self, i: i64, length: u32) -> u32 {
        let n = i64::from(length);
        if (0..n).contains(&i) {
            return i as u32;
        }
        let wrapped = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let j = i.rem_euclid(2 * n);
                j.min(2 * n - 1 - j)
            }
        };
        wrapped as u32
    }
}

impl Bitmap {
    /// An opaque image.
    pub const fn opaque(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Self {
        Self { width, height, pixels, alpha: Vec::new() }
    }

    /// Mean colour of 4096 to 8191 evenly spaced pixels, or of all pixels of a smaller image.
    pub fn approximate_mean(&self) -> Rgb {
        let step = (self.pixels.len() / 4096).max(1);
        let (mut sum, mut count) = (Rgb::BLACK, 0.0);
        for pixel in self.pixels.iter().step_by(step) {
            sum += Rgb::from(pixel.map(f64::from)).map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 });
            count += 1.0;
        }
        sum / count
    }

    /// Version of [`approximate_mean`](Self::approximate_mean) for alpha.
    pub fn approximate_mean_alpha(&self) -> f64 {
        let step = (self.alpha.len() / 4096).max(1);
        let sampled = self.alpha.iter().step_by(step);
        let count = sampled.len();
        if count == 0 { 1.0 } else { sampled.map(|alpha| f64::from(*alpha)).sum::<f64>() / count as f64 }
    }

    /// Largest value of each component; 0 for those without a finite positive value.
    pub fn max(&self) -> Rgb {
        let max = |component: usize| {
            let finite = self.pixels.iter().map(|pixel| pixel[component]).filter(|value| value.is_finite());
            f64::from(finite.fold(0.0, f32::max))
        };
        Rgb::new(max(0), max(1), max(2))
    }

    /// Size of the pixels in bytes.
    pub fn memory(&self) -> usize {
        size_of_val(self.pixels.as_slice()) + size_of_val(self.alpha.as_slice())
    }

    /// Black if there is no such pixel.
    fn pixel(&self, index: usize) -> Rgb {
        self.pixels.get(index).map_or(Rgb::BLACK, |&[r, g, b]| Rgb::new(f64::from(r), f64::from(g), f64::from(b)))
    }
}

impl Texture {
    /// Largest value of each component; that of vertex colours is 1.
    pub fn max(&self) -> Rgb {
        match self {
            Self::Checker { even, odd, .. } => {
                let (even, odd) = (even.to_array(), odd.to_array());
                Rgb::from([0, 1, 2].map(|component| even[component].max(odd[component])))
            }
            Self::Image { bitmap, .. } => bitmap.max(),
            Self::Mapped { texture, .. } => texture.max(),
            Self::VertexColor(texture) => texture.as_ref().map_or(Rgb::WHITE, |texture| texture.max()),
        }
    }

    /// The colour at a point; black where texture coordinates are not finite, or no pixel can be numbered.
    pub fn at(&self, point: &TexturePoint) -> Rgb {
        match self {
            Self::Mapped { texture, map } => texture.at(&TexturePoint { uv: map.map(point), ..*point }),
            Self::VertexColor(texture) => {
                let color = Rgb::from(point.detail.color.map(f64::from));
                texture.as_ref().map_or(color, |texture| texture.at(point) * color)
            }
            _ if !(point.uv[0].is_finite() && point.uv[1].is_finite()) => Rgb::BLACK,
            Self::Checker { even, odd, size } => {
                let [u, v] = point.uv;
                let half = 0.5 * ((u / size).floor() + (v / size).floor());
                // Not for infinities, which are neither even nor odd: their difference is no number.
                if half - half.floor() == 0.0 { *even } else { *odd }
            }
            Self::Image { bitmap, wrap, smooth } => {
                let Some(Taps { pixels, right, down }) = Taps::at(bitmap, *wrap, *smooth, point.uv) else {
                    return Rgb::BLACK;
                };
                // Not by `map`, whose closure is called for each pixel.
                let [a, b, c, d] = pixels;
                let [a, b, c, d] = [bitmap.pixel(a), bitmap.pixel(b), bitmap.pixel(c), bitmap.pixel(d)];
                a.lerp(b, right).lerp(c.lerp(d, right), down)
            }
        }
    }

    /// Alpha at a point, 0 to 1; 1 for textures without alpha.
    pub fn alpha_at(&self, point: &TexturePoint) -> f64 {
        match self {
            Self::Mapped { texture, map } => texture.alpha_at(&TexturePoint { uv: map.map(point), ..*point }),
            Self::VertexColor(texture) => texture.as_ref().map_or(1.0, |texture| texture.alpha_at(point)),
            Self::Checker { .. } => 1.0,
            Self::Image { bitmap, wrap, smooth } => {
                let Some(Taps { pixels, right, down }) = Taps::at(bitmap, *wrap, *smooth, point.uv) else { return 1.0 };
                let [a, b, c, d] = pixels.map(|index| bitmap.alpha.get(index).map_or(1.0, |alpha| f64::from(*alpha)));
                let (upper, lower) = (a + (b - a) * right, c + (d - c) * right);
                upper + (lower - upper) * down
            }
        }
    }

    /// Image of the texture, if any.
    pub fn bitmap(&self) -> Option<&Arc<Bitmap>> {
        match self {
            Self::Image { bitmap, .. } => Some(bitmap),
            Self::Mapped { texture, .. } => texture.bitmap(),
            Self::VertexColor(texture) => texture.as_ref()?.bitmap(),
            Self::Checker { .. } => None,
        }
    }
}

/// Four pixels around a point, from the upper left to the lower right, and the fractions for interpolation. Without
/// interpolation, all are the nearest pixel.
struct Taps {
    pixels: [usize; 4],
    right: f64,
    down: f64,
}

impl Taps {
    /// Taps at texture coordinates. `None` for an empty image and for coordinates that are not finite.
    fn at(bitmap: &Bitmap, wrap: [Wrap; 2], smooth: bool, [u, v]: [f64; 2]) -> Option<Self> {
        let (x, y) = (u * f64::from(bitmap.width), (1.0 - v) * f64::from(bitmap.height));
        if bitmap.width == 0 || bitmap.height == 0 || !(x.is_finite() && y.is_finite()) {
            return None;
        }
        let column = |x: f64| wrap[0].index(x as i64, bitmap.width) as usize;
        let start_of_row = |y: f64| wrap[1].index(y as i64, bitmap.height) as usize * bitmap.width as usize;
        if !smooth {
            return Some(Self { pixels: [start_of_row(y.floor()) + column(x.floor()); 4], right: 0.0, down: 0.0 });
        }
        // Pixel centres lie at half-integers.
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (a, b) = (column(left), column(left + 1.0));
        let (upper, lower) = (start_of_row(top), start_of_row(top + 1.0));
        Some(Self { pixels: [upper + a, upper + b, lower + a, lower + b], right: x - left, down: y - top })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(wrap: Wrap, smooth: bool) -> Texture {
        // Top row 1 2, bottom row 3 4.
        let pixels = [1.0, 2.0, 3.0, 4.0].map(|v| [v; 3]).to_vec();
        Texture::Image { bitmap: Arc::new(Bitmap::opaque(2, 2, pixels)), wrap: [wrap; 2], smooth }
    }

    fn at(texture: &Texture, u: f64, v: f64) -> f64 {
        texture.at(&TexturePoint::at([u, v])).r
    }

    #[test]
    fn v_runs_upwards() {
        let nearest = image(Wrap::Repeat, false);
        assert_eq!(at(&nearest, 0.25, 0.75), 1.0);
        assert_eq!(at(&nearest, 0.75, 0.75), 2.0);
        assert_eq!(at(&nearest, 0.25, 0.25), 3.0);
        assert_eq!(at(&nearest, 0.75, 0.25), 4.0);
    }

    #[test]
    fn all_integers_wrap_into_the_row() {
        for length in [1_u32, 2, 3, 640, u32::MAX] {
            let n = i128::from(length);
            for i in [i64::MIN, i64::MIN + 1, -641, -3, -1, 0, 1, 640, 1281, i64::from(length), i64::MAX - 1, i64::MAX]
            {
                let wide = i128::from(i);
                let mirrored = wide.rem_euclid(2 * n);
                let expected = [
                    (Wrap::Repeat, wide.rem_euclid(n)),
                    (Wrap::Clamp, wide.clamp(0, n - 1)),
                    (Wrap::Mirror, if mirrored < n { mirrored } else { 2 * n - 1 - mirrored }),
                ];
                for (wrap, index) in expected {
                    assert_eq!(i128::from(wrap.index(i, length)), index, "{wrap:?} of {i} in {length}");
                }
            }
        }
    }

    #[test]
    fn coordinates_outside_wrap() {
        assert_eq!(at(&image(Wrap::Repeat, false), 1.25, -0.25), 1.0);
        assert_eq!(at(&image(Wrap::Clamp, false), 1.75, -3.0), 4.0);
        assert_eq!(at(&image(Wrap::Mirror, false), 1.25, 0.25), 4.0);
        assert_eq!(at(&image(Wrap::Mirror, false), -0.25, 0.25), 3.0);
    }

    #[test]
    fn smooth_images_interpolate_between_pixel_centres() {
        let smooth = image(Wrap::Clamp, true);
        assert_eq!(at(&smooth, 0.5, 0.5), 2.5);
        assert_eq!(at(&smooth, 0.25, 0.75), 1.0);
        assert_eq!(at(&smooth, 0.5, 0.75), 1.5);
        assert_eq!(at(&image(Wrap::Repeat, true), 0.0, 0.5), 2.5);
    }

    #[test]
    fn checkers_alternate_across_zero() {
        let checker = Texture::Checker { even: Rgb::WHITE, odd: Rgb::BLACK, size: 2.0 };
        assert_eq!(at(&checker, 1.0, 1.0), 1.0);
        assert_eq!(at(&checker, -1.0, 1.0), 0.0);
        assert_eq!(at(&checker, -1.0, -1.0), 1.0);
        assert_eq!(at(&checker, 3.0, 1.0), 0.0);
    }

    #[test]
    fn invalid_coordinates_and_images_are_black() {
        let at = |texture: Texture, uv| texture.at(&TexturePoint::at(uv));
        assert_eq!(at(image(Wrap::Repeat, true), [f64::NAN, 0.0]), Rgb::BLACK);
        assert_eq!(at(image(Wrap::Repeat, true), [f64::INFINITY, 0.0]), Rgb::BLACK);
        assert!(at(image(Wrap::Clamp, true), [1e300, -1e300]).is_finite());
        assert!(at(image(Wrap::Clamp, true), [1e308, 0.5]).is_finite(), "more pixels away than numbers reach");
        let empty = Arc::new(Bitmap::opaque(0, 0, vec![]));
        assert_eq!(at(Texture::Image { bitmap: empty, wrap: [Wrap::Repeat; 2], smooth: true }, [0.5; 2]), Rgb::BLACK);
    }

    #[test]
    fn coordinates_are_mapped() {
        let texture = Arc::new(image(Wrap::Repeat, false));
        let half = [[0.5, 0.0, 0.25], [0.0, 0.5, 0.25]];
        let detail =
            VertexAttributes { second_uv: [0.25, 0.75], color: [0.5, 1.0, 1.0], ..VertexAttributes::default() };
        let point = TexturePoint { uv: [1.0, 0.0], detail };
        let mapped =
            |is_second, rows| Texture::Mapped { texture: Arc::clone(&texture), map: UvMap { is_second, rows } };
        // (1, 0) leads to (0.75, 0.25), the lower right pixel.
        assert_eq!(mapped(false, half).at(&point).r, 4.0);
        assert_eq!(mapped(true, UvMap::IDENTITY.rows).at(&point).r, 1.0);
        let tinted = Texture::VertexColor(Some(Arc::new(mapped(false, half))));
        assert_eq!(tinted.at(&point), Rgb::new(2.0, 4.0, 4.0));
        assert_eq!(Texture::VertexColor(None).at(&point), Rgb::new(0.5, 1.0, 1.0));
    }

    #[test]
    fn alpha_is_interpolated_like_colours() {
        let bitmap = Bitmap { alpha: vec![1.0, 0.0], ..Bitmap::opaque(2, 1, vec![[1.0; 3]; 2]) };
        let texture = Texture::Image { bitmap: Arc::new(bitmap), wrap: [Wrap::Clamp; 2], smooth: true };
        let alpha = |u| texture.alpha_at(&TexturePoint::at([u, 0.5]));
        assert_eq!([alpha(0.25), alpha(0.5), alpha(0.75)], [1.0, 0.5, 0.0]);
        assert_eq!(image(Wrap::Clamp, true).alpha_at(&TexturePoint::at([0.5; 2])), 1.0);
    }
}
