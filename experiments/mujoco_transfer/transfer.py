"""Drives a controller in MuJoCo, without retraining, and analyses its motion with gaitshift.

    python experiments/mujoco_transfer/transfer.py --phases 10
    python experiments/mujoco_transfer/transfer.py --phases 10 --contact mujoco --out out/mujoco_contact
    python experiments/mujoco_transfer/transfer.py --phases 10 --contact mujoco --controller robust --out out/robust

With `--contact mujoco` the ground is MuJoCo's own default contact instead of the file's, which has the stiffness and the
damping of ours. The script needs the packages of crates/gaitshift-python/tests/requirements.txt and the program `gaitshift`
(--program, or on the PATH). MuJoCo loads the body as the exported MJCF; the policy is the exported ONNX file, run at the
control period of the controller. Each motion begins at the default start and is written as a recording; `gaitshift analyse`
applies the same rules to it as `gaitshift evaluate` and `gaitshift transition` do to ours.

The recording's energies are functions of the motion, by our formulas: with MuJoCo's contact `contact_energy_j` is what
ours would store at that depth, and `contact_dissipation_j` has the difference. Work and losses are computed as in our
integrator, from MuJoCo's forces: each force times the mean of the old and the new velocity of a step.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import onnxruntime

import gaitshift

COMMANDS = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5]
SIDES = ("right", "left")
# The recorded terms of the reward.
TERMS = [name.removeprefix("reward_") for name in gaitshift.COLUMNS if name.startswith("reward_")]


def with_default_contact(mjcf):
    """The MJCF with MuJoCo's default contact: without the `solref`, `solimp` and `impratio` that ours are translated into."""
    for attribute in ("solref", "solimp", "impratio"):
        mjcf, count = re.subn(rf'\s+{attribute}="[^"]*"', "", mjcf)
        if count != 1:
            sys.exit(f"the exported MJCF has `{attribute}` {count} times instead of once")
    return mjcf


class Biped:
    """The exported body in MuJoCo with the account of where its energy goes."""

    def __init__(self, mjcf, body, task):
        self.model = mujoco.MjModel.from_xml_string(mjcf)
        # A motion that diverges is to be seen, not reset.
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        self.data = mujoco.MjData(self.model)
        self.body = gaitshift.Body(body)
        self.p = body
        self.task = task
        self.steps = round(task["control_period_s"] / self.model.opt.timestep)
        feet = [self.model.body(f"{side}_foot").id for side in SIDES]
        self.foot_of_geom = np.array([feet.index(b) if b in feet else -1 for b in self.model.geom_bodyid])

    def observation(self, omega_v):
        mujoco.mj_forward(self.model, self.data)
        return np.append(self.data.sensordata, omega_v)

    def contact(self):
        """Normal and tangential force on each foot in N, power lost to friction and taken by normal forces in W."""
        data, forces = self.data, np.zeros((2, 2))
        if data.ncon == 0:
            return forces, 0.0, 0.0
        # Every contact is of the ground (first geom) with a sphere of a sole: three rows, normal and two tangents.
        rows = data.contact.efc_address
        touching = rows >= 0
        rows = rows[touching, None] + np.arange(3)
        force, speed = data.efc_force[rows], data.efc_vel[rows]
        feet = self.foot_of_geom[data.contact.geom[touching, 1]]
        # The tangents are x and y in some order and sign.
        tangents = data.contact.frame[touching][:, [3, 6]]
        np.add.at(forces[:, 0], feet, force[:, 0])
        np.add.at(forces[:, 1], feet, np.sum(force[:, 1:] * tangents, axis=1))
        return forces, -np.sum(force[:, 1:] * speed[:, 1:]), -np.sum(force[:, 0] * speed[:, 0])

    def period(self, command):
        """Advances by a control period: means of the forces, and amounts of work and loss."""
        p, model, data, dt = self.p, self.model, self.data, self.model.opt.timestep
        data.ctrl[:] = command
        force = np.clip(command, -1.0, 1.0) * p["actuator_force_n"]
        means, friction_w, normal_w = np.zeros((2, 2)), 0.0, 0.0
        velocities = np.empty((self.steps + 1, 11))
        velocities[0] = data.qvel
        for k in range(self.steps):
            mujoco.mj_step(model, data)
            velocities[k + 1] = data.qvel
            # After a step these are still the forces of its beginning, as in our recordings.
            forces, friction, normal = self.contact()
            means += forces
            friction_w += friction
            normal_w += normal
        old, mean = velocities[:-1], 0.5 * (velocities[:-1] + velocities[1:])
        work = force * mean[:, [4, 8]] * dt
        damper = 0.0
        for phi, d, w in ((3, 5, 6), (7, 9, 10)):
            relative, relative_mean = old[:, d] - old[:, w], mean[:, d] - mean[:, w]
            damper += p["hip_damping_nms_per_rad"] * old[:, phi] @ mean[:, phi]
            damper += p["c1_ns_per_m"] * old[:, d] @ mean[:, d] + p["c2_ns_per_m"] * relative @ relative_mean
        amounts = {
            "work": work.sum(),
            "positive": np.maximum(work, 0.0).sum(),
            "damper": damper * dt,
            "friction": friction_w * dt,
            "normal": normal_w * dt,
        }
        return means / self.steps, force, amounts


def start_of(controller):
    """The default start: positions and velocities."""
    env = gaitshift.PassiveBipedEnv(controller=controller)
    env.reset(options={"start": "default"})
    return env.state


def record(biped, session, start, profile, duration_s, name):
    """One motion in MuJoCo as a recording."""
    task, p, data = biped.task, biped.p, biped.data
    period_s = task["control_period_s"]
    mujoco.mj_resetData(biped.model, data)
    data.qpos[:], data.qvel[:] = start
    times, commands = zip(*profile)
    rows = []
    totals = dict.fromkeys(("work", "positive", "damper", "friction", "normal"), 0.0)
    energy = biped.body.energy(*start)
    energy_at_start = energy["contact"]
    ended_by = "time limit"

    def row(time_s, omega_v, action, force, means, terms):
        q, v = data.qpos, data.qvel
        values = {"time_s": time_s, "omega_v": omega_v, "x_m": q[0], "z_m": q[1], "theta_rad": q[2]}
        values |= {"x_velocity_m_per_s": v[0], "z_velocity_m_per_s": v[1], "theta_velocity_rad_per_s": v[2]}
        for side, k in zip(range(2), (3, 7)):
            s = SIDES[side]
            values |= {f"{s}_phi_rad": q[k], f"{s}_h_m": q[k + 1], f"{s}_d_m": q[k + 2], f"{s}_w_m": q[k + 3]}
            values |= {f"{s}_phi_velocity_rad_per_s": v[k]}
            values |= {f"{s}_{n}_velocity_m_per_s": v[k + 1 + i] for i, n in enumerate("hdw")}
            values |= {f"{s}_command": action[side], f"{s}_actuator_force_n": force[side]}
            values |= {f"{s}_normal_force_n": means[side][0], f"{s}_tangential_force_n": means[side][1]}
        values |= {"kinetic_energy_j": energy["kinetic"], "gravitational_energy_j": energy["gravitational"]}
        values |= {"hip_spring_energy_j": energy["hip_springs"], "leg_spring_energy_j": energy["leg_springs"]}
        values |= {"elastic_energy_j": energy["elastic"], "contact_energy_j": energy["contact"]}
        values |= {"stop_energy_j": energy["stops"]}
        # What normal forces took and what the contact does not store is lost; the end stops here lose nothing.
        lost = totals["friction"] + totals["normal"] - (energy["contact"] - energy_at_start)
        values |= {"actuator_work_j": totals["work"], "actuator_positive_work_j": totals["positive"]}
        values |= {"damper_dissipation_j": totals["damper"], "contact_dissipation_j": lost, "stop_dissipation_j": 0.0}
        values["reward"] = sum(terms.values())
        values |= {f"reward_{name}": terms[name] for name in TERMS}
        rows.append(values)

    omega_v = float(np.interp(0.0, times, commands))
    mujoco.mj_forward(biped.model, data)
    no_terms = dict.fromkeys(TERMS, 0.0)
    row(0.0, omega_v, np.zeros(2), np.zeros(2), biped.contact()[0], no_terms)
    for k in range(1, round(duration_s / period_s) + 1):
        omega_v = float(np.interp((k - 1) * period_s, times, commands))
        observation = biped.observation(omega_v).astype(np.float32)
        [[*action]] = session.run(["action"], {"observation": observation[None]})[0].astype(float)
        action = np.array(action)
        before = energy["total"]
        means, force, amounts = biped.period(action)
        if not (np.all(np.isfinite(data.qpos)) and np.all(np.abs(data.qvel) <= p["diverged_speed"])):
            ended_by = "diverged"
            break
        for key, value in amounts.items():
            totals[key] += value
        energy = biped.body.energy(data.qpos, data.qvel)
        terms = gaitshift.reward_terms(
            task,
            data.qpos,
            data.qvel,
            omega_v,
            energy_change_j=energy["total"] - before,
            friction_loss_j=amounts["friction"],
            positive_work_j=amounts["positive"],
        )
        row(k * period_s, omega_v, action, force, means, terms)
        end = task["termination"]
        if abs(data.qpos[2]) > end["pitch_limit_rad"]:
            ended_by = "pitch"
        elif data.qpos[1] < end["min_hip_height_m"]:
            ended_by = "hip height"
        if ended_by != "time limit":
            break
    legs = 2 * (p["thigh_mass_kg"] + p["tibia_mass_kg"] + p["foot_mass_kg"])
    metadata = {
        "control_period_s": period_s,
        "total_mass_kg": p["hip_mass_kg"] + legs,
        "gravity_m_per_s2": p["gravity_m_per_s2"],
        "leg_length_m": p["leg_length_m"],
        "body": p,
        "controller": f"{name}, in MuJoCo {mujoco.__version__}",
        "seed": 0,
        "fell": ended_by != "time limit",
        "ended_by": ended_by,
    }
    return gaitshift.Recording(metadata, {n: np.array([r[n] for r in rows]) for n in gaitshift.COLUMNS})


def figure(value, digits=2):
    return "–" if value is None else f"{value:.{digits}f}"


def print_steady(ours, theirs):
    print("Steady motions, ours | MuJoCo\n")
    print("| ω_v | gait | upright, s | speed, m/s | Froude number | cost of transport | step frequency, Hz |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    columns = {"survived_s": 1, "speed_m_per_s": 2, "froude": 2, "cost_of_transport": 3, "step_frequency_hz": 2}
    for a, b in zip(ours, theirs):
        both = [f"{a['gait']} \\| {b['gait']}"]
        both += [f"{figure(a[name], digits)} \\| {figure(b[name], digits)}" for name, digits in columns.items()]
        print(f"| {b['omega_v']:g} | " + " | ".join(both) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--controller", help="controller file or name [default: the shipped controller]")
    parser.add_argument("--program", default="gaitshift", help="the program gaitshift")
    parser.add_argument("--out", type=Path, default=Path("out/mujoco_transfer"), help="folder for recordings and report")
    parser.add_argument("--duration-s", type=float, default=20.0, help="duration of each steady motion in s")
    parser.add_argument("--change-after-s", type=float, default=10.0, help="when the command changes, in s")
    parser.add_argument("--phases", type=int, default=1, help="begin each change at so many phases of our stride")
    parser.add_argument("--contact", choices=("ours", "mujoco"), default="ours", help="as exported, or MuJoCo's default")
    parser.add_argument("--changes-only", action="store_true", help="leave the steady motions out")
    arguments = parser.parse_args()
    out = arguments.out
    out.mkdir(parents=True, exist_ok=True)

    def program(*words):
        done = subprocess.run([arguments.program, *map(str, words)], stdout=subprocess.PIPE)
        if done.returncode:
            sys.exit(f"`{arguments.program} {' '.join(map(str, words))}` failed")
        return done.stdout

    chosen = ["--controller", arguments.controller] if arguments.controller else []
    controller = gaitshift.Controller.load(arguments.controller) if chosen else gaitshift.Controller.shipped()
    # The exported MJCF of the very body the controller was trained on.
    mjcf = gaitshift.Body(controller.body).mjcf(controller.task)
    if arguments.contact == "mujoco":
        mjcf = with_default_contact(mjcf)
    (out / "body.xml").write_text(mjcf)
    (out / "policy.onnx").write_bytes(program("export", "onnx", *chosen))
    biped = Biped(mjcf, controller.body, controller.task)
    session = onnxruntime.InferenceSession(str(out / "policy.onnx"), providers=["CPUExecutionProvider"])
    start = start_of(controller)

    steady = {}
    commands_held = [] if arguments.changes_only else COMMANDS
    for omega_v in commands_held:
        path = out / f"mujoco_omega_v_{omega_v:g}.csv"
        profile = [(0.0, omega_v)]
        record(biped, session, start, profile, arguments.duration_s, controller.name).write_csv(path)
        steady[omega_v] = path
    ours, theirs = [], []
    if steady:
        theirs = json.loads(program("analyse", "--json", *steady.values()))["rows"]
        listed = ",".join(f"{omega_v:g}" for omega_v in steady)
        words = ["--omega-v", listed, "--duration-s", arguments.duration_s, *chosen]
        ours = json.loads(program("evaluate", "--json", *words))["rows"]
        print_steady(ours, theirs)

    changes = []
    ramp = 0.4
    print("\nChanges of gait in 0.4 s, ours | MuJoCo\n")
    print("| change | begun at, s | gait before | gait after | upright, s | speed before, m/s | speed after, m/s |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for first, last in ((0.0, 3.0), (3.0, 0.0)):
        steps = json.loads(program("evaluate", "--json", "--omega-v", first, *chosen))["rows"][0]["step_frequency_hz"]
        stride_s = 2.0 / steps if steps else 1.0
        for phase in range(arguments.phases):
            at = round(arguments.change_after_s + stride_s * phase / arguments.phases, 2)
            path = out / f"mujoco_{first:g}_to_{last:g}_at_{at:g}_s.csv"
            profile = [(at, first), (at + ramp, last)]
            recording = record(biped, session, start, profile, at + ramp + 10.0, controller.name)
            recording.write_csv(path)
            b = recording.transition_summary(at, at + ramp)
            words = ["--from", first, "--to", last, "--start-s", at, "--ramp-s", ramp, *chosen]
            a = json.loads(program("transition", "--json", *words))
            changes.append({"from": first, "to": last, "start_s": at, "ours": a, "mujoco": b})
            both = [f"{a[name]} \\| {b[name]}" for name in ("gait_before", "gait_after")]
            both += [
                f"{figure(a[name])} \\| {figure(b[name])}"
                for name in ("survived_s", "speed_before_m_per_s", "speed_after_m_per_s")
            ]
            print(f"| {first:g} → {last:g} | {at:g} | " + " | ".join(both) + " |", flush=True)

    report = {
        "controller": controller.name,
        "provenance": controller.provenance,
        "mujoco": mujoco.__version__,
        "contact": arguments.contact,
        "steady": [{"omega_v": w, "ours": a, "mujoco": b} for w, a, b in zip(steady, ours, theirs)],
        "changes": changes,
    }
    (out / "report.json").write_text(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
