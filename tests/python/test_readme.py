"""README.md: the commands of its first result print the lines below them; its caption has the numbers of the stored example."""

import json
import os
import re
import subprocess
from pathlib import Path

import pytest
from clients.paths import EXPECTED

README = Path(__file__).resolve().parents[2] / "README.md"
# The README shows rounded numbers; a model of other numbers differs by more.
RELATIVE = 2e-3
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def blocks(heading):
    """The fenced blocks below a heading: (language, text)."""
    section = README.read_text(encoding="utf-8").split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return re.findall(r"```(\w+)\n(.*?)```", section, flags=re.DOTALL)


def words_and_numbers(line):
    """The line without its numbers and with single spaces, and the numbers."""
    return " ".join(NUMBER.sub("#", line).split()), [float(n) for n in NUMBER.findall(line)]


def test_the_first_result_is_what_its_commands_print(program, tmp_path):
    found = blocks("First result")
    # The first block builds the program, which a test finds built.
    assert [language for language, _ in found] == ["sh", "sh", "text"] and "cargo build" in found[0][1]
    environment = {**os.environ, "PATH": f"{Path(program).resolve().parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        ["sh", "-e"], input=found[1][1], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    printed = [words_and_numbers(line) for line in (done.stderr + done.stdout).splitlines()]
    expected = [words_and_numbers(line) for line in found[2][1].splitlines()]
    assert len(expected) >= 5
    for words, numbers in expected:
        same = [got for line, got in printed if line == words]
        close = [got for got in same if got == pytest.approx(numbers, rel=RELATIVE)]
        assert close, f"README.md shows {words!r} with {numbers}; the commands print {same or 'no such line'}"
    assert (tmp_path / "run.svg").stat().st_size > 1000


@pytest.mark.parametrize(("cooling", "run"), [("Without fan", "still air"), ("With fan", "fan at full speed")])
def test_the_caption_has_the_numbers_of_the_walking_example(cooling, run):
    temperature, minutes = re.search(rf"{cooling}: (\d+) °C after ([\d.]+)\s+min", README.read_text(encoding="utf-8")).groups()
    stored = json.loads((EXPECTED / "02_walking.json").read_text())[run]
    assert float(temperature) == pytest.approx(stored["winding_temperature_end_degC"], abs=0.51)
    assert float(minutes) == pytest.approx(stored["minutes_walked"], abs=0.051)
