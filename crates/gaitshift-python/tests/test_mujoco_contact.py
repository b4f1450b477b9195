"""Contract: on the ground the exported body does what ours does, but for what the MJCF's comments say: static heights and
forces agree, and where damping and friction differ in form, motions differ by a known little.

`pytest -s crates/gaitshift-python/tests/test_mujoco_contact.py` prints the figures of docs/mujoco.md.
"""

import mujoco
import numpy as np
import pytest

from biped_in_mujoco import NAMES, Biped


def standing(biped, height_m=0.0, legs=(0.0, 0.0)):
    """At rest over the ground with the given leg angles, at this height between the lower sole and the ground."""
    positions = np.zeros(11)
    positions[3], positions[7] = legs
    positions[1] = biped.ours.lowest_hip_height(positions) + height_m
    return positions, np.zeros(11)


def ours_after(biped, state, command, seconds):
    steps = round(seconds / biped.parameters["time_step_s"])
    positions, velocities, report = biped.ours.advance(*state, np.asarray(command, float), steps)
    assert not report["diverged"]
    return positions, velocities, report


def ours_path(biped, state, command, seconds, rows):
    """States and mean forces at `rows` equal intervals."""
    path = []
    for _ in range(rows):
        *state, report = ours_after(biped, state, command, seconds / rows)
        path.append((*state, np.array([report["tangential_n"], report["normal_n"]]).T))
    return path


def theirs_path(biped, state, command, seconds, rows):
    biped.put(*state, command)
    path, steps = [], round(seconds / rows / biped.model.opt.timestep)
    for _ in range(rows):
        forces = np.zeros((2, 2))
        for _ in range(steps):
            mujoco.mj_step(biped.model, biped.data)
            forces += biped.foot_forces() / steps
        path.append((biped.data.qpos.copy(), biped.data.qvel.copy(), forces))
    return path


@pytest.mark.filterwarnings("ignore:.*in proportion")  # the other body
@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"contact_exponent": 1.5, "contact_stiffness": 2e6},
        {"hip_mass_kg": 35.0, "foot_mass_kg": 2.0, "hip_com_height_m": 0.1, "leg_length_m": 1.0},
    ],
    ids=["default", "Hertz", "other"],
)
def test_the_force_of_a_sphere_is_the_spring_and_damper_that_the_file_says(parameters):
    # One sphere below each foot, held at a depth: the constraint's force without the motion that would follow.
    biped = Biped(foot_sphere_count=1, **parameters)
    load_n = 0.5 * 9.81 * sum(biped.model.body_mass)
    p = biped.parameters
    depth_m = (load_n / p["contact_stiffness"]) ** (1 / p["contact_exponent"])
    for speed in (0.0, -0.2, 0.05):
        for share in (0.5, 1.0, 2.0):
            positions, velocities = standing(biped)
            positions[1] -= share * depth_m
            velocities[1] = speed
            biped.put(positions, velocities)
            mujoco.mj_forward(biped.model, biped.data)
            theirs = biped.foot_forces()[:, 1]
            spring = load_n * share
            damper = load_n * p["contact_dissipation_s_per_m"] * -speed
            # What remains is the constraint's added mass times the acceleration, 0.02 % of the foot's mass.
            np.testing.assert_allclose(theirs, max(0.0, spring + damper), rtol=2e-3)
            if share == 1.0 or (p["contact_exponent"] == 1.0 and speed == 0.0):
                ours = biped.ours.foot_contact(positions, velocities)[0]["normal_n"]
                np.testing.assert_allclose(theirs, ours, rtol=2e-3)


def test_it_stands_at_the_same_height_under_the_same_forces():
    biped = Biped()
    # On the retracted end stops: no constant actuator force holds the hip.
    state = standing(biped)
    state[0][[4, 8]] = -biped.parameters["stroke_m"]
    state[0][1] -= biped.parameters["stroke_m"]
    ours, _, _ = ours_after(biped, state, (0.0, 0.0), 4.0)
    biped.put(*state)
    theirs, _ = biped.move(4.0)
    forces = biped.foot_forces()[:, 1]
    weight = 9.81 * sum(biped.model.body_mass)
    at_end = [foot["normal_n"] for foot in biped.ours.foot_contact(ours, np.zeros(11))]
    print(f"\nstanding: hip at {ours[1]:.6f} m, in MuJoCo {theirs[1]:.6f} m")
    print(f"  normal forces {at_end} N, in MuJoCo {forces} N, half the weight {weight / 2:.4f} N")
    print("  differences: " + ", ".join(f"{n} {d:.1e}" for n, d in zip(NAMES, ours - theirs)))
    assert np.max(np.abs(ours - theirs)) < 2e-5
    np.testing.assert_allclose(forces, weight / 2, rtol=1e-3)
    np.testing.assert_allclose(at_end, weight / 2, rtol=1e-3)


@pytest.mark.parametrize("height_m", [0.01, 0.05])
def test_a_drop(height_m):
    biped = Biped()
    state, seconds, rows = standing(biped, height_m), 0.4, 400
    ours = ours_path(biped, state, (0.0, 0.0), seconds, rows)
    theirs = theirs_path(biped, state, (0.0, 0.0), seconds, rows)
    total = [sum(forces[:, 1].sum() for _, _, forces in path) * seconds / rows for path in (ours, theirs)]
    peak = [max(forces[:, 1].sum() for _, _, forces in path) for path in (ours, theirs)]
    lowest = [min(q[1] for q, _, _ in path) for path in (ours, theirs)]
    largest = max(np.max(np.abs(a[0] - b[0])) for a, b in zip(ours, theirs))
    print(f"\ndrop from {100 * height_m:g} cm, ours and MuJoCo: impulse over {seconds} s {total[0]:.2f}, {total[1]:.2f} N s;")
    print(f"  greatest force {peak[0]:.0f}, {peak[1]:.0f} N; lowest hip {lowest[0]:.4f}, {lowest[1]:.4f} m;")
    print(f"  largest difference of any coordinate {largest:.1e} (m, rad)")
    assert abs(total[0] - total[1]) < 0.02 * total[0]
    assert abs(lowest[0] - lowest[1]) < 0.003


def test_the_sole_rolls():
    # One leg bears the body, which moves forward over the sole; the other is drawn up. The end stops' dissipation, the
    # other difference, is left out.
    biped = Biped(stop_dissipation_s_per_m=0.0)
    p = biped.parameters
    positions, velocities = standing(biped, legs=(0.15, -0.5))
    velocities[0] = 0.9
    velocities[3] = -0.9 / p["leg_length_m"]
    positions[1] -= 0.003
    command = (0.45, -0.15)
    seconds, rows = 0.25, 50
    ours = ours_path(biped, (positions, velocities), command, seconds, rows)
    theirs = theirs_path(biped, (positions, velocities), command, seconds, rows)

    def rolled(path):
        """How far the arc's centre moved, and how far it would have by rolling without slip."""
        along = p["leg_length_m"] - p["foot_arc_radius_m"]

        def centre(q):
            psi = q[2] + q[3]
            return q[0] + (along + q[4] - q[5]) * np.sin(psi), psi

        (x0, psi0), (x1, psi1) = centre(positions), centre(path[-1][0])
        return x1 - x0, -p["foot_arc_radius_m"] * (psi1 - psi0)

    for name, path in (("ours", ours), ("MuJoCo", theirs)):
        moved, ideal = rolled(path)
        normal = np.array([forces[0, 1] for _, _, forces in path])
        print(f"\nrolling for {seconds} s, {name}: centre moved {1e3 * moved:.2f} mm, r Δψ {1e3 * ideal:.2f} mm; "
              f"mean normal force {normal.mean():.1f} N; hip speed {path[-1][1][0]:.4f} m/s")
        assert normal.min() > 0.0
        # Smoothed friction creeps: a few per cent of the way.
        assert abs(moved - ideal) < 0.1 * abs(ideal)
    largest = np.max(np.abs(np.array([a[0] - b[0] for a, b in zip(ours, theirs)])), axis=0)
    print("  largest differences: " + ", ".join(f"{n} {d:.1e}" for n, d in zip(NAMES, largest)))
    assert np.max(largest) < 0.01
