"""The runs of the examples from the publications contain the numbers of `motor-fmu reproduce` and nothing else."""

import pytest
from clients.paths import EXAMPLES
from clients.seeds import paper_runs, thesis_cases, thesis_runs

try:
    import tomllib
except ModuleNotFoundError:
    import tomli as tomllib  # below Python 3.11 pytest brings it

FOLDERS = {"05_thesis": thesis_runs, "06_paper": paper_runs}


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_stored_runs_are_those_of_the_seeds(folder):
    files = FOLDERS[folder]()
    stored = {file.name: file.read_text() for file in (EXAMPLES / folder).glob("*.csv")}
    assert stored == files
    experiment = tomllib.loads((EXAMPLES / folder / "EXPERIMENT.toml").read_text())
    assert sorted(run["file"] for run in experiment["run"]) == sorted(files)


def test_each_run_of_the_thesis_is_set_as_it_was():
    runs = tomllib.loads((EXAMPLES / "05_thesis" / "EXPERIMENT.toml").read_text())["run"]
    sets = {run["file"]: run["set"] for run in runs}
    for case in thesis_cases():
        expected = {"cooling_mode": case["cooling_mode"]} | dict([case["setting"]] if case["setting"] else [])
        assert sets[f"{case['name']}.csv"] == expected, case["name"]
