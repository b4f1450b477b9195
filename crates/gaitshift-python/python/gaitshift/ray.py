"""A sweep on a Ray cluster: the file of ``gaitshift sweep``, the same results to the bit.

    python -m gaitshift.ray sweep.toml                        # on this machine
    python -m gaitshift.ray sweep.toml --address auto         # on the cluster that this machine belongs to

A trial is a training run; its folder with the last checkpoint goes to Ray's storage whenever a checkpoint is written. A trial
whose worker dies goes on from there, and so does a sweep whose driver was stopped or died: run the same command again.
At the end every trial's folder is where ``gaitshift sweep`` would have put it, with the same table.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import socket
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gaitshift import _native

_TRIALS = "ray-trials.json"


def train_trial(config: Mapping[str, Any]) -> None:
    """What a worker does: it trains or continues a run, and reports its folder whenever it has a new checkpoint."""
    from ray import tune

    trial = config["trial"]
    if trial["version"] != _native.__version__:
        raise RuntimeError(
            f"this worker has gaitshift {_native.__version__}, the sweep was begun with {trial['version']}; "
            "install the same version on every node"
        )
    # Ray gives every trial a working folder of its own; what an earlier try left there may be behind the checkpoint.
    run = Path("run")
    shutil.rmtree(run, ignore_errors=True)
    reported: int | None = None
    checkpoint = tune.get_checkpoint()
    if checkpoint is not None:
        with checkpoint.as_directory() as folder:
            shutil.copytree(folder, run)

    def report(step: int, met: int | None, finished: bool = False) -> None:
        nonlocal reported
        state = (run / "checkpoint" / "state.json").stat().st_mtime_ns
        if state != reported or finished:
            reported = state
            metrics = {"step": step, "met": met, "finished": finished}
            tune.report(metrics, checkpoint=tune.Checkpoint.from_directory(str(run)))

    met: int | None = None

    def watch(what: str, value: Any, evaluation: Mapping[str, Any] | None) -> None:
        nonlocal met
        if evaluation is not None and evaluation["best"]:
            met = evaluation["met"]
        if what != "note":
            report(value["step"], met)

    _native.train_trial(trial["config"], trial["command"], trial["settings"], str(run), watch)
    end = json.loads((run / "report.json").read_text(encoding="utf-8"))
    report(end["step"], end["best_met"], finished=True)


def sweep(
    file: str | os.PathLike[str],
    *,
    address: str | None = None,
    out: str | os.PathLike[str] | None = None,
    storage: str | None = None,
    retries: int = 3,
) -> Path:
    """Runs or continues a sweep; returns its folder.

    Args:
        file: the sweep, as of ``gaitshift sweep``.
        address: of a cluster; without it one is started on this machine.
        out: folder of the trials and the table, ``runs/NAME`` without it.
        storage: where Ray keeps checkpoints: a folder that all nodes see, or a URI such as ``s3://...``; ``OUT-ray``
            without it.
        retries: how often a trial may go on after a failure; -1 for ever.

    Raises:
        ValueError: a mistake in the file, or a folder that holds another sweep.
        ConnectionError: no cluster at the address.
        RuntimeError: trials that failed for good.
    """
    try:
        import ray
        from ray import tune
    except ImportError as error:
        remedy = "pip install 'crates/gaitshift-python[ray]' in a clone of gaitshift"
        raise ImportError(f"this needs Ray: {remedy} ({error})") from None

    told = _native.sweep_trials(os.fspath(file))
    folder = Path("runs", told["folder"]) if out is None else Path(out)
    trials = [{**trial, "command": told["command"], "version": _native.__version__} for trial in told["trials"]]
    _begin(folder, trials)
    where = storage if storage is not None and "://" in storage else os.path.abspath(storage or f"{folder}-ray")
    started = not ray.is_initialized()
    if started:
        _reach(address)
        try:
            ray.init(address=address, include_dashboard=False, log_to_driver=False)
        except ConnectionError as error:
            raise ConnectionError(f"no Ray cluster at {address}: {error}") from None
    try:
        return _run(ray, tune, file, folder, told["folder"], trials, where, retries)
    finally:
        if started:
            ray.shutdown()


def _reach(address: str | None) -> None:
    """Ray tries for minutes to reach a cluster that is not there; this says so at once."""
    host, colon, port = (address or "").removeprefix("ray://").rpartition(":")
    if not colon:
        return
    try:
        with socket.create_connection((host.strip("[]"), int(port)), timeout=10.0):
            pass
    except (OSError, ValueError, OverflowError) as error:
        raise ConnectionError(
            f"no Ray cluster at {address}: {error}; `ray status` on its head node gives the address"
        ) from None


def _begin(folder: Path, trials: list[dict[str, Any]]) -> None:
    """Remembers what the sweep runs; a folder that remembers something else is refused."""
    kept = folder / _TRIALS
    if kept.exists():
        if json.loads(kept.read_text(encoding="utf-8")) != trials:
            raise ValueError(
                f"{folder} holds a sweep of other settings or another version than asked for now; give another --out"
            )
        return
    for trial in trials:
        run = folder / trial["folder"]
        if (run / "config.toml").exists():
            raise ValueError(f"{run} holds a run of another sweep, which would be replaced; give another --out")
    folder.mkdir(parents=True, exist_ok=True)
    new = kept.with_suffix(".new")
    new.write_text(json.dumps(trials), encoding="utf-8")
    new.replace(kept)


def _run(
    ray: Any,
    tune: Any,
    file: str | os.PathLike[str],
    folder: Path,
    name: str,
    trials: list[dict[str, Any]],
    storage: str,
    retries: int,
) -> Path:
    threads = max(trial["threads"] for trial in trials)
    trainable = tune.with_resources(train_trial, {"cpu": threads})
    experiment = f"{storage.rstrip('/')}/{name}"
    if tune.Tuner.can_restore(experiment):
        print(f"going on with the sweep in {experiment}", file=sys.stderr)
        tuner = tune.Tuner.restore(experiment, trainable, resume_unfinished=True, resume_errored=True)
    else:
        tuner = tune.Tuner(
            trainable,
            param_space={"trial": tune.grid_search(trials)},
            tune_config=tune.TuneConfig(
                metric="step",
                mode="max",
                trial_name_creator=lambda trial: trial.config["trial"]["folder"].replace("/", "_"),
                trial_dirname_creator=lambda trial: trial.config["trial"]["folder"].replace("/", "_"),
            ),
            run_config=tune.RunConfig(
                name=name,
                storage_path=storage,
                failure_config=tune.FailureConfig(max_failures=retries),
                checkpoint_config=tune.CheckpointConfig(num_to_keep=1),
                verbose=1,
            ),
        )
    results = tuner.fit()
    failed = []
    for result in results:
        trial = result.config["trial"]
        if result.error is not None or result.checkpoint is None:
            failed.append(f"{trial['folder']}: {result.error or 'it did not begin'}")
            continue
        _bring(result.checkpoint, folder / trial["folder"])
    if failed:
        raise RuntimeError(
            f"{len(failed)} of {len(trials)} trials failed; the same command tries them again. The first: {failed[0]}"
        )
    markdown, table = _native.sweep_table(os.fspath(file), os.fspath(folder))
    (folder / "table.md").write_text(markdown, encoding="utf-8")
    (folder / "table.json").write_text(table + "\n", encoding="utf-8")
    return folder


def _bring(checkpoint: Any, run: Path) -> None:
    """Copies a trial's folder from Ray's storage, whole or not at all."""
    new = run.with_name(run.name + ".new")
    shutil.rmtree(new, ignore_errors=True)
    new.parent.mkdir(parents=True, exist_ok=True)
    with checkpoint.as_directory() as folder:
        shutil.copytree(folder, new)
    shutil.rmtree(run, ignore_errors=True)
    new.rename(run)


def main() -> int:
    """The command line."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        prog="python -m gaitshift.ray", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", metavar="FILE.toml", help="the sweep")
    parser.add_argument("--address", help="address of a Ray cluster, or auto [default: Ray on this machine]")
    parser.add_argument("--out", metavar="DIR", help="folder of the runs and the table [default: runs/NAME]")
    parser.add_argument("--storage", metavar="DIR|URI", help="where Ray keeps checkpoints [default: OUT-ray]")
    parser.add_argument(
        "--retries", type=int, default=3, metavar="N", help="goes of a trial after failures, -1 for ever [default: 3]"
    )
    arguments = vars(parser.parse_args())
    file = arguments.pop("file")
    try:
        folder = sweep(file, **arguments)
    except (ValueError, ImportError, ConnectionError, RuntimeError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2 if isinstance(error, (ValueError, ImportError, ConnectionError)) else 1
    print((folder / "table.md").read_text(encoding="utf-8"))
    print(f"wrote {folder}; its figure: gaitshift sweep {file} --out {folder} --table", file=sys.stderr)
    return 0


if __name__ == "__main__":
    # By its name, so that workers import it and no copy of it is sent.
    from gaitshift.ray import main as run_main

    sys.exit(run_main())
