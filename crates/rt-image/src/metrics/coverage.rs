//! Difference of coverage.

use super::ImagePair;

/// The greatest difference of coverage of a pixel, where an image without coverage covers all of its pixels; `None` if
/// neither image has it. Infinite if a coverage is NaN in one image and not in the other.
pub fn coverage_difference(pair: &ImagePair<'_>) -> Option<f64> {
    let (test, reference) = (pair.test().alpha(), pair.reference().alpha());
    if test.is_none() && reference.is_none() {
        return None;
    }
    let coverage = |alpha: Option<&[f32]>, index: usize| alpha.map_or(1.0, |alpha| f64::from(alpha[index]));
    let differences = (0..pair.test().pixels().len()).map(|index| {
        let (a, b) = (coverage(test, index), coverage(reference, index));
        if a == b || a.is_nan() && b.is_nan() {
            0.0
        } else if a.is_nan() || b.is_nan() {
            f64::INFINITY
        } else {
            (a - b).abs()
        }
    });
    Some(differences.fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Image;

    #[test]
    fn what_is_missing_covers_everything() {
        let opaque = Image::new(3, 1, false);
        let mut cut_out = Image::new(3, 1, true);
        let difference = |a: &Image, b: &Image| coverage_difference(&ImagePair::new(a, b).expect("alike"));
        assert_eq!(difference(&opaque, &opaque), None);
        cut_out.alpha_mut().expect("asked for").copy_from_slice(&[1.0, 0.25, f32::NAN]);
        assert_eq!(difference(&cut_out, &cut_out), Some(0.0));
        assert_eq!(difference(&opaque, &cut_out), Some(f64::INFINITY));
        cut_out.alpha_mut().expect("asked for")[2] = 1.0;
        assert_eq!(difference(&opaque, &cut_out), Some(0.75));
        assert_eq!(difference(&cut_out, &opaque), Some(0.75));
    }
}
