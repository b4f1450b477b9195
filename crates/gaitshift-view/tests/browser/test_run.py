"""Contract: the page of a training run shows its learning curve and evaluations while files grow, and a chosen evaluation's
controller comes onto the stage."""

import json
import shutil
import subprocess

import pytest
from conftest import REPOSITORY, until

SHIPPED = next((REPOSITORY / "crates").glob("*/controllers/biped.safetensors"))


@pytest.fixture
def run(program, tmp_path):
    """The beginning of a real run, with an evaluation of the shipped controller put into it."""
    folder = tmp_path / "run"
    subprocess.run([program, "train", "fast", "--steps", "2000", "--out", folder], check=True, capture_output=True)
    judged = subprocess.run([program, "evaluate", "--criteria", "--json"], capture_output=True, check=True).stdout
    (folder / "controllers").mkdir(exist_ok=True)
    shutil.copy(SHIPPED, folder / "controllers" / "step-0000250000.safetensors")
    judgement = json.loads(judged)
    met = sum(check["met"] for check in judgement["checks"])
    evaluation = {**judgement, "step": 250_000, "elapsed_s": 60.0, "met": met, "score": float(met)}
    (folder / "evaluations.jsonl").write_text(json.dumps(evaluation) + "\n")
    return folder


def test_a_run_shows_its_curves_and_an_evaluation_comes_onto_the_stage(view, tab, run):
    page = tab(view(run))
    until(page, "run.data && run.data.curve.length > 10")
    until(page, "document.getElementById('evaluation').options.length === 2")
    evaluation = page.evaluate("run.data.evaluations[0]")
    assert evaluation["criteria"] > 30 and evaluation["walking"] and evaluation["running"]
    # It was stopped at 2000 steps, and has a report.
    assert (run / "report.json").exists() and page.evaluate("run.data.finished") is False
    # A click on the point of the evaluation.
    x, y = page.evaluate("[run.plot.across(250000), run.plot.up(run.data.evaluations[0].met)]")
    page.locator("#criteria").click(position={"x": x, "y": y})
    until(page, "document.getElementById('who').textContent === 'step 250000'")
    until(page, "document.getElementById('gait').dataset.gait === 'walking'")
    # The files grow while the page looks on; a damaged line does not harm it.
    text = (run / "evaluations.jsonl").read_text()
    with (run / "evaluations.jsonl").open("a") as file:
        file.write("{\n" + text.replace('"step": 250000', '"step": 500000'))
    until(page, "run.data.evaluations.length === 2")
    assert page.evaluate("run.data.evaluations[1].controller") is False


def test_a_reward_term_of_ones_own_has_its_curve_on_the_live_page(view, tab, program, tmp_path):
    folder, term = tmp_path / "own", 'task.reward.extra=[{name="height", weight=2.0, expression="z_m"}]'
    training = [program, "train", "fast", "--steps", "2000", "--set", term, "--out", folder]
    subprocess.run(training, check=True, capture_output=True)
    page = tab(view("--controller", folder / "controller-last.safetensors"))
    # Kept at once, and early: an untrained controller falls within 0.2 s, and the stage begins anew.
    columns = "({ height: [...bipeds[0].track.column.reward_height], z: [...bipeds[0].track.column.z] })"
    until(page, f"bipeds.length && bipeds[0].track.column.z.length > 5 && (window.kept = {columns})")
    kept = page.evaluate("window.kept")
    assert len(kept["height"]) > 5 and all(0.5 < height < 3 for height in kept["height"][1:])
    # The other columns are where they were.
    assert all(0.3 < z < 1.5 for z in kept["z"])


def test_what_is_no_run_is_refused(program, tmp_path):
    result = subprocess.run([program, "view", tmp_path], capture_output=True, text=True)
    assert result.returncode == 2
    assert "config.toml" in result.stderr
