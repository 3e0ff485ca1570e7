//! Rays and hits as structures of arrays, between the stages of an integrator.

use crate::Hit;
use rt_math::{DVec3, Interval, Ray};

/// Capacity of a stream, in rays: the streams of an integrator stay in the cache of a core.
pub const STREAM_CAPACITY: usize = 256;

/// Eight numbers more than [`STREAM_CAPACITY`], so that kernels may load and store whole vectors.
const STREAM_SIZE: usize = STREAM_CAPACITY + 8;

/// One number of each ray of a stream.
///
/// Its size is known to the compiler, so that accesses with an index that is taken modulo [`STREAM_CAPACITY`] are not checked.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamArray<T>(Box<[T; STREAM_SIZE]>);

impl<T: Copy + Default> Default for StreamArray<T> {
    fn default() -> Self {
        Self(Box::new([T::default(); STREAM_SIZE]))
    }
}

impl<T> StreamArray<T> {
    /// Eight numbers from the index `at` on, which is taken modulo [`STREAM_CAPACITY`].
    #[inline(always)]
    pub fn vector(&self, at: usize) -> &[T; 8] {
        let at = at % STREAM_CAPACITY;
        // The compiler removes the branch.
        match self.0[at..at + 8].first_chunk() {
            Some(vector) => vector,
            None => unreachable!("eight numbers"),
        }
    }

    /// Mutable version of [`vector`](Self::vector).
    #[inline(always)]
    pub fn vector_mut(&mut self, at: usize) -> &mut [T; 8] {
        let at = at % STREAM_CAPACITY;
        match self.0[at..at + 8].first_chunk_mut() {
            Some(vector) => vector,
            None => unreachable!("eight numbers"),
        }
    }

    /// The number at an index, modulo [`STREAM_CAPACITY`].
    #[inline(always)]
    pub fn get(&self, at: usize) -> T
    where
        T: Copy,
    {
        self.0[at % STREAM_CAPACITY]
    }

    /// Sets the number at an index, modulo [`STREAM_CAPACITY`].
    #[inline(always)]
    pub fn set(&mut self, at: usize, number: T) {
        self.0[at % STREAM_CAPACITY] = number;
    }

    /// All numbers that a stream may use.
    #[inline(always)]
    pub fn as_slice(&self) -> &[T] {
        &self.0[..STREAM_CAPACITY]
    }

    /// Mutable version of [`as_slice`](Self::as_slice).
    #[inline(always)]
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.0[..STREAM_CAPACITY]
    }
}

/// Up to [`STREAM_CAPACITY`] rays, one array for each number.
///
/// The numbers behind the last ray have no meaning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RayStream {
    /// Coordinates of the origins.
    pub origin: [StreamArray<f64>; 3],
    /// Coordinates of the directions.
    pub direction: [StreamArray<f64>; 3],
    /// Minimum ray parameters of hits.
    pub min: StreamArray<f64>,
    /// Maximum ray parameters of hits.
    pub max: StreamArray<f64>,
    /// Times in the shutter interval, as [`Ray::time`].
    pub time: StreamArray<f64>,
    len: usize,
}

impl RayStream {
    /// Number of rays.
    #[inline(always)]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// True without any ray.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// True if a ray is at another time than 0.
    pub fn has_time(&self) -> bool {
        self.time.as_slice()[..self.len].iter().any(|time| *time != 0.0)
    }

    /// Removes all rays.
    pub const fn clear(&mut self) {
        self.len = 0;
    }

    /// Counts `count` rays that have been written behind the last one, up to the capacity.
    #[inline(always)]
    pub fn grow(&mut self, count: usize) {
        self.len = self.len.saturating_add(count).min(STREAM_CAPACITY);
    }

    /// Appends a ray. Nothing happens if the stream is full.
    #[inline(always)]
    pub fn push(&mut self, ray: &Ray, span: Interval) {
        let at = self.len;
        if at == STREAM_CAPACITY {
            return;
        }
        let Ray { origin, direction, time } = *ray;
        let ([x, y, z], [u, v, w]) = (&mut self.origin, &mut self.direction);
        x.set(at, origin.x);
        y.set(at, origin.y);
        z.set(at, origin.z);
        u.set(at, direction.x);
        v.set(at, direction.y);
        w.set(at, direction.z);
        self.min.set(at, span.min);
        self.max.set(at, span.max);
        self.time.set(at, time);
        self.grow(1);
    }

    /// Replaces the rays by those of another stream with these indices, which are less than its length. Those beyond the capacity
    /// are ignored.
    pub fn set_gathered(&mut self, from: &Self, indices: &[u8]) {
        let indices = &indices[..indices.len().min(STREAM_CAPACITY)];
        let gather = |to: &mut StreamArray<f64>, from: &StreamArray<f64>| {
            for (number, &index) in to.as_mut_slice().iter_mut().zip(indices) {
                *number = from.get(index.into());
            }
        };
        for axis in 0..3 {
            gather(&mut self.origin[axis], &from.origin[axis]);
            gather(&mut self.direction[axis], &from.direction[axis]);
        }
        gather(&mut self.min, &from.min);
        gather(&mut self.max, &from.max);
        gather(&mut self.time, &from.time);
        self.len = indices.len();
    }

    /// Replaces the rays by the images of those of another stream, within the same spans.
    #[inline]
    pub fn set_mapped(&mut self, from: &Self, map: impl Fn(&Ray) -> Ray) {
        self.clear();
        for at in 0..from.len {
            let (ray, span) = from.get(at);
            self.push(&map(&ray), span);
        }
    }

    /// The ray of this index.
    #[inline(always)]
    pub fn get(&self, at: usize) -> (Ray, Interval) {
        let vector = |[x, y, z]: &[StreamArray<f64>; 3]| DVec3::new(x.get(at), y.get(at), z.get(at));
        let span = Interval { min: self.min.get(at), max: self.max.get(at) };
        (Ray { origin: vector(&self.origin), direction: vector(&self.direction), time: self.time.get(at) }, span)
    }
}

/// Closest hits of a [`RayStream`], one array for each number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitStream {
    /// Parameters of the hits.
    pub t: StreamArray<f64>,
    /// See [`Hit::instance`].
    pub instance: StreamArray<u32>,
    /// See [`Hit::primitive`]; [`NONE`](Self::NONE) for a miss.
    pub primitive: StreamArray<u32>,
    /// See [`Hit::uv`].
    pub uv: [StreamArray<f64>; 2],
}

impl HitStream {
    /// Index of the primitive of a miss.
    pub const NONE: u32 = u32::MAX;

    /// Sets the hit of a ray.
    #[inline(always)]
    pub fn set(&mut self, at: usize, hit: Option<&Hit>) {
        let Some(hit) = hit else { return self.primitive.set(at, Self::NONE) };
        self.t.set(at, hit.t);
        self.instance.set(at, hit.instance);
        self.primitive.set(at, hit.primitive);
        let [u, v] = &mut self.uv;
        u.set(at, hit.uv[0]);
        v.set(at, hit.uv[1]);
    }

    /// The hit of a ray; `None` for a miss.
    #[inline(always)]
    pub fn get(&self, at: usize) -> Option<Hit> {
        let (primitive, [u, v]) = (self.primitive.get(at), &self.uv);
        let hit = || Hit { t: self.t.get(at), instance: self.instance.get(at), primitive, uv: [u.get(at), v.get(at)] };
        (primitive != Self::NONE).then(hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_and_hits_keep_their_numbers() {
        let (mut rays, mut hits) = (RayStream::default(), HitStream::default());
        let ray = |at: usize| Ray {
            time: at as f64 * 0.1,
            ..Ray::new(DVec3::new(at as f64, 0.5, -1.0), DVec3::new(1.0, -(at as f64), 2.0))
        };
        let hit = |at: usize| Hit { t: at as f64, instance: 7, primitive: at as u32, uv: [0.5, at as f64] };
        let span = |at: usize| Interval::new(0.25, at as f64);
        for at in 0..STREAM_CAPACITY {
            rays.push(&ray(at), span(at));
            hits.set(at, Some(&hit(at)).filter(|_| at % 3 > 0));
        }
        assert_eq!(rays.len(), STREAM_CAPACITY);
        for at in 0..STREAM_CAPACITY {
            assert_eq!(rays.get(at), (ray(at), span(at)));
            assert_eq!(hits.get(at), (at % 3 > 0).then(|| hit(at)));
        }
        rays.grow(300);
        assert_eq!(rays.len(), STREAM_CAPACITY, "counted up to the capacity");
        rays.clear();
        assert!(rays.is_empty());
    }

    #[test]
    fn rays_are_gathered_and_mapped_with_their_spans_and_times() {
        let mut rays = RayStream::default();
        for at in 0..STREAM_CAPACITY {
            let number = at as f64;
            let ray = Ray::new(DVec3::new(number, 1.0, 2.0), DVec3::new(3.0, -number, 5.0));
            rays.push(&Ray { time: number / 256.0, ..ray }, Interval::new(number, 2.0 * number));
        }
        let indices: Vec<u8> = (0..=255).rev().step_by(3).collect();
        let mut some = rays.clone();
        some.set_gathered(&rays, &indices);
        assert_eq!(some.len(), indices.len());
        assert!(indices.iter().enumerate().all(|(at, &index)| some.get(at) == rays.get(index.into())));
        some.set_gathered(&rays, &[7; 300]);
        assert_eq!((some.len(), some.get(STREAM_CAPACITY - 1)), (STREAM_CAPACITY, rays.get(7)));

        let twice = |ray: &Ray| Ray { origin: ray.origin * 2.0, ..*ray };
        some.set_mapped(&rays, twice);
        assert_eq!(some.len(), STREAM_CAPACITY);
        assert!((0..STREAM_CAPACITY).all(|at| some.get(at) == (twice(&rays.get(at).0), rays.get(at).1)));
        some.set_mapped(&RayStream::default(), twice);
        assert!(some.is_empty());
    }

    #[test]
    fn vectors_reach_beyond_the_last_ray_and_indices_wrap() {
        let mut numbers = StreamArray::<u32>::default();
        for (at, number) in numbers.as_mut_slice().iter_mut().enumerate() {
            *number = at as u32;
        }
        assert_eq!(numbers.vector(STREAM_CAPACITY - 3)[..3], [253, 254, 255]);
        *numbers.vector_mut(STREAM_CAPACITY - 3) = [7; 8];
        assert_eq!(numbers.as_slice()[STREAM_CAPACITY - 4..], [252, 7, 7, 7]);
        assert_eq!((numbers.get(STREAM_CAPACITY + 1), numbers.get(0)), (1, 0));
    }
}
