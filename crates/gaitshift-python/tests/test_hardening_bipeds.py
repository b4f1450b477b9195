"""Contract: the steps of experiments/hardening/gaits.py lack nothing where they are those of the commanded gait, more the less
they are like them, and nothing where no gait is commanded; the bipeds of mujoco_bipeds.py are observed and end as ours do,
and move as experiments/mujoco_transfer/transfer.py has them move on MuJoCo's default contact; those of hard_cases.py are
pushed as their episodes begin, or come to a step, most of them where the controller falls or gets stuck."""

import numpy as np
import pytest
from conftest import WALKER, experiment_script

import gaitshift


@pytest.fixture(scope="module")
def gaits():
    return experiment_script("hardening/gaits.py")


def lacks(gaits, steps, omega_v):
    """Of a motion given by (right force, left force, control periods)."""
    feet = gaits.Steps(1)
    lack = []
    for right, left, periods in steps:
        for _ in range(periods):
            landed, value = feet.lack(np.array([[right, left]], float), np.array([omega_v]), np.array([False]))
            lack += [value[0]] if landed[0] else []
            assert landed[0] or not value[0]
    return lack[1:]  # after the start


def run(flight):
    return 4 * [(800, 0, 30), (0, 0, flight), (0, 800, 30), (0, 0, flight)]


def walk(double):
    return 4 * [(390, 0, 40), (250, 150, double), (0, 390, 40), (150, 250, double)]


def test_the_commanded_gait_lacks_nothing(gaits):
    assert lacks(gaits, run(6), 3.0) == [0] * 5
    assert lacks(gaits, walk(6), 0.0) == [0] * 6


def test_the_other_gait_and_what_is_between_lack_more_and_more(gaits):
    of_run = [np.mean(lacks(gaits, motion, 3.0)) for motion in (run(4), run(3), run(1), walk(1), walk(4), walk(12))]
    assert of_run == sorted(of_run) and len(set(of_run)) == 6 and of_run[0] == 0
    of_walk = [np.mean(lacks(gaits, motion, 0.0)) for motion in (walk(4), walk(2), walk(1), run(1), run(4))]
    assert of_walk == sorted(of_walk) and len(set(of_walk)) == 5 and of_walk[0] == 0
    assert not any(lacks(gaits, motion, 0.5) for motion in (run(6), walk(6)))


def test_hopping_lacks_alternation_and_a_bounce_is_no_step(gaits):
    hop = 6 * [(800, 0, 20), (0, 0, 6)]
    assert lacks(gaits, hop, 3.0) == [1] * 3
    bouncing = 4 * [(800, 0, 2), (0, 0, 1), (800, 0, 27), (0, 0, 6), (0, 800, 30), (0, 0, 6)]
    assert lacks(gaits, bouncing, 3.0) == [0] * 5


def test_a_new_episode_begins_without_a_step(gaits):
    feet = gaits.Steps(1)
    command, on_both = np.array([0.0]), np.array([[200.0, 200.0]])
    feet.lack(np.array([[0.0, 0.0]]), command, np.array([True]))
    for force in (np.array([[0.0, 0.0]]), on_both, on_both):
        for _ in range(3):
            landed, lack = feet.lack(force, command, np.array([False]))
            assert not landed[0] and not lack[0]


@pytest.fixture(scope="module")
def mujoco_bipeds():
    return experiment_script("hardening/mujoco_bipeds.py")


def test_bipeds_in_mujoco_are_observed_as_ours(mujoco_bipeds):
    bipeds = mujoco_bipeds.MujocoBipeds(2, WALKER, np.random.default_rng(1))
    observations, _ = bipeds.reset(seed=3, options={"omega_v": np.array([0.0, 3.0])})
    ours = gaitshift.PassiveBipedEnv(controller=str(WALKER))
    for row, position, velocity, omega_v in zip(observations, bipeds.positions, bipeds.velocities, (0.0, 3.0)):
        expected, _ = ours.reset(options={"state": (position, velocity), "omega_v": omega_v})
        assert row == pytest.approx(expected)


def test_bipeds_in_mujoco_move_as_those_of_the_transfer(mujoco_bipeds, monkeypatch):
    """For half a second, with the same step: positions within a centimetre. What is left is the integrator's."""
    import mujoco

    monkeypatch.setattr(mujoco_bipeds, "TIME_STEP_S", 0.0002)

    transfer = experiment_script("mujoco_transfer/transfer.py")
    controller = gaitshift.Controller.load(WALKER)
    biped = transfer.Biped(
        transfer.with_default_contact(gaitshift.Body(controller.body).mjcf(controller.task)), controller.body, controller.task
    )
    bipeds = mujoco_bipeds.MujocoBipeds(1, WALKER, np.random.default_rng(1))
    observations, _ = bipeds.reset(seed=3, options={"omega_v": np.array([0.0])})
    biped.data.qpos[:], biped.data.qvel[:] = bipeds.positions[0], bipeds.velocities[0]
    mujoco.mj_forward(biped.model, biped.data)
    forces, means = [], []
    for _ in range(50):
        action = controller(observations[0])
        means.append(biped.period(action)[0][:, 0])
        observations, _, fell, _, info = bipeds.step(action[None])
        forces.append([info["right_normal_force_n"][0], info["left_normal_force_n"][0]])
        assert not fell[0]
    assert bipeds.positions[0] == pytest.approx(biped.data.qpos, abs=0.01)
    assert np.mean(forces, axis=0) == pytest.approx(np.mean(means, axis=0), rel=0.1)


def test_bipeds_in_mujoco_fall_and_begin_anew(mujoco_bipeds):
    bipeds = mujoco_bipeds.MujocoBipeds(3, WALKER, np.random.default_rng(1))
    bipeds.reset(seed=3, options={"omega_v": np.zeros(3)})
    bipeds.age[:] = 0
    bipeds.age[2] = mujoco_bipeds.EPISODE - 1
    for period in range(300):
        observations, _, fell, cut_off, info = bipeds.step(np.ones((3, 2)))
        if period == 0:
            assert cut_off.tolist() == [False, False, True] and not fell.any()
            assert info["final_obs"][2] != pytest.approx(observations[2])
        if fell.any():
            break
    index = int(np.argmax(fell))
    assert fell.any() and bipeds.age[index] == 0
    assert abs(observations[index][1]) < bipeds.end["pitch_limit_rad"]
    assert bipeds.positions[index, 1] > bipeds.end["min_hip_height_m"]
    assert not np.array_equal(info["final_obs"][index], observations[index])


@pytest.fixture
def hard_cases(monkeypatch):
    script = experiment_script("hardening/hard_cases.py")
    monkeypatch.setattr(script, "TRIED", 24)
    monkeypatch.setattr(script, "TRIED_STEPS", 24)
    monkeypatch.setattr(script, "MOTIONS", 2)
    return script


@pytest.fixture
def hard_pushes(hard_cases):
    actor = experiment_script("hardening/policy_gradient.py").Actor(WALKER)
    # A push that some motions withstand, and one that none does.
    cases = (hard_cases.Case(0.0, 320.0), hard_cases.Case(3.0, 800.0))
    bipeds = hard_cases.HardCases(40, WALKER, np.random.default_rng(1), actor, cases)
    bipeds.begun = bipeds.reset(options={}, seed=1)[0]
    return hard_cases, bipeds, actor


def test_the_pushes_that_it_falls_from_are_found(hard_pushes, capsys):
    script, bipeds, actor = hard_pushes
    some, all_of_them = (len(hard) for hard in bipeds.hard)
    assert 0 < some < 24 and all_of_them == 24
    # One by one, in an environment of their own.
    push = {"forward_n": 320.0, "start_s": 0.0, "duration_s": 0.1}
    alone = gaitshift.PassiveBipedEnv(controller=str(WALKER), disturbance={"pushes": [push]})
    for start in bipeds.starts[0]:
        observation, _ = alone.reset(options={"state": (start[:11], start[11:]), "omega_v": 0.0})
        fell = False
        for _ in range(script.TRIED_FOR):
            observation, _, fell, _, _ = alone.step(actor.act(observation[None])[0])
            if fell:
                break
        assert fell == any(np.array_equal(start, hard) for hard in bipeds.hard[0])
    bipeds.look(actor)
    assert "320 N at 0:" in capsys.readouterr().out


def test_most_episodes_begin_with_such_a_push_and_end_with_it(hard_pushes):
    script, bipeds, actor = hard_pushes
    assert bipeds.num_envs == 40 and list(np.unique(bipeds.omega_v)) == [0.0, 3.0]
    rows = np.concatenate([np.concatenate(bipeds.drawn(0)["state"], 1) for _ in range(20)])
    hard = np.mean([any(np.array_equal(row, one) for one in bipeds.hard[0]) for row in rows])
    share = len(bipeds.hard[0]) / 24
    assert hard == pytest.approx(script.HARD + (1 - script.HARD) * share, abs=0.08)
    observations = bipeds.begun
    assert (observations[:, -1] == bipeds.omega_v).all()
    falls, cut_off = np.zeros(40, int), np.zeros(40, int)
    for _ in range(script.EPISODE):
        observations, _, terminated, truncated, info = bipeds.step(actor.act(observations))
        assert (terminated & truncated).sum() == 0
        for biped in np.flatnonzero(terminated | truncated):
            assert info["final_obs"][biped].shape == (14,) and bipeds.age[biped] == 0
        falls, cut_off = falls + terminated, cut_off + truncated
    assert (falls[20:] >= 2).all() and cut_off[20:].sum() == 0
    assert falls[:20].sum() > 0 and cut_off[:20].sum() > 0


def test_a_step_is_hard_where_it_brings_the_body_down_or_to_rest(hard_cases, capsys):
    actor = experiment_script("hardening/policy_gradient.py").Actor(WALKER)
    # Steps that are got over, and one that is as high as a knee.
    cases = (hard_cases.Case(3.0, step_up_m=0.002), hard_cases.Case(0.0, step_up_m=0.4))
    bipeds = hard_cases.HardCases(20, WALKER, np.random.default_rng(1), actor, cases)
    observations, _ = bipeds.reset(options={}, seed=1)
    assert [len(hard) for hard in bipeds.hard] == [0, 24]
    assert "0.002 m at 3: 0 of 24, 0.4 m at 0: 24 of 24" in capsys.readouterr().out
    ahead_m = hard_cases.STEP_AT_M - np.concatenate(bipeds.starts)[:, 0]
    assert (hard_cases.AHEAD_M[0] <= ahead_m).all() and (ahead_m <= hard_cases.AHEAD_M[1]).all()
    ended = np.zeros(20, int)
    for _ in range(hard_cases.EPISODE):
        observations, _, terminated, _, _ = bipeds.step(actor.act(observations))
        ended += terminated
    assert not ended[:10].any() and (ended[10:] > 0).all()


def test_a_body_that_stands_before_a_step_is_stuck(hard_cases, monkeypatch):
    """Faster than it ever is, so that each motion counts as stuck, which none does in front of no step."""
    actor = experiment_script("hardening/policy_gradient.py").Actor(WALKER)
    monkeypatch.setattr(hard_cases, "STUCK_M_PER_S", 100.0)
    cases = (hard_cases.Case(0.0, 1.0), hard_cases.Case(0.0, step_up_m=0.001))
    bipeds = hard_cases.HardCases(4, WALKER, np.random.default_rng(1), actor, cases)
    observations, _ = bipeds.reset(options={}, seed=1)
    assert [len(hard) for hard in bipeds.hard] == [0, 24]
    _, _, terminated, cut_off, info = bipeds.step(actor.act(observations))
    assert terminated.tolist() == [False, False, True, True] and not cut_off.any()
    assert info["final_obs"][3].shape == (14,)
