"""Contract: experiments/full_runs/recorded.py keeps, of a page's claims about an experiment or beside it, one value for
each seed, and refuses pages on which one of them was not measured; of its seeds the motions and the training; what is
recorded of others stays. Runs of an experiment with another learner are kept beside it under a name of their own.
"""

import json

import pytest
from conftest import experiment_script


def claim(text, experiment, seeds, verdict="holds"):
    return {"claim": text, "own": {"experiment": experiment, "seeds": seeds, "verdict": verdict}, "beside": []}


def page(*claims):
    return {"experiments": [{"name": "paper", "seeds": [3, 5]}, {"name": "journal", "seeds": [1]}], "claims": list(claims)}


@pytest.fixture
def script():
    return experiment_script("full_runs/recorded.py")


def test_values_are_kept_by_claim(script):
    both = page(claim("walks", "paper", [1.0, None]), claim("is fast", "journal", [3.0]))
    assert script.claims(both, "paper", "some runs") == {
        "name": "paper",
        "runs": "some runs",
        "seeds": [3, 5],
        "claims": {"walks": [1.0, None]},
    }


def test_a_method_that_no_claim_is_about_is_kept_as_it_stands_beside_them(script):
    of_fast = {"experiment": "fast", "seeds": [2.0], "verdict": "differs"}
    unmeasured = {"experiment": "fast", "seeds": [], "verdict": "not_measured"}
    one = claim("walks", "paper", [1.0, 1.0]) | {"beside": [of_fast]}
    other = claim("falls", "paper, without phase I", [], "not_measured") | {"beside": [unmeasured]}
    whole = page(one, other)
    whole["experiments"].append({"name": "fast", "seeds": [7]})
    assert script.claims(whole, "fast", "")["claims"] == {"walks": [2.0]}


def test_what_was_not_measured_is_refused(script):
    with pytest.raises(SystemExit, match="not measured: runs"):
        script.claims(page(claim("walks", "paper", [1.0, 1.0]), claim("runs", "paper", [], "not_measured")), "paper", "")
    with pytest.raises(SystemExit, match="no claim is about journal"):
        script.claims(page(claim("walks", "paper", [1.0, 1.0])), "journal", "")
    with pytest.raises(SystemExit, match="no run of fast"):
        script.claims(page(claim("walks", "paper", [1.0, 1.0])), "fast", "")


def test_motions_and_training_are_kept_beside_those_of_others(script, tmp_path, monkeypatch):
    motion = dict.fromkeys(script.OF_A_MOTION) | {"omega_v": 0.5, "gait": "walking", "froude": 0.123456, "steps": 7}
    part = {"from_step": 0.0, "to_step": 100000.0, "mean_return": 12.34567, "falls": 0.0}
    studies = [{"group": "paper", "seed": 3, "steady": [motion], "course": [part]}]
    studies.append({"group": "journal", "seed": 1, "steady": [motion], "course": []})
    report = tmp_path / "report.json"
    report.write_text(json.dumps(page(claim("walks", "paper", [1.0, None])) | {"studies": studies}))
    (tmp_path / "training.csv").write_text(
        "experiment,seed,from_step,to_step,mean_return,falls\njournal,1,0,1,2,3\npaper,3,0,1,2,3\n"
    )
    monkeypatch.setattr(
        "sys.argv", ["recorded.py", str(report), "--experiment", "paper", "--runs", "some", "--into", str(tmp_path)]
    )
    for _ in range(2):
        script.main()
        assert [one["name"] for one in json.loads((tmp_path / "claims.json").read_text())] == ["paper"]
        assert (tmp_path / "motions.csv").read_text().splitlines()[1:] == ["paper,3,0.5,walking,0.1235,,,,,"]
        assert (tmp_path / "training.csv").read_text().splitlines()[1:] == ["journal,1,0,1,2,3", "paper,3,0,1e+05,12.35,0"]


def test_runs_with_another_learner_stand_beside_those_of_the_experiment(script, tmp_path, monkeypatch, capsys):
    motion = dict.fromkeys(script.OF_A_MOTION) | {"omega_v": 0.5, "gait": "walking"}
    studies = [{"group": "paper", "seed": 3, "steady": [motion], "course": []}]
    report = tmp_path / "report.json"
    report.write_text(json.dumps(page(claim("walks", "paper", [1.0, None])) | {"studies": studies}))
    always = ["recorded.py", str(report), "--experiment", "paper", "--runs", "some", "--into", str(tmp_path)]
    for more in [["--learner", "fast"], ["--learner", "plain", "--as", "paper, plain"]]:
        monkeypatch.setattr("sys.argv", always + more)
        script.main()
    kept = json.loads((tmp_path / "claims.json").read_text())
    assert [(one["name"], one["learner"], one.get("repeats")) for one in kept] == [
        ("paper", "fast", None),
        ("paper, plain", "plain", "paper"),
    ]
    assert [row.split(",0.5")[0] for row in (tmp_path / "motions.csv").read_text().splitlines()[1:]] == [
        "paper,3",
        '"paper, plain",3',
    ]
    monkeypatch.setattr("sys.argv", [*always, "--as", "paper, plain"])
    with pytest.raises(SystemExit):
        script.main()
    assert "--learner" in capsys.readouterr().err
