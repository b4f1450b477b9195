"""Contract: off the ground our equations of motion are MuJoCo's. MuJoCo is an independent implementation: it knows
bodies, joints and springs only from the exported MJCF and shares no line with ours. Accelerations agree to rounding;
with the same integrator and step whole motions do; against MuJoCo's Runge-Kutta at a fine step the difference of every
coordinate falls with our step, to first order, as our integrator's error should.

`pytest -s crates/gaitshift-python/tests/test_mujoco_flight.py` prints the figures of docs/mujoco.md.
"""

import mujoco
import numpy as np
import pytest

from biped_in_mujoco import NAMES, Biped, random_state

# The end stop's dissipation is what MJCF cannot express; without it the stops too are the same.
ELASTIC_STOPS = {"stop_dissipation_s_per_m": 0.0}
OTHER_BODY = {
    "leg_length_m": 1.1,
    "foot_arc_radius_m": 0.2,
    "hip_mass_kg": 31.0,
    "thigh_mass_kg": 4.0,
    "tibia_mass_kg": 5.0,
    "foot_mass_kg": 2.5,
    "hip_stiffness_nm_per_rad": 60.0,
    "hip_damping_nms_per_rad": 5.0,
    "k1_n_per_m": 4000.0,
    "k2_n_per_m": 9000.0,
    "k3_n_per_m": 15000.0,
    "c1_ns_per_m": 100.0,
    "c2_ns_per_m": 300.0,
    "actuator_force_n": 900.0,
    "hip_com_height_m": 0.17,
    "thigh_distance_m": 0.35,
    "tibia_distance_m": 0.7,
    "foot_distance_m": 1.0,
    "gravity_m_per_s2": 3.7,
}


@pytest.mark.parametrize("parameters", [{}, {"hip_com_height_m": 0.15}, OTHER_BODY], ids=["default", "trunk", "other"])
def test_accelerations_agree_to_rounding(parameters):
    biped = Biped(**parameters)
    rng = np.random.default_rng(1)
    worst = 0.0
    for _ in range(1000):
        positions, velocities = random_state(rng)
        ours, theirs = biped.accelerations(positions, velocities, rng.uniform(-1, 1, 2))
        worst = max(worst, np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs)))
    print(f"\naccelerations, 1000 random states: largest relative difference {worst:.1e}")
    assert worst < 1e-9


def test_elastic_end_stops_agree_to_rounding():
    biped = Biped(**ELASTIC_STOPS)
    rng = np.random.default_rng(2)
    for _ in range(200):
        positions, velocities = random_state(rng)
        positions[[4, 8]] = rng.uniform(0.1, 0.13, 2) * rng.choice([-1, 1], 2)
        ours, theirs = biped.accelerations(positions, velocities, rng.uniform(-1, 1, 2))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.max(np.abs(theirs)))


def test_the_dissipation_of_the_end_stops_is_the_only_difference_beyond_the_stroke():
    biped = Biped()
    rng = np.random.default_rng(3)
    positions, velocities = random_state(rng)
    positions[4], velocities[4] = 0.11, 0.5
    ours, theirs = biped.accelerations(positions, velocities, np.zeros(2))
    p = biped.parameters
    dissipative = p["stop_stiffness_n_per_m"] * 0.01 * p["stop_dissipation_s_per_m"] * 0.5
    # A force on the thigh alone, as an actuator's.
    corrected = biped.ours.accelerations(positions, velocities, np.array([dissipative, 0.0]))
    assert np.max(np.abs(ours - theirs)) > 1.0
    np.testing.assert_allclose(corrected, theirs, rtol=0, atol=1e-9 * np.max(np.abs(theirs)))


def commands(rng, periods):
    return rng.uniform(-1, 1, (periods, 2))


def ours_over_a_second(biped, state, series, rows=100):
    steps = round(1.0 / rows / biped.parameters["time_step_s"])
    path = []
    for command in series:
        positions, velocities, report = biped.ours.advance(*state, command, steps)
        assert not report["diverged"]
        state = positions, velocities
        path.append(positions)
    return np.array(path)


def theirs_over_a_second(biped, state, series, step_s, rows=100):
    biped.model.opt.timestep = step_s
    biped.put(*state)
    path = []
    for command in series:
        biped.data.ctrl[:] = command
        mujoco.mj_step(biped.model, biped.data, round(1.0 / rows / step_s))
        path.append(biped.data.qpos.copy())
    assert biped.data.ncon == 0
    return np.array(path)


def test_motions_agree_with_the_same_integrator_and_step():
    biped = Biped(**ELASTIC_STOPS)
    rng = np.random.default_rng(4)
    worst = np.zeros(11)
    for _ in range(20):
        state, series = random_state(rng), commands(rng, 100)
        ours = ours_over_a_second(biped, state, series)
        theirs = theirs_over_a_second(biped, state, series, biped.parameters["time_step_s"])
        worst = np.maximum(worst, np.max(np.abs(ours - theirs), axis=0))
    print("\nthe same integrator and step, 1 s, 20 random states, random commands: largest differences")
    for name, value in zip(NAMES, worst):
        print(f"  {name:9} {value:.1e}")
    assert np.max(worst) < 1e-8


def within_the_stroke(biped, rng):
    """A random state and random commands under which the thighs stay within their stroke, where motion is smooth: an
    impact on a stop is where a first-order step and the exact motion part for good."""
    while True:
        positions, velocities = random_state(rng)
        positions[[4, 8]] *= 0.5
        velocities[[4, 8]] *= 0.3
        biped.put(positions, velocities)
        series = []
        for _ in range(100):
            h, h_velocity = biped.data.qpos[[4, 8]], biped.data.qvel[[4, 8]]
            series.append(np.clip(-4.0 * h - 0.6 * h_velocity + rng.uniform(-0.3, 0.3, 2), -1, 1))
            biped.data.ctrl[:] = series[-1]
            mujoco.mj_step(biped.model, biped.data, 50)
            if np.max(np.abs(biped.data.qpos[[4, 8]])) > 0.095:
                break
        else:
            return (positions, velocities), series


def test_motions_converge_to_those_of_a_fine_step():
    rng = np.random.default_rng(5)
    motions = [within_the_stroke(Biped(), rng) for _ in range(20)]
    reference = Biped()
    reference.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    fine = [theirs_over_a_second(reference, *motion, 1e-4) for motion in motions]
    steps = [2e-4, 1e-4, 2e-5]
    worst = {}
    for step_s in steps:
        biped = Biped(time_step_s=step_s)
        differences = [
            np.max(np.abs(ours_over_a_second(biped, *motion) - path), axis=0)
            for motion, path in zip(motions, fine)
        ]
        worst[step_s] = np.max(differences, axis=0)
    print("\nagainst MuJoCo's Runge-Kutta at 0.1 ms, 1 s, 20 random states, random commands: largest differences")
    print("  step      " + "  ".join(f"{1e3 * step_s:.2f} ms" for step_s in steps))
    for k, name in enumerate(NAMES):
        print(f"  {name:9} " + "  ".join(f"{worst[step_s][k]:.1e}" for step_s in steps))
    assert np.all(worst[2e-4] < 0.02)
    assert np.all((worst[2e-4] / worst[1e-4] > 1.8) & (worst[2e-4] / worst[1e-4] < 2.2))
    assert np.all((worst[2e-4] / worst[2e-5] > 8.0) & (worst[2e-4] / worst[2e-5] < 12.5))
