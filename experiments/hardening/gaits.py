"""What the steps of many bipeds lack of the gait that is commanded, touchdown by touchdown."""

from __future__ import annotations

import numpy as np

WALK_BELOW, RUN_FROM = 0.1, 0.9  # s/m: |ω_v| of a walk, ω_v of a run
TOUCH_N, RELEASE_N = 20.0, 4.0  # 5 % and 1 % of the body weight, as where gaits are told apart
GAP = 2  # control periods; a shorter interruption of a contact is a bounce
ENOUGH = 4  # control periods of flight, or of double support, that a step should have; two are asked for
NONE_YET_N = 400.0  # about the body weight


class Steps:
    """The feet of many bipeds, one row each; forces in N, times in control periods."""

    def __init__(self, count: int) -> None:
        self.contact = np.ones((count, 2), bool)
        self.released = np.zeros((count, 2), int)  # since the force was above RELEASE_N
        # Since the last touchdown.
        self.flight = np.zeros(count, int)
        self.double_support = np.zeros(count, int)
        self.least_n = np.full(count, NONE_YET_N)  # the least force on both feet together
        self.last_foot = np.full(count, -1)

    def lack(self, force_n: np.ndarray, omega_v: np.ndarray, over: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which end a step by a touchdown in this control period, and what that step lacks: 0 where it has ENOUGH of its gait.

        A run lacks flight and has double support, a walk the reverse; either should not step twice with the same foot. Before
        there is flight it counts how far the ground is unloaded, and a little double support is less than much, so that
        there is always something to gain. Nothing is lacked between the two gaits' commands, at the first touchdown of
        an episode, which ends no step, or where an episode is over.
        """
        run, walk = omega_v >= RUN_FROM, np.abs(omega_v) < WALK_BELOW
        self.released = np.where(force_n > RELEASE_N, 0, self.released + 1)
        contact = (force_n > TOUCH_N) | (self.contact & (self.released < GAP))
        down = contact & ~self.contact
        landed = down.any(1) & ~over
        ends_step = landed & (self.last_foot >= 0)
        foot = np.where(down[:, 0], 0, 1)
        again = foot == self.last_foot
        flight = np.minimum(self.flight / ENOUGH, 1)
        of_run = 2 * (1 - flight) + np.minimum(self.least_n / 300, 1) + np.minimum(self.double_support / ENOUGH, 2)
        of_walk = flight + np.clip(1 - self.least_n / 200, 0, 1) + 0.5 * np.maximum(1 - self.double_support / ENOUGH, 0)
        lack = np.where(ends_step, run * (of_run + again) + walk * (of_walk + again), 0.0)

        self.contact = contact | over[:, None]
        self.flight = np.where(landed | over, 0, self.flight) + ((force_n < RELEASE_N).all(1) & ~over)
        self.double_support = np.where(landed, 0, self.double_support) + contact.all(1)
        self.least_n = np.minimum(np.where(landed, NONE_YET_N, self.least_n), force_n.sum(1))
        self.last_foot = np.where(landed, foot, self.last_foot)
        self.double_support[over], self.least_n[over], self.last_foot[over] = 0, NONE_YET_N, -1
        return ends_step & (run | walk), lack
