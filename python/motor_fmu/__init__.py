"""Calls the program `motor-fmu`; the functions return dictionaries, DataFrames or paths. Values are in SI units.

The wheel contains the program, the FMU library beside it and the archives of all models; nothing else has to be installed.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import pandas as pd

__all__ = ["MotorFmuError", "archive", "build", "close_loop", "presets", "program", "run", "simulate", "steady", "sweep"]

_HERE = Path(__file__).resolve().parent
Value = float | int | bool | str


class MotorFmuError(RuntimeError):
    """The program could not do what was asked; the text is its sentence. `code` is its exit code."""

    def __init__(self, sentence: str, code: int):
        super().__init__(sentence)
        self.code = code


def program() -> Path:
    """The path of the program in this package."""
    return _HERE / "bin" / ("motor-fmu.exe" if os.name == "nt" else "motor-fmu")


def archive(model: str, fmi: int = 2) -> Path:
    """The packed FMU of a model with its default start values, for FMI `fmi` (2 or 3)."""
    path = _HERE / "archives" / f"fmi{fmi}" / f"{model}.fmu"
    if not path.is_file():
        known = ", ".join(sorted(p.stem for p in (_HERE / "archives" / "fmi2").glob("*.fmu")))
        raise MotorFmuError(f"there is no archive of {model} for FMI {fmi}; models: {known}; FMI: 2, 3", 2)
    return path


def run(*arguments: object, answers: Iterable[int] = (0,)) -> str:
    """Runs the program and returns its standard output.

    Notes of the program go to standard error. An exit code that is not in `answers` is a :class:`MotorFmuError`.
    """
    done = subprocess.run([program(), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in answers:
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise MotorFmuError((lines[-1] if lines else "no message").removeprefix("error: "), done.returncode)
    print(done.stderr, end="", file=sys.stderr)
    return done.stdout


def presets() -> pd.DataFrame:
    """The built-in presets: name, model, description."""
    return pd.DataFrame(json.loads(run("presets", "--json")))


def build(
    *models: str,
    preset: str | os.PathLike | None = None,
    fmi: int | str = "both",
    effects: str | os.PathLike | None = None,
    out: str | os.PathLike = "dist",
) -> list[Path]:
    """Builds the FMUs of the models (all if none is named) into `out/fmi2` and `out/fmi3`, validates them and returns their paths."""
    output = run("build", *models, "--fmi", fmi, "--out", out, *_options(preset=preset, effects=effects))
    written = (Path(line.split(".fmu:")[0] + ".fmu") for line in output.splitlines() if ".fmu:" in line)
    return [path for path in written if path.is_file()]


def steady(
    model: str = "AnnulusCooledMotor",
    *,
    preset: str | os.PathLike | None = None,
    settings: Mapping[str, Value] | None = None,
    load: str | os.PathLike | None = None,
    hours: float | None = None,
) -> dict:
    """Thermal steady state and continuous torque; with `load`, a gait as periodic load."""
    options = _options(model=model, preset=preset, load=load, hours=hours)
    return json.loads(run("steady", "--json", *options, *_settings(settings)))


def sweep(
    vary: Mapping[str, tuple[float | str, float | str, int]],
    *,
    model: str = "AnnulusCooledMotor",
    objective: str | None = None,
    preset: str | os.PathLike | None = None,
    settings: Mapping[str, Value] | None = None,
    load: str | os.PathLike | None = None,
    hours: float | None = None,
) -> pd.DataFrame:
    """The points of a grid: `vary` maps a variable to its first value, last value and number of values.

    A value may be text with a unit (`"3000 rpm"`); the results are in SI units.

    The result as the program prints it (best point, units, notes) is in `.attrs`.
    """
    ranges = [part for name, (first, last, n) in vary.items() for part in ("--vary", f"{name}={first}:{last}:{n}")]
    options = _options(model=model, objective=objective, preset=preset, load=load, hours=hours)
    with tempfile.TemporaryDirectory() as folder:
        points = Path(folder) / "points.csv"
        found = run("sweep", "--json", *ranges, *options, *_settings(settings), "--output", points)
        frame = pd.read_csv(points)
    frame.attrs.update(json.loads(found))
    return frame


def simulate(
    fmu: str | os.PathLike,
    *,
    stop: float | None = None,
    step: float | None = None,
    settings: Mapping[str, Value] | None = None,
    inputs: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Simulates an FMU; `inputs` has a column `time` and one column for each input. The index of the result is the time in s."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "result.csv"
        signals = Path(folder) / "inputs.csv" if inputs is not None else None
        if signals is not None:
            inputs.to_csv(signals, index=False, float_format="%.17g")
        options = _options(stop=stop, step=step, input=signals)
        run("simulate", fmu, *options, *_settings(settings), "--output", result)
        return pd.read_csv(result, index_col="time")


def close_loop(experiment: str | os.PathLike, *, out: str | os.PathLike) -> dict:
    """Compares a model with bench data and adds what it lacks; the report as a dictionary, figures and FMUs in `out`.

    A verdict that ends the program with exit code 1 is a result and no error.
    """
    return json.loads(run("close-loop", experiment, "--out", out, "--json", answers=(0, 1)))


def main() -> int:
    """The command `motor-fmu`."""
    return subprocess.run([program(), *sys.argv[1:]]).returncode


def _options(**options: object) -> list[str]:
    return [part for name, value in options.items() if value is not None for part in (f"--{name}", str(value))]


def _settings(settings: Mapping[str, Value] | None) -> list[str]:
    def text(value: Value) -> str:
        return str(value).lower() if isinstance(value, bool) else str(value)

    return [part for name, value in (settings or {}).items() for part in ("--set", f"{name}={text(value)}")]
