"""The program `motor-fmu`: found, run, its answer returned."""

import os
import shutil
import subprocess


def motor_fmu(*arguments: str, answers: tuple[int, ...] = (0,)) -> str:
    """Runs `motor-fmu` (MOTOR_FMU_BIN, else the one on the path) and gives what it prints; an exit code that is no answer as an
    exception."""
    program = os.environ.get("MOTOR_FMU_BIN") or shutil.which("motor-fmu")
    if not program:
        raise FileNotFoundError("motor-fmu is not on the path; run `cargo build --release` and set MOTOR_FMU_BIN to it")
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    if done.returncode not in answers:
        raise RuntimeError(done.stderr.strip() or f"motor-fmu {arguments[0]} gave exit code {done.returncode}")
    return done.stdout
