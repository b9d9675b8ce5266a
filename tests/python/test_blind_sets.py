"""Two sets of the blind suite, drawn, run and judged: a listed effect with structure error, and a wrong unit."""

import subprocess

import pytest
from blind import draw, judge, make, run
from blind.files import write_set

SEED = 41
SETS = {
    (4, draw.LISTED): "a contact drop in a motor with three further thermal effects",
    (2, draw.MISTAKE): "the voltage's sign",
}


@pytest.mark.parametrize(("number", "kind"), SETS)
def test_a_set_is_right(number, kind, program, tmp_path):
    s = make.made(SEED, number)
    assert s.kind == kind
    write_set(s, tmp_path)
    done = run.ask(tmp_path, program, "", 120.0)
    assert done["exit_code"] in (0, 1), subprocess.list2cmdline([str(tmp_path)])
    one = run.judged(tmp_path)
    assert one.outcome == judge.RIGHT, one.sentence
