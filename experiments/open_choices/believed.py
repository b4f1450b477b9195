"""What a run's critics believe, beside what then comes.

At the run's last checkpoint the actor moves the body with its noise, from random starts under each command. For the
states and actions of these motions the lower value of both critics is compared with the sum that it estimates: of the
discounted rewards, with the symmetry term (7) where the run has it in the reward, and of the entropy bonus. Times so near
the time limit that 1 % of a constant reward is missing are left out.

With `--other`, a controller of another gait moves the body without noise, and from states of its motion, half a second
apart, the actor goes on: what the critics believe of the actor in that gait's states, what then comes, and what would come
if the other went on.

With `--course`, every policy that the run kept moves the body under one command, with its noise and without: what a step
earns, what of it is the energy term, and the entropy bonus, beside the gait of the evaluation at that step.

    python experiments/open_choices/believed.py runs/paper-1
    python experiments/open_choices/believed.py runs/paper-1 --other shipped
    python experiments/open_choices/believed.py runs/paper-1 --course 0

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


def tensors_of(file: Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """The tensors of a safetensors file and its metadata."""
    data = file.read_bytes()
    (size,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + size])
    metadata = header.pop("__metadata__")
    tensors = {}
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        values = np.frombuffer(data, np.float32, (end - begin) // 4, 8 + size + begin)
        tensors[name] = values.reshape(entry["shape"]).astype(float)
    return tensors, metadata


def network(tensors: dict[str, np.ndarray], name: str, x: np.ndarray) -> np.ndarray:
    """The output of the network whose tensors begin with `name`."""
    layer = 0
    while f"{name}layers.{layer}.weight" in tensors:
        at = f"{name}layers.{layer}"
        x = x @ tensors[f"{at}.weight"].T + tensors[f"{at}.bias"]
        if f"{at}.norm.weight" in tensors:
            x = (x - x.mean(-1, keepdims=True)) / np.sqrt(x.var(-1, keepdims=True) + 1e-5)
            x = x * tensors[f"{at}.norm.weight"] + tensors[f"{at}.norm.bias"]
        x = np.maximum(x, 0.0)
        layer += 1
    return x @ tensors[f"{name}output.weight"].T + tensors[f"{name}output.bias"]


class Policy:
    """A policy with its noise, from the tensors of a controller or, with the prefix `actor.`, of a checkpoint."""

    def __init__(self, tensors: dict[str, np.ndarray], name: str = "") -> None:
        self.tensors, self.name = tensors, name

    def act(self, observation: np.ndarray, rng: np.random.Generator, noisy: bool = True) -> tuple[np.ndarray, float]:
        """A drawn action, or the mean one, and its log-probability."""
        mean, log_deviation = np.split(network(self.tensors, self.name, observation), 2)
        log_deviation = np.clip(log_deviation, -5.0, 2.0)
        noise = rng.standard_normal(len(mean)) if noisy else np.zeros(len(mean))
        u = mean + np.exp(log_deviation) * noise
        slope = 2.0 * (math.log(2.0) - u - np.logaddexp(0.0, -2.0 * u))
        log_probability = -0.5 * noise**2 - log_deviation - 0.5 * math.log(2.0 * math.pi) - slope
        return np.tanh(u), float(log_probability.sum())

    def asymmetry(self, observation: np.ndarray) -> float:
        """The square of (7), from mean actions."""
        mirrored = observation[MIRRORED_OBSERVATION]
        actor = [np.tanh(network(self.tensors, self.name, o)[:2]) for o in (observation, mirrored)]
        return float(np.sum((actor[0] - actor[1][MIRRORED_ACTION]) ** 2))


class Agent(Policy):
    """Actor and critics of a checkpoint."""

    def __init__(self, run: Path) -> None:
        tensors, metadata = tensors_of(run / "checkpoint" / "agent.safetensors")
        super().__init__(tensors, "actor.")
        stored = json.loads(metadata["gaitshift-sac-agent"])
        self.gamma = stored["config"]["gamma"]
        self.alpha = stored["temperature"]["alpha"]

    def believed(self, observations: list[np.ndarray], actions: list[np.ndarray]) -> np.ndarray:
        x = np.concatenate([np.array(observations), np.array(actions)], axis=1)
        return np.minimum(network(self.tensors, "critic_1.", x), network(self.tensors, "critic_2.", x))[:, 0]


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

    def symmetry(self, policy: Policy, scaled: np.ndarray, omega_v: float) -> float:
        """The symmetry term of a step, where the run has it in the reward."""
        return -self.omega_s * policy.asymmetry(scaled) * self.common_factor(omega_v) if self.omega_s else 0.0

    def motion(self, omega_v: float, rng: np.random.Generator, **opening):
        """Scaled observations, actions, what follows each of them, and whether it fell, for the actor with its noise."""
        observation, _ = self.env.reset(seed=int(rng.integers(2**31)), options={"omega_v": omega_v, **opening})
        observations, actions, rewards, bonuses = [], [], [], []
        ended = fell = False
        while not ended:
            scaled = observation * gaitshift.OBSERVATION_SCALE
            action, log_probability = self.agent.act(scaled, rng)
            symmetry = self.symmetry(self.agent, scaled, omega_v)
            observation, reward, fell, truncated, _ = self.env.step(action)
            observations.append(scaled)
            actions.append(action)
            rewards.append(reward + symmetry)
            bonuses.append(-self.agent.alpha * log_probability)
            ended = fell or truncated
        follows = discounted(rewards, bonuses, self.agent.gamma)
        count = len(rewards) if fell else len(rewards) - self.tail
        return observations[:count], actions[:count], follows[:count], fell


    def earned(self, policy: Policy, omega_v: float, motions: int, noisy: bool) -> tuple[np.ndarray, int]:
        """Means over the steps of a policy's motions: reward, its energy term, entropy bonus. And how many motions fell."""
        sums, steps, falls = np.zeros(3), 0, 0
        for seed in range(motions):
            rng = np.random.default_rng(seed)
            observation, _ = self.env.reset(seed=seed, options={"omega_v": omega_v})
            ended = False
            while not ended:
                scaled = observation * gaitshift.OBSERVATION_SCALE
                action, log_probability = policy.act(scaled, rng, noisy)
                symmetry = self.symmetry(policy, scaled, omega_v)
                observation, reward, fell, truncated, info = self.env.step(action)
                sums += [reward + symmetry, info["reward_energy"], -self.agent.alpha * log_probability]
                steps += 1
                falls += fell
                ended = fell or truncated
        return sums / steps, falls


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


def course(run: Run, folder: Path, omega_v: float, motions: int) -> None:
    lines = (folder / "evaluations.jsonl").read_text().splitlines()
    rows = {e["step"]: min(e["rows"], key=lambda r: abs(r["omega_v"] - omega_v)) for e in map(json.loads, lines)}
    print("| steps | gait, Fr | with noise: reward, energy term, entropy bonus, falls | without: reward, energy term, falls |")
    print("| --- | --- | --- | --- |")
    for file in sorted((folder / "controllers").glob("step-*.safetensors")):
        step = int(file.stem.removeprefix("step-"))
        policy = Policy(tensors_of(file)[0])
        (reward, energy, bonus), falls = run.earned(policy, omega_v, motions, noisy=True)
        (steady, least, _), steady_falls = run.earned(policy, omega_v, motions, noisy=False)
        row = rows[step]
        print(
            f"| {step} | {row['gait']}, {row['froude'] or 0.0:.2f} | {reward:.3f}, {energy:+.3f}, {bonus:+.3f}, "
            f"{falls} of {motions} | {steady:.3f}, {least:+.3f}, {steady_falls} of {motions} |",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("run", type=Path, help="a run's folder")
    parser.add_argument("--other", help="a controller file, `shipped` or `robust`")
    parser.add_argument("--course", type=float, metavar="OMEGA_V", help="what every kept policy earns under this command")
    parser.add_argument("--motions", type=int, default=8, help="motions for each command")
    arguments = parser.parse_args()
    run = Run(arguments.run)
    gamma, alpha = run.agent.gamma, run.agent.alpha
    print(f"γ = {gamma:g}, α = {alpha:g}; a constant reward of 1 is worth {1 / (1 - gamma):.0f}\n")
    if arguments.course is not None:
        course(run, arguments.run, arguments.course, arguments.motions)
        return
    own_motions(run, arguments.motions)
    if arguments.other:
        others_states(run, arguments.other, arguments.motions)


if __name__ == "__main__":
    main()
