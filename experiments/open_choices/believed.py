"""What a run's critics believe, beside what then comes.

At the run's last checkpoint the actor moves the body with its noise, from random starts under each command. For the
states and actions of these motions the lower value of both critics is compared with the sum that it estimates: of the
discounted rewards, with the symmetry term (7) where the run has it in the reward, and of the entropy bonus. Times so near
the time limit that 1 % of a constant reward is missing are left out.

With `--other`, a controller of another gait moves the body without noise, and from states of its motion, half a second
apart, the actor goes on: what the critics believe of the actor in that gait's states, what then comes, and what would come
if the other went on.

    python experiments/open_choices/believed.py runs/paper-1
    python experiments/open_choices/believed.py runs/paper-1 --other shipped

The reward is that at the end of the run's last phase. Needs Python 3.11 and the Python package (`maturin develop`).
"""

from __future__ import annotations

import argparse
import json
import math
import struct
from pathlib import Path

import numpy as np
import tomllib

import gaitshift

COMMANDS = (0.0, 0.5, 1.0, 2.0, 3.0)
MISSING = 0.01
# Observations and actions of the mirror image: right and left exchanged.
MIRRORED_OBSERVATION = [0, 1, 2, 5, 6, 3, 4, 9, 10, 7, 8, 12, 11, 13]
MIRRORED_ACTION = [1, 0]


def discounted(rewards: list[float], bonuses: list[float], gamma: float) -> np.ndarray:
    """What follows each step: Q(s, a) = r + γ (bonus' + Q(s', a'))."""
    follows, after = np.zeros(len(rewards)), 0.0
    for k in reversed(range(len(rewards))):
        follows[k] = rewards[k] + gamma * after
        after = bonuses[k] + follows[k]
    return follows


class Agent:
    """Actor and critics of a checkpoint."""

    def __init__(self, run: Path) -> None:
        data = (run / "checkpoint" / "agent.safetensors").read_bytes()
        (size,) = struct.unpack("<Q", data[:8])
        header = json.loads(data[8 : 8 + size])
        stored = json.loads(header.pop("__metadata__")["gaitshift-sac-agent"])
        self.gamma = stored["config"]["gamma"]
        self.alpha = stored["temperature"]["alpha"]
        self.tensors = {}
        for name, entry in header.items():
            begin, end = entry["data_offsets"]
            values = np.frombuffer(data, np.float32, (end - begin) // 4, 8 + size + begin)
            self.tensors[name] = values.reshape(entry["shape"]).astype(float)

    def _network(self, name: str, x: np.ndarray) -> np.ndarray:
        t = self.tensors
        layer = 0
        while f"{name}.layers.{layer}.weight" in t:
            at = f"{name}.layers.{layer}"
            x = x @ t[f"{at}.weight"].T + t[f"{at}.bias"]
            if f"{at}.norm.weight" in t:
                x = (x - x.mean(-1, keepdims=True)) / np.sqrt(x.var(-1, keepdims=True) + 1e-5)
                x = x * t[f"{at}.norm.weight"] + t[f"{at}.norm.bias"]
            x = np.maximum(x, 0.0)
            layer += 1
        return x @ t[f"{name}.output.weight"].T + t[f"{name}.output.bias"]

    def act(self, observation: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
        """A drawn action and its log-probability."""
        mean, log_deviation = np.split(self._network("actor", observation), 2)
        log_deviation = np.clip(log_deviation, -5.0, 2.0)
        noise = rng.standard_normal(len(mean))
        u = mean + np.exp(log_deviation) * noise
        slope = 2.0 * (math.log(2.0) - u - np.logaddexp(0.0, -2.0 * u))
        log_probability = -0.5 * noise**2 - log_deviation - 0.5 * math.log(2.0 * math.pi) - slope
        return np.tanh(u), float(log_probability.sum())

    def asymmetry(self, observation: np.ndarray) -> float:
        """The square of (7), from mean actions."""
        actor = [np.tanh(self._network("actor", o)[:2]) for o in (observation, observation[MIRRORED_OBSERVATION])]
        return float(np.sum((actor[0] - actor[1][MIRRORED_ACTION]) ** 2))

    def believed(self, observations: list[np.ndarray], actions: list[np.ndarray]) -> np.ndarray:
        x = np.concatenate([np.array(observations), np.array(actions)], axis=1)
        return np.minimum(self._network("critic_1", x), self._network("critic_2", x))[:, 0]


class Run:
    """The task of a run at its end, and its agent."""

    def __init__(self, folder: Path) -> None:
        self.config = tomllib.loads((folder / "config.toml").read_text())
        task = self.config["task"]
        last = self.config["curriculum"]["phases"][-1]
        reward = task["reward"] | last.get("reward", {}) | last.get("reward_end", {})
        self.omega_s = reward["omega_s"] if self.config["training"]["symmetry"] == "reward" else 0.0
        self.divisor = reward["command_divisor"]
        self.agent = Agent(folder)
        # Long enough that a time limit cuts little off what is compared.
        self.tail = math.ceil(math.log(MISSING) / math.log(self.agent.gamma))
        limit_s = (self.tail + 500) * task["control_period_s"]
        task = task | {"reward": reward, "termination": task["termination"] | {"time_limit_s": limit_s}}
        self.env = gaitshift.PassiveBipedEnv(body=self.config["body"], task=task)

    def common_factor(self, omega_v: float) -> float:
        return 1.0 / (1.0 + self.divisor * max(omega_v, 0.0))

    def motion(self, omega_v: float, rng: np.random.Generator, **opening):
        """Scaled observations, actions, what follows each of them, and whether it fell, for the actor with its noise."""
        observation, _ = self.env.reset(seed=int(rng.integers(2**31)), options={"omega_v": omega_v, **opening})
        observations, actions, rewards, bonuses = [], [], [], []
        ended = fell = False
        while not ended:
            scaled = observation * gaitshift.OBSERVATION_SCALE
            action, log_probability = self.agent.act(scaled, rng)
            symmetry = -self.omega_s * self.agent.asymmetry(scaled) if self.omega_s else 0.0
            observation, reward, fell, truncated, _ = self.env.step(action)
            observations.append(scaled)
            actions.append(action)
            rewards.append(reward + symmetry * self.common_factor(omega_v))
            bonuses.append(-self.agent.alpha * log_probability)
            ended = fell or truncated
        follows = discounted(rewards, bonuses, self.agent.gamma)
        count = len(rewards) if fell else len(rewards) - self.tail
        return observations[:count], actions[:count], follows[:count], fell


def own_motions(run: Run, motions: int) -> None:
    print("| ω_v | falls | believed | what comes | believed too much |")
    print("| --- | --- | --- | --- | --- |")
    for omega_v in COMMANDS:
        rng = np.random.default_rng(1)
        believed, comes, falls = [], [], 0
        for _ in range(motions):
            observations, actions, follows, fell = run.motion(omega_v, rng)
            believed.extend(run.agent.believed(observations, actions))
            comes.extend(follows)
            falls += fell
        a, b = np.mean(believed), np.mean(comes)
        print(f"| {omega_v:g} | {falls} of {motions} | {a:.1f} | {b:.1f} | {a - b:+.1f} |", flush=True)


def others_states(run: Run, other: str, motions: int) -> None:
    controller = gaitshift.Controller.load(other)
    held = max(1, round(controller.control_period_s / run.config["task"]["control_period_s"]))
    between = round(0.5 / run.config["task"]["control_period_s"])
    print("\n| ω_v | the actor goes on: falls | believed | what comes | the other goes on: what comes |")
    print("| --- | --- | --- | --- | --- |")
    for omega_v in COMMANDS:
        rng = np.random.default_rng(2)
        observation, _ = run.env.reset(options={"omega_v": omega_v, "start": "default"})
        states, rewards, ended = [], [], False
        while not ended:
            if len(rewards) % held == 0:
                action, _ = controller.predict(observation, deterministic=True)
            states.append(run.env.state)
            observation, reward, fell, truncated, _ = run.env.step(action)
            rewards.append(reward)
            ended = fell or truncated
        follows = discounted(rewards, [0.0] * len(rewards), run.agent.gamma)
        usable = range(2 * between, len(rewards) if fell else len(rewards) - run.tail, between)[:motions]
        believed, comes, falls = [], [], 0
        for k in usable:
            observations, actions, own, fell = run.motion(omega_v, rng, state=states[k])
            believed.append(run.agent.believed(observations[:1], actions[:1])[0])
            comes.append(own[0])
            falls += fell
        if believed:
            goes_on = np.mean(follows[usable])
            print(
                f"| {omega_v:g} | {falls} of {len(believed)} | {np.mean(believed):.1f} | {np.mean(comes):.1f} | "
                f"{goes_on:.1f} |",
                flush=True,
            )
        else:
            print(f"| {omega_v:g} | the other falls | | | |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("run", type=Path, help="a run's folder")
    parser.add_argument("--other", help="a controller file, `shipped` or `robust`")
    parser.add_argument("--motions", type=int, default=8, help="motions for each command")
    arguments = parser.parse_args()
    run = Run(arguments.run)
    gamma, alpha = run.agent.gamma, run.agent.alpha
    print(f"γ = {gamma:g}, α = {alpha:g}; a constant reward of 1 is worth {1 / (1 - gamma):.0f}\n")
    own_motions(run, arguments.motions)
    if arguments.other:
        others_states(run, arguments.other, arguments.motions)


if __name__ == "__main__":
    main()
