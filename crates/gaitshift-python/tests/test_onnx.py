"""Contract: the exported graph is valid, says what goes in and out, and gives the policy's actions within rounding of
32-bit floats on raw observations, single and in batches. onnx's checker and onnxruntime are the oracles."""

import json

import numpy as np
import onnx
import onnxruntime
import pytest

import gaitshift


@pytest.fixture(scope="module")
def controller():
    return gaitshift.Controller.shipped()


def session(data):
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])


def test_the_file_is_valid_and_describes_itself(controller):
    model = onnx.load_from_string(controller.onnx())
    onnx.checker.check_model(model, full_check=True)
    [observation], [action] = model.graph.input, model.graph.output
    for port, size in ((observation, 14), (action, 2)):
        batch, extent = port.type.tensor_type.shape.dim
        assert port.type.tensor_type.elem_type == onnx.TensorProto.FLOAT
        assert batch.dim_param == "batch" and extent.dim_value == size
    metadata = {entry.key: entry.value for entry in model.metadata_props}
    assert json.loads(metadata["gaitshift.observation_names"]) == list(gaitshift.OBSERVATION_NAMES)
    assert len(json.loads(metadata["gaitshift.action_names"])) == 2
    assert float(metadata["gaitshift.control_period_s"]) == controller.control_period_s
    assert json.loads(metadata["gaitshift.body"]) == controller.body
    assert json.loads(metadata["gaitshift.task"]) == controller.task


def in_64_bits(model, observations):
    """The graph's actions in 64-bit floats, and the greatest sum of any linear layer."""
    constants = {t.name: onnx.numpy_helper.to_array(t).astype(np.float64) for t in model.graph.initializer}
    values, greatest = observations, 0.0
    for node in model.graph.node:
        if node.op_type == "Gemm":
            values = values @ constants[node.input[1]].T + constants[node.input[2]]
            greatest = max(greatest, np.max(np.abs(values)))
        else:
            scale = constants[node.input[1]] if node.op_type == "Mul" else None
            step = {"Mul": lambda v, scale=scale: v * scale, "Relu": lambda v: np.maximum(v, 0), "Tanh": np.tanh}
            values = step[node.op_type](values)
    return values, greatest


def test_actions_equal_the_policys(controller):
    rng = np.random.default_rng(1)
    # Of order one once they are scaled.
    observations = (rng.normal(size=(5000, 14)) / np.array(gaitshift.OBSERVATION_SCALE)).astype(np.float32)
    run = session(controller.onnx())
    [actions] = run.run(["action"], {"observation": observations})
    ours = controller(observations)
    exact, greatest = in_64_bits(onnx.load_from_string(controller.onnx()), observations.astype(np.float64))
    # What 32-bit floats resolve of the greatest sum before the tanh.
    rounding = np.finfo(np.float32).eps * greatest
    print(f"\nlargest difference of 5000 actions: {np.max(np.abs(actions - ours)):.1e}, rounding {rounding:.1e}")
    assert actions.shape == (5000, 2) and np.std(ours) > 0.1 and rounding < 1e-4
    assert np.max(np.abs(actions - exact)) < 3 * rounding
    assert np.max(np.abs(ours - exact)) < 3 * rounding
    [one] = run.run(None, {"observation": observations[:1]})
    np.testing.assert_allclose(one, ours[:1], atol=3 * rounding)


def test_a_network_of_other_sizes(program, tmp_path):
    (tmp_path / "sizes.toml").write_text(
        "\n".join(
            [
                'name = "sizes"',
                "[learner]",
                "actor_hidden = [24, 16, 8]",
                "[training]",
                "learning_starts = 100",
                "replay_capacity = 10000",
                "evaluation_interval_steps = 4000",
                "[[curriculum.phases]]",
                'name = "short"',
                "steps = 2000",
                "omega_v = [0.0, 3.0]",
            ]
        )
    )
    program("train", tmp_path / "sizes.toml", "--out", tmp_path / "run", cwd=tmp_path)
    path = tmp_path / "run" / "controller-last.safetensors"
    controller = gaitshift.Controller.load(path)
    observations = np.random.default_rng(2).normal(size=(500, 14)) / np.array(gaitshift.OBSERVATION_SCALE)
    data = program("export", "onnx", "--controller", path)
    assert data == controller.onnx()
    onnx.checker.check_model(onnx.load_from_string(data), full_check=True)
    [actions] = session(data).run(None, {"observation": observations.astype(np.float32)})
    np.testing.assert_allclose(actions, controller(observations), atol=1e-5)


def test_the_program_writes_the_same_file(program, tmp_path, controller):
    path = tmp_path / "policy.onnx"
    program("export", "onnx", "--out", path)
    assert path.read_bytes() == controller.onnx()
    controller.write_onnx(tmp_path / "ours.onnx")
    assert (tmp_path / "ours.onnx").read_bytes() == controller.onnx()
