"""The task as a Gymnasium environment."""

from __future__ import annotations

import os
import sys
import time
import webbrowser
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from numpy.typing import NDArray

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


class PassiveBipedEnv(HasParameters, gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]):
    """One biped at the paper's task.

    **Observation**, shape ``(14,)``, float64, SI units, not scaled, in the order of ``gaitshift.OBSERVATION_NAMES``:
    forward speed of the hip (m/s); pitch (rad) and its rate (rad/s); thigh displacement ``h`` (m) and its rate (m/s),
    right and left; hip angle (rad) and its rate (rad/s), right and left; rate of the leg's compression ``d`` (m/s),
    right and left; the command ``omega_v``. ``gaitshift.OBSERVATION_SCALE`` brings them to order one.

    **Action**, shape ``(2,)``, in [-1, 1]: forces of the right and the left actuator in units of their greatest
    (600 N by default), positive lengthening the leg, held for one control period (5 ms in the default recipe). What lies beyond
    [-1, 1] is limited to it.

    **Reward**: (2) of the paper with the task's weights, times the task's common factor, without the symmetry term (7),
    which depends on the policy and not on the motion.

    **End**: terminated by a fall (pitch, the hip too low, a rule of ``task["termination"]["extra"]``) or by a diverged
    simulation (``info["diverged"]``); truncated by the task's time limit (5 s in the default recipe).

    **info**: floats by the names of ``gaitshift.INFO_NAMES``: the reward's weighted terms (their sum times the common
    factor is the reward), energies, works and losses since the episode began (J), contact forces (N, means over the
    period), position (m), time (s) and command; and ``reward_NAME`` for each term of ``task["reward"]["extra"]``.
    The last step of an episode also has the text ``ended_by``: why it ended, in the words of recordings and of ``episodes.csv``
    (``"time limit"``, ``"pitch"``, ``"hip height"``, ``"diverged"``, ``"undefined"``, or the name of a rule of one's own).

    **reset** takes the options ``omega_v`` (the command of this episode) and ``start`` (``"random"`` or ``"default"``: the
    middle of the ranges that starts are drawn from), or ``state`` (positions and velocities, as :attr:`state` gives them, to
    rounding). The ground of ``disturbance`` or ``randomization`` lies where it lies in x, so a state of flat ground may be
    below it, which ends the episode at once. ``reset(seed=n)`` starts where ``gaitshift evaluate --seed n`` does.

    Environments can be pickled and copied (``copy.deepcopy``) in mid-episode; the copy continues to the same bits.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 200}

    def __init__(
        self,
        omega_v: Command = (-0.5, 3.5),
        *,
        experiment: str | os.PathLike[str] | None = None,
        controller: Controller | str | os.PathLike[str] | None = None,
        body: Mapping[str, Any] | None = None,
        task: Mapping[str, Any] | None = None,
        randomization: Mapping[str, Any] | None = None,
        disturbance: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Prepares the environment.

        Args:
            omega_v: the command, or the range (lowest, highest) that each episode draws its own from.
            experiment: recipe (``"paper"``, the default, ``"journal"``, ``"fast"``, ``"robust"``) or TOML file whose
                ``[body]`` and ``[task]`` are used. What a curriculum changes during training is not.
            controller: take body and task of this controller instead.
            body: parameters of the body that differ, e.g. ``{"friction": 0.6}``.
            task: parameters of the task that differ, e.g. ``{"reward": {"omega_e": 0.1}}``, or with a reward term of one's own
                ``{"reward": {"extra": [{"name": "upright", "weight": 0.2, "expression": "-theta_rad^2"}]}}``.
            randomization: what each episode draws: factors of the body, ground, pushes, weak actuators, latency, noise, with
                the keys of a phase's ``randomization``, e.g. ``{"body": {"friction": [0.5, 1.2]}, "latency_s": [0, 0.01],
                "terrain": {"slope_rad": [-0.05, 0.05]}}``.
            disturbance: what disturbs every episode, with the keys of ``gaitshift evaluate --disturbance``, e.g.
                ``{"terrain": {"slope_rad": 0.03}, "pushes": [{"forward_n": 80, "start_s": 2}]}``; not together with
                ``randomization``. A push's ``phase`` is of a stride that is taken to last as long as the one before.
            render_mode: ``"rgb_array"``: :meth:`render` gives a picture; ``gymnasium.make`` also takes ``"rgb_array_list"``.
                ``"human"``: the first reset opens a page in the browser, at :attr:`url`, on which the body moves; steps wait so
                that it moves in real time.

        Raises:
            TypeError: another render mode.
            ValueError: an unknown parameter or recipe, a value out of range, an experiment or controller that cannot be
                used.
            OSError: the controller's file cannot be read.

        Warns:
            UserWarning: a push of ``disturbance`` would come after the end of every episode.
        """
        self.render_mode = checked_render_mode(render_mode, ["human", "rgb_array"])
        self.observation_space, self.action_space = make_spaces()
        self._batch = make_batch(1, omega_v, experiment, controller, body, task, randomization, disturbance)
        self.metadata = render_metadata(self.metadata, self._batch)
        self._seeded = False
        self._running = False
        self._closed = False
        self.url: str | None = None
        """Where the page of the render mode ``human`` is, from the first reset on."""
        self._due_s = 0.0

    @property
    def omega_v(self) -> float:
        """The command in force. Set it during an episode to change gait: the next step, and its reward, are under it.

        ``gymnasium.make`` wraps the environment: write ``env.unwrapped.omega_v = 3.0``, since ``env.omega_v = 3.0`` would only
        set an attribute of the wrapper.
        """
        return self._batch.omega_v[0]

    @omega_v.setter
    def omega_v(self, value: float) -> None:
        self._check_running("setting omega_v")
        self._batch.omega_v = [value]

    @property
    def state(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions and velocities of the body's coordinates, shape ``(11,)`` each; see :mod:`gaitshift`."""
        return self._batch.state(0)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Begins an episode; see the class for the options."""
        self._check_open()
        opening = reset_options(options)
        seed = None if seed is None else checked_seed(seed)
        super().reset(seed=seed)
        if seed is not None or not self._seeded:
            self._batch.seed(0, int(self.np_random.integers(2**63)) if seed is None else seed)
            self._seeded = True
        if self.render_mode == "human" and self.url is None:
            self.url = self._batch.watch("gaitshift/PassiveBiped-v0")
            print(f"watch it at {self.url}", file=sys.stderr)
            webbrowser.open(self.url)
        observation, info = self._batch.reset_one(0, *opening)
        self._due_s = time.monotonic()
        self._running = True
        return observation, info

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """Advances by one control period.

        After the end of an episode the body goes on moving until ``reset``; that is of no episode.

        Raises:
            ValueError: an action of another shape than ``(2,)``, or with a number that is not finite.
            gymnasium.error.ResetNeeded: no episode has begun.
            gymnasium.error.ClosedEnvironmentError: the environment is closed.
        """
        self._check_running("step")
        action = np.asarray(action, dtype=np.float64)
        if action.shape != (2,):
            raise ValueError(f"the action has the shape {action.shape}, but it must be (2,)")
        outcome = self._batch.step_one(*action.tolist())
        if self.render_mode == "human":
            self._wait()
        return outcome

    def render(self) -> NDArray[np.uint8] | None:
        """The body now, shape ``(330, 640, 3)``, uint8, drawn in software without a display; ``None`` in other modes.

        The right leg is vermilion, the left leg pale blue; arrows are the ground's forces. Command, speed and time are
        shown above.
        """
        if self.render_mode != "rgb_array":
            return None
        self._check_running("render")
        return self._batch.render([0], RENDER_WIDTH_PX)[0]

    def close(self) -> None:
        """Ends the use of the environment; may be called again."""
        self._closed = True
        self._batch.unwatch()
        self._running = False

    def _wait(self) -> None:
        """Until the control period is over on the clock, too; time that was lost is not made up for."""
        self._due_s += self._batch.task["control_period_s"]
        ahead_s = self._due_s - time.monotonic()
        if ahead_s > 0:
            time.sleep(ahead_s)
        else:
            self._due_s = time.monotonic()

    def _check_running(self, what: str) -> None:
        if not self._running:
            self._check_open()
            raise ResetNeeded(f"call reset before {what}")

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedEnvironmentError("the environment is closed; make another one")
