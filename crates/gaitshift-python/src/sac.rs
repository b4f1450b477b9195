//! The learner alone, for any environment.

use crate::convert::{from_python, os_error, to_python, value_error};
use gaitshift_experiment::{sync_files, sync_folder};
use gaitshift_sac::{Agent, ReplayBuffer, SacConfig, SacError, Transitions, UpdateStats};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Between two looks for Ctrl-C during updates.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);
/// Most numbers that a replay buffer may hold: 64 GiB of them.
const NUMBERS_MAX: usize = 1 << 34;
/// By so much the way to the bounds of an environment and back may change an action.
const ROUNDING: f32 = 1e-5;
const AGENT: &str = "agent.safetensors";
const REPLAY: &str = "replay.safetensors";

/// See `_native.pyi`.
#[pyclass(module = "gaitshift._native")]
pub struct Sac {
    agent: Agent,
    replay: ReplayBuffer,
    /// What `act` drew last, and ln π of it.
    actions: Vec<f32>,
    log_probs: Vec<f32>,
}

fn sac_error(error: SacError) -> PyErr {
    match &error {
        SacError::File { path, source, .. } => os_error(source, path),
        SacError::Diverged { .. } => PyRuntimeError::new_err(error.to_string()),
        _ => value_error(error),
    }
}

#[pymethods]
impl Sac {
    #[new]
    fn new(
        observation_size: usize,
        action_size: usize,
        environments: usize,
        capacity: usize,
        seed: u64,
        settings: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let sizes = [
            ("observation_size", observation_size, 65_536),
            ("action_size", action_size, 65_536),
            ("environments", environments, 65_536),
            ("capacity", capacity, usize::MAX),
        ];
        for (name, value, most) in sizes {
            if !(1..=most).contains(&value) {
                let bound = if most == usize::MAX {
                    "1 or greater".to_owned()
                } else {
                    format!("from 1 to {most}")
                };
                return Err(value_error(format!(
                    "`{name}` is {value}, but it must be {bound}"
                )));
            }
        }
        let numbers = capacity.saturating_mul(2 * observation_size + action_size + 3);
        if numbers > NUMBERS_MAX {
            return Err(value_error(format!(
                "`capacity` is {capacity}, but a transition takes {} bytes here, and 64 GiB is the most; give a \
                 smaller one",
                4 * (2 * observation_size + action_size + 3)
            )));
        }
        let config: SacConfig = serde_json::from_value(from_python(settings, "settings")?)
            .map_err(|e| {
                value_error(gaitshift_experiment::did_you_mean(&format!(
                    "learner setting: {e}"
                )))
            })?;
        let agent =
            Agent::new(config, observation_size, action_size, None, seed).map_err(sac_error)?;
        let replay = ReplayBuffer::new(capacity, environments, observation_size, action_size)
            .map_err(sac_error)?;
        Ok(Self {
            agent,
            replay,
            actions: Vec::new(),
            log_probs: Vec::new(),
        })
    }

    #[staticmethod]
    fn load(folder: PathBuf) -> PyResult<Self> {
        let folder: PathBuf = folder.components().collect();
        recover(&folder).map_err(|e| os_error(&e, &folder))?;
        let agent = Agent::load(&folder.join(AGENT)).map_err(sac_error)?;
        let replay = ReplayBuffer::load(&folder.join(REPLAY)).map_err(sac_error)?;
        let sizes = |r: [usize; 2]| format!("observations of {} and actions of {}", r[0], r[1]);
        let of_agent = [agent.observation_size(), agent.action_size()];
        let of_replay = [replay.observation_size(), replay.action_size()];
        if of_agent != of_replay {
            return Err(value_error(format!(
                "{}: {AGENT} is for {}, {REPLAY} for {}; they were not saved together",
                folder.display(),
                sizes(of_agent),
                sizes(of_replay)
            )));
        }
        Ok(Self {
            agent,
            replay,
            actions: Vec::new(),
            log_probs: Vec::new(),
        })
    }

    /// The folder appears whole or not at all, and replaces one that was saved before.
    fn save(&self, py: Python<'_>, folder: PathBuf, more: Vec<(String, String)>) -> PyResult<()> {
        // Without a separator at its end, so that a name beside it can be formed.
        let folder: PathBuf = folder.components().collect();
        py.detach(|| {
            let io = |e: io::Error| os_error(&e, &folder);
            if folder.exists() && !folder.join(AGENT).exists() {
                return Err(value_error(format!(
                    "{} is there already and holds no saved learner; give another path",
                    folder.display()
                )));
            }
            let (new, old) = (beside(&folder, ".new"), beside(&folder, ".old"));
            remove(&new).map_err(io)?;
            fs::create_dir_all(&new).map_err(io)?;
            self.agent.save(&new.join(AGENT)).map_err(sac_error)?;
            self.replay.save(&new.join(REPLAY)).map_err(sac_error)?;
            for (name, text) in &more {
                fs::write(new.join(name), text).map_err(io)?;
            }
            // On the disk before it takes the place of the old one: after a loss of power too, one of them is whole.
            sync_files(&new).map_err(io)?;
            if folder.exists() {
                remove(&old).map_err(io)?;
                fs::rename(&folder, &old).map_err(io)?;
            }
            fs::rename(&new, &folder).map_err(io)?;
            sync_folder(folder.parent().unwrap_or(Path::new(""))).map_err(io)?;
            remove(&old).map_err(io)
        })
    }

    /// Rows of observations, one for each environment unless deterministic.
    fn act<'py>(
        &mut self,
        py: Python<'py>,
        observations: PyReadonlyArray2<'py, f32>,
        deterministic: bool,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let values: Vec<f32> = observations.as_array().iter().copied().collect();
        let (rows, size) = (observations.shape()[0], self.agent.action_size());
        let mut actions = vec![0.0; rows * size];
        if deterministic {
            let agent = &mut self.agent;
            py.detach(|| agent.act_deterministic(&values, &mut actions))
                .map_err(sac_error)?;
        } else {
            let mut log_probs = vec![0.0; rows];
            let agent = &mut self.agent;
            py.detach(|| agent.act(&values, &mut actions, &mut log_probs))
                .map_err(sac_error)?;
            self.actions.clone_from(&actions);
            self.log_probs = log_probs;
        }
        let actions = Array2::from_shape_vec((rows, size), actions).map_err(value_error)?;
        Ok(actions.into_pyarray(py))
    }

    fn observe(
        &mut self,
        observations: PyReadonlyArray2<'_, f32>,
        actions: PyReadonlyArray2<'_, f32>,
        rewards: PyReadonlyArray1<'_, f32>,
        next_observations: PyReadonlyArray2<'_, f32>,
        terminated: PyReadonlyArray1<'_, bool>,
        truncated: PyReadonlyArray1<'_, bool>,
    ) -> PyResult<()> {
        let matrix =
            |m: &PyReadonlyArray2<'_, f32>| m.as_array().iter().copied().collect::<Vec<f32>>();
        let (observations, mut actions) = (matrix(&observations), matrix(&actions));
        let next_observations = matrix(&next_observations);
        let rewards: Vec<f32> = rewards.as_array().iter().copied().collect();
        let flags =
            |v: &PyReadonlyArray1<'_, bool>| v.as_array().iter().copied().collect::<Vec<bool>>();
        let (terminated, truncated) = (flags(&terminated), flags(&truncated));
        let environments = self.replay.environments();
        let size = self.agent.action_size();
        // An action from elsewhere counts as drawn uniformly from [-1, 1]. Only sums over several rewards look at it.
        let uniform = -(size as f32) * std::f32::consts::LN_2;
        let mut log_probs = vec![uniform; environments];
        for (row, log_prob) in log_probs.iter_mut().enumerate() {
            let of_row = row * size..(row + 1) * size;
            if let (Some(taken), Some(own)) =
                (actions.get_mut(of_row.clone()), self.actions.get(of_row))
                && taken
                    .iter()
                    .zip(own)
                    .all(|(a, b)| (a - b).abs() <= ROUNDING)
            {
                taken.copy_from_slice(own);
                *log_prob = self.log_probs[row];
            }
        }
        self.replay
            .push(Transitions {
                observations: &observations,
                actions: &actions,
                log_probs: &log_probs,
                rewards: &rewards,
                next_observations: &next_observations,
                terminated: &terminated,
                truncated: &truncated,
                valid: &vec![true; environments],
            })
            .map_err(sac_error)
    }

    /// Means over the updates; α after them.
    fn update<'py>(&mut self, py: Python<'py>, count: u64) -> PyResult<Bound<'py, PyAny>> {
        let (agent, replay) = (&mut self.agent, &self.replay);
        let sums = py.detach(|| {
            let mut sums = UpdateStats::default();
            let mut next_look = Instant::now() + SIGNAL_INTERVAL;
            for _ in 0..count {
                let stats = agent.update(replay).map_err(sac_error)?;
                sums.critic_loss[0] += stats.critic_loss[0];
                sums.critic_loss[1] += stats.critic_loss[1];
                sums.mean_q += stats.mean_q;
                sums.actor_loss += stats.actor_loss;
                sums.entropy += stats.entropy;
                if Instant::now() >= next_look {
                    next_look = Instant::now() + SIGNAL_INTERVAL;
                    Python::attach(|py| py.check_signals())?;
                }
            }
            PyResult::Ok(sums)
        })?;
        let n = count.max(1) as f64;
        let told = serde_json::json!({
            "critic_loss": 0.5 * (sums.critic_loss[0] + sums.critic_loss[1]) / n,
            "actor_loss": sums.actor_loss / n,
            "mean_q": sums.mean_q / n,
            "entropy": sums.entropy / n,
            "alpha": self.agent.alpha(),
        });
        to_python(py, &told)
    }

    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.agent.config())
    }

    #[getter]
    fn sizes(&self) -> [usize; 4] {
        [
            self.agent.observation_size(),
            self.agent.action_size(),
            self.replay.environments(),
            self.replay.capacity(),
        ]
    }

    #[getter]
    fn updates(&self) -> u64 {
        self.agent.updates()
    }

    #[getter]
    fn stored(&self) -> usize {
        self.replay.valid_len()
    }

    /// What `act` drew last and `observe` may be given, with ln π of each row.
    #[getter]
    fn drawn(&self) -> (Vec<f32>, Vec<f32>) {
        (self.actions.clone(), self.log_probs.clone())
    }

    #[setter]
    fn set_drawn(&mut self, drawn: (Vec<f32>, Vec<f32>)) -> PyResult<()> {
        let (actions, log_probs) = drawn;
        let finite = actions.iter().chain(&log_probs).all(|v| v.is_finite());
        if actions.len() != log_probs.len() * self.agent.action_size() || !finite {
            return Err(value_error(
                "`drawn` does not hold one finite ln π for each action",
            ));
        }
        (self.actions, self.log_probs) = (actions, log_probs);
        Ok(())
    }

    fn set_learning_rate(&mut self, learning_rate: f64) -> PyResult<()> {
        self.agent
            .set_learning_rate(learning_rate)
            .map_err(sac_error)
    }
}

fn beside(folder: &Path, ending: &str) -> PathBuf {
    let mut name = folder.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}

fn remove(folder: &Path) -> io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// Finishes what a kill between the renames of a save left undone.
fn recover(folder: &Path) -> io::Result<()> {
    let old = beside(folder, ".old");
    if !folder.exists() && old.exists() {
        fs::rename(&old, folder)?;
    }
    Ok(())
}
