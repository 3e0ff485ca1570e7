//! Any of the structures, chosen while the program runs.

use core::ops::ControlFlow;

use crate::{
    Accelerator, AcceleratorQueries, Bih, BspTree, BuildError, BuildStats, Bvh, CylinderTree, KdTree, LazyBih, Linear,
    RayQuery, RegionQuery, SphereTree, UniformGrid, ValidationError, WideBvh,
};
use rt_geometry::{Hit, Primitives, Probe};
use rt_math::{Aabb, Interval, Ray};

use crate::wide::{BuildParams, Quality, SimdLevel};

/// Something to do with a structure of any type.
pub trait AcceleratorVisitor {
    /// What comes of it.
    type Output;

    /// Does it.
    fn visit<T: AcceleratorQueries>(self, structure: &T) -> Self::Output;
}

/// Lists all structures once, and makes what depends on the list.
macro_rules! structures {
    ($($(#[$doc:meta])* $name:ident($structure:ty) = $text:literal,)+) => {
        /// Which structure.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum AcceleratorKind {
            $($(#[$doc])* $name,)+
        }

        impl AcceleratorKind {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name),+];

            /// Its short name in lower case.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)+
                }
            }
        }

        /// A structure of a kind that is chosen at run time, at the cost of one `match` per query.
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum AnyAccelerator {
            $($(#[$doc])* $name($structure),)+
        }

        impl AnyAccelerator {
            /// Builds a structure with the defaults of its kind.
            ///
            /// # Errors
            ///
            /// As the builder of that kind.
            pub fn build<P: Primitives>(kind: AcceleratorKind, primitives: &P) -> Result<Self, BuildError> {
                Ok(match kind {
                    $(AcceleratorKind::$name => Self::$name(<$structure>::build(primitives)?),)+
                })
            }

            /// Builds a structure in as much time as `quality` allows. Only the wide tree knows qualities: the others are
            /// built with the defaults of their kind.
            ///
            /// # Errors
            ///
            /// As the builder of that kind.
            pub fn build_with<P: Primitives>(
                kind: AcceleratorKind,
                quality: Quality,
                primitives: &P,
            ) -> Result<Self, BuildError> {
                match kind {
                    AcceleratorKind::Wide => {
                        let params = BuildParams { quality, ..BuildParams::default() };
                        Ok(Self::Wide(WideBvh::build_with(primitives, &params)?))
                    }
                    other => Self::build(other, primitives),
                }
            }

            /// Has a list or wide structure asked by these instructions; changes no answer, and nothing about the others.
            #[must_use]
            pub fn with_level(self, level: SimdLevel) -> Self {
                match self {
                    Self::Linear(list) => Self::Linear(list.with_level(level)),
                    Self::Wide(wide) => Self::Wide(wide.with_level(level)),
                    other => other,
                }
            }

            /// Hands the structure itself to a visitor: the way to choose once and then query without a `match`.
            pub fn accept<V: AcceleratorVisitor>(&self, visitor: V) -> V::Output {
                match self {
                    $(Self::$name(structure) => visitor.visit(structure),)+
                }
            }

            /// What it is.
            pub const fn kind(&self) -> AcceleratorKind {
                match self {
                    $(Self::$name(_) => AcceleratorKind::$name,)+
                }
            }
        }

        impl Accelerator for AnyAccelerator {
            fn closest<P: Primitives, S: Probe>(
                &self,
                primitives: &P,
                ray: &Ray,
                span: Interval,
                probe: &mut S,
            ) -> Option<Hit> {
                match self {
                    $(Self::$name(structure) => structure.closest(primitives, ray, span, probe),)+
                }
            }

            fn occluded<P: Primitives, S: Probe>(
                &self,
                primitives: &P,
                ray: &Ray,
                span: Interval,
                probe: &mut S,
            ) -> bool {
                match self {
                    $(Self::$name(structure) => structure.occluded(primitives, ray, span, probe),)+
                }
            }

            fn closest_batch<P: Primitives, S: Probe>(
                &self,
                primitives: &P,
                rays: &[(Ray, Interval)],
                hits: &mut [Option<Hit>],
                probe: &mut S,
            ) {
                match self {
                    $(Self::$name(structure) => structure.closest_batch(primitives, rays, hits, probe),)+
                }
            }

            fn occluded_batch<P: Primitives, S: Probe>(
                &self,
                primitives: &P,
                rays: &[(Ray, Interval)],
                blocked: &mut [bool],
                probe: &mut S,
            ) {
                match self {
                    $(Self::$name(structure) => structure.occluded_batch(primitives, rays, blocked, probe),)+
                }
            }
        }

        impl AcceleratorQueries for AnyAccelerator {
            fn walk<P: Primitives, Q: RayQuery, S: Probe>(
                &self,
                primitives: &P,
                query: &mut Q,
                probe: &mut S,
            ) -> ControlFlow<()> {
                match self {
                    $(Self::$name(structure) => structure.walk(primitives, query, probe),)+
                }
            }

            fn search<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
                match self {
                    $(Self::$name(structure) => structure.search(query),)+
                }
            }

            fn memory(&self) -> usize {
                match self {
                    $(Self::$name(structure) => structure.memory(),)+
                }
            }

            fn build_stats(&self) -> BuildStats {
                match self {
                    $(Self::$name(structure) => structure.build_stats(),)+
                }
            }

            fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
                match self {
                    $(Self::$name(structure) => structure.validate(primitives),)+
                }
            }

            fn for_each_box(&self, visit: impl FnMut(Aabb, u32)) {
                match self {
                    $(Self::$name(structure) => structure.for_each_box(visit),)+
                }
            }
        }
    };
}

structures! {
    /// Brute force.
    Linear(Linear) = "linear",
    /// Uniform grid.
    Grid(UniformGrid) = "grid",
    /// Binary tree of boxes.
    Bvh(Bvh) = "bvh",
    /// Tree of boxes with eight children to a node.
    Wide(WideBvh) = "wide",
    /// Tree of planes at right angles to the axes.
    Kd(KdTree) = "kd",
    /// Tree of planes of any direction.
    Bsp(BspTree) = "bsp",
    /// Tree of spheres.
    Spheres(SphereTree) = "spheres",
    /// Tree of cylinders.
    Cylinders(CylinderTree) = "cylinders",
    /// Bounding interval hierarchy.
    Bih(Bih) = "bih",
    /// Bounding interval hierarchy, built where rays go.
    BihLazy(LazyBih) = "bih-lazy",
}
