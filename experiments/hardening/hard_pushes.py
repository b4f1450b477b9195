"""Bipeds that are pushed as their episodes begin, most of them where the controller falls."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Protocol

import numpy as np

import gaitshift
from gaitshift.vector import PassiveBipedVectorEnv

# ω_v in s/m and the push forward in N for 0.1 s: what `robust` was left with after two searches, and neighbours of it.
PUSHES = (
    *((0.0, force_n) for force_n in (270.0, 290.0, 305.0, -200.0, -250.0, -300.0)),
    *((1.0, force_n) for force_n in (230.0, 250.0, 300.0)),
    *((2.0, force_n) for force_n in (250.0, 300.0)),
    (3.0, 305.0),
)
PUSH_S = 0.1
EPISODE = 300  # control periods, in which a push is withstood or not
TRIED, TRIED_FOR = 128, 250  # starts of each push that are looked at, and for how many control periods
HARD = 0.6  # share of the episodes that begin where the controller falls, as far as it does
MOTIONS, LONG_S, LAST, EVERY = 16, 7.5, 150, 3  # of which each third of the last control periods may be a start
SIDES, JOINTS = ("right", "left"), (("phi", "rad"), ("h", "m"), ("d", "m"), ("w", "m"))
COORDINATES = ["x_m", "z_m", "theta_rad", *(f"{side}_{joint}_{unit}" for side in SIDES for joint, unit in JOINTS)]
VELOCITIES = [
    *(f"{name}_velocity_{unit}_per_s" for name, unit in (("x", "m"), ("z", "m"), ("theta", "rad"))),
    *(f"{side}_{joint}_velocity_{unit}_per_s" for side in SIDES for joint, unit in JOINTS),
]


class Learning(Protocol):
    """The actor that learns."""

    def act(self, observations: np.ndarray) -> np.ndarray:
        """Without noise, a row for each biped."""

    def save(self, path: Path, seed: int) -> None:
        """Writes it as a controller."""


class HardPushes:
    """As `PassiveBipedVectorEnv` with `autoreset_mode="SameStep"`, without rewards; each push has as many bipeds."""

    def __init__(self, count: int, controller: Path, rng: np.random.Generator, actor: Learning) -> None:
        self.controller, self.rng, self.actor = controller, rng, actor
        self.each = max(1, count // len(PUSHES))
        self.num_envs = self.each * len(PUSHES)
        self.environments = [self.environment(force_n, self.each) for _, force_n in PUSHES]
        self.omega_v = np.repeat([omega_v for omega_v, _ in PUSHES], self.each)
        self.age = np.zeros(self.num_envs, int)
        self.starts: list[np.ndarray] = []  # of each push: positions and velocities side by side
        self.hard: list[np.ndarray] = []  # those from which it falls

    def environment(self, force_n: float, count: int) -> PassiveBipedVectorEnv:
        push = {"forward_n": force_n, "start_s": 0.0, "duration_s": PUSH_S}
        return PassiveBipedVectorEnv(
            count, controller=self.controller, autoreset_mode="Disabled", disturbance={"pushes": [push]}
        )

    def set_omega_v(self, omega_v: np.ndarray) -> None:
        """Each keeps its own."""

    def look(self, actor: Learning) -> None:
        """Finds anew where the actor falls, and says from how many of the starts that are tried."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "now.safetensors"
            actor.save(path, 0)
            motions = self.motions(gaitshift.Controller.load(path))
        self.starts, self.hard = [], []
        for omega_v, force_n in PUSHES:
            pool = motions[omega_v]
            starts = pool[self.rng.permutation(len(pool))[:TRIED]]
            self.starts.append(starts)
            self.hard.append(starts[self.falls(actor, starts, omega_v, force_n)])
        told = (f"{force_n:g} N at {omega_v:g}: {len(hard)}" for (omega_v, force_n), hard in zip(PUSHES, self.hard))
        print(f"falls from {TRIED} starts each, {', '.join(told)}", flush=True)

    def motions(self, controller: gaitshift.Controller) -> dict[float, np.ndarray]:
        """States of undisturbed motions at each command."""
        states = {}
        for omega_v in sorted({omega_v for omega_v, _ in PUSHES}):
            seeds = self.rng.integers(2**31, size=MOTIONS)
            recordings = [controller.record(omega_v, LONG_S, seed=int(seed)) for seed in seeds]
            columns = [np.stack([recording[name] for name in COORDINATES + VELOCITIES], 1) for recording in recordings]
            states[omega_v] = np.concatenate([rows[-LAST::EVERY] for rows in columns])
        return states

    def falls(self, actor: Learning, starts: np.ndarray, omega_v: float, force_n: float) -> np.ndarray:
        """From which of the starts it falls."""
        environment = self.environment(force_n, len(starts))
        options = {"state": (starts[:, :11], starts[:, 11:]), "omega_v": np.full(len(starts), omega_v)}
        observations, _ = environment.reset(seed=0, options=options)
        fell = np.zeros(len(starts), bool)
        for _ in range(TRIED_FOR):
            observations, _, terminated, _, _ = environment.step(actor.act(observations))
            fell |= terminated
            if terminated.any():
                environment.reset(options={**options, "reset_mask": terminated.copy()})
        return fell

    def drawn(self, push: int) -> dict[str, Any]:
        """Where episodes of a push begin, one for each of its bipeds."""
        starts, hard = self.starts[push], self.hard[push]
        rows = starts[self.rng.integers(len(starts), size=self.each)]
        if len(hard):
            chosen = self.rng.random(self.each) < HARD
            rows = np.where(chosen[:, None], hard[self.rng.integers(len(hard), size=self.each)], rows)
        return {"state": (rows[:, :11], rows[:, 11:]), "omega_v": np.full(self.each, PUSHES[push][0])}

    def reset(self, *, options: dict[str, Any], seed: int) -> tuple[np.ndarray, dict[str, Any]]:
        self.look(self.actor)
        observations = []
        for push, environment in enumerate(self.environments):
            begins = self.drawn(push)
            observations.append(environment.reset(seed=int(self.rng.integers(2**31)), options=begins)[0])
        self.age[:] = self.rng.integers(0, EPISODE // 2, self.num_envs)
        return np.concatenate(observations), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, None, np.ndarray, np.ndarray, dict[str, Any]]:
        parts: list[list[np.ndarray]] = [[], [], []]
        forces = ("right_normal_force_n", "left_normal_force_n")
        info: dict[str, Any] = {name: np.zeros(self.num_envs) for name in forces}
        info["final_obs"] = np.full(self.num_envs, None, object)
        self.age += 1
        for push, environment in enumerate(self.environments):
            begin = push * self.each
            own = slice(begin, begin + self.each)
            observations, _, terminated, truncated, said = environment.step(actions[own])
            cut_off = ~terminated & (truncated | (self.age[own] >= EPISODE))
            over = terminated | cut_off
            for name in forces:
                info[name][own] = said[name]
            if over.any():
                observations = observations.copy()
                for biped in np.flatnonzero(over):
                    info["final_obs"][begin + biped] = observations[biped].copy()
                begun, _ = environment.reset(options={**self.drawn(push), "reset_mask": over})
                observations[over] = begun[over]
                self.age[own][over] = 0
            for part, rows in zip(parts, (observations, terminated, cut_off)):
                part.append(rows)
        observations, terminated, cut_off = (np.concatenate(part) for part in parts)
        return observations, None, terminated, cut_off, info
