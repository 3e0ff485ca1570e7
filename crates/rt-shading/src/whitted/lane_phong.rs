//! Phong models of materials without textures or with checkerboards, in the form that lanes read.

use crate::{
    Appearance, ColorTexture, FloatTexture, Highlight, Material, ShadingFeatures, Texture, TextureId,
    hit_context::SurfaceTransmission,
    lane_set::LaneSet,
    light::EmissionSides,
    wavefront::{IOR_RANGE, delta_lights::light_fits_f32, is_in_range},
};
use rt_math::{Real as _, Rgb, Vector3, transcendental::Pow};

/// Largest exponent of a highlight: the power multiplies the rounding error of the cosine by it.
const MAX_EXPONENT: f64 = 1000.0;

/// Phong model of a material, whose textures are checkerboards with cells of the same size, or which has none.
#[derive(Clone, Debug)]
pub(super) struct LanePhong {
    /// Models of even and of odd cells.
    cells: [UniformPhong; 2],
    /// Side of a cell in texture space; infinite without textures.
    side: f64,
}

/// Phong model without textures.
#[derive(Clone, Debug)]
pub(super) struct UniformPhong {
    /// Emission and reflected ambient light, of the front and of the back.
    pub(super) radiance: [Rgb; 2],
    pub(super) diffuse: Rgb,
    pub(super) specular: Rgb,
    exponent: f64,
    highlight: Highlight,
    pub(super) mirror: Rgb,
    /// Coefficient of transmitted light, and true if Fresnel's equations apply.
    pub(super) transmission: Option<(Rgb, bool)>,
    /// Media that a ray may enter or leave through the surface.
    pub(super) interface: SurfaceTransmission,
}

/// Phong models of the materials of a scene by index; `None` for those that are shaded one by one.
#[derive(Clone, Debug)]
pub(super) struct LanePhongs {
    phongs: Vec<Option<LanePhong>>,
    /// True if there are no others.
    pub(super) are_complete: bool,
    /// True if shadow rays pass the surfaces of media that absorb ([`Appearance::has_shadow_media`]).
    pub(super) has_shadow_media: bool,
}

impl LanePhongs {
    /// Models with these features. Which materials have one does not depend on the features. None has one if a light does
    /// not fit `f32`. Light with inverse-square falloff may still overflow at a distance of less than 10⁻¹³.
    pub(super) fn new(appearance: &Appearance, features: &ShadingFeatures) -> Self {
        let lights_fit_f32 = appearance.lights.iter().all(light_fits_f32);
        let has_shadow_media = appearance.has_shadow_media(features);
        let of = |material: &Material| {
            // The media of shadow rays from transparent surfaces are found one by one.
            if has_shadow_media && SurfaceTransmission::of(features, material) != SurfaceTransmission::None {
                return None;
            }
            let ior_fits_f32 = material.interior.is_none_or(|interior| IOR_RANGE.contains(&interior.ior));
            let fits_f32 = lights_fit_f32
                && ior_fits_f32
                && LanePhong::of(material, appearance, &ShadingFeatures::ALL).is_some_and(|phong| phong.fits_f32());
            if fits_f32 { LanePhong::of(material, appearance, features) } else { None }
        };
        let phongs: Vec<_> = appearance.materials.iter().map(of).collect();
        Self { are_complete: phongs.iter().all(Option::is_some), phongs, has_shadow_media }
    }

    #[inline(always)]
    pub(super) fn get(&self, material: u32) -> Option<&LanePhong> {
        self.phongs.get(material as usize)?.as_ref()
    }
}

impl LanePhong {
    /// True if all colours are in range ([`is_in_range`]), and the highlights are wide enough for cosines in `f32`.
    fn fits_f32(&self) -> bool {
        self.colors().all(is_in_range) && self.exponent() <= MAX_EXPONENT
    }

    fn of(material: &Material, appearance: &Appearance, features: &ShadingFeatures) -> Option<Self> {
        let mut side = None;
        let mut cell = |is_odd| {
            let mut color = |texture: ColorTexture| match texture {
                ColorTexture::Constant(rgb) => Some(rgb),
                ColorTexture::Textured(TextureId(id), factor) => match appearance.textures.get(id as usize)? {
                    &Texture::Checker { even, odd, size } if size.is_finite() && *side.get_or_insert(size) == size => {
                        Some(if is_odd { odd } else { even } * factor)
                    }
                    _ => None,
                },
            };
            UniformPhong::of(material, appearance, features, &mut color)
        };
        let cells = [cell(false)?, cell(true)?];
        Some(Self { cells, side: side.unwrap_or(f64::INFINITY) })
    }

    /// Largest exponent of the highlights of cells.
    fn exponent(&self) -> f64 {
        let of_cell = |cell: &UniformPhong| if cell.specular == Rgb::BLACK { 0.0 } else { cell.exponent };
        let [even, odd] = &self.cells;
        of_cell(even).max(of_cell(odd))
    }

    /// Colours of all cells.
    fn colors(&self) -> impl Iterator<Item = Rgb> {
        let of_cell = |cell: &UniformPhong| {
            let [front, back] = cell.radiance;
            [front, back, cell.diffuse, cell.specular, cell.mirror, cell.transmission_coefficient()]
        };
        self.cells.iter().flat_map(of_cell)
    }

    /// True if its colours differ between cells.
    #[inline(always)]
    pub(super) const fn is_checkered(&self) -> bool {
        self.side != f64::INFINITY
    }

    /// Lanes on an odd cell of the checkerboard, given texture coordinates.
    #[inline(always)]
    pub(super) fn odd_cells<L: LaneSet>(&self, lanes: L, [u, v]: [L::D; 2]) -> u8 {
        let side = lanes.splat_f64(self.side);
        let half = (lanes.floor_f64(u / side) + lanes.floor_f64(v / side)) * 0.5;
        !lanes.bits_f64((half - lanes.floor_f64(half)).eq(lanes.splat_f64(0.0)))
    }

    /// Model of an odd cell if the lowest bit of `odd` is set, else of an even one.
    #[inline(always)]
    pub(super) const fn cell(&self, odd: u8) -> &UniformPhong {
        &self.cells[(odd & 1) as usize]
    }
}

impl UniformPhong {
    /// Model with the constant colours of textures.
    fn of(
        material: &Material,
        appearance: &Appearance,
        features: &ShadingFeatures,
        constant: &mut impl FnMut(ColorTexture) -> Option<Rgb>,
    ) -> Option<Self> {
        let phong = material.to_phong();
        let FloatTexture::Constant(occlusion) = material.occlusion else { return None };
        let ambient = constant(phong.ambient)?;
        let ambient = if occlusion == 1.0 { ambient } else { ambient * occlusion };
        let transmission = match phong.transmission {
            Some(transmission) => Some((constant(transmission.coefficient)?, transmission.fresnel)),
            None => None,
        };
        let emission = constant(material.emission)?;
        let radiance = |emission: Rgb| {
            let emitted = if features.emission { Rgb::BLACK + emission } else { Rgb::BLACK };
            if features.ambient { emitted + ambient * appearance.ambient } else { emitted }
        };
        let back = if material.emission_sides == EmissionSides::Front { Rgb::BLACK } else { emission };
        Some(Self {
            radiance: [radiance(emission), radiance(back)],
            diffuse: constant(phong.diffuse)?,
            specular: if features.highlights { constant(phong.specular)? } else { Rgb::BLACK },
            exponent: phong.exponent,
            highlight: phong.highlight,
            mirror: constant(phong.mirror)?,
            transmission,
            interface: SurfaceTransmission::of(features, material),
        })
    }

    /// Emission and reflected ambient light of the back if the lowest bit of `inside` is set, else of the front.
    #[inline(always)]
    pub(super) const fn radiance_from(&self, inside: u8) -> Rgb {
        self.radiance[(inside & 1) as usize]
    }

    /// Coefficient of transmitted light; black without transmission.
    #[inline(always)]
    pub(super) fn transmission_coefficient(&self) -> Rgb {
        self.transmission.map_or(Rgb::BLACK, |(coefficient, _)| coefficient)
    }

    /// Version of [`Highlight::strength`] for lanes, given the normal, `wo` and `wi`.
    #[inline(always)]
    pub(super) fn highlight_strength<R: Pow>(&self, [normal, wo, wi]: [Vector3<R>; 3]) -> R {
        self.highlight.strength_lanes(normal, wo, wi, self.exponent)
    }
}
