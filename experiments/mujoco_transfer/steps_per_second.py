"""Environment steps per second from Python: ours, single and vector, and the same body in MuJoCo through Gymnasium.

    python experiments/mujoco_transfer/steps_per_second.py [--seconds 3] [--threads 2]

All with the same body, task, control period and integration step, random actions, resets included. MuJoCo is also run
at a step of 1 ms with its implicit integrator, a common choice for its speed. The environment around MuJoCo computes
the observation and the reward's velocity, forward and alive terms only, which favours it.

Steps are given per second of wall-clock time, and per second of processor time of all threads, which depends less on
other load on the machine.
"""

import argparse
import os
import time

import gymnasium
import mujoco
import numpy as np

import gaitshift


class MujocoBiped(gymnasium.Env):
    """The exported body in MuJoCo as a Gymnasium environment, as one would write it by hand."""

    def __init__(self, step_s=None):
        reference = gaitshift.PassiveBipedEnv()
        self.task = reference.task
        self.model = mujoco.MjModel.from_xml_string(gaitshift.Body(reference.body).mjcf())
        if step_s is not None:
            self.model.opt.timestep = step_s
            self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self.data = mujoco.MjData(self.model)
        self.steps = round(self.task["control_period_s"] / self.model.opt.timestep)
        self.observation_space, self.action_space = reference.observation_space, reference.action_space
        self.starts = []
        for seed in range(64):
            reference.reset(seed=seed)
            self.starts.append(reference.state)

    def _observation(self):
        return np.append(self.data.sensordata, self.omega_v)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = self.starts[self.np_random.integers(64)]
        self.omega_v = self.np_random.uniform(-0.5, 3.5)
        self.periods = 0
        mujoco.mj_forward(self.model, self.data)
        return self._observation(), {}

    def step(self, action):
        self.data.ctrl[:] = action
        mujoco.mj_step(self.model, self.data, self.steps)
        self.periods += 1
        end, position, speed = self.task["termination"], self.data.qpos, self.data.qvel[0]
        terminated = bool(abs(position[2]) > end["pitch_limit_rad"] or position[1] < end["min_hip_height_m"])
        truncated = self.periods * self.task["control_period_s"] >= end["time_limit_s"]
        return self._observation(), self.omega_v * speed - (speed < 0) + 1.0, terminated, truncated, {}


def rates(act, seconds):
    """Steps per second of the clock and of processor time; `act` takes some and says how many."""
    count, start, processor = 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - start < seconds:
        count += act()
    return count / (time.perf_counter() - start), count / (time.process_time() - processor)


def single(env, seconds):
    actions = np.random.default_rng(1).uniform(-1, 1, (256, 2)).astype(np.float32)
    env.reset(seed=1)

    def act():
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return len(actions)

    return rates(act, seconds)


def vector(env, seconds):
    actions = np.random.default_rng(1).uniform(-1, 1, (16, env.num_envs, 2)).astype(np.float32)
    env.reset(seed=1)

    def act():
        for action in actions:
            env.step(action)
        return actions.shape[0] * env.num_envs

    return rates(act, seconds)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=3.0, help="duration of each measurement")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="threads of the larger vector")
    parser.add_argument("--rounds", type=int, default=3, help="the median of so many rounds is given")
    arguments = parser.parse_args()
    name = "gaitshift/PassiveBiped-v0"
    make, make_vec = gymnasium.make, gymnasium.make_vec
    cases = {
        "gaitshift, gymnasium.make": (single, make(name)),
        "gaitshift, gymnasium.make, unwrapped": (single, make(name).unwrapped),
        "gaitshift, make_vec, 1 environment": (vector, make_vec(name, num_envs=1)),
        "gaitshift, make_vec, 16 environments": (vector, make_vec(name, num_envs=16)),
        f"gaitshift, make_vec, 64 environments, {arguments.threads} threads": (
            vector,
            make_vec(name, num_envs=64, threads=arguments.threads),
        ),
        "MuJoCo, the same step": (single, MujocoBiped()),
        "MuJoCo, 1 ms, implicitfast": (single, MujocoBiped(1e-3)),
        "MuJoCo, the same step, SyncVectorEnv, 16 environments": (vector, gymnasium.vector.SyncVectorEnv([MujocoBiped] * 16)),
    }
    found = {case: [] for case in cases}
    for _ in range(arguments.rounds):
        for case, (measure, env) in cases.items():
            found[case].append(measure(env, arguments.seconds))
    print(f"Median of {arguments.rounds} (least to greatest)\n")
    print("| environment | steps per second | steps per second of processor time |")
    print("| --- | --- | --- |")
    for case, pairs in found.items():
        cells = [f"{np.median(v):,.0f} ({min(v):,.0f} to {max(v):,.0f})" for v in zip(*pairs)]
        print(f"| {case} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
