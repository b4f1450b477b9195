"""The task as a Gymnasium vector environment that steps in Rust with the GIL released."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from gaitshift import _native
from gaitshift._common import (
    RENDER_WIDTH_PX,
    Command,
    HasParameters,
    checked_render_mode,
    checked_seed,
    make_batch,
    make_spaces,
    render_metadata,
    reset_options,
)
from gaitshift._motion import Controller

_MODES = {AutoresetMode.NEXT_STEP: 0, AutoresetMode.SAME_STEP: 1, AutoresetMode.DISABLED: 2}
_DIVERGED = _native.INFO_NAMES.index("diverged")


class PassiveBipedVectorEnv(HasParameters, VectorEnv[NDArray[np.float64], NDArray[np.float32], NDArray[Any]]):
    """``num_envs`` bipeds, each as :class:`gaitshift.env.PassiveBipedEnv` and to the same bits.

    Observations ``(num_envs, 14)``, actions ``(num_envs, 2)``, rewards ``(num_envs,)`` float64, flags ``(num_envs,)``
    bool. ``info[name]`` is an array ``(num_envs,)`` for every name of the single environment's info and ``info["_" + name]``
    says for which environments it holds, which is all of them. Where episodes ended there is ``info["ended_by"]`` too, an
    object array with ``None`` for the others.

    The option ``omega_v`` of :meth:`reset` is one command for all or a sequence of ``num_envs``; the option ``state`` has a row
    for each environment. Seeds, automatic resets and ``options["reset_mask"]`` follow Gymnasium's ``SyncVectorEnv``:
    environment ``i`` gets ``seed + i``; with ``AutoresetMode.SAME_STEP`` what the last step of an episode gave is in
    ``info["final_obs"]`` (an object array) and ``info["final_info"]``, where ``ended_by`` then is.
    """

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 200,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        omega_v: Command = (-0.5, 3.5),
        *,
        experiment: str | os.PathLike[str] | None = None,
        controller: Controller | str | os.PathLike[str] | None = None,
        body: Mapping[str, Any] | None = None,
        task: Mapping[str, Any] | None = None,
        randomization: Mapping[str, Any] | None = None,
        disturbance: Mapping[str, Any] | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        threads: int = 1,
        render_mode: str | None = None,
    ) -> None:
        """Prepares the environments; arguments as of the single one, and:

        Args:
            num_envs: how many.
            autoreset_mode: how an environment goes on after its episode.
            threads: how many threads share a step; what comes out does not depend on it.
        """
        self.render_mode = checked_render_mode(render_mode, ["rgb_array"])
        self._batch = make_batch(
            num_envs, omega_v, experiment, controller, body, task, randomization, disturbance, threads
        )
        self.num_envs = num_envs
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**render_metadata(self.metadata, self._batch), "autoreset_mode": self.autoreset_mode}
        self.single_observation_space, self.single_action_space = make_spaces()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._seeded = False
        self._over = np.zeros(num_envs, dtype=bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Begins an episode in every environment, or in those of ``options["reset_mask"]``."""
        self._check_open()
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        commands = options.pop("omega_v", None)
        commands = None if commands is None else self._checked_commands(commands, "options['omega_v']")
        opening = reset_options(options, self.num_envs)
        mask = np.ones(self.num_envs, dtype=bool) if mask is None else self._checked_mask(mask).copy()
        if not self._seeded and not mask.all():
            raise ResetNeeded("the first reset must be of all environments")
        if seed is None:
            seeds: list[int | None] = [None] * self.num_envs
        elif isinstance(seed, (int, np.integer)):
            seeds = [checked_seed(int(seed) + i) for i in range(self.num_envs)]
            super().reset(seed=int(seed))
        else:
            seeds = [None if own is None else checked_seed(own) for own in seed]
            if len(seeds) != self.num_envs:
                raise ValueError(f"{len(seeds)} seeds were given for {self.num_envs} environments")
        for i, own in enumerate(seeds):
            if not mask[i]:
                continue
            if own is not None:
                self._batch.seed(i, own)
            elif not self._seeded:
                self._batch.seed(i, int(self.np_random.integers(2**63)))
        states = None if opening.state is None else list(zip(*opening.state))
        observations, info = self._batch.reset_all(mask.tolist(), commands, opening.default_start, states)
        self._seeded = True
        self._over = self._over & ~mask
        return observations, self._info(info, mask)

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Advances every environment by one control period, or begins its next episode.

        Raises:
            ValueError: actions of another shape than ``(num_envs, 2)``, or with a number that is not finite.
            gymnasium.error.ResetNeeded: no episode has begun, or, without automatic resets, one is over.
            gymnasium.error.ClosedEnvironmentError: the environments are closed.
        """
        self._check_running("step")
        if self.autoreset_mode == AutoresetMode.DISABLED and self._over.any():
            first = int(np.argmax(self._over))
            raise ResetNeeded(f"the episode of environment {first} is over; reset it with options={{'reset_mask': ...}}")
        commands = np.ascontiguousarray(actions, dtype=np.float64)
        if commands.shape != (self.num_envs, 2):
            raise ValueError(f"the actions have the shape {commands.shape}, but it must be ({self.num_envs}, 2)")
        observations, rewards, terminated, truncated, info, final, ended_by = self._batch.step(
            commands, _MODES[self.autoreset_mode]
        )
        over = terminated | truncated
        self._over = over.copy()
        infos = self._info(info, np.ones(self.num_envs, dtype=bool))
        last = infos
        if final is not None:
            final_observations, final_info = final
            rows = np.full(self.num_envs, None, dtype=object)
            for i in np.flatnonzero(over):
                rows[i] = final_observations[i]
            last = self._info(final_info, over)
            infos |= {"final_obs": rows, "_final_obs": over, "final_info": last, "_final_info": over}
        if ended_by is not None:
            last |= {"ended_by": np.array(ended_by, dtype=object), "_ended_by": over}
        return observations, rewards, terminated, truncated, infos

    def set_omega_v(self, omega_v: float | Sequence[float]) -> None:
        """Changes the command of all environments, or of each by a sequence of ``num_envs`` numbers."""
        self._check_running("set_omega_v")
        self._batch.omega_v = self._checked_commands(omega_v, "omega_v")

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture of every environment as of the single one, in a tuple; ``None`` without a render mode."""
        if self.render_mode is None:
            return None
        self._check_running("render")
        return tuple(self._batch.render(range(self.num_envs), RENDER_WIDTH_PX))

    def close_extras(self, **kwargs: Any) -> None:
        """There are no resources to release."""

    def _info(self, values: NDArray[np.float64], mask: NDArray[np.bool_]) -> dict[str, Any]:
        names = self._batch.info_names
        info: dict[str, Any] = dict(zip(names, values))
        info["diverged"] = values[_DIVERGED] != 0.0
        info.update({"_" + name: mask for name in names})
        return info

    def _checked_commands(self, omega_v: Any, name: str) -> list[float]:
        try:
            commands = np.asarray(omega_v)
        except ValueError:  # rows of different lengths
            commands = np.array("")
        if commands.ndim > 1 or commands.dtype.kind not in "biuf":
            raise TypeError(
                f"{name} must be a number, or {self.num_envs} of them, one for each environment, not {omega_v!r}"
            )
        if commands.shape not in ((), (self.num_envs,)):
            raise ValueError(
                f"{name} has the length {len(commands)}, but there are {self.num_envs} environments; give one "
                "command for all, or one for each"
            )
        return [float(command) for command in np.broadcast_to(commands, (self.num_envs,))]

    def _checked_mask(self, mask: Any) -> NDArray[np.bool_]:
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise TypeError("options['reset_mask'] must be a NumPy array of bool")
        if mask.shape != (self.num_envs,):
            raise ValueError(f"options['reset_mask'] has the shape {mask.shape}, but it must be ({self.num_envs},)")
        if not mask.any():
            raise ValueError("options['reset_mask'] names no environment")
        return mask

    def _check_running(self, what: str) -> None:
        self._check_open()
        if not self._seeded:
            raise ResetNeeded(f"call reset before {what}")

    def _check_open(self) -> None:
        if self.closed:
            raise ClosedEnvironmentError("the environment is closed; make another one")
