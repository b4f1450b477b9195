"""Bipeds that are pushed as their episodes begin, or come to a step up, most of them where the controller falls."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

import gaitshift
from gaitshift.vector import PassiveBipedVectorEnv


@dataclass(frozen=True)
class Case:
    """What its bipeds meet: a push as the episode begins, or a step up that lies ahead."""

    omega_v: float  # s/m
    forward_n: float = 0.0
    step_up_m: float = 0.0

    def __str__(self) -> str:
        return f"{self.forward_n:g} N at {self.omega_v:g}" if self.forward_n else f"{self.step_up_m:g} m at {self.omega_v:g}"

    @property
    def disturbance(self) -> dict[str, Any]:
        if self.step_up_m:
            return {"terrain": {"steps": [{"height_m": self.step_up_m, "at_m": STEP_AT_M}]}}
        return {"pushes": [{"forward_n": self.forward_n, "start_s": 0.0, "duration_s": PUSH_S}]}


# What `robust` was left with after two searches, and neighbours of it.
PUSHES = (
    *(Case(0.0, force_n) for force_n in (270.0, 290.0, 305.0, -200.0, -250.0, -300.0)),
    *(Case(1.0, force_n) for force_n in (230.0, 250.0, 300.0)),
    *(Case(2.0, force_n) for force_n in (250.0, 300.0)),
    Case(3.0, 305.0),
)
STEPS = tuple(Case(0.0, step_up_m=step_up_m) for step_up_m in (0.01, 0.015, 0.02, 0.025, 0.03, 0.035))
PUSH_S = 0.1
STUCK_M_PER_S, FORGETS = 0.15, 0.99  # at a step, a mean speed that counts as a fall, over about 1 s
STEP_AT_M, AHEAD_M = 100.0, (0.2, 0.7)  # where a step's face is, and how far before it the hip is as an episode begins
EPISODE = 300  # control periods, in which a push is withstood or not
TRIED, TRIED_STEPS, TRIED_FOR = 128, 512, 300  # starts of each push and step that are looked at; for how many control periods
HARD = 0.6  # share of the episodes that begin where the controller falls, as far as it does
MOTIONS, LONG_S, LAST, EVERY = 16, 7.5, 150, 3  # of which each third of the last control periods may be a start
SIDES, JOINTS = ("right", "left"), (("phi", "rad"), ("h", "m"), ("d", "m"), ("w", "m"))
COORDINATES = ["x_m", "z_m", "theta_rad", *(f"{side}_{joint}_{unit}" for side in SIDES for joint, unit in JOINTS)]
VELOCITIES = [
    *(f"{name}_velocity_{unit}_per_s" for name, unit in (("x", "m"), ("z", "m"), ("theta", "rad"))),
    *(f"{side}_{joint}_velocity_{unit}_per_s" for side in SIDES for joint, unit in JOINTS),
]


def forgetful(speed: np.ndarray, observations: np.ndarray) -> np.ndarray:
    """The mean of the speed in m/s over about a second, one control period later."""
    return FORGETS * speed + (1 - FORGETS) * observations[:, 0]


class Learning(Protocol):
    """The actor that learns."""

    def act(self, observations: np.ndarray) -> np.ndarray:
        """Without noise, a row for each biped."""

    def save(self, path: Path, seed: int) -> None:
        """Writes it as a controller."""


def as_controller(actor: Learning) -> gaitshift.Controller:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "now.safetensors"
        actor.save(path, 0)
        return gaitshift.Controller.load(path)


def environment(case: Case, count: int, controller: Path) -> PassiveBipedVectorEnv:
    return PassiveBipedVectorEnv(count, controller=controller, autoreset_mode="Disabled", disturbance=case.disturbance)


def falls(actor: Learning, starts: np.ndarray, case: Case, controller: Path, periods: int = TRIED_FOR) -> np.ndarray:
    """From which of the starts it falls, or gets stuck; a row has positions and velocities."""
    bipeds = environment(case, len(starts), controller)
    options = {"state": (starts[:, :11], starts[:, 11:]), "omega_v": np.full(len(starts), case.omega_v)}
    observations, _ = bipeds.reset(seed=0, options=options)
    fell = np.zeros(len(starts), bool)
    actions = np.zeros((len(starts), 2), np.float32)
    speed = observations[:, 0].copy()
    for _ in range(periods):
        actions[~fell] = actor.act(observations[~fell])
        observations, _, terminated, _, _ = bipeds.step(actions)
        fell |= terminated
        if case.step_up_m:
            speed = forgetful(speed, observations)
            fell |= speed < STUCK_M_PER_S
        if terminated.any():
            bipeds.reset(options={**options, "reset_mask": terminated.copy()})
        if fell.all():
            break
    return fell


class HardCases:
    """As `PassiveBipedVectorEnv` with `autoreset_mode="SameStep"`, without rewards; each push, or step, has as many bipeds."""

    def __init__(
        self, count: int, controller: Path, rng: np.random.Generator, actor: Learning, cases: Sequence[Case] = PUSHES
    ) -> None:
        self.controller, self.rng, self.actor, self.cases = controller, rng, actor, cases
        self.each = max(1, count // len(cases))
        self.num_envs = self.each * len(cases)
        self.environments = [environment(case, self.each, controller) for case in cases]
        self.omega_v = np.repeat([case.omega_v for case in cases], self.each)
        self.age = np.zeros(self.num_envs, int)
        self.speed = np.ones(self.num_envs)  # m/s, the mean of about a second
        self.starts: list[np.ndarray] = []  # of each case: positions and velocities side by side
        self.hard: list[np.ndarray] = []  # those from which it falls

    def set_omega_v(self, omega_v: np.ndarray) -> None:
        """Each keeps its own."""

    def look(self, actor: Learning) -> None:
        """Finds anew where the actor falls, or gets stuck at a step, and says from how many of the starts that are tried."""
        motions = self.motions(as_controller(actor))
        self.starts, self.hard = [], []
        for case in self.cases:
            pool = motions[case.omega_v]
            tried = TRIED_STEPS if case.step_up_m else TRIED
            starts = pool[self.rng.permutation(len(pool))[:tried]]
            if case.step_up_m:
                starts[:, 0] = STEP_AT_M - self.rng.uniform(*AHEAD_M, len(starts))
            self.starts.append(starts)
            self.hard.append(starts[falls(actor, starts, case, self.controller)])
        told = (f"{case}: {len(hard)} of {len(starts)}" for case, starts, hard in zip(self.cases, self.starts, self.hard))
        print(f"falls under {', '.join(told)}", flush=True)

    def motions(self, controller: gaitshift.Controller) -> dict[float, np.ndarray]:
        """States of undisturbed motions at each command."""
        states = {}
        for omega_v in sorted({case.omega_v for case in self.cases}):
            seeds = self.rng.integers(2**31, size=MOTIONS)
            recordings = [controller.record(omega_v, LONG_S, seed=int(seed)) for seed in seeds]
            columns = [np.stack([recording[name] for name in COORDINATES + VELOCITIES], 1) for recording in recordings]
            states[omega_v] = np.concatenate([rows[-LAST::EVERY] for rows in columns])
        return states

    def drawn(self, index: int) -> dict[str, Any]:
        """Where episodes of a case begin, one for each of its bipeds."""
        starts, hard = self.starts[index], self.hard[index]
        rows = starts[self.rng.integers(len(starts), size=self.each)]
        if len(hard):
            chosen = self.rng.random(self.each) < HARD
            rows = np.where(chosen[:, None], hard[self.rng.integers(len(hard), size=self.each)], rows)
        return {"state": (rows[:, :11], rows[:, 11:]), "omega_v": np.full(self.each, self.cases[index].omega_v)}

    def reset(self, *, options: dict[str, Any], seed: int) -> tuple[np.ndarray, dict[str, Any]]:
        self.look(self.actor)
        observations = []
        for index, bipeds in enumerate(self.environments):
            begins = self.drawn(index)
            observations.append(bipeds.reset(seed=int(self.rng.integers(2**31)), options=begins)[0])
        self.age[:] = self.rng.integers(0, EPISODE // 2, self.num_envs)
        return np.concatenate(observations), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, None, np.ndarray, np.ndarray, dict[str, Any]]:
        parts: list[list[np.ndarray]] = [[], [], []]
        forces = ("right_normal_force_n", "left_normal_force_n")
        info: dict[str, Any] = {name: np.zeros(self.num_envs) for name in forces}
        info["final_obs"] = np.full(self.num_envs, None, object)
        self.age += 1
        for index, bipeds in enumerate(self.environments):
            begin = index * self.each
            own = slice(begin, begin + self.each)
            observations, _, terminated, truncated, said = bipeds.step(actions[own])
            if self.cases[index].step_up_m:
                self.speed[own] = forgetful(self.speed[own], observations)
                terminated = terminated | (self.speed[own] < STUCK_M_PER_S)
            cut_off = ~terminated & (truncated | (self.age[own] >= EPISODE))
            over = terminated | cut_off
            for name in forces:
                info[name][own] = said[name]
            if over.any():
                observations = observations.copy()
                for biped in np.flatnonzero(over):
                    info["final_obs"][begin + biped] = observations[biped].copy()
                begun, _ = bipeds.reset(options={**self.drawn(index), "reset_mask": over})
                observations[over] = begun[over]
                self.age[own][over] = 0
                self.speed[own][over] = begun[over, 0]
            for part, rows in zip(parts, (observations, terminated, cut_off)):
                part.append(rows)
        observations, terminated, cut_off = (np.concatenate(part) for part in parts)
        return observations, None, terminated, cut_off, info
