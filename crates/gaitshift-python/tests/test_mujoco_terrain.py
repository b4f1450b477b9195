"""Contract: on slopes and steps the body does what it does in MuJoCo on a plane and boxes, as far as the two contacts agree on
flat ground (test_mujoco_contact.py): it stands on a slope at the same height and under the same forces, and meets a step alike.

`pytest -s crates/gaitshift-python/tests/test_mujoco_terrain.py` prints the figures of docs/mujoco.md.
"""

import mujoco
import numpy as np
import pytest

import gaitshift

from biped_in_mujoco import NAMES, Biped


class Grounded(Biped):
    """Both bodies on ground that is not flat."""

    def __init__(self, terrain, **parameters):
        self.ours = gaitshift.Body(parameters, terrain=terrain)
        self.parameters = self.ours.parameters
        self.model = mujoco.MjModel.from_xml_string(self.ours.mjcf())
        self.data = mujoco.MjData(self.model)

    def at(self, x, legs=(0.0, 0.0), retracted=False):
        """At rest, the lower sole touching the ground."""
        positions = np.zeros(11)
        positions[0] = x
        positions[3], positions[7] = legs
        if retracted:
            positions[[4, 8]] = -self.parameters["stroke_m"]
        positions[1] = self.ours.lowest_hip_height(positions)
        return positions, np.zeros(11)

    def moved(self, state, seconds):
        steps = round(seconds / self.parameters["time_step_s"])
        positions, velocities, report = self.ours.advance(*state, np.zeros(2), steps)
        assert not report["diverged"]
        return positions, velocities


@pytest.mark.parametrize("slope", [0.05, -0.08, 0.15])
def test_a_foot_on_a_slope_is_pressed_alike(slope):
    # Held in place on single spheres, so that what is compared is the contact alone.
    biped = Grounded({"slope_rad": slope}, foot_sphere_count=1, foot_arc_half_angle_rad=0.1)
    p = biped.parameters
    load_n = 0.5 * 9.81 * sum(biped.model.body_mass)
    depth_m = load_n / p["contact_stiffness"]
    positions, velocities = biped.at(0.3)
    positions[0] += depth_m * np.sin(slope)
    positions[1] -= depth_m * np.cos(slope)
    biped.put(positions, velocities)
    mujoco.mj_forward(biped.model, biped.data)
    theirs = biped.foot_forces()
    ours = [[foot["tangential_n"], foot["normal_n"]] for foot in biped.ours.foot_contact(positions, velocities)]
    along = np.array([np.cos(slope), np.sin(slope)])
    out = np.array([-np.sin(slope), np.cos(slope)])
    np.testing.assert_allclose(np.array(ours) @ out, load_n, rtol=1e-6)
    np.testing.assert_allclose(np.array(ours) @ along, 0.0, atol=1e-6 * load_n)
    np.testing.assert_allclose(theirs @ out, load_n, rtol=2e-3)


def test_it_stands_on_a_slope_alike():
    # On its own soles it would roll away. On ones as round as the leg is long it is a roly-poly, which stands where its centre
    # of mass is over the contact: leaning up the slope.
    slope, r = 0.06, 0.8
    biped = Grounded({"slope_rad": slope}, foot_arc_radius_m=r, foot_sphere_count=150, hip_damping_nms_per_rad=50.0)
    p = biped.parameters
    total = sum(biped.model.body_mass)
    moment = sum(p[f"{part}_mass_kg"] * (p[f"{part}_distance_m"] - p["stroke_m"]) for part in ("thigh", "tibia", "foot"))
    lean = np.arcsin(r * np.sin(slope) / (2 * moment / total + p["stroke_m"]))
    state = biped.at(0.0, legs=(lean, lean), retracted=True)
    ours, velocities = biped.moved(state, 12.0)
    biped.put(*state)
    biped.move(11.9)
    forces, count = np.zeros((2, 2)), round(0.1 / biped.model.opt.timestep)

    def record():
        # Many stiff dampers side by side: the single step's friction is noise, its mean is not.
        forces[:] += biped.foot_forces() / count

    theirs, _ = biped.move(0.1, record)
    weight = 9.81 * total
    here = biped.ours.foot_contact(ours, velocities)
    at_end = np.array([[foot["tangential_n"], foot["normal_n"]] for foot in here])
    print(f"\nstanding on {slope} rad: hip at {ours[1]:.5f} m, in MuJoCo {theirs[1]:.5f} m")
    print(f"  forces on the feet (forward, up) {at_end.round(1).tolist()} N, in MuJoCo {forces.round(1).tolist()} N")
    print("  differences: " + ", ".join(f"{n} {d:.1e}" for n, d in zip(NAMES, ours - theirs)))
    # Smoothed friction creeps down the slope, in MuJoCo less the more spheres touch.
    creep_m = 12.0 * p["friction_smoothing_m_per_s"] * np.tan(slope) / p["friction"]
    assert abs(ours[0] - theirs[0]) < 1.1 * creep_m
    assert np.max(np.abs(ours - theirs)[1:]) < 0.01
    assert np.max(np.abs(velocities)) < 0.02 and abs(ours[0]) < 0.1, "it stands"
    for sums in (forces.sum(axis=0), at_end.sum(axis=0)):
        np.testing.assert_allclose(sums, [0.0, weight], atol=0.01 * weight)


@pytest.mark.parametrize("height", [0.03, -0.03])
def test_it_meets_a_step_alike(height):
    # The right leg comes down on the step's edge or beyond it, moving forward.
    biped = Grounded({"steps": [{"height_m": height, "at_m": 0.2}]})
    positions, velocities = biped.at(0.0, legs=(0.3, -0.2))
    positions[1] += 0.005
    velocities[0] = 0.8
    seconds, rows = 0.15, 30
    impulse = np.zeros((2, 2))
    ours, state = [], (positions, velocities)
    for _ in range(rows):
        steps = round(seconds / rows / biped.parameters["time_step_s"])
        *state, report = biped.ours.advance(*state, np.zeros(2), steps)
        impulse[0] += np.array([sum(report["tangential_n"]), sum(report["normal_n"])]) * seconds / rows
        ours.append(state[0])
    biped.put(positions, velocities)

    def record():
        impulse[1] += biped.foot_forces().sum(axis=0) * biped.model.opt.timestep

    theirs = []
    for _ in range(rows):
        theirs.append(biped.move(seconds / rows, record)[0])
    largest = np.max(np.abs(np.array(ours) - np.array(theirs)), axis=0)
    print(f"\nstep of {height} m: impulse (forward, up) {impulse[0].round(2)}, in MuJoCo {impulse[1].round(2)} N s")
    print("  largest differences: " + ", ".join(f"{n} {d:.1e}" for n, d in zip(NAMES, largest)))
    assert impulse[0][1] > 5.0
    np.testing.assert_allclose(impulse[0], impulse[1], atol=0.05 * np.linalg.norm(impulse[1]))
    assert np.max(largest) < 0.02


def test_the_ground_has_the_height_of_the_boxes():
    terrain = {
        "slope_rad": 0.05,
        "slope_from_m": 1.0,
        "steps": [{"height_m": 0.04, "at_m": 0.5}, {"height_m": -0.06, "at_m": 2.0}],
        "uneven": {"height_m": 0.02, "from_m": 2.5, "length_m": 3.0},
    }
    biped = Grounded(terrain)
    mujoco.mj_forward(biped.model, biped.data)
    hit = np.zeros(1, dtype=np.int32)
    for x in np.arange(-1.03, 8.0, 0.11):
        # The fourth argument leaves out the body.
        own = biped.model.body("hip").id
        down = np.array([0.0, 0.0, -1.0])
        origin = np.array([x, 2.0, 3.0])
        distance = mujoco.mj_ray(biped.model, biped.data, origin, down, None, 1, own, hit)
        assert abs(3.0 - distance - biped.ours.ground_height(x)) < 1e-9, x


def test_the_programs_ground_is_the_librarys(program):
    text = program("export", "mjcf", "--slope", "0.05rad@2", "--step-up", "0.02", "--uneven", "0.01")
    terrain = {
        "slope_rad": 0.05,
        "slope_from_m": 2.0,
        "steps": [{"height_m": 0.02, "at_m": 3.0}],
        "uneven": {"height_m": 0.01},
    }
    model = mujoco.MjModel.from_xml_string(text.decode())
    # The program exports the body of the shipped controller.
    body = gaitshift.Body(gaitshift.Controller.shipped().body, terrain=terrain)
    ours = mujoco.MjModel.from_xml_string(body.mjcf())
    np.testing.assert_array_equal(model.geom_pos, ours.geom_pos)
    np.testing.assert_array_equal(model.geom_size, ours.geom_size)
    # A ray from above meets the ground at its height, before the slope and on it.
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for x in (-1.0, 0.5, 2.6, 4.13, 17.3):
        hit = np.zeros(1, dtype=np.int32)
        distance = mujoco.mj_ray(model, data, np.array([x, 0.0, 5.0]), np.array([0.0, 0.0, -1.0]), None, 1, -1, hit)
        assert 5.0 - distance == pytest.approx(body.ground_height(x), abs=1e-6), x
