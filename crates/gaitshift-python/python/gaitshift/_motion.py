"""Controllers and recordings, on top of the compiled classes."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitshift import _native

if TYPE_CHECKING:
    import pandas


class Recording(Mapping[str, NDArray[np.float64]]):
    """A recorded motion: one row per control period, row 0 the initial state.

    ``recording["x_m"]`` is a column as an array of shape ``(rows,)``; ``gaitshift.COLUMNS`` lists the names that
    every recording has, units in the name, ``gaitshift.DETAILS`` those that it may have beside them, as ours do;
    ``reward_NAME`` are reward terms of one's own. docs/formats.md says what each holds.
    """

    def __init__(self, metadata: Mapping[str, Any], columns: Mapping[str, ArrayLike]) -> None:
        """A recording from another source, for instance another simulator.

        Args:
            metadata: ``control_period_s``, ``total_mass_kg``, ``gravity_m_per_s2``, ``leg_length_m``, ``body`` (a dict),
                ``controller`` (its name), ``seed``, ``fell``, ``ended_by``.
            columns: every name of ``gaitshift.COLUMNS``, any of ``gaitshift.DETAILS`` and any ``reward_NAME``, with its
                values, all of the same length, finite, times increasing.

        Raises:
            ValueError: what is missing, unknown, not finite or of another length.
        """
        arrays = {name: np.ascontiguousarray(values, dtype=np.float64) for name, values in columns.items()}
        self._native = _native.Recording(dict(metadata), arrays)

    @classmethod
    def _wrap(cls, native: _native.Recording) -> Recording:
        recording = cls.__new__(cls)
        recording._native = native
        return recording

    @classmethod
    def read_csv(cls, path: str | os.PathLike[str]) -> Recording:
        """Reads a recording that the program or :meth:`write_csv` wrote.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is no recording, of another version, cut off or damaged; with line and column.
        """
        return cls._wrap(_native.Recording.read_csv(os.fspath(path)))

    def write_csv(self, path: str | os.PathLike[str]) -> None:
        """Writes the recording as ``gaitshift evaluate --out`` does; numbers read back to the same bits."""
        self._native.write_csv(os.fspath(path))

    def write_npz(self, path: str | os.PathLike[str]) -> None:
        """Writes an NPZ file: one array for each column, and ``metadata``, its JSON as a string."""
        self._native.write_npz(os.fspath(path))

    @classmethod
    def read_npz(cls, path: str | os.PathLike[str]) -> Recording:
        """Reads a file of :meth:`write_npz` or ``gaitshift export npz``."""
        with np.load(path) as arrays:
            columns = {name: arrays[name] for name in arrays.files if name != "metadata"}
            return cls(json.loads(str(arrays["metadata"])), columns)

    @property
    def metadata(self) -> dict[str, Any]:
        """Control period, masses, all body parameters, controller, seed, and how the motion ended."""
        return self._native.metadata

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self._native[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._native.columns)

    def __len__(self) -> int:
        """Number of columns; the number of rows is ``rows``."""
        return len(self._native.columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self._native)

    def to_pandas(self) -> pandas.DataFrame:
        """All columns as a frame, ``time_s`` as the index; metadata in ``frame.attrs``. Needs pandas."""
        import pandas

        frame = pandas.DataFrame(dict(self)).set_index("time_s")
        frame.attrs = self.metadata
        return frame

    def summary(self, settling_time_s: float = 5.0) -> dict[str, Any]:
        """What the motion is: gait, speed, Froude number, support, cost of transport and more.

        The fields of ``gaitshift evaluate --json`` (docs/formats.md); ``None`` where undefined.

        Args:
            settling_time_s: time in s at the beginning that is left out, at most half of the motion.
        """
        return self._native.summary(settling_time_s)

    def transition_summary(self, ramp_start_s: float, ramp_end_s: float) -> dict[str, Any]:
        """The motion before a change of the command and after it: the fields of ``gaitshift transition --json``."""
        return self._native.transition_summary(ramp_start_s, ramp_end_s)

    def changes_of_gait(self) -> list[dict[str, Any]]:
        """What each change of the command does to the gait: ``changes`` of ``gaitshift transition --json``.

        Changes of the command with less than 4 s between them count as one.
        """
        return self._native.changes_of_gait()

    def __reduce__(self) -> tuple[Any, ...]:
        return Recording, (self.metadata, dict(self))

    def __repr__(self) -> str:
        metadata = self.metadata
        duration_s = max(self.rows - 1, 0) * metadata["control_period_s"]
        return f"<Recording of {duration_s:.2f} s by {metadata['controller']}, ended by {metadata['ended_by']}>"


class Controller:
    """A trained controller: a policy with the body and the task it was trained for.

    Attributes:
        name: what recordings call it.
        body: all parameters of the body, a dict.
        task: all parameters of the task, a dict.
        provenance: experiment and its digest, command, seed, steps.
        control_period_s: an action is held for this time, in s.
    """

    def __init__(self, native: _native.Controller) -> None:
        self._native = native
        self.name: str = native.name
        self.body: dict[str, Any] = native.body
        self.task: dict[str, Any] = native.task
        self.provenance: dict[str, Any] = native.provenance
        self.control_period_s: float = native.control_period_s

    @classmethod
    def shipped(cls) -> Controller:
        """The controller that comes with the package."""
        return cls(_native.Controller.shipped())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Controller:
        """Reads a ``controller.safetensors`` that ``gaitshift train`` wrote, or the best one of a run's folder, or takes the
        one that comes with the package under this name, ``"shipped"`` or ``"robust"``.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is no controller, of another version, cut off or damaged.
        """
        return cls(_native.Controller.load(os.fspath(path)))

    def __call__(self, observation: ArrayLike) -> NDArray[np.float32]:
        """The deterministic action.

        Args:
            observation: shape ``(14,)`` or ``(n, 14)``, SI units, as the environment gives it (not scaled).

        Returns:
            Commands of the right and the left actuator in [-1, 1], shape ``(2,)`` or ``(n, 2)``.

        Raises:
            ValueError: another shape, or a number that is not finite.
        """
        return self._native.act(np.ascontiguousarray(observation, dtype=np.float64))

    def predict(
        self, observation: ArrayLike, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[NDArray[np.float32], Any]:
        """As Stable-Baselines3's ``predict``, so that its ``evaluate_policy`` accepts the controller."""
        return self(observation), state

    def record(
        self,
        omega_v: float | Sequence[tuple[float, float]],
        duration_s: float = 20.0,
        *,
        seed: int | None = None,
        body: Mapping[str, Any] | None = None,
        task: Mapping[str, Any] | None = None,
        disturbance: Mapping[str, Any] | None = None,
    ) -> Recording:
        """Moves and records until the time is over or the body falls, to the same bits as the program.

        Args:
            omega_v: the command, or points ``(time in s, command)`` joined by straight lines.
            duration_s: at most this long, in s; the task's time limit is not applied.
            seed: draws the start and the noise, as ``--seed``; without it the default start.
            body: parameters that differ from the body it was trained on.
            task: parameters that differ from the task it was trained on.
            disturbance: what disturbs the motion, with the keys of ``gaitshift evaluate --disturbance``, e.g.
                ``{"terrain": {"slope_rad": 0.03}, "pushes": [{"forward_n": 80, "start_s": 2, "phase": 0.25}]}``.

        Raises:
            ValueError: an unknown parameter or a value out of range.

        Warns:
            UserWarning: a push never came.
        """
        if isinstance(omega_v, (int, float, np.number)):
            points = [(0.0, float(omega_v))]
        else:
            try:
                points = [(float(t), float(w)) for t, w in omega_v]
            except (TypeError, ValueError):
                raise ValueError(f"omega_v is {omega_v!r}, but it must be a number, or points (time in s, command)") from None
        tables = {"body": body, "task": task, "disturbance": disturbance}
        changes = {name: checked_table(name, table) for name, table in tables.items()}
        recording = Recording._wrap(self._native.record(points, duration_s, checked_whole("seed", seed, 0), **changes))
        asked = len((disturbance or {}).get("pushes", []))
        noted = (recording.metadata["disturbance"] or {}).get("pushes", []) if asked else []
        came = sum(push["start_s"] <= recording["time_s"][-1] for push in noted)
        if came < asked:
            warnings.warn(
                f"{came} of {asked} pushes came: the motion does not last until the time of the others, or their phase of the "
                "stride",
                stacklevel=2,
            )
        return recording

    def onnx(self) -> bytes:
        """The policy as an ONNX file: ``observation`` (batch, 14), not scaled, to ``action`` (batch, 2)."""
        return self._native.onnx()

    def write_onnx(self, path: str | os.PathLike[str]) -> None:
        """Writes :meth:`onnx` to a file."""
        self._native.write_onnx(os.fspath(path))

    # Gymnasium copies the arguments of an environment, and sends them to the processes of an AsyncVectorEnv.
    def __reduce__(self) -> tuple[Any, ...]:
        return _controller, (self._native.to_bytes(), self.name)

    def __repr__(self) -> str:
        return f"<Controller {self.name}>"


def checked_table(name: str, table: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Parameters that are given as a mapping, if they are given."""
    if table is None:
        return None
    if not isinstance(table, Mapping):
        raise TypeError(f"`{name}` must be a mapping of parameters, not {type(table).__name__}")
    return dict(table)


def checked_whole(name: str, value: int | None, least: int) -> int | None:
    """A whole number of 64 bits, if it is given."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value < 2**64:
        raise ValueError(f"`{name}` is {value!r}, but it must be a whole number from {least} to 2**64 - 1")
    return int(value)


def _controller(data: bytes, name: str) -> Controller:
    return Controller(_native.Controller.from_bytes(data, name))
