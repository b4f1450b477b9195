//! Trained controllers.

use crate::convert::{
    body_and_task, from_python, os_error, parameters, read_controller, to_python, value_error,
};
use crate::recording::Recording;
use gaitshift_experiment::{CommandProfile, Deterministic, Rollout, portable_path};
use gaitshift_task::{
    ACTION_SIZE, Disturbance, Environment, OBSERVATION_SIZE, OMEGA_V_MAX, scale_observation,
};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};

/// See `_native.pyi`.
#[pyclass(module = "gaitshift", frozen)]
pub struct Controller {
    pub controller: gaitshift_experiment::Controller,
    name: String,
}

#[pymethods]
impl Controller {
    #[staticmethod]
    fn shipped() -> PyResult<Self> {
        let controller = gaitshift_experiment::Controller::shipped().map_err(value_error)?;
        Ok(Self {
            controller,
            name: "the shipped controller".to_owned(),
        })
    }

    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self {
            controller: read_controller(&path)?,
            name: path.display().to_string(),
        })
    }

    #[staticmethod]
    fn from_bytes(bytes: &[u8], name: String) -> PyResult<Self> {
        let controller = gaitshift_experiment::Controller::from_bytes(bytes, Path::new(&name))
            .map_err(value_error)?;
        Ok(Self { controller, name })
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.controller.to_bytes().map_err(value_error)?;
        Ok(PyBytes::new(py, &bytes))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    #[getter]
    fn body<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.controller.body)
    }

    #[getter]
    fn task<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.controller.task)
    }

    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.controller.provenance)
    }

    #[getter]
    fn control_period_s(&self) -> f64 {
        self.controller.task.control_period_s
    }

    fn onnx<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = gaitshift_export::onnx(&self.controller).map_err(value_error)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn write_onnx(&self, path: PathBuf) -> PyResult<()> {
        let bytes = gaitshift_export::onnx(&self.controller).map_err(value_error)?;
        gaitshift_analysis::write_whole(&path, &bytes).map_err(|e| os_error(&e, &path))
    }

    /// One observation (14,) or several (n, 14).
    fn act<'py>(
        &self,
        py: Python<'py>,
        observations: PyReadonlyArrayDyn<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let shape = observations.shape().to_vec();
        if !(shape.len() == 1 || shape.len() == 2) || shape.last() != Some(&OBSERVATION_SIZE) {
            return Err(value_error(format!(
                "the observation has the shape {shape:?}, but it must be ({OBSERVATION_SIZE},) or (n, {OBSERVATION_SIZE})"
            )));
        }
        let rows = if shape.len() == 1 { 1 } else { shape[0] };
        let values: Vec<f64> = observations.as_array().iter().copied().collect();
        if let Some(k) = values.iter().position(|v| !v.is_finite()) {
            return Err(value_error(format!(
                "element {} of the observation is {}, but it must be finite",
                k % OBSERVATION_SIZE,
                values[k]
            )));
        }
        let mut policy = self.controller.policy.clone();
        let actions = py.detach(|| -> Result<Vec<f32>, String> {
            let mut scaled = vec![0.0; values.len()];
            let (observations, _) = values.as_chunks::<OBSERVATION_SIZE>();
            for (observation, out) in observations.iter().zip(scaled.chunks_mut(OBSERVATION_SIZE)) {
                scale_observation(observation, out);
            }
            let mut actions = vec![0.0; rows * ACTION_SIZE];
            policy
                .mean_action(&scaled, &mut actions)
                .map_err(|e| e.to_string())?;
            Ok(actions)
        });
        let actions = actions.map_err(value_error)?;
        if shape.len() == 1 {
            Ok(actions.into_pyarray(py).into_any())
        } else {
            let actions =
                Array2::from_shape_vec((rows, ACTION_SIZE), actions).map_err(value_error)?;
            Ok(actions.into_pyarray(py).into_any())
        }
    }

    #[pyo3(signature = (profile, duration_s, seed = None, body = None, task = None, disturbance = None))]
    #[allow(clippy::too_many_arguments)]
    fn record(
        &self,
        py: Python<'_>,
        profile: Vec<(f64, f64)>,
        duration_s: f64,
        seed: Option<u64>,
        body: Option<&Bound<'_, PyAny>>,
        task: Option<&Bound<'_, PyAny>>,
        disturbance: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Recording> {
        if !(0.0..=3600.0).contains(&duration_s) {
            return Err(value_error(format!(
                "`duration_s` is {duration_s}, but it must be from 0 to 3600"
            )));
        }
        let profile = command_profile(&profile)?;
        let (mut body, task) = body_and_task(None, Some(&self.controller), body, task)?;
        let disturbance = match disturbance {
            Some(table) => {
                let table = from_python(table, "disturbance")?;
                let disturbance: Disturbance = parameters(table, "disturbance")?;
                disturbance.validate().map_err(value_error)?;
                body = disturbance.place(body);
                Some(disturbance)
            }
            None => None,
        };
        let start = Environment::start(&body, &task, seed);
        let mut policy = self.controller.policy.clone();
        let recording = py.detach(|| {
            Rollout {
                body: &body,
                task: &task,
                start,
                profile: &profile,
                duration_s,
                seed: seed.unwrap_or(0),
                disturbance: disturbance.as_ref(),
                controller: &portable_path(Path::new(&self.name)),
            }
            .record(&mut Deterministic(&mut policy))
        });
        recording.map(Recording).map_err(value_error)
    }
}

/// The command over time from its points.
fn command_profile(points: &[(f64, f64)]) -> PyResult<CommandProfile> {
    let in_range = points.iter().all(|p| p.1.abs() <= OMEGA_V_MAX);
    CommandProfile::through(points)
        .filter(|_| in_range)
        .ok_or_else(|| {
            value_error(format!(
                "the command needs at least one point (time in s, omega_v), increasing times and commands from -{OMEGA_V_MAX} to \
                 {OMEGA_V_MAX}"
            ))
        })
}
