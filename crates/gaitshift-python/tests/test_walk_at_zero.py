"""Contract: what experiments/hardening/walk_at_zero.py adds to a controller's commands is the function that it says, in each
leg its mirror image, at ω_v up to 0.2 and speeds between `--faster-than` and `--slower-than` alone; the file that it writes
acts so, and can be shaped again. Falls are counted, of hard states and others so that they stand for all. A search that goes
on equals one that was not stopped."""

import sys

import numpy as np
import pytest
from conftest import REPOSITORY, experiment_script

import gaitshift

WALKER = REPOSITORY / "controllers/robust/walking-faster.safetensors"  # it walks at 0 from all starts
RIGHT, LEFT = slice(7, 9), slice(9, 11)  # angle and rate of each leg


@pytest.fixture(scope="module")
def script():
    return experiment_script("hardening/walk_at_zero.py")


@pytest.fixture
def values(script):
    return np.random.default_rng(1).normal(scale=0.2, size=script.NUMBERS)


@pytest.fixture
def observations():
    drawn = np.random.default_rng(2).normal(size=(400, 14))
    drawn[:, RIGHT], drawn[:, LEFT] = 0.3 * drawn[:, RIGHT], 0.3 * drawn[:, LEFT]
    drawn[:, 8] += np.where(drawn[:, 8] > drawn[:, 10], 3, -3)  # no leg just turns round, where both functions are partly on
    drawn[:, 13] = 0
    return drawn


def before_tanh(actor, observations):
    return np.arctanh(actor.act(observations).astype(float).clip(-0.999, 0.999))


def mirrored(observations):
    return observations[:, [0, 1, 2, 5, 6, 3, 4, 9, 10, 7, 8, 12, 11, 13]]


def added_to_right_leg(script, values, observations, scale):
    angle, rate = observations[:, 7] - observations[:, 9], observations[:, 8] - observations[:, 10]
    forward, back = (np.interp(angle, script.KNOTS_RAD, part) for part in np.split(values[: -script.OBSERVED], 2))
    return np.where(rate > 0, forward, back) + (observations * scale)[:, : script.OBSERVED] @ values[-script.OBSERVED :]


def test_what_is_added_is_a_function_of_the_legs_and_a_linear_one(script, values, observations):
    shaped, actor = script.Shaped(WALKER, values), script.Actor(WALKER)
    scale = actor.scale.numpy()
    added = np.stack([added_to_right_leg(script, values, rows, scale) for rows in (observations, mirrored(observations))], 1)
    expected = np.tanh(before_tanh(actor, observations) + added)
    seen = np.abs(actor.act(observations)) < 0.99  # a tanh near 1 does not tell what went into it
    assert seen.sum() > 50
    assert shaped.act(observations)[seen] == pytest.approx(expected[seen], abs=1e-3)


def test_nothing_is_added_at_other_commands_and_beyond_a_speed(script, values, observations):
    shaped, actor = script.Shaped(WALKER, values, slower_than=0.3), script.Actor(WALKER)
    slow, quick = observations.copy(), observations.copy()
    slow[:, 0], quick[:, 0] = 0.1, 1.5
    assert np.abs(shaped.act(slow) - actor.act(slow)).max() > 0.1
    assert np.abs(shaped.act(quick) - actor.act(quick)).max() < 1e-4
    fast = script.Shaped(WALKER, values, faster_than=1.4)
    assert np.abs(fast.act(quick) - actor.act(quick)).max() > 0.1
    assert np.abs(fast.act(slow) - actor.act(slow)).max() < 1e-4
    for omega_v in (-0.5, 0.5, 3.0):
        slow[:, 13] = omega_v
        assert np.abs(shaped.act(slow) - actor.act(slow)).max() < 1e-4


def test_the_file_acts_so_and_can_be_shaped_again(script, values, observations, tmp_path):
    path = tmp_path / "one.safetensors"
    shaped = script.Shaped(WALKER, values)
    shaped.save(path, seed=4)
    controller = gaitshift.Controller.load(path)
    assert controller.provenance["seed"] == 4
    assert np.array([controller(row) for row in observations]) == pytest.approx(shaped.act(observations), abs=1e-4)
    again = script.Shaped(path, np.zeros(script.NUMBERS))
    assert again.act(observations) == pytest.approx(shaped.act(observations), abs=1e-4)


@pytest.fixture
def short(script, monkeypatch):
    monkeypatch.setattr(script, "STARTS", 3)
    monkeypatch.setattr(script, "LONG_S", 4.0)
    monkeypatch.setattr(script, "SETTLED_S", 2.0)
    monkeypatch.setattr(script, "UP", 20)
    monkeypatch.setattr(script, "AFTER_A_RUN", 0.0)  # there is no time to settle after one


def test_pushes_and_steps_are_counted_that_make_it_fall(script, tmp_path):
    task = script.Task(script.parsed(["--controller", str(WALKER), "--out", str(tmp_path)]))
    actor = script.Actor(WALKER)
    starts = np.concatenate([task.starts([motion], np.random.default_rng(1)) for motion in task.walks(actor, 5)[:3]])

    def share(case, starts=starts):
        return task.fell(actor, starts, case).mean()

    assert [share(script.Case(0.0, forward_n)) for forward_n in (0.0, 900.0, -1500.0)] == [0, 1, 1]
    one_by_one = [share(script.Case(0.0, 360.0), starts[[row]]) for row in range(len(starts))]
    assert 0 < np.mean(one_by_one) < 1
    assert share(script.Case(0.0, 360.0)) == pytest.approx(np.mean(one_by_one))
    starts[:, 0] = script.STEP_AT_M - 0.6
    assert [share(script.Case(0.0, step_up_m=up_m)) for up_m in (0.0005, 0.3)] == [0, 1]


def test_hard_states_are_those_that_fall_and_make_an_estimate_for_all(script, short, monkeypatch, tmp_path):
    monkeypatch.setattr(script, "UP", 200)
    monkeypatch.setattr(script, "LAST", 120)
    flags = ["--pushes=-360:1", "--steps", "0.04:1", "--slower-than", "0.3", "--hard", "80"]
    task = script.Task(script.parsed(["--controller", str(WALKER), "--out", str(tmp_path), *flags]))
    task.found = [task.find(case, 80, 1) for case, _ in task.cases]
    actor = script.Actor(WALKER)
    for (case, _), (hard, others) in zip(task.cases, task.found):
        assert len(hard) > 0 and len(hard) + len(others) == 80
        assert task.fell(actor, hard, case).all() and not task.fell(actor, others, case).any()
    hard, others = task.found[1]
    ahead = script.STEP_AT_M - np.concatenate([hard, others])[:, 0]
    assert script.AHEAD_M[0] < ahead.min() < ahead.max() < script.AHEAD_M[1]
    for index, (hard, _) in enumerate(task.found):
        assert task.share(actor, index, None, np.random.default_rng(1)) == pytest.approx(len(hard) / 80)


def test_motions_with_a_latency_count_those_that_fall(script, monkeypatch, tmp_path):
    monkeypatch.setattr(script, "LATE", 2)
    monkeypatch.setattr(script, "LATE_S", 5.0)
    task = script.Task(script.parsed(["--controller", str(WALKER), "--out", str(tmp_path), "--latency", "0.02:1"]))
    assert [task.falls_late(script.Actor(WALKER), late_s, 1) for late_s in (0.0, 0.2)] == [0, 1]
    assert "falls 0.02 s late" in task.cost(np.zeros(script.NUMBERS), 1)


def test_motions_of_a_raised_body_count_those_that_fall(script, monkeypatch, tmp_path):
    monkeypatch.setattr(script, "RAISED", 2)
    monkeypatch.setattr(script, "RAISED_S", 5.0)
    task = script.Task(script.parsed(["--controller", str(WALKER), "--out", str(tmp_path), "--raised", "0.3:1"]))
    assert [task.falls_raised(script.Actor(WALKER), height_m, 1) for height_m in (-0.05, 0.3)] == [0, 1]
    assert "falls raised by 0.3 m" in task.cost(np.zeros(script.NUMBERS), 1)


def test_a_search_begins_with_the_numbers_of_another(script, short, monkeypatch, tmp_path):
    for out, more in (("a", []), ("b", ["--begin-with", str(tmp_path / "a"), "--deviation", "1e-9"])):
        flags = ["--controller", str(WALKER), "--out", str(tmp_path / out), "--generations", "1", "--candidates", "4"]
        monkeypatch.setattr(sys, "argv", ["walk_at_zero.py", *flags, *more])
        script.main()
    first, second = (gaitshift.Controller.load(tmp_path / out / "1.safetensors") for out in "ab")
    row = np.linspace(-0.3, 0.3, 14)
    row[13] = 0
    assert second(row) == pytest.approx(first(row), abs=1e-5)
    assert first(row) != pytest.approx(gaitshift.Controller.load(WALKER)(row), abs=1e-5)
    with pytest.raises(SystemExit):
        script.parsed(["--controller", str(WALKER), "--out", str(tmp_path), "--hard", "80"])


def test_a_search_that_goes_on_equals_one_that_was_not_stopped(script, short, monkeypatch, tmp_path):
    def searched(out, *generations):
        for count in generations:
            flags = ["--controller", str(WALKER), "--out", str(out), "--generations", str(count), "--candidates", "4"]
            monkeypatch.setattr(sys, "argv", ["walk_at_zero.py", *flags])
            script.main()
        table = np.genfromtxt(out / "log.csv", delimiter=",", names=True)
        return table["cost"], gaitshift.Controller.load(out / "3.safetensors")

    cost, whole = searched(tmp_path / "a", 3)
    np.random.seed(0)  # what goes on does not depend on what else drew numbers
    cost_in_parts, parts = searched(tmp_path / "b", 1, 3)
    assert len(cost) == 3 and cost.tolist() == cost_in_parts.tolist()
    row = np.linspace(-0.3, 0.3, 14)
    row[13] = 0
    assert whole(row).tolist() == parts(row).tolist()
    with pytest.raises(SystemExit, match="another --candidates"):
        monkeypatch.setattr(sys, "argv", [*sys.argv[:-1], "5"])
        script.main()


def test_a_controller_that_cannot_be_shaped_is_refused_at_once(script, monkeypatch, tmp_path):
    # What went wrong: it was found out in a process of the pool, which ended without a word, and the search waited for it.
    monkeypatch.setattr(sys, "argv", ["walk_at_zero.py", "--controller", str(tmp_path / "none"), "--out", str(tmp_path)])
    with pytest.raises(SystemExit, match="no such file"):
        script.main()


def test_what_does_not_walk_costs_more_than_any_walk(script, monkeypatch, tmp_path):
    monkeypatch.setattr(script, "STARTS", 3)

    def cost(*flags):
        task = script.Task(script.parsed(["--controller", str(WALKER), "--out", str(tmp_path), *flags]))
        return lambda values: task.cost(values, 1)["cost"]

    walks, limp = np.zeros(script.NUMBERS), np.full(script.NUMBERS, -5.0)
    too_fast = cost("--speed", "0.2")(walks)
    assert cost()(walks) < 2 < too_fast < script.NO_WALK < cost()(limp)
