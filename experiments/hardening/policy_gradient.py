"""Hardens a controller by policy gradients: it meets strong pushes, and a fall costs.

Proximal policy optimisation from a controller that exists (Schulman et al. 2017). The only reward is -1 for a fall. What is not
to change is held by a second term: in motions that nothing disturbs, or little, the actor imitates the controller as it was;
after pushes forward away from ω_v = 0 too, and near 0 with `--near-zero`. Many of the bipeds have other bodies, on which it
is hardly held.
With `--gaits` steps cost, too, that lack something of the commanded gait, a walk at ω_v = 0 or a run from 1 on: of undisturbed
bipeds here, on softer ground, and in MuJoCo on its own default contact. With `--anew` the controller to begin with, which may
do neither, is hardly imitated from 0.6 to 2.8, and little beyond.
With `--hard-pushes` half of the bipeds begin with pushes from where the controller falls, with `--hard-steps` some of them
before steps up where it falls or gets stuck; every 20 iterations these are looked for anew.
With `--raised-like` many of the bipeds have the hip's mass far above its axis; there two other controllers are imitated, which
have learned such bodies alone. `--after-pushes 30` holds meanwhile what it did before after pushes; with `--free-start-s 2`
nothing is held in the first 2 s from random starts, where these bodies and ours still look alike, and need one answer.
`--imitation-steps 200` imitates, after each update, in 200 steps more, from what the last iterations saw.
Exploration noise lasts for about 0.1 s, because noise that is new in every control period hardly moves the body; the
gradient is that of what is new in it. The actor is the mean of a network and its mirror image, so the controller to begin with
must be one.

Beside the controllers, OUT/log.csv has a row for each iteration: how far its update moved the actor (divergence, at most some
0.02 for an update to be trusted), falls per second in each group of bipeds, how far the actor is from what it imitates
(mean |Δa|²), and what a step lacks of its gait where that costs. Needs PyTorch and safetensors beside the package, for
`--gaits` MuJoCo; an iteration takes about 10 s of one core, longer with `--gaits`:

    pip install torch safetensors mujoco
    before=controllers/robust/shaped-when-fast.safetensors
    python experiments/hardening/policy_gradient.py --controller $before --out out/pg
    python experiments/hardening/falls.py robust out/pg/400.safetensors
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gaits import Steps
from hard_cases import PUSHES, STEPS, Case, HardCases
from safetensors import safe_open
from safetensors.torch import save_file
from torch import Tensor, nn

from gaitshift.vector import PassiveBipedVectorEnv

CONTROL_PERIODS = 128  # of a biped in an iteration
CONTROL_PERIOD_S = 0.01  # of `robust`
GAMMA, LAMBDA = 0.998, 0.97  # a horizon of 5 s
CLIP = 0.2
EPOCHS, ROWS = 3, 16384
REMEMBERED, IMITATION_ROWS = 8, 4096  # iterations, with `--imitation-steps`; rows of one
# Right and left exchanged.
OBSERVATION_MIRROR = [0, 1, 2, 5, 6, 3, 4, 9, 10, 7, 8, 12, 11, 13]
ACTION_MIRROR = [1, 0]
OMEGA_V = 13  # its place among the observations
HARDLY = 0.05  # a weight of what the controller did before
NEAR_ZERO = 0.4  # s/m, of a command; beyond it what search has taught about pushes forward is imitated
# s/m and weight: from these commands on no more of what it did before is imitated with `--anew`. The run is held a little.
ANEW = ((0.6, HARDLY), (2.8, 5.0))
AT_SPEED = 2.5  # s/m, the least command at which `--at-speed-like` is imitated
LOOK_EVERY = 20  # iterations, with `--hard-pushes`
CRITIC_ALONE, WARM_UP = 6, 12  # iterations at first, and after them, in which the actor's rate rises
SPREAD = 7  # iterations at first, of 1.28 s each: an episode lasts 10 s
RAISED_WEIGHT, RAISED_AT_MOST = 30.0, 2.0  # of `--raised-like`; s/m, the command from which on they do not get faster
LEAST_NOISE, NOISE_LASTS = 0.02, 0.9  # standard deviation; what remains of the noise in the next control period


@dataclass(frozen=True)
class Group:
    """Bipeds that are disturbed alike."""

    name: str
    share: float
    randomization: dict[str, Any] | None
    keep: float  # weight of what the controller did before
    elsewhere: float  # the same at commands beyond NEAR_ZERO
    forward: bool = False  # whether pushed forward, so that `--at-speed-like` is imitated at speed
    commands: str = "0 and whole"  # which it is given, see `Bipeds.drawn`
    gait: bool = False  # whether steps cost that lack something of the commanded gait
    in_mujoco: bool = False
    hard: bool = False  # whether it meets what the controller falls from, see `HardCases`
    taught: bool = False  # whether the controllers of `--raised-like` are imitated


def pushed(forward_n: tuple[float, float] = (0, 0), up_n: tuple[float, float] = (0, 0)) -> dict[str, Any]:
    """Pushes of 0.1 s, 2.5 s apart in the mean."""
    return {"pushes": {"interval_s": 2.5, "forward_n": forward_n, "up_n": up_n, "duration_s": (0.1, 0.1)}}


WEAK = {
    "share": 0.7,
    "latency_s": (0.0, 0.02),
    "noise": {
        "x_velocity_m_per_s": 0.2,
        "theta_rad": 0.04,
        "theta_velocity_rad_per_s": 0.2,
        "h_m": 0.01,
        "h_velocity_m_per_s": 0.2,
        "phi_rad": 0.03,
        "phi_velocity_rad_per_s": 0.2,
        "d_velocity_m_per_s": 0.2,
    },
    "pushes": {"interval_s": 3.0, "forward_n": (-150, 150), "up_n": (-150, 150), "duration_s": (0.1, 0.1)},
    "terrain": {"slope_rad": (-0.06, 0.06), "steps": {"height_m": (-0.03, 0.03)}},
}
SEGMENTS = (
    *(f"{name}_mass_kg" for name in ("hip", "thigh", "tibia", "foot")),
    *(f"{name}_inertia_kg_m2" for name in ("hip", "thigh", "tibia", "foot")),
    *(f"{name}_distance_m" for name in ("thigh", "tibia")),
)
# A foot's centre of mass further out would lie below the sole.
OTHER_BODY = {**dict.fromkeys(SEGMENTS, (0.8, 1.2)), "foot_distance_m": (0.8, 1.05)}
SOFT_GROUND = {"body": {"contact_stiffness": (0.2, 0.5), "contact_dissipation_s_per_m": (5.0, 12.0)}}
STEPS_UP = {"terrain": {"steps": {"height_m": (0.005, 0.035), "spacing_m": (1.5, 3.0)}}}


# Of the others, where half of the bipeds are pushed hard.
SHARES_BESIDE_HARD = {
    "other bodies": 0.06,
    "raised mass": 0.16,
    "forward": 0.08,
    "backward": 0.05,
    "down": 0.05,
    "any direction": 0.06,
}


# The same where half of them have the mass far above the axis.
SHARES_BESIDE_RAISED = {"other bodies": 0.08, "raised mass": 0.16, "forward": 0.12, "backward": 0.08}


@dataclass(frozen=True)
class Held:
    """Weights of what the controller did before, where not all groups have the same."""

    undisturbed: float
    elsewhere: float  # after pushes forward beyond NEAR_ZERO
    near_zero: float  # within it, after pushes forward, backward and in any direction
    after_pushes: float = HARDLY  # after hard cases, pushes down, and those backward beyond NEAR_ZERO
    walk: float | None = None  # undisturbed within NEAR_ZERO, where it is not as beyond
    hard_near_zero: float | None = None  # in hard cases within NEAR_ZERO, where it is not as beyond


@dataclass(frozen=True)
class Extras:
    """Which groups there are beside those that all runs have."""

    gaits: bool = False
    anew: bool = False
    hard: bool = False
    raised_m: Sequence[float] = ()  # least and greatest height of the hip's mass above its axis
    raised_near_zero: float = RAISED_WEIGHT


def groups(held: Held, extras: Extras = Extras()) -> list[Group]:
    """Who meets what."""
    walk = held.undisturbed if held.walk is None else held.walk
    any_direction = pushed(forward_n=(-300, 300), up_n=(-300, 300))
    parts = [
        Group("undisturbed", 0.08, None, walk, held.undisturbed, commands="all", gait=extras.gaits),
        Group("weak", 0.15, WEAK, 10.0, 10.0, commands="all"),
        Group("other bodies", 0.15, {"body": OTHER_BODY, "hip_com_height_m": (-0.1, 0.0)}, HARDLY, HARDLY, commands="all"),
        Group("raised mass", 0.25, {"body": OTHER_BODY, "hip_com_height_m": (0.0, 0.07)}, HARDLY, HARDLY, commands="all"),
        Group("forward", 0.22, pushed(forward_n=(200, 360)), held.near_zero, held.elsewhere, forward=True),
        Group("backward", 0.13, pushed(forward_n=(-360, -100)), held.near_zero, held.after_pushes),
        Group("down", 0.07, pushed(up_n=(-360, -50)), held.after_pushes, held.after_pushes),
        Group("any direction", 0.10, any_direction, held.near_zero, held.elsewhere, forward=True),
        Group("steps up", 0.05, STEPS_UP, HARDLY, HARDLY),
    ]
    if extras.gaits:
        parts += [
            Group("soft ground", 0.05, SOFT_GROUND, HARDLY, HARDLY, commands="of gaits", gait=True),
            Group("in MuJoCo", 0.15, None, HARDLY, HARDLY, commands="of gaits", gait=True, in_mujoco=True),
        ]
    if extras.anew:
        parts.append(Group("to run", 0.25, None, HARDLY, HARDLY, commands="to run", gait=True))
    if extras.hard:
        parts = [replace(part, share=SHARES_BESIDE_HARD.get(part.name, part.share)) for part in parts]
        near_zero = held.after_pushes if held.hard_near_zero is None else held.hard_near_zero
        parts.append(Group("hard cases", 0.5, None, near_zero, held.after_pushes, hard=True))
    if extras.raised_m:
        parts = [replace(part, share=SHARES_BESIDE_RAISED.get(part.name, part.share)) for part in parts]
        raised, weights = {"hip_com_height_m": tuple(extras.raised_m)}, (extras.raised_near_zero, RAISED_WEIGHT)
        parts.append(Group("far raised", 0.5, raised, *weights, commands="all", taught=True))
    return parts


def read(path: Path) -> tuple[dict[str, str], dict[str, Tensor]]:
    """What a controller's file says of itself, and its tensors."""
    if not path.is_file():
        raise SystemExit(f"{path}: no such file; give the controller.safetensors of a run or a hardening")
    with safe_open(path, "pt") as file:
        return file.metadata(), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118, it is no dict


def command_line() -> str:
    """The command that runs, as a controller's file records it."""
    return " ".join([f"python experiments/hardening/{Path(sys.argv[0]).name}", *sys.argv[1:]])


class Actor(nn.Module):
    """The mean of a network of two layers and its mirror image, as a controller's file holds it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.metadata, self.file = read(path)
        description = json.loads(self.metadata["gaitshift"])
        refused = f"{path}: no mean of a network of two layers and its mirror image, so it cannot be trained on"
        if len(description["network"]["hidden"]) != 2:
            raise SystemExit(refused)
        self.scale = torch.tensor(description["observation_scale"])
        units = self.file["layers.0.bias"].shape[0] // 2
        self.layers = nn.ModuleList([nn.Linear(14, units), nn.Linear(units, units), nn.Linear(units, 2)])
        first, second, output = self.layers
        with torch.no_grad():
            for layer, name, inputs in ((first, "layers.0", 14), (second, "layers.1", units)):
                layer.weight.copy_(self.file[f"{name}.weight"][:units, :inputs])
                layer.bias.copy_(self.file[f"{name}.bias"][:units])
            output.weight.copy_(2 * self.file["output.weight"][:2, :units])
            output.bias.copy_(self.file["output.bias"][:2])
            looked_at = torch.randn(64, 14)
            error = (self(looked_at) - torch.tanh(self.written(looked_at))).abs().max()
        if error > 1e-4:
            raise SystemExit(refused)

    def half(self, observations: Tensor) -> Tensor:
        first, second, output = self.layers
        return output(torch.relu(second(torch.relu(first(observations)))))

    def forward(self, observations: Tensor) -> Tensor:
        mirrored = self.half(observations[:, OBSERVATION_MIRROR])[:, ACTION_MIRROR]
        return torch.tanh(0.5 * (self.half(observations) + mirrored))

    def act(self, observations: np.ndarray) -> np.ndarray:
        """Without noise, from what is not scaled yet."""
        with torch.no_grad():
            return self(torch.from_numpy((observations * self.scale.numpy()).astype(np.float32))).numpy()

    def written(self, observations: Tensor) -> Tensor:
        """What the file's network gives, before the tanh."""
        rows = observations
        for name in ("layers.0", "layers.1"):
            rows = torch.relu(rows @ self.file[f"{name}.weight"].T + self.file[f"{name}.bias"])
        return (rows @ self.file["output.weight"].T + self.file["output.bias"])[:, :2]

    def save(self, path: Path, seed: int) -> None:
        """Writes a controller: both halves side by side."""
        description = json.loads(self.metadata["gaitshift"])
        description["provenance"] |= {"command": command_line(), "seed": seed}
        first, second, output = self.layers
        units = first.bias.shape[0]
        tensors = {name: tensor.clone() for name, tensor in self.file.items()}
        with torch.no_grad():
            tensors["layers.0.weight"][:] = torch.cat([first.weight, first.weight[:, OBSERVATION_MIRROR]])
            tensors["layers.1.weight"][:] = torch.block_diag(second.weight, second.weight)
            for name, layer in (("layers.0", first), ("layers.1", second)):
                tensors[f"{name}.bias"][:] = layer.bias.repeat(2)
            tensors["output.weight"][:2, :units] = output.weight / 2
            tensors["output.weight"][:2, units:] = output.weight[ACTION_MIRROR] / 2
            tensors["output.bias"][:2] = (output.bias + output.bias[ACTION_MIRROR]) / 2
        save_file(tensors, path, self.metadata | {"gaitshift": json.dumps(description)})


class Bipeds:
    """All groups side by side."""

    def __init__(
        self,
        controller: Path,
        parts: list[Group],
        count: int,
        at_zero: float,
        rng: np.random.Generator,
        anew: bool = False,
        begin: Path | None = None,
        cases: Sequence[Case] = PUSHES,
    ) -> None:
        self.parts, self.at_zero, self.rng, self.anew = parts, at_zero, rng, anew
        self.begin, self.cases = begin or controller, cases
        self.hard: HardCases | None = None
        self.environments, self.commands, observations, group = [], [], [], []
        for index, part in enumerate(parts):
            environment = self.environment(part, max(1, round(count * part.share)), controller)
            bipeds = environment.num_envs
            group += [index] * bipeds
            commands = self.drawn(part, bipeds)
            first, _ = environment.reset(seed=int(rng.integers(2**31)), options={"omega_v": commands})
            self.environments.append(environment)
            self.commands.append(commands)
            observations.append(first)
        self.group = np.array(group)
        self.count = len(group)
        self.steps = Steps(self.count)
        self.costs = np.array([part.gait for part in parts])[self.group]  # which pay for what their steps lack
        self.age = np.zeros(self.count, int)  # control periods since the episode began
        self.observations = np.concatenate(observations).astype(np.float32)

    def environment(self, part: Group, count: int, controller: Path) -> Any:
        if part.in_mujoco:
            from mujoco_bipeds import MujocoBipeds  # here, so that MuJoCo is not needed without it

            return MujocoBipeds(count, controller, self.rng)
        if part.hard:
            self.hard = HardCases(count, controller, self.rng, Actor(self.begin), self.cases)
            return self.hard
        return PassiveBipedVectorEnv(
            count, controller=controller, randomization=part.randomization, autoreset_mode="SameStep"
        )

    def drawn(self, part: Group, count: int) -> np.ndarray:
        """Commands: 0, near 0, and the rest; those of a walk and of a run where gaits are learned on other ground."""
        if part.hard and self.hard:
            return self.hard.omega_v.copy()
        chance = self.rng.random(count)
        if part.commands == "to run":
            return self.rng.uniform(0.9, 2.8, count)
        if part.commands == "of gaits":
            high = np.where(chance < 0.6, self.rng.uniform(2.9, 3.5, count), self.rng.uniform(-0.5, 3.5, count))
            return np.where(chance < 0.3, self.rng.uniform(-0.05, 0.05, count), high)
        if part.commands == "all":
            return np.where(chance < 0.35, self.rng.uniform(-0.3, 0.3, count), self.rng.uniform(-0.5, 3.5, count))
        low = np.where(self.rng.random(count) < 0.8, 0.0, self.rng.uniform(-0.2, 0.3, count))
        whole = self.rng.choice([1.0, 2.0, 3.0, 3.0], count)
        high = np.where(self.rng.random(count) < 0.3, self.rng.uniform(-0.2, 3.5, count), whole)
        return np.where(chance < self.at_zero, low, high)

    def keep(self) -> Tensor:
        """The weight of what the controller did before, of each."""
        parts = zip(self.parts, self.commands)
        weights = [np.where(np.abs(omega_v) > NEAR_ZERO, part.elsewhere, part.keep) for part, omega_v in parts]
        weight, omega_v = np.concatenate(weights), np.concatenate(self.commands)
        if self.anew:
            commands, weights = zip(*ANEW)
            most = np.array([np.inf, *weights])[np.searchsorted(commands, omega_v, side="right")]
            weight = np.minimum(weight, most)
        return torch.from_numpy(weight.astype(np.float32))

    def spread(self) -> None:
        """Begins some episodes anew, so that those of a group do not all end, and begin again, at once."""
        begin = 0
        for part, environment, commands in zip(self.parts, self.environments, self.commands):
            end = begin + environment.num_envs
            # The others' episodes have ages of their own from the first.
            if not part.hard and not part.in_mujoco:
                over = self.rng.random(environment.num_envs) < 1 / SPREAD
                if over.any():
                    observations, _ = environment.reset(options={"omega_v": commands, "reset_mask": over})
                    self.observations[begin:end][over] = observations[over]
                    self.age[begin:end][over] = 0
            begin = end

    def change_commands(self) -> None:
        """Of one in twenty, in the middle of an episode."""
        begin = 0
        for index, (part, environment) in enumerate(zip(self.parts, self.environments)):
            count = environment.num_envs
            changed = self.rng.random(count) < 0.05
            self.commands[index] = np.where(changed, self.drawn(part, count), self.commands[index])
            environment.set_omega_v(self.commands[index])
            self.observations[begin : begin + count, OMEGA_V] = self.commands[index]
            begin += count

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, dict[int, np.ndarray], np.ndarray, np.ndarray]:
        """Which fell, whose episode is over, the last observations of those that were cut off, which have a touchdown in a
        group where steps may cost, and what their steps lack of the commanded gait."""
        fell, over, force_n, last = [], [], [], {}
        begin = 0
        for environment in self.environments:
            end = begin + environment.num_envs
            self.observations[begin:end], _, terminated, truncated, info = environment.step(actions[begin:end])
            for biped in np.flatnonzero(truncated & ~terminated):
                last[begin + biped] = info["final_obs"][biped]
            fell.append(terminated)
            over.append(terminated | truncated)
            force_n.append(np.stack([info["right_normal_force_n"], info["left_normal_force_n"]], 1))
            begin = end
        ended = np.concatenate(over)
        self.age = np.where(ended, 0, self.age + 1)
        landed, lack = self.steps.lack(np.concatenate(force_n), np.concatenate(self.commands), ended)
        return np.concatenate(fell), ended, last, landed & self.costs, np.where(self.costs, lack, 0)


@dataclass
class Rollout:
    """What all bipeds did in an iteration, control period by control period."""

    observations: np.ndarray  # scaled, one more at the end
    actions: np.ndarray  # without what remains of the noise before, which no gradient goes through
    rewards: np.ndarray
    fell: np.ndarray
    landed: np.ndarray  # where a step may cost
    lack: np.ndarray  # what the step that ends lacks of the commanded gait
    over: np.ndarray
    age: np.ndarray  # control periods since the episode began
    cut_off: np.ndarray  # the critic's value where an episode was cut off

    @classmethod
    def zeros(cls, count: int) -> Rollout:
        shapes = [(CONTROL_PERIODS + 1, count, 14), (CONTROL_PERIODS, count, 2), *[(CONTROL_PERIODS, count)] * 7]
        return cls(*(np.zeros(shape, np.float32) for shape in shapes))


class Learner:
    """The actor, the critic, which also knows the group, and the noise."""

    def __init__(
        self,
        actor: Actor,
        before: Actor,
        at_speed: Actor,
        bipeds: Bipeds,
        rate: float,
        noise: float,
        gaits: float = 0.0,
        raised_like: Sequence[Path] = (),
        free_start_s: float = 0.0,
    ) -> None:
        self.actor, self.before, self.at_speed, self.bipeds, self.gaits = actor, before, at_speed, bipeds, gaits
        self.free_start = free_start_s / CONTROL_PERIOD_S
        self.remembered: deque[tuple[Tensor, Tensor, Tensor]] = deque(maxlen=REMEMBERED)
        self.forward = torch.tensor([part.forward for part in bipeds.parts])
        self.group = torch.from_numpy(bipeds.group)
        self.which = nn.functional.one_hot(self.group, len(bipeds.parts)).float()
        self.critic = nn.Sequential(
            nn.Linear(14 + len(bipeds.parts), 256), nn.ReLU(), nn.Linear(256, 256), nn.ReLU(), nn.Linear(256, 1)
        )
        self.actor_adam = torch.optim.Adam(actor.parameters(), lr=rate)
        self.imitation_adam = torch.optim.Adam(actor.parameters(), lr=rate)  # its gradients are of another size
        self.critic_adam = torch.optim.Adam(self.critic.parameters(), lr=3e-4)
        # Some bipeds with little noise, so that the actor is tried as it will be used, and some with much, so that it learns.
        deviation = LEAST_NOISE * (noise / LEAST_NOISE) ** bipeds.rng.random((bipeds.count, 1))
        self.fresh = (deviation * np.sqrt(1 - NOISE_LASTS**2)).astype(np.float32)
        self.noise = np.zeros((bipeds.count, 2), np.float32)
        self.taught = torch.tensor([part.taught for part in bipeds.parts])
        self.may_start_freely = torch.tensor([not part.hard and not part.taught for part in bipeds.parts])
        self.teachers = [Actor(path).requires_grad_(False) for path in raised_like]
        if any(not torch.equal(teacher.scale, actor.scale) for teacher in self.teachers):
            raise SystemExit("--raised-like: their observations are scaled otherwise; give controllers of the same recipe")

    def rollout(self) -> Rollout:
        bipeds, scale = self.bipeds, self.actor.scale.numpy()
        done = Rollout.zeros(bipeds.count)
        for period in range(CONTROL_PERIODS):
            done.observations[period], done.age[period] = bipeds.observations * scale, bipeds.age
            with torch.no_grad():
                mean = self.actor(torch.from_numpy(done.observations[period])).numpy()
            new = self.fresh * bipeds.rng.standard_normal(mean.shape, dtype=np.float32)
            done.actions[period] = mean + new
            self.noise = NOISE_LASTS * self.noise + new
            fell, done.over[period], last, done.landed[period], lack = bipeds.step(np.clip(mean + self.noise, -1, 1))
            self.noise[done.over[period] > 0] = 0
            done.fell[period], done.lack[period] = fell, lack
            done.rewards[period] = -done.fell[period] - self.gaits * done.lack[period]
            for biped, final in last.items():
                with torch.no_grad():
                    seen = torch.from_numpy(final.astype(np.float32) * scale)
                    done.cut_off[period, biped] = self.critic(torch.cat([seen, self.which[biped]])).item()
        done.observations[CONTROL_PERIODS] = bipeds.observations * scale
        return done

    def to_imitate(self, seen: Tensor, group: Tensor) -> Tensor:
        """What is imitated: the controller as it was, at speed after pushes forward the other one, and on bodies with the mass
        far above the axis those that know them."""
        other = self.forward[group] & (seen[:, OMEGA_V] > AT_SPEED * self.actor.scale[OMEGA_V])
        imitated = self.before(seen)
        imitated[other] = self.at_speed(seen[other])
        if self.teachers:
            near_zero = seen[:, OMEGA_V].abs() < NEAR_ZERO * self.actor.scale[OMEGA_V]
            for teacher, where in zip(self.teachers, (~near_zero, near_zero)):
                rows = self.taught[group] & where
                asked = seen[rows]
                asked[:, OMEGA_V].clamp_(max=RAISED_AT_MOST * float(self.actor.scale[OMEGA_V]))
                imitated[rows] = teacher(asked)
        return imitated

    def held(self, done: Rollout, keep: Tensor) -> Tensor:
        """The weight of what is imitated, a row for each action, from that of each biped."""
        free = (torch.from_numpy(done.age) < self.free_start) & self.may_start_freely[self.group]
        return torch.where(free, keep.clamp(max=HARDLY), keep).flatten()

    def advantages(self, done: Rollout) -> tuple[Tensor, Tensor]:
        """Generalized advantage estimates, and the returns that the critic is to learn; a row for each action."""
        seen = torch.from_numpy(done.observations)
        with torch.no_grad():
            values = torch.stack([self.critic(torch.cat([rows, self.which], 1))[:, 0] for rows in seen]).numpy()
        advantages = np.zeros_like(done.rewards)
        following = np.zeros(self.bipeds.count, np.float32)
        for period in reversed(range(CONTROL_PERIODS)):
            next_value = np.where(done.over[period] > 0, done.cut_off[period], values[period + 1])
            error = done.rewards[period] + GAMMA * next_value - values[period]
            following = error + GAMMA * LAMBDA * (1 - done.over[period]) * following
            advantages[period] = following
        returns = torch.from_numpy(advantages + values[:-1]).flatten()
        flat = torch.from_numpy(advantages).flatten()
        return flat / (flat.std() + 1e-6), returns

    def update(self, done: Rollout, keep: Tensor, critic_alone: bool) -> tuple[np.ndarray, float]:
        """Learns from a rollout; mean |Δa|² of each group to what is imitated, and how far the actor got by this
        update (its Kullback-Leibler divergence)."""
        advantage, returns = self.advantages(done)
        seen = torch.from_numpy(done.observations[:-1]).reshape(-1, 14)
        taken = torch.from_numpy(done.actions).reshape(-1, 2)
        group, which = (rows.repeat(CONTROL_PERIODS, *[1] * (rows.dim() - 1)) for rows in (self.group, self.which))
        keep = self.held(done, keep)
        variance = torch.from_numpy(self.fresh[:, 0] ** 2).repeat(CONTROL_PERIODS)
        with torch.no_grad():
            old = torch.cat([self.actor(rows) for rows in seen.split(ROWS)])
            parts = zip(seen.split(ROWS), group.split(ROWS))
            imitated = torch.cat([self.to_imitate(rows, of) for rows, of in parts])
        self.remembered.append((seen, imitated, keep))
        moved, divergence = torch.zeros(len(self.bipeds.parts)), 0.0
        for epoch in range(EPOCHS):
            for chosen in torch.randperm(len(seen)).split(ROWS):
                value = self.critic(torch.cat([seen[chosen], which[chosen]], 1))[:, 0]
                critic_loss = (value - returns[chosen]).square().mean()
                self.critic_adam.zero_grad()
                critic_loss.backward()
                self.critic_adam.step()
                if critic_alone:
                    continue
                mean = self.actor(seen[chosen])
                away = (taken[chosen] - mean).square() - (taken[chosen] - old[chosen]).square()
                ratio = (-away.sum(1) / (2 * variance[chosen])).clamp(-10, 10).exp()
                gain = torch.minimum(ratio * advantage[chosen], ratio.clamp(1 - CLIP, 1 + CLIP) * advantage[chosen])
                difference = (mean - imitated[chosen]).square().sum(1)
                loss = (keep[chosen] * difference - gain).mean()
                self.descend(self.actor_adam, loss)
                if epoch == EPOCHS - 1:
                    moved.index_add_(0, group[chosen], difference.detach())
                    step = (mean.detach() - old[chosen]).square().sum(1)
                    divergence += float((step / (2 * variance[chosen])).sum()) / len(seen)
        return (moved / torch.bincount(group)).numpy(), divergence

    def imitate(self, steps: int) -> None:
        """Imitates on, from the rollouts of the last iterations: an update has few steps, since its gain holds near it only."""
        for _ in range(steps):
            seen, imitated, keep = self.remembered[int(torch.randint(len(self.remembered), ()))]
            chosen = torch.randint(len(seen), (IMITATION_ROWS,))
            loss = (keep[chosen] * (self.actor(seen[chosen]) - imitated[chosen]).square().sum(1)).mean()
            self.descend(self.imitation_adam, loss)

    def descend(self, adam: torch.optim.Adam, loss: Tensor) -> None:
        """A step of the actor."""
        adam.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(self.actor.parameters(), 1.0)
        adam.step()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--controller", type=Path, required=True, help="the controller to begin with, whose motion is kept")
    parser.add_argument("--from", dest="begin", type=Path, help="go on from this one of its outputs (not to the same bits)")
    parser.add_argument("--out", type=Path, required=True, help="folder for the controllers and log.csv")
    parser.add_argument("--iterations", type=int, default=400)
    parser.add_argument("--bipeds", type=int, default=1024)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--learning-rate", type=float, default=1e-4, help="once it is warm; it falls to a fiftieth")
    parser.add_argument("--noise", type=float, default=0.15, help="greatest deviation of exploration, of the greatest force")
    parser.add_argument("--keep", type=float, default=300.0, help="weight of the undisturbed motion as it was")
    parser.add_argument("--keep-walk", type=float, help="the same near ω_v = 0 [default: as --keep]")
    parser.add_argument("--elsewhere", type=float, default=100.0, help="the same after pushes forward, not near 0")
    parser.add_argument("--near-zero", type=float, default=0.05, help="the same near 0, after pushes not down alone")
    parser.add_argument("--at-speed-like", type=Path, help=f"controller to imitate there at ω_v > {AT_SPEED:g}")
    parser.add_argument("--gaits", type=float, default=0.0, help="cost of what a step lacks of its gait, 0.4 for example")
    parser.add_argument("--at-zero", type=float, default=0.65, help="share of the strongly disturbed at or near ω_v = 0")
    parser.add_argument("--hard-pushes", action="store_true", help="half of the bipeds are pushed where it falls")
    parser.add_argument("--hard-steps", action="store_true", help="with --hard-pushes: some of them come to steps up instead")
    parser.add_argument("--after-pushes", type=float, default=HARDLY, help="the same after hard cases, pushes backward or down")
    parser.add_argument("--hard-near-zero", type=float, help="the same in hard cases near 0 [default: as --after-pushes]")
    parser.add_argument(
        "--raised-like", type=Path, nargs=2, default=(), metavar=("BEYOND", "NEAR_ZERO"),
        help="controllers to imitate with the hip's mass far above its axis, at ω_v beyond 0.4 and nearer to 0",
    )
    parser.add_argument(
        "--raised-m", type=float, nargs=2, default=(0.06, 0.1), metavar=("LEAST", "GREATEST"), help="these heights, in m"
    )
    parser.add_argument("--imitation-steps", type=int, default=0, help="that follow each update, from the last rollouts")
    parser.add_argument("--free-start-s", type=float, default=0.0, help="hardly held from random starts for so long")
    parser.add_argument("--raised-near-zero", type=float, default=RAISED_WEIGHT, help="weight of NEAR_ZERO")
    parser.add_argument("--anew", action="store_true", help="with --gaits: hardly imitate it at ω_v from 0.6 to 2.8")
    arguments = parser.parse_args()
    if arguments.anew and not arguments.gaits > 0:
        raise SystemExit("--anew lets go of what the controller did, so it needs gaits to learn instead: give --gaits 0.4 too")

    if arguments.hard_steps and not arguments.hard_pushes:
        raise SystemExit("--hard-steps takes a share of the bipeds of --hard-pushes: give that too")

    torch.set_num_threads(1)
    torch.manual_seed(arguments.seed)
    rng = np.random.default_rng(arguments.seed)
    held = Held(
        arguments.keep, arguments.elsewhere, arguments.near_zero, arguments.after_pushes, arguments.keep_walk,
        arguments.hard_near_zero,
    )
    raised_m = arguments.raised_m if arguments.raised_like else ()
    extras = Extras(
        arguments.gaits > 0, arguments.anew, arguments.hard_pushes, raised_m, arguments.raised_near_zero
    )
    parts = groups(held, extras)
    cases = PUSHES + STEPS if arguments.hard_steps else PUSHES
    begin = arguments.begin or arguments.controller
    bipeds = Bipeds(arguments.controller, parts, arguments.bipeds, arguments.at_zero, rng, arguments.anew, begin, cases)
    actor, before = Actor(begin), Actor(arguments.controller).requires_grad_(False)
    at_speed = Actor(arguments.at_speed_like or arguments.controller).requires_grad_(False)
    learner = Learner(
        actor, before, at_speed, bipeds, arguments.learning_rate, arguments.noise, arguments.gaits,
        arguments.raised_like, arguments.free_start_s,
    )
    seconds_of = CONTROL_PERIODS * CONTROL_PERIOD_S * np.bincount(bipeds.group)  # a group's in an iteration
    arguments.out.mkdir(parents=True, exist_ok=True)
    with (arguments.out / "log.csv").open("a", newline="") as log:
        rows = csv.writer(log)
        names = [part.name for part in parts]
        costing = [part.name for part in parts if part.gait]
        columns = [f"{what} {name}" for what in ("falls_per_s", "moved") for name in names]
        columns += [f"lack {name}" for name in costing]
        rows.writerow(["iteration", "elapsed_s", "divergence", *columns])
        began = time.monotonic()
        for iteration in range(1, arguments.iterations + 1):
            share_left = 1 - iteration / arguments.iterations
            warm = min(1.0, max(0.05, (iteration - CRITIC_ALONE) / WARM_UP))
            for adam in (learner.actor_adam, learner.imitation_adam):
                adam.param_groups[0]["lr"] = arguments.learning_rate * max(0.02, share_left) * warm
            keep = bipeds.keep()
            if bipeds.hard and iteration % LOOK_EVERY == 0:
                bipeds.hard.look(actor)
            if iteration <= SPREAD:
                bipeds.spread()
            done = learner.rollout()
            bipeds.change_commands()
            moved, divergence = learner.update(done, keep, critic_alone=iteration <= CRITIC_ALONE)
            if iteration > CRITIC_ALONE:
                learner.imitate(arguments.imitation_steps)
            falls = np.bincount(bipeds.group, weights=done.fell.sum(0)) / seconds_of
            lack, steps = (np.bincount(bipeds.group, weights=rows.sum(0)) for rows in (done.lack, done.landed))
            of_step = (lack / np.maximum(steps, 1))[[part.gait for part in parts]]
            elapsed_s = round(time.monotonic() - began)
            measured = [*falls.round(4), *moved.round(9), *of_step.round(3)]
            rows.writerow([iteration, elapsed_s, round(divergence, 5), *measured])
            log.flush()
            told = ", ".join(f"{name} {fall:.3f}" for name, fall in zip(names, falls))
            print(f"iteration {iteration} of {arguments.iterations}, falls per s: {told}", flush=True)
            if iteration % 10 == 0 or iteration == arguments.iterations:
                actor.save(arguments.out / f"{iteration}.safetensors", arguments.seed)


if __name__ == "__main__":
    main()
