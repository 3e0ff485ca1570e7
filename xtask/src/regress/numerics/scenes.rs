//! Structures and rays that several chapters need.

use std::error::Error;

use rt_accel::{Accelerator, AcceleratorKind, AcceleratorQueries, AnyAccelerator};
use rt_geometry::{Counters, Hit, NoProbe, Primitives};
use rt_math::{Interval, Ray};

/// A structure under its name.
#[derive(Debug)]
pub(super) struct Named {
    kind: AcceleratorKind,
    pub structure: AnyAccelerator,
}

impl Named {
    pub(super) const fn new(kind: AcceleratorKind, structure: AnyAccelerator) -> Self {
        Self { kind, structure }
    }

    pub(super) fn name(&self) -> &'static str {
        self.kind.name()
    }

    pub(super) fn closest<P: Primitives>(&self, primitives: &P, ray: &Ray, span: Interval) -> Option<Hit> {
        self.structure.closest(primitives, ray, span, &mut NoProbe)
    }

    /// Nodes and primitives looked at, per ray.
    pub(super) fn visits<P: Primitives>(&self, primitives: &P, rays: &[Ray]) -> f64 {
        let mut counters = Counters::default();
        for ray in rays {
            self.structure.closest(primitives, ray, Interval::FORWARD, &mut counters);
        }
        let total = counters.total();
        (total.nodes + total.tests) as f64 / rays.len() as f64
    }
}

/// One structure of each kind, brute force first, each found to be as it should.
pub(super) fn all_structures<P: Primitives>(primitives: &P) -> Result<Vec<Named>, Box<dyn Error + Send + Sync>> {
    let build = |&kind: &AcceleratorKind| {
        let structure = AnyAccelerator::build(kind, primitives)?;
        structure.validate(primitives).map_err(|violation| format!("{}: {violation}", kind.name()))?;
        Ok(Named { kind, structure })
    };
    AcceleratorKind::ALL.iter().map(build).collect()
}

/// All that must be equal to the last bit.
pub(super) fn key(hit: Option<Hit>) -> Option<[u64; 5]> {
    hit.map(|Hit { t, instance, primitive, uv }| {
        [t.to_bits(), instance.into(), primitive.into(), uv[0].to_bits(), uv[1].to_bits()]
    })
}
