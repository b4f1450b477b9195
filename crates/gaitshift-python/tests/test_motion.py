"""Contract: controllers act and record from Python to the same bits as the program, disturbed motions too; recordings go
through CSV, NPZ and pandas without losing a bit; the analysis is the program's; what is no controller or recording is
refused."""

import copy
import json
import pickle

import numpy as np
import pytest

import gaitshift


@pytest.fixture(scope="module")
def controller():
    return gaitshift.Controller.shipped()


@pytest.fixture(scope="module")
def recording(controller):
    return controller.record(3.0, 6.0)


@pytest.mark.parametrize(("name", "own_terms"), [("shipped", []), ("robust", ["reward_going_on"])])
def test_controllers_that_come_with_the_package_have_names(tmp_path, monkeypatch, program, name, own_terms):
    (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path)
    ours = gaitshift.Controller.load(name)
    program("evaluate", "--controller", name, "--omega-v", 0, "--duration-s", 1, "--out", tmp_path / "out")
    theirs = gaitshift.Recording.read_csv(tmp_path / "out" / "omega_v_0.csv")
    assert_same(ours.record(0.0, 1.0), theirs, own_terms)


def assert_same(one, other, own_terms=()):
    assert one.metadata == other.metadata
    assert list(one) == list(other) == [*gaitshift.COLUMNS, *gaitshift.DETAILS, *own_terms]
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


@pytest.mark.parametrize("seed", [None, 3])
def test_it_records_as_the_program_does(program, tmp_path, controller, seed):
    drawn = [] if seed is None else ["--seed", seed]
    program("evaluate", "--omega-v", 1.5, "--duration-s", 3, "--out", tmp_path, *drawn)
    theirs = gaitshift.Recording.read_csv(tmp_path / "omega_v_1.5.csv")
    assert_same(controller.record(1.5, 3.0, seed=seed), theirs)


# What went wrong: only undisturbed motions could be recorded from Python.
def test_it_records_disturbed_motions_as_the_program_does(program, tmp_path, controller):
    options = ["--push", "80:-20@1.5,0.2", "--push", "60@1+0.25", "--slope", "0.03rad@1", "--step-up", "0.01@2"]
    options += ["--noise", "theta=0.01", "--latency", "0.004", "--weak", "right=0.9"]
    options += ["--set", "task.reward.omega_e=0.02", "--set", "friction=0.8"]
    program("evaluate", "--omega-v", 1.5, "--duration-s", 4, "--seed", 6, "--out", tmp_path, *options)
    theirs = gaitshift.Recording.read_csv(tmp_path / "omega_v_1.5.csv")
    ours = controller.record(
        1.5,
        4.0,
        seed=6,
        body={"friction": 0.8},
        task={"reward": {"omega_e": 0.02}},
        disturbance={
            "pushes": [
                {"forward_n": 80, "up_n": -20, "start_s": 1.5, "duration_s": 0.2},
                {"forward_n": 60, "start_s": 1, "phase": 0.25},
            ],
            "terrain": {"slope_rad": 0.03, "slope_from_m": 1, "steps": [{"height_m": 0.01, "at_m": 2}]},
            "noise": {"theta_rad": 0.01},
            "latency_s": 0.004,
            "actuator_factor": [0.9, 1.0],
        },
    )
    assert_same(ours, theirs)
    # Both pushes came: there was a stride for the one at a phase.
    assert len(ours.metadata["disturbance"]["pushes"]) == 2 and ours.metadata["ground"] and ours.rows > 200


def test_a_push_that_never_came_is_warned_of(controller):
    def record(*pushes):
        return controller.record(1.5, 2.0, disturbance={"pushes": [{"forward_n": 10, **push} for push in pushes]})

    with pytest.warns(UserWarning, match="1 of 2 pushes came"):
        record({"start_s": 1}, {"start_s": 3})
    with pytest.warns(UserWarning, match="0 of 1 pushes came"):
        record({"start_s": 1.9, "phase": 0.9})
    record({"start_s": 1})


def test_a_disturbance_that_changes_nothing_is_none(controller):
    assert_same(controller.record(1.5, 1.0, disturbance={}, task={}), controller.record(1.5, 1.0))


def test_a_changing_command_and_its_analysis(program, tmp_path, controller):
    theirs = json.loads(
        program("transition", "--start-s", 4, "--after-s", 4, "--json", "--out", tmp_path).decode()
    )
    ours = controller.record([(4.0, 0.0), (4.4, 3.0)], 8.4)
    assert_same(ours, gaitshift.Recording.read_csv(tmp_path / "recording.csv"))
    changes, seed = theirs.pop("changes"), theirs.pop("seed")
    assert seed is None
    assert ours.transition_summary(4.0, 4.4) == theirs
    assert ours.changes_of_gait() == changes and len(changes) == 1
    assert changes[0]["gait_after"] == "running"
    assert controller.record(0.0, 2.0).changes_of_gait() == []
    # The program analyses the file as it analysed the motion.
    [analysed] = json.loads(program("analyse", "--transition", "--json", tmp_path / "recording.csv"))["transitions"]
    assert analysed["ramp_start_s"] == 4.0 and analysed["ramp_end_s"] == 4.4
    assert {key: analysed[key] for key in theirs} == theirs


def test_the_analysis_of_a_steady_motion(program, tmp_path, recording):
    recording.write_csv(tmp_path / "motion.csv")
    [row] = json.loads(program("analyse", "--json", tmp_path / "motion.csv"))["rows"]
    summary = recording.summary()
    assert {key: row[key] for key in summary} == summary
    assert row["omega_v"] == 3.0
    assert recording.summary(settling_time_s=1.0)["window_start_s"] == 1.0


def test_csv_npz_and_pandas_hold_the_same_bits(program, tmp_path, recording):
    csv, npz = tmp_path / "motion.csv", tmp_path / "motion.npz"
    recording.write_csv(csv)
    assert_same(gaitshift.Recording.read_csv(csv), recording)
    recording.write_npz(npz)
    assert_same(gaitshift.Recording.read_npz(npz), recording)
    program("export", "npz", csv, "--out", tmp_path / "theirs.npz")
    assert (tmp_path / "theirs.npz").read_bytes() == npz.read_bytes()
    assert program("export", "csv", csv) == csv.read_bytes()
    with np.load(npz) as arrays:
        assert sorted(arrays.files) == sorted([*gaitshift.COLUMNS, *gaitshift.DETAILS, "metadata"])
        assert arrays["x_m"].dtype == np.float64
    frame = recording.to_pandas()
    assert frame.index.name == "time_s" and frame.shape == (recording.rows, len([*recording]) - 1)
    np.testing.assert_array_equal(frame["x_m"].to_numpy(), recording["x_m"])
    assert frame.attrs["control_period_s"] == recording.metadata["control_period_s"]


def test_a_recording_from_arrays(recording):
    columns = {name: recording[name] for name in recording}
    assert_same(gaitshift.Recording(recording.metadata, columns), recording)
    for change, words in [
        ({"x_m": None}, "x_m"),
        ({"speed": columns["x_m"]}, "speed"),
        ({"x_m": columns["x_m"][:-1]}, "x_m"),
        ({"x_m": np.full(recording.rows, np.nan)}, "x_m"),
        ({"time_s": columns["time_s"][::-1]}, "row 1"),
        ({"x_m": np.zeros((2, 2))}, "x_m"),
        ({"com_z_m": columns["com_z_m"][:-1]}, "com_z_m"),
        ({"com_z_m": np.full(recording.rows, np.inf)}, "com_z_m"),
    ]:
        changed = {name: values for name, values in {**columns, **change}.items() if values is not None}
        with pytest.raises(ValueError, match=words):
            gaitshift.Recording(recording.metadata, changed)
    # Another simulator may not know the details.
    plain = gaitshift.Recording(recording.metadata, {name: columns[name] for name in gaitshift.COLUMNS})
    assert list(plain) == list(gaitshift.COLUMNS) and plain.summary()["energy_recovery"] is None
    with pytest.raises(ValueError, match="metadata"):
        gaitshift.Recording({"seed": 1}, columns)
    # It named an attribute that there is none of.
    with pytest.raises(KeyError, match=r"`speed`; list\(recording\) gives the names"):
        recording["speed"]


def test_the_controller_acts(controller):
    one = controller(np.zeros(14))
    many = controller(np.zeros((3, 14)))
    assert one.shape == (2,) and many.shape == (3, 2) and one.dtype == np.float32
    np.testing.assert_array_equal(many, np.tile(one, (3, 1)))
    assert np.all(np.abs(controller(np.full(14, 1e6))) <= 1.0)
    for observation in (np.zeros(13), np.zeros((2, 3, 14)), np.full(14, np.nan), 0.0):
        with pytest.raises(ValueError):
            controller(observation)


def test_controllers_and_recordings_can_be_copied_and_pickled(controller, recording):
    observation = np.linspace(-1, 1, 14)
    for copied in (copy.deepcopy(controller), pickle.loads(pickle.dumps(controller))):
        assert copied.name == controller.name and copied.body == controller.body
        np.testing.assert_array_equal(copied(observation), controller(observation))
    assert_same(pickle.loads(pickle.dumps(recording)), recording)


def test_bad_motions_are_refused(controller):
    for arguments in ([], 1.0), ([(0.0, 1.0), (0.0, 2.0)], 1.0), (1e9, 1.0), (float("nan"), 1.0), (1.0, -1.0), (1.0, 1e9):
        with pytest.raises(ValueError):
            controller.record(*arguments)
    with pytest.raises(ValueError, match="'run', but it must be a number, or points"):
        controller.record("run", 1.0)
    with pytest.raises(ValueError, match="frction"):
        controller.record(1.0, 1.0, body={"frction": 0.5})
    for wrong, error, words in [
        ({"task": {"reward": {"omga_e": 0.5}}}, ValueError, "did you mean `omega_e`"),
        ({"task": {"control_period_s": 0.0}}, ValueError, "control_period_s"),
        ({"disturbance": {"latencey_s": 1}}, ValueError, "did you mean `latency_s`"),
        ({"disturbance": {"terrain": {"slope_rad": 3}}}, ValueError, r"terrain\.slope_rad"),
        ({"disturbance": "slope.toml"}, TypeError, "`disturbance` must be a mapping"),
        ({"body": 3}, TypeError, "`body` must be a mapping"),
    ]:
        with pytest.raises(error, match=words):
            controller.record(1.0, 1.0, **wrong)
    for seed in (-1, 2**64, 1.5, True):
        with pytest.raises(ValueError, match=r"`seed` is .* whole number"):
            controller.record(1.0, 1.0, seed=seed)


def test_files_that_are_none_are_refused(tmp_path, recording):
    damaged = tmp_path / "damaged"
    damaged.write_bytes(b"\x10\0\0\0\0\0\0\0garbage")
    recording.write_csv(tmp_path / "cut.csv")
    cut = (tmp_path / "cut.csv").read_text()
    (tmp_path / "cut.csv").write_text(cut[: len(cut) // 2])
    with pytest.raises(FileNotFoundError, match="missing"):
        gaitshift.Controller.load(tmp_path / "missing")
    with pytest.raises(FileNotFoundError, match="missing"):
        gaitshift.Recording.read_csv(tmp_path / "missing")
    with pytest.raises(ValueError, match="damaged"):
        gaitshift.Controller.load(damaged)
    with pytest.raises(ValueError, match="damaged"):
        gaitshift.Recording.read_csv(damaged)
    with pytest.raises(ValueError, match=r"cut\.csv"):
        gaitshift.Recording.read_csv(tmp_path / "cut.csv")
    with pytest.raises(OSError):
        recording.write_csv(tmp_path / "no" / "such" / "folder.csv")


def test_the_body():
    body = gaitshift.Body({"friction": 0.5})
    assert body.parameters["friction"] == 0.5
    standing = np.zeros(11)
    standing[1] = body.lowest_hip_height(standing)
    assert standing[1] == pytest.approx(body.parameters["leg_length_m"], abs=1e-3)
    falling = body.accelerations(standing + np.eye(11)[1], np.zeros(11), np.zeros(2))
    assert falling[1] == -body.parameters["gravity_m_per_s2"]
    for arguments in (
        (np.zeros(10), np.zeros(11), np.zeros(2)),
        (np.zeros(11), np.full(11, np.nan), np.zeros(2)),
        (np.zeros(11), np.zeros(11), np.zeros((2, 1))),
    ):
        with pytest.raises(ValueError):
            body.accelerations(*arguments)
    with pytest.raises(ValueError, match="frction"):
        gaitshift.Body({"frction": 0.5})
