"""FMUs that behave as those of other exporters do: `motor-fmu` answers as the standards demand.

`corpus/expected.toml` has the answers, by hand from the text of the standards. `NOT_YET` lists where the program still answers otherwise
and in which respects; a test that finds fewer or more of them fails, so that a repair is noticed and taken out of the list.
"""

import contextlib
import fnmatch
import json
import os
import re
import resource
import signal
import subprocess
import time
from pathlib import Path

import corpus
import fmpy
import pytest
from corpus import describe, exports
from requirements import where_demanded
from validator import checkers

try:
    import tomllib
except ImportError:
    import tomli as tomllib  # below Python 3.11 pytest brings it

COMMANDS = ("validate", "simulate", "cosim")
#: Seconds after which a run counts as one that does not return.
PATIENCE = 10
#: The same for an FMU with many variables.
LONG_PATIENCE = 60
#: Factor on the processor time for ten times the variables, at most: between a time that is proportional (10) and a quadratic one (100).
GROWTH = 10**1.5

# Checks (patterns of their names), finding, and the respects in which the answer is wrong.
NOT_YET = {
}

CASES = tomllib.loads((corpus.FOLDER / "expected.toml").read_text(encoding="utf-8"))["case"]


def name(case):
    """A case in one word."""
    further = [case.get("encoding"), *case.get("only", ()), case.get("count")]
    return "-".join([case["fmu"], *(str(part) for part in further if part)])


def expectation(case, command):
    """What is expected of one command, or None."""
    said = case.get(command)
    return case["simulate"] if said == {"alike": True} else said


def checks():
    for case in CASES:
        marks = [pytest.mark.nightly] if case.get("nightly") else []
        if case["fmu"] in exports.EXPORTERS:
            marks.append(where_demanded(case["fmu"]))
        for fmi in case["standards"]:
            for command in COMMANDS:
                if expectation(case, command):
                    yield pytest.param(case, fmi, command, id=f"{name(case)} fmi{fmi} {command}", marks=marks)


CHECKS = list(checks())


def build(case, fmi, folder):
    if case["fmu"] in exports.EXPORTERS:
        return exports.build(case["fmu"], folder)
    options = {key: case[key] for key in ("encoding", "only", "count") if key in case}
    return corpus.build(case["fmu"], fmi, folder / f"{case['fmu'].replace(':', '-')}.fmu", **options)


def command_line(case, command, fmu, folder):
    """The arguments of the program. A system has the FMU as its only component, or several times."""
    expected = expectation(case, command)
    arguments = expected.get("arguments", [])
    if command == "cosim":
        stop = getattr(describe.MODELS.get(case["fmu"].partition(":")[0]), "stop", 1)
        system = folder / f"system-{fmu.stem}.toml"
        text = f'[system]\nname = "alone"\n[experiment]\nstop = {stop}\nstep = 0.01\n'
        names = ["it", *(f"further{k}" for k in range(1, expected.get("components", 1)))]
        system.write_text(text + "".join(f'[[component]]\nname = "{name}"\nfmu = "{fmu.name}"\n' for name in names))
        return ["cosim", system, "--json", *(f"it.{a}" if "=" in a else a for a in arguments)]
    return [command, fmu, "--json", *arguments]


def processor_time():
    """Seconds of all processes that have been waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Run:
    """A finished run, or one that was ended because it did not return; `left` are the temporary files that remain."""

    def __init__(self, program, arguments, folder, environment=None, patience=PATIENCE):
        temporary = folder / "temporary"
        temporary.mkdir()
        # A shell stands between, so that an FMU that signals the parent of its process ends no test.
        command = ["sh", "-c", '"$@"; exit $?', "sh", program, *map(str, arguments)]
        environment = {**os.environ, **(environment or {}), "TMPDIR": str(temporary)}
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        before = processor_time()
        process = subprocess.Popen(command, cwd=folder, env=environment, start_new_session=True, **streams)
        try:
            self.out, self.err = process.communicate(timeout=patience)
            self.exit = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            self.out, self.err = process.communicate()
            self.exit = "did not return"
        finally:
            # What an FMU's process leaves running.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        self.cpu = processor_time() - before
        self.left = sorted(path.name for path in temporary.iterdir())


def judge(expected, command, run, fmu):
    """What is wrong with an answer: by respect, what was found."""
    validated = command == "validate"
    wrong = {}

    def demand(holds, respect, found):
        if not holds:
            wrong.setdefault(respect, []).append(found)

    errors = expected.get("errors", ["any"] if expected.get("breach") else [])
    allowed = expected.get("exit", [int(bool(errors))] if validated else [0])
    demand(run.exit in allowed, "exit", f"{run.exit}: {run.err[:300]}")
    if "exit" in wrong and not (validated and run.exit in (0, 1)):
        return wrong
    demand(not run.left, "left behind", run.left)
    if run.exit == 2:
        lines = [line for line in run.err.splitlines() if line.strip()]
        one = len(lines) == 1 and lines[0].startswith("error: ") and Path(fmu).stem in lines[0]
        demand(one and not run.out, "sentence", (run.err[:300], run.out[:300]))
        demand(re.search(expected.get("refusal", ""), run.err), "refusal", run.err[:300])
    else:
        try:
            answer = json.loads(run.out)
        except ValueError:
            return wrong | {"output": run.out[:300]}
        if validated:
            findings(expected, answer[0]["findings"], errors, demand)
        else:
            final_values(expected, answer["final"], "it." if command == "cosim" else "", demand)
    if not validated:
        for pattern in expected.get("says", ()):
            demand(re.search(pattern, run.err), "says", run.err[:300])
    return wrong


def findings(expected, found, errors, demand):
    codes = {finding["code"] for finding in found}
    broken = {finding["code"] for finding in found if finding["severity"] == "error"}
    texts = [f"{finding['code']}: {finding['message']}" for finding in found]
    if errors == ["any"]:
        demand(broken, "errors", texts)
    elif "exit" not in expected:
        # An entry may name alternatives.
        demand({next((e for e in errors if code in e.split("|")), code) for code in broken} == set(errors), "errors", texts)
    demand(codes >= set(expected.get("finds", ())), "finds", texts)
    demand(not codes & set(expected.get("without", ())), "without", texts)
    for pattern in expected.get("says", ()):
        demand(any(re.search(pattern, text) for text in texts), "says", texts)
    if "unsaid" in expected:
        demand(not any(re.search(expected["unsaid"], text) for text in texts), "unsaid", texts)


def final_values(expected, found, prefix, demand):
    for variable, value in expected.get("final", {}).items():
        got = found.get(prefix + variable)
        if isinstance(value, float):
            close = isinstance(got, (int, float)) and abs(got - value) <= expected.get("tolerance", 0.0)
        else:
            close = str(got) == str(value)
        demand(close, "final", f"{variable}: {got}, expected {value}")


def not_yet(check):
    """The respects in which the program is known to be wrong."""
    return {respect for pattern, (_, respects) in NOT_YET.items() if fnmatch.fnmatchcase(check, pattern) for respect in respects}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """The FMUs, each built once."""
    made = {}

    def get(case, fmi):
        key = name(case), fmi
        if key not in made:
            made[key] = build(case, fmi, tmp_path_factory.mktemp("fmu"))
        return made[key]

    return get


@pytest.mark.parametrize(("case", "fmi", "command"), CHECKS)
def test_the_answer_is_that_of_the_standard(case, fmi, command, program, fmus, tmp_path, request):
    fmu = fmus(case, fmi)
    expected = expectation(case, command)
    environment = {}
    if case["fmu"] in exports.EXPORTERS and command != "validate":
        environment = exports.with_python()
        expected = expected if environment else {"exit": [2]}
    run = Run(program, command_line(case, command, fmu, fmu.parent), tmp_path, environment, LONG_PATIENCE if "count" in case else PATIENCE)
    wrong = judge(expected, command, run, fmu)
    if "count" in case:
        # The machine and its load are the same for both.
        fewer = fmus(case | {"count": case["count"] // 10}, fmi)
        (tmp_path / "fewer").mkdir()
        base = Run(program, command_line(case, command, fewer, fewer.parent), tmp_path / "fewer", environment)
        if run.cpu > GROWTH * base.cpu:
            wrong["time"] = f"{run.cpu:.1f} s, with a tenth of the variables {base.cpu:.1f} s"
    known = not_yet(request.node.callspec.id)
    assert set(wrong) == known, f"wrong: {wrong}; NOT_YET has {known or 'nothing'}. {case['basis']}"


@pytest.mark.parametrize("signal_name", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("command", COMMANDS)
def test_an_interrupt_leaves_nothing_behind(command, signal_name, program, fmus, tmp_path):
    """While an FMU does not return, the program is interrupted: it ends soon, its temporary folder and its processes are gone."""
    case = {"fmu": "lag:hang", command: {}}
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    arguments = command_line(case, command, fmus(case, 2), fmus(case, 2).parent)
    environment = {**os.environ, "TMPDIR": str(temporary)}
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    # A test run in the background ignores SIGINT, which its children would inherit.
    def heed():
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    command = [program, *map(str, arguments)]
    process = subprocess.Popen(command, env=environment, start_new_session=True, preexec_fn=heed, **silent)
    try:
        until(lambda: any(temporary.iterdir()))
        time.sleep(1.0)  # until the step that does not return
        process.send_signal(getattr(signal, signal_name))
        assert until(lambda: process.poll() is not None), "the program does not end"
        gone = until(lambda: not any(temporary.iterdir()) and not group_alive(process.pid), 2)
        wrong = set() if gone else {"left behind"}
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    assert wrong == not_yet(f"interrupt {command} {signal_name}")


def until(done, seconds=PATIENCE):
    """Waits for a condition; whether it came true."""
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def group_alive(group):
    """Whether a process group has members."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_not_yet_lists_checks_that_exist():
    names = [check.id for check in CHECKS]
    names += [f"interrupt {command} {name}" for command in COMMANDS for name in ("SIGINT", "SIGTERM")]
    assert all(fnmatch.filter(names, pattern) for pattern in NOT_YET)


def test_each_answer_has_a_basis():
    assert all(len(case["basis"]) > 5 for case in CASES)
    # (a) to (k) of the corpus, and the two exporters.
    assert len({case["fmu"] for case in CASES}) >= 22


@pytest.mark.parametrize(("model", "fmi"), [(name, fmi) for name, model in describe.MODELS.items() for fmi in model.standards])
def test_other_checkers_find_nothing_in_the_models(model, fmi, tmp_path):
    fmu = corpus.build(model, fmi, tmp_path / f"{model}.fmu")
    assert not checkers.fmpy(fmu) and not checkers.fmutool(fmu)


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("model", ["lag", "ball", "stair"])
def test_fmpy_gets_the_closed_forms(model, fmi, interface, fmus):
    """The FMUs themselves are right: fmpy steps them, or integrates them with CVODE, to the expected values."""
    case = next(case for case in CASES if name(case) == ("lag:print" if model == "lag" else model))
    stop = 1.1 if model == "stair" else float(describe.MODELS[model].stop)
    fmu = fmus({**case, "fmu": model}, fmi)
    options = {"fmi_type": interface, "stop_time": stop, "output_interval": stop / 200, "relative_tolerance": 1e-8}
    last = fmpy.simulate_fmu(str(fmu), **options)[-1]
    assert last["time"] == pytest.approx(stop)
    for variable, value in case["simulate"]["final"].items():
        assert last[variable] == pytest.approx(value, abs=1e-5), variable


def test_integers_of_64_bits_pass_connections_exactly(motor_fmu, tmp_path):
    """-9007199254740993 is no double. Here it passes two connections, the second one with direct feedthrough."""
    corpus.build("types", 3, tmp_path / "types.fmu")
    system = '[system]\nname = "whole"\nconnect = ["a.low_out -> b.in", "b.through -> c.in"]\n'
    system += "".join(f'[[component]]\nname = "{component}"\nfmu = "types.fmu"\n' for component in "abc")
    (tmp_path / "s.toml").write_text(system)
    for algorithm in ("jacobi", "gauss-seidel"):
        run = motor_fmu("cosim", "s.toml", "--algorithm", algorithm, "--json")
        assert run.returncode == 0, run.stderr
        final = json.loads(run.stdout)["final"]
        assert [final[f"{component}.through"] for component in "abc"] == [0, -9007199254740993, -9007199254740993]
