"""docs/importers.md: the code of each tested recipe runs as it stands and prints the lines below it."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from clients import paths
from requirements import where_demanded

PAGE = paths.ROOT / "docs" / "importers.md"
#: The package of each tested tool.
PACKAGES = {"fmpy": "fmpy", "ecos": "ecospy", "libcosim": "libcosimpy"}


def sections():
    """The text below each heading, by heading."""
    parts = re.split(r"^## (.*)$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def blocks(text):
    """The fenced blocks of a text: (what stands behind the fence, content)."""
    return re.findall(r"^```(.*?)\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)


@pytest.fixture
def folder(tmp_path):
    """What the page assumes: a folder with dist/ and examples/systems/."""
    (tmp_path / "dist").symlink_to(paths.dist().resolve(), target_is_directory=True)
    shutil.copytree(paths.EXAMPLES / "systems", tmp_path / "examples" / "systems")
    return tmp_path


def run(kind, code, folder, program):
    """The standard output of one block."""
    path = os.pathsep.join([str(Path(program).resolve().parent), os.environ["PATH"]])
    command = [sys.executable, "-c", code] if kind == "python" else ["sh", "-e", "-c", code]
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, f"{code}\n{done.stderr[-2000:]}"
    return done.stdout


@pytest.mark.parametrize("tool", [pytest.param(tool, marks=where_demanded(package)) for tool, package in PACKAGES.items()])
def test_the_recipe_prints_what_the_page_says(tool, folder, program):
    found = blocks(sections()[tool])
    printed, compared = "", 0
    for kind, content in found:
        if kind in ("python", "sh"):
            printed = run(kind, content, folder, program)
            continue
        assert kind == "text", f"{tool}: a block of the kind {kind!r} is not run"
        (expected,) = content.splitlines()
        assert expected in printed.splitlines(), f"{expected}: {printed[-500:]}"
        compared += 1
    assert compared == sum(kind == "python" for kind, _ in found) >= 1


def test_all_tools_agree():
    """The single case has one result on the whole page."""
    text = PAGE.read_text(encoding="utf-8")
    results = [content for kind, content in blocks(text) if kind == "text" and "current" in content]
    assert len(results) >= 1 + len(PACKAGES) and len(set(results)) == 1


def test_every_tool_is_run_or_marked():
    found = sections()
    assert {name for name in found if "(not tested)" not in name} == set(PACKAGES)
    for name, text in found.items():
        if "(not tested)" in name:
            assert not [kind for kind, _ in blocks(text) if kind in ("python", "sh")], f"{name}: mark its code `not-run`"
            assert "https://" in text, f"{name}: the source of its steps is missing"


def test_the_versions_are_those_of_the_tests():
    text = PAGE.read_text(encoding="utf-8")
    for line in (Path(__file__).parent / "requirements.txt").read_text().splitlines():
        pin = line.partition(";")[0].strip()
        if pin.partition("==")[0] in (*PACKAGES.values(), "tbb"):
            assert pin in text, f"docs/importers.md does not have {pin}"
