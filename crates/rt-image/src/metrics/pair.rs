//! Two images of one size.

use crate::Image;

/// An image and the reference that it is compared with, of the same size and with a pixel that is finite in both.
#[derive(Clone, Copy, Debug)]
pub struct ImagePair<'f> {
    test: &'f Image,
    reference: &'f Image,
    non_finite: NonFinite,
}

/// Pixels with a component that is NaN or infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NonFinite {
    /// Pixels of the image under test.
    pub test: u64,
    /// Pixels of the reference.
    pub reference: u64,
    /// Pixels that are not finite in one of the images, and not the same in the other: a NaN is the same as a NaN.
    pub different: u64,
}

/// Error of [`ImagePair::new`]: images that cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PairError {
    /// They differ in size (width and height in pixels).
    #[error(
        "the images differ in size: {}x{} and {}x{} pixels; compare images of the same size",
        test[0], test[1], reference[0], reference[1]
    )]
    Size {
        /// Size of the image under test.
        test: [u32; 2],
        /// Size of the reference.
        reference: [u32; 2],
    },
    /// The images are empty, or every pixel is NaN or infinite in one of them.
    #[error("no pixel is finite in both images; metrics need at least one")]
    NothingFinite,
}

impl<'f> ImagePair<'f> {
    /// Pairs an image with a reference.
    ///
    /// # Errors
    /// [`PairError`] if they differ in size, or have no pixel that is finite in both.
    pub fn new(test: &'f Image, reference: &'f Image) -> Result<Self, PairError> {
        let size = |film: &Image| [film.width(), film.height()];
        if size(test) != size(reference) {
            return Err(PairError::Size { test: size(test), reference: size(reference) });
        }
        let mut non_finite = NonFinite::default();
        let mut nothing_finite = true;
        for (x, r) in test.pixels().iter().zip(reference.pixels()) {
            let finite = [x, r].map(|pixel| pixel.iter().all(|value| value.is_finite()));
            nothing_finite &= finite != [true; 2];
            non_finite.test += u64::from(!finite[0]);
            non_finite.reference += u64::from(!finite[1]);
            let same = x.iter().zip(r).all(|(x, r)| x == r || x.is_nan() && r.is_nan());
            non_finite.different += u64::from(finite != [true; 2] && !same);
        }
        if nothing_finite { Err(PairError::NothingFinite) } else { Ok(Self { test, reference, non_finite }) }
    }

    /// The image under test.
    pub const fn test(&self) -> &'f Image {
        self.test
    }

    /// The reference.
    pub const fn reference(&self) -> &'f Image {
        self.reference
    }

    /// Width of both in pixels.
    pub const fn width(&self) -> u32 {
        self.test.width()
    }

    /// Height of both in pixels.
    pub const fn height(&self) -> u32 {
        self.test.height()
    }

    /// Pixels that the radiance metrics leave out.
    pub const fn non_finite(&self) -> NonFinite {
        self.non_finite
    }

    /// Radiance of the image and of the reference, row by row from the top; `None` where one of them is not finite.
    pub(super) fn pixels(&self) -> impl Iterator<Item = Option<PixelPair>> + Clone {
        self.test.pixels().iter().zip(self.reference.pixels()).map(|(x, r)| {
            let finite = x.iter().chain(r).all(|value| value.is_finite());
            finite.then(|| PixelPair { test: x.map(f64::from), reference: r.map(f64::from) })
        })
    }

    /// Those pixels that are finite in both images: at least one.
    pub(super) fn finite_pixels(&self) -> impl Iterator<Item = PixelPair> + Clone {
        self.pixels().flatten()
    }
}

/// A pixel that is finite in both images.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelPair {
    pub(super) test: [f64; 3],
    pub(super) reference: [f64; 3],
}

impl PixelPair {
    /// Test minus reference. The difference of two `f32` of like size is exact in `f64`.
    pub(super) fn error(&self) -> [f64; 3] {
        core::array::from_fn(|channel| self.test[channel] - self.reference[channel])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::film;

    #[test]
    fn sizes_must_agree() {
        let (wide, high) = (Image::new(3, 2, false), Image::new(2, 3, false));
        let error = ImagePair::new(&wide, &high).expect_err("they differ");
        assert_eq!(error, PairError::Size { test: [3, 2], reference: [2, 3] });
        assert_eq!(error.to_string(), "the images differ in size: 3x2 and 2x3 pixels; compare images of the same size");
        let empty = Image::new(0, 7, false);
        assert_eq!(ImagePair::new(&empty, &empty).expect_err("empty"), PairError::NothingFinite);
    }

    #[test]
    fn what_is_not_finite_is_counted_and_compared() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let test = film(6, 1, &[[nan, 0.0, 0.0], [inf, 1.0, 1.0], [inf; 3], [0.0; 3], [nan, 1.0, 0.0], [1.0; 3]]);
        let reference = film(6, 1, &[[nan, 0.0, 0.0], [inf, 1.0, 1.0], [-inf; 3], [nan; 3], [nan, 2.0, 0.0], [2.0; 3]]);
        let pair = ImagePair::new(&test, &reference).expect("the last pixel is finite");
        assert_eq!(pair.non_finite(), NonFinite { test: 4, reference: 5, different: 3 });
        assert_eq!(pair.finite_pixels().count(), 1);
        let blind = film(1, 1, &[[nan; 3]]);
        assert_eq!(ImagePair::new(&blind, &blind).expect_err("nothing to see"), PairError::NothingFinite);
    }
}
