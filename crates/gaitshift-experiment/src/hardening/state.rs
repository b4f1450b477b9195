//! What the next round begins with, as one safetensors file.

use super::case::Pairs;
use super::{Hardening, HardeningPlan, HardeningRound};
use crate::durable;
use crate::tensors;
use crate::training_error::{TrainingError, io_error};
use gaitshift_sac::{MlpShape, NamedTensor, Policy};
use gaitshift_task::{ACTION_SIZE, OBSERVATION_SIZE};
use serde::{Deserialize, Serialize};
use std::io;
use std::path::PathBuf;

const FORMAT: &str = "gaitshift-hardening 4";
const KINDS: [&str; 4] = ["push.found", "push.alone", "step_up.found", "step_up.alone"];
/// Before the names of the best policy's tensors.
const BEST: &str = "best.";
/// What else such a folder holds.
const FILES: [&str; 3] = [
    "controller.safetensors",
    "controller-last.safetensors",
    "rounds.jsonl",
];

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    plan: HardeningPlan,
    /// Of the controller as it was.
    controller_crc32c: String,
    network: MlpShape,
    rounds: Vec<HardeningRound>,
    /// Rounds whose pairs are here.
    remembered: usize,
}

impl Hardening {
    fn state_path(&self) -> PathBuf {
        self.folder.join("state.safetensors")
    }

    fn error(&self, cause: String) -> TrainingError {
        TrainingError::other(&self.state_path(), cause)
    }

    fn original_crc32c(&self) -> Result<String, TrainingError> {
        let bytes = self.original.to_bytes().map_err(|e| self.error(e))?;
        Ok(format!("{:08x}", crc32c::crc32c(&bytes)))
    }

    /// That nothing lies there that would be taken for this, or lost.
    pub(super) fn require_empty(&self) -> Result<(), TrainingError> {
        for name in FILES {
            if self.folder.join(name).exists() {
                return Err(TrainingError::other(
                    &self.folder,
                    format!("already holds {name}, which is of something else; give another --out"),
                ));
            }
        }
        Ok(())
    }

    pub(super) fn save(&self) -> Result<(), TrainingError> {
        let header = Header {
            format: FORMAT.to_owned(),
            plan: self.plan.clone(),
            controller_crc32c: self.original_crc32c()?,
            network: self.policy.shape().clone(),
            rounds: self.rounds.clone(),
            remembered: self.pushes.found.len(),
        };
        let mut tensors = self.policy.tensors();
        tensors.extend(self.best.tensors().into_iter().map(|tensor| NamedTensor {
            name: format!("{BEST}{}", tensor.name),
            ..tensor
        }));
        let (pushes, steps_up) = (&self.pushes, &self.steps_up);
        let remembered = [
            &pushes.found,
            &pushes.alone,
            &steps_up.found,
            &steps_up.alone,
        ];
        for (kind, rounds) in KINDS.into_iter().zip(remembered) {
            for (round, pairs) in rounds.iter().enumerate() {
                let values = [&pairs.observations, &pairs.actions];
                let sizes = [OBSERVATION_SIZE, ACTION_SIZE];
                for ((of, values), size) in PARTS.into_iter().zip(values).zip(sizes) {
                    tensors.push(NamedTensor {
                        name: name(kind, round, of),
                        shape: vec![pairs.rows(), size],
                        values: values.clone(),
                    });
                }
            }
        }
        let json = serde_json::to_string(&header).map_err(|e| self.error(e.to_string()))?;
        let bytes = tensors::to_bytes(&tensors, json).map_err(|e| self.error(e))?;
        let path = self.state_path();
        durable::write(&path, &bytes).map_err(io_error(&path))
    }

    /// Takes up what the folder holds, if it holds anything.
    pub(super) fn restore(&mut self) -> Result<bool, TrainingError> {
        let path = self.state_path();
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(false),
            Err(e) => return Err(io_error(&path)(e)),
        };
        let foreign = |cause: String| {
            TrainingError::other(
                &path,
                format!("{cause}; restore it from a copy, or give another --out"),
            )
        };
        let json = tensors::text(&bytes).map_err(foreign)?;
        let header: Header = serde_json::from_str(&json)
            .map_err(|e| foreign(format!("its metadata are damaged: {e}")))?;
        if header.format != FORMAT {
            return Err(foreign(format!(
                "its format is `{}`, this program reads `{FORMAT}`",
                header.format
            )));
        }
        if header.plan != self.plan || header.controller_crc32c != self.original_crc32c()? {
            return Err(TrainingError::other(
                &self.folder,
                "holds the hardening of another controller, or with other commands, disturbances, hidden units or seed; give the \
                 same, or another --out"
                    .to_owned(),
            ));
        }
        let held = tensors::open(&bytes)
            .and_then(|file| tensors::tensors(&file))
            .map_err(foreign)?;
        if header.network != *self.policy.shape() {
            return Err(foreign("it has a network of other sizes".to_owned()));
        }
        let best: Vec<_> = held
            .iter()
            .filter_map(|tensor| {
                Some(NamedTensor {
                    name: tensor.name.strip_prefix(BEST)?.to_owned(),
                    ..tensor.clone()
                })
            })
            .collect();
        let policy = |tensors: &[NamedTensor<f32>]| {
            Policy::from_tensors(header.network.clone(), tensors)
                .map_err(|e| foreign(e.to_string()))
        };
        (self.policy, self.best) = (policy(&held)?, policy(&best)?);
        let values = |name: String, size: usize| {
            let tensor = held.iter().find(|tensor| tensor.name == name);
            let of_size = tensor.filter(|tensor| matches!(tensor.shape[..], [_, s] if s == size));
            let values = of_size.map(|tensor| tensor.values.clone());
            values.ok_or_else(|| foreign(format!("it lacks `{name}`, or has another size of it")))
        };
        let (pushes, steps_up) = (&mut self.pushes, &mut self.steps_up);
        let remembered = [
            &mut pushes.found,
            &mut pushes.alone,
            &mut steps_up.found,
            &mut steps_up.alone,
        ];
        for (kind, rounds) in KINDS.into_iter().zip(remembered) {
            for round in 0..header.remembered {
                let [observations, actions] = [0, 1].map(|k| {
                    let size = [OBSERVATION_SIZE, ACTION_SIZE][k];
                    values(name(kind, round, PARTS[k]), size)
                });
                let pairs = Pairs {
                    observations: observations?,
                    actions: actions?,
                };
                if pairs.rows() * OBSERVATION_SIZE != pairs.observations.len() {
                    return Err(foreign(format!(
                        "it has pairs of other sizes in round {round}"
                    )));
                }
                rounds.push(pairs);
            }
        }
        if header.rounds.is_empty() {
            return Err(foreign("it has no rounds".to_owned()));
        }
        self.rounds = header.rounds;
        Ok(true)
    }
}

const PARTS: [&str; 2] = ["observations", "actions"];

fn name(kind: &str, round: usize, part: &str) -> String {
    format!("{kind}.{round:02}.{part}")
}
