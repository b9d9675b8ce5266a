"""Seeded faults in archives of this project and in a foreign FMU: `motor-fmu validate` finds each, and nothing in archives without a fault.

The foreign FMU is an oscillator that is compiled from its own C source (`validator/`). docs/validator.md has the answers of two other
checkers; every night a test compares the page with their answers.
"""

import os

import pytest
from clients import paths
from validator import checkers, faults, table

BASES = [*faults.OURS.values(), *faults.FOREIGN.values()]


WORKERS = min(4, os.cpu_count() or 2)


@pytest.fixture(scope="module")
def answers(program, tmp_path_factory):
    """The exit code and the findings of `motor-fmu validate` for each fault."""
    return table.judge_all(program, paths.dist(), tmp_path_factory.mktemp("faults"), WORKERS, others=())


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    """The archives without a fault."""
    out = tmp_path_factory.mktemp("clean")
    files = table.bases(paths.dist(), out)
    return {name: files[name].write(out / f"{name.replace(' ', '-')}.fmu") for name in BASES}


@pytest.mark.parametrize("base", BASES)
def test_without_a_fault_nothing_is_found(program, clean, base):
    assert checkers.ours(program, clean[base]) == (0, [])
    assert not any(other(clean[base]) for other in table.OTHERS)


@pytest.mark.parametrize("number", range(len(faults.ALL)), ids=[f"{fault.code}: {fault.what}" for fault in faults.ALL])
def test_the_fault_is_found(answers, number):
    code, findings = answers[number]
    found = [finding for finding in findings if finding["code"] == faults.ALL[number].code]
    assert found, f"found {[(finding['code'], finding['message']) for finding in findings]}"
    assert code == any(finding["severity"] == "error" for finding in findings)
    assert all(finding["where"] and finding["message"].endswith(".") for finding in findings)


def test_there_are_as_many_faults_as_promised():
    assert len(faults.ALL) >= 60
    assert len({(fault.code, fault.what) for fault in faults.ALL}) == len(faults.ALL)


@pytest.mark.nightly
def test_the_page_has_the_table(program, tmp_path):
    command = "cd tests/python && python -m validator.table PROGRAM DIST"
    answers = table.judge_all(program, paths.dist(), tmp_path, WORKERS)
    assert table.on_page() == table.text(answers), f"docs/validator.md is out of date; `{command}` updates it"
