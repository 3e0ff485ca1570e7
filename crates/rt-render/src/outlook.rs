//! What of a plan depends on the camera, made anew when the camera changes.
//!
//! ```text
//!   compile                 scene ──> world, structures, lights, needs ──┐
//!                                                                        ├──> plan
//!   compile, look_through   camera, film ──> outlook ────────────────────┘
//! ```

use rt_camera::{Camera, CameraSettings, FilmSettings};
use rt_math::Aabb;
use rt_scene_io::{Accel, Integrator, NamedCamera, Scene};

use crate::{
    Crop, PlanOptions, RenderError, RenderPlan, RenderSpace,
    passes::default_passes,
    plan::{View, World, check_adaptive, check_crop, view_volume},
    structure::Wanted,
    surroundings::CameraMedium,
    visible::Visible,
    world::Part,
};

/// A camera of a scene, and the image that it exposes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot<'a> {
    /// In coordinates of the scene.
    pub(crate) camera: &'a NamedCamera,
    /// Width and height of the whole image in pixels.
    pub(crate) size: [u32; 2],
}

impl Shot<'_> {
    /// When the shutter is open, if that is a single moment.
    pub(crate) fn moment(&self) -> Option<f64> {
        let [opens, closes] = self.camera.settings.shutter;
        (opens == closes).then_some(opens)
    }
}

/// What is known of a scene before anyone looks at it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) options: &'a PlanOptions,
    pub(crate) wanted: Wanted,
    pub(crate) space: RenderSpace,
    pub(crate) world: &'a World,
    /// Whether materials let light through.
    pub(crate) refracts: bool,
}

/// What a plan knows by its camera.
pub(crate) struct Outlook {
    pub(crate) camera: Camera,
    pub(crate) size: [u32; 2],
    pub(crate) crop: Crop,
    pub(crate) visible: Option<Visible>,
    pub(crate) narrows: bool,
    pub(crate) view: View,
    pub(crate) surroundings: CameraMedium,
    pub(crate) moves: bool,
    pub(crate) passes: u32,
    pub(crate) pass_spp: u32,
    pub(crate) simple_pass_spp: Option<u32>,
}

impl Outlook {
    /// What the stage looks like in the shot.
    pub(crate) fn of(stage: &Stage<'_>, shot: &Shot<'_>) -> Result<Self, RenderError> {
        let Stage { scene, options, wanted, space, world, refracts } = *stage;
        let (settings, [width, height]) = (&scene.settings, shot.size);
        FilmSettings { width, height, ..scene.film }.validate()?;
        let crop = check_crop(options.crop, width, height)?;
        let camera = Camera::new(&space.camera(&shot.camera.settings), width, height)
            .map_err(|source| RenderError::Camera { name: shot.camera.name.clone(), source })?;
        let moves = camera.moves() || world.moves();
        check_adaptive(settings, &camera, moves)?;
        let visible = if options.full { None } else { visible(stage, &camera, crop)? };
        let (near, far) = depth_range(&camera, &world.bounds());
        let stochastic = settings.integrator.is_stochastic() || camera.has_lens() || moves;
        let passes = settings.passes.unwrap_or_else(|| default_passes(settings.pattern, settings.spp, stochastic));
        let surroundings = if settings.integrator.follows_light() && refracts {
            CameraMedium::of(shot.camera, &camera, moves, scene, world)
        } else {
            CameraMedium::air()
        };
        let of_pass = |spp: u32| settings.pattern.round_up(spp.div_ceil(passes));
        Ok(Self {
            size: shot.size,
            crop,
            visible,
            narrows: !options.full
                && wanted.accel == Accel::Auto
                && settings.integrator != Integrator::Cost
                && !camera.moves(),
            view: View::new(settings, near, far),
            surroundings,
            moves,
            passes,
            pass_spp: of_pass(settings.spp),
            simple_pass_spp: settings.adaptive.map(|adaptive| of_pass(adaptive.least(settings.spp).min(settings.spp))),
            camera,
        })
    }
}

impl RenderPlan<'_> {
    /// Looks at the scene through another camera, which exposes a whole image of this width and height. The camera keeps the
    /// name of the one before, and stands inside of the same medium.
    ///
    /// The picture is that of a plan compiled with this camera in the scene, to the bit. Structures stay as they are, so that it
    /// takes milliseconds; only where the camera leads to another origin of coordinates, in a scene far from the origin, or opens
    /// its shutter for a moment rather than a while, or the other way round, all is compiled anew.
    ///
    /// # Errors
    /// As of [`compile`](Self::compile); the plan is as it was then.
    pub fn look_through(&mut self, camera: &CameraSettings, size: [u32; 2]) -> Result<(), RenderError> {
        let options = PlanOptions { crop: None, ..self.options };
        let before = self.scene.cameras.get(options.camera);
        let camera =
            NamedCamera { name: self.camera_name.to_owned(), settings: *camera, medium: before.and_then(|c| c.medium) };
        let shot = Shot { camera: &camera, size };
        if RenderSpace::of(self.scene, &camera.settings) != self.space || shot.moment() != self.moment {
            *self = Self::compile_shot(self.scene, &options, &shot, self.camera_name)?;
            return Ok(());
        }
        let outlook = Outlook::of(&self.stage(&options), &shot)?;
        self.options = options;
        self.set_outlook(outlook);
        Ok(())
    }

    fn stage<'a>(&'a self, options: &'a PlanOptions) -> Stage<'a> {
        let Self { scene, wanted, space, ref world, needs, .. } = *self;
        Stage { scene, options, wanted, space, world, refracts: needs.refraction }
    }

    fn set_outlook(&mut self, outlook: Outlook) {
        Outlook {
            camera: self.camera,
            size: self.size,
            crop: self.crop,
            visible: self.visible,
            narrows: self.narrows,
            view: self.view,
            surroundings: self.surroundings,
            moves: self.moves,
            passes: self.passes,
            pass_spp: self.pass_spp,
            simple_pass_spp: self.simple_pass_spp,
        } = outlook;
    }
}

impl World {
    /// True if something moves.
    fn moves(&self) -> bool {
        match self {
            Self::Spheres(..) => false,
            Self::Parts(top, levels) => top.all_parts(levels).any(Part::moves),
        }
    }

    /// The least box around all that is bounded.
    pub(crate) fn bounds(&self) -> Aabb {
        match self {
            Self::Spheres(world, _) => {
                world.spheres.as_slice().iter().fold(Aabb::EMPTY, |sum, sphere| sum.union(sphere.bounds()))
            }
            Self::Parts(top, _) => top.parts.iter().filter_map(|part| part.bounds).fold(Aabb::EMPTY, Aabb::union),
        }
    }
}

/// What the camera rays of the crop are asked of, where that pays. The cost view shows the work that the structure over
/// the whole scene takes; a camera that moves looks into many volumes.
fn visible(stage: &Stage<'_>, camera: &Camera, crop: Crop) -> Result<Option<Visible>, RenderError> {
    let scene = stage.scene;
    if scene.settings.integrator == Integrator::Cost || camera.moves() {
        return Ok(None);
    }
    let volume = view_volume(camera, scene.film.sample_offset, scene.film.filter, crop);
    let visible = match stage.world {
        World::Spheres(world, _) => Visible::build(stage.wanted, world, &volume),
        World::Parts(top, levels) => Visible::build(stage.wanted, &top.set(levels), &volume),
    };
    visible.map_err(|source| RenderError::Build { object: scene.name.clone(), source })
}

/// Nearest and farthest depth of a box, along the view axis.
fn depth_range(camera: &Camera, bounds: &Aabb) -> (f64, f64) {
    if bounds.is_empty() {
        return (0.0, 1.0);
    }
    let depths = bounds.corners().map(|corner| camera.depth(corner));
    let near = depths.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
    let far = depths.into_iter().fold(0.0, f64::max);
    if near < far { (near, far) } else { (near, near + 1.0) }
}
