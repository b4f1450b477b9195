"""Contract: RL Baselines3 Zoo trains on the environment as it comes. Skipped where the zoo is not installed."""

import subprocess
import sys

import pytest

pytest.importorskip("rl_zoo3", reason="RL Baselines3 Zoo is not installed: pip install rl_zoo3")

SETTINGS = """
gaitshift/PassiveBiped-v0:
  n_timesteps: 600
  policy: MlpPolicy
  learning_starts: 100
  policy_kwargs: "dict(net_arch=[16, 16])"
"""


def test_the_zoo_trains_sac(tmp_path):
    (tmp_path / "sac.yml").write_text(SETTINGS)
    command = [sys.executable, "-m", "rl_zoo3.train", "--algo", "sac", "--env", "gaitshift/PassiveBiped-v0"]
    options = ["--gym-packages", "gaitshift", "--conf-file", tmp_path / "sac.yml", "--log-folder", tmp_path / "logs"]
    more = ["--env-kwargs", "omega_v:3.0", "--eval-freq", "300", "--eval-episodes", "1", "--seed", "1", "--device", "cpu"]
    done = subprocess.run([*command, *options, *more], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    [model] = (tmp_path / "logs" / "sac").glob("*/gaitshift-PassiveBiped-v0.zip")
    assert model.stat().st_size > 1000
    assert (model.parent / "evaluations.npz").exists()
