"""Training runs and their folders, on top of the compiled functions."""

from __future__ import annotations

import io
import json
import logging
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from gaitshift import _native
from gaitshift._common import experiment_text
from gaitshift._motion import Controller, checked_whole

if TYPE_CHECKING:
    import pandas

_log = logging.getLogger("gaitshift")


class Evaluation(TypedDict):
    """The result of an evaluation without noise, in short."""

    met: int
    """Number of criteria met."""
    criteria: int
    """Number of criteria."""
    score: float
    """With partial credit for criteria nearly met; controllers are compared by it."""
    accepted: bool
    """Whether every criterion is met."""
    best: bool
    """Whether it is the best of the run so far."""


@dataclass(frozen=True)
class Progress:
    """The progress of a run, which is passed to the callback.

    Attributes:
        step: environment steps so far.
        total_steps: environment steps in all.
        updates: updates of the learner so far.
        elapsed_s: wall-clock so far in s, resumed runs counted together.
        phase: name of the phase of the curriculum.
        mean_return: mean reward per episode over the last 100 episodes.
        fall_share: share of them that ended in a fall.
        verdict: a short verdict of the last evaluation.
        evaluation: the evaluation that was just made, or ``None`` between two of them.
    """

    step: int
    total_steps: int
    updates: int
    elapsed_s: float
    phase: str
    mean_return: float
    fall_share: float
    verdict: str
    evaluation: Evaluation | None = None


Callback = Callable[[Progress], object]
"""Called every few thousand steps and after every evaluation; ``False``, or what else counts as false but ``None``, stops the
run with a checkpoint."""


def train(
    experiment: str | os.PathLike[str] = "fast",
    *,
    seed: int | None = None,
    out: str | os.PathLike[str] | None = None,
    set: Mapping[str, Any] | None = None,
    threads: int | None = None,
    steps: int | None = None,
    stop_when_accepted: bool = False,
    callback: Callback | None = None,
) -> Run:
    """Trains a controller: the run of ``gaitshift train``, to the same bits.

    Releases the GIL, so other threads keep running. Ctrl-C writes a checkpoint and raises ``KeyboardInterrupt``;
    an exception in the callback also writes one. :meth:`Run.resume` continues from there.
    Evaluations and notes go to the logger ``gaitshift``; what is probably not meant is a ``UserWarning``.

    Args:
        experiment: a recipe (``paper``, ``journal``, ``fast``, ``robust``) or the path of an experiment's file.
        seed: replaces the experiment's.
        out: a new folder; ``runs/NAME-SEED`` without it.
        set: values that differ from the experiment's: ``{"body.friction": 0.6}`` or ``{"body": {"friction": 0.6}}``.
        threads: threads of the learner; they change the speed, never the result.
        steps: stops with a checkpoint at about this step.
        stop_when_accepted: ends at the first evaluation that meets every criterion; where phases randomize, of those from
            the first such phase on.
        callback: see :data:`Callback`.

    Raises:
        ValueError: an unknown recipe or key, a value out of range, a folder that holds a run already.
        RuntimeError: the run began and cannot go on: a full disk, a learner that diverged.
    """
    folder = _native.train(
        experiment_text(experiment) or "fast",
        _receiver(callback),
        set=list(_assignments(set or {})),
        seed=checked_whole("seed", seed, 0),
        out=None if out is None else os.fspath(out),
        threads=checked_whole("threads", threads, 1),
        steps=checked_whole("steps", steps, 1),
        stop_when_accepted=stop_when_accepted,
    )
    return Run(folder)


def _receiver(callback: Callback | None) -> Callable[..., object]:
    if callback is not None and not callable(callback):
        raise TypeError(f"`callback` must be callable, not {type(callback).__name__}")

    def receive(what: str, value: Any, evaluation: Evaluation | None) -> object:
        if what == "note":
            _log.info("%s", value)
            return None
        progress = Progress(**value, evaluation=evaluation)
        if evaluation is not None:
            _log.info("step %d of %d: %s", progress.step, progress.total_steps, progress.verdict)
        return None if callback is None else callback(progress)

    return receive


def _assignments(values: Mapping[str, Any], within: str = "") -> Iterator[str]:
    """What differs, as the program takes it: KEY=VALUE, the value in TOML."""
    for key, value in values.items():
        if not isinstance(key, str):
            raise TypeError(f"`set`: the key {key!r} must be a text such as 'body.friction'")
        path = f"{within}{key}"
        # A table whose key `kind` says what else it holds is replaced whole.
        if isinstance(value, Mapping) and "kind" not in value:
            yield from _assignments(value, f"{path}.")
        else:
            yield f"{path}={_toml(value, path)}"


def _toml(value: Any, key: str) -> str:
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: "inf", -math.inf: "-inf"}.get(value, "nan")
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(str(k), ensure_ascii=False)} = {_toml(v, key)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(item, key) for item in value) + "]"
    raise TypeError(f"`set`: `{key}` is {value!r}, but a value must be a number, text, bool, list or mapping")


class Run:
    """The folder of a training run: its settings, its progress and its results.

    Nothing is kept in memory: every attribute reads the folder anew, also while the run is still training elsewhere.
    ``metrics``, ``episodes``, ``evaluations``, ``motions`` and ``criteria`` need pandas: ``pip install
    crates/gaitshift-python[pandas]`` in a clone.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        """
        Raises:
            FileNotFoundError: the folder holds no run.
        """
        self.folder: Path = Path(folder)
        if not (self.folder / "config.toml").is_file():
            raise FileNotFoundError(f"{self.folder} is not a run's folder: it has no config.toml")

    def resume(
        self, *, threads: int | None = None, steps: int | None = None, callback: Callback | None = None
    ) -> Run:
        """Continues from the last checkpoint, to the same bits as if the run had not stopped; arguments as in :func:`train`.

        Edits of the folder's ``config.toml`` apply from there on, as with ``gaitshift train --resume``.

        Raises:
            ValueError: no checkpoint, a damaged one, or an edit of what the checkpoint decides.
            RuntimeError: the run cannot go on.
        """
        _native.resume(
            os.fspath(self.folder),
            _receiver(callback),
            threads=checked_whole("threads", threads, 1),
            steps=checked_whole("steps", steps, 1),
        )
        return self

    @property
    def config(self) -> dict[str, Any]:
        """The whole experiment, every value written out."""
        return _native.run_config(os.fspath(self.folder))

    @property
    def report(self) -> dict[str, Any] | None:
        """How the run ended or was last stopped (docs/formats.md); ``None`` before that."""
        try:
            text = (self.folder / "report.json").read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        report: dict[str, Any] = json.loads(text)
        return report

    @property
    def finished(self) -> bool:
        """Whether it took all its steps, or met the criteria where that ends it."""
        report = self.report
        return report is not None and bool(report["finished"])

    @property
    def metrics(self) -> pandas.DataFrame:
        """The metrics of ``metrics.csv``, indexed by ``train/step``."""
        return self._table("metrics.csv", "train/step")

    @property
    def episodes(self) -> pandas.DataFrame:
        """Every episode, in order: ``step``, ``omega_v``, ``total_reward``, ``periods``, ``ended``, ``distance_m``."""
        return self._table("episodes.csv")

    @property
    def evaluations(self) -> pandas.DataFrame:
        """One row for each evaluation, indexed by ``step``: ``elapsed_s``, ``met``, ``criteria``, ``score``, ``accepted``."""
        names = ["step", "elapsed_s", "met", "criteria", "score", "accepted"]
        rows = [{**line, "criteria": len(line["checks"])} for line in self._evaluations()]
        return _pandas().DataFrame(rows, columns=names).set_index("step")

    @property
    def motions(self) -> pandas.DataFrame:
        """The steady motions of all evaluations: one row for each ``step`` and command ``omega_v``, its gait, speed, Froude
        number and everything else that ``gaitshift evaluate --json`` gives."""
        return self._nested("rows", _native.motion_names())

    @property
    def criteria(self) -> pandas.DataFrame:
        """The criteria of all evaluations: ``step``, ``name``, ``value``, ``met``, ``reason``, ``credit``."""
        return self._nested("checks", ["name", "value", "met", "reason", "credit"])

    @property
    def controllers(self) -> Mapping[int, Controller]:
        """The evaluated controllers by step; each is read on access."""
        return _Controllers(self.folder / "controllers")

    @property
    def best(self) -> Controller:
        """The controller with the highest score so far.

        Raises:
            FileNotFoundError: nothing has been evaluated yet.
        """
        return self._controller("controller.safetensors", "nothing has been evaluated yet")

    @property
    def last(self) -> Controller:
        """The controller of the last checkpoint."""
        return self._controller("controller-last.safetensors", "there is no checkpoint yet")

    def __fspath__(self) -> str:
        return os.fspath(self.folder)

    def __repr__(self) -> str:
        return f"<Run {self.folder}, {'finished' if self.finished else 'not finished'}>"

    def _controller(self, name: str, why: str) -> Controller:
        path = self.folder / name
        if not path.exists():
            raise FileNotFoundError(f"{self.folder} has no {name}: {why}")
        return Controller.load(path)

    def _text(self, name: str) -> str:
        """A log without the line that is just being written."""
        try:
            text = (self.folder / name).read_text(encoding="utf-8")
        except FileNotFoundError:
            return ""
        return text[: text.rfind("\n") + 1]

    def _table(self, name: str, index: str | None = None) -> pandas.DataFrame:
        pandas = _pandas()
        text = self._text(name)
        if not text:
            return pandas.DataFrame()
        # A reader that gives back the bits that were written.
        frame = pandas.read_csv(io.StringIO(text), float_precision="round_trip")
        return frame if index is None else frame.set_index(index)

    def _evaluations(self) -> list[dict[str, Any]]:
        lines = []
        for number, line in enumerate(self._text("evaluations.jsonl").splitlines(), 1):
            try:
                lines.append(json.loads(line))
            except json.JSONDecodeError as error:
                path = self.folder / "evaluations.jsonl"
                raise ValueError(f"{path}: line {number} is damaged: {error}") from None
        return lines

    def _nested(self, name: str, columns: Sequence[str]) -> pandas.DataFrame:
        rows = [{"step": line["step"], **row} for line in self._evaluations() for row in line[name]]
        # Rows of another version keep their own columns.
        return _pandas().DataFrame(rows, columns=None if rows else ["step", *columns])


class _Controllers(Mapping[int, Controller]):
    """Controllers by step, read when they are asked for."""

    def __init__(self, folder: Path) -> None:
        names = (re.fullmatch(r"step-(\d+)\.safetensors", path.name) for path in folder.glob("step-*"))
        self._paths = {int(name[1]): folder / name[0] for name in names if name}

    def __getitem__(self, step: int) -> Controller:
        return Controller.load(self._paths[step])

    def __iter__(self) -> Iterator[int]:
        return iter(sorted(self._paths))

    def __len__(self) -> int:
        return len(self._paths)

    def __repr__(self) -> str:
        return f"<controllers of steps {list(self)}>"


def _pandas() -> Any:
    try:
        import pandas
    except ImportError:
        raise ImportError("this needs pandas: pip install 'crates/gaitshift-python[pandas]' in a clone of gaitshift") from None
    return pandas
