"""What the tests share: the program they compare with, and an experiment of seconds."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[3]
# A controller that stays as it is, a mean of a network of two layers and its mirror image: what some motions withstand, and how
# far two integrators differ after a foot has left the ground, depends on the controller.
WALKER = REPOSITORY / "controllers/robust/by-policy-gradients-on-hard-pushes.safetensors"


def experiment_script(name):
    """The module of a script below experiments/."""
    path = REPOSITORY / "experiments" / name
    if str(path.parent) not in sys.path:  # where a script finds its other modules
        sys.path.insert(0, str(path.parent))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def tiny():
    """The file of an experiment of seconds."""
    return REPOSITORY / "crates" / "gaitshift" / "tests" / "tiny.toml"


@pytest.fixture(scope="session")
def program():
    """Runs the Rust program that GAITSHIFT_PROGRAM names, or that cargo built last in the dev profile."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
    path = os.environ.get("GAITSHIFT_PROGRAM", str(target / "debug" / "gaitshift"))
    if not Path(path).exists():
        pytest.fail(f"{path} does not exist: run `cargo build -p gaitshift`, or set GAITSHIFT_PROGRAM")

    def run(*arguments, **options):
        command = [path, *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, **options).stdout

    return run
