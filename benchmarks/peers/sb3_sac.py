"""Updates per second of Stable-Baselines3's Soft Actor-Critic. Protocol: protocol.py.

    python benchmarks/peers/sb3_sac.py --hidden 128 --threads 1

`SAC.train` as the library has it, on random transitions of our sizes. It differs from ours in what no user would
change: ln σ is limited to [-20, 2], and losses are recorded for its log.
"""

import argparse

from protocol import limit_threads, serve

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--hidden", type=int, default=128, help="units of each of the two hidden layers")
parser.add_argument("--threads", type=int, default=1)
arguments = parser.parse_args()
limit_threads(arguments.threads)

import gymnasium  # noqa: E402
import numpy as np  # noqa: E402
import torch  # noqa: E402
from stable_baselines3 import SAC  # noqa: E402
from stable_baselines3.common.logger import Logger  # noqa: E402

OBSERVATIONS, ACTIONS, TRANSITIONS, BATCH = 14, 2, 200_000, 256
UPDATES_PER_CALL = 10


class Sizes(gymnasium.Env):
    """Tells the sizes and nothing else; it is never stepped."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (OBSERVATIONS,), np.float32)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32)


torch.set_num_threads(arguments.threads)
model = SAC(
    "MlpPolicy", Sizes(), policy_kwargs={"net_arch": [arguments.hidden] * 2}, buffer_size=TRANSITIONS, batch_size=BATCH,
    learning_rate=3e-4, tau=0.005, gamma=0.99, ent_coef=0.2, device="cpu", seed=1,
)
model.set_logger(Logger(None, []))
rng, replay = np.random.default_rng(1), model.replay_buffer
for array in (replay.observations, replay.next_observations, replay.rewards):
    array[:] = rng.standard_normal(array.shape, np.float32)
replay.actions[:] = rng.uniform(-1, 1, replay.actions.shape)
replay.dones[:] = rng.random(replay.dones.shape) < 0.002
replay.full = True


def work():
    model.train(gradient_steps=UPDATES_PER_CALL, batch_size=BATCH)
    return UPDATES_PER_CALL


serve(work)
