"""What the single and the vector environment share."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import Any, NamedTuple, cast

import numpy as np
from gymnasium import spaces
from gymnasium.error import Error
from numpy.typing import NDArray

from gaitshift import _native
from gaitshift._motion import Controller, checked_table

Command = float | tuple[float, float]


class HasParameters:
    """What both environments tell of the body and the task they were made with."""

    _batch: _native.Batch

    @property
    def body(self) -> dict[str, Any]:
        """All parameters of the body."""
        return self._batch.body

    @property
    def task(self) -> dict[str, Any]:
        """All parameters of the task."""
        return self._batch.task

    def __getstate__(self) -> dict[str, Any]:
        """For ``pickle`` and ``copy.deepcopy``: the copy goes on to the same bits. A page stays with the original."""
        return {**self.__dict__, "_batch": self._batch.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._batch = _native.Batch.restore(state["_batch"])
        if "url" in state:
            self.__dict__["url"] = None


RENDER_WIDTH_PX = 640


def checked_render_mode(render_mode: str | None, supported: list[str]) -> str | None:
    """The render mode, if it is one. `rgb_array_list` comes from `gymnasium.make`, which wraps the environment for it."""
    if render_mode is None or render_mode in supported:
        return render_mode
    # Gymnasium's make_vec_env and its kin try a render mode and go without one on TypeError, as of an unknown argument.
    raise TypeError(f"render_mode {render_mode!r} is not supported; it must be None or one of {supported}")


def render_metadata(metadata: Mapping[str, Any], batch: _native.Batch) -> dict[str, Any]:
    """The class's metadata with the frame rate at which a film of every step runs in real time."""
    return {**metadata, "render_fps": round(1.0 / batch.task["control_period_s"])}


def make_spaces() -> tuple[spaces.Space[NDArray[np.float64]], spaces.Space[NDArray[np.float32]]]:
    observation = spaces.Box(-np.inf, np.inf, (len(_native.OBSERVATION_NAMES),), np.float64)
    action = spaces.Box(-1.0, 1.0, (2,), np.float32)
    return cast(Any, observation), cast(Any, action)


def make_batch(
    count: int,
    omega_v: Command,
    experiment: str | os.PathLike[str] | None,
    controller: Controller | str | os.PathLike[str] | None,
    body: Mapping[str, Any] | None,
    task: Mapping[str, Any] | None,
    randomization: Mapping[str, Any] | None,
    disturbance: Mapping[str, Any] | None,
    threads: int = 1,
) -> _native.Batch:
    if isinstance(controller, (str, os.PathLike)):
        controller = Controller.load(controller)
    if controller is not None and not isinstance(controller, Controller):
        raise TypeError(f"`controller` must be a gaitshift.Controller or a path, not {type(controller).__name__}")
    tables = {"body": body, "task": task, "randomization": randomization, "disturbance": disturbance}
    try:
        bounds = np.broadcast_to(np.asarray(omega_v, dtype=np.float64), (2,)).tolist()
    except (TypeError, ValueError):
        raise ValueError(f"`omega_v` must be a command or a pair (lowest, highest), not {omega_v!r}") from None
    batch = _native.Batch(
        count,
        bounds,
        experiment=experiment_text(experiment),
        controller=None if controller is None else controller._native,
        **{name: checked_table(name, table) for name, table in tables.items()},
        threads=threads,
    )
    limit_s = batch.task["termination"]["time_limit_s"]
    late = [push["start_s"] for push in (batch.disturbance or {}).get("pushes", []) if push["start_s"] >= limit_s]
    if late:
        starts = ", ".join(f"{start_s:g} s" for start_s in late)
        warnings.warn(
            f"the push at {starts} never comes: episodes last {limit_s:g} s. Give it another `start_s`, or the task another "
            "`time_limit_s`",
            stacklevel=3,
        )
    return batch


def experiment_text(experiment: str | os.PathLike[str] | None) -> str | None:
    """A recipe's name or a path, as the program reads it: a path object is a path, whatever its name."""
    if experiment is None or isinstance(experiment, str):
        return experiment
    return os.path.join(os.curdir, experiment)


def checked_seed(seed: Any) -> int:
    """A seed of the program: what Gymnasium refuses is refused likewise, and what has more than 64 bits too."""
    if not isinstance(seed, (int, np.integer)) or not 0 <= seed < 2**64:
        raise Error(f"the seed is {seed!r}, but it must be a whole number from 0 to 2**64 - 1")
    return int(seed)


State = tuple[NDArray[np.float64], NDArray[np.float64]]


class ResetOptions(NamedTuple):
    """How an episode begins."""

    omega_v: float | None = None
    default_start: bool = False
    state: State | None = None


def reset_options(options: Mapping[str, Any] | None, num_envs: int | None = None) -> ResetOptions:
    """The options of reset; states of several environments have a row for each."""
    if options is None:
        return ResetOptions()
    unknown = sorted(set(options) - {"omega_v", "start", "state"})
    if unknown:
        raise ValueError(f"unknown option {unknown[0]!r} of reset; the options are 'omega_v', 'start' and 'state'")
    start = options.get("start", "random")
    if start not in ("default", "random"):
        raise ValueError(f"the option 'start' of reset is {start!r}, but it must be 'default' or 'random'")
    omega_v = options.get("omega_v")
    if omega_v is not None and not isinstance(omega_v, (int, float, np.number)):
        raise TypeError(f"the option 'omega_v' of reset must be a number, not {omega_v!r}")
    state = options.get("state")
    if state is not None and "start" in options:
        raise ValueError("the options 'start' and 'state' of reset both say where the episode begins; give one of them")
    return ResetOptions(
        None if omega_v is None else float(omega_v),
        start == "default",
        None if state is None else checked_state(state, num_envs),
    )


def checked_state(state: Any, num_envs: int | None) -> State:
    """Positions and velocities, each of shape (11,), or for several environments (num_envs, 11)."""
    shape = (11,) if num_envs is None else (num_envs, 11)
    try:
        # One for all environments may have the shape of one; a number is no state.
        positions, velocities = (np.asarray(x, dtype=np.float64) for x in state)
        if not all(x.shape in ((11,), shape) for x in (positions, velocities)):
            raise ValueError
        positions, velocities = (np.array(np.broadcast_to(x, shape)) for x in (positions, velocities))
    except (TypeError, ValueError):
        raise ValueError(
            f"the option 'state' of reset must be a pair (positions, velocities) of arrays of the shape {shape}, as the "
            "attribute state gives them"
        ) from None
    if not (np.isfinite(positions).all() and np.isfinite(velocities).all()):
        raise ValueError("the option 'state' of reset holds a number that is not finite")
    return positions, velocities
