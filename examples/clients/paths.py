"""Where things are: the measured gait, and the archives that `motor-fmu build` wrote."""

import os
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parent.parent
ROOT = EXAMPLES.parent
DATA = ROOT / "fmu-src" / "physics" / "data"
EXPECTED = EXAMPLES / "expected"


def dist() -> Path:
    """The folder of built archives: MOTOR_FMU_DIST if that is set, else dist/ of the repository."""
    return Path(os.environ.get("MOTOR_FMU_DIST") or ROOT / "dist")


def archive(model: str, fmi: int, preset: str | None = None) -> Path:
    """The built archive of a model, with the start values of a preset if one is named; an error says what to run if it is missing."""
    folder = dist() / "presets" / preset if preset else dist()
    path = folder / f"fmi{fmi}" / f"{model}.fmu"
    if not path.is_file():
        build = f"motor-fmu build {model} --preset {preset}" if preset else "motor-fmu build"
        raise FileNotFoundError(f"{path} does not exist; run `cargo xtask demo` or `{build} --out {folder}` first")
    return path
