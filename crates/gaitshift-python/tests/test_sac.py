"""Contract: the learner serves any Gymnasium environment: it finds the known optimum of a small task; the same seed and
calls give the same numbers for any number of threads, saved and loaded or not; actions keep their bounds; what is wrong
is one clear error and changes nothing."""

import json

import gymnasium
import numpy as np
import pytest

import gaitshift

SMALL = {"hidden": (32, 32), "batch_size": 64, "capacity": 2000}


class Reach(gymnasium.Env):
    """A point on a line; the reward is minus the distance to 0.5 after each move, so the best action is the difference.
    Bounds that are not symmetric show that actions are scaled."""

    observation_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
    action_space = gymnasium.spaces.Box(-3.0, 1.0, (1,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.x, self.moves = self.np_random.uniform(-0.4, 1.0), 0
        return np.array([self.x], np.float32), {}

    def step(self, action):
        self.x = float(np.clip(self.x + action[0], -1.0, 1.0))
        self.moves += 1
        return np.array([self.x], np.float32), -abs(self.x - 0.5), False, self.moves == 5, {}


def drive(learner, env, steps, seed=None, updates=1):
    observation, _ = env.reset(seed=seed)
    for _ in range(steps):
        action = learner.act(observation)
        following, reward, terminated, truncated, _ = env.step(action)
        learner.observe(observation, action, reward, following, terminated, truncated)
        observation = env.reset()[0] if terminated or truncated else following
        learner.update(updates)


def test_it_finds_a_known_optimum():
    env = Reach()
    learner = gaitshift.SAC.for_spaces(env.observation_space, env.action_space, gamma=0.5, learning_rate=2e-3, **SMALL)
    drive(learner, env, 1500, seed=1)
    positions = np.linspace(-0.3, 0.9, 7, dtype=np.float32).reshape(-1, 1)
    reached = positions + learner.act(positions, deterministic=True)
    assert np.abs(reached - 0.5).max() < 0.1
    # Nobody reaches it by chance.
    untrained = gaitshift.SAC.for_spaces(env.observation_space, env.action_space, **SMALL)
    assert np.abs(positions + untrained.act(positions, deterministic=True) - 0.5).max() > 0.3
    assert learner.updates == 1500 and learner.stored == 1500


def learned(learner, steps=120, seed=5):
    drive(learner, Reach(), steps, seed=seed)
    return learner.act([[0.1], [0.7]], deterministic=True)


def make(**settings):
    return gaitshift.SAC(1, 1, action_low=-3.0, action_high=1.0, **{**SMALL, **settings})


@pytest.mark.parametrize("settings", [{}, {"n_step": 3}, {"temperature": 0.1}])
def test_the_same_seed_gives_the_same_numbers_for_any_number_of_threads(settings):
    one = learned(make(seed=4, **settings))
    np.testing.assert_array_equal(one, learned(make(seed=4, threads=3, **settings)))
    assert (one != learned(make(seed=5, **settings))).any()


@pytest.mark.parametrize("settings", [{}, {"n_step": 3}])
def test_saved_and_loaded_it_goes_on_to_the_same_bits(tmp_path, settings):
    through, stopped = make(seed=2, **settings), make(seed=2, **settings)
    for learner in (through, stopped):
        drive(learner, Reach(), 100, seed=1)
    stopped.save(tmp_path / "learner")
    stopped.save(f"{tmp_path}/learner/")  # over the one before
    loaded = gaitshift.SAC.load(tmp_path / "learner")
    assert (loaded.updates, loaded.stored, loaded.capacity) == (100, 100, 2000)
    assert loaded.settings == through.settings
    np.testing.assert_array_equal(learned(through), learned(loaded))
    assert [path.name for path in tmp_path.iterdir()] == ["learner"]


@pytest.mark.parametrize("settings", [{}, {"n_step": 3}])
def test_saved_between_acting_and_observing_it_goes_on_to_the_same_bits(tmp_path, settings):
    """The probability of the action that was drawn was lost: sums over several rewards took it for a random one."""
    learner, env = make(seed=2, **settings), Reach()
    drive(learner, env, 99, seed=1)
    observation, _ = env.reset()
    action = learner.act(observation)
    learner.save(tmp_path / "learner")
    loaded = gaitshift.SAC.load(tmp_path / "learner")
    following, reward, terminated, truncated, _ = env.step(action)
    for each in (learner, loaded):
        each.observe(observation, action, reward, following, terminated, truncated)
        each.update(60)
    np.testing.assert_array_equal(learned(learner), learned(loaded))


def test_several_environments_are_observed_row_by_row():
    envs = gymnasium.vector.SyncVectorEnv(
        [Reach] * 3, autoreset_mode=gymnasium.vector.AutoresetMode.SAME_STEP
    )
    learner = gaitshift.SAC.for_spaces(
        envs.single_observation_space, envs.single_action_space, environments=3, capacity=300, batch_size=32
    )
    observations, _ = envs.reset(seed=1)
    for _ in range(20):
        actions = learner.act(observations)
        assert actions.shape == (3, 1) and actions.dtype == np.float32
        following, rewards, terminated, truncated, infos = envs.step(actions)
        last = following.copy()
        for i in np.flatnonzero(terminated | truncated):
            last[i] = infos["final_obs"][i]
        learner.observe(observations, actions, rewards, last, terminated, truncated)
        observations = following
    assert learner.stored == 60
    stats = learner.update(4)
    assert learner.updates == 4 and set(stats) == {"critic_loss", "actor_loss", "mean_q", "entropy", "alpha"}
    assert all(np.isfinite(value) for value in stats.values())


def test_actions_keep_their_bounds():
    learner = gaitshift.SAC(2, 2, action_low=[-1.0, 0.0], action_high=[2.0, 0.5], **SMALL)
    actions = np.array([learner.act([0.3, -0.2]) for _ in range(300)])
    assert (actions.min(axis=0) >= [-1.0, 0.0]).all() and (actions.max(axis=0) <= [2.0, 0.5]).all()
    assert (actions.max(axis=0) - actions.min(axis=0) > [1.5, 0.25]).all()


def test_bad_settings_are_named():
    for settings, words in [
        ({"gama": 0.9}, "did you mean `gamma`"),
        ({"gamma": 2.0}, "`gamma` is 2.0"),
        ({"temperature": "cold"}, "'auto'"),
        ({"hidden": ()}, "actor_hidden"),
        ({"capacity": 0}, "`capacity` is 0"),
        ({"capacity": 10**15}, "64 GiB"),
        ({"environments": 0}, "`environments` is 0"),
        ({"seed": -1}, "`seed` is -1"),
        ({"action_low": 1.0}, "low below high"),
        ({"action_low": [0.0, 0.0]}, "1 of them"),
        ({"mirror_loss_weight": 1.0}, "no longer exists"),
    ]:
        with pytest.raises(ValueError, match=words):
            gaitshift.SAC(1, 1, **settings)
    with pytest.raises(TypeError, match="needs a Box"):
        gaitshift.SAC.for_spaces(Reach.observation_space, gymnasium.spaces.Discrete(3))
    with pytest.raises(ValueError, match="needs bounds"):
        gaitshift.SAC.for_spaces(Reach.observation_space, gymnasium.spaces.Box(-np.inf, np.inf, (1,)))


def test_bad_values_are_named_and_not_stored():
    learner = make()
    good = {"observation": [0.1], "action": [0.2], "reward": 1.0, "next_observation": [0.2], "terminated": False}
    for change, words in [
        ({"observation": [0.1, 0.2]}, r"`observation` has the shape \(2,\), but it must be \(1,\)"),
        ({"next_observation": [np.nan]}, "every number must be finite"),
        ({"reward": np.inf}, "`reward`"),
        ({"reward": [1.0, 2.0]}, "`reward` has the shape"),
        ({"action": [1.5]}, "within the bounds"),
    ]:
        with pytest.raises(ValueError, match=words):
            learner.observe(**{**good, **change})
    assert learner.stored == 0
    with pytest.raises(ValueError, match="no valid transition"):
        learner.update()
    with pytest.raises(ValueError, match="`n` is -1"):
        learner.update(-1)
    with pytest.raises(ValueError, match="shape"):
        learner.act([[0.1], [0.2]])
    learner.observe(**good)
    assert learner.stored == 1


def test_what_is_no_saved_learner_is_refused_and_nothing_is_overwritten(tmp_path):
    with pytest.raises(FileNotFoundError):
        gaitshift.SAC.load(tmp_path / "absent")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "work.txt").write_text("hours of it")
    with pytest.raises(ValueError, match="holds no saved learner"):
        make().save(tmp_path / "mine")
    learner = make()
    learner.save(tmp_path / "learner")
    agent = tmp_path / "learner" / "agent.safetensors"
    agent.write_bytes(agent.read_bytes()[:-100])
    with pytest.raises(ValueError, match=r"agent\.safetensors"):
        gaitshift.SAC.load(tmp_path / "learner")
    learner.save(tmp_path / "learner")
    settings = tmp_path / "learner" / "sac.json"
    saved = json.loads(settings.read_text())
    for damaged in ({}, saved | {"drawn": [[0.5], []]}, saved | {"drawn": "nothing"}):
        settings.write_text(json.dumps(damaged))
        with pytest.raises(ValueError, match=r"sac\.json"):
            gaitshift.SAC.load(tmp_path / "learner")


def test_settings_may_be_numpys_numbers():
    # What went wrong: integers of NumPy became 64.0, which is no number of units.
    learner = make(batch_size=np.int64(32), hidden=(np.int64(8),) * 2, critic_layer_norm=np.True_, gamma=np.float32(0.5))
    learner.act(np.zeros((1, 1), np.float32))
