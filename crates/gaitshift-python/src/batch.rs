//! Environments stepped together, without Python in between: what both Gymnasium classes stand on.

use crate::controller::Controller;
use crate::convert::{body_and_task, to_python, value_error};
use gaitshift_body::{AdvanceReport, Body, BodyState, LEFT, RIGHT};
use gaitshift_experiment::{Simulation, recording_row};
use gaitshift_figures::Snapshot;
use gaitshift_task::{
    EndReason, Environment, OBSERVATION_SIZE, RewardTerms, StepOutcome, TaskParameters,
};
use gaitshift_view::{Server, Show, Stopper, ViewOptions, Watched};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyOSError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::net::{Ipv4Addr, SocketAddr};

/// Terms of the reward, without the symmetry term (7), which only a learner knows.
const TERMS: usize = RewardTerms::NAMES.len() - 1;
const INFO_SIZE: usize = 4 + TERMS + 16;

/// Names of the numbers in `info`: those of a recording's columns, and `diverged` at the end.
pub fn info_names() -> Vec<String> {
    let terms = RewardTerms::NAMES
        .iter()
        .filter(|name| **name != "symmetry");
    let rest = [
        "kinetic_energy_j",
        "gravitational_energy_j",
        "hip_spring_energy_j",
        "leg_spring_energy_j",
        "contact_energy_j",
        "stop_energy_j",
        "actuator_work_j",
        "actuator_positive_work_j",
        "damper_dissipation_j",
        "contact_dissipation_j",
        "stop_dissipation_j",
        "right_normal_force_n",
        "right_tangential_force_n",
        "left_normal_force_n",
        "left_tangential_force_n",
        "diverged",
    ];
    ["time_s", "omega_v", "x_m", "z_m"]
        .map(str::to_owned)
        .into_iter()
        .chain(terms.map(|name| format!("reward_{name}")))
        .chain(rest.map(str::to_owned))
        .collect()
}

/// How a vector environment goes on after an episode, as Gymnasium's `AutoresetMode`.
const NEXT_STEP: u8 = 0;
const SAME_STEP: u8 = 1;

/// How an episode begins.
#[derive(Debug, Clone, Copy)]
struct Opening {
    omega_v: Option<f64>,
    default_start: bool,
}

impl Opening {
    const DRAWN: Self = Self {
        omega_v: None,
        default_start: false,
    };
}

/// One environment with its own random numbers.
#[derive(Debug, Clone)]
struct Slot {
    environment: Environment,
    rng: Xoshiro256PlusPlus,
    /// The episode is over: the next step begins another.
    over: bool,
}

/// What one step of one environment gives.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    observation: [f64; OBSERVATION_SIZE],
    reward: f64,
    terminated: bool,
    truncated: bool,
    info: [f64; INFO_SIZE],
    /// Terms of the reward and mean forces, for whoever watches.
    terms: RewardTerms,
    report: AdvanceReport,
    /// Observation and info of the episode that ended within this step, where a new one has begun.
    last: Option<([f64; OBSERVATION_SIZE], [f64; INFO_SIZE])>,
}

/// What all environments share.
#[derive(Debug)]
struct Setting {
    body: Body,
    task: TaskParameters,
    omega_v: [f64; 2],
}

impl Setting {
    /// Begins an episode. The start is drawn before the command, so that a seed gives the start that the
    /// program's `--seed` gives.
    fn begin(&self, slot: &mut Slot, opening: Opening) -> Row {
        let start = if opening.default_start {
            Environment::default_start(&self.body, &self.task)
        } else {
            Environment::random_start(&self.body, &self.task, None, &mut slot.rng)
        };
        let [low, high] = self.omega_v;
        let omega_v = match opening.omega_v {
            Some(omega_v) => omega_v,
            None if low < high => low + (high - low) * slot.rng.random::<f64>(),
            None => low,
        };
        slot.environment = Environment::new(&self.body, start, omega_v);
        slot.over = false;
        let contact = [RIGHT, LEFT].map(|leg| self.body.foot_contact(&start, leg));
        let report = AdvanceReport {
            normal_n: contact.map(|c| c.normal_n),
            tangential_n: contact.map(|c| c.tangential_n),
            ..AdvanceReport::default()
        };
        Row {
            observation: slot.environment.observation(),
            info: self.info(&slot.environment, &RewardTerms::default(), &report, false),
            report,
            ..Row::default()
        }
    }

    fn step(&self, slot: &mut Slot, command: [f64; 2]) -> Row {
        let environment = &mut slot.environment;
        let before = environment.clone();
        let outcome: StepOutcome =
            environment.step(&self.body, &self.task, &self.task.reward, command);
        let diverged = outcome.ended == Some(EndReason::Diverged);
        if diverged {
            // Numbers that are none must not reach a learner: the last state that had any stays.
            *environment = before;
        }
        let report = if diverged {
            AdvanceReport::default()
        } else {
            outcome.report
        };
        slot.over = outcome.ended.is_some();
        Row {
            observation: environment.observation(),
            reward: outcome.factor * outcome.terms.sum(),
            terminated: outcome.ended.is_some_and(EndReason::is_termination),
            truncated: outcome.ended == Some(EndReason::TimeLimit),
            info: self.info(environment, &outcome.terms, &report, diverged),
            terms: outcome.terms,
            report,
            last: None,
        }
    }

    /// The numbers of `info`, in the order of their names.
    fn info(
        &self,
        environment: &Environment,
        terms: &RewardTerms,
        report: &AdvanceReport,
        diverged: bool,
    ) -> [f64; INFO_SIZE] {
        let s: &BodyState = &environment.state;
        let (energy, account) = (self.body.energy(s), &environment.account);
        let names = RewardTerms::NAMES.iter().zip(terms.values());
        let place = [
            f64::from(environment.periods) * self.task.control_period_s,
            environment.omega_v,
            s.x,
            s.z,
        ];
        let rest = [
            energy.kinetic,
            energy.gravitational,
            energy.hip_springs,
            energy.leg_springs(),
            energy.contact,
            energy.stops,
            account.work(),
            account.positive_work(),
            account.dampers(),
            account.contact(),
            account.stops,
            report.normal_n[RIGHT],
            report.tangential_n[RIGHT],
            report.normal_n[LEFT],
            report.tangential_n[LEFT],
            f64::from(u8::from(diverged)),
        ];
        let own = names.filter(|(name, _)| **name != "symmetry");
        let mut values = place.into_iter().chain(own.map(|term| term.1)).chain(rest);
        std::array::from_fn(|_| values.next().unwrap_or_default())
    }

    /// One step of one environment of a vector, with Gymnasium's automatic resets.
    fn vector_step(&self, slot: &mut Slot, command: [f64; 2], autoreset: u8) -> Row {
        if slot.over && autoreset == NEXT_STEP {
            return self.begin(slot, Opening::DRAWN);
        }
        let row = self.step(slot, command);
        if !(slot.over && autoreset == SAME_STEP) {
            return row;
        }
        let first = self.begin(slot, Opening::DRAWN);
        Row {
            observation: first.observation,
            info: first.info,
            last: Some((row.observation, row.info)),
            ..row
        }
    }
}

/// See `_native.pyi`.
#[pyclass(module = "gaitshift._native")]
pub struct Batch {
    setting: Setting,
    slots: Vec<Slot>,
    threads: usize,
    names: Vec<Py<PyString>>,
    shown: Option<Shown>,
}

/// The first environment on a page in the browser.
#[derive(Debug)]
struct Shown {
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
/// Observations, rewards, terminated, truncated, info, and observations and info of episodes that ended.
type Vectors<'py> = (
    Matrix<'py>,
    Vector<'py, f64>,
    Vector<'py, bool>,
    Vector<'py, bool>,
    Matrix<'py>,
    Option<(Matrix<'py>, Matrix<'py>)>,
);

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (count, omega_v, *, experiment = None, controller = None, body = None, task = None, threads = 1))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        count: i64,
        omega_v: [f64; 2],
        experiment: Option<&str>,
        controller: Option<&Controller>,
        body: Option<&Bound<'_, PyAny>>,
        task: Option<&Bound<'_, PyAny>>,
        threads: i64,
    ) -> PyResult<Self> {
        let controller = controller.map(|c| &c.controller);
        let (body, task) = body_and_task(experiment, controller, body, task)?;
        if !(omega_v.iter().all(|w| w.abs() <= 100.0) && omega_v[0] <= omega_v[1]) {
            return Err(value_error(format!(
                "`omega_v` is {omega_v:?}, but it must be a command from -100 to 100, or a pair (lowest, highest) of them"
            )));
        }
        let count = in_range("num_envs", count, 65_536)?;
        let threads = in_range("threads", threads, 256)?;
        let blank = Environment::new(&body, BodyState::standing(&body), 0.0);
        let slot = Slot {
            environment: blank,
            rng: Xoshiro256PlusPlus::seed_from_u64(0),
            over: false,
        };
        Ok(Self {
            slots: vec![slot; count],
            setting: Setting {
                body,
                task,
                omega_v,
            },
            threads,
            shown: None,
            names: info_names()
                .iter()
                .map(|name| PyString::new(py, name).unbind())
                .collect(),
        })
    }

    #[getter]
    fn body<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.setting.body.parameters())
    }

    #[getter]
    fn task<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.setting.task)
    }

    fn seed(&mut self, index: usize, seed: u64) -> PyResult<()> {
        self.slot(index)?.rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        Ok(())
    }

    #[getter]
    fn omega_v(&self) -> Vec<f64> {
        self.slots.iter().map(|s| s.environment.omega_v).collect()
    }

    /// The commands of all environments; none changes if one is out of range.
    #[setter]
    fn set_omega_v(&mut self, omega_v: Vec<f64>) -> PyResult<()> {
        if omega_v.len() != self.slots.len() {
            return Err(value_error(format!(
                "{} commands were given for {} environments",
                omega_v.len(),
                self.slots.len()
            )));
        }
        omega_v.iter().try_for_each(|&value| check_command(value))?;
        for (slot, value) in self.slots.iter_mut().zip(omega_v) {
            slot.environment.omega_v = value;
        }
        Ok(())
    }

    /// Serves a page on the loopback address that shows the first environment; gives its address. Steps and episodes
    /// of single environments are shown.
    fn watch(&mut self, name: &str) -> PyResult<String> {
        let setting = &self.setting;
        let options = ViewOptions {
            address: SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0),
            names: Vec::new(),
        };
        let server = Server::bind(&options).map_err(|e| PyOSError::new_err(e.to_string()))?;
        let start = BodyState::standing(&setting.body);
        let metadata = Simulation::new(&setting.body, &setting.task, start, 0.0).metadata(name, 0);
        let watched = Watched::new(name, setting.body.parameters(), metadata);
        let (url, stopper) = (server.url(), server.stopper());
        let show = Show::Watched(watched.clone());
        std::thread::Builder::new()
            .name("view".to_owned())
            .spawn(move || server.run(show))
            .map_err(|e| PyOSError::new_err(e.to_string()))?;
        self.shown = Some(Shown {
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
        let body = &self.setting.body;
        let slots = indices
            .iter()
            .map(|&index| {
                self.slots.get(index).ok_or_else(|| {
                    PyIndexError::new_err(format!("there is no environment {index}"))
                })
            })
            .collect::<PyResult<Vec<&Slot>>>()?;
        let period_s = self.setting.task.control_period_s;
        let draw = |environment: &Environment| {
            let state = &environment.state;
            let force_n = [RIGHT, LEFT].map(|leg| {
                let contact = body.foot_contact(state, leg);
                (contact.tangential_n, contact.normal_n)
            });
            Snapshot {
                body: body.parameters(),
                state,
                force_n,
                omega_v: environment.omega_v,
                time_s: f64::from(environment.periods) * period_s,
            }
            .draw(width_px)
        };
        let pictures = py.detach(|| {
            let drawn = slots.iter().map(|slot| draw(&slot.environment));
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
        &mut self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(Vector<'py, f64>, Vector<'py, f64>)> {
        let state = self.slot(index)?.environment.state;
        Ok((
            PyArray1::from_slice(py, &state.positions()),
            PyArray1::from_slice(py, &state.velocities()),
        ))
    }

    #[pyo3(signature = (index, omega_v = None, default_start = false))]
    fn reset_one<'py>(
        &mut self,
        py: Python<'py>,
        index: usize,
        omega_v: Option<f64>,
        default_start: bool,
    ) -> PyResult<(Vector<'py, f64>, Bound<'py, PyDict>)> {
        omega_v.map_or(Ok(()), check_command)?;
        self.slot(index)?;
        let opening = Opening {
            omega_v,
            default_start,
        };
        let row = self.setting.begin(&mut self.slots[index], opening);
        if index == 0 {
            if let Some(shown) = &self.shown {
                shown.watched.begin();
            }
            self.show([0.0; 2], &row);
        }
        Ok((
            PyArray1::from_slice(py, &row.observation),
            self.info(py, &row.info)?,
        ))
    }

    /// One step of the first environment.
    fn step_one<'py>(&mut self, py: Python<'py>, right: f64, left: f64) -> PyResult<OneStep<'py>> {
        check_action(right)?;
        check_action(left)?;
        let row = py.detach(|| self.setting.step(&mut self.slots[0], [right, left]));
        self.show([right, left].map(|c| c.clamp(-1.0, 1.0)), &row);
        Ok((
            PyArray1::from_slice(py, &row.observation),
            row.reward,
            row.terminated,
            row.truncated,
            self.info(py, &row.info)?,
        ))
    }

    /// Begins an episode in every environment that `mask` names.
    fn reset_all<'py>(
        &mut self,
        py: Python<'py>,
        mask: Vec<bool>,
        omega_v: Option<f64>,
        default_start: bool,
    ) -> PyResult<(Matrix<'py>, Matrix<'py>)> {
        omega_v.map_or(Ok(()), check_command)?;
        if mask.len() != self.slots.len() {
            return Err(value_error(format!(
                "the mask has {} elements for {} environments",
                mask.len(),
                self.slots.len()
            )));
        }
        let opening = Opening {
            omega_v,
            default_start,
        };
        let report = AdvanceReport::default();
        let rows: Vec<Row> = self
            .slots
            .iter_mut()
            .zip(mask)
            .map(|(slot, begin)| {
                if begin {
                    return self.setting.begin(slot, opening);
                }
                let environment = &slot.environment;
                let terms = RewardTerms::default();
                Row {
                    observation: environment.observation(),
                    info: self.setting.info(environment, &terms, &report, false),
                    ..Row::default()
                }
            })
            .collect();
        let (observations, _, _, _, info, _) = vectors(py, &rows)?;
        Ok((observations, info))
    }

    /// One step of every environment, without the interpreter's lock.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
        autoreset: u8,
    ) -> PyResult<Vectors<'py>> {
        let count = self.slots.len();
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
        let Self {
            setting,
            slots,
            threads,
            ..
        } = self;
        let mut rows = vec![Row::default(); count];
        py.detach(|| {
            let share = count.div_ceil(*threads);
            let work = |slots: &mut [Slot], commands: &[[f64; 2]], rows: &mut [Row]| {
                for ((slot, command), row) in slots.iter_mut().zip(commands).zip(rows) {
                    *row = setting.vector_step(slot, *command, autoreset);
                }
            };
            if share >= count {
                return work(slots, &commands, &mut rows);
            }
            std::thread::scope(|scope| {
                for ((slots, commands), rows) in slots
                    .chunks_mut(share)
                    .zip(commands.chunks(share))
                    .zip(rows.chunks_mut(share))
                {
                    scope.spawn(move || work(slots, commands, rows));
                }
            });
        });
        vectors(py, &rows)
    }
}

impl Batch {
    /// Shows the first environment after a step, if anyone watches.
    fn show(&mut self, command: [f64; 2], row: &Row) {
        if let (Some(shown), Some(slot)) = (&mut self.shown, self.slots.first()) {
            let (setting, environment) = (&self.setting, &slot.environment);
            let time_s = f64::from(environment.periods) * setting.task.control_period_s;
            recording_row(
                &setting.body,
                environment,
                time_s,
                command,
                &row.report,
                &row.terms,
                &mut shown.row,
            );
            shown.watched.push(&shown.row);
        }
    }

    fn slot(&mut self, index: usize) -> PyResult<&mut Slot> {
        let count = self.slots.len();
        self.slots.get_mut(index).ok_or_else(|| {
            PyIndexError::new_err(format!(
                "there is no environment {index}, only 0 to {}",
                count - 1
            ))
        })
    }

    fn info<'py>(
        &self,
        py: Python<'py>,
        values: &[f64; INFO_SIZE],
    ) -> PyResult<Bound<'py, PyDict>> {
        let info = PyDict::new(py);
        let (diverged, numbers) = (values[INFO_SIZE - 1] != 0.0, &values[..INFO_SIZE - 1]);
        for (name, value) in self.names.iter().zip(numbers) {
            info.set_item(name, value)?;
        }
        info.set_item(&self.names[INFO_SIZE - 1], diverged)?;
        Ok(info)
    }
}

fn in_range(name: &str, value: i64, most: usize) -> PyResult<usize> {
    usize::try_from(value)
        .ok()
        .filter(|value| (1..=most).contains(value))
        .ok_or_else(|| {
            value_error(format!(
                "`{name}` is {value}, but it must be from 1 to {most}"
            ))
        })
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
    if omega_v.abs() <= 100.0 {
        return Ok(());
    }
    Err(value_error(format!(
        "`omega_v` is {omega_v}, but it must be from -100 to 100"
    )))
}

/// Rows of all environments as arrays: one row for each environment, `info` one row for each name.
fn vectors<'py>(py: Python<'py>, rows: &[Row]) -> PyResult<Vectors<'py>> {
    let count = rows.len();
    let array = |observations: &dyn Fn(&Row) -> [f64; OBSERVATION_SIZE],
                 info: &dyn Fn(&Row) -> [f64; INFO_SIZE]| {
        let mut o = Array2::<f64>::zeros((count, OBSERVATION_SIZE));
        let mut i = Array2::<f64>::zeros((INFO_SIZE, count));
        for (k, row) in rows.iter().enumerate() {
            o.row_mut(k).assign(&Array1::from_iter(observations(row)));
            i.column_mut(k).assign(&Array1::from_iter(info(row)));
        }
        (o.into_pyarray(py), i.into_pyarray(py))
    };
    let (observations, info) = array(&|row| row.observation, &|row| row.info);
    let ended = rows.iter().any(|row| row.last.is_some());
    let last = ended.then(|| {
        array(
            &|row| row.last.map_or([0.0; OBSERVATION_SIZE], |last| last.0),
            &|row| row.last.map_or([0.0; INFO_SIZE], |last| last.1),
        )
    });
    let flags = |flag: fn(&Row) -> bool| PyArray1::from_iter(py, rows.iter().map(flag));
    Ok((
        observations,
        PyArray1::from_iter(py, rows.iter().map(|row| row.reward)),
        flags(|row| row.terminated),
        flags(|row| row.truncated),
        info,
        last,
    ))
}
