"""Two sets of the blind suite, drawn, run and judged: no effect at all, and a wrong sign."""

import pytest
from blind import draw, judge, make, run
from blind.files import write_set

SEED = 41
SETS = {
    (11, draw.NULL): "another motor with noise, drift and no effect",
    (2, draw.MISTAKE): "the sign of the voltage",
}


@pytest.mark.parametrize(("number", "kind"), SETS)
def test_a_set_is_right(number, kind, program, tmp_path):
    s = make.made(SEED, number)
    assert s.kind == kind
    write_set(s, tmp_path)
    run.ask(tmp_path, program, "", 120.0)
    one = run.judged(tmp_path)
    assert one.outcome == judge.RIGHT, f"{one.sentence}: {SETS[number, kind]}"
