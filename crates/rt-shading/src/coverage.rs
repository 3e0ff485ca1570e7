//! Alpha test of surfaces.

use crate::{Texture, TextureId, TexturePoint};

/// Rule for the covered part of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// All of it is there.
    Opaque,
    /// It is there where alpha is at least this number: leaves, fences.
    Mask(f64),
    /// Each ray meets it with the probability alpha, so that the mean over many rays is the blend of what is there and what
    /// is behind it (Wyman, McGuire, "Hashed Alpha Testing", 2017).
    Blend,
}

/// Parts of a surface that rays pass: the uncovered part, and culled back faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Meaning of alpha.
    pub alpha: Alpha,
    /// Factor of alpha.
    pub factor: f64,
    /// Texture whose alpha is multiplied to it.
    pub texture: Option<TextureId>,
    /// True if surfaces that enclose no space are visible from their front only.
    pub has_front_only: bool,
}

impl Coverage {
    /// All of it, on both sides.
    pub const ALL: Self = Self { alpha: Alpha::Opaque, factor: 1.0, texture: None, has_front_only: false };

    /// True if the surface is there at a point, on the side from which it is met. `vertices` is the alpha of the vertices;
    /// `threshold` gives a number in \[0, 1\), even and independent for each ray.
    pub fn covers(
        &self,
        textures: &[Texture],
        point: &TexturePoint,
        vertices: f64,
        threshold: impl FnOnce() -> f64,
    ) -> bool {
        if self.alpha == Alpha::Opaque {
            return true;
        }
        let texture = self.texture.and_then(|TextureId(id)| textures.get(id as usize));
        let alpha = self.factor * vertices * texture.map_or(1.0, |texture| texture.alpha_at(point));
        match self.alpha {
            Alpha::Opaque => true,
            Alpha::Mask(cutoff) => alpha >= cutoff,
            Alpha::Blend => alpha > threshold(),
        }
    }
}

impl Default for Coverage {
    fn default() -> Self {
        Self::ALL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covers(coverage: &Coverage, vertices: f64, threshold: f64) -> bool {
        coverage.covers(&[], &TexturePoint::default(), vertices, || threshold)
    }

    #[test]
    fn masks_cut_and_blends_let_through() {
        let mask = Coverage { alpha: Alpha::Mask(0.5), factor: 0.8, ..Coverage::ALL };
        assert!(covers(&mask, 0.625, 0.99) && !covers(&mask, 0.6, 0.0));
        let blend = Coverage { alpha: Alpha::Blend, factor: 0.5, ..Coverage::ALL };
        assert!(covers(&blend, 1.0, 0.49) && !covers(&blend, 1.0, 0.5));
        let nothing = Coverage { factor: 0.0, ..blend };
        assert!(!covers(&nothing, 1.0, 0.0), "what is not there is never met");
        assert!(covers(&Coverage::ALL, 0.0, 0.9), "alpha of opaque surfaces has no meaning");
    }
}
