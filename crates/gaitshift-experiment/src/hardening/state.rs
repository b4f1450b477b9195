//! What the next round begins with, as one safetensors file.

use super::case::Pairs;
use super::{Hardening, HardeningPlan, HardeningRound};
use crate::durable;
use crate::training_error::{TrainingError, io_error};
use gaitshift_sac::{MlpShape, NamedTensor, Policy};
use gaitshift_task::{ACTION_SIZE, OBSERVATION_SIZE};
use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io;
use std::path::PathBuf;

const FORMAT: &str = "gaitshift-hardening 1";
const KEY: &str = "gaitshift";
const KINDS: [&str; 2] = ["found", "alone"];
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
            remembered: self.found.len(),
        };
        let mut tensors = self.policy.tensors();
        for (kind, rounds) in KINDS.into_iter().zip([&self.found, &self.alone]) {
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
        let bytes: Vec<Vec<u8>> = tensors
            .iter()
            .map(|t| t.values.iter().flat_map(|v| v.to_le_bytes()).collect())
            .collect();
        let views = tensors
            .iter()
            .zip(&bytes)
            .map(|(t, bytes)| {
                let view = TensorView::new(Dtype::F32, t.shape.clone(), bytes)?;
                Ok((t.name.as_str(), view))
            })
            .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()
            .map_err(|e| self.error(e.to_string()))?;
        let json = serde_json::to_string(&header).map_err(|e| self.error(e.to_string()))?;
        let metadata = HashMap::from([(KEY.to_owned(), json)]);
        let bytes =
            safetensors::serialize(views, Some(metadata)).map_err(|e| self.error(e.to_string()))?;
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
        let (_, metadata) =
            SafeTensors::read_metadata(&bytes).map_err(|e| foreign(e.to_string()))?;
        let json = metadata.metadata().as_ref().and_then(|m| m.get(KEY));
        let json = json.ok_or_else(|| foreign("is not of this command".to_owned()))?;
        let header: Header = serde_json::from_str(json)
            .map_err(|e| foreign(format!("has a header of another kind ({e})")))?;
        if header.format != FORMAT {
            return Err(foreign(format!(
                "has format {:?}, and this program reads {FORMAT:?}",
                header.format
            )));
        }
        if header.plan != self.plan || header.controller_crc32c != self.original_crc32c()? {
            return Err(TrainingError::other(
                &self.folder,
                "holds the hardening of another controller, or with other commands, impulses, pushes or seed; give the same, or \
                 another --out"
                    .to_owned(),
            ));
        }
        let tensors = SafeTensors::deserialize(&bytes).map_err(|e| foreign(e.to_string()))?;
        let read = |name: &str| -> Result<(Vec<usize>, Vec<f32>), TrainingError> {
            let tensor = tensors.tensor(name).map_err(|e| foreign(e.to_string()))?;
            if tensor.dtype() != Dtype::F32 {
                return Err(foreign(format!("has `{name}` as no 32-bit numbers")));
            }
            let (numbers, _) = tensor.data().as_chunks::<4>();
            let values = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes));
            Ok((tensor.shape().to_vec(), values.collect()))
        };
        let mut own = Vec::new();
        for (name, _) in header.network.tensors() {
            let (shape, values) = read(&name)?;
            own.push(NamedTensor {
                name,
                shape,
                values,
            });
        }
        if header.network != *self.policy.shape() {
            return Err(foreign("has a network of other sizes".to_owned()));
        }
        self.policy =
            Policy::from_tensors(header.network, &own).map_err(|e| foreign(e.to_string()))?;
        for (kind, rounds) in KINDS.into_iter().zip([&mut self.found, &mut self.alone]) {
            for round in 0..header.remembered {
                let [observations, actions] = PARTS.map(|part| read(&name(kind, round, part)));
                let ((shape, observations), (_, actions)) = (observations?, actions?);
                let rows = shape.first().copied().unwrap_or(0);
                if observations.len() != rows * OBSERVATION_SIZE
                    || actions.len() != rows * ACTION_SIZE
                {
                    return Err(foreign(format!(
                        "has pairs of other sizes in round {round}"
                    )));
                }
                rounds.push(Pairs {
                    observations,
                    actions,
                });
            }
        }
        if header.rounds.is_empty() {
            return Err(foreign("has no rounds".to_owned()));
        }
        self.rounds = header.rounds;
        Ok(true)
    }
}

const PARTS: [&str; 2] = ["observations", "actions"];

fn name(kind: &str, round: usize, part: &str) -> String {
    format!("{kind}.{round:02}.{part}")
}
