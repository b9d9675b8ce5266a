"""Each numbered example runs as a user runs it. Its numbers are compared with independent results (`example_truths.py`) and with
the stored output of an earlier run, within the tolerances of `stored.py`."""

import json
import os
import subprocess
import sys

import pytest
from clients.paths import EXAMPLES, EXPECTED
from example_truths import TRUTHS
from stored import same, same_page

SCRIPTS = sorted(EXAMPLES.glob("[0-9]*.py"))
# Outputs that are not the numbers of the run but files beside them.
ARGUMENTS = {
    "02_walking": lambda folder: ("--out", str(folder)),
    "03_what_cooling_buys": lambda folder: ("--out", str(folder)),
    "04_close_the_loop_bench": lambda folder: ("--out", str(folder)),
    "07_refit_against_repair": lambda folder: ("--out", str(folder)),
    "08_walking_study": lambda folder: ("--out", str(folder)),
    "12_coupling_error": lambda folder: ("--out", str(folder)),
    "13_operating_range": lambda folder: ("--out", str(folder)),
    "14_runs_that_disagree": lambda folder: ("--out", str(folder)),
}
FILES = {
    "02_walking": ("walking.json", "walking.svg", "walking.png"),
    "03_what_cooling_buys": ("what-cooling-buys.md",),
    "04_close_the_loop_bench": ("close-the-loop-bench.md", "fan/report.json", "fan/report.html", "still-air/preset.toml"),
    "07_refit_against_repair": ("refit-against-repair.md", "refit-against-repair.svg"),
    "08_walking_study": ("walking-study.md", "walking-study.svg"),
    "12_coupling_error": ("coupling-error.svg",),
    "13_operating_range": ("operating-range.md", "operating-range.svg"),
    "14_runs_that_disagree": ("bench-splits.md",),
}
# Pages of the documentation that an example writes.
PAGES = (
    "what-cooling-buys.md",
    "walking-study.md",
    "close-the-loop-bench.md",
    "refit-against-repair.md",
    "refit-against-repair.svg",
    "operating-range.md",
    "bench-splits.md",
)


def test_every_example_has_its_expected_output():
    assert [script.stem for script in SCRIPTS] == sorted(file.stem for file in EXPECTED.glob("*.json"))


# The walking study and the five splits take minutes; `test_walking_study.py` tests the sentences of the former every day. MuJoCo and Dask
# serve one example each. What 02, 03, 05, 07 and 12 add to `test_actuator.py`, `test_reproduce.py`, `test_close_loop.py` and
# `test_cosim_system.py` are their stored numbers, for ten seconds to half a minute each.
NIGHTLY = (
    "02_walking",
    "03_what_cooling_buys",
    "05_thesis",
    "07_refit_against_repair",
    "08_walking_study",
    "10_mujoco_leg",
    "11_dask_sweep",
    "12_coupling_error",
    "14_runs_that_disagree",
)


def _marked(script):
    return pytest.param(script, id=script.stem, marks=pytest.mark.nightly if script.stem in NIGHTLY else ())


@pytest.mark.parametrize("script", map(_marked, SCRIPTS))
def test_example(script, tmp_path):
    arguments = ARGUMENTS.get(script.stem, lambda _: ())(tmp_path)
    done = subprocess.run(
        [sys.executable, str(script), *arguments], capture_output=True, text=True, timeout=900, env=os.environ, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    for truth in TRUTHS.get(script.stem, ()):
        truth(found)
    same(found, json.loads((EXPECTED / f"{script.stem}.json").read_text()))
    for name in FILES.get(script.stem, ()):
        assert (tmp_path / name).stat().st_size > 0
        if name in PAGES:
            same_page((tmp_path / name).read_text(), (EXAMPLES.parent / "docs" / name).read_text(), f"docs/{name}")
