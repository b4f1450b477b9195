"""What the single and the vector environment share."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from gaitshift import _native
from gaitshift._motion import Controller

Command = float | tuple[float, float]


def make_spaces() -> tuple[spaces.Box, spaces.Box]:
    observation = spaces.Box(-np.inf, np.inf, (len(_native.OBSERVATION_NAMES),), np.float64)
    action = spaces.Box(-1.0, 1.0, (2,), np.float32)
    return observation, action


def make_batch(
    count: int,
    seeds: Sequence[int],
    omega_v: Command,
    experiment: str | os.PathLike[str] | None,
    controller: Controller | str | os.PathLike[str] | None,
    body: Mapping[str, Any] | None,
    task: Mapping[str, Any] | None,
    threads: int = 1,
) -> _native.Batch:
    if isinstance(controller, (str, os.PathLike)):
        controller = Controller.load(controller)
    if controller is not None and not isinstance(controller, Controller):
        raise TypeError(f"`controller` must be a gaitshift.Controller or a path, not {type(controller).__name__}")
    for name, value in (("body", body), ("task", task)):
        if value is not None and not isinstance(value, Mapping):
            raise TypeError(f"`{name}` must be a mapping of parameters, not {type(value).__name__}")
    bounds = [omega_v, omega_v] if np.isscalar(omega_v) else list(omega_v)
    if len(bounds) != 2:
        raise ValueError(f"`omega_v` must be a command or a pair (lowest, highest), not {omega_v!r}")
    return _native.Batch(
        count,
        list(seeds),
        [float(bound) for bound in bounds],
        experiment=None if experiment is None else os.fspath(experiment),
        controller=None if controller is None else controller._native,
        body=None if body is None else dict(body),
        task=None if task is None else dict(task),
        threads=threads,
    )


def reset_options(options: Mapping[str, Any] | None) -> tuple[float | None, bool]:
    """The command, and whether the start is the default one."""
    if options is None:
        return None, False
    unknown = sorted(set(options) - {"omega_v", "start"})
    if unknown:
        raise ValueError(f"unknown option {unknown[0]!r} of reset; the options are 'omega_v' and 'start'")
    start = options.get("start", "random")
    if start not in ("default", "random"):
        raise ValueError(f"the option 'start' of reset is {start!r}, but it must be 'default' or 'random'")
    omega_v = options.get("omega_v")
    return None if omega_v is None else float(omega_v), start == "default"
