"""Runs the program on each set: `python -m blind.run SETS --program motor-fmu [--jobs J]`, in `tests/python`.

Each set gets a folder `result` with the output of the program, without the FMUs, and `run.json`: exit code, wall
seconds, seconds of CPU (user and system), memory, and hashes
of program and set. A result of the same program and set is kept.
"""

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from .judge import FINE, judge

TIME_LIMIT = 600.0  # s for one set
BUDGET = 45.0  # s of wall time, the default of the program
LIBRARIES = (".so", ".dll", ".dylib")


def digest(*files: Path) -> str:
    return hashlib.sha256(b"".join(hashlib.sha256(f.read_bytes()).digest() for f in files)).hexdigest()


def digest_of_program(program: Path) -> str:
    """With the libraries beside it, which influence the result."""
    return digest(program, *sorted(f for f in program.parent.iterdir() if f.suffix in LIBRARIES))


def digest_of_set(folder: Path) -> str:
    return digest(*(f for f in sorted(folder.iterdir()) if f.is_file()))


def in_order(folder: Path) -> list:
    """The sets of a folder, by number."""
    sets = [path.parent for path in folder.glob("*/truth.json")]
    return sorted(sets, key=lambda s: (s.name.rpartition("-")[0], int(s.name.rpartition("-")[2])))


def read_json(file: Path):
    """None if the file is missing or incomplete."""
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def measured(command: list, errors: Path, limit: float):
    """Exit code, wall seconds, seconds of CPU (user and system) and the largest memory in MB, as far as the system
    knows them.
    """
    begin = time.monotonic()
    with errors.open("wb") as stderr:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr)
        watch = threading.Timer(limit, process.kill)
        watch.start()
        memory = cpu = None
        if hasattr(os, "wait4"):
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            memory = usage.ru_maxrss / (1024.0**2 if sys.platform == "darwin" else 1024.0)
            cpu = usage.ru_utime + usage.ru_stime
        else:
            process.wait()
        watch.cancel()
    return process.returncode, time.monotonic() - begin, cpu, memory


def ask(
    folder: Path, program: Path, program_digest: str, limit: float = TIME_LIMIT, budget: float | None = None
) -> dict:
    """The content of the set's `run.json`."""
    result, file = folder / "result", folder / "result" / "run.json"
    whose = {"program": program_digest, "set": digest_of_set(folder)}
    before = read_json(file)
    if before and before.items() >= whose.items():
        return before
    shutil.rmtree(result, ignore_errors=True)
    result.mkdir()
    command = [str(program), "close-loop", str(folder / "experiment.toml"), "--out", str(result)]
    command += ["--budget", f"{budget:g}"] if budget else []
    code, seconds, cpu, memory = measured(command, result / "stderr.txt", limit)
    # A hundred sets with their FMUs would fill a disk.
    for fmu in result.rglob("*.fmu"):
        fmu.unlink()
    whose |= {"exit_code": code, "seconds": round(seconds, 3)}
    run = whose | {
        "budget": budget or BUDGET,
        "cpu_seconds": cpu and round(cpu, 3),
        "memory_MB": memory and round(memory, 1),
    }
    file.write_text(json.dumps(run) + "\n", encoding="utf-8")
    return run


def report_of(folder: Path):
    """The report, or None if the program could not run."""
    run = read_json(folder / "result" / "run.json")
    return read_json(folder / "result" / "report.json") if run and run["exit_code"] in (0, 1) else None


def judged(folder: Path):
    """The report of a set compared with its truth. A report that violates the contract counts as none."""
    truth, run = read_json(folder / "truth.json"), read_json(folder / "result" / "run.json")
    try:
        return judge(truth, report_of(folder), run | {"error": why(folder)})
    except (AttributeError, KeyError, TypeError, ValueError) as breach:
        broken = judge(truth, None, run | {"exit_code": 0, "error": ""})
        broken.said = f"a report that breaks the contract ({type(breach).__name__}: {breach})"
        return broken


def why(folder: Path) -> str:
    """One sentence about a set without a report, without the folder of this machine."""
    run = read_json(folder / "result" / "run.json")
    lines = (folder / "result" / "stderr.txt").read_text(encoding="utf-8", errors="replace").split("\n")
    said = [line.strip() for line in lines if line.strip()]
    last = f": {said[-1]}".replace(f"{folder.resolve().parent}/", "") if said else ""
    return f"exit code {run['exit_code']} after {run['seconds']:.0f} s" + last


def main(arguments=None):
    parser = argparse.ArgumentParser(
        prog="python -m blind.run", description="Asks the program about each set of a folder."
    )
    parser.add_argument("sets", type=Path)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--count", type=int, help="the first sets only")
    parser.add_argument("--jobs", type=int, default=1, help="programs at a time")
    parser.add_argument(
        "--budget",
        type=float,
        help="wall time that the program is given for a set, s; for a machine that others use too",
    )
    options = parser.parse_args(arguments)
    program = options.program.resolve()
    if not program.is_file():
        sys.exit(f"{program} is not there")
    whose = digest_of_program(program)
    sets = in_order(options.sets)[: options.count]
    with ThreadPoolExecutor(options.jobs) as pool:
        waiting = {pool.submit(ask, folder, program, whose, TIME_LIMIT, options.budget): folder for folder in sets}
        for count, done in enumerate(as_completed(waiting), 1):
            folder, run = waiting[done], done.result()
            one = judged(folder)
            text = f"[{count}/{len(sets)}] {folder.name}: {run['seconds']:.1f} s"
            if report_of(folder) is None:
                print(f"{text}: no report: {why(folder)}", flush=True)
            else:
                print(text if one.outcome in FINE else f"{text}: {one.sentence.partition(': ')[2]}", flush=True)


if __name__ == "__main__":
    main()
