"""Contract: experiments/mujoco_transfer/transfer.py, on which docs/mujoco.md rests, feeds the policy what our environment
would, starts where ours starts, and keeps its books: what the actuators put in is in the motion, in the springs, or was
taken by dampers, friction and contact, to 2 %. Two seconds suffice; whole gaits are the experiment's business."""

import mujoco
import numpy as np
import onnxruntime
import pytest
from conftest import experiment_script

import gaitshift


@pytest.fixture(scope="module")
def transfer():
    return experiment_script("mujoco_transfer/transfer.py")


@pytest.fixture(scope="module")
def controller():
    return gaitshift.Controller.shipped()


@pytest.fixture(scope="module")
def biped(transfer, controller):
    return transfer.Biped(gaitshift.Body(controller.body).mjcf(), controller.body, controller.task)


def test_the_contact_can_be_mujocos_own(transfer, controller):
    ours = gaitshift.Body(controller.body).mjcf()
    plain = transfer.with_default_contact(ours)
    model, default = mujoco.MjModel.from_xml_string(plain), mujoco.MjModel.from_xml_string("<mujoco><worldbody>"
        "<geom type='sphere' size='1'/></worldbody></mujoco>")
    sole = model.geom("right_sole_0")
    np.testing.assert_array_equal(sole.solref, default.geom_solref[0])
    np.testing.assert_array_equal(sole.solimp, default.geom_solimp[0])
    assert model.opt.impratio == default.opt.impratio
    assert sole.friction[0] == controller.body["friction"]
    assert mujoco.MjModel.from_xml_string(ours).opt.impratio != default.opt.impratio


def test_the_observation_is_our_environments(biped, controller):
    env = gaitshift.PassiveBipedEnv(controller=controller, omega_v=1.5)
    for seed in range(20):
        observation, _ = env.reset(seed=seed)
        mujoco.mj_resetData(biped.model, biped.data)
        biped.data.qpos[:], biped.data.qvel[:] = env.state
        np.testing.assert_array_equal(biped.observation(1.5), observation)


@pytest.mark.parametrize("omega_v", [0.0, 3.0])
def test_energy_is_accounted_for(transfer, biped, controller, omega_v):
    session = onnxruntime.InferenceSession(controller.onnx(), providers=["CPUExecutionProvider"])
    start = transfer.start_of(controller)
    there = transfer.record(biped, session, start, [(0.0, omega_v)], 2.0, "test")
    ours = controller.record(omega_v, 2.0)
    assert set(there.metadata) == set(ours.metadata) and there.metadata["body"] == ours.metadata["body"]
    for name in gaitshift.COLUMNS:
        if name.endswith(("_m", "_rad", "_m_per_s", "_rad_per_s", "_energy_j")):
            assert there[name][0] == pytest.approx(ours[name][0], abs=1e-12), name
    parts = ("kinetic", "gravitational", "hip_spring", "leg_spring", "contact", "stop")
    total = sum(there[f"{part}_energy_j"] for part in parts)
    losses = sum(there[f"{part}_dissipation_j"] for part in ("damper", "contact", "stop"))
    missing = there["actuator_work_j"] - losses - (total - total[0])
    spent = there["actuator_positive_work_j"][-1]
    print(f"\nω_v = {omega_v:g}: {spent:.1f} J put in over {there['time_s'][-1]:.2f} s, "
          f"greatest error of the account {np.max(np.abs(missing)):.2e} J")
    assert spent > 10.0
    assert np.max(np.abs(missing)) < 0.02 * spent
