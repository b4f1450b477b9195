"""The body in MuJoCo, for the tests that compare it with ours."""

import mujoco
import numpy as np

import gaitshift

NAMES = ["x", "z", "theta"] + [f"{side}_{name}" for side in ("right", "left") for name in ("phi", "h", "d", "w")]


def random_state(rng, height_m=30.0):
    """A state far off the ground, thighs within their stroke."""
    positions = rng.uniform(-1, 1, 11) * [0, 0, 1, *2 * [1, 0.09, 0.05, 0.05]]
    positions[1] = height_m
    velocities = rng.uniform(-1, 1, 11) * [2, 2, 4, *2 * [4, 1, 1, 1]]
    return positions, velocities


class Biped:
    """Our body and MuJoCo's of the same parameters."""

    def __init__(self, **parameters):
        self.ours = gaitshift.Body(parameters)
        self.parameters = self.ours.parameters
        self.model = mujoco.MjModel.from_xml_string(self.ours.mjcf())
        self.data = mujoco.MjData(self.model)

    def put(self, positions, velocities, command=(0.0, 0.0)):
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = positions
        self.data.qvel[:] = velocities
        self.data.ctrl[:] = command

    def accelerations(self, positions, velocities, command):
        """Ours and MuJoCo's."""
        self.put(positions, velocities, command)
        mujoco.mj_forward(self.model, self.data)
        force = np.asarray(command) * self.parameters["actuator_force_n"]
        return self.ours.accelerations(positions, velocities, force), self.data.qacc.copy()

    def foot_forces(self):
        """Tangential and normal force of the ground on each foot in MuJoCo, shape (2, 2), in N."""
        forces = np.zeros((2, 2))
        wrench = np.zeros(6)
        feet = [self.model.body("right_foot").id, self.model.body("left_foot").id]
        for k, contact in enumerate(self.data.contact[: self.data.ncon]):
            mujoco.mj_contactForce(self.model, self.data, k, wrench)
            # Rows of the frame: normal and two tangents; the force acts on the second geom.
            force = contact.frame.reshape(3, 3).T @ wrench[:3]
            bodies = self.model.geom_bodyid[list(contact.geom)]
            foot = feet.index(bodies[1] if bodies[1] in feet else bodies[0])
            forces[foot] += (force if bodies[1] in feet else -force)[[0, 2]]
        return forces

    def move(self, seconds, record=None):
        """Lets MuJoCo move; `record(data)` is called after every step."""
        for _ in range(round(seconds / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)
            if record:
                record()
        return self.data.qpos.copy(), self.data.qvel.copy()
