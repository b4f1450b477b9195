"""Bipeds in MuJoCo, on its own default contact, stepped as `PassiveBipedVectorEnv` steps ours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import gaitshift

# Ten times that of the file, with an integrator for it: near enough to learn on. What was learned is judged with the file's.
TIME_STEP_S = 0.002
EPISODE = 1000  # control periods


def model(controller: gaitshift.Controller) -> mujoco.MjModel:
    """The controller's body as it is exported, without the contact that ours is translated into."""
    mjcf = gaitshift.Body(controller.body).mjcf(controller.task)
    for attribute in ("solref", "solimp", "impratio"):
        mjcf = re.sub(rf'\s+{attribute}="[^"]*"', "", mjcf)
    made = mujoco.MjModel.from_xml_string(mjcf)
    made.opt.timestep, made.opt.integrator = TIME_STEP_S, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    made.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    made.opt.tolerance, made.opt.ls_tolerance = 1e-5, 0.05
    return made


class MujocoBipeds:
    """As `PassiveBipedVectorEnv` with `autoreset_mode="SameStep"`, without rewards. Info has just the normal forces, in N at
    the end of the control period instead of its mean. Episodes begin at random starts, and end with a fall or after 10 s."""

    def __init__(self, count: int, controller: Path, rng: np.random.Generator) -> None:
        loaded = gaitshift.Controller.load(controller)
        self.num_envs, self.rng, self.model = count, rng, model(loaded)
        self.bipeds = [mujoco.MjData(self.model) for _ in range(count)]
        self.starts = gaitshift.PassiveBipedEnv(controller=loaded)
        self.steps = round(loaded.task["control_period_s"] / TIME_STEP_S)
        self.end, self.diverged_speed = loaded.task["termination"], loaded.body["diverged_speed"]
        feet = [self.model.body(f"{side}_foot").id for side in ("right", "left")]
        self.foot_of_geom = np.array([feet.index(body) if body in feet else -1 for body in self.model.geom_bodyid])
        self.age = rng.integers(0, EPISODE, count)
        self.positions, self.velocities = np.zeros((2, count, 11))

    def set_omega_v(self, omega_v: np.ndarray) -> None:
        self.omega_v = np.array(omega_v, float)

    def reset(self, *, options: dict[str, Any], seed: int) -> tuple[np.ndarray, dict[str, Any]]:
        self.rng = np.random.default_rng(seed)
        self.set_omega_v(options["omega_v"])
        for index in range(self.num_envs):
            self.begin(index)
        return self.observations(), {}

    def begin(self, index: int) -> None:
        self.starts.reset(seed=int(self.rng.integers(2**31)), options={"omega_v": float(self.omega_v[index])})
        data = self.bipeds[index]
        mujoco.mj_resetData(self.model, data)
        data.qpos[:], data.qvel[:] = self.starts.state
        self.positions[index], self.velocities[index] = data.qpos, data.qvel

    def observations(self) -> np.ndarray:
        position, velocity = self.positions.T, self.velocities.T
        rows = [velocity[0], position[2], velocity[2]]
        for joint in (4, 8, 3, 7):  # h and φ of both legs
            rows += [position[joint], velocity[joint]]
        return np.stack([*rows, velocity[5], velocity[9], self.omega_v], 1)

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, None, np.ndarray, np.ndarray, dict[str, Any]]:
        force_n = np.zeros((self.num_envs, 2))
        for index, data in enumerate(self.bipeds):
            data.ctrl[:] = actions[index]
            mujoco.mj_step(self.model, data, self.steps)
            self.positions[index], self.velocities[index] = data.qpos, data.qvel
            if data.ncon:
                rows = data.contact.efc_address
                touching = rows >= 0
                feet = self.foot_of_geom[data.contact.geom[touching, 1]]
                np.add.at(force_n[index], feet, data.efc_force[rows[touching]])
        self.age += 1
        diverged = ~(np.isfinite(self.positions).all(1) & (np.abs(self.velocities) <= self.diverged_speed).all(1))
        low = self.positions[:, 1] < self.end["min_hip_height_m"]
        fell = diverged | low | (np.abs(self.positions[:, 2]) > self.end["pitch_limit_rad"])
        cut_off = ~fell & (self.age >= EPISODE)
        observations = self.observations()
        info: dict[str, Any] = {"right_normal_force_n": force_n[:, 0], "left_normal_force_n": force_n[:, 1]}
        over = np.flatnonzero(fell | cut_off)
        if len(over):
            info["final_obs"] = np.full(self.num_envs, None, object)
            for index in over:
                info["final_obs"][index] = observations[index]
                self.begin(index)
            self.age[over] = 0
            observations = self.observations()
        return observations, None, fell, cut_off, info
