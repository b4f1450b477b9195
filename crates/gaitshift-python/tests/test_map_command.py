"""Contract: what experiments/hardening/map_command.py writes acts at ω_v as the controller did at the command that is given for
it, piecewise linearly between the points and constantly beyond; what cannot be mapped is refused."""

import sys

import numpy as np
import pytest
from conftest import WALKER, experiment_script
from safetensors.torch import load_file

import gaitshift

POINTS = [(-0.2, 0.1), (0.3, 0.0), (0.31, 0.8), (3.0, 2.0)]


@pytest.fixture
def run(monkeypatch):
    script = experiment_script("hardening/map_command.py")

    def run(controller, out, points):
        words = ["--controller", str(controller), "--out", str(out), "--points=" + ",".join(f"{a}:{b}" for a, b in points)]
        monkeypatch.setattr(sys, "argv", ["map_command.py", *words])
        script.main()
        return gaitshift.Controller.load(out)

    return run


def test_it_acts_as_at_the_command_that_is_given(run, tmp_path):
    before, after = gaitshift.Controller.load(WALKER), run(WALKER, tmp_path / "one.safetensors", POINTS)
    first = load_file(tmp_path / "one.safetensors")["layers.0.weight"]
    half = len(first) // 2
    mirror = [0, 1, 2, 5, 6, 3, 4, 9, 10, 7, 8, 12, 11, 13]
    assert (first[half:] == first[:half, mirror]).all()  # still a mean of a network and its mirror image
    again = run(tmp_path / "one.safetensors", tmp_path / "two.safetensors", [(0.0, -0.5), (1.0, 3.5)])
    for row in np.random.default_rng(1).normal(size=(200, 14)):
        commands = np.array([-1.0, -0.2, 0.1, 0.3, 0.305, 0.31, 1.7, 3.0, 4.0])
        for command, heard in zip(commands, np.interp(commands, *np.transpose(POINTS))):
            assert after([*row[:13], command]) == pytest.approx(before([*row[:13], heard]), abs=1e-3)
        assert again([*row[:13], 0.25]) == pytest.approx(after([*row[:13], 0.5]), abs=1e-4)


def test_what_cannot_be_mapped_is_refused(run, tmp_path, capsys):
    out = tmp_path / "one.safetensors"
    with pytest.raises(SystemExit, match="no such file"):
        run(tmp_path / "none.safetensors", out, POINTS)
    for points in (POINTS[:1], [(1.0, 0.0), (0.0, 1.0)]):
        with pytest.raises(SystemExit):
            run(WALKER, out, points)
        assert "with rising" in capsys.readouterr().err
    assert not out.exists()
