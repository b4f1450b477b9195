//! A controller's deterministic policy as an ONNX graph.
//!
//! `observation` (batch × 14, 32-bit floats, SI units, the paper's order) → scale → hidden layers →
//! means → tanh → `action` (batch × 2, in [-1, 1], right leg first). Scaling and squashing are part of the
//! graph, so that nothing has to be known besides the order of the observation, and that stands in the
//! file's metadata. Operator set 17, format version 8.

use crate::protobuf::Message;
use gaitshift_experiment::Controller;
use gaitshift_sac::NamedTensor;
use gaitshift_task::{OBSERVATION_NAMES, OBSERVATION_SCALE, OBSERVATION_SIZE};

/// Version of ONNX's file format (`IR_VERSION`).
const FORMAT_VERSION: u64 = 8;
/// Version of ONNX's operators.
const OPERATORS: u64 = 17;

/// A controller that cannot be written as ONNX.
#[derive(Debug, thiserror::Error)]
pub enum OnnxError {
    /// A tensor that the network's shape asks for is not there.
    #[error("the policy has no tensor `{name}`: it is damaged or of another program")]
    Missing {
        /// The tensor.
        name: String,
    },
    /// Body, task or provenance hold a number that JSON cannot.
    #[error("the controller's description cannot be written as JSON: {cause}")]
    Description {
        /// What the writer says.
        cause: String,
    },
}

/// The bytes of the ONNX file of a controller.
///
/// # Errors
/// A policy without the tensors its shape asks for, a description that is no JSON.
pub fn onnx(controller: &Controller) -> Result<Vec<u8>, OnnxError> {
    let graph = Graph::of(controller)?;
    let mut model = Message::default()
        .integer(1, FORMAT_VERSION)
        .bytes(2, "gaitshift")
        .bytes(3, env!("CARGO_PKG_VERSION"))
        .bytes(
            6,
            "Deterministic policy of a planar biped with passive hips; see the metadata for names and units.",
        )
        .message(7, graph.finish())
        .message(8, Message::default().bytes(1, "").integer(2, OPERATORS));
    for (key, value) in metadata(controller)? {
        model = model.message(14, Message::default().bytes(1, key).bytes(2, value));
    }
    Ok(model.finish())
}

/// What the file says about itself.
fn metadata(controller: &Controller) -> Result<Vec<(&'static str, String)>, OnnxError> {
    fn json(value: Result<String, serde_json::Error>) -> Result<String, OnnxError> {
        value.map_err(|e| OnnxError::Description {
            cause: e.to_string(),
        })
    }
    Ok(vec![
        ("gaitshift.format", "gaitshift-onnx 1".to_owned()),
        (
            "gaitshift.observation_names",
            json(serde_json::to_string(&OBSERVATION_NAMES))?,
        ),
        (
            "gaitshift.observation",
            "float32, batch x 14, SI units and radians, not scaled; omega_v is the command".to_owned(),
        ),
        (
            "gaitshift.action_names",
            r#"["right_command","left_command"]"#.to_owned(),
        ),
        (
            "gaitshift.action",
            "float32, batch x 2, in [-1, 1], held for one control period; actuator force = action * \
             actuator_force_n, positive lengthens the leg"
                .to_owned(),
        ),
        (
            "gaitshift.actuator_force_n",
            format!("{:?}", controller.body.actuator_force_n),
        ),
        (
            "gaitshift.control_period_s",
            format!("{:?}", controller.task.control_period_s),
        ),
        ("gaitshift.body", json(serde_json::to_string(&controller.body))?),
        ("gaitshift.task", json(serde_json::to_string(&controller.task))?),
        (
            "gaitshift.provenance",
            json(serde_json::to_string(&controller.provenance))?,
        ),
    ])
}

/// Nodes and constants, in the order in which they are computed.
#[derive(Default)]
struct Graph {
    nodes: Vec<Message>,
    constants: Vec<Message>,
    last: String,
}

impl Graph {
    fn of(controller: &Controller) -> Result<Self, OnnxError> {
        let tensors = controller.policy.tensors();
        let find = |name: String| -> Result<&NamedTensor<f32>, OnnxError> {
            tensors
                .iter()
                .find(|tensor| tensor.name == name)
                .ok_or(OnnxError::Missing { name })
        };
        let shape = controller.policy.shape();
        let mut graph = Self {
            last: "observation".to_owned(),
            ..Self::default()
        };
        graph.constant("observation_scale", &[OBSERVATION_SIZE], &OBSERVATION_SCALE);
        graph.node("Mul", "scaled_observation", &["observation_scale"], []);
        for layer in 0..shape.hidden.len() {
            let prefix = format!("layers.{layer}");
            let weight = find(format!("{prefix}.weight"))?;
            let bias = find(format!("{prefix}.bias"))?;
            graph.linear(&prefix, weight, bias, weight.shape[0]);
            graph.node("Relu", &format!("{prefix}.relu"), &[], []);
        }
        // Of the outputs the first half are the means; the deviations are for exploring.
        let (weight, bias) = (
            find("output.weight".to_owned())?,
            find("output.bias".to_owned())?,
        );
        graph.linear("mean", weight, bias, controller.policy.action_size());
        graph.node("Tanh", "action", &[], []);
        Ok(graph)
    }

    /// A constant of 32-bit floats.
    fn constant(&mut self, name: &str, shape: &[usize], values: &[f32]) {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let tensor = shape
            .iter()
            .fold(Message::default(), |m, &extent| m.integer(1, extent as u64))
            .integer(2, 1)
            .bytes(8, name)
            .bytes(9, bytes);
        self.constants.push(tensor);
    }

    /// A node whose first input is the last node's output.
    fn node(
        &mut self,
        operator: &str,
        name: &str,
        constants: &[&str],
        attributes: impl IntoIterator<Item = Message>,
    ) {
        let inputs = std::iter::once(self.last.as_str()).chain(constants.iter().copied());
        let node = inputs
            .fold(Message::default(), |m, input| m.bytes(1, input))
            .bytes(2, name)
            .bytes(3, name)
            .bytes(4, operator)
            .messages(5, attributes);
        self.nodes.push(node);
        self.last = name.to_owned();
    }

    /// A linear layer with the first `units` rows of its weights.
    fn linear(
        &mut self,
        name: &str,
        weight: &NamedTensor<f32>,
        bias: &NamedTensor<f32>,
        units: usize,
    ) {
        let inputs = weight.shape[1];
        let names = [format!("{name}.weight"), format!("{name}.bias")];
        self.constant(
            &names[0],
            &[units, inputs],
            &weight.values[..units * inputs],
        );
        self.constant(&names[1], &[units], &bias.values[..units]);
        // Weights are outputs × inputs.
        let transposed = Message::default()
            .bytes(1, "transB")
            .integer(3, 1)
            .integer(20, 2);
        self.node("Gemm", name, &[&names[0], &names[1]], [transposed]);
    }

    fn finish(self) -> Message {
        Message::default()
            .messages(1, self.nodes)
            .bytes(2, "policy")
            .messages(5, self.constants)
            .message(
                11,
                port(
                    "observation",
                    OBSERVATION_SIZE,
                    "SI units and radians, not scaled",
                ),
            )
            .message(
                12,
                port("action", 2, "actuator commands in [-1, 1], right leg first"),
            )
    }
}

/// An input or output: batch × `size` 32-bit floats.
fn port(name: &str, size: usize, description: &str) -> Message {
    let shape = Message::default()
        .message(1, Message::default().bytes(2, "batch"))
        .message(1, Message::default().integer(1, size as u64));
    let tensor = Message::default().integer(1, 1).message(2, shape);
    Message::default()
        .bytes(1, name)
        .message(2, Message::default().message(1, tensor))
        .bytes(3, description)
}
