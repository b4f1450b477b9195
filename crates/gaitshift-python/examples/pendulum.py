"""The learner alone on Gymnasium's Pendulum-v1, beside Stable-Baselines3 with the same settings and budget.

    pip install 'gaitshift' stable-baselines3
    python crates/gaitshift-python/examples/pendulum.py --steps 5000 --seeds 1 2 3

Both take turns, seed by seed, on one thread each; of the times only the ratio says something. A return above -200 is a
pendulum that is swung up and held.
"""

import argparse
import time

import gymnasium
import numpy as np

import gaitshift

TASK = "Pendulum-v1"
# Stable-Baselines3's zoo has the same, but for its 20 000 steps.
SETTINGS = {"learning_rate": 1e-3, "gamma": 0.99, "tau": 0.005, "batch_size": 256}
HIDDEN = (256, 256)
LEARNING_STARTS = 100


def train_ours(env, steps, seed, starts, **settings):
    env.action_space.seed(seed)
    learner = gaitshift.SAC.for_spaces(
        env.observation_space, env.action_space, seed=seed, hidden=HIDDEN, capacity=steps, **settings
    )
    observation, _ = env.reset(seed=seed)
    for step in range(steps):
        action = env.action_space.sample() if step < starts else learner.act(observation)
        following, reward, terminated, truncated, _ = env.step(action)
        learner.observe(observation, action, reward, following, terminated, truncated)
        observation = env.reset()[0] if terminated or truncated else following
        if step >= starts:
            learner.update()
    return learner


def train_theirs(env, steps, seed, starts, **settings):
    import torch
    from stable_baselines3 import SAC

    torch.set_num_threads(1)
    policy = {"net_arch": list(HIDDEN)}
    model = SAC("MlpPolicy", env, seed=seed, learning_starts=starts, buffer_size=steps,
                policy_kwargs=policy, device="cpu", **settings)  # fmt: skip
    return model.learn(steps)


def mean_return(learner, episodes=20):
    """Mean return without the policy's noise, from the same starts for both."""
    env = gymnasium.make(TASK)
    total = 0.0
    for episode in range(episodes):
        observation, _ = env.reset(seed=10_000 + episode)
        over = False
        while not over:
            action, _ = learner.predict(observation, deterministic=True)
            observation, reward, terminated, truncated, _ = env.step(action)
            total += reward
            over = terminated or truncated
    return total / episodes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=5000)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--ours-only", action="store_true", help="without Stable-Baselines3")
    arguments = parser.parse_args()
    learners = {"gaitshift": train_ours, "Stable-Baselines3": train_theirs}
    if arguments.ours_only:
        learners.pop("Stable-Baselines3")
    returns = {name: [] for name in learners}
    times_s = {name: [] for name in learners}
    for seed in arguments.seeds:
        for name, train in learners.items():
            start = time.perf_counter()
            learner = train(gymnasium.make(TASK), arguments.steps, seed, LEARNING_STARTS, **SETTINGS)
            times_s[name].append(time.perf_counter() - start)
            returns[name].append(mean_return(learner))
            print(f"seed {seed}, {name}: return {returns[name][-1]:.0f}, {times_s[name][-1]:.1f} s", flush=True)
    for name in learners:
        print(f"{name}: return {np.mean(returns[name]):.0f}, from {min(returns[name]):.0f} to {max(returns[name]):.0f}")
    if len(learners) == 2:
        ours, theirs = (np.array(times_s[name]) for name in learners)
        ratios = theirs / ours
        print(f"time, theirs by ours: {ratios.mean():.1f}, from {ratios.min():.1f} to {ratios.max():.1f}")


if __name__ == "__main__":
    main()
