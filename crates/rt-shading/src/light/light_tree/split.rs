//! Splits of the nodes of a light tree.

use super::LightBounds;
use rt_math::Aabb;

/// Buckets along an axis.
const BUCKETS: usize = 12;

/// Partitions at least two lights and returns the length of the first part. The split minimises the sum of power · M_A · M_Ω
/// (the surface area orientation heuristic, section 4.2 of the paper). Lights whose centres coincide are halved in their
/// order.
pub(super) fn split(node: &LightBounds, lights: &mut [(LightBounds, u32)]) -> usize {
    let centres = Aabb::from_points(lights.iter().map(|(bounds, _)| bounds.around().centre()));
    let longest = node.around().extent().max_element();
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        if !(centres.extent()[axis] > 0.0) {
            continue;
        }
        let regular = longest / node.around().extent()[axis];
        for (cost, bucket) in costs(&centres, axis, lights) {
            if best.is_none_or(|(min, ..)| regular * cost < min) {
                best = Some((regular * cost, axis, bucket));
            }
        }
    }
    let Some((_, axis, last)) = best else { return lights.len() / 2 };
    let is_first = |light: &(LightBounds, u32)| bucket_of(&centres, axis, &light.0) <= last;
    let (first, second): (Vec<_>, Vec<_>) = lights.iter().partition(|light| is_first(light));
    let n_first = first.len();
    lights.copy_from_slice(&[first, second].concat());
    n_first
}

/// Costs of splits behind a bucket, for those with lights on both sides.
fn costs(centres: &Aabb, axis: usize, lights: &[(LightBounds, u32)]) -> Vec<(f64, usize)> {
    let mut buckets = [None::<LightBounds>; BUCKETS];
    for (bounds, _) in lights {
        let bucket = &mut buckets[bucket_of(centres, axis, bounds)];
        *bucket = Some(bucket.map_or(*bounds, |sum| sum.union(bounds)));
    }
    let cost = |side: &[Option<LightBounds>]| {
        let sum = side.iter().flatten().copied().reduce(|a, b| a.union(&b))?;
        Some(sum.power() * sum.directions() * sum.around().surface_area())
    };
    let split = |last: usize| Some((cost(&buckets[..=last])? + cost(&buckets[last + 1..])?, last));
    (0..BUCKETS - 1).filter_map(split).collect()
}

fn bucket_of(centres: &Aabb, axis: usize, bounds: &LightBounds) -> usize {
    let along = (bounds.around().centre()[axis] - centres.min[axis]) / centres.extent()[axis];
    ((along * BUCKETS as f64) as usize).min(BUCKETS - 1)
}

#[cfg(test)]
mod tests {
    use super::super::union;
    use super::*;
    use rt_math::{DVec3, Rgb};

    /// Area light that faces along an axis.
    fn light(x: f64, axis: DVec3) -> LightBounds {
        let corner = DVec3::new(x, 0.0, 0.0);
        LightBounds::new(Aabb::new(corner, corner + 0.1), axis, 0.0, Rgb::WHITE)
    }

    fn halves(lights: &mut [(LightBounds, u32)]) -> [Vec<u32>; 2] {
        let node = union(lights).expect("bounds");
        let middle = split(&node, lights);
        let (first, second) = lights.split_at(middle);
        [first, second].map(|half| half.iter().map(|light| light.1).collect())
    }

    #[test]
    fn far_groups_are_kept_apart() {
        let mut lights: Vec<_> =
            [0.0, 100.0, 1.0, 101.0, 2.0].map(|x| light(x, DVec3::Z)).into_iter().zip(0..).collect();
        assert_eq!(halves(&mut lights), [vec![0, 2, 4], vec![1, 3]]);
    }

    #[test]
    fn lights_that_face_apart_are_kept_apart() {
        let facing = [(0.0, DVec3::Z), (1.0, DVec3::Z), (2.0, DVec3::NEG_Z), (3.0, DVec3::NEG_Z), (4.0, DVec3::NEG_Z)];
        let mut lights: Vec<_> = facing.map(|(x, axis)| light(x, axis)).into_iter().zip(0..).collect();
        assert_eq!(halves(&mut lights), [vec![0, 1], vec![2, 3, 4]]);
    }

    #[test]
    fn lights_in_one_place_are_halved() {
        let mut lights: Vec<_> = (0..5).map(|i| (light(1.0, DVec3::X), i)).collect();
        assert_eq!(halves(&mut lights), [vec![0, 1], vec![2, 3, 4]]);
    }
}
