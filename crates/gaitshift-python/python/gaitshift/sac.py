"""The learner alone: Soft Actor-Critic for any environment with continuous actions."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from gaitshift import _native

_SETTINGS = "sac.json"
_FORMAT = "gaitshift-sac 1"


class SAC:
    """A Soft Actor-Critic agent with its replay buffer.

    The learner of ``gaitshift train``, without the task's mirror: give it what an environment does, and let it update as
    often as you like. The same seed and calls give the same numbers for any number of threads; saved and loaded, it goes
    on to the same bits. Updates run without the interpreter's lock and stop between two of them on Ctrl-C.

    With ``environments=1`` the methods take and give single observations ``(observation_size,)`` and actions
    ``(action_size,)``, else rows ``(environments, ...)``. A row should always be the same environment.

    ::

        learner = gaitshift.SAC.for_spaces(env.observation_space, env.action_space, seed=1)
        observation, _ = env.reset(seed=1)
        for step in range(20_000):
            action = env.action_space.sample() if step < 1_000 else learner.act(observation)
            following, reward, terminated, truncated, _ = env.step(action)
            learner.observe(observation, action, reward, following, terminated, truncated)
            observation = env.reset()[0] if terminated or truncated else following
            if step >= 1_000:
                learner.update()
    """

    def __init__(
        self,
        observation_size: int,
        action_size: int,
        *,
        seed: int = 1,
        environments: int = 1,
        capacity: int = 1_000_000,
        action_low: ArrayLike = -1.0,
        action_high: ArrayLike = 1.0,
        hidden: tuple[int, ...] | list[int] = (256, 256),
        learning_rate: float = 3e-4,
        gamma: float = 0.99,
        tau: float = 0.005,
        batch_size: int = 256,
        temperature: float | str | dict[str, Any] = "auto",
        threads: int = 1,
        **settings: Any,
    ) -> None:
        """
        Args:
            observation_size: numbers in an observation.
            action_size: numbers in an action.
            seed: of everything random.
            environments: observed together, row by row.
            capacity: transitions in the replay buffer.
            action_low: bounds of the actions, numbers or one for each; the policy's (-1, 1) is scaled to them.
            action_high: see ``action_low``.
            hidden: units of each hidden layer of actor and critics; ``actor_hidden`` and ``critic_hidden`` for each.
            learning_rate: of actor, critics and, with ``"auto"``, temperature.
            gamma: discount per step.
            tau: share of the critics that their targets take over in each update.
            batch_size: transitions in an update.
            temperature: weight of the entropy: a number, ``"auto"`` to hold an entropy of ``-action_size``, or a table as
                ``[learner.temperature]`` of an experiment.
            threads: of an update; they change the speed, never the result.
            **settings: any other key of ``[learner]``, such as ``n_step``, ``critic_layer_norm``.

        Raises:
            ValueError: an unknown setting or a value out of range.
        """
        if temperature == "auto":
            temperature = {"kind": "auto", "initial": 1.0, "learning_rate": learning_rate}
        elif isinstance(temperature, str):
            raise ValueError(f"`temperature` is {temperature!r}, but it must be a number, 'auto' or a table")
        elif not isinstance(temperature, dict):
            temperature = {"kind": "fixed", "alpha": float(temperature)}
        all_settings: dict[str, Any] = {
            "actor_hidden": list(hidden),
            "critic_hidden": list(hidden),
            "learning_rate": learning_rate,
            "gamma": gamma,
            "tau": tau,
            "batch_size": batch_size,
            "temperature": temperature,
            "threads": threads,
            **settings,
        }
        sizes = {
            "observation_size": observation_size,
            "action_size": action_size,
            "environments": environments,
            "capacity": capacity,
            "seed": seed,
        }
        for name, size in sizes.items():
            if not isinstance(size, (int, np.integer)) or not 0 <= size < 2**64:
                raise ValueError(f"`{name}` is {size!r}, but it must be a whole number, 0 or greater")
        self._low, self._high = _bounds(action_low, action_high, int(action_size))
        self._native = _native.Sac(
            int(observation_size), int(action_size), int(environments), int(capacity), int(seed), all_settings
        )

    @classmethod
    def for_spaces(cls, observation_space: Any, action_space: Any, **settings: Any) -> SAC:
        """A learner for the spaces of a single Gymnasium environment: sizes and bounds are theirs.

        Raises:
            TypeError: a space that is not a one-dimensional ``Box``.
            ValueError: an action without bounds; or as the constructor.
        """
        for name, space in (("observation", observation_space), ("action", action_space)):
            if not isinstance(space, spaces.Box) or len(space.shape) != 1:
                raise TypeError(
                    f"the {name} space is {space}, but the learner needs a Box of one dimension; "
                    "gymnasium.wrappers.FlattenObservation makes one of most observations"
                )
        if not action_space.is_bounded():
            raise ValueError(f"the action space is {action_space}, but every action needs bounds")
        return cls(
            observation_space.shape[0],
            action_space.shape[0],
            action_low=action_space.low,
            action_high=action_space.high,
            **settings,
        )

    @property
    def observation_size(self) -> int:
        """Numbers in an observation."""
        return self._native.sizes[0]

    @property
    def action_size(self) -> int:
        """Numbers in an action."""
        return self._native.sizes[1]

    @property
    def environments(self) -> int:
        """Environments observed together."""
        return self._native.sizes[2]

    @property
    def capacity(self) -> int:
        """Transitions that the replay buffer holds at most."""
        return self._native.sizes[3]

    @property
    def stored(self) -> int:
        """Transitions that the replay buffer holds."""
        return self._native.stored

    @property
    def updates(self) -> int:
        """Updates so far."""
        return self._native.updates

    @property
    def settings(self) -> dict[str, Any]:
        """All settings of the learner, as ``[learner]`` of an experiment."""
        return self._native.settings

    def act(self, observation: ArrayLike, deterministic: bool = False) -> NDArray[np.float32]:
        """The action for an observation, within the bounds.

        Deterministic ones, without the policy's noise, may be asked for any number of observations ``(n, observation_size)``
        at once.

        Raises:
            ValueError: another shape, or a number that is not finite.
        """
        rows, single = self._rows("observation", observation, self.observation_size, None if deterministic else 0)
        actions = self._native.act(rows, deterministic)
        scaled = self._low + 0.5 * (actions + 1.0) * (self._high - self._low)
        bounded = np.clip(scaled, self._low, self._high).astype(np.float32)
        return bounded[0] if single else bounded

    def predict(
        self, observation: ArrayLike, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[NDArray[np.float32], Any]:
        """As Stable-Baselines3's ``predict``, so that its ``evaluate_policy`` accepts the learner."""
        return self.act(observation, deterministic=deterministic), state

    def observe(
        self,
        observation: ArrayLike,
        action: ArrayLike,
        reward: ArrayLike,
        next_observation: ArrayLike,
        terminated: ArrayLike,
        truncated: ArrayLike = False,
    ) -> None:
        """Stores the outcome of an action.

        Args:
            observation: where the action was taken.
            action: the action, within the bounds; it need not come from :meth:`act`.
            reward: its reward.
            next_observation: where it led, before any reset: of an episode that ended its last observation.
            terminated: nothing follows.
            truncated: the episode was cut off, and something would have followed.

        Raises:
            ValueError: another shape, a number that is not finite, an action out of bounds; nothing is stored then.
        """
        observations, _ = self._rows("observation", observation, self.observation_size)
        following, _ = self._rows("next_observation", next_observation, self.observation_size)
        actions, _ = self._rows("action", action, self.action_size)
        # A hair of rounding is no mistake.
        room = 1e-5 * (self._high - self._low)
        if not np.all((actions >= self._low - room) & (actions <= self._high + room)):
            raise ValueError(f"the action is {action!r}, but it must lie within the bounds {self._low} to {self._high}")
        unscaled = 2.0 * (actions - self._low) / (self._high - self._low) - 1.0
        self._native.observe(
            observations,
            np.clip(unscaled, -1.0, 1.0).astype(np.float32),
            self._numbers("reward", reward, np.float32),
            following,
            self._numbers("terminated", terminated, np.bool_),
            self._numbers("truncated", truncated, np.bool_),
        )

    def update(self, n: int = 1) -> dict[str, float]:
        """Makes ``n`` updates; returns the means of ``critic_loss``, ``actor_loss``, ``mean_q`` and ``entropy`` (nats) over
        them, and the temperature ``alpha``.

        Raises:
            ValueError: nothing has been observed yet.
            RuntimeError: learning diverged.
        """
        if not isinstance(n, (int, np.integer)) or n < 0:
            raise ValueError(f"`n` is {n!r}, but it must be a whole number, 0 or greater")
        return self._native.update(int(n))

    def set_learning_rate(self, learning_rate: float) -> None:
        """Changes the learning rate of actor and critics."""
        self._native.set_learning_rate(learning_rate)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Saves networks, optimiser, random numbers and replay buffer in a folder, over one that was saved before.

        Environments are not part of it; where they go on as they were, learning goes on to the same bits, also when it
        was saved between :meth:`act` and :meth:`observe`.

        Raises:
            OSError: it cannot be written.
            ValueError: something else is there already.
        """
        more = {
            "format": _FORMAT,
            "action_low": self._low.tolist(),
            "action_high": self._high.tolist(),
            "drawn": self._native.drawn,
        }
        self._native.save(os.fspath(path), [(_SETTINGS, json.dumps(more) + "\n")])

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SAC:
        """Reads what :meth:`save` wrote.

        Raises:
            OSError: it cannot be read.
            ValueError: it is damaged, of another version, or no learner.
        """
        learner = cls.__new__(cls)
        learner._native = _native.Sac.load(os.fspath(path))
        file = Path(path) / _SETTINGS
        try:
            more = json.loads(file.read_text(encoding="utf-8"))
            if more["format"] != _FORMAT:
                raise ValueError(f"its format is {more['format']!r}, this version reads {_FORMAT!r}")
            learner._low, learner._high = _bounds(more["action_low"], more["action_high"], learner.action_size)
            # A folder of an earlier version has none.
            learner._native.drawn = tuple(more.get("drawn", ([], [])))
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f"{file} is no part of a saved learner: {error}") from None
        return learner

    def __repr__(self) -> str:
        sizes = f"{self.observation_size} observations, {self.action_size} actions"
        return f"<SAC for {sizes}, {self.updates} updates>"

    def _rows(self, name: str, values: ArrayLike, size: int, count: int | None = 0) -> tuple[NDArray[np.float32], bool]:
        """Values as rows, and whether they were a single one; `count` None allows any number of rows."""
        array = np.asarray(values, dtype=np.float32)
        single = array.ndim == 1
        rows = array.reshape(1, -1) if single else array
        wanted = self.environments if count == 0 else None
        if rows.ndim != 2 or rows.shape[1] != size or (wanted is not None and rows.shape[0] != wanted):
            shape = f"({size},)" if self.environments == 1 else f"({self.environments}, {size})"
            also = f" or (n, {size})" if count is None else ""
            raise ValueError(f"`{name}` has the shape {array.shape}, but it must be {shape}{also}")
        if not np.isfinite(rows).all():
            raise ValueError(f"`{name}` is {values!r}, but every number must be finite")
        return np.ascontiguousarray(rows), single

    def _numbers(self, name: str, values: ArrayLike, kind: Any) -> NDArray[Any]:
        array = np.asarray(values)
        rows = np.broadcast_to(array, (self.environments,)) if array.ndim == 0 else array
        if rows.shape != (self.environments,):
            raise ValueError(f"`{name}` has the shape {array.shape}, but it must be ({self.environments},)")
        if not np.isfinite(rows).all():
            raise ValueError(f"`{name}` is {values!r}, but it must be finite")
        return np.ascontiguousarray(rows, dtype=kind)


def _bounds(low: ArrayLike, high: ArrayLike, size: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    try:
        bounds = [np.broadcast_to(np.asarray(b, dtype=np.float64), (size,)).copy() for b in (low, high)]
    except ValueError:
        raise ValueError(f"`action_low` and `action_high` must be numbers or have {size} of them each") from None
    if not (np.isfinite(bounds).all() and (bounds[0] < bounds[1]).all()):
        raise ValueError(f"`action_low` is {low!r} and `action_high` {high!r}, but they must be finite, low below high")
    return bounds[0], bounds[1]
