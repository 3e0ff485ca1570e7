//! Pairs of coordinates of 256 paths, drawn one by one and together, for each pattern.

#![allow(missing_docs, reason = "criterion's macros generate public functions")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rt_camera::{PixelSampler, SampleStream, SamplerKind};
use rt_math::Sampler;

/// Paths that are traced together.
const PATHS: u32 = 256;
/// Pairs that each path draws.
const PAIRS: u64 = 8;

/// Samplers of consecutive samples of some pixels.
fn samplers(pattern: SamplerKind, pixels: u32) -> Vec<SampleStream> {
    let sampler = PixelSampler::new(pattern, 256, 7);
    let of_pixel = |x| (0..PATHS / pixels).map(move |index| sampler.sample([100 + x, 200], index));
    (0..pixels).flat_map(of_pixel).collect()
}

fn pairs(c: &mut Criterion) {
    let mut group = c.benchmark_group("pairs");
    group.throughput(Throughput::Elements(u64::from(PATHS) * PAIRS));
    for pattern in SamplerKind::ALL {
        for pixels in [1, 4, 16] {
            let start = samplers(pattern, pixels);
            let mut paths = start.clone();
            let mut values = vec![[0.0; 2]; paths.len()];
            group.bench_function(BenchmarkId::new(format!("{}/one by one", pattern.name()), pixels), |bench| {
                bench.iter(|| {
                    paths.copy_from_slice(&start);
                    for _ in 0..PAIRS {
                        for (path, value) in paths.iter_mut().zip(&mut values) {
                            *value = path.next_2d();
                        }
                        black_box(&mut values);
                    }
                });
            });
            let which: Vec<_> = (0..PATHS).collect();
            group.bench_function(BenchmarkId::new(format!("{}/batch", pattern.name()), pixels), |bench| {
                bench.iter(|| {
                    paths.copy_from_slice(&start);
                    for _ in 0..PAIRS {
                        Sampler::next_2d_batch(&mut paths, &which, &mut values);
                        black_box(&mut values);
                    }
                });
            });
        }
    }
}

fn settings() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .without_plots()
}

criterion_group! { name = benches; config = settings(); targets = pairs }
criterion_main!(benches);
