"""Contract: experiments/open_choices/believed.py, on which docs/reward-or-learner.md rests, moves the body by the run's own
actor, with its probabilities, and compares the critics with what then comes: of a constant reward its closed form, to the
1 % that it says the time limit may cut off."""

import numpy as np
import pytest
from conftest import experiment_script

import gaitshift

GAMMA = 0.95


@pytest.fixture(scope="module")
def believed():
    return experiment_script("open_choices/believed.py")


@pytest.fixture(scope="module")
def folder(tiny, tmp_path_factory):
    """That of a run whose reward is 1 a step, with the paper's learner: no mean with the mirror image."""
    settings = {
        "training.symmetry": "reward",
        "learner.gamma": GAMMA,
        "curriculum.phases.only.reward": {"omega_e": 0.0, "omega_l": 0.0, "omega_f": 0.0, "c1": 0.0, "omega_s": 0.0},
        "curriculum.phases.only.omega_v": [0.0, 0.0],
    }
    out = tmp_path_factory.mktemp("believed") / "run"
    return gaitshift.train(tiny, out=out, set=settings).folder


@pytest.fixture
def run(believed, folder):
    return believed.Run(folder)


def test_the_discounted_sum_is_that_of_a_known_case(believed):
    # Q_k = r_k + 0.5 (b_(k+1) + Q_(k+1)), where b is the bonus of the action that follows.
    follows = believed.discounted([1.0, 2.0, 4.0], [8.0, 16.0, 32.0], 0.5)
    assert follows.tolist() == [1 + 0.5 * (16 + 2 + 0.5 * (32 + 4)), 2 + 0.5 * (32 + 4), 4]


def test_the_actor_is_the_runs_own(believed, run, folder):
    controller = gaitshift.Controller.load(folder / "controller-last.safetensors")
    rng = np.random.default_rng(0)
    for _ in range(20):
        observation = rng.normal(size=14)
        mean, _ = np.split(believed.network(run.agent.tensors, "actor.", observation * gaitshift.OBSERVATION_SCALE), 2)
        expected, _ = controller.predict(observation, deterministic=True)
        np.testing.assert_allclose(np.tanh(mean), expected, atol=2e-6)


def test_probabilities_are_those_of_the_squashed_gaussian(believed, run):
    import torch
    from torch.distributions import Normal, TanhTransform, TransformedDistribution

    observation = np.random.default_rng(1).normal(size=14)
    mean, log_deviation = np.split(believed.network(run.agent.tensors, "actor.", observation), 2)
    reference = TransformedDistribution(
        Normal(torch.tensor(mean), torch.tensor(np.exp(np.clip(log_deviation, -5.0, 2.0)))), TanhTransform()
    )
    rng = np.random.default_rng(2)
    for _ in range(20):
        action, log_probability = run.agent.act(observation, rng)
        assert log_probability == pytest.approx(float(reference.log_prob(torch.tensor(action)).sum()), abs=1e-6)


def test_what_comes_of_a_constant_reward(run):
    run.agent.alpha = 0.0
    observations, actions, follows, fell = run.motion(0.0, np.random.default_rng(3))
    assert len(observations) == len(actions) == len(follows)
    left = np.arange(len(follows), 0, -1) + (0 if fell else run.tail)
    np.testing.assert_allclose(follows, (1 - GAMMA**left) / (1 - GAMMA), rtol=1e-9)
    assert fell or follows.min() > 0.99 / (1 - GAMMA)


def test_what_is_believed_is_the_lower_of_both_critics(run):
    for name, value in (("critic_1", 3.0), ("critic_2", 2.0)):
        run.agent.tensors[f"{name}.output.weight"][:] = 0.0
        run.agent.tensors[f"{name}.output.bias"][:] = value
    assert run.agent.believed([np.zeros(14)] * 2, [np.zeros(2)] * 2).tolist() == [2.0, 2.0]


def test_what_a_policy_earns_is_the_mean_reward_of_a_step(believed, run):
    # The reward is 1 a step, and without an energy term nothing of it is energy.
    (reward, energy, bonus), falls = run.earned(run.agent, 0.0, motions=2, noisy=True)
    assert (reward, energy) == (1.0, 0.0)
    assert bonus != 0.0 and 0 <= falls <= 2


def test_the_course_has_a_line_for_every_policy_the_run_kept(believed, run, folder, capsys):
    believed.course(run, folder, omega_v=0.0, motions=1)
    rows = [line for line in capsys.readouterr().out.splitlines() if line[2].isdigit()]
    kept = sorted(int(file.stem.removeprefix("step-")) for file in (folder / "controllers").glob("step-*.safetensors"))
    assert kept and [int(row.split("|")[1]) for row in rows] == kept
    assert all("1.000, +0.000" in row for row in rows)
