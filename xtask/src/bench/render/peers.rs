//! Figures of other renderers, to compare with.

/// The fastest of the renderers that were measured on a scene.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(super) struct Peer {
    pub scene: &'static str,
    pub renderer: &'static str,
    /// CPU seconds of the whole process, from start to written image.
    pub cpu_seconds: f64,
}

pub(super) const SOURCE: &str = "Of POV-Ray 3.7.0.10, Tachyon 0.99b6, Mitsuba 3.9.1 (scalar_rgb, llvm_ad_rgb) and Cycles \
    (bpy 5.0.1) the fastest: processor seconds of the whole process on one core of an AMD EPYC (Zen 4), median of three. \
    That was another run, so times compare only roughly.";

const MITSUBA: &str = "Mitsuba llvm_ad_rgb";

const FASTEST: [Peer; 6] = [
    Peer { scene: "mound10", renderer: MITSUBA, cpu_seconds: 0.92 },
    Peer { scene: "mound100", renderer: MITSUBA, cpu_seconds: 1.23 },
    Peer { scene: "mound1000", renderer: MITSUBA, cpu_seconds: 1.89 },
    Peer { scene: "minray", renderer: MITSUBA, cpu_seconds: 0.72 },
    Peer { scene: "whitted", renderer: MITSUBA, cpu_seconds: 0.89 },
    Peer { scene: "balls", renderer: "Cycles", cpu_seconds: 5.03 },
];

pub(super) fn fastest(scene: &str) -> Option<Peer> {
    FASTEST.into_iter().find(|peer| peer.scene == scene)
}
