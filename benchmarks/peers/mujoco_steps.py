"""Environment steps per second of MuJoCo on our body. Protocol: protocol.py.

    gaitshift export mjcf --out biped.xml
    python benchmarks/peers/mujoco_steps.py biped.xml                        # with the file's time step
    python benchmarks/peers/mujoco_steps.py biped.xml --timestep 0.001       # and the implicitfast integrator

One step is one control period under uniformly random forces, with the observation; no reward, no Gymnasium. An episode
ends by a fall or after 10 s and the next one starts as ours do: legs split, one foot on the ground, moving forward.
"""

import argparse
import itertools

from protocol import limit_threads, serve

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("mjcf", help="what `gaitshift export mjcf` wrote")
parser.add_argument(
    "--timestep", type=float, metavar="S", help="use this time step and implicitfast [default: the file's own]"
)
arguments = parser.parse_args()
limit_threads(1)

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

CONTROL_PERIOD_S, TIME_LIMIT_S = 0.01, 10.0
PITCH_LIMIT_RAD, MIN_HIP_HEIGHT_M = 1.4, 0.68
X, Z, THETA, RIGHT_PHI, LEFT_PHI = 0, 1, 2, 3, 7  # in qpos and qvel
LEG_LENGTH_M = 0.8

model = mujoco.MjModel.from_xml_path(arguments.mjcf)
if arguments.timestep is not None:
    model.opt.timestep = arguments.timestep
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
data = mujoco.MjData(model)
substeps = round(CONTROL_PERIOD_S / model.opt.timestep)
rng = np.random.default_rng(1)


def start():
    """A start drawn from the ranges of `StartParameters` in gaitshift-task."""
    mujoco.mj_resetData(model, data)
    front, rear = rng.uniform(0.10, 0.40), rng.uniform(-0.40, -0.10)
    pitch, speed = rng.uniform(-0.1, 0.1), rng.uniform(0.2, 1.0)
    legs = (RIGHT_PHI, LEFT_PHI) if rng.random() < 0.5 else (LEFT_PHI, RIGHT_PHI)
    data.qpos[THETA] = pitch
    data.qvel[X] = speed
    # phi is the angle between hip and leg, front and rear that between leg and vertical.
    for leg, angle, rate in zip(legs, (front, rear), (-speed / LEG_LENGTH_M, speed / LEG_LENGTH_M)):
        data.qpos[leg] = angle - pitch
        data.qvel[leg] = rate
    mujoco.mj_kinematics(model, data)
    sole = model.geom_contype == 1
    data.qpos[Z] += rng.uniform(0.0, 0.02) - np.min(data.geom_xpos[sole, 2] - model.geom_size[sole, 0])
    return data.qpos.copy(), data.qvel.copy()


starts = [start() for _ in range(64)]
actions = itertools.cycle(rng.uniform(-1, 1, (64, 64, 2)))
observation = np.zeros(model.nsensordata + 1)  # the last one is the command
limit = round(TIME_LIMIT_S / CONTROL_PERIOD_S)
periods = 0


def reset():
    global periods
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = starts[rng.integers(len(starts))]
    observation[-1] = rng.uniform(-0.5, 3.5)
    mujoco.mj_forward(model, data)
    observation[:-1] = data.sensordata
    periods = 0


def work():
    global periods
    step, position, control, sensors = mujoco.mj_step, data.qpos, data.ctrl, data.sensordata
    some = next(actions)
    for action in some:
        control[:] = action
        step(model, data, substeps)
        observation[:-1] = sensors
        periods += 1
        if abs(position[THETA]) > PITCH_LIMIT_RAD or position[Z] < MIN_HIP_HEIGHT_M or periods >= limit:
            reset()
    return len(some)


reset()
serve(work)
