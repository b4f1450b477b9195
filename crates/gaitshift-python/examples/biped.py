"""Our learner and Stable-Baselines3's on the biped, at equal steps and at equal minutes.

    pip install 'gaitshift' stable-baselines3
    python crates/gaitshift-python/examples/biped.py --steps 100000 --seeds 1 2 3 --out out/biped

For each seed, one after the other, on one thread each:

  Stable-Baselines3   its SAC with the settings of its zoo for a planar walker (Walker2d)
  gaitshift.SAC       ours with the same settings and the same steps
  gaitshift train     a recipe, for as long as Stable-Baselines3 took

All learn and are judged by the reward and the starts of the same environment, the commands drawn from all of its range.
The two loops that learn are those of pendulum.py beside this file.
"""

import argparse
import json
import shutil
import time
from pathlib import Path

import gymnasium
import numpy as np
from pendulum import train_ours, train_theirs

import gaitshift

COMMANDS = (0.0, 1.0, 2.0, 3.0)
# What the zoo gives for Walker2d; the rest, two layers of 256 units and an update per step among it, is SAC's default.
LEARNING_STARTS = 10_000

# To observations of order one, as `gaitshift train` scales them.
SCALE = np.array(gaitshift.OBSERVATION_SCALE)


def make(recipe, omega_v=(-0.5, 3.5)):
    env = gymnasium.make("gaitshift/PassiveBiped-v0", experiment=recipe, omega_v=omega_v)
    space = gymnasium.spaces.Box(-np.inf, np.inf, SCALE.shape, np.float32)
    return gymnasium.wrappers.TransformObservation(env, lambda seen: (seen * SCALE).astype(np.float32), space)


def with_learner(train):
    """Training of a learner on the task of a recipe, which gives what acts."""

    def trained(recipe, steps, seed, starts):
        learner = train(make(recipe), steps, seed, starts)
        return lambda observation: learner.predict(observation, deterministic=True)[0]

    return trained


def train_recipe(recipe, seconds, seed, folder):
    shutil.rmtree(folder, ignore_errors=True)  # of a comparison that was interrupted
    run = gaitshift.train(recipe, seed=seed, out=folder, threads=1, callback=lambda progress: progress.elapsed_s < seconds)
    controller = run.best if len(run.controllers) else run.last  # before the first evaluation there is no best
    return lambda observation: controller(observation / SCALE)


def judge(act, recipe, episodes=32):
    """Mean return over the whole range of commands, and time upright and mean speed at some, from the same starts for all."""

    def play(env, seed):
        observation, info = env.reset(seed=seed)
        total, start_m, over = 0.0, info["x_m"], False
        while not over:
            observation, reward, terminated, truncated, info = env.step(act(observation))
            total += reward
            over = terminated or truncated
        return total, info["time_s"], (info["x_m"] - start_m) / info["time_s"]

    env = make(recipe)
    result = {"return": float(np.mean([play(env, 10_000 + episode)[0] for episode in range(episodes)]))}
    for omega_v in COMMANDS:
        env = make(recipe, omega_v)
        played = np.array([play(env, 10_000 + episode) for episode in range(8)])
        result[f"at {omega_v:g}"] = [float(played[:, 1].mean()), float(played[:, 2].mean())]
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recipe", default="fast")
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--learning-starts", type=int, default=LEARNING_STARTS)
    parser.add_argument("--ours-only", action="store_true", help="without Stable-Baselines3; the recipe gets our time")
    parser.add_argument("--out", type=Path, default=Path("out/biped"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    table = arguments.out / "biped.json"
    # Kept after each training, so that an interrupted comparison goes on where it was.
    rows = json.loads(table.read_text()) if table.exists() else []
    shown = []
    for seed in arguments.seeds:

        def learn(name, train, *settings, seed=seed):
            asked = {"learner": name, "seed": seed, "recipe": arguments.recipe, "steps": arguments.steps}
            found = [row for row in rows if asked.items() <= row.items()]
            if found:
                shown.append(found[0])
                return found[0]["seconds"]
            start = time.perf_counter()
            act = train(arguments.recipe, *settings)
            seconds = time.perf_counter() - start
            rows.append(asked | {"seconds": seconds, **judge(act, arguments.recipe)})
            shown.append(rows[-1])
            table.write_text(json.dumps(rows, indent=1) + "\n")
            return seconds

        sizes = (arguments.steps, seed, arguments.learning_starts)
        allowed = learn("gaitshift.SAC", with_learner(train_ours), *sizes)
        if not arguments.ours_only:
            allowed = learn("Stable-Baselines3", with_learner(train_theirs), *sizes)
        learn("gaitshift train", train_recipe, allowed, seed, arguments.out / f"gaitshift-train-{seed}")

    print(f"{'learner':<18} {'seed':>4} {'time':>7} {'return':>7}  time upright and speed at ω_v = 0, 1, 2, 3")
    for row in shown:
        motions = "  ".join(f"{row[f'at {omega_v:g}'][0]:4.1f} s {row[f'at {omega_v:g}'][1]:5.2f} m/s" for omega_v in COMMANDS)
        print(f"{row['learner']:<18} {row['seed']:>4} {row['seconds']:>5.0f} s {row['return']:>7.1f}  {motions}")


if __name__ == "__main__":
    main()
