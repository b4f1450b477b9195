"""Contract: experiments/full_runs/claims.py keeps, of a page's claims about an experiment, one value for each seed, and refuses
pages on which one of them was not measured."""

import pytest
from conftest import experiment_script


def claim(text, experiment, seeds, verdict="holds"):
    return {"claim": text, "own": {"experiment": experiment, "seeds": seeds, "verdict": verdict}, "beside": []}


def page(*claims):
    return {"experiments": [{"name": "paper", "seeds": [3, 5]}, {"name": "journal", "seeds": [1]}], "claims": list(claims)}


@pytest.fixture
def recorded():
    return experiment_script("full_runs/claims.py").recorded


def test_values_are_kept_by_claim(recorded):
    both = page(claim("walks", "paper", [1.0, None]), claim("is fast", "journal", [3.0]))
    assert recorded(both, "paper", "some runs") == {
        "name": "paper",
        "runs": "some runs",
        "seeds": [3, 5],
        "claims": {"walks": [1.0, None]},
    }


def test_what_was_not_measured_is_refused(recorded):
    with pytest.raises(SystemExit, match="not measured: runs"):
        recorded(page(claim("walks", "paper", [1.0, 1.0]), claim("runs", "paper", [], "not_measured")), "paper", "")
    with pytest.raises(SystemExit, match="no claim is about journal"):
        recorded(page(claim("walks", "paper", [1.0, 1.0])), "journal", "")
