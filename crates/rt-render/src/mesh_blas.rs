//! Triangle meshes of the bottom level.

use std::sync::Arc;

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{Hit, HitStream, Probe, RayStream, TriangleMesh};
use rt_math::{Interval, Ray};
use rt_shading::Texture;

use crate::alpha_mesh::{AlphaTest, AlphaTestedMesh};

/// Mesh with the acceleration structure of its triangles, in local space.
#[derive(Debug)]
pub(crate) struct MeshBlas {
    pub(crate) mesh: Arc<TriangleMesh>,
    pub(crate) alpha_test: Option<AlphaTest>,
    pub(crate) accelerator: AnyAccelerator,
}

/// Evaluates an expression with the triangles of a mesh, which pass its alpha test if it has one.
macro_rules! with_triangles {
    ($blas:expr, $textures:expr, $triangles:ident => $body:expr) => {
        match &$blas.alpha_test {
            None => {
                let $triangles = &*$blas.mesh;
                $body
            }
            Some(alpha_test) => {
                let $triangles = &AlphaTestedMesh { mesh: &$blas.mesh, alpha_test, textures: $textures };
                $body
            }
        }
    };
}

impl MeshBlas {
    pub(crate) fn closest<S: Probe>(
        &self,
        textures: &[Texture],
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        with_triangles!(self, textures, triangles => self.accelerator.closest(triangles, ray, span, probe))
    }

    pub(crate) fn occluded<S: Probe>(&self, textures: &[Texture], ray: &Ray, span: Interval, probe: &mut S) -> bool {
        with_triangles!(self, textures, triangles => self.accelerator.occluded(triangles, ray, span, probe))
    }

    pub(crate) fn closest_stream<S: Probe>(
        &self,
        textures: &[Texture],
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        with_triangles!(self, textures, triangles => self.accelerator.closest_stream(triangles, rays, hits, probe));
    }

    pub(crate) fn occluded_stream<S: Probe>(
        &self,
        textures: &[Texture],
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        with_triangles!(self, textures, triangles => self.accelerator.occluded_stream(triangles, rays, occluded, probe));
    }
}
