use super::*;
use crate::strategies::vector;
use proptest::prelude::*;
use rt_math::random;
use rt_math::transcendental::sincos;
use std::f64::consts::TAU;

const CLOSED: bool = true;
const OPEN: bool = false;

fn cylinder(caps: bool) -> CappedQuadric {
    CappedQuadric::cylinder(1.0, -1.0, 2.0, caps).expect("a cylinder")
}

fn cone(caps: bool) -> CappedQuadric {
    CappedQuadric::cone(1.0, 2.0, caps).expect("a cone")
}

fn frustum(caps: bool) -> CappedQuadric {
    CappedQuadric::frustum(2.0, 1.0, 1.0, caps).expect("a frustum")
}

fn hit(quadric: CappedQuadric, origin: [f64; 3], direction: [f64; 3], span: Interval) -> Option<(f64, DVec3)> {
    let ray = Ray::new(origin.into(), direction.into());
    let hit = quadric.intersect(&ray, span)?;
    Some((hit.t, quadric.surface(&ray, &hit, InteractionFlags::ALL).geometric_normal))
}

fn first(quadric: CappedQuadric, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec3)> {
    hit(quadric, origin, direction, Interval::FORWARD)
}

#[test]
fn radii_belong_to_their_ends() {
    for radii in [[1.0, 0.25], [0.25, 1.0], [1.0, 1.0 + 1e-9], [1.0 + 1e-9, 1.0], [0.1, 100.0], [1.0, 1.0]] {
        assert_eq!(CappedQuadric::frustum(radii[0], radii[1], 3.0, true).expect("a frustum").radii(), radii);
    }
    assert_eq!(CappedQuadric::cone(0.7, 2.0, true).expect("a cone").radii(), [0.7, 0.0]);
    assert_eq!(CappedQuadric::cylinder(0.7, 1.0, 2.0, true).expect("a cylinder").radii(), [0.7; 2]);
}

#[test]
fn side_and_caps_of_a_cylinder_are_hit_from_outside_and_inside() {
    let solid = cylinder(CLOSED);
    assert_eq!(first(solid, [-3.0, 0.5, 0.0], [1.0, 0.0, 0.0]), Some((2.0, DVec3::NEG_X)));
    assert_eq!(first(solid, [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]), Some((0.5, DVec3::X)), "from inside");
    assert_eq!(first(solid, [0.5, 5.0, 0.5], [0.0, -1.0, 0.0]), Some((3.0, DVec3::Y)));
    assert_eq!(first(solid, [0.5, 0.0, 0.5], [0.0, -1.0, 0.0]), Some((1.0, DVec3::NEG_Y)), "from inside");
    assert_eq!(first(solid, [-3.0, 2.5, 0.0], [1.0, 0.0, 0.0]), None, "above");
    assert_eq!(first(solid, [-3.0, 2.0, 0.0], [1.0, 0.0, 0.0]), Some((2.0, DVec3::NEG_X)), "in the plane of a cap");
    // In through the top, out through the side.
    let slanted = |span| hit(solid, [-2.0, 4.0, 0.0], [1.0, -1.0, 0.0], span).map(|(t, _)| t);
    assert_eq!(slanted(Interval::FORWARD), Some(2.0));
    assert_eq!(slanted(Interval::new(2.5, 3.0)), Some(3.0));
    assert_eq!(slanted(Interval::new(2.5, 2.9)), None);
}

#[test]
fn an_open_tube_is_looked_through() {
    let [solid, open] = [CLOSED, OPEN].map(cylinder);
    assert_eq!(first(open, [0.5, 5.0, 0.5], [0.0, -1.0, 0.0]), None, "through the cylinder");
    // Over the near rim to the far wall.
    assert_eq!(first(open, [-3.0, 4.5, 0.0], [1.0, -1.0, 0.0]), Some((4.0, DVec3::X)));
    assert_eq!(first(solid, [-3.0, 4.5, 0.0], [1.0, -1.0, 0.0]), Some((2.5, DVec3::Y)));
    assert_eq!(first(open, [-3.0, 4.0, 0.0], [1.0, -1.0, 0.0]), Some((2.0, DVec3::NEG_X)), "the rim is closed");
    assert_eq!(first(solid, [-3.0, 4.0, 0.0], [1.0, -1.0, 0.0]), Some((2.0, DVec3::NEG_X)), "the rim: side first");
    assert_eq!(first(open, [-3.0, 1.0, 0.0], [1.0, 0.0, 0.0]), Some((2.0, DVec3::NEG_X)));
}

#[test]
fn rays_along_the_axis_of_a_cylinder_meet_the_caps_up_to_the_rim() {
    let [solid, open] = [CLOSED, OPEN].map(cylinder);
    for x in [0.5, 1.0] {
        assert_eq!(first(solid, [x, 5.0, 0.0], [0.0, -1.0, 0.0]), Some((3.0, DVec3::Y)));
        assert_eq!(first(open, [x, 5.0, 0.0], [0.0, -1.0, 0.0]), None);
    }
    assert_eq!(first(solid, [1.0f64.next_up(), 5.0, 0.0], [0.0, -1.0, 0.0]), None);
}

#[test]
fn tangents_count_up_to_the_last_number() {
    for x in [1.0f64.next_down(), 1.0] {
        assert!(first(cylinder(CLOSED), [x, 0.0, -5.0], [0.0, 0.0, 1.0]).is_some_and(|(t, _)| (t - 5.0).abs() < 1e-7));
    }
    assert_eq!(first(cylinder(CLOSED), [1.0f64.next_up(), 0.0, -5.0], [0.0, 0.0, 1.0]), None);
}

#[test]
fn texture_coordinates_run_around_the_side_and_over_the_caps() {
    let uv = |origin: [f64; 3], direction: [f64; 3]| {
        let ray = Ray::new(origin.into(), direction.into());
        let hit = cylinder(CLOSED).intersect(&ray, Interval::FORWARD).expect("a hit");
        cylinder(CLOSED).surface(&ray, &hit, InteractionFlags::ALL).uv
    };
    assert_eq!(uv([0.0, 0.5, 3.0], [0.0, 0.0, -1.0]), [0.5, 0.5]);
    assert_eq!(uv([3.0, 1.25, 0.0], [-1.0, 0.0, 0.0]), [0.75, 0.75]);
    assert_eq!(uv([0.5, 5.0, -0.5], [0.0, -1.0, 0.0]), [0.75, 0.75]);
    assert_eq!(uv([0.5, -5.0, -0.5], [0.0, 1.0, 0.0]), [0.75, 0.25]);
}

#[test]
fn the_side_of_a_cone_slopes_to_the_apex_and_the_base_faces_down() {
    let [solid, open] = [CLOSED, OPEN].map(cone);
    let (t, normal) = first(solid, [-3.0, 1.0, 0.0], [1.0, 0.0, 0.0]).expect("half way up");
    assert_eq!(t, 2.5);
    assert!((normal - DVec3::new(-2.0, 1.0, 0.0).normalize()).length() < 1e-15);
    assert_eq!(first(solid, [0.5, -3.0, 0.0], [0.0, 1.0, 0.0]), Some((3.0, DVec3::NEG_Y)));
    assert_eq!(first(open, [0.5, -3.0, 0.0], [0.0, 1.0, 0.0]).map(|(t, _)| t), Some(4.0), "from inside");
    assert_eq!(first(solid, [-3.0, 3.0, 0.0], [1.0, 0.0, 0.0]), None, "the other nappe is not there");
    assert_eq!(first(solid, [-3.0, -0.5, 0.0], [1.0, 0.0, 0.0]), None, "nor what is below the base");
    assert_eq!(first(solid, [0.25, 5.0, 0.0], [0.0, -1.0, 0.0]).map(|(t, _)| t), Some(3.5), "past the other nappe");
}

#[test]
fn the_apex_faces_whoever_looks_at_it() {
    for caps in [CLOSED, OPEN] {
        assert_eq!(first(cone(caps), [0.0, 5.0, 0.0], [0.0, -1.0, 0.0]), Some((3.0, DVec3::Y)));
    }
    assert_eq!(first(cone(CLOSED), [0.0, 1.0, 0.0], [0.0, 2.0, 0.0]), Some((0.5, DVec3::NEG_Y)), "from inside");
}

#[test]
fn rays_along_a_generator_cross_once() {
    let parallel = [-0.5, 1.0, 0.0];
    assert_eq!(first(cone(CLOSED), [2.0, -1.0, 0.0], parallel), None, "outside");
    assert_eq!(first(cone(CLOSED), [1.0, -1.0, 0.0], parallel), Some((1.0, DVec3::NEG_Y)), "in at the base");
    assert_eq!(first(cone(OPEN), [1.0, -1.0, 0.0], parallel).map(|(t, _)| t), Some(2.5), "out at the side");
}

#[test]
fn known_values_of_a_frustum() {
    let [solid, open] = [CLOSED, OPEN].map(frustum);
    let (t, normal) = first(solid, [-5.0, 0.5, 0.0], [1.0, 0.0, 0.0]).expect("the side");
    assert_eq!(t, 3.5);
    assert!((normal - DVec3::new(-1.0, 1.0, 0.0).normalize()).length() < 1e-15);
    assert_eq!(first(solid, [0.5, 3.0, 0.0], [0.0, -1.0, 0.0]), Some((2.0, DVec3::Y)));
    assert_eq!(first(solid, [1.5, -3.0, 0.0], [0.0, 1.0, 0.0]), Some((3.0, DVec3::NEG_Y)));
    assert_eq!(first(open, [0.5, 3.0, 0.0], [0.0, -1.0, 0.0]), None, "through the open frustum");
    assert_eq!(first(solid, [1.5, 3.0, 0.0], [0.0, -1.0, 0.0]).map(|(t, _)| t), Some(2.5), "beside the top");
    let funnel = CappedQuadric::frustum(1.0, 2.0, 1.0, CLOSED).expect("a frustum");
    assert_eq!(first(funnel, [1.5, -3.0, 0.0], [0.0, 1.0, 0.0]).map(|(t, _)| t), Some(3.5), "under the brim");
}

/// Rays through the rim into the solid, and rays from inside to the rim. Rounding must not let them pass between
/// the side and a cap.
#[test]
fn no_ray_slips_through_the_rim() {
    let solid = CappedQuadric::cylinder(0.7, -0.3, 1.1, CLOSED).expect("a cylinder");
    let (mut leaks, mut surplus) = (0, 0);
    for ray in 0..1_000_000u64 {
        let draw = |k: u64| random::unit(random::hash(&[ray, k]));
        let (sin, cos) = sincos(TAU * draw(0));
        let y = if draw(1) < 0.5 { -0.3 } else { 1.1 };
        let rim = DVec3::new(0.7 * sin, y, 0.7 * cos);
        let (sin, cos) = sincos(TAU * draw(2));
        let inside = DVec3::new(0.69 * draw(3) * sin, 1.38 * draw(4) - 0.29, 0.69 * draw(3) * cos);
        let back = 1e4 * draw(5) * draw(5) * draw(5);
        let arriving = Ray::new(rim + (rim - inside) * back, inside - rim);
        let leaving = Ray::new(inside, rim - inside);
        let hits = |ray: &Ray, min: f64| solid.intersect(ray, Interval::new(min, f64::INFINITY)).map(|hit| hit.t);
        leaks += usize::from(hits(&arriving, 0.0).is_none()) + usize::from(hits(&leaving, 0.0).is_none());
        let out = hits(&leaving, 0.0).unwrap_or(0.0);
        surplus += usize::from(hits(&leaving, out.next_up()).is_some());
    }
    assert_eq!((leaks, surplus), (0, 0));
}

/// A cylinder, cone or frustum with the radii of its ends.
fn quadric() -> impl Strategy<Value = (CappedQuadric, [f64; 2])> {
    let cylinder =
        (0.1..5.0f64, -5.0..5.0f64, 0.1..5.0f64, any::<bool>()).prop_map(|(radius, bottom, height, caps)| {
            (CappedQuadric::cylinder(radius, bottom, bottom + height, caps), [radius; 2])
        });
    let cone = (0.01..50.0f64, 0.01..50.0f64, any::<bool>())
        .prop_map(|(radius, height, caps)| (CappedQuadric::cone(radius, height, caps), [radius, 0.0]));
    let frustum = (0.01..5.0f64, 0.01..5.0f64, 0.01..5.0f64, any::<bool>())
        .prop_map(|(bottom, top, height, caps)| (CappedQuadric::frustum(bottom, top, height, caps), [bottom, top]));
    prop_oneof![cylinder, cone, frustum].prop_map(|(quadric, radii)| (quadric.expect("good numbers"), radii))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3 * ProptestConfig::default().cases))]
    #[test]
    fn hits_lie_on_the_surface((quadric, radii) in quadric(), from in vector(100.0), to in vector(3.0)) {
        let ray = Ray::new(from, to - from);
        if let Some(hit) = quadric.intersect(&ray, Interval::FORWARD) {
            let surface = quadric.surface(&ray, &hit, InteractionFlags::ALL);
            let (p, normal) = (surface.point, surface.geometric_normal);
            let ([bottom, top], [low, high]) = (quadric.heights(), radii);
            let height = top - bottom;
            // Without cancellation near an apex.
            let radius = if low == high { low } else { (low * (top - p.y) + high * (p.y - bottom)) / height };
            let from_axis = DVec3::new(p.x, 0.0, p.z).length();
            let gap = match normal {
                DVec3::Y => p.y - top,
                DVec3::NEG_Y => p.y - bottom,
                _ => (from_axis - radius) * height / DVec3::new(height, high - low, 0.0).length(),
            };
            prop_assert!(gap.abs() <= normal.abs().dot(surface.point_error), "{gap}");
            prop_assert!(from_axis <= low.max(high) * (1.0 + 1e-15) && (bottom..=top).contains(&p.y));
            prop_assert!((p - ray.at(hit.t)).length() < 1e-11);
            prop_assert!((normal.length() - 1.0).abs() < 1e-15);
            prop_assert!(normal.y.abs() == 1.0 || normal.dot(p - DVec3::Y * p.y) > 0.0);
            prop_assert!(surface.uv.iter().all(|x| (0.0..=1.0).contains(x)), "{:?}", surface.uv);
            prop_assert!(quadric.bounds().contains(p));
        }
    }
}

proptest! {
    /// An open cylinder differs from a solid only where the caps hide its inside.
    #[test]
    fn caps_only_add_hits(from in vector(4.0), to in vector(2.0)) {
        let ray = Ray::new(from, to - from);
        let [solid, open] = [CLOSED, OPEN].map(|caps| cylinder(caps).intersect(&ray, Interval::FORWARD).map(|hit| hit.t));
        prop_assert!(open.is_none_or(|open| solid.is_some_and(|solid| solid <= open)), "{solid:?} {open:?}");
    }

    /// A ray towards a point inside enters the solid and leaves it again.
    #[test]
    fn a_solid_is_entered_and_left(from in vector(20.0), x in -0.4..0.4f64, y in 0.01..1.0f64, z in -0.2..0.2f64) {
        let ray = Ray::new(from, DVec3::new(x, y, z) - from);
        let within = |min, max| cone(CLOSED).intersect(&ray, Interval::new(min, max)).map(|hit| hit.t);
        let enter = within(f64::NEG_INFINITY, f64::INFINITY).expect("towards a point inside");
        let leave = within(1.0, f64::INFINITY).expect("from a point inside");
        prop_assert!(enter < 1.0 && leave > 1.0);
        prop_assert_eq!(within(leave.next_up(), f64::INFINITY), None);
    }

    /// With equal radii a frustum is a cylinder, with a tiny tip a cone.
    #[test]
    fn limits_of_a_frustum_are_cylinders_and_cones(from in vector(5.0), to in vector(1.0), caps in any::<bool>()) {
        let ray = Ray::new(from, to - from);
        let t = |quadric: Result<CappedQuadric, ShapeError>| {
            quadric.expect("good numbers").intersect(&ray, Interval::FORWARD).map(|hit| hit.t)
        };
        let straight = CappedQuadric::frustum(1.0, 1.0, 2.0, caps);
        prop_assert_eq!(t(straight), t(CappedQuadric::cylinder(1.0, 0.0, 2.0, caps)));
        let pointed = CappedQuadric::frustum(1.0, 1e-30, 2.0, caps);
        prop_assert_eq!(t(pointed), t(CappedQuadric::cone(1.0, 2.0, caps)));
    }
}
