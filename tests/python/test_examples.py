"""Each numbered example runs as a user runs it, and gives what it gave when its output was stored."""

import json
import os
import subprocess
import sys

import pytest
from clients.paths import EXAMPLES, EXPECTED

RELATIVE = 1e-6
# Differences of large numbers, given in percent: rounding shows in them first.
ABSOLUTE = 1e-6
SCRIPTS = sorted(EXAMPLES.glob("[0-9]*.py"))
# Outputs that are not the numbers of the run but files beside them.
ARGUMENTS = {
    "02_walking": lambda folder: ("--out", str(folder)),
    "03_what_cooling_buys": lambda folder: ("--out", str(folder)),
    "04_close_the_loop_bench": lambda folder: ("--out", str(folder)),
    "07_refit_against_repair": lambda folder: ("--out", str(folder)),
    "08_walking_study": lambda folder: ("--out", str(folder)),
    "12_coupling_error": lambda folder: ("--out", str(folder)),
}
FILES = {
    "02_walking": ("walking.json", "walking.svg", "walking.png"),
    "03_what_cooling_buys": ("what-cooling-buys.md",),
    "04_close_the_loop_bench": ("close-the-loop-bench.md", "fan/report.json", "fan/report.html", "still-air/preset.toml"),
    "07_refit_against_repair": ("refit-against-repair.md", "refit-against-repair.svg"),
    "08_walking_study": ("walking-study.md", "walking-study.svg"),
    "12_coupling_error": ("coupling-error.svg",),
}
# Pages of the documentation that an example writes.
PAGES = ("what-cooling-buys.md", "walking-study.md", "close-the-loop-bench.md", "refit-against-repair.md", "refit-against-repair.svg")


def test_every_example_has_its_expected_output():
    assert [script.stem for script in SCRIPTS] == sorted(file.stem for file in EXPECTED.glob("*.json"))


# Their packages, MuJoCo and Dask, serve one example each.
NIGHTLY = ("10_mujoco_leg", "11_dask_sweep")


def _marked(script):
    return pytest.param(script, id=script.stem, marks=pytest.mark.nightly if script.stem in NIGHTLY else ())


@pytest.mark.parametrize("script", map(_marked, SCRIPTS))
def test_example(script, tmp_path):
    arguments = ARGUMENTS.get(script.stem, lambda _: ())(tmp_path)
    done = subprocess.run(
        [sys.executable, str(script), *arguments], capture_output=True, text=True, timeout=900, env=os.environ, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    expected = json.loads((EXPECTED / f"{script.stem}.json").read_text())
    same(json.loads(done.stdout), expected, script.stem)
    for name in FILES.get(script.stem, ()):
        assert (tmp_path / name).stat().st_size > 0
        if name in PAGES:
            assert (tmp_path / name).read_text() == (EXAMPLES.parent / "docs" / name).read_text(), f"docs/{name} is stale"


def same(found, expected, where):
    """Equal up to the tolerance, whatever the nesting."""
    assert type(found) is type(expected), f"{where}: {found!r} where {expected!r} was expected"
    if isinstance(expected, dict):
        assert list(found) == list(expected), where
        for key in expected:
            same(found[key], expected[key], f"{where}: {key}")
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, rel=RELATIVE, abs=ABSOLUTE), where
    else:
        assert found == expected, where
