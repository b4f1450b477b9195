"""Contract: a vector environment's every row is what the single environment of that seed gives, to the bit, through
automatic resets in each of Gymnasium's modes and for any number of threads; Gymnasium's own SyncVectorEnv is the oracle."""

import threading
import time

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import gaitshift

ID = "gaitshift/PassiveBiped-v0"
# Short episodes, so that there are many resets, some by the time limit and some by falls.
SHORT = {"task": {"termination": {"time_limit_s": 0.18, "min_hip_height_m": 0.7}}}


def assert_equal_info(ours, theirs, where):
    for key, value in theirs.items():
        assert key in ours, (where, key)
        if key == "final_info":
            assert_equal_info(ours[key], value, (where, key))
        elif key == "final_obs":
            for a, b in zip(ours[key], value):
                assert (a is None) == (b is None)
                if a is not None:
                    np.testing.assert_array_equal(a, b)
        elif not key.startswith("_"):
            mask = theirs["_" + key]
            np.testing.assert_array_equal(ours[key][mask], value[mask], err_msg=f"{where} {key}")
            assert ours["_" + key][mask].all()


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("threads", [1, 3])
def test_it_equals_gymnasiums_own_vector_of_single_environments(mode, threads):
    count = 5
    ours = gymnasium.make_vec(ID, num_envs=count, autoreset_mode=mode, threads=threads, **SHORT)
    assert isinstance(ours.unwrapped, gaitshift.PassiveBipedVectorEnv)
    theirs = SyncVectorEnv([lambda: gaitshift.PassiveBipedEnv(**SHORT)] * count, autoreset_mode=mode)
    assert ours.metadata["autoreset_mode"] == mode
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    rng = np.random.default_rng(1)
    a, b = ours.reset(seed=11), theirs.reset(seed=11)
    np.testing.assert_array_equal(a[0], b[0])
    assert_equal_info(a[1], b[1], "reset")
    ends, reasons = np.zeros(2), set()
    for k in range(300):
        actions = rng.uniform(-1, 1, (count, 2)).astype(np.float32)
        a, b = ours.step(actions), theirs.step(actions)
        for one, other in zip(a[:4], b[:4]):
            np.testing.assert_array_equal(one, other, err_msg=f"step {k}")
            assert one.dtype == other.dtype
        assert_equal_info(a[4], b[4], k)
        ends += [a[2].sum(), a[3].sum()]
        # Only where an episode ended, and by its name in the single environment's info.
        last = a[4].get("final_info", a[4])
        over = a[2] | a[3]
        assert ("ended_by" in last) == over.any()
        if over.any():
            np.testing.assert_array_equal(last["_ended_by"], over)
            assert all((reason is not None) == it for reason, it in zip(last["ended_by"], over))
            reasons |= set(last["ended_by"][over])
    assert np.all(ends > 3), f"terminated, truncated: {ends}"
    assert reasons == {"time limit", "hip height"}


def test_what_a_step_gave_is_not_changed_later():
    env = gymnasium.make_vec(ID, num_envs=3, autoreset_mode=AutoresetMode.DISABLED, **SHORT).unwrapped
    env.reset(seed=1)
    given = []
    for _ in range(40):
        _, _, terminated, truncated, info = env.step(np.ones((3, 2)))
        given.append((info, {key: value.copy() for key, value in info.items()}))
        if (terminated | truncated).any():
            env.reset(options={"reset_mask": terminated | truncated})
    for info, copied in given:
        for key, value in copied.items():
            np.testing.assert_array_equal(info[key], value, err_msg=key)


def test_without_automatic_resets_a_mask_resets():
    env = gymnasium.make_vec(ID, num_envs=3, autoreset_mode=AutoresetMode.DISABLED, **SHORT).unwrapped
    env.reset(seed=1)
    while True:
        observations, _, terminated, truncated, _ = env.step(np.zeros((3, 2)))
        if (terminated | truncated).any():
            break
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros((3, 2)))
    over = terminated | truncated
    again, info = env.reset(options={"reset_mask": over, "omega_v": 1.25})
    np.testing.assert_array_equal(again[~over], observations[~over])
    assert np.all(again[over][:, -1] == 1.25)
    np.testing.assert_array_equal(info["_time_s"], over)
    env.step(np.zeros((3, 2)))


def test_seeds():
    env = gymnasium.make_vec(ID, num_envs=3)
    first = env.reset(seed=5)[0]
    np.testing.assert_array_equal(env.reset(seed=[5, 6, 7])[0], first)
    np.testing.assert_array_equal(env.reset(seed=[None, 6, 7])[0][1:], first[1:])
    other = gymnasium.make_vec(ID, num_envs=3).reset()[0]
    assert len(np.unique(other[:, 7])) == 3


def test_gymnasiums_processes_can_run_it_too():
    controller = gaitshift.Controller.shipped()
    env = gymnasium.make_vec(ID, num_envs=2, vectorization_mode="async", controller=controller)
    observations, _ = env.reset(seed=5)
    ours = gymnasium.make_vec(ID, num_envs=2, controller=controller)
    np.testing.assert_array_equal(observations, ours.reset(seed=5)[0])
    env.close()


def test_commands_of_each_environment():
    env = gymnasium.make_vec(ID, num_envs=2).unwrapped
    env.reset(seed=1)
    env.set_omega_v([0.5, 1.5])
    np.testing.assert_array_equal(env.step(np.zeros((2, 2)))[0][:, -1], [0.5, 1.5])
    for values, words in (([1.0, 2.0, 3.0], "omega_v has the length 3, but there are 2"), ([1.0, np.nan], "`omega_v` is NaN")):
        with pytest.raises(ValueError, match=words):
            env.set_omega_v(values)
    np.testing.assert_array_equal(env.step(np.zeros((2, 2)))[0][:, -1], [0.5, 1.5])


# What went wrong: a sequence was refused at reset, "must be a number", although states are given one for each.
@pytest.mark.parametrize("omega_v", [[0, 1, 2], (0.0, 1.0, 2.0), np.arange(3)])
def test_commands_of_each_environment_at_reset(omega_v):
    env = gymnasium.make_vec(ID, num_envs=3).unwrapped
    observations, info = env.reset(seed=1, options={"omega_v": omega_v})
    np.testing.assert_array_equal(observations[:, -1], [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(info["omega_v"], [0.0, 1.0, 2.0])
    # To the bit as one by one.
    for i in range(3):
        alone = gaitshift.PassiveBipedEnv().reset(seed=1 + i, options={"omega_v": float(i)})[0]
        np.testing.assert_array_equal(observations[i], alone)
    # Those beside the mask keep theirs.
    mask = np.array([False, True, False])
    observations, _ = env.reset(options={"omega_v": [3.0, 3.0, 3.0], "reset_mask": mask})
    np.testing.assert_array_equal(observations[:, -1], [0.0, 3.0, 2.0])


@pytest.mark.parametrize(
    ("omega_v", "error", "words"),
    [
        ([1.0, 2.0], ValueError, "has the length 2, but there are 3"),
        ([1.0], ValueError, "has the length 1, but there are 3"),
        ([], ValueError, "has the length 0, but there are 3"),
        ([1.0, np.nan, 2.0], ValueError, "`omega_v` is NaN"),
        ([1.0, 101.0, 2.0], ValueError, "`omega_v` is 101"),
        ("fast", TypeError, "a number, or 3 of them"),
        (["a", "b", "c"], TypeError, "a number, or 3 of them"),
        ([[1.0], [1.0, 2.0], 3.0], TypeError, "a number, or 3 of them"),
        (np.ones((3, 1)), TypeError, "a number, or 3 of them"),
    ],
)
def test_bad_commands_at_reset_change_nothing(omega_v, error, words):
    env = gymnasium.make_vec(ID, num_envs=3, omega_v=0.5).unwrapped
    env.reset(seed=1)
    with pytest.raises(error, match=words):
        env.reset(options={"omega_v": omega_v})
    np.testing.assert_array_equal(env.step(np.zeros((3, 2)))[0][:, -1], [0.5] * 3)


def test_it_steps_without_the_interpreters_lock():
    # Long control periods, so that a step takes milliseconds.
    env = gymnasium.make_vec(ID, num_envs=64, task={"control_period_s": 0.05}).unwrapped
    env.reset(seed=1)
    actions = np.zeros((64, 2))
    running, counted = True, 0

    def count():
        nonlocal counted
        while running:
            counted += 1
            time.sleep(1e-4)

    thread = threading.Thread(target=count)
    thread.start()
    try:
        start, largest = time.perf_counter(), 0
        while time.perf_counter() - start < 2.0:
            before = counted
            env.step(actions)
            # With the lock held for the whole step, at most the switch at its beginning is counted.
            largest = max(largest, counted - before)
    finally:
        running = False
        thread.join()
    assert largest >= 5, "no other thread ran during a step"


@pytest.mark.parametrize(
    "actions", [np.zeros((2, 2)), np.zeros(6), np.full((3, 2), np.nan), np.zeros((3, 3)), "forward", None]
)
def test_bad_actions_are_refused(actions):
    env = gymnasium.make_vec(ID, num_envs=3).unwrapped
    env.reset(seed=1)
    with pytest.raises((ValueError, TypeError)):
        env.step(actions)


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"num_envs": 0}, ValueError),
        ({"num_envs": -1}, ValueError),
        ({"num_envs": 10**9}, ValueError),
        ({"num_envs": 2, "threads": -1}, ValueError),
        ({"num_envs": 2, "threads": 0}, ValueError),
        ({"num_envs": 2, "autoreset_mode": "sometimes"}, ValueError),
        ({"num_envs": 2, "body": {"mass": 1.0}}, ValueError),
        ({"num_envs": 2, "wheels": 4}, TypeError),
    ],
)
def test_what_cannot_be_made_is_refused(options, error):
    with pytest.raises(error):
        gymnasium.make_vec(ID, **options)


def test_bad_resets_are_refused():
    env = gymnasium.make_vec(ID, num_envs=2).unwrapped
    calls = [lambda: env.step(np.zeros((2, 2))), lambda: env.set_omega_v(1.0)]
    for call in calls:
        with pytest.raises(gymnasium.error.ResetNeeded):
            call()
    with pytest.raises(ValueError):
        env.reset(seed=[1, 2, 3])
    for seed in (-1, [0, -1], [0, "one"], 2**64 - 1):
        with pytest.raises(gymnasium.error.Error, match="seed"):
            env.reset(seed=seed)
    with pytest.raises(TypeError):
        env.reset(options={"reset_mask": [True, False]})
    with pytest.raises(ValueError):
        env.reset(options={"reset_mask": np.array([True])})
    with pytest.raises(ValueError, match="wind"):
        env.reset(options={"wind": 1.0})
    env.reset()
    env.close()
    for call in (*calls, env.reset):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError):
            call()
