//! The controller file: one safetensors file with the policy's networks and, in its metadata, the
//! body, the task and the provenance. It needs nothing else to run.

use crate::config::{nearest, question};
use crate::durable;
use crate::provenance::Provenance;
use crate::simulation::Control;
use crate::tensors;
use gaitshift_body::BodyParameters;
use gaitshift_sac::{MlpShape, Policy};
use gaitshift_task::{
    ACTION_SIZE, OBSERVATION_NAMES, OBSERVATION_SCALE, OBSERVATION_SIZE, TaskParameters,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Version of the controller file's metadata.
const FORMAT: &str = "gaitshift-controller 1";

/// A trained policy with the body and task it was trained for.
#[derive(Debug, Clone)]
pub struct Controller {
    /// The policy: 14 scaled observations in, two commands in [-1, 1] out.
    pub policy: Policy,
    /// The body it was trained on.
    pub body: BodyParameters,
    /// The task it was trained for.
    pub task: TaskParameters,
    /// Where it comes from.
    pub provenance: Provenance,
}

/// A controller file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} the controller {}: {cause}; {remedy}", path.display())]
pub struct ControllerError {
    /// What was tried: "use" or "write".
    pub action: &'static str,
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub cause: String,
    /// What to do.
    pub remedy: &'static str,
}

const REMEDY: &str = "give a controller.safetensors that `gaitshift train` wrote, the folder of its run, or `shipped` or `robust`, which \
                      come with the program";

#[derive(Serialize, Deserialize)]
struct Description {
    format: String,
    network: MlpShape,
    observation_names: Vec<String>,
    observation_scale: Vec<f32>,
    body: BodyParameters,
    task: TaskParameters,
    provenance: Provenance,
}

impl Controller {
    /// The file's bytes.
    ///
    /// # Errors
    /// As a text, if the policy cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>, String> {
        let description = Description {
            format: FORMAT.to_owned(),
            network: self.policy.shape().clone(),
            observation_names: OBSERVATION_NAMES.map(str::to_owned).to_vec(),
            observation_scale: OBSERVATION_SCALE.to_vec(),
            body: self.body.clone(),
            task: self.task.clone(),
            provenance: self.provenance.clone(),
        };
        let json = serde_json::to_string(&description).map_err(|e| e.to_string())?;
        tensors::to_bytes(&self.policy.tensors(), json)
    }

    /// Writes the file; a kill at any moment leaves the old one or the new one.
    ///
    /// # Errors
    /// The file system's.
    pub fn write(&self, path: &Path) -> Result<(), ControllerError> {
        let error = |cause: String| ControllerError {
            action: "write",
            path: path.to_owned(),
            cause,
            remedy: "check that the folder exists and can be written, and that its disk has room",
        };
        let bytes = self.to_bytes().map_err(error)?;
        durable::write(path, &bytes).map_err(|e| error(e.to_string()))
    }

    /// Reads a file, or the best controller so far of a run's folder, see [`Controller::file_of`]; or takes the one that comes
    /// with the program under this name, see [`Controller::names`].
    ///
    /// # Errors
    /// A file that is missing, truncated, foreign, or of other sizes.
    pub fn read(path: &Path) -> Result<Self, ControllerError> {
        if let Some(bytes) = Self::of_name(path) {
            return Self::from_bytes(bytes, path);
        }
        let path = &Self::file_of(path);
        let bytes = std::fs::read(path).map_err(|e| {
            let meant = path.to_str().and_then(|name| nearest(name, Self::names()));
            let question =
                meant.map_or_else(String::new, |name| format!(" ({})", question(&[name])));
            let cause = if path.is_dir() {
                "it is a folder without a controller.safetensors".to_owned()
            } else {
                format!("{e}{question}")
            };
            ControllerError {
                action: "use",
                path: path.to_owned(),
                cause,
                remedy: REMEDY,
            }
        })?;
        Self::from_bytes(&bytes, path)
    }

    /// The controller's file that a path stands for: of a run's folder `controller.safetensors`, before its first
    /// evaluation `controller-last.safetensors`; of everything else the path itself.
    pub fn file_of(path: &Path) -> PathBuf {
        ["controller.safetensors", "controller-last.safetensors"]
            .into_iter()
            .map(|name| path.join(name))
            .find(|file| file.is_file())
            .unwrap_or_else(|| path.to_owned())
    }

    /// The run's folder that a path stands for where a controller is asked for, if it is one: not a controller's file, and not the
    /// name of one that comes with the program, whatever folder has that name.
    pub fn run_of(path: &Path) -> Option<&Path> {
        let is_run = !Self::is_name(path) && path.join("config.toml").is_file();
        is_run.then_some(path)
    }

    /// Whether a path is a run's folder whose controller was never evaluated: what stands for it is the last one, not the best.
    pub fn is_unevaluated(path: &Path) -> bool {
        let is_folder = !Self::is_name(path) && path.is_dir();
        is_folder && Self::file_of(path).ends_with("controller-last.safetensors")
    }

    /// Reads the bytes of a file; `path` names it in errors.
    ///
    /// # Errors
    /// As [`Controller::read`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, ControllerError> {
        let error = |cause: String| ControllerError {
            action: "use",
            path: path.to_owned(),
            cause,
            remedy: REMEDY,
        };
        let of_checkpoint = path
            .parent()
            .is_some_and(|folder| folder.ends_with("checkpoint"));
        let json = tensors::text(bytes).map_err(|cause| match of_checkpoint {
            true => error(
                "it is part of a checkpoint; the run's folder stands for its controller".to_owned(),
            ),
            false => error(cause),
        })?;
        let damaged_metadata =
            |e: serde_json::Error| error(format!("its metadata is damaged: {e}"));
        let mut description: Value = serde_json::from_str(&json).map_err(damaged_metadata)?;
        let format = description.get("format").and_then(Value::as_str);
        if let Some(format) = format.filter(|format| *format != FORMAT) {
            return Err(error(format!(
                "its format is `{format}`, this program reads `{FORMAT}`"
            )));
        }
        take_out_gone_keys(&mut description).map_err(error)?;
        let description: Description =
            serde_json::from_value(description).map_err(damaged_metadata)?;
        let file = tensors::open(bytes).map_err(error)?;
        let shape = &description.network;
        let sizes = (shape.inputs, shape.outputs);
        if sizes != (OBSERVATION_SIZE, 2 * ACTION_SIZE) {
            return Err(error(format!(
                "its network has {} inputs and {} outputs instead of {OBSERVATION_SIZE} and {}",
                sizes.0,
                sizes.1,
                2 * ACTION_SIZE
            )));
        }
        if shape.layer_norm {
            return Err(error(
                "its network has layer normalisation, which this version does not know: use the one that trained it"
                    .to_owned(),
            ));
        }
        // Before memory is set aside for what the metadata promise.
        let held: usize = file.iter().map(|(_, view)| view.data().len() / 4).sum();
        if parameter_count(shape) != Some(held) {
            return Err(error(format!(
                "its layers {:?} are not those of its tensors, which hold {held} numbers",
                shape.hidden
            )));
        }
        let tensors = tensors::tensors(&file).map_err(error)?;
        let policy = Policy::from_tensors(description.network.clone(), &tensors)
            .map_err(|e| error(e.to_string()))?;
        let names = &description.observation_names;
        if names.len() != OBSERVATION_SIZE {
            return Err(error(format!(
                "its metadata name {} observations instead of {OBSERVATION_SIZE}",
                names.len()
            )));
        }
        let mut named = names.iter().zip(OBSERVATION_NAMES);
        if let Some((its, ours)) = named.find(|(its, ours)| its != ours) {
            return Err(error(format!(
                "it observes `{its}` where this version has `{ours}`: use the one that trained it"
            )));
        }
        if description.observation_scale != OBSERVATION_SCALE {
            return Err(error(
                "its observation scale is not this program's".to_owned(),
            ));
        }
        description
            .body
            .validate()
            .map_err(|e| error(e.to_string()))?;
        description
            .task
            .validate(&description.body)
            .map_err(|e| error(e.to_string()))?;
        Ok(Self {
            policy,
            body: description.body,
            task: description.task,
            provenance: description.provenance,
        })
    }
}

/// Keys of the reward in controllers of earlier versions: whether one other than 0 would change the reward.
const GONE: [(&str, bool); 10] = [
    ("alive_command_factor", true),
    ("energy_command_divisor", true),
    ("energy_reference_period_s", true),
    ("entropy_command_divisor", false),
    ("entropy_share_at_zero", false),
    ("horizon_command_divisor", false),
    ("horizon_share_floor", false),
    ("omega_e_floor", true),
    // It scaled reward and entropy bonus alike.
    ("scale", false),
    ("speed_limit_m_per_s", true),
];

/// Takes out what earlier versions wrote of the reward and this one does not know.
fn take_out_gone_keys(description: &mut Value) -> Result<(), String> {
    let reward = description.pointer_mut("/task/reward");
    let Some(reward) = reward.and_then(Value::as_object_mut) else {
        return Ok(());
    };
    for (key, changes) in GONE {
        let value = reward.remove(key);
        if changes && value.is_some_and(|v| v.as_f64() != Some(0.0)) {
            return Err(format!(
                "its reward has `{key}`, which this version does not know: use the one that trained it"
            ));
        }
    }
    Ok(())
}

/// How many numbers a network of this shape holds; none if they cannot be counted.
fn parameter_count(shape: &MlpShape) -> Option<usize> {
    let (mut inputs, mut count) = (shape.inputs, 0_usize);
    for &units in shape.hidden.iter().chain([&shape.outputs]) {
        let each = inputs.checked_add(1)?;
        count = count.checked_add(units.checked_mul(each)?)?;
        inputs = units;
    }
    Some(count)
}

/// Runs a policy without noise.
#[derive(Debug)]
pub struct Deterministic<'a>(pub &'a mut Policy);

impl Control for Deterministic<'_> {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        // The lengths are right by their types.
        let _ = self.0.mean_action(observation, action);
    }
}
