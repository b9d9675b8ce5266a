"""Closing the loop over an experiment: `motor-fmu close-loop`, and its report in a few numbers."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

from clients.program import motor_fmu

# Time budget of a search, s: the search ends before it also on a busy machine, so that the results do not depend on its load.
BUDGET_S = 300


def close_loop(experiment: Path) -> dict:
    """The report on an experiment."""
    with TemporaryDirectory() as folder:
        return json.loads(motor_fmu("close-loop", str(experiment), "--out", folder, "--budget", str(BUDGET_S), "--json"))


def summary(report: dict) -> dict:
    """Verdict, errors before and after, parameters with what is known of them, and which the data hardly separates."""
    return {
        "verdict": report["verdict"],
        "effects": [effect["id"] for effect in report["effects"]],
        "error": {role: {name: _of_physics(error) for name, error in of_role.items()} for role, of_role in report["error"].items()},
        "parameters": {
            name: {"prior": p["prior"], "value": p["value"], "ci95": p["ci95"]} for name, p in report["parameters"].items()
        },
        "hardly_separated": report["correlated"],
        "fmu_agrees": report["replay"]["agrees"],
        "notes": [note for note in report["notes"] if "clock" in note],
    }


def _of_physics(error: dict) -> dict:
    """An error without that of the black box, which is another model and none of the result."""
    return {stage: value for stage, value in error.items() if stage != "blackbox"}
