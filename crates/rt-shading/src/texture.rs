//! Colour that varies over a surface.

use rt_math::Rgb;

/// Index of a texture in [`Appearance::textures`](crate::Appearance::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// What happens beyond the edge of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// It repeats.
    Repeat,
    /// It repeats, mirrored every other time.
    Mirror,
    /// The edge goes on.
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
}

/// A colour as a function of texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// A checkerboard with squares of side `size` in texture space; the square at the origin is `even`.
    Checker {
        /// Colour of the squares whose coordinates add up to an even number.
        even: Rgb,
        /// Colour of the others.
        odd: Rgb,
        /// Side of a square.
        size: f64,
    },
    /// An image; (0, 0) is its lower left corner, (1, 1) its upper right.
    Image {
        /// The pixels.
        bitmap: Bitmap,
        /// Beyond the edge, along u and v.
        wrap: [Wrap; 2],
        /// Interpolate between pixels rather than take the nearest.
        smooth: bool,
    },
}

impl Wrap {
    /// The pixel that index `i`, possibly outside, stands for in a row of `length`.
    fn index(self, i: i64, length: u32) -> u32 {
        let n = i64::from(length);
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
    /// The pixel in column `x` and row `y`; black if there is none.
    fn pixel(&self, x: u32, y: u32) -> Rgb {
        let index = y as usize * self.width as usize + x as usize;
        self.pixels.get(index).map_or(Rgb::BLACK, |p| Rgb::from(p.map(f64::from)))
    }
}

impl Texture {
    /// The colour at texture coordinates `uv`; black where these are not finite, or no pixel can be numbered.
    pub fn at(&self, uv: [f64; 2]) -> Rgb {
        if !(uv[0].is_finite() && uv[1].is_finite()) {
            return Rgb::BLACK;
        }
        match self {
            Self::Checker { even, odd, size } => {
                let parity = ((uv[0] / size).floor() + (uv[1] / size).floor()).rem_euclid(2.0);
                if parity == 0.0 { *even } else { *odd }
            }
            Self::Image { bitmap, wrap, smooth } => image_at(bitmap, *wrap, *smooth, uv),
        }
    }
}

fn image_at(bitmap: &Bitmap, wrap: [Wrap; 2], smooth: bool, [u, v]: [f64; 2]) -> Rgb {
    if bitmap.width == 0 || bitmap.height == 0 {
        return Rgb::BLACK;
    }
    let fetch =
        |x: f64, y: f64| bitmap.pixel(wrap[0].index(x as i64, bitmap.width), wrap[1].index(y as i64, bitmap.height));
    let (x, y) = (u * f64::from(bitmap.width), (1.0 - v) * f64::from(bitmap.height));
    if !(x.is_finite() && y.is_finite()) {
        return Rgb::BLACK;
    }
    if !smooth {
        return fetch(x.floor(), y.floor());
    }
    // Pixel centres lie at half-integers.
    let (x, y) = (x - 0.5, y - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let upper = fetch(left, top).lerp(fetch(left + 1.0, top), fx);
    let lower = fetch(left, top + 1.0).lerp(fetch(left + 1.0, top + 1.0), fx);
    upper.lerp(lower, fy)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(wrap: Wrap, smooth: bool) -> Texture {
        // Top row 1 2, bottom row 3 4.
        let pixels = [1.0, 2.0, 3.0, 4.0].map(|v| [v; 3]).to_vec();
        Texture::Image { bitmap: Bitmap { width: 2, height: 2, pixels }, wrap: [wrap; 2], smooth }
    }

    fn at(texture: &Texture, u: f64, v: f64) -> f64 {
        texture.at([u, v]).r
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
    fn images_wrap_as_asked() {
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
    fn nonsense_is_black() {
        assert_eq!(image(Wrap::Repeat, true).at([f64::NAN, 0.0]), Rgb::BLACK);
        assert_eq!(image(Wrap::Repeat, true).at([f64::INFINITY, 0.0]), Rgb::BLACK);
        assert!(image(Wrap::Clamp, true).at([1e300, -1e300]).is_finite());
        assert!(image(Wrap::Clamp, true).at([1e308, 0.5]).is_finite(), "more pixels away than numbers reach");
        let empty = Bitmap { width: 0, height: 0, pixels: vec![] };
        assert_eq!(Texture::Image { bitmap: empty, wrap: [Wrap::Repeat; 2], smooth: true }.at([0.5; 2]), Rgb::BLACK);
    }
}
