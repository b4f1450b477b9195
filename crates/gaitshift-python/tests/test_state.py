"""Contract: an episode begins in the state that it is given; a pickled or copied environment goes on to the same bits, in
mid-episode, randomized or disturbed too; episodes that are randomized or disturbed differ as they should, from the starts that
a seed draws without; what makes no sense is refused."""

import copy
import json
import pickle

import gymnasium
import numpy as np
import pytest

import gaitshift

ID = "gaitshift/PassiveBiped-v0"
RANDOMIZATION = {
    "body": {"friction": [0.5, 1.5]},
    "latency_s": [0.0, 0.02],
    "noise": {"theta_rad": 0.05},
    "actuator_factor": [0.7, 1.0],
    "pushes": {"interval_s": 0.3, "forward_n": [-60, 60]},
    "terrain": {"slope_rad": [-0.05, 0.05], "steps": {"height_m": [-0.02, 0.02]}, "uneven": {"height_m": [0, 0.01]}},
}
DISTURBANCE = {
    "latency_s": 0.004,
    "noise": {"phi_rad": 0.02},
    "pushes": [{"forward_n": 60.0, "start_s": 0.15}],
    "terrain": {"slope_rad": 0.03},
}


def make(**options):
    return gymnasium.make(ID, **options).unwrapped


def vector(count, **options):
    return gymnasium.make_vec(ID, num_envs=count, vectorization_mode="vector_entry_point", **options).unwrapped


def episode(env, steps, seed=3):
    """What so many steps give, under actions that a seed draws."""
    rng = np.random.default_rng(seed)
    shape = env.action_space.shape
    told = []
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(rng.uniform(-0.5, 0.5, shape))
        told.append((observation, reward, terminated, truncated, {k: v for k, v in info.items() if not k.startswith("final")}))
    return told


def assert_same(one, other):
    for a, b in zip(one, other, strict=True):
        for x, y in zip(a[:4], b[:4]):
            np.testing.assert_array_equal(x, y)
        assert a[4].keys() == b[4].keys()
        for name in a[4]:
            np.testing.assert_array_equal(a[4][name], b[4][name])


def test_an_episode_begins_in_the_state_that_is_given():
    env = make(omega_v=1.0)
    env.reset(seed=5)
    episode(env, 20)
    positions, velocities = env.state
    other = make(omega_v=1.0)
    observation, info = other.reset(options={"state": (positions, velocities), "omega_v": 2.5})
    for given, put in zip((positions, velocities), other.state):
        np.testing.assert_allclose(put, given, rtol=0, atol=1e-12)
    assert other.omega_v == 2.5 and observation[-1] == 2.5 and info["time_s"] == 0.0
    # Where it is put is where it goes on from: the same actions lead to the same place, to rounding.
    env.reset(options={"state": (positions, velocities), "omega_v": 2.5})
    assert_same(episode(env, 20), episode(other, 20))


def test_states_of_several_environments():
    env = vector(3, omega_v=1.0)
    positions = np.zeros((3, 11))
    positions[:, 1] = [0.9, 1.0, 1.1]
    env.reset(seed=1, options={"state": (positions, np.zeros(11))})
    # One mask, and the states of the others stay.
    mask = np.array([False, True, False])
    positions[:, 1] = 2.0
    _, info = env.reset(options={"state": (positions, np.zeros((3, 11))), "reset_mask": mask})
    np.testing.assert_allclose(info["z_m"], [0.9, 2.0, 1.1])


@pytest.mark.parametrize(
    "state, words",
    [
        (([0.0] * 10, [0.0] * 11), "(11,)"),
        (([0.0] * 11,), "pair"),
        (3, "pair"),
        (([np.nan] * 11, [0.0] * 11), "finite"),
        (("a", "b"), "pair"),
        ((0.0, 0.0), "(11,)"),
    ],
)
def test_states_that_are_none_are_refused(state, words):
    env = make()
    with pytest.raises(ValueError, match="state") as error:
        env.reset(options={"state": state})
    assert words in str(error.value)


def test_a_state_and_a_start_exclude_each_other():
    env = make()
    env.reset()
    with pytest.raises(ValueError, match="'start' and 'state'"):
        env.reset(options={"state": env.state, "start": "default"})


@pytest.mark.parametrize("options", [{}, {"randomization": RANDOMIZATION}, {"disturbance": DISTURBANCE}])
@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("several", [False, True])
def test_a_copy_goes_on_to_the_same_bits(options, duplicate, several):
    env = vector(3, **options) if several else make(**options)
    env.reset(seed=11)
    episode(env, 10, seed=1)
    other = duplicate(env)
    assert other is not env and other.body == env.body and other.task == env.task
    expected = episode(env, 60)
    assert_same(expected, episode(other, 60))
    # Both have been moved by themselves, and draw the same next episode.
    first, second = env.reset(), other.reset()
    np.testing.assert_array_equal(first[0], second[0])


def test_wrapped_environments_are_copied_too():
    env = gymnasium.make(ID, omega_v=2.0)
    env.reset(seed=4)
    other = copy.deepcopy(env)
    np.testing.assert_array_equal(env.step([0.3, -0.2])[0], other.step([0.3, -0.2])[0])


def test_a_damaged_pickle_is_refused():
    env = make()
    state = env.__getstate__()
    with pytest.raises(ValueError, match="saved environment"):
        env.__setstate__({**state, "_batch": state["_batch"][:-20]})
    # One of no environments was taken, and its first step panicked.
    empty = json.dumps({**json.loads(state["_batch"]), "state": []})
    with pytest.raises(ValueError, match="no environments"):
        env.__setstate__({**state, "_batch": empty})


def test_episodes_are_randomized():
    env, plain = make(omega_v=1.0, randomization=RANDOMIZATION), make(omega_v=1.0)
    observation, _ = env.reset(seed=8)
    undisturbed, _ = plain.reset(seed=8)
    # The same start; only the noise of the pitch is in what is told of it.
    for state, other in zip(env.state, plain.state):
        np.testing.assert_array_equal(state, other)
    different = np.flatnonzero(observation != undisturbed)
    assert [gaitshift.OBSERVATION_NAMES[i] for i in different] == ["theta_rad"]
    # Episodes differ from each other although they begin in one state under the same actions.
    ends = []
    for _ in range(4):
        env.reset(options={"state": plain.state})
        episode(env, 30)
        ends.append(env.state[0])
    assert len({tuple(end) for end in ends}) == 4


def test_episodes_are_disturbed():
    seeds = {"seed": 2, "options": {"start": "default"}}
    env = make(omega_v=1.0, disturbance={"pushes": [{"forward_n": 100.0, "start_s": 0.05, "duration_s": 0.1}]})
    plain = make(omega_v=1.0)
    for each in (env, plain):
        each.reset(**seeds)
    assert_same(episode(env, 5), episode(plain, 5))
    episode(env, 10), episode(plain, 10)
    # 10 N s on 40 kg, as far as the ground lets it.
    assert env.state[1][0] > plain.state[1][0] + 0.05
    slope = make(omega_v=1.0, disturbance={"terrain": {"slope_rad": 0.1}})
    slope.reset(**seeds)
    assert slope.state[0][1] > plain.reset(**seeds)[1]["z_m"]


def test_a_push_comes_at_a_phase_of_the_stride():
    controller = gaitshift.Controller.shipped()
    push = {"forward_n": 100.0, "start_s": 3.0, "phase": 0.5}
    noted = controller.record(3.0, 6.0, seed=2, disturbance={"pushes": [push]}).metadata["disturbance"]
    recording = controller.record(3.0, 6.0, seed=2)
    env = make(omega_v=3.0, controller=controller, disturbance={"pushes": [push]})
    observation, _ = env.reset(seed=2)
    moved = [env.state[0][0]]
    for period in range(recording.rows - 1):
        if period == 320:  # while it waits, or acts
            env = copy.deepcopy(env)
        observation, *_ = env.step(controller(observation))
        moved.append(env.state[0][0])
    [first, *_] = np.flatnonzero(recording["x_m"] != np.array(moved))
    # The stride before it is as long as its own to within some percent.
    assert recording["time_s"][first] == pytest.approx(noted["pushes"][0]["start_s"], abs=0.03)
    assert moved[-1] > recording["x_m"][-1]


# A push without `start_s` comes at 5 s, when an episode is over, and nothing said so.
def test_a_push_after_the_end_is_warned_of():
    with pytest.warns(UserWarning, match="the push at 5 s never comes: episodes last 5 s"):
        make(disturbance={"pushes": [{"forward_n": 100.0}]})
    make(disturbance={"pushes": [{"forward_n": 100.0, "start_s": 4.0}]})
    make(disturbance={"pushes": [{"forward_n": 100.0}]}, task={"termination": {"time_limit_s": 6.0}})


@pytest.mark.parametrize(
    "options, words",
    [
        ({"randomization": {"latency_s": [0.1, 0.0]}}, "randomization.latency_s"),
        ({"randomization": {"body": {"frction": [1, 2]}}}, "did you mean `friction`"),
        ({"randomization": {"terrain": {"slope_rad": [0, 2]}}}, "randomization.terrain.slope_rad"),
        ({"randomization": {"pushes": {"interval": 1}}}, "did you mean `interval_s`"),
        ({"disturbance": {"latencey_s": 1}}, "did you mean `latency_s`"),
        ({"disturbance": {"terrain": {"slope_rad": 3}}}, "terrain.slope_rad"),
        ({"disturbance": {"pushes": [{"phase": 1}]}}, "pushes[0].phase"),
        ({"disturbance": DISTURBANCE, "randomization": RANDOMIZATION}, "randomization"),
    ],
)
def test_what_cannot_be_is_refused(options, words):
    with pytest.raises(ValueError) as error:
        make(**options)
    assert words in str(error.value)


def test_a_table_must_be_a_mapping():
    with pytest.raises(TypeError, match="randomization"):
        make(randomization=3)
