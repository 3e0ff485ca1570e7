//! Primitives to build accelerators over: simple kernels, one of them deliberately bad.
//!
//! The equality of accelerators must hold for any kernel that keeps the contract of `Primitives`, so accuracy does not
//! matter here.

pub(crate) mod accelerators;
pub(crate) mod rays;

use rt_accel::{Aabb, ClosestPoint, DVec3, Hit, Interval, PrimitiveGeometry, Primitives, Ray, SphereKernel};
use rt_geometry::{PacketKernel, Plane, WatertightRay};
use rt_math::{SlabRay, Vec3};

use rt_tests::Draw;

/// The seed of this run: the one given in the environment variable `RT_SEED`, or a fixed one.
pub(crate) fn run_seed() -> u64 {
    std::env::var("RT_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(20_240_229)
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Solid {
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    /// A sphere about which accelerators may decide.
    Round(SphereKernel),
    Box(Aabb),
    Triangle([DVec3; 3]),
    /// A triangle of a mesh, hit by the watertight test.
    Facet([Vec3; 3]),
    /// Hit somewhere around the box, by a hash of the ray: no kernel could be worse.
    Sloppy(Aabb),
    /// The unbounded plane `y = height`.
    Ground {
        height: f64,
    },
    /// Claims these bounds and is never hit.
    Ghost(Aabb),
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Soup(pub(crate) Vec<Solid>);

impl Soup {
    pub(crate) fn spheres(count: u64, draw: &mut Draw) -> Self {
        let spacing = 1.0 / rt_math::transcendental::cbrt(count as f64);
        Self(
            (0..count)
                .map(|_| Solid::Sphere { centre: draw.point(), radius: spacing * draw.between(0.1, 0.4) })
                .collect(),
        )
    }

    /// Spheres on a floor of two triangles, with some of everything in between.
    pub(crate) fn marbles(draw: &mut Draw) -> Self {
        let mut solids = Self::spheres(300, draw).0;
        solids.extend(sheet(1, |x, z| DVec3::new(x, -0.9, z)));
        for _ in 0..25 {
            let corner = draw.point();
            solids.push(Solid::Box(Aabb::new(corner, corner + draw.point().abs() * 0.3)));
            let corner = draw.point();
            solids.push(Solid::Sloppy(Aabb::new(corner, corner + draw.point().abs() * 0.2)));
            let corner = draw.point();
            solids.push(Solid::Ghost(Aabb::new(corner, corner + draw.point().abs() * 0.1)));
        }
        solids.extend_from_within(280..320);
        Self(solids)
    }

    /// Long thin triangles, each nearly along one of the axes.
    pub(crate) fn sticks(count: u64, draw: &mut Draw) -> Self {
        let stick = |_| {
            let along = DVec3::AXES[draw.below(3)];
            let from = draw.point() * (1.0 - along) - along;
            let to = from + along * 2.0 + draw.point() * 0.02;
            Solid::Triangle([from, to, to + draw.point() * 0.02])
        };
        Self((0..count).map(stick).collect())
    }

    /// Small solids of all bounded kinds and a bumpy sheet of triangles with shared vertices, all within one unit of
    /// the origin.
    pub(crate) fn mixed(draw: &mut Draw) -> Self {
        let mut solids = Vec::new();
        for _ in 0..40 {
            let (centre, radius) = (draw.point(), draw.between(0.01, 0.2));
            solids.push(Solid::Sphere { centre, radius });
            let corner = draw.point();
            let aabb = Aabb::new(corner, corner + draw.point().abs() * 0.3);
            solids.push(Solid::Box(aabb));
            let corner = draw.point();
            solids.push(Solid::Sloppy(Aabb::new(corner, corner + draw.point().abs() * 0.2)));
            let corner = draw.point();
            solids.push(Solid::Triangle([corner, corner + draw.point() * 0.3, corner + draw.point() * 0.3]));
        }
        solids.extend(sheet(8, |x, z| DVec3::new(x, (x * z).abs() - 0.5, z)));
        // Exact duplicates: the lower index has to win.
        solids.extend_from_within(0..20);
        Self(solids)
    }

    /// A sphere of triangles that share vertices, and small ones around it.
    pub(crate) fn triangles(draw: &mut Draw) -> Self {
        let bumps = |x: f64, z: f64| DVec3::new(x, (x * z).abs() - 0.5, z);
        let mut solids: Vec<_> = sheet(12, bumps).collect();
        solids.extend(Self::sticks(40, draw).0);
        for _ in 0..100 {
            let corner = draw.point();
            solids.push(Solid::Triangle([corner, corner + draw.point() * 0.2, corner + draw.point() * 0.2]));
        }
        solids.extend_from_within(0..20);
        Self(solids)
    }

    /// Triangles as of a mesh.
    pub(crate) fn facets(draw: &mut Draw) -> Self {
        let facet = |solid| match solid {
            Solid::Triangle(vertices) => Solid::Facet(vertices.map(|vertex| vertex.as_vec3())),
            other => other,
        };
        Self(Self::triangles(draw).0.into_iter().map(facet).collect())
    }

    /// The same, where accelerators may decide about spheres.
    pub(crate) fn rounded(self) -> Self {
        let round = |solid| match solid {
            Solid::Sphere { centre, radius } => Solid::Round(SphereKernel { centre, radius }),
            other => other,
        };
        Self(self.0.into_iter().map(round).collect())
    }

    /// These solids on a square of two large triangles, of which accelerators have copies.
    pub(crate) fn with_floor(mut self) -> Self {
        let corner = |x: f32, z: f32| Vec3::new(x, -0.3, z);
        let [a, b, c, d] = [corner(-1.5, -1.5), corner(-1.5, 1.5), corner(1.5, 1.5), corner(1.5, -1.5)];
        self.0.extend([Solid::Facet([a, b, c]), Solid::Facet([a, c, d])]);
        self
    }

    /// The same with a few solids of all other kinds among them, the last of which cannot be hit.
    pub(crate) fn with_others(mut self, draw: &mut Draw) -> Self {
        let spacing = self.0.len() / 20;
        for at in (0..20).map(|n| n * spacing) {
            let corner = draw.point();
            let around = Aabb::new(corner, corner + draw.point().abs() * 0.2);
            let vertices = [corner, corner + draw.point() * 0.3, corner + draw.point() * 0.3];
            self.0.insert(at, Solid::Sphere { centre: draw.point(), radius: 0.1 });
            self.0.extend([Solid::Triangle(vertices), Solid::Box(around), Solid::Sloppy(around), Solid::Ghost(around)]);
        }
        self
    }

    pub(crate) fn scaled(mut self, scale: f64) -> Self {
        self.map_points(|p| p * scale, scale);
        self
    }

    pub(crate) fn moved(mut self, offset: DVec3) -> Self {
        self.map_points(|p| p + offset, 1.0);
        self
    }

    fn map_points(&mut self, point: impl Fn(DVec3) -> DVec3, scale: f64) {
        for solid in &mut self.0 {
            *solid = match *solid {
                Solid::Sphere { centre, radius } => Solid::Sphere { centre: point(centre), radius: radius * scale },
                Solid::Round(SphereKernel { centre, radius }) => {
                    Solid::Round(SphereKernel { centre: point(centre), radius: radius * scale })
                }
                Solid::Box(b) => Solid::Box(Aabb::new(point(b.min), point(b.max))),
                Solid::Triangle(vertices) => Solid::Triangle(vertices.map(&point)),
                Solid::Facet(vertices) => Solid::Facet(vertices.map(|vertex| point(vertex.as_dvec3()).as_vec3())),
                Solid::Sloppy(b) => Solid::Sloppy(Aabb::new(point(b.min), point(b.max))),
                Solid::Ground { height } => Solid::Ground { height: point(DVec3::Y * height).y },
                Solid::Ghost(b) => Solid::Ghost(Aabb::new(point(b.min), point(b.max))),
            };
        }
    }
}

/// Two triangles for each cell of an n × n grid over [-1, 1]², raised by `surface`.
pub(crate) fn sheet(n: usize, surface: impl Fn(f64, f64) -> DVec3) -> impl Iterator<Item = Solid> {
    let vertex = move |i: usize, j: usize| {
        let place = |k: usize| 2.0 * k as f64 / n as f64 - 1.0;
        surface(place(i), place(j))
    };
    (0..n * n).flat_map(move |cell| {
        let (i, j) = (cell % n, cell / n);
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [Solid::Triangle([a, b, c]), Solid::Triangle([a, c, d])]
    })
}

impl Solid {
    pub(crate) fn bounds(&self) -> Option<Aabb> {
        match *self {
            Self::Sphere { centre, radius } | Self::Round(SphereKernel { centre, radius }) => {
                Some(Aabb::new(centre - DVec3::splat(radius), centre + DVec3::splat(radius)))
            }
            Self::Box(aabb) | Self::Sloppy(aabb) | Self::Ghost(aabb) => Some(aabb),
            Self::Triangle(vertices) => Some(Aabb::from_points(vertices)),
            Self::Facet(vertices) => Some(Aabb::from_points(vertices.map(|vertex| vertex.as_dvec3()))),
            Self::Ground { .. } => None,
        }
    }

    fn intersect(&self, ray: &Ray, span: Interval) -> Option<f64> {
        match *self {
            Self::Sphere { centre, radius } => sphere(centre, radius, ray, span),
            Self::Round(round) => round.intersect(ray, span),
            Self::Box(aabb) => {
                let line = aabb.clip(&SlabRay::new(ray), Interval::new(f64::NEG_INFINITY, f64::INFINITY))?;
                span.first(line.min, line.max)
            }
            Self::Triangle(vertices) => triangle(vertices, ray).filter(|&t| span.contains(t)),
            Self::Sloppy(aabb) => sloppy(aabb, ray).filter(|&t| span.contains(t)),
            Self::Ground { height } => ground(height).intersect(ray, span).map(|hit| hit.t),
            Self::Facet(_) | Self::Ghost(_) => None,
        }
    }
}

fn ground(height: f64) -> Plane {
    Plane::new(DVec3::new(0.3, height, -0.2), DVec3::Y).expect("a finite height")
}

fn sphere(centre: DVec3, radius: f64, ray: &Ray, span: Interval) -> Option<f64> {
    let f = ray.origin - centre;
    let a = ray.direction.length_squared();
    let b = -f.dot(ray.direction);
    let c = f.length_squared() - radius * radius;
    let discriminant = radius * radius - (f + ray.direction * (b / a)).length_squared();
    if discriminant < 0.0 || discriminant.is_nan() {
        return None;
    }
    let q = b + (a * discriminant).sqrt().copysign(b);
    let (t0, t1) = (c / q, q / a);
    span.first(t0.min(t1), t0.max(t1))
}

fn triangle([a, b, c]: [DVec3; 3], ray: &Ray) -> Option<f64> {
    let (e1, e2) = (b - a, c - a);
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    let s = ray.origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = ray.direction.dot(q) / determinant;
    let t = e2.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t.is_finite()).then_some(t)
}

fn sloppy(aabb: Aabb, ray: &Ray) -> Option<f64> {
    let pad = DVec3::splat(aabb.extent().max_element() * 0.01);
    let larger = Aabb::new(aabb.min - pad, aabb.max + pad);
    let line = larger.clip(&SlabRay::new(ray), Interval::new(-1e300, 1e300))?;
    let words: Vec<u64> = ray.origin.to_array().iter().chain(&ray.direction.to_array()).map(|x| x.to_bits()).collect();
    let weight = rt_math::random::unit(rt_math::random::hash(&words)) * 1.2 - 0.1;
    let t = line.min + weight * (line.max - line.min);
    t.is_finite().then_some(t)
}

impl Primitives for Soup {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.0[index as usize].bounds()
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        if let Solid::Facet(vertices) = self.0[index as usize] {
            let hit = WatertightRay::new(ray).intersect(vertices.map(|vertex| vertex.as_dvec3()), span)?;
            return Some(Hit { t: hit.t, instance: 0, primitive: index, uv: hit.uv });
        }
        let t = self.0[index as usize].intersect(ray, span)?;
        Some(Hit { t, instance: 0, primitive: index, uv: [0.0; 2] })
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        match self.0[index as usize] {
            Solid::Sphere { centre, radius } => PrimitiveGeometry::Sphere(centre, radius),
            Solid::Round(round) => PrimitiveGeometry::ExactSphere(round),
            Solid::Box(aabb) => PrimitiveGeometry::Box(aabb),
            Solid::Triangle(vertices) => PrimitiveGeometry::Triangle(vertices),
            Solid::Facet(vertices) => PrimitiveGeometry::ExactTriangle(vertices),
            Solid::Sloppy(_) | Solid::Ground { .. } | Solid::Ghost(_) => PrimitiveGeometry::Opaque,
        }
    }

    fn packet_kernel(&self, index: u32) -> PacketKernel {
        match self.0[index as usize] {
            Solid::Round(round) => PacketKernel::Sphere(round),
            Solid::Facet(vertices) => PacketKernel::Triangle(vertices.map(|vertex| vertex.as_dvec3())),
            Solid::Ground { height } => PacketKernel::Plane(ground(height)),
            _ => PacketKernel::Single,
        }
    }
}

impl ClosestPoint for Soup {
    /// Some point of the primitive or its box; a plane has one, and ghosts have none.
    fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3> {
        match self.0[index as usize] {
            Solid::Sphere { centre, radius } | Solid::Round(SphereKernel { centre, radius }) => {
                Some(centre + (point - centre).normalize_or_zero() * radius.min((point - centre).length()))
            }
            Solid::Ground { height } => Some(DVec3::new(point.x, height, point.z)),
            Solid::Ghost(_) => None,
            solid => solid.bounds().map(|bounds| point.max(bounds.min).min(bounds.max)),
        }
    }
}
