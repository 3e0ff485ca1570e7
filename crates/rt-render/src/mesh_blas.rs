//! Triangle meshes of the bottom level.

use std::sync::Arc;

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{Hit, Probe, TriangleMesh};
use rt_math::{Interval, Ray};
use rt_shading::Texture;

use crate::alpha_mesh::{AlphaTest, AlphaTestedMesh};

/// Mesh with the acceleration structure of its triangles, in local space.
#[derive(Debug)]
pub(crate) struct MeshBlas {
    pub(crate) mesh: Arc<TriangleMesh>,
    /// Alpha test of the material.
    pub(crate) alpha_test: Option<AlphaTest>,
    pub(crate) structure: AnyAccelerator,
}

impl MeshBlas {
    pub(crate) fn closest<S: Probe>(
        &self,
        textures: &[Texture],
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        match &self.alpha_test {
            None => self.structure.closest(&*self.mesh, ray, span, probe),
            Some(alpha_test) => {
                self.structure.closest(&AlphaTestedMesh { mesh: &self.mesh, alpha_test, textures }, ray, span, probe)
            }
        }
    }

    pub(crate) fn occluded<S: Probe>(&self, textures: &[Texture], ray: &Ray, span: Interval, probe: &mut S) -> bool {
        match &self.alpha_test {
            None => self.structure.occluded(&*self.mesh, ray, span, probe),
            Some(alpha_test) => {
                self.structure.occluded(&AlphaTestedMesh { mesh: &self.mesh, alpha_test, textures }, ray, span, probe)
            }
        }
    }

    pub(crate) fn closest_batch<S: Probe>(
        &self,
        textures: &[Texture],
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        match &self.alpha_test {
            None => self.structure.closest_batch(&*self.mesh, rays, hits, probe),
            Some(alpha_test) => {
                let tested = AlphaTestedMesh { mesh: &self.mesh, alpha_test, textures };
                self.structure.closest_batch(&tested, rays, hits, probe);
            }
        }
    }

    pub(crate) fn occluded_batch<S: Probe>(
        &self,
        textures: &[Texture],
        rays: &[(Ray, Interval)],
        blocked: &mut [bool],
        probe: &mut S,
    ) {
        match &self.alpha_test {
            None => self.structure.occluded_batch(&*self.mesh, rays, blocked, probe),
            Some(alpha_test) => {
                let tested = AlphaTestedMesh { mesh: &self.mesh, alpha_test, textures };
                self.structure.occluded_batch(&tested, rays, blocked, probe);
            }
        }
    }
}
