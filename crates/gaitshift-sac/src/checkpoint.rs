//! Agents and replay buffers on disk, each as one safetensors file with one JSON metadata entry.
//!
//! An agent's file holds everything that the next update depends on: networks, targets, both
//! moments of Adam and its step counts, the temperature with its own, the random streams, the settings. A
//! buffer's file holds the filled part of the ring. A run that is saved and resumed goes on bit for bit.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

use gaitshift_nn::{Mlp, MlpShape, NamedTensor, Trained};
use safetensors::tensor::{Dtype, SafeTensors, View};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::agent::{Agent, Streams};
use crate::config::{SacConfig, Temperature, actor_shape, check_sizes, critic_shape};
use crate::error::SacError;
use crate::learner::{TemperatureState, UpdateStats};
use crate::mirror::Mirror;
use crate::rehearsal::Rehearsal;
use crate::replay::ReplayBuffer;

const AGENT: &str = "agent checkpoint";
const REPLAY: &str = "replay buffer file";
const AGENT_KEY: &str = "gaitshift-sac-agent";
const REPLAY_KEY: &str = "gaitshift-sac-replay";
const REHEARSAL: [&str; 2] = ["rehearsal.observations", "rehearsal.actions"];
/// More updates than any run makes: counting on from there does not overflow.
const MOST_UPDATES: u64 = 1 << 62;
/// Version of both formats.
const FORMAT: u32 = 5;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct AgentHeader {
    format: u32,
    config: SacConfig,
    observation_size: usize,
    action_size: usize,
    mirror: Option<Mirror>,
    temperature: TemperatureState,
    updates: u64,
    actor_steps: u64,
    critic_steps: [u64; 2],
    stats: UpdateStats,
    streams: Streams,
    /// Remembered pairs; 0 if none are rehearsed.
    rehearsal: usize,
    /// Of them in an update.
    rehearsal_rows: usize,
    rehearsal_weight: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReplayHeader {
    format: u32,
    observation_size: usize,
    action_size: usize,
    /// Under the name it had when the format was made.
    #[serde(rename = "streams")]
    environments: usize,
    rows: usize,
    filled: usize,
    head: usize,
}

/// A tensor whose bytes are made when it is written, so that only one is in memory at a time.
struct Lazy<'a> {
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Box<dyn Fn() -> Vec<u8> + 'a>,
}

impl View for Lazy<'_> {
    fn dtype(&self) -> Dtype {
        self.dtype
    }
    fn shape(&self) -> &[usize] {
        &self.shape
    }
    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Owned((self.bytes)())
    }
    fn data_len(&self) -> usize {
        self.shape.iter().product::<usize>() * self.dtype.bitsize() / 8
    }
}

/// `serialize_to_file` writes beside the target and renames, so a crash leaves the old file whole.
fn write<H: Serialize>(
    path: &Path,
    kind: &'static str,
    key: &str,
    header: &H,
    tensors: Vec<(String, Lazy<'_>)>,
) -> Result<(), SacError> {
    let failed = |source: std::io::Error| SacError::File {
        action: "write",
        path: path.to_owned(),
        source,
    };
    let header =
        serde_json::to_string(header).map_err(|error| failed(std::io::Error::other(error)))?;
    let metadata = HashMap::from([(key.to_owned(), header)]);
    let written = safetensors::tensor::serialize_to_file(tensors, Some(metadata), path);
    written.map_err(|error| match error {
        safetensors::SafeTensorError::IoError(source) => failed(source),
        other => SacError::Format {
            kind,
            path: path.to_owned(),
            cause: other.to_string(),
            remedy: "this is a defect of the program, please report it",
        },
    })?;
    readable(path).map_err(failed)
}

/// The library writes for the owner alone; the file gets the permissions of any new one.
fn readable(path: &Path) -> std::io::Result<()> {
    let mut probe = path.as_os_str().to_owned();
    probe.push(".new");
    let permissions = fs::File::create(&probe)?.metadata()?.permissions();
    fs::remove_file(&probe)?;
    fs::set_permissions(path, permissions)
}

/// An open file; knows how to complain.
struct Reader<'a> {
    kind: &'static str,
    path: &'a Path,
    tensors: SafeTensors<'a>,
}

impl<'a> Reader<'a> {
    fn read(path: &Path) -> Result<Vec<u8>, SacError> {
        fs::read(path).map_err(|source| SacError::File {
            action: "read",
            path: path.to_owned(),
            source,
        })
    }

    fn open<H: DeserializeOwned>(
        kind: &'static str,
        key: &str,
        path: &'a Path,
        bytes: &'a [u8],
    ) -> Result<(Self, H), SacError> {
        let reject = |cause: String, remedy| SacError::Format {
            kind,
            path: path.to_owned(),
            cause,
            remedy,
        };
        let foreign = "give a file that this program wrote for this purpose";
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|error| {
            reject(
                format!(
                    "its safetensors header cannot be read or does not match its length ({error})"
                ),
                "the file is truncated or of another program: restore it from a copy, or begin anew",
            )
        })?;
        let header = metadata
            .metadata()
            .as_ref()
            .and_then(|entries| entries.get(key));
        let header =
            header.ok_or_else(|| reject(format!("its metadata has no entry `{key}`"), foreign))?;
        let version: Version = serde_json::from_str(header).map_err(|error| {
            reject(
                format!("its metadata entry `{key}` is malformed ({error})"),
                foreign,
            )
        })?;
        if version.format != FORMAT {
            return Err(reject(
                format!(
                    "it has format {}, and this program reads format {FORMAT}",
                    version.format
                ),
                "use the version of the program that wrote it",
            ));
        }
        let header = serde_json::from_str(header).map_err(|error| {
            reject(
                format!("its metadata entry `{key}` is malformed ({error})"),
                foreign,
            )
        })?;
        let tensors = SafeTensors::deserialize(bytes).map_err(|error| {
            reject(
                error.to_string(),
                "the file is truncated: restore it from a copy, or begin anew",
            )
        })?;
        Ok((
            Self {
                kind,
                path,
                tensors,
            },
            header,
        ))
    }

    fn reject(&self, cause: String) -> SacError {
        let remedy =
            "the file was altered or is of another program: restore it from a copy, or begin anew";
        SacError::Format {
            kind: self.kind,
            path: self.path.to_owned(),
            cause,
            remedy,
        }
    }

    fn bytes(&self, name: &str, dtype: Dtype, shape: &[usize]) -> Result<&'a [u8], SacError> {
        let tensor = self
            .tensors
            .tensor(name)
            .map_err(|_| self.reject(format!("the tensor `{name}` is missing")))?;
        if tensor.dtype() != dtype || tensor.shape() != shape {
            return Err(self.reject(format!(
                "the tensor `{name}` is {:?} {:?}, but {dtype:?} {shape:?} is needed",
                tensor.dtype(),
                tensor.shape()
            )));
        }
        Ok(tensor.data())
    }

    fn floats(
        &self,
        name: &str,
        shape: &[usize],
    ) -> Result<impl Iterator<Item = f32> + use<'a>, SacError> {
        let bytes = self.bytes(name, Dtype::F32, shape)?;
        Ok(bytes
            .chunks_exact(4)
            .map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])))
    }

    /// Every tensor of a network of these sizes is there under `prefix`.
    fn check(&self, shape: &MlpShape, prefix: &str) -> Result<(), SacError> {
        for (name, shape) in shape.tensors() {
            self.bytes(&format!("{prefix}.{name}"), Dtype::F32, &shape)?;
        }
        Ok(())
    }

    /// Reads into `flat` everything that belongs to `network` under `prefix`.
    fn fill(&self, network: &Mlp<f32>, prefix: &str, flat: &mut [f32]) -> Result<(), SacError> {
        let mut tensors = Vec::new();
        for (name, shape) in network.shape().tensors() {
            let values = self.floats(&format!("{prefix}.{name}"), &shape)?.collect();
            tensors.push(NamedTensor {
                name,
                shape,
                values,
            });
        }
        network.load_tensors_into(&tensors, flat);
        Ok(())
    }

    fn network(&self, network: &mut Mlp<f32>, prefix: &str) -> Result<(), SacError> {
        let mut flat = network.parameters.clone();
        self.fill(network, prefix, &mut flat)?;
        network.parameters = flat;
        Ok(())
    }

    fn trained(&self, trained: &mut Trained<f32>, prefix: &str) -> Result<(), SacError> {
        self.network(&mut trained.network, prefix)?;
        self.fill(
            &trained.network,
            &format!("{prefix}.first_moment"),
            &mut trained.first_moment,
        )?;
        self.fill(
            &trained.network,
            &format!("{prefix}.second_moment"),
            &mut trained.second_moment,
        )?;
        trained.refresh();
        Ok(())
    }
}

/// The part of a header that is read before the rest.
#[derive(Deserialize)]
struct Version {
    format: u32,
}

fn to_bytes(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

fn lazy_tensors<'a>(
    network: &Mlp<f32>,
    prefix: &str,
    flat: &[f32],
    out: &mut Vec<(String, Lazy<'a>)>,
) {
    for NamedTensor {
        name,
        shape,
        values,
    } in network.tensors_of(flat)
    {
        let bytes = Box::new(move || to_bytes(values.iter().copied()));
        out.push((
            format!("{prefix}.{name}"),
            Lazy {
                dtype: Dtype::F32,
                shape,
                bytes,
            },
        ));
    }
}

impl Agent {
    /// Saves everything the next update depends on, apart from the replay buffer.
    ///
    /// # Errors
    /// When the file cannot be written, or learning has diverged.
    pub fn save(&self, path: &Path) -> Result<(), SacError> {
        let learner = &self.learner;
        learner.check_finite()?;
        let mut tensors = Vec::new();
        let [critic_1, critic_2] = &learner.critics;
        for (trained, prefix) in [
            (&learner.actor, "actor"),
            (critic_1, "critic_1"),
            (critic_2, "critic_2"),
        ] {
            let network = &trained.network;
            lazy_tensors(network, prefix, &network.parameters, &mut tensors);
            lazy_tensors(
                network,
                &format!("{prefix}.first_moment"),
                &trained.first_moment,
                &mut tensors,
            );
            lazy_tensors(
                network,
                &format!("{prefix}.second_moment"),
                &trained.second_moment,
                &mut tensors,
            );
        }
        let [target_1, target_2] = &learner.targets;
        lazy_tensors(target_1, "target_1", &target_1.parameters, &mut tensors);
        lazy_tensors(target_2, "target_2", &target_2.parameters, &mut tensors);
        if let Some(rehearsal) = &self.rehearsal {
            for ((name, size), values) in REHEARSAL
                .into_iter()
                .zip(rehearsal.sizes())
                .zip([rehearsal.observations(), rehearsal.actions()])
            {
                tensors.push((
                    name.to_owned(),
                    Lazy {
                        dtype: Dtype::F32,
                        shape: vec![rehearsal.rows(), size],
                        bytes: Box::new(|| to_bytes(values.iter().copied())),
                    },
                ));
            }
        }
        let header = AgentHeader {
            format: FORMAT,
            config: learner.config.clone(),
            observation_size: learner.observation_size,
            action_size: learner.action_size,
            mirror: learner.mirror.as_deref().cloned(),
            temperature: learner.temperature,
            updates: learner.updates,
            actor_steps: learner.actor.steps,
            critic_steps: [critic_1.steps, critic_2.steps],
            stats: learner.stats,
            streams: self.streams.clone(),
            rehearsal: self.rehearsal.as_ref().map_or(0, Rehearsal::rows),
            rehearsal_rows: learner.rehearsed_rows(),
            rehearsal_weight: learner.rehearsal_weight,
        };
        write(path, AGENT, AGENT_KEY, &header, tensors)
    }

    /// Resumes a saved agent.
    ///
    /// # Errors
    /// When the file cannot be read, is truncated, or is none of [`Agent::save`]; the error names the file,
    /// the tensor and what to do.
    pub fn load(path: &Path) -> Result<Self, SacError> {
        let bytes = Reader::read(path)?;
        let (reader, header) = Reader::open::<AgentHeader>(AGENT, AGENT_KEY, path, &bytes)?;
        let (config, sizes) = (
            &header.config,
            [header.observation_size, header.action_size],
        );
        config
            .validate()
            .and_then(|()| check_sizes(config, sizes))
            .map_err(|error| reader.reject(error.to_string()))?;
        let temperature = header.temperature;
        let counts = [header.updates, header.actor_steps, temperature.steps];
        if counts
            .iter()
            .chain(&header.critic_steps)
            .any(|&count| count > MOST_UPDATES)
        {
            return Err(reader.reject("it counts more updates than any run can make".to_owned()));
        }
        // A header cannot hold a number that is not finite.
        let learned = matches!(config.temperature, Temperature::Auto { .. });
        let alpha = temperature.alpha;
        if alpha < 0.0 || learned && alpha == 0.0 {
            let least = if learned { "above 0" } else { "at least 0" };
            return Err(reader.reject(format!(
                "the temperature in it is {alpha}, but it must be {least}"
            )));
        }
        // The file holds what its header says, or this fails before memory is taken for it.
        reader.check(&actor_shape(config, sizes), "actor")?;
        reader.check(&critic_shape(config, sizes), "critic_1")?;
        let mut agent = Self::new(
            header.config,
            header.observation_size,
            header.action_size,
            header.mirror,
            0,
        )
        .map_err(|error| reader.reject(error.to_string()))?;
        let learner = &mut agent.learner;
        reader.trained(&mut learner.actor, "actor")?;
        for ((critic, target), number) in learner
            .critics
            .iter_mut()
            .zip(&mut learner.targets)
            .zip(1..)
        {
            reader.trained(critic, &format!("critic_{number}"))?;
            reader.network(target, &format!("target_{number}"))?;
        }
        learner.temperature = temperature;
        learner.updates = header.updates;
        learner.actor.steps = header.actor_steps;
        [learner.critics[0].steps, learner.critics[1].steps] = header.critic_steps;
        learner.stats = header.stats;
        agent.streams = header.streams;
        if header.rehearsal > 0 {
            let read = |index: usize| {
                let shape = [header.rehearsal, sizes[index]];
                Ok::<Vec<f32>, SacError>(reader.floats(REHEARSAL[index], &shape)?.collect())
            };
            Rehearsal::new(sizes[0], sizes[1], read(0)?, read(1)?)
                .and_then(|rehearsal| agent.rehearse(rehearsal, header.rehearsal_rows))
                .map_err(|error| reader.reject(error.to_string()))?;
        }
        agent
            .set_rehearsal_weight(header.rehearsal_weight)
            .map_err(|error| reader.reject(error.to_string()))?;
        Ok(agent)
    }
}

impl ReplayBuffer {
    /// Saves the filled part of the ring.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), SacError> {
        let header = ReplayHeader {
            format: FORMAT,
            observation_size: self.observation_size,
            action_size: self.action_size,
            environments: self.environments,
            rows: self.rows,
            filled: self.filled,
            head: self.head,
        };
        let width = self.width();
        let mut tensors: Vec<_> = self
            .columns()
            .into_iter()
            .map(|(name, offset, size)| {
                let bytes = Box::new(move || {
                    let slots = self.data[..self.len() * width].chunks_exact(width);
                    to_bytes(slots.flat_map(|slot| slot[offset..offset + size].iter().copied()))
                });
                (
                    name.to_owned(),
                    Lazy {
                        dtype: Dtype::F32,
                        shape: vec![self.len(), size],
                        bytes: bytes as _,
                    },
                )
            })
            .collect();
        let flags = Box::new(|| self.flags.clone());
        tensors.push((
            "flags".to_owned(),
            Lazy {
                dtype: Dtype::U8,
                shape: vec![self.len()],
                bytes: flags,
            },
        ));
        write(path, REPLAY, REPLAY_KEY, &header, tensors)
    }

    /// Loads a saved buffer.
    ///
    /// # Errors
    /// When the file cannot be read, is truncated, or is none of [`ReplayBuffer::save`]; the error names the
    /// file, the tensor and what to do.
    pub fn load(path: &Path) -> Result<Self, SacError> {
        let bytes = Reader::read(path)?;
        let (reader, header) = Reader::open::<ReplayHeader>(REPLAY, REPLAY_KEY, path, &bytes)?;
        let capacity = header.rows.saturating_mul(header.environments);
        let mut buffer = Self::new(
            capacity,
            header.environments,
            header.observation_size,
            header.action_size,
        )
        .map_err(|error| reader.reject(error.to_string()))?;
        let wrapped = header.filled == header.rows && header.head < header.rows;
        if !(wrapped || header.filled < header.rows && header.head == header.filled) {
            return Err(reader.reject(format!(
                "its ring of {} rows cannot have {} filled and row {} next",
                header.rows, header.filled, header.head
            )));
        }
        (buffer.filled, buffer.head) = (header.filled, header.head);
        let (len, width) = (buffer.len(), buffer.width());
        // The file holds as much as its header says, or this fails before any memory is filled.
        buffer
            .flags
            .extend_from_slice(reader.bytes("flags", Dtype::U8, &[len])?);
        buffer.data.resize(len * width, 0.0);
        for (name, offset, size) in buffer.columns() {
            let mut values = reader.floats(name, &[len, size])?;
            for slot in buffer.data.chunks_exact_mut(width) {
                for (place, value) in slot[offset..offset + size].iter_mut().zip(&mut values) {
                    *place = value;
                }
            }
        }
        buffer.count_valid();
        Ok(buffer)
    }
}
