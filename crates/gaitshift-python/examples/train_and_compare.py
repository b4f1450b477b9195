"""Trains a controller with Stable-Baselines3, loads ours, and plots both.

    pip install crates/gaitshift-python stable-baselines3 matplotlib
    python crates/gaitshift-python/examples/train_and_compare.py --steps 200000

A learner of another library needs nothing of ours but the environment. Few steps make no walker: what `gaitshift train`
needs for it is in docs/results.md.
"""

import argparse
from pathlib import Path

import gymnasium
import matplotlib
import numpy as np
from stable_baselines3 import SAC

import gaitshift

matplotlib.use("Agg")
from matplotlib import pyplot


class ScaledObservation(gymnasium.ObservationWrapper):
    """Observations of order one, which networks learn from more easily than from SI units."""

    def __init__(self, env):
        super().__init__(env)
        self.scale = np.array(gaitshift.OBSERVATION_SCALE)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (14,), np.float32)

    def observation(self, observation):
        return (observation * self.scale).astype(np.float32)


def make(omega_v):
    return ScaledObservation(gymnasium.make("gaitshift/PassiveBiped-v0", omega_v=omega_v, experiment="fast"))


def watch(act, env, seconds=10.0):
    """Time and forward speed of a motion, until it is over."""
    observation, info = env.reset(seed=1, options={"start": "default"})
    times, speeds = [], []
    while info["time_s"] < seconds:
        observation, _, terminated, truncated, info = env.step(act(observation))
        times.append(info["time_s"])
        speeds.append(observation[0])
        if terminated or truncated:
            break
    return np.array(times), np.array(speeds)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--steps", type=int, default=50_000)
    parser.add_argument("--out", type=Path, default=Path("out/stable-baselines3"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)

    model = SAC("MlpPolicy", make((-0.2, 0.2)), seed=1, learning_starts=500, train_freq=4,
                policy_kwargs={"net_arch": [64, 64]})
    model.learn(arguments.steps)
    model.save(arguments.out / "sac")

    ours = gaitshift.Controller.shipped()
    own = gymnasium.make("gaitshift/PassiveBiped-v0", omega_v=0.0, controller=ours)
    theirs = make(0.0)
    figure, axes = pyplot.subplots(figsize=(7, 3.5), layout="constrained")
    axes.plot(*watch(ours, own), label="the shipped controller")
    times, speeds = watch(lambda o: model.predict(o, deterministic=True)[0], theirs)
    axes.plot(times, speeds / gaitshift.OBSERVATION_SCALE[0], label=f"Stable-Baselines3, {arguments.steps} steps")
    axes.set(xlabel="time, s", ylabel="forward speed, m/s", title="ω_v = 0")
    axes.legend()
    figure.savefig(arguments.out / "comparison.png", dpi=150)

    summary = ours.record(0.0).summary()
    print(f"ours at ω_v = 0: {summary['gait']}, {summary['speed_m_per_s']:.2f} m/s")


if __name__ == "__main__":
    main()
