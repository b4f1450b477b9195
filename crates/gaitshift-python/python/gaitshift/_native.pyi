"""The compiled part of the package. Users meet `Body` and `reward_terms`; the rest is wrapped."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]

COLUMNS: list[str]
"""Names of a recording's columns, units in the name."""
DETAILS: list[str]
"""Names of the columns that a recording may have beside these."""
INFO_NAMES: list[str]
"""Names of the numbers in an environment's info."""
OBSERVATION_NAMES: list[str]
"""Names of the 14 observations, units in the name."""
OBSERVATION_SCALE: list[float]
"""Factors that bring the 14 observations to order one."""
__version__: str

class AdvanceReport(TypedDict):
    diverged: bool
    actuator_n: list[float]
    normal_n: list[float]
    tangential_n: list[float]
    account: dict[str, Any]

class Body:
    """The mechanism alone: no task, no controller.

    `parameters` are those that differ from the default body's (keys of `[body]`); ValueError for an unknown one or a
    value out of range. `terrain` is the ground where it is not flat, with the keys of `[terrain]` of a disturbance:
    slope_rad, slope_from_m, steps, uneven.

    Positions and velocities are arrays of shape (11,), float64: x, z, theta, then phi, h, d, w of the right leg and of
    the left one (m, rad, m/s, rad/s).
    """

    def __init__(
        self, parameters: Mapping[str, Any] | None = None, terrain: Mapping[str, Any] | None = None
    ) -> None: ...
    @property
    def parameters(self) -> dict[str, Any]:
        """All parameters."""
    def mjcf(
        self,
        task: Mapping[str, Any] | None = None,
        *,
        actuator_factor: Sequence[float] = (1.0, 1.0),
        latency_s: float = 0.0,
    ) -> str:
        """The body as MJCF, the model format of MuJoCo; `qpos` and `qvel` are positions and velocities. `task` holds
        parameters that differ from the default task, whose default start and control period the file has as the keyframe
        `start` and the numeric `control_period_s`. The body of a controller: `Body(controller.body).mjcf(controller.task)`.
        `actuator_factor` is the share of its force that the right and the left actuator still have, `latency_s` the delay
        from command to force, in s. ValueError for an unknown key or a value out of range.
        """
    def accelerations(self, positions: _Floats, velocities: _Floats, actuator_n: _Floats) -> _Floats:
        """Accelerations of the 11 coordinates (m/s², rad/s²) under the actuators' forces, shape (2,), in N."""
    def advance(
        self, positions: _Floats, velocities: _Floats, command: _Floats, steps: int
    ) -> tuple[_Floats, _Floats, AdvanceReport]:
        """Integrates `steps` steps of `time_step_s` under a constant command, shape (2,), limited to [-1, 1].

        Returns positions, velocities and a report: means of the forces in N, right and left, and the account of
        works and losses in J. The lock of the interpreter is not held.
        """
    def energy(self, positions: _Floats, velocities: _Floats) -> dict[str, float]:
        """Energies in J: kinetic, gravitational, hip_springs, leg_springs, elastic, contact, stops, total."""
    def foot_contact(self, positions: _Floats, velocities: _Floats) -> list[dict[str, float]]:
        """What the ground does to the right and the left foot: tangential_n, normal_n (N), moment_nm about the hip axis
        (N m), elastic_j (J), normal_loss_w and friction_loss_w (W)."""
    def ground_height(self, x: float) -> float:
        """Height of the ground in m at `x`."""
    def lowest_hip_height(self, positions: _Floats) -> float:
        """Height of the hip axis in m at which the lower sole just touches the ground."""

def program(command_line: list[str]) -> int:
    """Runs the program with a command line, its own name first, and gives its exit code."""

def reward_terms(
    task: Mapping[str, Any],
    positions: _Floats,
    velocities: _Floats,
    omega_v: float,
    *,
    energy_change_j: float,
    friction_loss_j: float,
    positive_work_j: float,
) -> dict[str, float]:
    """The weighted terms of the reward of a period that ended in a state, before the common factor.

    `task` holds parameters that differ from the default task; `energy_change_j` is the change of the body's total
    energy over the period, `friction_loss_j` what friction took, `positive_work_j` the actuators' positive work. Terms of
    one's own (`task["reward"]["extra"]`) are not among them.
    """

class Recording:
    def __init__(self, metadata: Mapping[str, Any], columns: Mapping[str, _Floats]) -> None: ...
    @staticmethod
    def read_csv(path: str) -> Recording: ...
    def write_csv(self, path: str) -> None: ...
    def write_npz(self, path: str) -> None: ...
    @property
    def metadata(self) -> dict[str, Any]: ...
    @property
    def columns(self) -> list[str]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> _Floats: ...
    def summary(self, settling_time_s: float = 5.0) -> dict[str, Any]: ...
    def transition_summary(self, ramp_start_s: float, ramp_end_s: float) -> dict[str, Any]: ...
    def changes_of_gait(self) -> list[dict[str, Any]]: ...

class Controller:
    @staticmethod
    def shipped() -> Controller: ...
    @staticmethod
    def load(path: str) -> Controller: ...
    @staticmethod
    def from_bytes(bytes: bytes, name: str) -> Controller: ...
    def to_bytes(self) -> bytes: ...
    @property
    def name(self) -> str: ...
    @property
    def body(self) -> dict[str, Any]: ...
    @property
    def task(self) -> dict[str, Any]: ...
    @property
    def provenance(self) -> dict[str, Any]: ...
    @property
    def control_period_s(self) -> float: ...
    def act(self, observations: _Floats) -> NDArray[np.float32]: ...
    def onnx(self) -> bytes: ...
    def write_onnx(self, path: str) -> None: ...
    def record(
        self,
        profile: Sequence[tuple[float, float]],
        duration_s: float,
        seed: int | None = None,
        body: Mapping[str, Any] | None = None,
        task: Mapping[str, Any] | None = None,
        disturbance: Mapping[str, Any] | None = None,
    ) -> Recording: ...

def train(
    experiment: str,
    callback: Callable[..., object],
    *,
    set: Sequence[str],
    seed: int | None,
    out: str | None,
    threads: int | None,
    steps: int | None,
    stop_when_accepted: bool,
) -> str:
    """Trains and gives the run's folder. `set` holds KEY=VALUE. `callback(what, value, evaluation)` is called with
    "progress", "evaluation" (value: a dict) or "note" (value: a text)."""

def resume(folder: str, callback: Callable[..., object], *, threads: int | None, steps: int | None) -> None: ...
def run_config(folder: str) -> dict[str, Any]: ...
def motion_names() -> list[str]:
    """Names of what an evaluation tells of each of its steady motions, in their order."""

def train_trial(config: str, command: str, settings: str, out: str, callback: Callable[..., object]) -> None:
    """Trains a trial of a sweep from its whole configuration, or goes on with it. `settings` are for TensorBoard."""

def sweep_trials(file: str) -> dict[str, Any]:
    """A sweep's name, folder, command and trials: folder, configuration, settings and threads of each."""

def sweep_table(file: str, folder: str) -> tuple[str, str]:
    """A sweep's table as Markdown and as JSON."""


class Sac:
    def __init__(
        self,
        observation_size: int,
        action_size: int,
        environments: int,
        capacity: int,
        seed: int,
        settings: Mapping[str, Any],
    ) -> None: ...
    @staticmethod
    def load(folder: str) -> Sac: ...
    def save(self, folder: str, more: Sequence[tuple[str, str]]) -> None: ...
    def act(self, observations: NDArray[np.float32], deterministic: bool) -> NDArray[np.float32]: ...
    def observe(
        self,
        observations: NDArray[np.float32],
        actions: NDArray[np.float32],
        rewards: NDArray[np.float32],
        next_observations: NDArray[np.float32],
        terminated: NDArray[np.bool_],
        truncated: NDArray[np.bool_],
    ) -> None: ...
    def update(self, count: int) -> dict[str, float]: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    @property
    def sizes(self) -> list[int]: ...
    @property
    def updates(self) -> int: ...
    @property
    def stored(self) -> int: ...
    @property
    def drawn(self) -> tuple[list[float], list[float]]:
        """Actions that `act` drew last, row after row, and ln π of each row."""
    @drawn.setter
    def drawn(self, drawn: tuple[Sequence[float], Sequence[float]]) -> None: ...
    def set_learning_rate(self, learning_rate: float) -> None: ...

class Batch:
    def __init__(
        self,
        count: int,
        omega_v: Sequence[float],
        *,
        experiment: str | None = None,
        controller: Controller | None = None,
        body: Mapping[str, Any] | None = None,
        task: Mapping[str, Any] | None = None,
        randomization: Mapping[str, Any] | None = None,
        disturbance: Mapping[str, Any] | None = None,
        threads: int = 1,
    ) -> None: ...
    @property
    def info_names(self) -> list[str]: ...
    def save(self) -> str: ...
    @staticmethod
    def restore(text: str) -> Batch: ...
    @property
    def body(self) -> dict[str, Any]: ...
    @property
    def task(self) -> dict[str, Any]: ...
    @property
    def disturbance(self) -> dict[str, Any] | None: ...
    def seed(self, index: int, seed: int) -> None: ...
    @property
    def omega_v(self) -> list[float]: ...
    @omega_v.setter
    def omega_v(self, omega_v: Sequence[float]) -> None: ...
    def state(self, index: int) -> tuple[_Floats, _Floats]: ...
    def watch(self, name: str) -> str: ...
    def unwatch(self) -> None: ...
    def render(self, indices: Sequence[int], width_px: int) -> list[NDArray[np.uint8]]: ...
    def reset_one(
        self,
        index: int,
        omega_v: float | None = None,
        default_start: bool = False,
        state: tuple[_Floats, _Floats] | None = None,
    ) -> tuple[_Floats, dict[str, Any]]: ...
    def step_one(self, right: float, left: float) -> tuple[_Floats, float, bool, bool, dict[str, Any]]: ...
    def reset_all(
        self,
        mask: Sequence[bool],
        omega_v: Sequence[float] | None = None,
        default_start: bool = False,
        states: Sequence[tuple[_Floats, _Floats]] | None = None,
    ) -> tuple[_Floats, _Floats]: ...
    def step(
        self, actions: _Floats, autoreset: int
    ) -> tuple[
        _Floats,
        _Floats,
        NDArray[np.bool_],
        NDArray[np.bool_],
        _Floats,
        tuple[_Floats, _Floats] | None,
        list[str | None] | None,
    ]: ...
