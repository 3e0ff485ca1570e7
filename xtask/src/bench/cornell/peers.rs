//! Results of other renderers on the Cornell box.

use serde::Serialize;

pub(super) const SOURCE: &str = "Mitsuba 3.9.1 (llvm_ad_rgb, independent samples, one thread) and Cycles (bpy 5.0.1, its own samples, \
    one thread) were measured in another run, on one core of an AMD EPYC (Zen 4): processor seconds of the render call, against the \
    same reference with the same pixels left out. Times of other runs compare only roughly.";

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct CornellPeer {
    pub name: &'static str,
    points: [Point; 4],
}

/// Result at one number of samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Point {
    pub spp: u32,
    pub cpu_seconds: f64,
    pub rmse: f64,
    /// Efficiency 1 / (MSE · seconds) of unrounded numbers.
    pub efficiency: f64,
}

const fn point(spp: u32, cpu_seconds: f64, rmse: f64, efficiency: f64) -> Point {
    Point { spp, cpu_seconds, rmse, efficiency }
}

pub(super) const PEERS: [CornellPeer; 2] = [
    CornellPeer {
        name: "Mitsuba LLVM",
        points: [
            point(16, 0.557, 0.01534, 7629.3),
            point(64, 2.186, 0.00765, 7822.9),
            point(256, 8.680, 0.00384, 7809.9),
            point(1024, 34.864, 0.00194, 7654.9),
        ],
    },
    CornellPeer {
        name: "Cycles",
        points: [
            point(16, 2.661, 0.01404, 1906.3),
            point(64, 8.715, 0.00648, 2734.0),
            point(256, 34.331, 0.00306, 3112.2),
            point(1024, 141.835, 0.00148, 3222.4),
        ],
    },
];

impl CornellPeer {
    /// Result with this number of samples per pixel.
    pub(super) fn at(&self, spp: u32) -> Option<&Point> {
        self.points.iter().find(|point| point.spp == spp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_fit_together() {
        for Point { cpu_seconds, rmse, efficiency, .. } in PEERS.iter().flat_map(|peer| peer.points) {
            // RMSE has three digits.
            let product = efficiency * rmse * rmse * cpu_seconds;
            assert!((product - 1.0).abs() < 0.02, "{efficiency}: {product}");
        }
    }
}
