"""Contract: the exported body walks in MuJoCo under the exported policy with what the two files say alone, by the script that
the examples give; it starts where ours starts and acts as often as ours acts."""

import re
import subprocess
import sys

import mujoco
import numpy as np
import pytest
from conftest import REPOSITORY

import gaitshift

SCRIPT = REPOSITORY / "crates" / "gaitshift-python" / "examples" / "walk_in_mujoco.py"


@pytest.fixture(scope="module")
def files(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("exported")
    program("export", "mjcf", "--out", folder / "biped.xml")
    program("export", "onnx", "--out", folder / "policy.onnx")
    return folder


# The exported body stood still under its policy: its pose at rest is symmetric, so the policy kept it so. And it was not
# the body that the policy was trained on, so that it fell at commands from 2 on.
@pytest.mark.parametrize("omega_v, speeds", [(0.0, (0.3, 0.8)), (1.5, (1.6, 2.4)), (3.0, (2.3, 3.0))])
def test_the_script_walks_and_runs(files, tmp_path, omega_v, speeds):
    text = SCRIPT.read_text().replace("omega_v = mujoco.MjModel.from_xml_path(\"biped.xml\"), 0.0",
                                      f"omega_v = mujoco.MjModel.from_xml_path(\"biped.xml\"), {omega_v}")
    assert str(omega_v) in text
    script = tmp_path / "walk.py"
    script.write_text(text)
    out = subprocess.run([sys.executable, script], cwd=files, check=True, capture_output=True, text=True).stdout
    way, seconds, height = map(float, re.fullmatch(r"(\S+) m in (\S+) s, hip at (\S+) m\n", out).groups())
    assert seconds == 10.0 and 0.6 < height < 0.9, out
    assert speeds[0] < way / seconds < speeds[1], out


def test_the_file_says_where_to_start_and_how_often_to_act(files):
    controller = gaitshift.Controller.shipped()
    model = mujoco.MjModel.from_xml_path(str(files / "biped.xml"))
    assert model.numeric("control_period_s").data[0] == controller.control_period_s
    env = gaitshift.PassiveBipedEnv(controller=controller)
    env.reset(options={"start": "default"})
    positions, velocities = env.state
    np.testing.assert_array_equal(model.key("start").qpos, positions)
    np.testing.assert_array_equal(model.key("start").qvel, velocities)


def test_the_task_can_be_another():
    task = {"control_period_s": 0.005, "start": {"speed_m_per_s": 0.9}}
    model = mujoco.MjModel.from_xml_string(gaitshift.Body().mjcf(task))
    assert model.numeric("control_period_s").data[0] == 0.005
    assert model.key("start").qvel[0] == 0.9
    with pytest.raises(ValueError, match="contrl_period_s"):
        gaitshift.Body().mjcf({"contrl_period_s": 0.005})


def test_the_script_is_short():
    body = SCRIPT.read_text().split('"""')[2]
    assert len([line for line in body.splitlines() if line and not line.startswith("import")]) <= 12


def test_a_latency_delays_the_force_by_its_steps(program):
    text = program("export", "mjcf", "--latency", "20ms", "--weak", "right=0.5").decode()
    controller = gaitshift.Controller.shipped()
    own = gaitshift.Body(controller.body)
    assert own.mjcf(controller.task, actuator_factor=(0.5, 1.0), latency_s=0.02) == text
    with pytest.raises(ValueError, match="latency_s"):
        own.mjcf(latency_s=-1.0)
    with pytest.raises(ValueError, match="control_period_s"):
        own.mjcf({"control_period_s": -1.0})
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    random = np.random.default_rng(1)
    commands, forces = [], []
    for k in range(400):
        if k % 50 == 0:
            command = random.uniform(-1.0, 1.0, 2)
        data.ctrl[:] = command
        mujoco.mj_step(model, data)
        commands.append(command)
        forces.append(data.actuator_force * model.actuator_gear[:, 0])
    # Without force until the first command arrives, 100 steps of 0.2 ms later.
    assert not np.any(forces[:100])
    np.testing.assert_allclose(forces[100:], np.array(commands[:-100]) * [300.0, 600.0], atol=1e-9)
