//! The mechanism alone. The texts for `help` stand here and, for editors, in `_native.pyi`.

use crate::convert::{in_range, numbers, to_python, value_error, warn, with_overrides};
use gaitshift_body::{BodyParameters, BodyState, EnergyAccount};
use gaitshift_task::{Disturbance, RewardTerms, StepEnergies, TaskParameters, TerrainParameters};
use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;

type Array<'py> = PyReadonlyArrayDyn<'py, f64>;
type Eleven<'py> = Bound<'py, PyArray1<f64>>;

/// Longest stretch for one call of `advance`, in steps: an hour at the default step.
const MOST_STEPS: u32 = 18_000_000;

/// The mechanism alone: no task, no controller.
///
/// `parameters` are those that differ from the default body's (keys of `[body]`); ValueError for an unknown one or a
/// value out of range. `terrain` is the ground where it is not flat, with the keys of `[terrain]` of a disturbance:
/// slope_rad, slope_from_m, steps, uneven.
///
/// Positions and velocities are arrays of shape (11,), float64: x, z, theta, then phi, h, d, w of the right leg and of
/// the left one (m, rad, m/s, rad/s).
#[pyclass(module = "gaitshift", frozen)]
pub struct Body {
    body: gaitshift_body::Body,
    terrain: TerrainParameters,
}

fn state(positions: &Array<'_>, velocities: &Array<'_>) -> PyResult<BodyState> {
    Ok(BodyState::from_coordinates(
        &numbers(positions, "positions")?,
        &numbers(velocities, "velocities")?,
    ))
}

#[pymethods]
impl Body {
    #[new]
    #[pyo3(signature = (parameters = None, terrain = None))]
    fn new(
        py: Python<'_>,
        parameters: Option<&Bound<'_, PyAny>>,
        terrain: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let parameters: BodyParameters =
            with_overrides(&BodyParameters::default(), parameters, "parameters")?;
        warn(py, &parameters.warnings(), 1)?;
        let ground = Disturbance {
            terrain: with_overrides(&TerrainParameters::default(), terrain, "terrain")?,
            ..Disturbance::default()
        };
        ground.validate().map_err(value_error)?;
        let body = gaitshift_body::Body::new(parameters).map_err(value_error)?;
        Ok(Self {
            body: ground.place(body),
            terrain: ground.terrain,
        })
    }

    /// All parameters.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.body.parameters())
    }

    /// The body as MJCF, the model format of MuJoCo; `qpos` and `qvel` are positions and velocities. `task` holds
    /// parameters that differ from the default task, whose default start and control period the file has as the keyframe
    /// `start` and the numeric `control_period_s`. The body of a controller: `Body(controller.body).mjcf(controller.task)`.
    /// `actuator_factor` is the share of its force that the right and the left actuator still have, `latency_s` the delay
    /// from command to force, in s. ValueError for an unknown key or a value out of range.
    #[pyo3(signature = (task = None, *, actuator_factor = [1.0; 2], latency_s = 0.0))]
    fn mjcf(
        &self,
        task: Option<&Bound<'_, PyAny>>,
        actuator_factor: [f64; 2],
        latency_s: f64,
    ) -> PyResult<String> {
        let task: TaskParameters = with_overrides(&TaskParameters::default(), task, "task")?;
        task.validate(self.body.parameters()).map_err(value_error)?;
        let disturbance = Disturbance {
            actuator_factor,
            latency_s,
            terrain: self.terrain.clone(),
            ..Disturbance::default()
        };
        disturbance.validate().map_err(value_error)?;
        gaitshift_export::mjcf(self.body.parameters(), &task, &disturbance).map_err(value_error)
    }

    /// Accelerations of the 11 coordinates (m/s², rad/s²) under the actuators' forces, shape (2,), in N.
    fn accelerations<'py>(
        &self,
        py: Python<'py>,
        positions: Array<'py>,
        velocities: Array<'py>,
        actuator_n: Array<'py>,
    ) -> PyResult<Eleven<'py>> {
        let state = state(&positions, &velocities)?;
        let force = numbers(&actuator_n, "actuator_n")?;
        let accelerations = self.body.accelerations(&state, force).coordinates();
        Ok(PyArray1::from_slice(py, &accelerations))
    }

    /// Integrates `steps` steps of `time_step_s` under a constant command, shape (2,), limited to [-1, 1].
    ///
    /// Returns positions, velocities and a report: means of the forces in N, right and left, and the account of
    /// works and losses in J. The lock of the interpreter is not held.
    fn advance<'py>(
        &self,
        py: Python<'py>,
        positions: Array<'py>,
        velocities: Array<'py>,
        command: Array<'py>,
        steps: i64,
    ) -> PyResult<(Eleven<'py>, Eleven<'py>, Bound<'py, PyDict>)> {
        let mut state = state(&positions, &velocities)?;
        let command = numbers(&command, "command")?;
        let steps = in_range("steps", steps, 0..=MOST_STEPS)?;
        let mut account = EnergyAccount::default();
        let report = py.detach(|| self.body.advance(&mut state, command, steps, &mut account));
        let out = PyDict::new(py);
        out.set_item("diverged", report.diverged)?;
        out.set_item("actuator_n", report.actuator_n.to_vec())?;
        out.set_item("normal_n", report.normal_n.to_vec())?;
        out.set_item("tangential_n", report.tangential_n.to_vec())?;
        out.set_item("account", to_python(py, &account)?)?;
        Ok((
            PyArray1::from_slice(py, &state.positions()),
            PyArray1::from_slice(py, &state.velocities()),
            out,
        ))
    }

    /// Energies in J: kinetic, gravitational, hip_springs, leg_springs, elastic, contact, stops, total.
    fn energy<'py>(
        &self,
        py: Python<'py>,
        positions: Array<'py>,
        velocities: Array<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let energy = self.body.energy(&state(&positions, &velocities)?);
        let out = PyDict::new(py);
        for (name, value) in [
            ("kinetic", energy.kinetic),
            ("gravitational", energy.gravitational),
            ("hip_springs", energy.hip_springs),
            ("leg_springs", energy.leg_springs()),
            ("elastic", energy.elastic()),
            ("contact", energy.contact),
            ("stops", energy.stops),
            ("total", energy.total()),
        ] {
            out.set_item(name, value)?;
        }
        Ok(out)
    }

    /// What the ground does to the right and the left foot: tangential_n, normal_n (N), moment_nm about the hip axis
    /// (N m), elastic_j (J), normal_loss_w and friction_loss_w (W).
    fn foot_contact<'py>(
        &self,
        py: Python<'py>,
        positions: Array<'py>,
        velocities: Array<'py>,
    ) -> PyResult<[Bound<'py, PyDict>; 2]> {
        let state = state(&positions, &velocities)?;
        let foot = |leg| {
            let contact = self.body.foot_contact(&state, leg);
            let out = PyDict::new(py);
            out.set_item("tangential_n", contact.tangential_n)?;
            out.set_item("normal_n", contact.normal_n)?;
            out.set_item("moment_nm", contact.moment_nm)?;
            out.set_item("elastic_j", contact.elastic_j)?;
            out.set_item("normal_loss_w", contact.normal_loss_w)?;
            out.set_item("friction_loss_w", contact.friction_loss_w)?;
            Ok::<_, PyErr>(out)
        };
        Ok([foot(0)?, foot(1)?])
    }

    /// Height of the ground in m at `x`.
    fn ground_height(&self, x: f64) -> f64 {
        self.body.ground_height(x)
    }

    /// Height of the hip axis in m at which the lower sole just touches the ground.
    fn lowest_hip_height(&self, positions: Array<'_>) -> PyResult<f64> {
        let positions = numbers(&positions, "positions")?;
        let state = BodyState::from_coordinates(&positions, &[0.0; 11]);
        Ok(self.body.lowest_hip_height(&state))
    }
}

/// The weighted terms of the reward of a period that ended in a state, before the common factor.
///
/// `task` holds parameters that differ from the default task; `energy_change_j` is the change of the body's total
/// energy over the period, `friction_loss_j` what friction took, `positive_work_j` the actuators' positive work. Terms of
/// one's own (`task["reward"]["extra"]`) are not among them.
#[pyfunction]
#[pyo3(signature = (task, positions, velocities, omega_v, *, energy_change_j, friction_loss_j, positive_work_j))]
#[allow(clippy::too_many_arguments)]
pub fn reward_terms<'py>(
    py: Python<'py>,
    task: &Bound<'py, PyAny>,
    positions: Array<'py>,
    velocities: Array<'py>,
    omega_v: f64,
    energy_change_j: f64,
    friction_loss_j: f64,
    positive_work_j: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let task: TaskParameters = with_overrides(&TaskParameters::default(), Some(task), "task")?;
    let energies = StepEnergies {
        change_j: energy_change_j,
        friction_loss_j,
        positive_work_j,
    };
    let terms = task
        .reward
        .terms(&state(&positions, &velocities)?, &energies, omega_v);
    let named = PyDict::new(py);
    for (name, value) in RewardTerms::NAMES.iter().zip(terms.values()) {
        named.set_item(name, value)?;
    }
    Ok(named)
}
