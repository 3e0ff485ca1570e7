//! NFF text.

use std::fmt::Write;

use rt_math::DVec3;

/// A file that grows by statements, and the numbers of its objects.
#[derive(Debug, Default)]
pub(super) struct Nff {
    text: String,
    /// Polygons, spheres, cylinders and cones.
    pub(super) polygons: usize,
    pub(super) spheres: usize,
    pub(super) cones: usize,
}

/// A fill: colour, Kd, Ks, shine, transmittance, index of refraction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fill {
    pub(super) colour: [f64; 3],
    pub(super) diffuse: f64,
    pub(super) specular: f64,
    pub(super) shine: f64,
    pub(super) transmittance: f64,
    pub(super) ior: f64,
}

impl Fill {
    /// A surface without highlight and mirror.
    pub(super) const fn matte(colour: [f64; 3], diffuse: f64) -> Self {
        Self { colour, diffuse, specular: 0.0, shine: 1.0, transmittance: 0.0, ior: 1.0 }
    }
}

/// Camera of a square image, 45 degrees wide, before a blue sky.
#[derive(Clone, Copy, Debug)]
pub(super) struct NffView {
    pub(super) from: DVec3,
    pub(super) at: DVec3,
    pub(super) up: DVec3,
}

/// Coordinates smaller than this are written as 0.
const NOTHING: f64 = 1e-9;

/// A number in six digits after the first.
fn number(x: f64) -> String {
    if x.abs() < NOTHING {
        return "0".to_owned();
    }
    // What is printed with an exponent is read back to be printed without.
    let text = format!("{x:.6e}");
    text.parse::<f64>().map_or(text, |rounded| rounded.to_string())
}

fn vector(v: DVec3) -> String {
    v.to_array().map(number).join(" ")
}

impl Nff {
    /// A file that begins with a comment, the sky, the view and the lights.
    pub(super) fn new(comment: &str, view: &NffView, lights: &[DVec3]) -> Self {
        let mut file = Self::default();
        let NffView { from, at, up } = view;
        file.line(format_args!("# {comment}\nb 0.078 0.361 0.753"));
        file.line(format_args!("v\nfrom {}\nat {}\nup {}", vector(*from), vector(*at), vector(*up)));
        file.line(format_args!("angle 45\nhither 0.01\nresolution 512 512"));
        for light in lights {
            file.line(format_args!("l {}", vector(*light)));
        }
        file
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{line}");
    }

    /// The surface of what follows.
    pub(super) fn fill(&mut self, fill: &Fill) {
        let Fill { colour, diffuse, specular, shine, transmittance, ior } = fill;
        let colour = vector(DVec3::from(*colour));
        self.line(format_args!("f {colour} {diffuse} {specular} {shine} {transmittance} {ior}"));
    }

    pub(super) fn sphere(&mut self, centre: DVec3, radius: f64) {
        self.spheres += 1;
        self.line(format_args!("s {} {}", vector(centre), number(radius)));
    }

    /// A cylinder or cone between two points, each with its radius.
    pub(super) fn cone(&mut self, base: (DVec3, f64), apex: (DVec3, f64)) {
        self.cones += 1;
        let end = |(place, radius)| format!("{} {}", vector(place), number(radius));
        self.line(format_args!("c\n{}\n{}", end(base), end(apex)));
    }

    pub(super) fn polygon(&mut self, corners: &[DVec3]) {
        self.polygons += 1;
        self.line(format_args!("p {}", corners.len()));
        for corner in corners {
            self.line(format_args!("{}", vector(*corner)));
        }
    }

    /// Number of all objects.
    pub(super) const fn objects(&self) -> usize {
        self.polygons + self.spheres + self.cones
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_seven_digits_and_no_exponent() {
        assert_eq!(number(1.0 / 3.0), "0.3333333");
        assert_eq!(number(-12_345.678_9), "-12345.68");
        assert_eq!(number(1e-17), "0");
        assert_eq!(number(2.5e-8), "0.000000025");
    }
}
