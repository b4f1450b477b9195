"""Contract: importing is quick; every public name is documented and has types; examples and
outside learners run."""

import ast
import importlib.metadata
import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import gaitshift

PACKAGE = Path(gaitshift.__file__).parent


def test_importing_is_quick():
    # Processor time of the importing thread, NumPy and Gymnasium included: what else the machine does is left out.
    code = "import time; start = time.thread_time(); import gaitshift; print(time.thread_time() - start)"
    seconds = min(
        float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout)
        for _ in range(10)
    )
    print(f"\nimport gaitshift: {seconds:.3f} s of processor time, least of 10")
    assert seconds < 0.3


def test_gymnasium_finds_it_by_the_modules_name():
    code = "import gymnasium; gymnasium.make('gaitshift:gaitshift/PassiveBiped-v0').reset(seed=1)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_version_is_the_crates():
    assert importlib.metadata.version("gaitshift") == gaitshift.__version__


def test_everything_public_is_documented():
    for name in gaitshift.__all__:
        value = getattr(gaitshift, name)
        if callable(value):
            assert value.__doc__, name
        if inspect.isclass(value):
            for member, own in vars(value).items():
                if not member.startswith("_") and (callable(own) or hasattr(own, "__get__")):
                    assert inspect.getdoc(getattr(value, member)), f"{name}.{member}"


def test_help_says_of_the_compiled_names_what_the_stubs_say():
    tree = ast.parse((PACKAGE / "_native.pyi").read_text())
    by_name = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    documented = 0
    for name in ("Body", "reward_terms"):
        compiled = getattr(gaitshift, name)
        assert inspect.getdoc(compiled) == ast.get_docstring(by_name[name]), name
        for node in by_name[name].body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                member = f"{name}.{node.name}"
                assert inspect.getdoc(getattr(compiled, node.name)) == ast.get_docstring(node), member
                documented += 1
    assert documented >= 7


def test_the_stubs_name_what_the_compiled_module_has():
    from gaitshift import _native

    tree = ast.parse((PACKAGE / "_native.pyi").read_text())
    assert (PACKAGE / "py.typed").exists()
    stubs = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            stubs[node.name] = {f.name for f in node.body if isinstance(f, ast.FunctionDef)}
        elif isinstance(node, ast.FunctionDef):
            stubs[node.name] = set()
        elif isinstance(node, ast.AnnAssign):
            stubs[node.target.id] = set()
    stubs.pop("AdvanceReport")
    names = {name for name in dir(_native) if not name.startswith("__") or name == "__version__"}
    assert set(stubs) == names
    for name, members in stubs.items():
        if members:
            public = {member for member in vars(getattr(_native, name)) if not member.startswith("__")}
            assert public == {member for member in members if not member.startswith("__")}, name


def test_stable_baselines3_trains_on_it():
    import torch
    from stable_baselines3 import SAC
    from stable_baselines3.common.env_checker import check_env

    env = gymnasium.make("gaitshift/PassiveBiped-v0", omega_v=0.5)
    check_env(env.unwrapped)
    # Networks this small are slower on several threads.
    torch.set_num_threads(1)
    model = SAC("MlpPolicy", env, seed=1, learning_starts=500, policy_kwargs={"net_arch": [32, 32]}, train_freq=8)
    before = [parameter.detach().clone() for parameter in model.actor.parameters()]
    model.learn(3000)
    after = list(model.actor.parameters())
    assert all(bool(p.isfinite().all()) for p in after)
    assert any(bool((p != q).any()) for p, q in zip(before, after))
    assert model.num_timesteps == 3000
    lengths = [episode["l"] for episode in model.ep_info_buffer]
    assert len(lengths) > 3 and np.mean(lengths) > 10


def test_the_example_runs(tmp_path):
    example = Path(__file__).parents[1] / "examples" / "train_and_compare.py"
    command = [sys.executable, example, "--steps", "600", "--out", tmp_path]
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path, env=one_thread)
    assert (tmp_path / "comparison.png").stat().st_size > 10_000


def test_the_example_of_the_learner_alone_runs(tmp_path):
    example = Path(__file__).parents[1] / "examples" / "pendulum.py"
    command = [sys.executable, example, "--steps", "300", "--seeds", "1"]
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}
    said = subprocess.run(command, check=True, capture_output=True, cwd=tmp_path, env=one_thread, text=True).stdout
    assert "time, theirs by ours" in said


def test_the_comparison_on_the_biped_runs_and_goes_on_where_it_was(tmp_path):
    example = Path(__file__).parents[1] / "examples" / "biped.py"
    command = [sys.executable, example, "--steps", "300", "--learning-starts", "200", "--out", tmp_path, "--seeds"]
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}

    def run(*seeds):
        subprocess.run([*command, *seeds], check=True, capture_output=True, cwd=tmp_path, env=one_thread)
        return json.loads((tmp_path / "biped.json").read_text())

    first = run("1")
    assert [row["learner"] for row in first] == ["gaitshift.SAC", "Stable-Baselines3", "gaitshift train"]
    assert all(row["seconds"] > 0 and 0 < row["at 3"][0] <= 10.01 for row in first)
    assert run("1", "2")[:3] == first


@pytest.mark.parametrize("call", ["accelerations", "advance"])
def test_the_compiled_classes_refuse_what_is_no_array(call):
    with pytest.raises(TypeError):
        getattr(gaitshift.Body(), call)("a", "b", "c", 1)


@pytest.mark.parametrize("steps", [-5, 2**40])
def test_a_number_of_steps_out_of_range_is_said_to_be(steps):
    # What went wrong: a negative one was an OverflowError that named nothing.
    with pytest.raises(ValueError, match=f"`steps` is {steps}, but it must be from 0 to"):
        gaitshift.Body().advance(np.zeros(11), np.zeros(11), np.zeros(2), steps)
