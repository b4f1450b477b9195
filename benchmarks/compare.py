"""The learner and the simulator beside their peers, measured in the same run, one after the other in turn.

Every contestant is a process of its own that stays alive, pinned to one core or two. In each round all are asked in
turn, never two at once, and each round begins with another one, so that what else happens to the machine happens to
all. Tables are Markdown: median (least to greatest) over the rounds; a ratio is ours to the peer's of the same round,
then likewise.

updates    updates per second of Soft Actor-Critic: ours, JAX, Stable-Baselines3; OpenBLAS's matrix product
simulator  environment steps per second: ours, MuJoCo on the exported body at the same time step and at 1 ms
memory     resident memory of our learner with a replay buffer of a million transitions

MFLOP of an update are those of its dense products (`flop_per_update` in this file counts them), the same number for all
contestants, whatever else they compute. The share of the peak is of the matrix product's rate in the same rounds. We
leave out products with the zeros behind a rectifier, so ours can exceed the peak; "zeros counted" is the same program
with all of them, the same networks to the bit.
"""

import argparse
import contextlib
import importlib.metadata
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from datetime import datetime, timezone
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PEERS = ROOT / "benchmarks" / "peers"
REQUIREMENTS = "benchmarks/requirements.txt"
PACKAGES = ("gymnasium", "jax", "jaxlib", "mujoco", "numpy", "optax", "stable-baselines3", "torch")
GROUPS = ("updates", "simulator", "memory")
BATCH, OBSERVATIONS, ACTIONS = 256, 14, 2
OURS = "gaitshift"
DENSE = "gaitshift, zeros counted"
PEAK = "matrix product (OpenBLAS)"
# Compiling takes a contestant seconds, answering what it was asked for and a little more.
START_LIMIT_S, ANSWER_LIMIT_S = 300.0, 120.0
# A one-thread contestant that had less than this share of its core was disturbed.
QUIET_SHARE = 0.97


class Failure(Exception):
    """What cannot go on, with its remedy; printed without a traceback."""


def flop_per_update(hidden):
    """FLOP of one update with two hidden layers of `hidden` units, counting 2 for each multiply-add.

    Zeros are counted like other numbers. Only the products with the weights count, at their real sizes: no bias, no
    activation, no Adam, no sampling. Let A and C be the numbers of weights of the actor and of one critic. For each row
    of the batch:

        actor at s'                                      A
        both target critics at (s', a')                 2 C
        both critics at (s, a)                          2 C
        their weights' gradients                        2 C
        their gradients back to the first hidden layer  2 (C - first layer); nobody asks for those of the inputs
        actor at s                                       A
        both critics at (s, pi(s))                      2 C
        gradient of the smaller critic in the action    (C - first layer) + actions x hidden; the other one's is 0
        actor's weights' gradients                       A
        its gradients back to the first hidden layer    (A - first layer)

    A library that differentiates both critics in the actor's loss, or computes gradients nobody uses, does more.
    """
    actor_first, critic_first = OBSERVATIONS * hidden, (OBSERVATIONS + ACTIONS) * hidden
    actor = actor_first + hidden * hidden + hidden * 2 * ACTIONS
    critic = critic_first + hidden * hidden + hidden
    critics_learn = 2 * critic + 2 * critic + 2 * (critic - critic_first)
    actor_learns = actor + 2 * critic + (critic - critic_first + ACTIONS * hidden) + actor + (actor - actor_first)
    return 2 * BATCH * (actor + 2 * critic + critics_learn + actor_learns)


class Contestant:
    """A process that works when told to."""

    def __init__(self, name, command, threads, remedy):
        cores = sorted(os.sched_getaffinity(0))
        if len(cores) < threads:
            raise Failure(f"{name} is to use {threads} threads, but this process may use {len(cores)} cores only; "
                          f"give --threads {len(cores)}")
        self.name, self.command, self.threads, self.remedy = name, [str(part) for part in command], threads, remedy
        self.rounds = []
        self.stderr = tempfile.TemporaryFile()  # noqa: SIM115 (open as long as the process)
        # The last cores: the first one handles most interrupts.
        try:
            self.process = subprocess.Popen(
                self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.stderr, text=True,
                preexec_fn=lambda: os.sched_setaffinity(0, cores[-threads:]),
            )
        except OSError as error:
            raise Failure(f"{name} cannot be started: {error}\n{remedy}") from error
        answer = self._read(START_LIMIT_S)
        if answer != "ready":
            raise self._failure(f"printed {answer!r} instead of 'ready'" if answer else "did not start")

    def _read(self, limit_s):
        """The next line, empty when the process has ended or is ended here because it takes too long."""
        alarm = threading.Timer(limit_s, self.process.kill)
        alarm.start()
        try:
            return self.process.stdout.readline().strip()
        finally:
            alarm.cancel()

    def _failure(self, what):
        try:
            code = self.process.wait(1.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait()
        self.stderr.seek(0)
        said = self.stderr.read().decode(errors="replace").strip() or "(nothing)"
        return Failure(f"{self.name} {what} (exit code {code})\n  command: {' '.join(self.command)}\n"
                       f"  it wrote to standard error:\n\n{said}\n\n{self.remedy}")

    def _processor_s(self):
        """Processor time of all its threads so far, to a hundredth of a second."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def measure(self, seconds):
        before = self._processor_s()
        try:
            print(seconds, file=self.process.stdin, flush=True)
            answer = json.loads(self._read(seconds + ANSWER_LIMIT_S))
            rate = answer["count"] / answer["seconds"]
        except (OSError, ValueError, KeyError, ZeroDivisionError) as error:
            raise self._failure(f"did not answer as it should ({error!r})") from error
        self.rounds.append(
            {"count": answer["count"], "seconds": answer["seconds"], "processor_s": self._processor_s() - before}
        )
        return rate

    def finish(self):
        """Ends its input and returns what it printed last, if anything."""
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        rest = self._read(ANSWER_LIMIT_S)
        if self.process.wait() != 0:
            raise self._failure("failed at the end")
        return json.loads(rest) if rest else None

    def rates(self):
        return [entry["count"] / entry["seconds"] for entry in self.rounds]

    def close(self):
        """Ends it at once; does nothing to one that has ended."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
        self.stderr.close()


def run_group(contestants, rounds, seconds):
    """Starts `(name, command, threads, remedy)` each, measures them in turn and returns them, ended."""
    with contextlib.ExitStack() as stack:
        running = []
        for contestant in contestants:
            progress(f"starting {contestant[0]}")
            running.append(Contestant(*contestant))
            stack.callback(running[-1].close)
        for index in range(rounds):
            progress(f"round {index + 1} of {rounds}")
            first = index % len(running)
            for contestant in running[first:] + running[:first]:
                # Threads of OpenMP and OpenBLAS spin for a while after their work; the next one is not to feel it.
                time.sleep(0.2)
                contestant.measure(seconds)
        for contestant in running:
            contestant.last = contestant.finish()
    return running


def progress(text):
    print(text, file=sys.stderr, flush=True)


def spread(values, digits=0):
    """Median (least to greatest)."""
    median, least, greatest = (
        f"{value:,.{digits}f}" for value in (statistics.median(values), min(values), max(values))
    )
    return f"{median} ({least} to {greatest})"


def ratios(ours, peer):
    return [mine / its for mine, its in zip(ours.rates(), peer.rates())]


def table(header, rows):
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def remedy_pip():
    return (f"Remedy: {sys.executable} -m pip install -r {REQUIREMENTS}\n"
            "or run this program with the Python of an environment where that was done.")


REMEDY_CARGO = "Remedy: see that `cargo build --release` works in this checkout."


def build(package, kind, name):
    """Builds an example or the program and returns where cargo put it."""
    command = ["cargo", "build", "--release", "--message-format=json-render-diagnostics", "-p", package, kind, name]
    progress(" ".join(command))
    try:
        done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    except FileNotFoundError as error:
        raise Failure("cargo is not installed or not on the path; see https://rustup.rs") from error
    if done.returncode != 0:
        raise Failure(f"`{' '.join(command)}` failed; what it said stands above")
    for line in done.stdout.splitlines():
        message = json.loads(line)
        if message["reason"] == "compiler-artifact" and message["target"]["name"] == name and message["executable"]:
            return message["executable"]
    raise Failure(f"`{' '.join(command)}` named no executable {name}")


def measure_updates(arguments, report):
    program = arguments.update_rate or build("gaitshift-sac", "--example", "update_rate")
    rows, scaling, results = {threads: [] for threads in arguments.threads}, [], []
    for hidden in arguments.hidden:
        progress(f"updates, {hidden} units")
        # All numbers of threads in the same rounds, so that they can be compared with each other too.
        contestants = []
        for threads in arguments.threads:
            sizes = ["--hidden", hidden, "--threads", threads]
            contestants += [
                (OURS, [program, *sizes], threads, REMEDY_CARGO),
                (DENSE, [program, *sizes, "--count-zeros"], threads, REMEDY_CARGO),
                ("JAX", [sys.executable, PEERS / "jax_sac.py", *sizes], threads, remedy_pip()),
                ("Stable-Baselines3", [sys.executable, PEERS / "sb3_sac.py", *sizes], threads, remedy_pip()),
                (PEAK, [sys.executable, PEERS / "sgemm_peak.py", "--threads", threads], threads, remedy_pip()),
            ]
        found = run_group(contestants, arguments.rounds, arguments.seconds)
        flop, fewest = flop_per_update(hidden), found[0]
        for threads in arguments.threads:
            ours, *peers, peak = [contestant for contestant in found if contestant.threads == threads]
            for contestant in (ours, *peers):
                per_round = [1e-9 * flop * rate for rate in contestant.rates()]
                shares = [100 * rate / most for rate, most in zip(per_round, peak.rates())]
                rows[threads].append([
                    f"{hidden}²", f"{1e-6 * flop:.1f}", contestant.name, spread(contestant.rates()),
                    f"{statistics.median(per_round):.1f}", f"{statistics.median(shares):.0f} %",
                    "" if contestant is ours else spread(ratios(ours, contestant), 2),
                ])
            rows[threads].append([f"{hidden}²", "", PEAK, "", spread(peak.rates(), 1), "", ""])
            results.append({"hidden": hidden, "threads": threads, "mflop_per_update": 1e-6 * flop,
                            "contestants": [raw(contestant) for contestant in (ours, *peers, peak)]})
            if ours is not fewest:
                scaling.append([f"{hidden}²", fewest.threads, threads, spread(ratios(ours, fewest), 2)])
    for threads in arguments.threads:
        report.section(
            f"Updates, {'one thread' if threads == 1 else f'{threads} threads'}",
            f"Batch {BATCH}, {OBSERVATIONS} observations, {ACTIONS} actions, two hidden layers.",
            table(["hidden", "MFLOP/update", "contestant", "updates/s", "GFLOP/s", "of the peak", "ours/peer"],
                  rows[threads]),
        )
    if scaling:
        report.section("Updates, more threads", f"{OURS}, in the same rounds as above.",
                       table(["hidden", "threads", "and", "times as many updates/s"], scaling))
    report.data["updates"] = results


def measure_simulator(arguments, report):
    program = arguments.step_rate or build("gaitshift-task", "--example", "step_rate")
    with tempfile.TemporaryDirectory() as folder:
        mjcf = arguments.mjcf
        if mjcf is None:
            mjcf = Path(folder) / "biped.xml"
            export = [build("gaitshift", "--bin", "gaitshift"), "export", "mjcf", "--out", str(mjcf)]
            if subprocess.run(export).returncode != 0:
                raise Failure(f"`{' '.join(export)}` failed; what it said stands above")
        mujoco = [sys.executable, PEERS / "mujoco_steps.py", mjcf]
        ours, *peers = run_group([
            (OURS, [program], 1, REMEDY_CARGO),
            ("MuJoCo, the same time step", mujoco, 1, remedy_pip()),
            ("MuJoCo, 1 ms, implicitfast", [*mujoco, "--timestep", 0.001], 1, remedy_pip()),
        ], arguments.rounds, arguments.seconds)
    report.section(
        "Environment steps, one thread",
        "A step is one control period of 0.01 s under random forces, with the observation; resets included.",
        table(["contestant", "steps/s", "ours/peer"], [
            [contestant.name, spread(contestant.rates()),
             "" if contestant is ours else spread(ratios(ours, contestant), 2)]
            for contestant in (ours, *peers)
        ]),
    )
    report.data["simulator"] = {"contestants": [raw(contestant) for contestant in (ours, *peers)]}


def measure_memory(arguments, report):
    program = arguments.update_rate or build("gaitshift-sac", "--example", "update_rate")
    transitions, rows, results = 1_000_000, [], []
    for hidden in arguments.hidden:
        command = [program, "--hidden", hidden, "--threads", 1, "--transitions", transitions]
        [ours] = run_group([(OURS, command, 1, REMEDY_CARGO)], 1, min(arguments.seconds, 1.0))
        try:
            peak, replay = int(ours.last["peak_resident_bytes"]), int(ours.last["replay_bytes"])
        except (TypeError, KeyError) as error:
            raise Failure(f"{program} did not tell its peak_resident_bytes and replay_bytes at its end") from error
        mib = 2.0**20
        rows.append([f"{hidden}²", f"{replay / mib:,.1f}", f"{peak / mib:,.1f}", f"{(peak - replay) / mib:,.1f}",
                     f"{peak / replay:.3f}"])
        results.append({"hidden": hidden, "transitions": transitions, **ours.last})
    report.section(
        f"Memory with {transitions:,} transitions",
        f"The learner alone, batch {BATCH}, one thread; MiB of 2^20 bytes. The peak is of resident memory.",
        table(["hidden", "replay buffer, MiB", "peak, MiB", "beyond the buffer, MiB", "peak/buffer"], rows),
    )
    report.data["memory"] = results


def without_folders(part):
    """A part of a command as it may be published: a peer's script by its path in the repository, other files by name."""
    path = Path(part)
    return str(path.relative_to(ROOT)) if PEERS in path.parents else path.name


def raw(contestant):
    command = [without_folders(part) for part in contestant.command]
    return {"name": contestant.name, "command": command, "threads": contestant.threads, "rounds": contestant.rounds}


def output(*command):
    """What a command prints, or nothing where there is no such command."""
    try:
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


def version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def describe_machine():
    processor = {}
    for line in output("lscpu").splitlines():
        key, _, value = line.partition(":")
        processor[key.strip()] = value.strip()
    return {
        "processor": " ".join(processor.get(key, "") for key in ("Model name", "CPU family", "Model")).strip(),
        "lscpu": processor,
        "cores": len(os.sched_getaffinity(0)),
        "kernel": platform.release(),
        "date": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "load_average_before": os.getloadavg(),
        "commit": output("git", "rev-parse", "HEAD"),
        "uncommitted_changes": bool(output("git", "status", "--porcelain")),
        "rustc": output("rustc", "--version"),
        "python": platform.python_version(),
        "packages": {package: version(package) for package in PACKAGES},
    }


class Report:
    """Tables, printed as they come, and raw figures."""

    def __init__(self, arguments):
        self.data = {"machine": describe_machine(), "rounds": arguments.rounds, "seconds": arguments.seconds}
        machine = self.data["machine"]
        commit = machine["commit"][:9] + (" with changes" if machine["uncommitted_changes"] else "")
        packages = (f"{name} {number}" for name, number in machine["packages"].items() if number)
        facts = [machine["processor"], f"{machine['cores']} cores", f"Linux {machine['kernel']}", machine["date"],
                 f"commit {commit}", machine["rustc"], *packages]
        print(f"{', '.join(filter(None, facts))}. Median (least to greatest) of {arguments.rounds} rounds of "
              f"{arguments.seconds:g} s.\n", flush=True)

    def section(self, title, text, table):
        print(f"## {title}\n\n{text}\n\n{table}", flush=True)

    def disturbed(self):
        """Least share of its core that a one-thread contestant had, and whose it was."""
        groups = [*self.data.get("updates", []), *filter(None, [self.data.get("simulator")])]
        return min(
            ((entry["processor_s"] / entry["seconds"], contestant["name"])
             for group in groups for contestant in group["contestants"] if contestant["threads"] == 1
             for entry in contestant["rounds"]),
            default=(1.0, ""),
        )


def at_least(kind, least):
    def parse(text):
        with contextlib.suppress(ValueError):
            if (value := kind(text)) >= least:
                return value
        raise argparse.ArgumentTypeError(f"{text!r} is no number from {least} up")

    return parse


def list_of(parse):
    return lambda text: [parse(part) for part in text.split(",")]


def group(text):
    if text not in GROUPS:
        raise argparse.ArgumentTypeError(f"no group {text!r}; there are {', '.join(GROUPS)}")
    return text


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f"""\
to install the peers (PyTorch without CUDA suffices and is smaller):
  python3 -m venv bench && bench/bin/pip install --index-url https://download.pytorch.org/whl/cpu torch==2.15.0
  bench/bin/pip install -r {REQUIREMENTS}

examples:
  bench/bin/python benchmarks/compare.py --json figures.json                 # everything
  bench/bin/python benchmarks/compare.py --groups updates --hidden 100 --threads 1 --rounds 3
  bench/bin/python benchmarks/compare.py --groups simulator --mjcf biped.xml

The machine should have nothing else to do; a warning at the end says when it had. Progress goes to standard error.
Exit codes: 0 done, 1 failed, 2 bad arguments, 130 interrupted.""")
    parser.add_argument("--groups", type=list_of(group), default=list(GROUPS), metavar="LIST",
                        help=f"what to measure, of {', '.join(GROUPS)} [default: all]")
    parser.add_argument("--hidden", type=list_of(at_least(int, 1)), default=[64, 100, 128, 256], metavar="LIST",
                        help="units of each of the two hidden layers [default: 64,100,128,256]")
    parser.add_argument("--threads", type=list_of(at_least(int, 1)), default=[1, 2], metavar="LIST",
                        help="threads of an update, each with a core of its own; the first is the one "
                             "others are compared with [default: 1,2]")
    parser.add_argument("--rounds", type=at_least(int, 1), default=5, help="rounds of each group [default: 5]")
    parser.add_argument("--seconds", type=at_least(float, 0.01), default=2.0,
                        help="time for each contestant in a round [default: 2]")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all single figures, machine and versions here")
    parser.add_argument("--mjcf", type=Path, metavar="FILE",
                        help="body for MuJoCo [default: built and exported by `gaitshift export mjcf`]")
    parser.add_argument("--update-rate", metavar="PROGRAM",
                        help="our learner, instead of building the example update_rate of gaitshift-sac")
    parser.add_argument("--step-rate", metavar="PROGRAM",
                        help="our simulator, instead of building the example step_rate of gaitshift-task")
    arguments = parser.parse_args()
    if arguments.mjcf is not None and not arguments.mjcf.is_file():
        parser.error(f"--mjcf {arguments.mjcf}: no such file")
    if arguments.json is not None and not arguments.json.resolve().parent.is_dir():
        parser.error(f"--json {arguments.json}: its folder does not exist")
    return arguments


def main():
    arguments = parse_arguments()
    report = Report(arguments)
    measures = {"updates": measure_updates, "simulator": measure_simulator, "memory": measure_memory}
    for group in arguments.groups:
        measures[group](arguments, report)
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(report.data, indent=1) + "\n")
    share, name = report.disturbed()
    if share < QUIET_SHARE:
        progress(f"warning: {name} had its core for only {100 * share:.0f} % of one of its rounds; something else ran")


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        sys.exit(f"error: {failure}")
    except KeyboardInterrupt:
        sys.exit(130)
