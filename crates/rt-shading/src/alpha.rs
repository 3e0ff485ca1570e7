//! Alpha test of surfaces.

use crate::{Texture, TextureId, TexturePoint};

/// Meaning of alpha (glTF 2.0, section 3.9.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Rays hit where alpha is at least this cutoff, as for leaves and fences.
    Mask(f64),
    /// Each ray hits with the probability alpha (Wyman, McGuire, "Hashed Alpha Testing", 2017). The mean over rays is the
    /// blend of surface and background.
    Blend,
}

/// Parts of a surface that rays pass: transparent parts, and culled back faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Alpha {
    /// Meaning of alpha.
    pub mode: AlphaMode,
    /// Factor of alpha.
    pub factor: f64,
    /// Texture with alpha that is multiplied to the factor.
    pub texture: Option<TextureId>,
    /// True if rays pass the back faces of open surfaces.
    pub culls_back_faces: bool,
}

impl Alpha {
    /// Opaque on both sides.
    pub const OPAQUE: Self = Self { mode: AlphaMode::Opaque, factor: 1.0, texture: None, culls_back_faces: false };

    /// True if a ray hits the surface at a point.
    ///
    /// `vertex_alpha` is interpolated from the vertices. `threshold` returns a number in \[0, 1\), uniform and independent
    /// for each ray.
    pub fn hits(
        &self,
        textures: &[Texture],
        point: &TexturePoint,
        vertex_alpha: f64,
        threshold: impl FnOnce() -> f64,
    ) -> bool {
        if self.mode == AlphaMode::Opaque {
            return true;
        }
        let texture = self.texture.and_then(|TextureId(id)| textures.get(id as usize));
        let alpha = self.factor * vertex_alpha * texture.map_or(1.0, |texture| texture.alpha_at(point));
        match self.mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => alpha >= cutoff,
            AlphaMode::Blend => alpha > threshold(),
        }
    }
}

impl Default for Alpha {
    fn default() -> Self {
        Self::OPAQUE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hits(alpha: &Alpha, vertex_alpha: f64, threshold: f64) -> bool {
        alpha.hits(&[], &TexturePoint::default(), vertex_alpha, || threshold)
    }

    #[test]
    fn masks_cut_and_blends_are_stochastic() {
        let mask = Alpha { mode: AlphaMode::Mask(0.5), factor: 0.8, ..Alpha::OPAQUE };
        assert!(hits(&mask, 0.625, 0.99) && !hits(&mask, 0.6, 0.0));
        let blend = Alpha { mode: AlphaMode::Blend, factor: 0.5, ..Alpha::OPAQUE };
        assert!(hits(&blend, 1.0, 0.49) && !hits(&blend, 1.0, 0.5));
        let transparent = Alpha { factor: 0.0, ..blend };
        assert!(!hits(&transparent, 1.0, 0.0), "alpha 0 is never hit");
        assert!(hits(&Alpha::OPAQUE, 0.0, 0.9), "alpha of opaque surfaces has no meaning");
    }
}
