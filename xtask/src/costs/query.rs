//! Tracing a part of a set of rays, to count or to time.

use cpu_time::ThreadTime;
use rt_accel::{Accelerator, AcceleratorVisitor, AnyAccelerator};
use rt_geometry::RayStats;
use rt_geometry::{Counters, Hit, NoProbe, Primitives, Probe, RayKind};

use crate::scenes::rays::RaySet;

/// Rays spread evenly over a set.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaySample<'r> {
    pub set: &'r RaySet,
    pub rays: usize,
}

impl RaySample<'_> {
    /// The place in the set of each ray of the sample.
    pub(super) fn places(self) -> impl Iterator<Item = usize> {
        (0..self.rays).map(move |index| index * self.set.rays.len() / self.rays)
    }
}

/// Every bit of the answer to a ray: the closest hit, or for shadow rays the presence of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RayAnswer {
    Miss,
    Occluded,
    Hit { t: u64, instance: u32, primitive: u32, uv: [u64; 2] },
}

impl From<Option<Hit>> for RayAnswer {
    fn from(hit: Option<Hit>) -> Self {
        hit.map_or(Self::Miss, |Hit { t, instance, primitive, uv }| Self::Hit {
            t: t.to_bits(),
            instance,
            primitive,
            uv: uv.map(f64::to_bits),
        })
    }
}

impl From<bool> for RayAnswer {
    fn from(is_occluded: bool) -> Self {
        if is_occluded { Self::Occluded } else { Self::Miss }
    }
}

/// All answers, with what they took.
pub(super) fn count<P: Primitives>(
    accelerator: &AnyAccelerator,
    primitives: &P,
    sample: RaySample<'_>,
) -> (Vec<RayAnswer>, RayStats) {
    let (mut answers, mut counters) = (Vec::with_capacity(sample.rays), Counters::default());
    // The kind is a formality: each sample has counters of its own.
    counters.ray(RayKind::Primary);
    accelerator.accept(CountedTrace {
        primitives,
        sample,
        probe: &mut counters,
        answered: |answer| answers.push(answer),
    });
    (answers, counters.total())
}

/// Seconds for all answers, by the clock of the thread: other processes do not count.
pub(super) fn time<P: Primitives>(accelerator: &AnyAccelerator, primitives: &P, sample: RaySample<'_>) -> f64 {
    let mut hits = 0;
    let answered = |answer| hits += usize::from(answer != RayAnswer::Miss);
    let started = ThreadTime::now();
    accelerator.accept(CountedTrace { primitives, sample, probe: &mut NoProbe, answered });
    std::hint::black_box(hits);
    started.elapsed().as_secs_f64()
}

struct CountedTrace<'a, P, S, F> {
    primitives: &'a P,
    sample: RaySample<'a>,
    probe: &'a mut S,
    answered: F,
}

impl<P: Primitives, S: Probe, F: FnMut(RayAnswer)> AcceleratorVisitor for CountedTrace<'_, P, S, F> {
    type Output = ();

    fn visit<T: Accelerator>(self, accelerator: &T) {
        let Self { primitives, sample, probe, mut answered } = self;
        for place in sample.places() {
            let (ray, span) = &sample.set.rays[place];
            answered(if sample.set.any {
                accelerator.occluded(primitives, ray, *span, probe).into()
            } else {
                accelerator.closest(primitives, ray, *span, probe).into()
            });
        }
    }
}
