//! Tracing a part of a set of rays, to count or to time.

use cpu_time::ThreadTime;
use rt_accel::{AcceleratorQueries, AcceleratorVisitor, AnyAccelerator};
use rt_geometry::RayStats;
use rt_geometry::{Counters, Hit, NoProbe, Primitives, Probe, RayKind};

use crate::scenes::rays::RaySet;

/// Rays spread evenly over a set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample<'r> {
    pub set: &'r RaySet,
    pub rays: usize,
}

impl Sample<'_> {
    /// The place in the set of each ray of the sample.
    pub(super) fn places(self) -> impl Iterator<Item = usize> {
        (0..self.rays).map(move |index| index * self.set.rays.len() / self.rays)
    }
}

/// Exact answer to a ray: the closest hit, or for shadow rays the presence of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    Miss,
    Blocked,
    Hit { t: u64, instance: u32, primitive: u32 },
}

impl Answer {
    fn closest(hit: Option<Hit>) -> Self {
        hit.map_or(Self::Miss, |hit| Self::Hit { t: hit.t.to_bits(), instance: hit.instance, primitive: hit.primitive })
    }

    fn any(is_blocked: bool) -> Self {
        if is_blocked { Self::Blocked } else { Self::Miss }
    }
}

/// All answers, with what they took.
pub(super) fn count<P: Primitives>(
    structure: &AnyAccelerator,
    primitives: &P,
    sample: Sample<'_>,
) -> (Vec<Answer>, RayStats) {
    let (mut answers, mut counters) = (Vec::with_capacity(sample.rays), Counters::default());
    // The kind is a formality: each sample has counters of its own.
    counters.ray(RayKind::Primary);
    structure.accept(Trace { primitives, sample, probe: &mut counters, answered: |answer| answers.push(answer) });
    (answers, counters.total())
}

/// Seconds for all answers, by the clock of the thread: other processes do not count.
pub(super) fn time<P: Primitives>(structure: &AnyAccelerator, primitives: &P, sample: Sample<'_>) -> f64 {
    let mut hits = 0;
    let answered = |answer| hits += usize::from(answer != Answer::Miss);
    let started = ThreadTime::now();
    structure.accept(Trace { primitives, sample, probe: &mut NoProbe, answered });
    std::hint::black_box(hits);
    started.elapsed().as_secs_f64()
}

struct Trace<'a, P, S, F> {
    primitives: &'a P,
    sample: Sample<'a>,
    probe: &'a mut S,
    answered: F,
}

impl<P: Primitives, S: Probe, F: FnMut(Answer)> AcceleratorVisitor for Trace<'_, P, S, F> {
    type Output = ();

    fn visit<T: AcceleratorQueries>(self, structure: &T) {
        let Self { primitives, sample, probe, mut answered } = self;
        for place in sample.places() {
            let (ray, span) = &sample.set.rays[place];
            answered(if sample.set.any {
                Answer::any(structure.occluded(primitives, ray, *span, probe))
            } else {
                Answer::closest(structure.closest(primitives, ray, *span, probe))
            });
        }
    }
}
