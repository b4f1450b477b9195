"""Contract: the environment is the Rust task to the last bit, and a Gymnasium environment by Gymnasium's own checks.
Observation, reward terms, termination and every number in info equal those of a recording by the Rust program."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import gaitshift

ID = "gaitshift/PassiveBiped-v0"


def make(**options):
    return gymnasium.make(ID, **options).unwrapped


@pytest.mark.parametrize("options", [{}, {"omega_v": 2.0}, {"experiment": "fast"}, {"body": {"friction": 0.5}}])
def test_gymnasium_accepts_it(options):
    check_env(make(**options))


@pytest.mark.parametrize("omega_v", [0.0, 3.0])
@pytest.mark.parametrize("seed", [None, 7])
def test_it_moves_as_the_program_does_to_the_bit(program, tmp_path, omega_v, seed):
    drawn = [] if seed is None else ["--seed", seed]
    program("evaluate", "--omega-v", omega_v, "--duration-s", 4, "--out", tmp_path, *drawn)
    recording = gaitshift.Recording.read_csv(tmp_path / f"omega_v_{omega_v:g}.csv")
    controller = gaitshift.Controller.shipped()
    env = make(controller=controller, omega_v=omega_v)
    observation, info = env.reset(seed=seed, options={"start": "default" if seed is None else "random"})
    observed = [name for name in gaitshift.OBSERVATION_NAMES if name in recording and name != "omega_v"]
    assert len(observed) == 13
    shared = set(gaitshift.INFO_NAMES) & set(gaitshift.COLUMNS)
    assert shared == set(gaitshift.INFO_NAMES) - {"diverged"}
    assert recording.rows > 100
    for row in range(recording.rows):
        if row > 0:
            observation, reward, terminated, truncated, info = env.step(controller(observation))
            assert not truncated
            fell = recording.metadata["fell"] and row == recording.rows - 1
            assert terminated == fell
            reward_factor = 1.0 / (1.0 + env.task["reward"]["command_divisor"] * max(omega_v, 0.0))
            assert reward == reward_factor * recording["reward"][row]
        by_name = dict(zip(gaitshift.OBSERVATION_NAMES, observation))
        for name in observed:
            assert by_name[name] == recording[name][row], (name, row)
        for name in shared:
            assert info[name] == recording[name][row], (name, row)


def test_a_fall_terminates_where_the_program_says(program, tmp_path):
    # Ice: the shipped controller does not stand on it.
    body = tmp_path / "ice.toml"
    body.write_text("friction = 0.01\n")
    program("evaluate", "--omega-v", 3, "--body", body, "--out", tmp_path)
    recording = gaitshift.Recording.read_csv(tmp_path / "omega_v_3.csv")
    assert recording.metadata["fell"]
    controller = gaitshift.Controller.shipped()
    env = make(controller=controller, omega_v=3.0, body={"friction": 0.01})
    observation, _ = env.reset(options={"start": "default"})
    for row in range(1, recording.rows):
        observation, _, terminated, _, info = env.step(controller(observation))
        assert terminated == (row == recording.rows - 1)
        assert ("ended_by" in info) == terminated
    assert info["ended_by"] == recording.metadata["ended_by"] == "hip height"


def test_the_time_limit_truncates():
    env = make(task={"control_period_s": 0.01, "termination": {"time_limit_s": 0.05}})
    env.reset(seed=1)
    steps = [env.step(np.zeros(2))[2:] for _ in range(5)]
    assert [step[:2] for step in steps] == [(False, False)] * 4 + [(False, True)]
    assert [step[2].get("ended_by") for step in steps] == [None] * 4 + ["time limit"]
    assert "ended_by" not in env.reset()[1]


def test_a_diverged_simulation_terminates_with_a_flag_and_finite_numbers():
    # One stiff damper on a light foot: the step cannot resolve it.
    env = make(body={"c1_ns_per_m": 1e6, "foot_mass_kg": 0.01})
    env.reset(seed=1)
    for _ in range(200):
        observation, reward, terminated, _, info = env.step(np.ones(2))
        assert np.all(np.isfinite(observation)) and np.isfinite(reward)
        if terminated:
            break
    assert info["diverged"] is True
    assert info.pop("ended_by") == "diverged"
    assert all(np.isfinite(value) for value in info.values())


def test_the_reward_is_the_sum_of_its_terms():
    env = make(omega_v=1.5)
    env.reset(seed=3)
    for _ in range(20):
        _, reward, _, _, info = env.step(env.action_space.sample())
        assert reward == pytest.approx(sum(info[name] for name in info if name.startswith("reward_")), abs=1e-12)


def test_seeds():
    env = make()
    first, info = env.reset(seed=5)
    second, _ = env.reset()
    again, info_again = env.reset(seed=5)
    np.testing.assert_array_equal(first, again)
    assert info == info_again
    np.testing.assert_array_equal(second, env.reset()[0])
    assert np.any(first != second)
    # Without a seed, two environments start differently.
    assert np.any(make().reset()[0] != make().reset()[0])


def test_the_command_is_drawn_or_given_or_changed():
    env = make(omega_v=(1.0, 2.0))
    drawn = [env.reset(seed=k)[0][-1] for k in range(50)]
    assert min(drawn) >= 1.0 and max(drawn) <= 2.0 and max(drawn) - min(drawn) > 0.5
    assert env.reset(options={"omega_v": 3.0})[0][-1] == 3.0
    env.omega_v = -0.25
    assert env.step(np.zeros(2))[0][-1] == -0.25
    assert env.omega_v == -0.25


def test_the_command_is_changed_inside_the_wrappers():
    # The documented ways; an attribute of the wrapper is none of the environment's.
    for change in (
        lambda env: setattr(env.unwrapped, "omega_v", 2.5),
        lambda env: env.set_wrapper_attr("omega_v", 2.5),
    ):
        env = gymnasium.make(ID, omega_v=1.0)
        env.reset(seed=1)
        change(env)
        assert env.step(np.zeros(2, dtype=np.float32))[0][-1] == 2.5


# docs/formats.md says both of the noise of environments.
def test_disturbed_it_moves_as_the_program_does_to_the_bit_but_for_noise():
    controller = gaitshift.Controller.shipped()
    disturbance = {
        "latency_s": 0.004,
        "actuator_factor": [0.9, 1.0],
        "pushes": [{"forward_n": 60, "start_s": 0.5}],
        "terrain": {
            "slope_rad": 0.03,
            "slope_from_m": 0.5,
            "steps": [{"height_m": 0.005, "at_m": 1.2}],
            "uneven": {"height_m": 0.003, "from_m": 2},
        },
    }
    differ = {}
    for noise in (0.0, 0.01):
        disturbance["noise"] = {"theta_rad": noise}
        recording = controller.record(1.5, 2.0, seed=7, disturbance=disturbance)
        env = make(controller=controller, omega_v=1.5, disturbance=disturbance)
        observation, info = env.reset(seed=7)
        x_m = [info["x_m"]]
        for _ in range(1, recording.rows):
            observation, _, terminated, truncated, info = env.step(controller(observation))
            x_m.append(info["x_m"])
            if terminated or truncated:
                break
        assert len(x_m) > 100
        differ[noise] = not np.array_equal(x_m, recording["x_m"][: len(x_m)])
        assert x_m[0] == recording["x_m"][0]
    assert differ == {0.0: False, 0.01: True} and x_m[-1] > 2.5


def test_actions_beyond_the_limits_are_limited():
    one, two = make(), make()
    one.reset(seed=1), two.reset(seed=1)
    np.testing.assert_array_equal(one.step([5.0, -7.0])[0], two.step([1.0, -1.0])[0])


def test_parameters_can_be_read_and_changed():
    env = make(experiment="fast", body={"foot_mass_kg": 2.0}, task={"reward": {"c3": 0.7}})
    assert env.body["foot_mass_kg"] == 2.0
    assert env.task["reward"]["c3"] == 0.7
    positions, velocities = env.state
    assert positions.shape == velocities.shape == (11,)


ENDLESS: dict[str, object] = {}
ENDLESS["body"] = ENDLESS


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"body": ENDLESS}, ValueError, "`body`: .*[Cc]ircular"),
        ({"body": {"foot_mass": 2.0}}, ValueError, "foot_mass"),
        ({"body": {"foot_mass_kg": -2.0}}, ValueError, "foot_mass_kg"),
        ({"body": {"foot_mass_kg": float("nan")}}, ValueError, "`body`, `foot_mass_kg`: .* not finite"),
        ({"task": {"start": {"pitch_rad": [0, float("inf")]}}}, ValueError, r"`task`, `start.pitch_rad\[1\]`"),
        ({"body": {"foot_mass_kg": object()}}, ValueError, "`body`"),
        ({"body": {"foot_mass_kg": "heavy"}}, ValueError, "heavy"),
        ({"body": 3}, TypeError, "body"),
        ({"disturbance": {"latency_s": [3]}}, ValueError, "`latency_s`"),
        ({"disturbance": {"pushes": [{"forward_n": "a"}]}}, ValueError, "forward_n"),
        ({"disturbance": {"terrain": 3}}, ValueError, "`terrain`: .* expected a table"),
        ({"randomization": {"latency_s": 0.01}}, ValueError, "`latency_s`"),
        ({"body": {"time_step_s": 0.003}}, ValueError, "control_period_s"),
        ({"task": {"control_period_s": 0.0}}, ValueError, "control_period_s"),
        ({"experiment": "slow"}, ValueError, "slow"),
        ({"experiment": "no/such.toml"}, ValueError, "such.toml"),
        ({"controller": "no/such.safetensors"}, FileNotFoundError, "such.safetensors.*; give a "),
        ({"controller": 3}, TypeError, "controller"),
        ({"controller": gaitshift.Controller.shipped(), "experiment": "fast"}, ValueError, "one of them"),
        ({"omega_v": (3.0, 1.0)}, ValueError, "omega_v"),
        ({"omega_v": float("nan")}, ValueError, "omega_v"),
        ({"omega_v": (1.0, 2.0, 3.0)}, ValueError, "omega_v"),
        ({"omega_v": "fast"}, ValueError, "omega_v"),
        ({"omega_v": None}, ValueError, "omega_v"),
        ({"speed": 1.0}, TypeError, "speed"),
    ],
)
def test_what_cannot_be_made_is_refused(options, error, words):
    with pytest.raises(error, match=words):
        gymnasium.make(ID, **options)


def test_a_body_out_of_proportion_is_warned_of():
    with pytest.warns(UserWarning, match="`leg_length_m` is 1"):
        gaitshift.Body({"leg_length_m": 1.0})
    with pytest.warns(UserWarning, match="`leg_length_m` is 1"):
        gaitshift.PassiveBipedEnv(body={"leg_length_m": 1.0})


# It was a ValueError, on which make_vec_env, which tries "rgb_array" and on a TypeError goes without, gave up.
def test_an_unsupported_render_mode_is_refused():
    for make_one in (gaitshift.PassiveBipedEnv, gaitshift.PassiveBipedVectorEnv):
        with pytest.raises(TypeError, match="render"):
            make_one(render_mode="ansi")


def test_stable_baselines3_makes_a_vector_of_them():
    from stable_baselines3.common.env_util import make_vec_env

    envs = make_vec_env(ID, n_envs=4, seed=1)
    observations = envs.reset()
    assert observations.shape == (4, 14)
    observations, rewards, over, infos = envs.step(np.zeros((4, 2), dtype=np.float32))
    assert observations.shape == (4, 14) and rewards.shape == over.shape == (4,) and "x_m" in infos[0]
    envs.close()


def test_episode_statistics_are_recorded():
    env = gymnasium.wrappers.RecordEpisodeStatistics(gymnasium.make(ID, omega_v=0.0))
    env.reset(seed=1)
    total, over = 0.0, False
    while not over:
        _, reward, terminated, truncated, info = env.step(env.action_space.sample())
        total, over = total + reward, terminated or truncated
    assert info["episode"]["r"] == pytest.approx(total)


@pytest.mark.parametrize(
    "action", [np.zeros(3), np.zeros((2, 1)), 0.5, [0.0, np.nan], [np.inf, 0.0], ["a", "b"], None, []]
)
def test_actions_that_are_none_are_refused_and_change_nothing(action):
    env = make()
    env.reset(seed=1)
    before = env.state
    with pytest.raises((ValueError, TypeError)):
        env.step(action)
    np.testing.assert_array_equal(before, env.state)
    env.step(np.zeros(2))


def test_options_of_reset_that_are_unknown_are_refused():
    env = make()
    with pytest.raises(ValueError, match="omgea"):
        env.reset(options={"omgea": 1.0})
    with pytest.raises(ValueError, match="start"):
        env.reset(options={"start": "anywhere"})
    with pytest.raises(ValueError, match="omega_v"):
        env.reset(options={"omega_v": float("inf")})
    with pytest.raises(TypeError, match="omega_v"):
        env.reset(options={"omega_v": "fast"})


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, "one"])
def test_seeds_that_are_none_are_refused(seed):
    with pytest.raises(gymnasium.error.Error, match="seed"):
        make().reset(seed=seed)


@pytest.mark.parametrize("omega_v", [float("nan"), 1e9])
def test_commands_out_of_range_are_refused(omega_v):
    env = make(omega_v=1.0)
    env.reset(seed=1)
    with pytest.raises(ValueError, match="omega_v"):
        env.omega_v = omega_v
    assert env.omega_v == 1.0


def test_the_order_of_calls():
    env = make()
    calls = [lambda: env.step(np.zeros(2)), lambda: setattr(env, "omega_v", 1.0)]
    for call in calls:
        with pytest.raises(gymnasium.error.ResetNeeded):
            call()
    env.reset()
    env.close()
    env.close()
    for call in (*calls, env.reset):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError):
            call()


def test_a_folder_named_like_a_recipe_does_not_hide_the_recipe(tmp_path, monkeypatch):
    # What went wrong: with a folder called `paper` or `fast` in the working directory, which runs of those recipes invite,
    # gymnasium.make failed: "Is a directory".
    monkeypatch.chdir(tmp_path)
    for name in ("paper", "fast"):
        (tmp_path / name).mkdir()
    paper, fast = make(), make(experiment="fast")
    assert paper.task != fast.task
    # A path object is a path, whatever its name.
    (tmp_path / "journal").write_text('[body]\nfriction = 0.5\n')
    assert make(experiment=Path("journal")).body["friction"] == 0.5
    with pytest.raises(ValueError, match="fast"):
        make(experiment=Path("fast"))
