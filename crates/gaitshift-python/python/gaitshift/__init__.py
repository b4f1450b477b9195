"""A planar biped with passive hips that walks and runs on one command.

- ``gymnasium.make("gaitshift/PassiveBiped-v0")`` and ``gymnasium.make_vec(...)``: the task as an environment;
  see :class:`gaitshift.env.PassiveBipedEnv` and :class:`gaitshift.vector.PassiveBipedVectorEnv`.
- :class:`Controller`: a trained controller, to act, to record motions, to export as ONNX.
- :func:`train` and :class:`Run`: training runs and their folders.
- :class:`SAC`: the learner alone, for any environment with continuous actions.
- :class:`Recording`: a recorded motion as arrays, with the analysis of gaits.
- :class:`Body`: the mechanism alone: accelerations, integration, energies, MJCF.

SI units and radians everywhere. Coordinates of the body, 11 numbers, in this order: ``x, z, theta``, then
``phi, h, d, w`` of the right leg and of the left one: hip axis (forward, up), pitch, hip angle, displacement of the
thigh down the leg, compression between thigh and foot, and between thigh and tibia. Angles are positive when they
swing a leg forward.
"""

from gymnasium.envs.registration import register

from gaitshift._motion import Controller, Recording
from gaitshift._native import (
    COLUMNS,
    DETAILS,
    INFO_NAMES,
    OBSERVATION_NAMES,
    OBSERVATION_SCALE,
    Body,
    __version__,
    reward_terms,
)
from gaitshift._training import Evaluation, Progress, Run, train
from gaitshift.env import PassiveBipedEnv
from gaitshift.sac import SAC
from gaitshift.vector import PassiveBipedVectorEnv

__all__ = [
    "COLUMNS",
    "DETAILS",
    "INFO_NAMES",
    "OBSERVATION_NAMES",
    "OBSERVATION_SCALE",
    "SAC",
    "Body",
    "Controller",
    "Evaluation",
    "PassiveBipedEnv",
    "PassiveBipedVectorEnv",
    "Progress",
    "Recording",
    "Run",
    "__version__",
    "reward_terms",
    "train",
]

# The task has a time limit of its own (`task.termination.time_limit_s`), so no wrapper counts steps.
register(
    id="gaitshift/PassiveBiped-v0",
    entry_point="gaitshift.env:PassiveBipedEnv",
    vector_entry_point="gaitshift.vector:PassiveBipedVectorEnv",
)
