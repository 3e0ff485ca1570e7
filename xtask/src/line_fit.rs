//! Straight lines by least squares.

/// Line of least squares through points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineFit {
    /// Mean of the points, which the line goes through.
    pub x: f64,
    pub y: f64,
    /// NaN unless two points have different abscissas.
    pub slope: f64,
    /// Standard error of the slope; NaN for fewer than three points.
    pub slope_error: f64,
}

impl LineFit {
    pub(crate) fn of(points: &[[f64; 2]]) -> Self {
        let count = points.len() as f64;
        let [x, y] = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
        let spread: f64 = points.iter().map(|point| (point[0] - x) * (point[0] - x)).sum();
        let slope = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>() / spread;
        let residual = |point: &[f64; 2]| point[1] - y - slope * (point[0] - x);
        let squares: f64 = points.iter().map(|point| residual(point) * residual(point)).sum();
        let freedom = if points.len() > 2 { count - 2.0 } else { f64::NAN };
        Self { x, y, slope, slope_error: (squares / freedom / spread).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_of_a_regression() {
        // Slope 1/2, residuals −1/2, 1, −1/2, error √(1.5 / 1 / 2).
        let LineFit { x, y, slope, slope_error } = LineFit::of(&[[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]]);
        assert_eq!([x, y, slope], [1.0, 1.0, 0.5]);
        assert!((slope_error - 0.75f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn few_points_have_no_error_or_no_slope() {
        let two = LineFit::of(&[[1.0, 1.0], [2.0, 3.0]]);
        assert!(two.slope == 2.0 && two.slope_error.is_nan());
        assert!(LineFit::of(&[[1.0, 1.0], [1.0, 3.0]]).slope.is_nan() && LineFit::of(&[]).slope.is_nan());
    }
}
