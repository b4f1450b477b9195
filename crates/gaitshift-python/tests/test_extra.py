"""Contract: a reward term and an ending of one's own, given as dictionaries, are in reward, info, recording and training,
of the single and the vector environment alike; a mistake is a ValueError that says what was probably meant."""

import copy

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import gaitshift
from gaitshift.env import PassiveBipedEnv
from gaitshift.vector import PassiveBipedVectorEnv

TERM = {"name": "calm", "weight": 0.5, "expression": "-right_command^2 - abs(left_command - left_previous_command)"}
RULE = {"name": "late", "expression": "time_s > 0.055"}
PERIOD = {"control_period_s": 0.01}
TASK = {**PERIOD, "reward": {"extra": [TERM]}, "termination": {"extra": [RULE]}}


def test_the_term_is_in_reward_and_info() -> None:
    plain, own = PassiveBipedEnv(omega_v=1.0, task=PERIOD), PassiveBipedEnv(omega_v=1.0, task=TASK)
    for env in (plain, own):
        env.reset(seed=1)
    before = 0.2
    for left in (0.2, -0.1, 0.4):
        action = np.array([0.5, left])
        _, reward, _, _, _ = plain.step(action)
        _, with_own, _, _, info = own.step(action)
        expected = 0.5 * (-0.25 - abs(left - before))
        assert info["reward_calm"] == pytest.approx(expected, abs=1e-12)
        assert with_own - reward == pytest.approx(expected, abs=1e-12)
        before = left
    copied = copy.deepcopy(own)
    action = np.array([0.0, 0.0])
    assert copied.step(action)[1] == own.step(action)[1]
    own.step(action)
    _, _, terminated, truncated, info = own.step(action)
    assert terminated and not truncated and info["diverged"] is False and info["ended_by"] == "late"


def test_info_tells_which_rule_ended_it_and_what_was_undefined() -> None:
    for expression, reason in (("time_s > 0.035", "second"), ("sqrt(0.035 - time_s) > 1", "undefined")):
        rules = [{"name": "first", "expression": "time_s > 0.055"}, {"name": "second", "expression": expression}]
        env = PassiveBipedEnv(omega_v=1.0, task={**PERIOD, "termination": {"extra": rules}})
        env.reset(seed=1)
        told = [env.step(np.zeros(2, dtype=np.float32))[4].get("ended_by") for _ in range(4)]
        assert told == [None] * 3 + [reason]


def test_gymnasium_accepts_it() -> None:
    env = gymnasium.make("gaitshift/PassiveBiped-v0", task={"reward": {"extra": [TERM]}})
    check_env(env.unwrapped, skip_render_check=True)


def test_the_vector_environment_tells_the_same() -> None:
    many = PassiveBipedVectorEnv(2, omega_v=1.0, task=TASK, autoreset_mode=AutoresetMode.SAME_STEP)
    one = PassiveBipedEnv(omega_v=1.0, task=TASK)
    many.reset(seed=[5, 6])
    one.reset(seed=6)
    action = np.array([0.3, -0.2])
    for step in range(6):
        _, rewards, terminated, _, infos = many.step(np.array([action, action]))
        _, reward, _, _, info = one.step(action)
        assert rewards[1] == reward
        told = infos["final_info"] if terminated[1] else infos
        assert told["reward_calm"][1] == info["reward_calm"] != 0.0
        assert terminated[1] == (step == 5)


def test_the_controller_records_it(tmp_path) -> None:
    # As the program does.
    with pytest.warns(UserWarning, match="tells left from right"):
        run = gaitshift.train(
            "fast",
            out=tmp_path / "run",
            set={
                "task.reward.extra": [TERM],
                "learner.actor_hidden": [8],
                "learner.critic_hidden": [8],
                "training.evaluation_interval_steps": 10**9,
                "training.metrics_interval_steps": 640,
            },
            steps=3200,
        )
    assert (run.metrics["reward/calm"] < 0).all()
    recording = gaitshift.Controller.load(run.folder / "controller-last.safetensors").record(1.0, duration_s=0.5)
    assert recording["reward_calm"][1:].max() < 0
    recording.write_csv(tmp_path / "r.csv")
    again = gaitshift.Recording.read_csv(tmp_path / "r.csv")
    assert list(again) == list(recording) and (again["reward_calm"] == recording["reward_calm"]).all()
    recording.write_npz(tmp_path / "r.npz")
    again = gaitshift.Recording.read_npz(tmp_path / "r.npz")
    assert (again["reward_calm"] == recording["reward_calm"]).all()


@pytest.mark.parametrize(
    ("task", "part"),
    [
        ({"reward": {"extra": [{**TERM, "expression": "right_comand"}]}}, "did you mean `right_command`"),
        ({"reward": {"extra": [{**TERM, "expression": "1 / omega_v"}]}}, "default start"),
        ({"reward": {"extra": [{**TERM, "name": "energy"}]}}, "reserved"),
        ({"reward": {"extra": [{**TERM, "wieght": 1}]}}, "did you mean `weight`"),
        ({"termination": {"extra": [{"name": "a", "expression": "z_m <"}]}}, "at its end"),
    ],
)
def test_mistakes_are_answered(task: dict, part: str) -> None:
    with pytest.raises(ValueError, match=part):
        PassiveBipedEnv(task=task)
