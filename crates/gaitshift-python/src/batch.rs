//! Environments stepped together, without Python in between: what both Gymnasium classes stand on.

use crate::controller::Controller;
use crate::convert::{
    body_and_task, from_python, in_range, numbers, parameters, to_python, value_error,
};
use gaitshift_analysis::recording::RecordingMetadata;
use gaitshift_body::{Body, BodyParameters, BodyState, LEFT, RIGHT, Terrain};
use gaitshift_experiment::{Simulation, recording_row};
use gaitshift_figures::Snapshot;
use gaitshift_task::{
    AutoReset, INFO_SIZE, INFO_WIDTH, OBSERVATION_SIZE, OMEGA_V_MAX, Opening, TaskParameters,
    VectorEnvironment, VectorState, VectorStep, info_names,
};
use gaitshift_view::{Server, Show, Stopper, ViewOptions, Watched};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyIndexError, PyOSError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use serde::Deserialize;
use serde_json::{Value, json};
use std::net::{Ipv4Addr, SocketAddr};

/// See `_native.pyi`.
#[pyclass(module = "gaitshift._native")]
pub struct Batch {
    vector: VectorEnvironment,
    threads: usize,
    names: Vec<Py<PyString>>,
    shown: Option<Shown>,
}

/// The first environment on a page in the browser.
#[derive(Debug)]
struct Shown {
    name: String,
    watched: Watched,
    stopper: Stopper,
    row: Vec<f64>,
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.stopper.stop();
    }
}

type Vector<'py, T> = Bound<'py, PyArray1<T>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;
/// Observation, reward, terminated, truncated, info.
type OneStep<'py> = (Vector<'py, f64>, f64, bool, bool, Bound<'py, PyDict>);
/// Observations, rewards, terminated, truncated, info, observations and info of episodes after which another began, and why
/// episodes ended.
type Vectors<'py> = (
    Matrix<'py>,
    Vector<'py, f64>,
    Vector<'py, bool>,
    Vector<'py, bool>,
    Matrix<'py>,
    Option<(Matrix<'py>, Matrix<'py>)>,
    Option<Vec<Option<String>>>,
);

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (count, omega_v, *, experiment = None, controller = None, body = None, task = None,
                        randomization = None, disturbance = None, threads = 1))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        count: i64,
        omega_v: [f64; 2],
        experiment: Option<&str>,
        controller: Option<&Controller>,
        body: Option<&Bound<'_, PyAny>>,
        task: Option<&Bound<'_, PyAny>>,
        randomization: Option<&Bound<'_, PyAny>>,
        disturbance: Option<&Bound<'_, PyAny>>,
        threads: i64,
    ) -> PyResult<Self> {
        let controller = controller.map(|c| &c.controller);
        let (body, task) = body_and_task(experiment, controller, body, task)?;
        if !(omega_v.iter().all(|w| w.abs() <= OMEGA_V_MAX) && omega_v[0] <= omega_v[1]) {
            return Err(value_error(format!(
                "`omega_v` is {omega_v:?}, but it must be a command from -{OMEGA_V_MAX} to {OMEGA_V_MAX}, or a pair (lowest, highest) of them"
            )));
        }
        let count = in_range("num_envs", count, 1..=65_536)?;
        let threads = in_range("threads", threads, 1..=256)?;
        let own = |table: Option<&Bound<'_, PyAny>>, name| match table {
            Some(table) => from_python(table, name).map(Some),
            None => Ok(None),
        };
        let vector = disturbed(
            VectorEnvironment::new(body, task, omega_v, count),
            own(randomization, "randomization")?,
            own(disturbance, "disturbance")?,
        )?;
        Ok(Self::of(py, vector, threads))
    }

    /// Everything there is, as text for `restore`; without the page that shows it.
    fn save(&self) -> PyResult<String> {
        let v = &self.vector;
        let saved = json!({
            "body": v.body().parameters(),
            "task": v.task(),
            "omega_v": v.command_range(),
            "randomization": v.randomization(),
            "disturbance": v.disturbance(),
            "threads": self.threads,
            "state": v.state(),
        });
        serde_json::to_string(&saved).map_err(value_error)
    }

    /// What `save` wrote.
    #[staticmethod]
    fn restore(py: Python<'_>, text: &str) -> PyResult<Self> {
        #[derive(Deserialize)]
        struct All {
            body: BodyParameters,
            task: TaskParameters,
            omega_v: [f64; 2],
            randomization: Option<Value>,
            disturbance: Option<Value>,
            threads: usize,
            state: VectorState,
        }
        let damaged = |cause: &dyn std::fmt::Display| {
            value_error(format!("the saved environment cannot be used: {cause}"))
        };
        let all: All = serde_json::from_str(text).map_err(|e| damaged(&e))?;
        let body = Body::new(all.body).map_err(|e| damaged(&e))?;
        all.task
            .validate(body.parameters())
            .map_err(|e| damaged(&e))?;
        let count = all.state.len();
        if count == 0 {
            return Err(damaged(&"it is of no environments"));
        }
        let vector = VectorEnvironment::new(body, all.task, all.omega_v, count);
        let mut vector = disturbed(vector, all.randomization, all.disturbance)?;
        if !vector.restore(all.state) {
            return Err(damaged(&"it is of other environments"));
        }
        Ok(Self::of(py, vector, all.threads.clamp(1, 256)))
    }

    /// Names of the rows of the information, those of reward terms of one's own after those that all have.
    #[getter]
    fn info_names<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyString>> {
        self.names
            .iter()
            .map(|name| name.bind(py).clone())
            .collect()
    }

    #[getter]
    fn body<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.vector.body().parameters())
    }

    #[getter]
    fn task<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.vector.task())
    }

    #[getter]
    fn disturbance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.vector.disturbance())
    }

    fn seed(&mut self, index: usize, seed: u64) -> PyResult<()> {
        self.check_index(index)?;
        self.vector.seed(index, seed);
        Ok(())
    }

    #[getter]
    fn omega_v(&self) -> Vec<f64> {
        let commands = (0..self.vector.len()).map(|i| self.vector.environment(i).omega_v);
        commands.collect()
    }

    /// The commands of all environments; none changes if one is out of range.
    #[setter]
    fn set_omega_v(&mut self, omega_v: Vec<f64>) -> PyResult<()> {
        self.check_commands(&omega_v)?;
        for (index, value) in omega_v.into_iter().enumerate() {
            self.vector.set_command(index, value);
        }
        Ok(())
    }

    /// Serves a page on the loopback address that shows the first environment; gives its address. Steps and episodes
    /// of single environments are shown.
    fn watch(&mut self, name: &str) -> PyResult<String> {
        let (body, task) = (self.vector.body(), self.vector.task());
        let options = ViewOptions {
            address: SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0),
            names: Vec::new(),
        };
        let server = Server::bind(&options).map_err(|e| PyOSError::new_err(e.to_string()))?;
        let own_columns = task.reward.extra.columns().collect();
        let metadata = recording_metadata(body, task, name);
        let watched = Watched::new(name, body.parameters(), metadata, own_columns);
        let (url, stopper) = (server.url(), server.stopper());
        let show = Show::Watched(watched.clone());
        std::thread::Builder::new()
            .name("view".to_owned())
            .spawn(move || server.run(show))
            .map_err(|e| PyOSError::new_err(e.to_string()))?;
        self.shown = Some(Shown {
            name: name.to_owned(),
            watched,
            stopper,
            row: Vec::new(),
        });
        Ok(url)
    }

    /// Ends the page.
    fn unwatch(&mut self) {
        self.shown = None;
    }

    /// Pictures of the environments of the given indices, shape (rows, columns, 3) each, drawn without the
    /// interpreter's lock.
    fn render<'py>(
        &self,
        py: Python<'py>,
        indices: Vec<usize>,
        width_px: u32,
    ) -> PyResult<Vec<Bound<'py, PyArray3<u8>>>> {
        indices
            .iter()
            .try_for_each(|&index| self.check_index(index))?;
        let period_s = self.vector.task().control_period_s;
        let draw = |index: usize| {
            let (environment, body) = (self.vector.environment(index), self.vector.body_of(index));
            let state = &environment.state;
            let force_n = [RIGHT, LEFT].map(|leg| {
                let contact = body.foot_contact(state, leg);
                (contact.tangential_n, contact.normal_n)
            });
            let ground = body.terrain().map(Terrain::outline);
            Snapshot {
                body: body.parameters(),
                ground: ground.as_deref(),
                state,
                force_n,
                omega_v: environment.omega_v,
                time_s: f64::from(environment.periods) * period_s,
            }
            .draw(width_px)
        };
        let pictures = py.detach(|| {
            let drawn = indices.iter().map(|&index| draw(index));
            drawn.collect::<Result<Vec<_>, _>>()
        });
        let pictures = pictures.map_err(|e| value_error(e.to_string()))?;
        pictures
            .into_iter()
            .map(|picture| {
                let shape = (picture.height as usize, picture.width as usize, 3);
                let rgb: Vec<u8> = picture
                    .rgba
                    .chunks_exact(4)
                    .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
                    .collect();
                let array =
                    Array3::from_shape_vec(shape, rgb).map_err(|e| value_error(e.to_string()))?;
                Ok(array.into_pyarray(py))
            })
            .collect()
    }

    fn state<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(Vector<'py, f64>, Vector<'py, f64>)> {
        self.check_index(index)?;
        let state = self.vector.environment(index).state;
        Ok((
            PyArray1::from_slice(py, &state.positions()),
            PyArray1::from_slice(py, &state.velocities()),
        ))
    }

    #[pyo3(signature = (index, omega_v = None, default_start = false, state = None))]
    fn reset_one<'py>(
        &mut self,
        py: Python<'py>,
        index: usize,
        omega_v: Option<f64>,
        default_start: bool,
        state: Option<[PyReadonlyArrayDyn<'py, f64>; 2]>,
    ) -> PyResult<(Vector<'py, f64>, Bound<'py, PyDict>)> {
        omega_v.map_or(Ok(()), check_command)?;
        self.check_index(index)?;
        let opening = Opening {
            omega_v,
            default_start,
            state: state.map(|s| body_state(&s)).transpose()?,
        };
        let step = self.vector.reset(index, opening);
        if index == 0 {
            if let Some(shown) = &self.shown {
                let body = self.vector.body_of(0);
                let metadata = recording_metadata(body, self.vector.task(), &shown.name);
                shown.watched.begin(body.parameters(), metadata);
            }
            self.show([0.0; 2], &step);
        }
        Ok((
            PyArray1::from_slice(py, &step.observation),
            self.info(py, &step)?,
        ))
    }

    /// One step of the first environment.
    fn step_one<'py>(&mut self, py: Python<'py>, right: f64, left: f64) -> PyResult<OneStep<'py>> {
        check_action(right)?;
        check_action(left)?;
        let step = py.detach(|| self.vector.step(0, [right, left]));
        self.show([right, left].map(|c| c.clamp(-1.0, 1.0)), &step);
        Ok((
            PyArray1::from_slice(py, &step.observation),
            step.reward,
            step.terminated,
            step.truncated,
            self.info(py, &step)?,
        ))
    }

    /// Begins an episode in every environment that `mask` names, under the commands and in the states given for all
    /// environments if there are any.
    #[pyo3(signature = (mask, omega_v = None, default_start = false, states = None))]
    fn reset_all<'py>(
        &mut self,
        py: Python<'py>,
        mask: Vec<bool>,
        omega_v: Option<Vec<f64>>,
        default_start: bool,
        states: Option<Vec<[PyReadonlyArrayDyn<'py, f64>; 2]>>,
    ) -> PyResult<(Matrix<'py>, Matrix<'py>)> {
        if mask.len() != self.vector.len() {
            return Err(value_error(format!(
                "the mask has {} elements for {} environments",
                mask.len(),
                self.vector.len()
            )));
        }
        if let Some(commands) = &omega_v {
            self.check_commands(commands)?;
        }
        let states: Option<Vec<BodyState>> = states
            .map(|states| states.iter().map(body_state).collect())
            .transpose()?;
        if let Some(states) = states.as_ref().filter(|s| s.len() != mask.len()) {
            return Err(value_error(format!(
                "{} states were given for {} environments",
                states.len(),
                mask.len()
            )));
        }
        let steps: Vec<VectorStep> = mask
            .into_iter()
            .enumerate()
            .map(|(index, begin)| {
                if begin {
                    let opening = Opening {
                        omega_v: omega_v.as_ref().map(|commands| commands[index]),
                        default_start,
                        state: states.as_ref().map(|states| states[index]),
                    };
                    self.vector.reset(index, opening)
                } else {
                    self.vector.look(index)
                }
            })
            .collect();
        let (observations, _, _, _, info, _, _) = vectors(py, &steps, self.vector.task())?;
        Ok((observations, info))
    }

    /// One step of every environment, without the interpreter's lock.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
        autoreset: u8,
    ) -> PyResult<Vectors<'py>> {
        let count = self.vector.len();
        if actions.shape() != [count, 2] {
            return Err(value_error(format!(
                "`actions` has the shape {:?}, but it must be ({count}, 2)",
                actions.shape()
            )));
        }
        let actions = actions.as_array();
        let commands: Vec<[f64; 2]> = actions.rows().into_iter().map(|a| [a[0], a[1]]).collect();
        for (k, command) in commands.iter().enumerate() {
            for value in command {
                check_action(*value).map_err(|e| value_error(format!("environment {k}: {e}")))?;
            }
        }
        let auto_reset = match autoreset {
            0 => AutoReset::NextStep,
            1 => AutoReset::SameStep,
            _ => AutoReset::Disabled,
        };
        let threads = self.threads;
        let steps = py.detach(|| self.vector.step_all(&commands, auto_reset, threads));
        vectors(py, &steps, self.vector.task())
    }
}

/// Environments with what differs between their episodes, or disturbs them.
fn disturbed(
    mut vector: VectorEnvironment,
    randomization: Option<Value>,
    disturbance: Option<Value>,
) -> PyResult<VectorEnvironment> {
    if let Some(table) = randomization {
        let randomization = parameters(table, "randomization")?;
        vector = vector.randomized(randomization).map_err(value_error)?;
    }
    if let Some(table) = disturbance {
        let disturbance = parameters(table, "disturbance")?;
        vector = vector.disturbed(disturbance).map_err(value_error)?;
    }
    Ok(vector)
}

impl Batch {
    fn of(py: Python<'_>, vector: VectorEnvironment, threads: usize) -> Self {
        Self {
            names: info_names(&vector.task().reward)
                .iter()
                .map(|name| PyString::new(py, name).unbind())
                .collect(),
            vector,
            threads,
            shown: None,
        }
    }

    /// Shows the first environment after a step, if anyone watches.
    fn show(&mut self, command: [f64; 2], step: &VectorStep) {
        if let Some(shown) = &mut self.shown {
            let environment = self.vector.environment(0);
            let period_s = self.vector.task().control_period_s;
            recording_row(
                self.vector.body_of(0),
                environment,
                f64::from(environment.periods) * period_s,
                command,
                &step.report,
                &step.terms,
                &mut shown.row,
            );
            let own = self.vector.task().reward.extra.terms().len();
            shown.row.extend(&step.terms.extra[..own]);
            shown.watched.push(&shown.row);
        }
    }

    fn check_index(&self, index: usize) -> PyResult<()> {
        let count = self.vector.len();
        if index < count {
            return Ok(());
        }
        Err(PyIndexError::new_err(format!(
            "there is no environment {index}, only 0 to {}",
            count - 1
        )))
    }

    /// Commands of all environments.
    fn check_commands(&self, commands: &[f64]) -> PyResult<()> {
        if commands.len() != self.vector.len() {
            return Err(value_error(format!(
                "{} commands were given for {} environments",
                commands.len(),
                self.vector.len()
            )));
        }
        commands.iter().try_for_each(|&value| check_command(value))
    }

    fn info<'py>(&self, py: Python<'py>, step: &VectorStep) -> PyResult<Bound<'py, PyDict>> {
        let info = PyDict::new(py);
        for (k, (name, value)) in self.names.iter().zip(&step.info).enumerate() {
            if k == INFO_SIZE - 1 {
                info.set_item(name, *value != 0.0)?;
            } else {
                info.set_item(name, value)?;
            }
        }
        if let Some(ended) = step.ended {
            info.set_item("ended_by", self.vector.task().end_name(ended))?;
        }
        Ok(info)
    }
}

/// What describes a recording of a body's motion.
pub fn recording_metadata(body: &Body, task: &TaskParameters, name: &str) -> RecordingMetadata {
    Simulation::new(body, task, BodyState::standing(body), 0.0).metadata(name, 0)
}

/// Positions and velocities as the state of a body.
fn body_state([positions, velocities]: &[PyReadonlyArrayDyn<'_, f64>; 2]) -> PyResult<BodyState> {
    Ok(BodyState::from_coordinates(
        &numbers(positions, "state[0]")?,
        &numbers(velocities, "state[1]")?,
    ))
}

fn check_action(value: f64) -> PyResult<()> {
    if value.is_finite() {
        return Ok(());
    }
    Err(value_error(format!(
        "the action holds {value}, but both elements must be finite; what lies beyond [-1, 1] is limited to it"
    )))
}

fn check_command(omega_v: f64) -> PyResult<()> {
    if omega_v.abs() <= OMEGA_V_MAX {
        return Ok(());
    }
    Err(value_error(format!(
        "`omega_v` is {omega_v}, but it must be from -{OMEGA_V_MAX} to {OMEGA_V_MAX}"
    )))
}

/// A step of all environments as arrays: observations one row for each environment, `info` one row for each name.
fn vectors<'py>(
    py: Python<'py>,
    steps: &[VectorStep],
    task: &TaskParameters,
) -> PyResult<Vectors<'py>> {
    let count = steps.len();
    let array = |observations: &dyn Fn(&VectorStep) -> [f64; OBSERVATION_SIZE],
                 info: &dyn Fn(&VectorStep) -> [f64; INFO_WIDTH]| {
        let mut o = Array2::<f64>::zeros((count, OBSERVATION_SIZE));
        let mut i = Array2::<f64>::zeros((INFO_WIDTH, count));
        for (k, step) in steps.iter().enumerate() {
            o.row_mut(k).assign(&Array1::from_iter(observations(step)));
            i.column_mut(k).assign(&Array1::from_iter(info(step)));
        }
        (o.into_pyarray(py), i.into_pyarray(py))
    };
    let (observations, info) = array(&|step| step.observation, &|step| step.info);
    let begun = steps.iter().any(|step| step.last.is_some());
    let last = begun.then(|| {
        array(
            &|step| step.last.map_or([0.0; OBSERVATION_SIZE], |last| last.0),
            &|step| step.last.map_or([0.0; INFO_WIDTH], |last| last.1),
        )
    });
    let ended = steps.iter().any(|step| step.ended.is_some());
    let ended_by = ended.then(|| {
        let reasons = steps.iter().map(|step| step.ended);
        reasons
            .map(|reason| Some(task.end_name(reason?).to_owned()))
            .collect()
    });
    let flags = |flag: fn(&VectorStep) -> bool| PyArray1::from_iter(py, steps.iter().map(flag));
    Ok((
        observations,
        PyArray1::from_iter(py, steps.iter().map(|step| step.reward)),
        flags(|step| step.terminated),
        flags(|step| step.truncated),
        info,
        last,
        ended_by,
    ))
}
