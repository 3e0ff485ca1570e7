//! Images.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use numpy::{IntoPyArray as _, PyArray1};
use pyo3::prelude::*;
use rt_render::{PlanOptions, RayKind, RenderPlan, Rendering, RunOptions, StopRule, Stopped, TargetError};
use rt_scene_io::{Integrator, LoadOptions, Scene};

use crate::error::value_error;
use crate::threads::Threads;

/// Time between two checks for signals.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// A finished image: pixels, row by row, with statistics and error estimates.
#[pyclass(name = "Rendering", module = "rt._rt", frozen)]
pub(crate) struct PyRendering {
    rendering: Rendering,
    width: usize,
    height: usize,
}

#[pymethods]
impl PyRendering {
    /// Linear radiance, three numbers for each pixel.
    fn pixels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.rendering.film.pixels().as_flattened().to_vec().into_pyarray(py)
    }

    #[getter]
    fn width(&self) -> usize {
        self.width
    }

    #[getter]
    fn height(&self) -> usize {
        self.height
    }

    /// Samples per pixel: least, mean, most.
    #[getter]
    fn samples_per_pixel(&self) -> (u32, f64, u32) {
        let range = self.rendering.samples_per_pixel;
        (range.min, range.mean, range.max)
    }

    /// Relative root mean square error and its 95 % interval; `None` if it is unknown.
    #[getter]
    fn error(&self) -> Option<(f64, (f64, f64))> {
        let error = self.rendering.error?;
        let [low, high] = error.relative_interval();
        Some((error.relative_rmse(), (low, high)))
    }

    /// Names and values of statistics.
    #[getter]
    fn statistics(&self) -> Vec<(&'static str, f64)> {
        let statistics = &self.rendering.statistics;
        let mut values = vec![
            ("samples", statistics.samples as f64),
            ("passes", f64::from(statistics.passes)),
            ("bad_samples", statistics.bad_samples as f64),
            ("threads", statistics.threads as f64),
            ("build_seconds", statistics.build_seconds),
            ("render_seconds", statistics.render_seconds),
        ];
        let of_kind = |kind: RayKind| statistics.counters.of(kind).rays as f64;
        values.extend(RayKind::ALL.map(|kind| (rays_name(kind), of_kind(kind))));
        values
    }

    /// Why the render ended: `samples`, `time` or `target`.
    #[getter]
    fn stopped(&self) -> &'static str {
        match self.rendering.stopped {
            Stopped::Samples => "samples",
            Stopped::Time => "time",
            Stopped::Target => "target",
            Stopped::Interrupted => "interrupted",
        }
    }
}

const fn rays_name(kind: RayKind) -> &'static str {
    match kind {
        RayKind::Primary => "primary_rays",
        RayKind::Shadow => "shadow_rays",
        RayKind::Reflection => "reflection_rays",
        RayKind::Refraction => "refraction_rays",
        RayKind::Diffuse => "diffuse_rays",
    }
}

/// Renders a scene file.
#[pyfunction]
#[pyo3(signature = (path, *, spp, size, seed, integrator, depth, time, target_error, threads))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
pub(crate) fn render(
    py: Python<'_>,
    path: PathBuf,
    spp: Option<u32>,
    size: Option<[u32; 2]>,
    seed: Option<u64>,
    integrator: Option<&str>,
    depth: Option<u32>,
    time: Option<f64>,
    target_error: Option<f64>,
    threads: usize,
) -> PyResult<PyRendering> {
    let integrator = integrator.map(integrator_of).transpose()?;
    let rule = stop_rule(spp, time, target_error)?;
    let interrupt = AtomicBool::new(false);
    let load = |_| -> Result<Scene, String> {
        let options = LoadOptions { size, integrator, ..LoadOptions::default() };
        let mut scene = rt_scene_io::load(&path, &options).map_err(|error| error.to_string())?;
        let settings = &mut scene.settings;
        settings.spp = spp.unwrap_or(settings.spp);
        settings.seed = seed.unwrap_or(settings.seed);
        settings.depth = depth.unwrap_or(settings.depth);
        settings.integrator = integrator.unwrap_or(settings.integrator);
        Ok(scene)
    };
    let pool = Threads::all(py)?;
    let work = || -> Result<Rendering, String> {
        let scene = pool.run(load)?;
        let plan = pool.run(|_| RenderPlan::compile(&scene, &PlanOptions::default()));
        let plan = plan.map_err(|error| error.to_string())?;
        let options = RunOptions { threads, interrupt: Some(&interrupt), ..RunOptions::default() };
        let rendered = match &rule {
            Some(rule) => plan.render_until(&options, rule, |_| ()),
            None => plan.render(&options, |_| ()),
        };
        rendered.map_err(|error| error.to_string())
    };
    let rendering = py.detach(|| while_signals_are_checked(&interrupt, work))?.map_err(value_error)?;
    let (width, height) = (rendering.film.width() as usize, rendering.film.height() as usize);
    Ok(PyRendering { rendering, width, height })
}

/// Calls `work` on a thread of its own. Meanwhile this thread checks for signals: only the main thread of Python handles them.
/// The first exception of a handler sets `interrupt`, and is returned once `work` has ended.
fn while_signals_are_checked<T: Send>(interrupt: &AtomicBool, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let mut raised = Ok(());
    let (sender, ended) = mpsc::channel::<()>();
    let worked = thread::scope(|scope| -> PyResult<_> {
        let worker = thread::Builder::new().spawn_scoped(scope, move || {
            // Dropped when the work ends, by a panic as well.
            let _sender = sender;
            work()
        })?;
        while ended.recv_timeout(SIGNAL_INTERVAL) == Err(RecvTimeoutError::Timeout) {
            if raised.is_ok() {
                raised = Python::attach(|py| py.check_signals());
                interrupt.store(raised.is_err(), Ordering::Relaxed);
            }
        }
        Ok(worker.join())
    })?;
    raised?;
    worked.or_else(|panic| std::panic::resume_unwind(panic))
}

fn integrator_of(name: &str) -> PyResult<Integrator> {
    let found = Integrator::ALL.into_iter().find(|integrator| integrator.name() == name);
    found.ok_or_else(|| {
        let names = Integrator::ALL.map(Integrator::name).join(", ");
        value_error(format!("integrator {name:?} is not one of {names}"))
    })
}

/// The rule of a render that ends by time or error; the number of samples is then the limit.
fn stop_rule(spp: Option<u32>, time: Option<f64>, target_error: Option<f64>) -> PyResult<Option<StopRule>> {
    if time.is_none() && target_error.is_none() {
        return Ok(None);
    }
    let duration = |seconds: f64| {
        let message = format!("time must be positive and below 1.8e19 seconds, not {seconds:?}");
        Duration::try_from_secs_f64(seconds).map_err(|_| value_error(message))
    };
    let default_max =
        if target_error.is_some() { StopRule::DEFAULT_MAX_SPP_OF_TARGET } else { StopRule::DEFAULT_MAX_SPP };
    Ok(Some(StopRule {
        time: time.map(duration).transpose()?,
        target: target_error.map(TargetError::of_image),
        max_spp: spp.unwrap_or(default_max),
    }))
}
