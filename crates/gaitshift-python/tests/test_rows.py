"""Contract: experiments/recipe/rows.py takes whatever a sweep's folder holds, as its documentation says, and gives the seeds of
a row in their order, 10 after 2."""

import sys

from conftest import experiment_script


def test_a_sweeps_folder_is_taken_as_it_is(tmp_path, monkeypatch, capsys):
    rows = experiment_script("recipe/rows.py")
    (tmp_path / "table.json").write_text("[]")
    for seed in (10, 2):
        run = tmp_path / "3 friction" / f"seed-{seed}"
        run.mkdir(parents=True)
        (run / "evaluations.jsonl").write_text("")
    (tmp_path / "3 friction" / "seed-11").mkdir()
    monkeypatch.setattr(rows, "of_run", lambda run: [run.name])
    monkeypatch.setattr(sys, "argv", ["rows.py", *map(str, sorted(tmp_path.iterdir()))])
    rows.main()
    assert capsys.readouterr().out.splitlines()[2:] == ["| 3 friction | seed-2, seed-10 |"]
